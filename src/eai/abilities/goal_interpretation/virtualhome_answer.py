"""How protocol `strict` reads the goals of a VirtualHome task.

An answer is an object with at least one of the three sections, anywhere in the text. A section that is
missing or null is empty.
"""

from __future__ import annotations

from eai.abilities.goal_interpretation.written import (
    FIELDS,
    SECTIONS,
    Entry,
    Unreadable,
    WrittenGoals,
    written_goals,
)
from eai.abilities.json_text import Pairs, find_json
from eai.abilities.task import GoalKind

_NOTHING = Pairs(())


def read_goals(text: str) -> WrittenGoals | Unreadable:
    """The goals in an answer, or why there are none."""
    found = find_json(text, _sections)
    if found is None:
        keys = ", ".join(f'"{key}"' for key in SECTIONS.values())
        return Unreadable(f"there is no JSON object with {keys}")
    sections, repairs = found
    return written_goals({kind: _entries(kind, sections.get(SECTIONS[kind])) for kind in GoalKind}, repairs)


def _sections(value: object) -> dict[str, object] | None:
    """The members of an object that has one of the sections."""
    if not isinstance(value, Pairs):
        return None
    members = dict(value.members)
    return members if any(key in members for key in SECTIONS.values()) else None


def _entries(kind: GoalKind, value: object) -> list[Entry | None]:
    """The fields of each entry, None for one that is ill-formed; empty objects say nothing."""
    if value is None:
        return []
    if not isinstance(value, list):
        return [None]
    return [_fields(kind, entry) for entry in value if entry != _NOTHING]


def _fields(kind: GoalKind, entry: object) -> Entry | None:
    members = dict(entry.members) if isinstance(entry, Pairs) else {}
    fields = [members.get(name) for name in FIELDS[kind]]
    texts = [field for field in fields if isinstance(field, str)]
    return texts if len(texts) == len(fields) else None
