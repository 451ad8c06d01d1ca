"""Conditions and effects as trees of clauses: one shape for both, matched by one set of rules.

Connectives are flattened and single-part lists opened, so that ``(and (p) (and (q)))`` is the same tree as
``(and (p) (q))`` and ``(and (p))`` the same as ``(p)``; double negations vanish, and an implication is the
disjunction that it means. Order of parts is kept and means nothing.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from enum import Enum
from typing import TypeAlias

from typing_extensions import assert_never

import eai.logic.formula as f
import eai.pddl.model as m
from eai.pddl.writer import write_term

EQUALITY = "="
"""The name of the predicate of equations."""


class _Connective(str, Enum):
    """The words that join the parts of a list."""

    ALL = "and"
    ANY = "or"


class _Scope(str, Enum):
    """The words that bind a variable, or guard its part."""

    FORALL = "forall"
    EXISTS = "exists"


@dataclass(frozen=True, slots=True)
class Literal:
    """An atom, asserted or denied; in an effect: added or deleted."""

    predicate: str
    arguments: tuple[f.Term, ...]
    positive: bool


@dataclass(frozen=True, slots=True)
class Joined:
    """A list of clauses."""

    connective: _Connective
    parts: tuple[Clause, ...]


@dataclass(frozen=True, slots=True)
class Denied:
    """The negation of something that is not an atom."""

    part: Clause


@dataclass(frozen=True, slots=True)
class Bound:
    """A clause under a quantifier."""

    scope: _Scope
    name: str
    type: str
    part: Clause


@dataclass(frozen=True, slots=True)
class Guarded:
    """A clause of an effect that depends on a condition."""

    guard: Clause
    part: Clause


Clause: TypeAlias = Literal | Joined | Denied | Bound | Guarded


_HEAD = re.compile(r"\(([^\s()?]+)")
_CONNECTIVES = frozenset({*(word.value for word in (*_Connective, *_Scope)), "not", "when"})


def condition_clause(formula: f.Formula) -> Clause:
    """The tree of a condition.

    Raises:
        ValueError: the formula has a part without a PDDL form.
    """
    match formula:
        case f.Atom(predicate, arguments):
            return Literal(predicate, arguments, positive=True)
        case f.Equals(left, right):
            return Literal(EQUALITY, (left, right), positive=True)
        case f.Not(operand):
            return _denied(condition_clause(operand))
        case f.And(operands):
            return _joined(_Connective.ALL, map(condition_clause, operands))
        case f.Or(operands):
            return _joined(_Connective.ANY, map(condition_clause, operands))
        case f.Implies(premise, conclusion):
            return _joined(
                _Connective.ANY, [_denied(condition_clause(premise)), condition_clause(conclusion)]
            )
        case f.ForAll(variable, body):
            return _bound(_Scope.FORALL, variable, condition_clause(body))
        case f.Exists(variable, body):
            return _bound(_Scope.EXISTS, variable, condition_clause(body))
        case _:
            raise ValueError(f"{type(formula).__name__} has no PDDL form")


def effect_clause(effect: m.PddlEffect) -> Clause:
    """The tree of an effect."""
    match effect:
        case m.AddEffect(atom):
            return Literal(atom.predicate, atom.arguments, positive=True)
        case m.DeleteEffect(atom):
            return Literal(atom.predicate, atom.arguments, positive=False)
        case m.Both(parts):
            return _joined(_Connective.ALL, map(effect_clause, parts))
        case m.Each(variable, part):
            return _bound(_Scope.FORALL, variable, effect_clause(part))
        case m.WhenEffect(condition, part):
            return Guarded(condition_clause(condition), effect_clause(part))
        case _:
            assert_never(effect)


def literals(clause: Clause) -> Iterator[Literal]:
    """The literals of a tree, left to right, each as often as it stands there."""
    match clause:
        case Literal():
            yield clause
        case Joined(_, parts):
            for part in parts:
                yield from literals(part)
        case Denied(part) | Bound(part=part):
            yield from literals(part)
        case Guarded(guard, part):
            yield from literals(guard)
            yield from literals(part)


def parts_of(clause: Clause) -> tuple[Clause, ...]:
    """The parts of a list; anything else is a list of one."""
    return clause.parts if isinstance(clause, Joined) else (clause,)


def canonical(clause: Clause, names: Mapping[str, str], depth: int = 0) -> str:
    """The text of all trees that differ from this one in order of parts and names of variables only.

    Args:
        clause: the tree.
        names: what the free variables are called; one that is not there is like no other tree's.
        depth: how many quantifiers stand around it.
    """
    match clause:
        case Literal(predicate, arguments, positive):
            atom = f"({' '.join([predicate, *[_called(term, names) for term in arguments]])})"
            return atom if positive else f"(not {atom})"
        case Joined(connective, parts):
            found = sorted([canonical(part, names, depth) for part in parts])
            return f"({' '.join([connective.value, *found])})"
        case Denied(part):
            return f"(not {canonical(part, names, depth)})"
        case Bound(scope, name, category, part):
            bound = f"#{depth}"
            body = canonical(part, {**names, name: bound}, depth + 1)
            return f"({scope.value} (?{bound} - {category}) {body})"
        case Guarded(guard, part):
            return f"(when {canonical(guard, names, depth)} {canonical(part, names, depth)})"
        case _:
            assert_never(clause)


def write_clause(clause: Clause) -> str:
    """The tree as PDDL on one line."""
    match clause:
        case Literal(predicate, arguments, positive):
            atom = f"({' '.join((predicate, *map(write_term, arguments)))})"
            return atom if positive else f"(not {atom})"
        case Joined(connective, parts):
            return f"({' '.join((connective.value, *map(write_clause, parts)))})"
        case Denied(part):
            return f"(not {write_clause(part)})"
        case Bound(scope, name, category, part):
            return f"({scope.value} (?{name} - {category}) {write_clause(part)})"
        case Guarded(guard, part):
            return f"(when {write_clause(guard)} {write_clause(part)})"
        case _:
            assert_never(clause)


def predicates_in(text: str) -> frozenset[str]:
    """The predicates of a clause as `write_clause` prints it; a name that stands alone is a predicate."""
    return frozenset(_HEAD.findall(text)) - _CONNECTIVES if text.startswith("(") else frozenset({text})


def _called(term: f.Term, names: Mapping[str, str]) -> str:
    return f"?{names.get(term.name, f'?{term.name}')}" if isinstance(term, f.Variable) else term.name


def _denied(clause: Clause) -> Clause:
    match clause:
        case Literal(predicate, arguments, positive):
            return Literal(predicate, arguments, positive=not positive)
        case Denied(part):
            return part
        case _:
            return Denied(clause)


def _bound(scope: _Scope, variable: f.Variable, part: Clause) -> Clause:
    return Bound(scope, variable.name, m.type_of(variable), part)


def _joined(connective: _Connective, parts: Iterable[Clause]) -> Clause:
    flat: list[Clause] = []
    for part in parts:
        if isinstance(part, Joined) and part.connective is connective:
            flat.extend(part.parts)
        else:
            flat.append(part)
    return flat[0] if len(flat) == 1 else Joined(connective, tuple(flat))
