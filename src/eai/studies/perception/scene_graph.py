"""Scene graphs: what is perceived of a scene, over names, and how answers write it."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

from eai.abilities.json_text import Pairs, find_json

SCENE = "scene"
"""The field of a question's metadata that has the scene graph which it tells of instead of the scene."""

UNREADABLE = 'there is no object with a list of "facts"'
"""Why nothing is perceived."""


class NamedFact(NamedTuple):
    """A fact by the names that answers use."""

    predicate: str
    arguments: tuple[str, ...]

    def __str__(self) -> str:
        return f"{self.predicate}({', '.join(self.arguments)})"


@dataclass(frozen=True, slots=True)
class SceneGraph:
    """What is perceived: objects by name, and facts about them, each once and in order."""

    objects: tuple[str, ...] = ()
    facts: tuple[NamedFact, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """All names in it, each once."""
        return tuple(
            dict.fromkeys([*self.objects, *(name for fact in self.facts for name in fact.arguments)])
        )

    @property
    def text(self) -> str:
        """It as an answer writes it: ``{"objects": ["a", ...], "facts": [["inside", "a", "b"], ...]}``."""
        return json.dumps(
            {"objects": self.objects, "facts": [[f.predicate, *f.arguments] for f in self.facts]}
        )


@dataclass(frozen=True, slots=True)
class ReadGraph:
    """A scene graph as it was read.

    Attributes:
        graph: it; empty if the answer has none.
        ill_formed: the entries that are left out, as texts.
        repairs: what it took to find it in the answer.
        unreadable: why there is none; None if there is one.
    """

    graph: SceneGraph
    ill_formed: tuple[str, ...] = ()
    repairs: tuple[str, ...] = ()
    unreadable: str | None = None


def read_scene_graph(text: str, arities: Mapping[str, int]) -> ReadGraph:
    """The scene graph in an answer.

    Args:
        text: the answer.
        arities: how many objects each predicate is said of, by its name in answers.
    """
    found = find_json(text, _sections)
    if found is None:
        return ReadGraph(SceneGraph(), unreadable=UNREADABLE)
    (objects, entries), repairs = found
    names = [name for name in objects if isinstance(name, str)]
    facts: dict[NamedFact, None] = {}
    ill_formed = [str(name) for name in objects if not isinstance(name, str)]
    for entry in entries:
        fact = _fact(entry, arities)
        if fact is None:
            ill_formed.append(json.dumps(entry))
        else:
            facts[fact] = None
    return ReadGraph(SceneGraph(tuple(dict.fromkeys(names)), tuple(facts)), tuple(ill_formed), repairs)


def _sections(value: object) -> tuple[list[object], list[object]] | None:
    """The objects and facts of a JSON value that has a list of facts."""
    if not isinstance(value, Pairs):
        return None
    members = dict(value.members)
    objects, facts = members.get("objects", []), members.get("facts")
    return (objects, facts) if isinstance(objects, list) and isinstance(facts, list) else None


def _fact(entry: object, arities: Mapping[str, int]) -> NamedFact | None:
    if not isinstance(entry, list) or not entry or not all(isinstance(part, str) for part in entry):
        return None
    predicate, *arguments = entry
    return NamedFact(predicate, tuple(arguments)) if arities.get(predicate) == len(arguments) else None


def graph_of(objects: Iterable[str], facts: Iterable[NamedFact]) -> SceneGraph:
    """The scene graph of objects and facts, each once."""
    return SceneGraph(tuple(dict.fromkeys(objects)), tuple(dict.fromkeys(facts)))


class Supports:
    """What rests in or on what, while facts are added.

    Args:
        predicates: what says so, by the names that scene graphs use.
    """

    def __init__(self, predicates: frozenset[str]) -> None:
        self._predicates = predicates
        self._below: dict[str, list[str]] = {}

    def add(self, fact: NamedFact) -> None:
        """Take a fact into account, if it is of a support."""
        if fact.predicate in self._predicates:
            self._below.setdefault(fact.arguments[0], []).append(fact.arguments[1])

    def rests(self, fact: NamedFact) -> bool:
        """Whether a fact gives a support to something that has one."""
        return fact.predicate in self._predicates and fact.arguments[0] in self._below

    def closes(self, fact: NamedFact) -> bool:
        """Whether a fact would close a circle of supports."""
        if fact.predicate not in self._predicates:
            return False
        first, second = fact.arguments
        pending, seen = [second], set[str]()
        while pending:
            name = pending.pop()
            if name == first:
                return True
            if name not in seen:
                seen.add(name)
                pending += self._below.get(name, ())
        return False
