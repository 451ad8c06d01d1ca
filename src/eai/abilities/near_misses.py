"""Near misses: where a goal was not reached, what came of its objects instead."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TypeAlias

from eai.abilities.explanation import Explanation

_Fact: TypeAlias = tuple[str, ...]

SHOWN = 2
"""How many near misses of one goal are told."""


def near_misses(explanation: Explanation) -> Mapping[str, tuple[str, ...]]:
    """What the steps of an answer brought about instead of the goals that it misses: goal -> facts, as texts.

    A fact is a near miss if it became true and stayed so, and is another relation of the same objects in the
    same order, a state of the same object whose coming ended the one that is wanted, or the same relation of
    the first object to another one. What holds both ways between two objects says only that they are near
    each other, and is none.
    """
    made, ended = _made(explanation), _ended(explanation)
    found = {}
    for goal in explanation.goals:
        wanted = _parts(goal.goal)
        if not goal.satisfied and wanted is not None:
            near = sorted(
                (fact for fact in made if _is_near(wanted, fact, ended)),
                key=lambda fact: fact[1:] != wanted[1:],
            )
            if near:
                found[goal.goal] = tuple(_text(fact) for fact in near[:SHOWN])
    return found


def _made(explanation: Explanation) -> list[tuple[str, ...]]:
    """The facts that the steps made true and left so, without those that hold both ways."""
    made: dict[tuple[str, ...], None] = {}
    for step in explanation.steps:
        for fact in filter(None, map(_parts, step.removed)):
            made.pop(fact, None)
        made |= dict.fromkeys(filter(None, map(_parts, step.added)))
    return [fact for fact in made if len(fact) != 3 or (fact[0], fact[2], fact[1]) not in made]


def _ended(explanation: Explanation) -> Mapping[_Fact, frozenset[_Fact]]:
    """For each fact that a step made true, the facts that this step, or another that did so, ended."""
    ended: dict[_Fact, frozenset[_Fact]] = {}
    for step in explanation.steps:
        removed = frozenset(filter(None, map(_parts, step.removed)))
        for fact in filter(None, map(_parts, step.added)):
            ended[fact] = ended.get(fact, frozenset()) | removed
    return ended


def _is_near(wanted: _Fact, fact: _Fact, ended: Mapping[_Fact, frozenset[_Fact]]) -> bool:
    same_objects = fact[1:] == wanted[1:] and fact[0] != wanted[0]
    if same_objects and len(wanted) == 2:
        return wanted in ended[fact]
    other_place = len(wanted) == len(fact) == 3 and fact[:2] == wanted[:2] and fact[2] != wanted[2]
    return same_objects or other_place


def _parts(text: str) -> tuple[str, ...] | None:
    """``INSIDE(soap.1002, cup.1003)`` as its words; None for a text of another form."""
    name, bracket, rest = text.partition("(")
    if not bracket or not rest.endswith(")") or not name.isidentifier() or "(" in rest:
        return None
    return (name, *(word.strip() for word in rest[:-1].split(",")))


def _text(fact: Iterable[str]) -> str:
    name, *arguments = fact
    return f"{name}({', '.join(arguments)})"
