"""How eai-eval 1.0.5 reads the goals of a VirtualHome task (spec sections b and f).

Its quirks: JSON is not looked for in prose, and only a fence at the very start is removed; every apostrophe
becomes a quotation mark; entries are duplicates only if all their fields agree, so that an action with two
descriptions is predicted twice; much that is not of the expected type aborts the whole run, which is told
here as `Unreadable.aborts`.
"""

from __future__ import annotations

import json
from typing import Any

from eai.abilities.goal_interpretation.written import (
    FIELDS,
    SECTIONS,
    Entry,
    Unreadable,
    WrittenGoals,
    written_goals,
)
from eai.abilities.task import GoalKind

_FENCE = "```json"
_NAME_FIELDS = frozenset({"name", "from_name", "to_name"})


def read_goals(text: str) -> WrittenGoals | Unreadable:
    """The goals that the reference finds in an answer."""
    text = text.replace("<|eot_id|>", "")
    if text.startswith(_FENCE):
        text = text.removeprefix(_FENCE).strip("`")
    try:
        value = json.loads(text.strip().replace("\n", "").replace("'", '"'))
    except (ValueError, RecursionError) as error:
        return Unreadable(f"the answer is not JSON: {error}")
    if not isinstance(value, dict):
        return Unreadable("the answer is not a JSON object", aborts=True)
    try:
        return written_goals({kind: _entries(kind, value.get(SECTIONS[kind], [])) for kind in GoalKind})
    except (TypeError, AttributeError, RecursionError):
        return Unreadable("a section or an entry of it is not of the expected type", aborts=True)


def _entries(kind: GoalKind, values: Any) -> list[Entry | None]:
    """The fields of each entry, None for one that lacks some; duplicates and empty entries are left out.

    Raises:
        TypeError: the reference aborts, for a value that it cannot iterate, index, measure or look up.
    """
    unique = {_hashable(value): value for value in values}
    return [_fields(FIELDS[kind], entry) for entry in unique.values() if len(entry)]


def _fields(names: tuple[str, ...], entry: Any) -> Entry | None:
    for name in names:
        if name not in entry:
            return None
    return [_text(name, entry[name]) for name in names]


def _hashable(value: Any) -> object:
    if isinstance(value, dict):
        return frozenset([(key, _hashable(part)) for key, part in value.items()])
    return tuple([_hashable(part) for part in value]) if isinstance(value, list) else value


def _text(field: str, value: Any) -> str:
    """A field as text; what is no string becomes something that no name or state is equal to.

    Raises:
        TypeError: the reference aborts, for an action that is no string or a name that cannot be looked up.
    """
    if isinstance(value, str):
        return value
    if field == "action":
        raise TypeError("an action must be a string")
    if field in _NAME_FIELDS:
        hash(value)
    return json.dumps(value)
