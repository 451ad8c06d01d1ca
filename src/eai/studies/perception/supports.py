"""The supports in a scene graph: what is in or on what, which never makes a circle."""

from __future__ import annotations

from eai.studies.perception.scene_graph import NamedFact


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
