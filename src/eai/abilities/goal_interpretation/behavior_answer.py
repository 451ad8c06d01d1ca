"""How protocol `strict` reads the goals of a BEHAVIOR task.

An answer is an object, anywhere in the text, whose members are lists of conditions; an object around it does
not matter. Capitals do not matter;
``toggledon`` is another spelling of ``toggled_on``; what is said twice is said once.
"""

from __future__ import annotations

from eai.abilities.goal_interpretation.behavior_conditions import SYMMETRIC, Unreadable, Value, Written
from eai.abilities.json_text import Pairs, find_json


def read_conditions(text: str) -> Written | Unreadable:
    """The conditions in an answer, each once, or why there are none."""
    found = find_json(text, _conditions)
    if found is None:
        return Unreadable("there is no JSON object of lists of conditions")
    conditions, repairs = found
    return Written(tuple(dict.fromkeys(map(canonical, conditions))), repairs)


def canonical(condition: Value) -> Value:
    """The condition as all spellings of it come out; symmetric relations have their objects in order."""
    if isinstance(condition, str):
        return condition.strip().lower().replace("toggledon", "toggled_on")
    if not isinstance(condition, tuple):
        return str(condition)
    parts = tuple(map(canonical, condition))
    if len(parts) == 3 and parts[0] in SYMMETRIC:
        return (parts[0], *sorted(parts[1:], key=str))
    return parts


def _conditions(value: object) -> list[Value] | None:
    """All conditions of an object whose members are lists or null, or of the one member that is one."""
    if not isinstance(value, Pairs):
        return None
    if len(value.members) == 1 and isinstance(value.members[0][1], Pairs):
        return _conditions(value.members[0][1])
    sections = [[] if section is None else section for _, section in value.members]
    if not all(isinstance(section, list) for section in sections):
        return None
    return [_frozen(each) for section in sections if isinstance(section, list) for each in section]


def _frozen(value: object) -> Value:
    return tuple(map(_frozen, value)) if isinstance(value, list) else value
