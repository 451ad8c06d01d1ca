"""Print formulas in the syntax that `eai.logic.ltl` reads."""

from __future__ import annotations

from collections.abc import Sequence

from typing_extensions import assert_never

import eai.logic.formula as f
from eai.logic.ltl import PREFIX, PREFIXES, STRENGTHS

_PREFIXES = {kind: word for word, kind in PREFIXES.items()}


def format_ltl(formula: f.Formula) -> str:
    """Return the text of a formula, with as few brackets as the grammar allows.

    Parsing this text gives an equal formula under four conditions. First, the formula's names are names of
    the grammar, and not words such as ``and``. Second, no object has the name of a variable that is bound
    around it. Third, actions are in the parser's signature. Fourth, And, Or and Then have two or more parts;
    or no parts, which is printed as ``true`` or ``false``.
    """
    return _format_subformula(formula, STRENGTHS["then"])


def _format_subformula(formula: f.Formula, needed_strength: int) -> str:
    """Return the text of a formula, in brackets if it binds less tightly than ``needed_strength``."""
    match formula:
        case f.Atom(name, arguments) | f.Occurs(name, arguments):
            return f"{name}({', '.join(term.name for term in arguments)})"
        case f.Equals(left, right):
            return f"{left.name} = {right.name}"
        case f.And(parts):
            return _format_series(parts, "and", needed_strength) if parts else "true"
        case f.Or(parts):
            return _format_series(parts, "or", needed_strength) if parts else "false"
        case f.Then(parts):
            return _format_series(parts, "then", needed_strength) if parts else "true"
        case f.Implies(left, right):
            return _format_infix(left, "implies", right, needed_strength)
        case f.Until(left, right):
            return _format_infix(left, "until", right, needed_strength)
        case f.Not(operand) | f.Next(operand) | f.Eventually(operand) | f.Always(operand):
            return f"{_PREFIXES[type(formula)]} {_format_subformula(operand, PREFIX)}"
        case f.ForAll(body=body) | f.Exists(body=body) | f.Exactly(body=body) | f.ForPairs(body=body):
            return f"{_format_quantifier(formula)}. ({format_ltl(body)})"
        case _:
            assert_never(formula)


def _format_series(parts: Sequence[f.Formula], word: str, needed_strength: int) -> str:
    """Return the text of an And, Or or Then.

    A part with the same operator keeps its brackets, so that parsing gives an equal formula.
    """
    if len(parts) == 1:
        return _format_subformula(parts[0], needed_strength)
    text = f" {word} ".join([_format_subformula(part, STRENGTHS[word] + 1) for part in parts])
    return _add_brackets_if_needed(text, STRENGTHS[word], needed_strength)


def _format_infix(left: f.Formula, word: str, right: f.Formula, needed_strength: int) -> str:
    strength = STRENGTHS[word]
    text = f"{_format_subformula(left, strength + 1)} {word} {_format_subformula(right, strength)}"
    return _add_brackets_if_needed(text, strength, needed_strength)


def _add_brackets_if_needed(text: str, strength: int, needed_strength: int) -> str:
    return f"({text})" if strength < needed_strength else text


def _format_quantifier(formula: f.ForAll | f.Exists | f.Exactly | f.ForPairs) -> str:
    match formula:
        case f.ForAll(variable):
            return f"forall {_format_variable(variable)}"
        case f.Exists(variable):
            return f"exists {_format_variable(variable)}"
        case f.Exactly(count, variable):
            return f"forn {count}. {_format_variable(variable)}"
        case f.ForPairs(first, second, _, count):
            word = "forpairs" if count is None else f"fornpairs {count}."
            return f"{word} {_format_variable(first)}, {_format_variable(second)}"
        case _:
            assert_never(formula)


def _format_variable(variable: f.Variable) -> str:
    return variable.name if variable.category is None else f"{variable.name}: {variable.category}"
