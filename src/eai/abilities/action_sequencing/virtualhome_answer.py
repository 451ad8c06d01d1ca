"""How protocol `strict` reads a VirtualHome plan.

An answer maps actions to argument lists, in order and with repeated keys: ``{"WALK": ["sofa", "352"], ...}``.
Lists of such objects, an object around them, fences, prose and single quotes are accepted; every repair is
named.
"""

from __future__ import annotations

import json
import re

from eai.abilities.action_sequencing.plan import TOO_LONG, Unreadable, WrittenPlan, WrittenStep
from eai.abilities.json_text import MAX_LENGTH, Pairs, find_json

_STEP = re.compile(r"""["'](\w+)["']\s*:\s*(\[[^\[\]{}]*\])""")


def read_plan(text: str) -> WrittenPlan | Unreadable:
    """The steps of an answer: from the last JSON value that is a plan, else from all pairs in the text."""
    if len(text) > MAX_LENGTH:
        return TOO_LONG
    found = find_json(text, _steps)
    if found is not None:
        steps, repairs = found
        return WrittenPlan(steps, repairs)
    return _scan(text)


def _steps(value: object) -> tuple[WrittenStep, ...] | None:
    """The steps of a JSON value that is a plan of at least one step, or None."""
    if isinstance(value, list):
        parts = [_steps(item) for item in value]
        if not parts or any(part is None for part in parts):
            return None
        return tuple(step for part in parts if part is not None for step in part)
    if not isinstance(value, Pairs) or not value.members:
        return None
    wrapped = _steps(value.members[0][1]) if len(value.members) == 1 else None
    if wrapped is not None:
        return wrapped
    if not all(isinstance(arguments, list) for _, arguments in value.members):
        return None
    return tuple(
        WrittenStep(action, tuple(arguments))
        for action, arguments in value.members
        if isinstance(arguments, list)
    )


def _scan(text: str) -> WrittenPlan | Unreadable:
    """All ``"ACTION": [...]`` pairs of a text that is not JSON, say because it is cut off."""
    steps: list[WrittenStep] = []
    for match in _STEP.finditer(text):
        action, written = match.groups()
        try:
            arguments = json.loads(written.replace("'", '"'))
        except ValueError:
            return Unreadable(f"the list of step {len(steps) + 1} ({action}) is not JSON")
        steps.append(WrittenStep(action, tuple(arguments)))
    if not steps:
        return Unreadable("no step was found")
    return WrittenPlan(tuple(steps), ("broken_json",))
