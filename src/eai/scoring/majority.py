"""Self-consistency: of several answers to a task, one that says what most of them say."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Sequence

from eai.abilities.declaration import Sameness, declaration_of
from eai.abilities.json_text import Pairs, find_json
from eai.abilities.protocol import Ability


def majority(answers: Sequence[str], ability: Ability) -> int:
    """The index of the first answer that means what most readable ones mean.

    Of meanings that are equally frequent the one that was given first counts. If none can be read, the
    first answer is taken.
    """
    meanings = [meaning(text, ability) for text in answers]
    counts = Counter(each for each in meanings if each is not None)
    return meanings.index(counts.most_common(1)[0][0]) if counts else 0


def meaning(text: str, ability: Ability) -> str | None:
    """An answer without what does not matter, so that equal answers are equal texts; None if unreadable.

    What does not matter is declared by the ability (`Sameness`).
    """
    same = declaration_of(ability).asked.sameness
    found = find_json(text, lambda value: _plain(value, same))
    if found is not None:
        return found[0]
    start = -1 if same.bare is None else text.find(same.bare)
    return _spaced(text[start:]) if start >= 0 else None


def _plain(value: object, same: Sameness) -> str | None:
    """A JSON value as a text without accidents; None for what cannot be an answer."""
    return _text(value, same) if isinstance(value, Pairs | list) else None


def _text(value: object, same: Sameness) -> str:
    if isinstance(value, Pairs):
        members = [f"{json.dumps(key)}:{_text(each, same)}" for key, each in value.members]
        return "{" + ",".join(members if same.keys_in_order else sorted(members)) + "}"
    if isinstance(value, list):
        elements = [_text(each, same) for each in value]
        is_set = same.lists_are_sets and not _is_tuple(value)
        return "[" + ",".join(sorted(elements) if is_set else elements) + "]"
    return json.dumps(_spaced(value) if isinstance(value, str) else value)


def _is_tuple(values: Sequence[object]) -> bool:
    """Whether a list is one goal, such as ``["inside", "rag", "bucket"]``, and not a list of goals."""
    return all(isinstance(value, str) for value in values)


def _spaced(text: str) -> str:
    return " ".join(text.split())
