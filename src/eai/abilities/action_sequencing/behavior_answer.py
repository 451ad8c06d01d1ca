"""How protocol `strict` reads a BEHAVIOR plan.

An answer is a list of steps, each with an action and its object: ``[{"action": "OPEN", "object": "jar_0"}]``.
Two objects are separated by a comma or stand in a list. Fences, prose, single quotes and the comments that
the prompt's own example has are accepted; every repair is named.
"""

from __future__ import annotations

import re
from dataclasses import replace

from eai.abilities.action_sequencing.plan import Unreadable, WrittenPlan, WrittenStep
from eai.abilities.json_text import Pairs, find_json

_COMMENT = re.compile(r"(?<=[\[\]{},\s])#[^\n]*")


def read_plan(text: str) -> WrittenPlan | Unreadable:
    """The steps of an answer: from the last JSON value that is a plan."""
    found = find_json(text, _steps)
    if found is not None:
        return WrittenPlan(*found)
    without = _COMMENT.sub("", text)
    found = find_json(without, _steps) if without != text else None
    if found is None:
        return Unreadable("no list of steps with an action and an object was found")
    plan = WrittenPlan(*found)
    return replace(plan, repairs=(*plan.repairs, "comments"))


def _steps(value: object) -> tuple[WrittenStep, ...] | None:
    """The steps of a JSON value that is a plan of at least one step, or None."""
    if isinstance(value, Pairs) and len(value.members) == 1:
        return _steps(value.members[0][1])
    if not isinstance(value, list):
        return None
    steps = [_step(item) for item in value]
    if not steps or any(step is None for step in steps):
        return None
    return tuple(step for step in steps if step is not None)


def _step(value: object) -> WrittenStep | None:
    members = dict(value.members) if isinstance(value, Pairs) else {}
    action, objects = members.get("action"), members.get("object")
    if not isinstance(action, str):
        return None
    if isinstance(objects, str):
        return WrittenStep(action, tuple(objects.split(",")))
    return WrittenStep(action, tuple(map(str, objects))) if isinstance(objects, list) else None
