"""How eai-eval 1.0.5 reads a VirtualHome plan (spec section b; reference: ``load_json_preserving_order``).

Its quirks: a step whose list is empty (``"STANDUP": []``) vanishes; text around the steps is ignored; only a
fence at the very start is removed; a list that is not JSON counts twice as a parsing error.
"""

from __future__ import annotations

import json
import re

from eai.abilities.action_sequencing.plan import TOO_LONG, Unreadable, WrittenPlan, WrittenStep
from eai.abilities.json_text import MAX_LENGTH

_STEP = re.compile(r'"(\w+)"\s*:\s*(\[[^\]]+\])')
_FENCE = "```json"
_LIST_END = "]"


def read_plan(text: str) -> WrittenPlan | Unreadable:
    """The steps that the reference finds in an answer, in order."""
    if len(text) > MAX_LENGTH:
        return TOO_LONG
    text = text[: text.rfind(_LIST_END) + 1]  # no step ends later, and none is looked for in vain
    text = text.removeprefix(_FENCE).strip().replace("\n", "").replace("'", '"')
    steps: list[WrittenStep] = []
    for match in _STEP.finditer(re.sub(r"\s+", " ", text)):
        action, arguments = match.groups()
        try:
            steps.append(WrittenStep(action, tuple(json.loads(arguments))))
        except (ValueError, RecursionError):
            reason = f"the list of step {len(steps) + 1} ({action}) is not JSON"
            return Unreadable(reason, times_counted=2)
    if not steps:
        return Unreadable("no step was found")
    return WrittenPlan(tuple(steps))
