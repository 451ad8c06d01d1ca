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
    written = _STEP.findall(re.sub(r"\s+", " ", text))
    if not written:
        return Unreadable("no step was found")
    try:
        # A line break cannot stand in a JSON string, so no list runs on into the next.
        lists = json.loads("[" + ",\n".join([arguments for _, arguments in written]) + "]")
    except (ValueError, RecursionError):
        return Unreadable("the list of a step is not JSON", times_counted=2)
    return WrittenPlan(
        tuple(WrittenStep(name, tuple(args)) for (name, _), args in zip(written, lists, strict=True))
    )
