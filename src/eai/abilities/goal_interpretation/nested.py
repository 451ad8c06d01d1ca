"""Conditions as nested JSON lists: ``["forall", ["jar", "-", "jar"], ["not", ["open", "jar"]]]``.

The words are those of BDDL. Answers to goal interpretation are asked for literals, but some nest them. The
parts of a connective may stand in a list of their own, and a variable may be its category alone.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeAlias

import eai.logic.formula as f
from eai.logic.traversal import MAX_COUNT_DIGITS

Literal: TypeAlias = Callable[[object, frozenset[str]], f.Formula | None]
"""The meaning of an entry without connectives below quantifiers of variables; None if it is no literal."""


def read_nested(entry: object, literal: Literal, variables: frozenset[str] = frozenset()) -> f.Formula | None:
    """The meaning of an entry; None if it, or a part of it, is no condition."""

    def read(part: object, *bound: f.Variable) -> f.Formula | None:
        return read_nested(part, literal, variables | {variable.name for variable in bound})

    match entry:
        case ["not", [*_] as operand]:
            negated = read(operand)
            return None if negated is None else f.Not(negated)
        case ["and" | "or" as word, [*_] as first, *others]:
            parts = [read(part) for part in parts_of((first, *others))]
            known = tuple([part for part in parts if part is not None])
            return None if len(known) < len(parts) else f.And(known) if word == "and" else f.Or(known)
        case ["imply", premise, conclusion]:
            one, other = read(premise), read(conclusion)
            return None if one is None or other is None else f.Implies(one, other)
        case ["forall" | "exists" | "forn" | "forpairs" | "fornpairs" as word, *head, body]:
            count = _count(head.pop(0)) if word in ("forn", "fornpairs") and head else None
            bound = [variable for each in head if (variable := _variable(each)) is not None]
            inner = read(body, *bound)
            return None if inner is None or len(bound) < len(head) else _quantified(word, count, bound, inner)
        case _:
            return literal(entry, variables)


def parts_of(parts: Sequence[object]) -> Sequence[object]:
    """The parts of a connective, which may stand in a list of their own."""
    match parts:
        case [[[*_], *_] as inner]:
            return inner
        case _:
            return parts


def _quantified(
    word: str, count: int | None, variables: Sequence[f.Variable], body: f.Formula
) -> f.Formula | None:
    match word, count, variables:
        case "forall", None, [variable]:
            return f.ForAll(variable, body)
        case "exists", None, [variable]:
            return f.Exists(variable, body)
        case "forn", int(number), [variable]:
            return f.Exactly(number, variable, body)
        case "forpairs", None, [first, second]:
            return f.ForPairs(first, second, body)
        case "fornpairs", int(number), [first, second]:
            return f.ForPairs(first, second, body, number)
        case _:
            return None


def _variable(part: object) -> f.Variable | None:
    match part:
        case str(category):
            return f.Variable(category, category)
        case [str(name), "-", str(category)]:
            return f.Variable(name, category)
        case _:
            return None


def _count(part: object) -> int | None:
    match part:
        case bool():
            return None
        case int(number) | [int(number)] if number >= 0:
            return number
        case str(digits) | [str(digits)] if digits.isdecimal() and len(digits) <= MAX_COUNT_DIGITS:
            return int(digits)
        case _:
            return None
