"""Delete relaxation of a declared domain: what could ever be so, if nothing got in the way of anything.

Every fact that an action may add may be so from then on, and every fact that one may delete may be not so,
whatever else is so (Bonet and Geffner 2001). What cannot be so even then is never so: a goal that cannot is
proved out of reach. Predicates that are computed may be anything. Effort is counted: nothing is proved of a
domain with too many actions.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from functools import cache
from typing import TypeAlias

import eai.logic.formula as f
from eai.logic.traversal import free_variables, predicates_of
from eai.planning.search import Effort
from eai.planning.subgoal import find_object
from eai.world.condition import Scope
from eai.world.derived import Defined, find_stored_predicates
from eai.world.domain import Domain
from eai.world.effect import ANYTHING, Add, Delete, Effect, ForEach, Let, When
from eai.world.executable import applicability
from eai.world.operator import Check, Operator
from eai.world.state import Fact, State

_MAX_LOOKS, _ACTION = 6_000_000, 30
"""Maximum number of values of parameters that are looked at; each look at an action counts for some."""

_Literal: TypeAlias = tuple[str, tuple[int, ...], bool]
"""A predicate, what it is said of, and whether it is so."""


class PossibleFacts:
    """The facts that may ever be so in an episode of a domain, and those that may ever not.

    Args:
        domain: the domain.
        initial: where the episode begins.
        usable: the objects that actions may be about.
    """

    def __init__(self, domain: Domain, initial: State, usable: Sequence[int]) -> None:
        self.domain = domain
        self._scene = initial.scene
        self.at_start = set(initial.facts())
        self.possibly_true = set(self.at_start)
        self.possibly_false: set[Fact] = set()
        self._known: set[_Literal] = set()
        self._asked: dict[_Literal, bool] = {}
        self._denied: set[_Literal] = set()
        self._done: set[tuple[int, tuple[int | None, ...]]] = set()
        self._effort = Effort(_MAX_LOOKS)
        self._pending = {o.name: list(self._instances_of(o, initial, usable)) for o in domain.operators}
        before = -1
        while self.count_literals() > before and self.is_complete:
            before = self.count_literals()
            self._grow()

    @property
    def is_complete(self) -> bool:
        """Whether all actions were looked at; otherwise everything may hold."""
        return not self._effort.is_exceeded

    def count_literals(self) -> int:
        """How much may be so, or not so."""
        return len(self.possibly_true) + len(self.possibly_false)

    def _instances_of(self, operator: Operator, initial: State, usable: Sequence[int]) -> Iterator[Scope]:
        """The actions by an operator that what never changes permits, as far as they can be listed."""
        static = tuple([check for check in operator.checks if self._is_static(check)])
        unchanging = replace(operator, checks=static, effects=(), tries=())
        arguments = applicability(unchanging, self.domain.vocabulary)
        for each in arguments(initial, usable, self._effort.spend):
            if self._effort.spend(_ACTION):
                return
            yield operator.scope(each)

    def _is_static(self, check: Check) -> bool:
        """Whether a check reads nothing that changes."""
        vocabulary = self.domain.vocabulary
        read = find_stored_predicates(predicates_of(check.condition), vocabulary)
        stored = map(vocabulary.find_stored, read)
        return all(predicate is not None and predicate.static for predicate in stored)

    def holds(self, formula: f.Formula, scope: Scope, truth: bool = True) -> bool:
        """Whether a formula may be true, or false."""
        if not self.is_complete:
            return True
        match formula:
            case f.Atom(predicate, terms):
                return self._literal(predicate, tuple([self._index(term, scope) for term in terms]), truth)
            case f.Equals(left, right):
                return (self._index(left, scope) == self._index(right, scope)) == truth
            case f.Not(part):
                return self.holds(part, scope, not truth)
            case f.And(parts) | f.Or(parts):
                each = (self.holds(part, scope, truth) for part in parts)
                return all(each) if isinstance(formula, f.And) == truth else any(each)
            case f.Implies(premise, conclusion):
                return self.holds(f.Or((f.Not(premise), conclusion)), scope, truth)
            case f.ForAll(variable, body) | f.Exists(variable, body):
                each = (self.holds(body, inner, truth) for inner in self._instances(variable, scope))
                return all(each) if isinstance(formula, f.ForAll) == truth else any(each)
            case f.Exactly(count, variable, body):
                instances = list(self._instances(variable, scope))
                may = sum(self.holds(body, inner) for inner in instances)
                must = sum(not self.holds(body, inner, truth=False) for inner in instances)
                return must <= count <= may if truth else (may, must) != (count, count)
            case f.ForPairs(first, second, body):
                rows = [list(self._instances(second, row)) for row in self._instances(first, scope)]
                met = sum(any(self.holds(body, inner) for inner in row) for row in rows)
                smaller = min(len(rows), len(rows[0]) if rows else 0)
                return not truth or met >= (smaller if formula.count is None else formula.count)
        raise TypeError(f"expected a formula about one state, found {type(formula).__name__}")

    def _instances(self, variable: f.Variable, scope: Scope) -> Iterator[Scope]:
        mask = self._scene.category(variable.category)
        for index in range(len(self._scene.objects)):
            if mask >> index & 1:
                yield {**scope, variable.name: index}

    def _index(self, term: f.Term, scope: Scope) -> int:
        return scope[term.name] if isinstance(term, f.Variable) else find_object(term, self._scene)

    def _literal(self, predicate: str, arguments: tuple[int, ...], truth: bool) -> bool:
        """Whether a literal may hold; what may once may always."""
        literal = predicate, arguments, truth
        if literal in self._known or literal in self._denied:
            return literal in self._known
        found = self.atom(predicate, arguments, truth)
        if found:
            self._known.add(literal)
        elif not self._asked:
            self._denied.add(literal)
        return found

    def atom(self, predicate: str, arguments: tuple[int, ...], truth: bool) -> bool:
        """Whether an atom may be true, or false."""
        derived = self.domain.vocabulary.derived_by_name.get(predicate)
        if derived is None:
            fact = Fact(predicate, arguments)
            return (
                fact in self.possibly_true
                if truth
                else fact not in self.at_start or fact in self.possibly_false
            )
        return self._defined(derived, arguments, truth) if isinstance(derived, Defined) else True

    def _defined(self, derived: Defined, arguments: tuple[int, ...], truth: bool) -> bool:
        """Whether a defined predicate may hold of objects, or not: a least fixpoint where it is recursive.

        What is asked again on the way is taken to be false where it is to be true, and to be either where it
        is to be false; the outermost question is asked until that teaches nothing more.
        """
        literal = derived.name, arguments, truth
        if literal in self._asked:
            return self._asked[literal]
        is_outermost = not self._asked
        names = [parameter.name for parameter in derived.parameters]
        scope = dict(zip(names, arguments, strict=True))
        while True:
            known = len(self._known)
            self._asked[literal] = not truth
            found = self._asked[literal] = self.holds(derived.definition, scope, truth)
            if not is_outermost:
                return found
            self._asked.clear()
            if found or len(self._known) == known:
                return found

    def _grow(self) -> None:
        """Let every action do what it may, once; what was not so at some time may be so the next time."""
        self._denied.clear()
        self._done.clear()
        for operator in self.domain.operators:
            self._pending[operator.name] = [
                scope for scope in self._pending[operator.name] if not self._is_done(operator, scope)
            ]

    def _is_done(self, operator: Operator, scope: Scope) -> bool:
        """Do what an action may; whether it can do no more."""
        if self._effort.spend(_ACTION) or not self._passes(operator.checks, scope):
            return False
        self._do(operator.effects, scope)
        for each in operator.tries:
            if self.holds(each.condition, scope) and self._passes(each.checks, scope):
                self._do(each.effects, scope)
        return not operator.tries and all(isinstance(effect, Add | Delete) for effect in operator.effects)

    def _passes(self, checks: Iterable[Check], scope: Scope) -> bool:
        return all(self.holds(check.condition, scope) for check in checks)

    def _do(self, effects: Iterable[Effect], scope: Scope) -> None:
        for effect in effects:
            key = id(effect), tuple([scope.get(name) for name in _variables(effect)])
            if key in self._done:
                continue
            self._done.add(key)
            match effect:
                case Add(atom):
                    self.add(Fact(atom.predicate, tuple([self._index(t, scope) for t in atom.arguments])))
                case Delete(atom):
                    self._delete(atom, scope)
                case When(condition, inner, otherwise):
                    if self.holds(condition, scope):
                        self._do(inner, scope)
                    if otherwise and self.holds(condition, scope, truth=False):
                        self._do(otherwise, scope)
                case ForEach(variable, condition, inner) | Let(variable, condition, inner):
                    for each in list(self._instances(variable, scope)):
                        if self.holds(condition, each):
                            self._do(inner, each)

    def add(self, fact: Fact) -> None:
        """A fact may be so from now on."""
        self.possibly_true.add(fact)

    def _delete(self, atom: f.Atom, scope: Scope) -> None:
        wanted = [None if term == ANYTHING else self._index(term, scope) for term in atom.arguments]
        for predicate, arguments in self.at_start:
            if predicate == atom.predicate and all(
                each in (None, own) for each, own in zip(wanted, arguments, strict=True)
            ):
                self.possibly_false.add(Fact(predicate, arguments))


@cache
def _variables(effect: Effect) -> tuple[str, ...]:
    """The names of all variables in an effect."""
    match effect:
        case Add(atom) | Delete(atom):
            return tuple([term.name for term in atom.arguments if isinstance(term, f.Variable)])
        case When(condition, inner, otherwise):
            parts = (*inner, *otherwise)
        case ForEach(_, condition, inner) | Let(_, condition, inner):
            parts = inner
    names = dict.fromkeys(free_variables(condition)) | dict.fromkeys(n for e in parts for n in _variables(e))
    return tuple(sorted(names))


def find_unreachable_goals(
    domain: Domain, initial: State, usable: Sequence[int], goals: Iterable[f.Formula]
) -> list[f.Formula]:
    """The goals about one state that are proved never to hold."""
    possible = PossibleFacts(domain, initial, usable)
    return [goal for goal in goals if not possible.holds(goal, {})]
