"""Flips: the changes that may give a condition another truth, and the actions that make them.

Where a condition is not as it should be, one of some changes has to happen before it is: a disjunctive
landmark (Richter and Westphal 2010) of that one state, found by taking the condition apart.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cache, cached_property
from typing import TypeAlias

import eai.logic.formula as f
from eai.logic.traversal import free_variables, predicates_of
from eai.planning.achievers import Achievers, complete_bindings
from eai.planning.effect_schema import (
    EffectSchema,
    FactChange,
    changes_towards,
    match_atom,
    unread_predicates,
)
from eai.planning.search import Effort
from eai.planning.subgoal import arguments_of, find_object
from eai.planning.successor_generator import ACTION_BINDINGS
from eai.world.action import Action
from eai.world.condition import FormulaEvaluator, Scope
from eai.world.derived import find_definition, find_stored_predicates
from eai.world.domain import Domain
from eai.world.fault import FaultKind
from eai.world.operator import Check
from eai.world.relation import bits, mask_of
from eai.world.state import State

ChangeSet: TypeAlias = frozenset[FactChange]
"""Changes of which one has to happen; if there are none, nothing helps."""

ScopedCondition: TypeAlias = tuple[f.Formula, Scope]
"""A condition, and what its variables stand for."""

_NOTHING: ChangeSet = frozenset()
_FEW = 4
"""So few actions that no other part of a condition is looked at for fewer."""

_MAX_BINDINGS = 3_000_000
"""Maximum number of values of parameters that are tried to list the actions by one operator."""


class ConflictChanges:
    """The changes and actions that may give conditions another truth, in one episode.

    Args:
        domain: the domain.
        initial: a state of the episode, which says what never changes.
        objects: what actions may be about, by index.
        achievers: those of the domain.
    """

    def __init__(self, domain: Domain, initial: State, objects: Sequence[int], achievers: Achievers) -> None:
        self._domain = domain
        self._initial = initial
        self._usable = mask_of(objects)
        self._achievers = achievers
        self._static = {p.name for p in domain.vocabulary.predicates if p.static}
        self._conditions: dict[int, list[tuple[f.Formula, frozenset[str]]]] = {}
        self._unread = {o.name: unread for o in domain.operators if (unread := unread_predicates(o))}
        # Kept by hand: a `cache` of a method would keep all of an episode until garbage is collected.
        self._writers: dict[FactChange, tuple[Action, ...]] = {}
        self._taking: dict[str, tuple[Action, ...]] = {}
        self._indices: dict[tuple[str, int], dict[int, list[Action]]] = {}
        self._open: set[tuple[str, tuple[int, ...], bool]] = set()
        self._of_operator: dict[tuple[str, str, bool], list[EffectSchema]] = {}
        for (predicate, adds), schemas in achievers.by_effect.items():
            for schema in schemas:
                self._of_operator.setdefault((schema.operator.name, predicate, adds), []).append(schema)
        self._depths: dict[int, tuple[int, f.Formula]] = {}
        self._readings = FormulaEvaluator(domain.vocabulary)
        self.holds = self._readings.holds
        self.names = self._readings.names
        self.derived = domain.vocabulary.derived_by_name.get

    def actions(self, changes: Iterable[FactChange]) -> dict[Action, None]:
        """The actions that may make one of some changes, in a fixed order."""
        return dict.fromkeys(
            action for change in sorted(changes, key=change_order) for action in self.actions_making(change)
        )

    def actions_making(self, change: FactChange) -> tuple[Action, ...]:
        """The actions that may make a change, as far as what never changes permits them."""
        found = self._writers.get(change)
        if found is None:
            unread = [a for each in self._changing(change) for a in self.actions_of(each)]
            makers = [action for _, _, actions in self._by_schema(change) for action in actions]
            found = self._writers[change] = tuple(dict.fromkeys([*unread, *makers]))
        return found

    def group_makers(self, change: FactChange) -> Iterator[tuple[Sequence[Action], list[ScopedCondition]]]:
        """The actions that may make a change, those together of which the same must hold before."""
        yield from ((self.actions_of(name), []) for name in self._changing(change))
        for schema, scope, actions in self._by_schema(change):
            given = [(each, self.names(each)) for each in schema.conditions]
            asked = {name for _, names in given for name in names if name not in scope}
            names = [parameter.name for parameter in schema.operator.parameters]
            places = [place for place, name in enumerate(names) if name in asked]
            alike: dict[tuple[int, ...], list[Action]] = {}
            for action in actions:
                alike.setdefault(tuple([action.arguments[i] for i in places]), []).append(action)
            for values, own in alike.items():
                inner = {names[place]: value for place, value in zip(places, values, strict=True)}
                yield own, _closed(given, {**scope, **inner})

    def _changing(self, change: FactChange) -> list[str]:
        """The operators whose effects are left out, and may make a change."""
        return [name for name, changed in self._unread.items() if change.predicate in changed]

    def _by_schema(
        self, change: FactChange
    ) -> Iterator[tuple[EffectSchema, dict[str, int], Sequence[Action]]]:
        """The effects that make a change, what their variables stand for in it, and the actions."""
        for schema in self._achievers.by_effect.get((change.predicate, change.truth), ()):
            scope = match_atom(schema.atom, change.arguments, self._object_named)
            if scope is not None:
                places = enumerate(schema.operator.parameters)
                bound = [(i, scope[each.name]) for i, each in places if each.name in scope]
                yield schema, scope, self._about(schema.operator.name, bound)

    def _about(self, name: str, bound: Sequence[tuple[int, int]]) -> Sequence[Action]:
        """The actions by an operator that have some objects at their places."""
        if not bound:
            return self.actions_of(name)
        place, thing = bound[0]
        by_object = self._indices.get((name, place))
        if by_object is None:
            by_object = self._indices[name, place] = {}
            for action in self.actions_of(name):
                by_object.setdefault(action.arguments[place], []).append(action)
        found = by_object.get(thing, [])
        return [a for a in found if all(a.arguments[i] == o for i, o in bound[1:])] if bound[1:] else found

    def actions_of(self, name: str) -> tuple[Action, ...]:
        """The actions by an operator, as far as what never changes permits them."""
        found = self._taking.get(name)
        if found is None:
            actions: dict[Action, None] = {}
            for achiever in self._achievers.find_operators([name]):
                partial = achiever.partial(self._initial.scene, {}, fixed=True)
                effort = Effort(_MAX_BINDINGS)
                for binding in complete_bindings(self._initial, partial, self._usable, effort):
                    if effort.spend(ACTION_BINDINGS):
                        break
                    actions[Action(name, achiever.arguments(binding))] = None
            found = self._taking[name] = tuple(actions)
        return found

    @cached_property
    def is_partial(self) -> bool:
        """Whether an operator has too many actions to list them, so that nothing can be proved."""
        return any(
            ACTION_BINDINGS * self._usable.bit_count() ** operator.arity > _MAX_BINDINGS
            and self._is_too_wide(operator.name)
            for operator in self._domain.operators
        )

    def _is_too_wide(self, name: str) -> bool:
        effort = Effort(_MAX_BINDINGS)
        for achiever in self._achievers.find_operators([name]):
            partial = achiever.partial(self._initial.scene, {}, fixed=True)
            for _ in complete_bindings(self._initial, partial, self._usable, effort):
                if effort.spend(ACTION_BINDINGS):
                    break
        return effort.is_exceeded

    def may_make(self, action: Action, change: FactChange) -> bool:
        """Whether an action may make a change."""
        return next(self.effect_conditions(action, change), None) is not None

    def preconditions(self, action: Action) -> list[ScopedCondition]:
        """The conditions under which an action is carried out."""
        operator = self._domain.compiled[action.operator].operator
        scope = operator.scope(action.arguments)
        return [(remaining_condition(each, operator.checks), scope) for each in operator.checks]

    def effect_conditions(self, action: Action, change: FactChange) -> Iterator[list[ScopedCondition]]:
        """For each effect by which an action may make a change what that needs besides, as far as known."""
        if change.predicate in self._unread.get(action.operator, ()):
            yield []
        effect = action.operator, change.predicate, change.truth
        for schema in self._of_operator.get(effect, ()):
            scope = self._matches(schema, action, change)
            if scope is not None:
                conditions = self._conditions.get(id(schema))
                if conditions is None:
                    conditions = self._conditions[id(schema)] = _conditions(schema)
                yield [(each, scope) for each, names in conditions if names <= scope.keys()]

    def changes_before_step(
        self, action: Action, state: State, changes: ChangeSet, *, executed: bool
    ) -> tuple[ChangeSet, bool]:
        """The changes that may alter that a step makes none of some changes, or undoes one; if it does so.

        Args:
            action: the step.
            state: where it is taken.
            changes: the changes.
            executed: whether it is executed there, not skipped.
        """
        if action.operator in self._unread:
            return frozenset(self._any(p.name for p in self._domain.vocabulary.predicates)), executed
        found: set[FactChange] = set()
        undoes = False
        for schema, scope, helps in self._touching(action, changes):
            if helps and not executed:
                return self.changes_for_skipping(action, state, executed=False), False
            tried = schema.checks if schema.operator.tries else ()
            parts = [(condition, scope) for condition in (*schema.conditions, *tried)]
            closed = [part for part in parts if free_variables(part[0]) <= scope.keys()]
            fails = any(not self.holds(*part, state) for part in closed)
            if helps and fails:
                found |= self._of_parts(closed, state, True, all_needed=True)
            elif helps or (executed and not fails):
                found.update(*[self.all_changes(part[0]) for part in parts if part not in closed])
                undoes = undoes or not helps
                if not helps:
                    found |= self._of_parts(closed, state, False, all_needed=False)
        if undoes:
            found |= self.changes_for_skipping(action, state, executed=True)
        return frozenset(found), undoes

    def _touching(
        self, action: Action, changes: ChangeSet
    ) -> Iterator[tuple[EffectSchema, dict[str, int], bool]]:
        """The effects of an action that may make one of some changes, or its opposite."""
        for schema in self._achievers.schemas[action.operator]:
            for change in changes:
                if change.predicate == schema.atom.predicate:
                    scope = self._matches(schema, action, change._replace(truth=schema.adds))
                    if scope is not None:
                        yield schema, scope, schema.adds == change.truth

    def changes_for_skipping(self, action: Action, state: State, *, executed: bool) -> ChangeSet:
        """The changes one of which has a step skipped that is executed, or the other way round."""
        operator = self._domain.compiled[action.operator].operator
        scope = operator.scope(action.arguments)
        checks = [c.condition for c in operator.checks if c.fault is FaultKind.ADDITIONAL_STEP]
        wrong = [(c, scope) for c in checks if self.holds(c, scope, state) == executed]
        return self._of_parts(wrong, state, not executed, all_needed=False)

    def _matches(self, schema: EffectSchema, action: Action, change: FactChange) -> dict[str, int] | None:
        """The objects of a schema's variables where it is that of an action and makes a change."""
        if schema.adds != change.truth or schema.atom.predicate != change.predicate:
            return None
        known = dict(zip(schema.variables, action.arguments, strict=False))
        return match_atom(schema.atom, change.arguments, self._object_named, known)

    def _object_named(self, constant: f.Constant) -> int:
        return find_object(constant, self._initial.scene)

    def find_changes(self, formula: f.Formula, scope: Scope, state: State, *, truth: bool) -> ChangeSet:
        """The changes one of which has to happen before a condition has a truth that it has not."""
        match formula:
            case f.Not(operand):
                return self.find_changes(operand, scope, state, truth=not truth)
            case f.Implies(premise, conclusion):
                return self.find_changes(f.Or((f.Not(premise), conclusion)), scope, state, truth=truth)
            case f.And(operands) | f.Or(operands):
                parts = [(operand, scope) for operand in operands]
                return self._of_parts(parts, state, truth, all_needed=isinstance(formula, f.And) == truth)
            case f.Exists(variable, body) | f.ForAll(variable, body):
                if isinstance(formula, f.Exists) == truth:
                    return self._of_any_instance(variable, body, scope, state, truth)
                holding = mask_of(self._readings.witnesses(variable, body, scope, state))
                values = bits(state.scene.category(variable.category) & ~holding if truth else holding)
                instances = [(body, {**scope, variable.name: value}) for value in values]
                return self._of_parts(instances, state, truth, all_needed=True)
            case f.Atom():
                return self._of_atom(formula, scope, state, truth)
            case f.Equals():
                return _NOTHING
            case _:
                return frozenset(self.all_changes(formula))

    def _of_parts(
        self, parts: Sequence[tuple[f.Formula, Scope]], state: State, truth: bool, *, all_needed: bool
    ) -> ChangeSet:
        """Of a condition that is made of others: of one that is needed and fails, or else of any of them."""
        if not all_needed:
            return frozenset().union(
                *[self.find_changes(part, scope, state, truth=truth) for part, scope in parts]
            )
        best: ChangeSet = _NOTHING
        least = float("inf")
        for part, scope in parts:
            if self.holds(part, scope, state) != truth:
                found = self.find_changes(part, scope, state, truth=truth)
                number = sum([len(self.actions_making(change)) for change in found])
                if number < least:
                    best, least = found, number
                if least <= _FEW:
                    break
        return best

    def _of_any_instance(
        self, variable: f.Variable, body: f.Formula, scope: Scope, state: State, truth: bool
    ) -> ChangeSet:
        """Of a body for whatever value of its variable: of the part that fails for it."""
        left = state.scene.category(variable.category)
        found: set[FactChange] = set()
        for part, wanted in sorted(
            _conjuncts(body, truth), key=lambda part: self.count_read_predicates(part[0])
        ):
            holding = mask_of(self._readings.witnesses(variable, part, scope, state))
            holding = holding if wanted else ~holding
            values = list(bits(left & ~holding))
            left &= holding
            if len(values) > _FEW:
                found.update(self._patterns(part, {**scope, variable.name: None}, wanted))
            else:
                for value in values:
                    found |= self.find_changes(part, {**scope, variable.name: value}, state, truth=wanted)
        return frozenset(found)

    def count_read_predicates(self, formula: f.Formula) -> int:
        """How much a condition reads, which makes what is known of it less."""
        known = self._depths.get(id(formula))
        if known is None:
            names = find_stored_predicates(predicates_of(formula), self._domain.vocabulary)
            known = self._depths[id(formula)] = sum(name not in self._static for name in names), formula
        return known[0]

    def _patterns(
        self, formula: f.Formula, scope: Mapping[str, int | None], truth: bool
    ) -> Iterator[FactChange]:
        """The changes that may help a condition on any objects in the place of None."""
        vocabulary = self._domain.vocabulary
        for change in changes_towards(formula, scope, truth, vocabulary, self._object_named):
            if change.predicate not in self._static:
                yield change

    def _of_atom(self, atom: f.Atom, scope: Scope, state: State, truth: bool) -> ChangeSet:
        name = atom.predicate
        derived = self._domain.vocabulary.derived_by_name.get(name)
        arguments = arguments_of(atom, scope, self._initial.scene)
        if derived is None:
            return _NOTHING if name in self._static else frozenset((FactChange(name, arguments, truth),))
        defined = find_definition(derived)
        if defined is None:
            return frozenset(self.all_changes(atom))
        key = (name, arguments, truth)
        if key in self._open:  # nothing is so because it is so, but it may cease to be so with itself
            return _NOTHING if truth else frozenset(self.all_changes(atom))
        self._open.add(key)
        inner = dict(zip([p.name for p in defined.parameters], arguments, strict=True))
        found = self.find_changes(defined.definition, inner, state, truth=truth)
        self._open.discard(key)
        return found

    def all_changes(self, formula: f.Formula) -> Iterator[FactChange]:
        """All changes of what a condition reads."""
        return self._any(find_stored_predicates(predicates_of(formula), self._domain.vocabulary))

    def _any(self, names: Iterable[str]) -> Iterator[FactChange]:
        """All changes of stored predicates."""
        for name in names:
            if name not in self._static:
                anything = (None,) * (self._domain.vocabulary.arity(name) or 0)
                yield from (FactChange(name, anything, truth) for truth in (True, False))


def _conditions(schema: EffectSchema) -> list[tuple[f.Formula, frozenset[str]]]:
    """The conditions of an effect beside the operator's checks, with the names of their free variables."""
    found = (*schema.checks[len(schema.operator.checks) :], *schema.conditions)
    return [(each, free_variables(each)) for each in found]


def _closed(conditions: Iterable[tuple[f.Formula, Iterable[str]]], scope: Scope) -> list[ScopedCondition]:
    """The conditions all variables of which have a value."""
    return [(each, scope) for each, names in conditions if scope.keys() >= set(names)]


@cache
def remaining_condition(check: Check, checks: tuple[Check, ...]) -> f.Formula:
    """A check without the alternatives that the other checks of the operator deny."""
    condition = check.condition
    required = [each.condition for each in checks if each is not check]
    denied = [each.operand for each in required if isinstance(each, f.Not)]
    if not isinstance(condition, f.Or):
        return condition
    return f.Or(
        tuple([part for part in condition.operands if part not in denied and f.Not(part) not in required])
    )


def _conjuncts(formula: f.Formula, truth: bool) -> list[tuple[f.Formula, bool]]:
    """The parts of a condition all of which must have a truth for it to have its own."""
    match formula:
        case f.Not(operand):
            return _conjuncts(operand, not truth)
        case f.And(operands) | f.Or(operands) if isinstance(formula, f.And) == truth:
            return [part for operand in operands for part in _conjuncts(operand, truth)]
        case _:
            return [(formula, truth)]


def change_order(change: FactChange) -> tuple[str, tuple[int, ...], bool]:
    """The place of a change in a fixed order."""
    return change.predicate, tuple([-1 if i is None else i for i in change.arguments]), change.truth
