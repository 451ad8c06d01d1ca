"""Formulas printed in the syntax that `eai.logic.ltl` reads."""

from __future__ import annotations

from collections.abc import Sequence

from typing_extensions import assert_never

import eai.logic.formula as f
from eai.logic.ltl import PREFIX, PREFIXES, STRENGTHS

_PREFIXES = {kind: word for word, kind in PREFIXES.items()}


def print_ltl(formula: f.Formula) -> str:
    """The formula as text, with as few brackets as the grammar allows.

    Reading the text gives an equal formula if its names are names of the grammar and no words of it, no
    object is named as a variable around it, actions are in the reader's signature, and And, Or and Then have
    at least two parts (or none: ``true`` and ``false``).
    """
    return _print(formula, STRENGTHS["then"])


def _print(formula: f.Formula, place: int) -> str:
    """The text of a formula, in brackets if it binds less tightly than its place needs."""
    match formula:
        case f.Atom(name, arguments) | f.Occurs(name, arguments):
            return f"{name}({', '.join(term.name for term in arguments)})"
        case f.Equals(left, right):
            return f"{left.name} = {right.name}"
        case f.And(parts):
            return _joined(parts, "and", place) if parts else "true"
        case f.Or(parts):
            return _joined(parts, "or", place) if parts else "false"
        case f.Then(parts):
            return _joined(parts, "then", place) if parts else "true"
        case f.Implies(left, right):
            return _infix(left, "implies", right, place)
        case f.Until(left, right):
            return _infix(left, "until", right, place)
        case f.Not(operand) | f.Next(operand) | f.Eventually(operand) | f.Always(operand):
            return f"{_PREFIXES[type(formula)]} {_print(operand, PREFIX)}"
        case f.ForAll(body=body) | f.Exists(body=body) | f.Exactly(body=body) | f.ForPairs(body=body):
            return f"{_quantifier(formula)}. ({print_ltl(body)})"
        case _:
            assert_never(formula)


def _joined(parts: Sequence[f.Formula], word: str, place: int) -> str:
    """An associative connective; a part that is the same connective keeps its brackets."""
    if len(parts) == 1:
        return _print(parts[0], place)
    text = f" {word} ".join([_print(part, STRENGTHS[word] + 1) for part in parts])
    return _bracketed(text, STRENGTHS[word], place)


def _infix(left: f.Formula, word: str, right: f.Formula, place: int) -> str:
    """A connective that groups to the right."""
    strength = STRENGTHS[word]
    text = f"{_print(left, strength + 1)} {word} {_print(right, strength)}"
    return _bracketed(text, strength, place)


def _bracketed(text: str, strength: int, place: int) -> str:
    return f"({text})" if strength < place else text


def _quantifier(formula: f.ForAll | f.Exists | f.Exactly | f.ForPairs) -> str:
    match formula:
        case f.ForAll(variable):
            return f"forall {_binding(variable)}"
        case f.Exists(variable):
            return f"exists {_binding(variable)}"
        case f.Exactly(count, variable):
            return f"forn {count}. {_binding(variable)}"
        case f.ForPairs(first, second, _, count):
            word = "forpairs" if count is None else f"fornpairs {count}."
            return f"{word} {_binding(first)}, {_binding(second)}"
        case _:
            assert_never(formula)


def _binding(variable: f.Variable) -> str:
    return variable.name if variable.category is None else f"{variable.name}: {variable.category}"
