"""Delete relaxation of a declared domain: a superset of the facts that may ever hold.

Every fact that an action adds counts as possibly true from then on. Every deleted fact counts as possibly
false, but stays possibly true (Bonet and Geffner 2001). A goal that does not hold even under these
assumptions is proved unreachable. Predicates that a function computes may be true or false. The effort is
limited: nothing is proved for a domain with too many actions.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from functools import cache
from typing import TypeAlias

import eai.logic.formula as f
from eai.logic.traversal import find_free_variables, find_predicates
from eai.planning.search import SearchEffort
from eai.planning.subgoal import find_object
from eai.world.condition import Scope
from eai.world.derived import DefinedPredicate, find_stored_dependencies
from eai.world.domain import Domain
from eai.world.effect import ANYTHING, Add, Delete, Effect, ForEach, Let, When
from eai.world.executable import compile_argument_finder
from eai.world.operator import Check, Operator
from eai.world.state import Fact, State

_MAX_LOOKS, _ACTION_LOOKS = 6_000_000, 30
"""Maximum number of operations to find the possible facts, and the number that each tried action costs.

Each object that is tried as an argument of an action costs one operation, too.
"""

_GroundLiteral: TypeAlias = tuple[str, tuple[int, ...], bool]
"""A predicate, its arguments, and whether it is true."""


class PossibleFacts:
    """The facts that may ever be true, and the facts that may ever be false, in an episode of a domain.

    Args:
        domain: the domain.
        initial: the initial state.
        usable_objects: the objects that actions may use, by index.
    """

    def __init__(self, domain: Domain, initial: State, usable_objects: Sequence[int]) -> None:
        self.domain = domain
        self._scene = initial.scene
        self.at_start = set(initial.facts())
        self.possibly_true = set(self.at_start)
        self.possibly_false: set[Fact] = set()
        self._proved: set[_GroundLiteral] = set()
        self._assumed: dict[_GroundLiteral, bool] = {}
        self._denied: set[_GroundLiteral] = set()
        self._done: set[tuple[int, tuple[int | None, ...]]] = set()
        self._effort = SearchEffort(_MAX_LOOKS)
        self._pending = {
            o.name: list(self._generate_bindings_allowed_by_static_facts(o, initial, usable_objects))
            for o in domain.operators
        }
        before = -1
        while self.count_possible_literals() > before and self.has_examined_all_actions:
            before = self.count_possible_literals()
            self._apply_all_actions_once()

    @property
    def has_examined_all_actions(self) -> bool:
        """Whether all actions were examined within the limit of effort. If not, `may_hold` returns True."""
        return not self._effort.is_limit_exceeded

    def count_possible_literals(self) -> int:
        """Return the number of facts that may be true plus the number of facts that may be false."""
        return len(self.possibly_true) + len(self.possibly_false)

    def _generate_bindings_allowed_by_static_facts(
        self, operator: Operator, initial: State, usable_objects: Sequence[int]
    ) -> Iterator[Scope]:
        """Yield the mappings from an operator's parameters to objects that the unchanging facts allow."""
        static = tuple([check for check in operator.checks if self._is_static(check)])
        unchanging = replace(operator, checks=static, effects=(), alternatives=())
        arguments = compile_argument_finder(unchanging, self.domain.vocabulary)
        for values in arguments(initial, usable_objects, self._effort.spend_and_check_limit):
            if self._effort.spend_and_check_limit(_ACTION_LOOKS):
                return
            yield operator.map_parameters(values)

    def _is_static(self, check: Check) -> bool:
        vocabulary = self.domain.vocabulary
        read = find_stored_dependencies(find_predicates(check.condition), vocabulary)
        stored = map(vocabulary.find_stored_predicate, read)
        return all(predicate is not None and predicate.static for predicate in stored)

    def may_hold(self, formula: f.Formula, scope: Scope, truth: bool = True) -> bool:
        """Whether a formula may ever be true; if ``truth`` is False, whether it may ever be false."""
        if not self.has_examined_all_actions:
            return True
        match formula:
            case f.Atom(predicate, terms):
                return self._may_literal_hold_cached(
                    predicate, tuple([self._find_object_index(term, scope) for term in terms]), truth
                )
            case f.Equals(left, right):
                return (
                    self._find_object_index(left, scope) == self._find_object_index(right, scope)
                ) == truth
            case f.Not(part):
                return self.may_hold(part, scope, not truth)
            case f.And(parts) | f.Or(parts):
                results = (self.may_hold(part, scope, truth) for part in parts)
                return all(results) if isinstance(formula, f.And) == truth else any(results)
            case f.Implies(premise, conclusion):
                return self.may_hold(f.Or((f.Not(premise), conclusion)), scope, truth)
            case f.ForAll(variable, body) | f.Exists(variable, body):
                results = (
                    self.may_hold(body, inner, truth)
                    for inner in self._generate_scopes_with_each_object(variable, scope)
                )
                return all(results) if isinstance(formula, f.ForAll) == truth else any(results)
            case f.Exactly(count, variable, body):
                instances = list(self._generate_scopes_with_each_object(variable, scope))
                may = sum(self.may_hold(body, inner) for inner in instances)
                must = sum(not self.may_hold(body, inner, truth=False) for inner in instances)
                return must <= count <= may if truth else (may, must) != (count, count)
            case f.ForPairs(first, second, body):
                rows = [
                    list(self._generate_scopes_with_each_object(second, row))
                    for row in self._generate_scopes_with_each_object(first, scope)
                ]
                met = sum(any(self.may_hold(body, inner) for inner in row) for row in rows)
                smaller = min(len(rows), len(rows[0]) if rows else 0)
                return not truth or met >= (smaller if formula.count is None else formula.count)
        raise TypeError(f"{type(formula).__name__} is not about one state: use no temporal operators")

    def _generate_scopes_with_each_object(self, variable: f.Variable, scope: Scope) -> Iterator[Scope]:
        mask = self._scene.get_category_mask(variable.category)
        for index in range(len(self._scene.objects)):
            if mask >> index & 1:
                yield {**scope, variable.name: index}

    def _find_object_index(self, term: f.Term, scope: Scope) -> int:
        return scope[term.name] if isinstance(term, f.Variable) else find_object(term, self._scene)

    def _may_literal_hold_cached(self, predicate: str, arguments: tuple[int, ...], truth: bool) -> bool:
        """Whether a literal may ever hold.

        The result True is cached for good, since a possible literal never becomes impossible.
        """
        literal = predicate, arguments, truth
        if literal in self._proved or literal in self._denied:
            return literal in self._proved
        is_possible = self.may_atom_hold(predicate, arguments, truth)
        if is_possible:
            self._proved.add(literal)
        elif not self._assumed:
            self._denied.add(literal)
        return is_possible

    def may_atom_hold(self, predicate: str, arguments: tuple[int, ...], truth: bool) -> bool:
        """Whether an atom may ever be true; if ``truth`` is False, whether it may ever be false."""
        derived = self.domain.vocabulary.derived_by_name.get(predicate)
        if derived is None:
            fact = Fact(predicate, arguments)
            if truth:
                return fact in self.possibly_true
            return fact not in self.at_start or fact in self.possibly_false
        if isinstance(derived, DefinedPredicate):
            return self._may_derived_atom_have_truth_value(derived, arguments, truth)
        return True

    def _may_derived_atom_have_truth_value(
        self, derived: DefinedPredicate, arguments: tuple[int, ...], truth: bool
    ) -> bool:
        """Whether an atom of a defined predicate may ever have the truth value ``truth``.

        By a recursive definition, an atom's truth may depend on the atom itself. Then the atom is at first
        assumed to be never true, but possibly false, as in a least fixpoint. The outermost evaluation is
        repeated until its result is True, or until it finds no new possible literal.
        """
        literal = derived.name, arguments, truth
        if literal in self._assumed:
            return self._assumed[literal]
        is_outer_call = not self._assumed
        names = [parameter.name for parameter in derived.parameters]
        scope = dict(zip(names, arguments, strict=True))
        while True:
            proved_before = len(self._proved)
            self._assumed[literal] = not truth
            result = self._assumed[literal] = self.may_hold(derived.definition, scope, truth)
            if not is_outer_call:
                return result
            self._assumed.clear()
            if result or len(self._proved) == proved_before:
                return result

    def _apply_all_actions_once(self) -> None:
        """Apply every action once. Effects that are impossible now may become possible in the next round."""
        self._denied.clear()
        self._done.clear()
        for operator in self.domain.operators:
            self._pending[operator.name] = [
                scope
                for scope in self._pending[operator.name]
                if not self._apply_action_and_check_if_repeat_useless(operator, scope)
            ]

    def _apply_action_and_check_if_repeat_useless(self, operator: Operator, scope: Scope) -> bool:
        """Apply an action. Return whether applying it again later can have no further effect."""
        if self._effort.spend_and_check_limit(_ACTION_LOOKS) or not self._may_pass_checks(
            operator.checks, scope
        ):
            return False
        self._apply_effects(operator.effects, scope)
        for attempt in operator.alternatives:
            if self.may_hold(attempt.condition, scope) and self._may_pass_checks(attempt.checks, scope):
                self._apply_effects(attempt.effects, scope)
        return not operator.alternatives and all(
            isinstance(effect, Add | Delete) for effect in operator.effects
        )

    def _may_pass_checks(self, checks: Iterable[Check], scope: Scope) -> bool:
        return all(self.may_hold(check.condition, scope) for check in checks)

    def _apply_effects(self, effects: Iterable[Effect], scope: Scope) -> None:
        for effect in effects:
            key = id(effect), tuple([scope.get(name) for name in _find_effect_variables(effect)])
            if key in self._done:
                continue
            self._done.add(key)
            match effect:
                case Add(atom):
                    self.add(
                        Fact(
                            atom.predicate, tuple([self._find_object_index(t, scope) for t in atom.arguments])
                        )
                    )
                case Delete(atom):
                    self._mark_deletable(atom, scope)
                case When(condition, inner, otherwise):
                    if self.may_hold(condition, scope):
                        self._apply_effects(inner, scope)
                    if otherwise and self.may_hold(condition, scope, truth=False):
                        self._apply_effects(otherwise, scope)
                case ForEach(variable, condition, inner) | Let(variable, condition, inner):
                    for instance in list(self._generate_scopes_with_each_object(variable, scope)):
                        if self.may_hold(condition, instance):
                            self._apply_effects(inner, instance)

    def add(self, fact: Fact) -> None:
        """Record that a fact may be true."""
        self.possibly_true.add(fact)

    def _mark_deletable(self, atom: f.Atom, scope: Scope) -> None:
        pattern = [
            None if term == ANYTHING else self._find_object_index(term, scope) for term in atom.arguments
        ]
        for predicate, arguments in self.at_start:
            if predicate == atom.predicate and all(
                expected in (None, argument) for expected, argument in zip(pattern, arguments, strict=True)
            ):
                self.possibly_false.add(Fact(predicate, arguments))


@cache
def _find_effect_variables(effect: Effect) -> tuple[str, ...]:
    match effect:
        case Add(atom) | Delete(atom):
            return tuple([term.name for term in atom.arguments if isinstance(term, f.Variable)])
        case When(condition, inner, otherwise):
            parts = (*inner, *otherwise)
        case ForEach(_, condition, inner) | Let(_, condition, inner):
            parts = inner
    names = dict.fromkeys(find_free_variables(condition)) | dict.fromkeys(
        n for e in parts for n in _find_effect_variables(e)
    )
    return tuple(sorted(names))


def find_unreachable_goals(
    domain: Domain, initial: State, usable: Sequence[int], goals: Iterable[f.Formula]
) -> list[f.Formula]:
    """Return the goals that provably hold in no reachable state."""
    possible = PossibleFacts(domain, initial, usable)
    return [goal for goal in goals if not possible.may_hold(goal, {})]
