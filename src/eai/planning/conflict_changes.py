"""Changes of facts that may make a condition true or false, and the actions that make these changes.

If a condition is false in a state, at least one change of a certain set must happen before it can become true
(or the reverse). This set is called a disjunctive landmark of the state (Richter and Westphal 2010). It is
derived from the formula of the condition.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cache, cached_property
from typing import NamedTuple, TypeAlias

import eai.logic.formula as f
from eai.logic.traversal import find_free_variables, find_predicates
from eai.planning.achievers import AchieversByPredicate, generate_complete_bindings
from eai.planning.effect_schema import (
    EffectSchema,
    FactChange,
    find_changes_towards,
    find_predicates_with_incomplete_schemas,
    match_atom,
)
from eai.planning.search import SearchEffort
from eai.planning.subgoal import find_object, find_object_indices_of_arguments
from eai.planning.successor_generator import ACTION_BINDINGS
from eai.world.action import Action
from eai.world.condition import FormulaEvaluator, Scope
from eai.world.derived import find_definition, find_stored_dependencies
from eai.world.domain import Domain
from eai.world.fault import FaultKind
from eai.world.operator import Check
from eai.world.relation import iterate_bits, make_mask
from eai.world.state import State

ChangeSet: TypeAlias = frozenset[FactChange]
"""Set of changes of facts: at least one of them must happen. If the set is empty, no change can help."""

StepUndoesWantedChange: TypeAlias = bool
"""A truth value: whether a step makes the opposite of a wanted change of a fact."""

ScopedCondition: TypeAlias = tuple[f.Formula, Scope]
"""A condition, and a mapping from its free variables to objects."""

_NOTHING: ChangeSet = frozenset()
_FEW_ACTIONS = 4
"""Maximum number of actions for the changes of one part of a condition, so that no other part is examined.

It is also the maximum number of values of a variable that are examined one by one.
"""

_MAX_BINDINGS = 3_000_000
"""Maximum number of parameter values that are tried when the actions of one operator are listed."""


class _EffectOnFact(NamedTuple):
    """An effect of an action on a fact. It makes a wanted change of the fact, or the opposite change.

    Attributes:
        schema: the effect.
        scope: mapping from variables of the effect to objects. It has each variable whose object follows from
            the action's arguments or the fact.
        makes_change: True if the effect makes the wanted change, False if it makes the opposite change.
    """

    schema: EffectSchema
    scope: dict[str, int]
    makes_change: bool


class NecessaryChangeFinder:
    """Finds changes of facts that may make conditions true or false, and the actions that make them.

    One finder serves one episode.

    Args:
        domain: the domain.
        initial: any state of the episode; only its facts that never change are used.
        objects: the objects that actions may use, by index.
        achievers: the achievers of the domain.
    """

    def __init__(
        self, domain: Domain, initial: State, objects: Sequence[int], achievers: AchieversByPredicate
    ) -> None:
        self._domain = domain
        self._initial = initial
        self._usable = make_mask(objects)
        self._achievers = achievers
        self._static = {p.name for p in domain.vocabulary.predicates if p.static}
        self._schema_conditions: dict[int, list[tuple[f.Formula, frozenset[str]]]] = {}
        self._unread = {
            o.name: unread for o in domain.operators if (unread := find_predicates_with_incomplete_schemas(o))
        }
        # These dictionaries are caches: `functools.cache` on a method would keep the episode in memory.
        self._writers: dict[FactChange, tuple[Action, ...]] = {}
        self._taking: dict[str, tuple[Action, ...]] = {}
        self._indices: dict[tuple[str, int], dict[int, list[Action]]] = {}
        self._open: set[tuple[str, tuple[int, ...], bool]] = set()
        self._of_operator: dict[tuple[str, str, bool], list[EffectSchema]] = {}
        for (predicate, adds), schemas in achievers.by_effect.items():
            for schema in schemas:
                self._of_operator.setdefault((schema.operator.name, predicate, adds), []).append(schema)
        self._changed_by = {
            name: {schema.atom.predicate for schema in schemas} for name, schemas in achievers.schemas.items()
        }
        self._effects: dict[Action, dict[FactChange, Sequence[_EffectOnFact]]] = {}
        self._changes_of_predicates: dict[int, tuple[ChangeSet, f.Formula]] = {}
        self._depths: dict[int, tuple[int, f.Formula]] = {}
        self._readings = FormulaEvaluator(domain.vocabulary)
        self.holds = self._readings.holds
        self.names = self._readings.list_free_variables
        self.derived = domain.vocabulary.derived_by_name.get

    def clear_cached_effects(self) -> None:
        """Remove the effects of single actions from the cache, which grows with each new action."""
        self._effects.clear()

    def find_actions_making_any_change(self, changes: Iterable[FactChange]) -> dict[Action, None]:
        """Return the actions that may make any of the changes, in a fixed order, as keys of a dict."""
        return dict.fromkeys(
            action
            for change in sorted(changes, key=make_change_sort_key)
            for action in self.find_actions_making_change(change)
        )

    def find_actions_making_change(self, change: FactChange) -> tuple[Action, ...]:
        """Return all actions that may change a fact. Actions that static facts rule out are left out."""
        all_makers = self._writers.get(change)
        if all_makers is None:
            unread = [
                a
                for name in self._get_operators_with_incomplete_effect_schemas(change)
                for a in self.get_actions_of_operator(name)
            ]
            makers = [
                action for _, _, actions in self._find_schemas_making_change(change) for action in actions
            ]
            all_makers = self._writers[change] = tuple(dict.fromkeys([*unread, *makers]))
        return all_makers

    def group_actions_making_change_by_conditions(
        self, change: FactChange
    ) -> Iterator[tuple[Sequence[Action], list[ScopedCondition]]]:
        """Yield the actions that may change a fact, in groups with equal conditions.

        Each group is a pair: the actions, and the conditions of the effect that makes the change.
        """
        yield from (
            (self.get_actions_of_operator(name), [])
            for name in self._get_operators_with_incomplete_effect_schemas(change)
        )
        for schema, scope, actions in self._find_schemas_making_change(change):
            names = [parameter.name for parameter in schema.operator.parameters]
            needed = {name for condition in schema.conditions for name in self.names(condition)}
            positions = [i for i, name in enumerate(names) if name in needed and name not in scope]
            bound = {*scope, *names}
            conditions = [c for c in schema.conditions if bound.issuperset(self.names(c))]
            groups: dict[tuple[int, ...], list[Action]] = {}
            for action in actions:
                groups.setdefault(tuple([action.arguments[i] for i in positions]), []).append(action)
            for values, group in groups.items():
                inner = scope | {names[i]: value for i, value in zip(positions, values, strict=True)}
                yield group, [(condition, inner) for condition in conditions]

    def _get_operators_with_incomplete_effect_schemas(self, change: FactChange) -> list[str]:
        """Return the names of the operators that may change a fact by an effect without an `EffectSchema`.

        `make_effect_schemas` makes no schema if an effect reuses the name of an outer variable.
        """
        return [name for name, changed in self._unread.items() if change.predicate in changed]

    def _find_schemas_making_change(
        self, change: FactChange
    ) -> Iterator[tuple[EffectSchema, dict[str, int], Sequence[Action]]]:
        """Yield each effect schema that makes a change of a fact, with a binding and a list of actions.

        The binding maps variables to the objects that the change determines. The actions are those of the
        schema's operator with these objects.
        """
        for schema in self._achievers.by_effect.get((change.predicate, change.truth), ()):
            scope = match_atom(schema.atom, change.arguments, self._find_object_index)
            if scope is not None:
                parameters = enumerate(schema.operator.parameters)
                bound = [(i, scope[parameter.name]) for i, parameter in parameters if parameter.name in scope]
                yield schema, scope, self._select_actions_by_arguments(schema.operator.name, bound)

    def _select_actions_by_arguments(self, name: str, bound: Sequence[tuple[int, int]]) -> Sequence[Action]:
        if not bound:
            return self.get_actions_of_operator(name)
        position, index = bound[0]
        by_object = self._indices.get((name, position))
        if by_object is None:
            by_object = self._indices[name, position] = {}
            for action in self.get_actions_of_operator(name):
                by_object.setdefault(action.arguments[position], []).append(action)
        actions = by_object.get(index, [])
        if bound[1:]:
            return [a for a in actions if all(a.arguments[i] == o for i, o in bound[1:])]
        return actions

    def get_actions_of_operator(self, name: str) -> tuple[Action, ...]:
        """Return all actions of an operator, except actions that the unchanging facts rule out."""
        all_actions = self._taking.get(name)
        if all_actions is None:
            actions: dict[Action, None] = {}
            for achiever in self._achievers.get_operators_as_achievers([name]):
                partial = achiever.make_partial_variable_binding(
                    self._initial.scene, {}, only_static_conditions=True
                )
                effort = SearchEffort(_MAX_BINDINGS)
                for binding in generate_complete_bindings(self._initial, partial, self._usable, effort):
                    if effort.spend_and_check_limit(ACTION_BINDINGS):
                        break
                    actions[Action(name, achiever.get_operator_arguments(binding))] = None
            all_actions = self._taking[name] = tuple(actions)
        return all_actions

    @cached_property
    def has_operator_with_too_many_actions_to_list(self) -> bool:
        """Whether an operator has too many actions to list.

        Then no minimum number of edits of a plan is proved.
        """
        return any(
            ACTION_BINDINGS * self._usable.bit_count() ** operator.arity > _MAX_BINDINGS
            and self._has_too_many_actions_to_list(operator.name)
            for operator in self._domain.operators
        )

    def _has_too_many_actions_to_list(self, operator_name: str) -> bool:
        effort = SearchEffort(_MAX_BINDINGS)
        for achiever in self._achievers.get_operators_as_achievers([operator_name]):
            partial = achiever.make_partial_variable_binding(
                self._initial.scene, {}, only_static_conditions=True
            )
            for _ in generate_complete_bindings(self._initial, partial, self._usable, effort):
                if effort.spend_and_check_limit(ACTION_BINDINGS):
                    break
        return effort.is_limit_exceeded

    def may_make_change(self, action: Action, change: FactChange) -> bool:
        """Whether an action may make a change of a fact."""
        return next(self.find_effect_conditions(action, change), None) is not None

    def find_preconditions(self, action: Action) -> list[ScopedCondition]:
        """Return the conditions of an action's checks, each with a mapping from its variables to objects."""
        operator = self._domain.compiled_operators[action.operator].operator
        scope = operator.map_parameters(action.arguments)
        return [
            (simplify_check_given_other_checks(check, operator.checks), scope) for check in operator.checks
        ]

    def find_effect_conditions(self, action: Action, change: FactChange) -> Iterator[list[ScopedCondition]]:
        """Yield the conditions of each effect by which an action may change a fact.

        Conditions are omitted if they mention variables that neither the action nor the change binds.
        """
        if change.predicate in self._unread.get(action.operator, ()):
            yield []
        effect = action.operator, change.predicate, change.truth
        for schema in self._of_operator.get(effect, ()):
            scope = self._match_schema(schema, action, change)
            if scope is not None:
                conditions = self._schema_conditions.get(id(schema))
                if conditions is None:
                    conditions = self._schema_conditions[id(schema)] = _list_conditions_and_free_variables(
                        schema
                    )
                yield [(condition, scope) for condition, names in conditions if names <= scope.keys()]

    def find_changes_before_step_for_wanted_change(
        self, step: Action, state: State, wanted_change: FactChange, *, is_step_executed: bool
    ) -> tuple[ChangeSet, StepUndoesWantedChange]:
        """Return earlier changes of facts that may let a step make, or not undo, a wanted change.

        The returned changes come before the step. A step undoes the wanted change by making the opposite
        change. The second returned value is whether the step undoes the wanted change.

        Args:
            step: the step.
            state: the state before the step.
            wanted_change: the change that the step should make and not undo.
            is_step_executed: whether the step is executed in this state, not skipped.
        """
        earlier_changes: set[FactChange] = set()
        undoes = False
        for schema, scope, helps in self._find_effects_making_or_undoing(step, wanted_change):
            if helps and not is_step_executed:
                return self.find_changes_toggling_need_for_step(step, state, is_step_executed=False), False
            tried = schema.checks if schema.operator.alternatives else ()
            conditions = (*schema.conditions, *tried)
            closed_parts = [(c, scope) for c in conditions if scope.keys() >= set(self.names(c))]
            fails = any(not self.holds(*part, state) for part in closed_parts)
            if helps and fails:
                earlier_changes |= self._find_necessary_changes_for_parts(
                    closed_parts, state, True, all_needed=True
                )
            elif helps or (is_step_executed and not fails):
                for condition in conditions:
                    if not scope.keys() >= set(self.names(condition)):
                        earlier_changes |= self.find_all_fact_changes_of_predicates_in(condition)
                undoes = undoes or not helps
                if not helps:
                    earlier_changes |= self._find_necessary_changes_for_parts(
                        closed_parts, state, False, all_needed=False
                    )
        if undoes:
            earlier_changes |= self.find_changes_toggling_need_for_step(step, state, is_step_executed=True)
        return frozenset(earlier_changes), undoes

    def get_all_changes_if_schemas_are_incomplete(self, operator_name: str) -> ChangeSet:
        """Return all possible changes of facts if an operator's effect has no `EffectSchema`, else none."""
        names = [p.name for p in self._domain.vocabulary.predicates] if operator_name in self._unread else ()
        return frozenset(self._find_changes_of_predicates(names))

    def select_changes_step_makes_or_undoes(self, step: Action, changes: ChangeSet) -> list[FactChange]:
        """Return the changes in a set that a step may make, or may undo by making the opposite change."""
        predicates = self._changed_by[step.operator]
        return [
            change
            for change in changes
            if change.predicate in predicates and self._find_effects_making_or_undoing(step, change)
        ]

    def _find_effects_making_or_undoing(self, action: Action, change: FactChange) -> Sequence[_EffectOnFact]:
        effects_by_change = self._effects.setdefault(action, {})
        effects = effects_by_change.get(change)
        if effects is None:
            effects = effects_by_change[change] = tuple(
                [
                    _EffectOnFact(schema, scope, schema.adds == change.truth)
                    for schema in self._achievers.schemas[action.operator]
                    if (scope := self._match_schema(schema, action, change._replace(truth=schema.adds)))
                    is not None
                ]
            )
        return effects

    def find_changes_toggling_need_for_step(
        self, step: Action, state: State, *, is_step_executed: bool
    ) -> ChangeSet:
        """Return the changes of facts that may turn an executed step into a skipped step, or the reverse.

        A step is skipped if it is not needed in the state.
        """
        operator = self._domain.compiled_operators[step.operator].operator
        scope = operator.map_parameters(step.arguments)
        checks = [c.condition for c in operator.checks if c.fault is FaultKind.ADDITIONAL_STEP]
        wrong = [(c, scope) for c in checks if self.holds(c, scope, state) == is_step_executed]
        return self._find_necessary_changes_for_parts(wrong, state, not is_step_executed, all_needed=False)

    def _match_schema(
        self, schema: EffectSchema, action: Action, change: FactChange
    ) -> dict[str, int] | None:
        """Return a mapping from the variables of an effect schema to objects.

        With these objects the effect makes the change. The result is None if the action does not make the
        change by this effect.
        """
        if schema.adds != change.truth or schema.atom.predicate != change.predicate:
            return None
        scope = dict(zip(schema.variables, action.arguments, strict=False))
        return match_atom(schema.atom, change.arguments, self._find_object_index, scope)

    def _find_object_index(self, constant: f.Constant) -> int:
        return find_object(constant, self._initial.scene)

    def find_necessary_changes(
        self, formula: f.Formula, scope: Scope, state: State, *, truth: bool
    ) -> ChangeSet:
        """Return changes of facts; at least one of them must happen before a condition can become true.

        If ``truth`` is False: before the condition can become false.
        """
        match formula:
            case f.Not(operand):
                return self.find_necessary_changes(operand, scope, state, truth=not truth)
            case f.Implies(premise, conclusion):
                return self.find_necessary_changes(
                    f.Or((f.Not(premise), conclusion)), scope, state, truth=truth
                )
            case f.And(operands) | f.Or(operands):
                parts = [(operand, scope) for operand in operands]
                return self._find_necessary_changes_for_parts(
                    parts, state, truth, all_needed=isinstance(formula, f.And) == truth
                )
            case f.Exists(variable, body) | f.ForAll(variable, body):
                if isinstance(formula, f.Exists) == truth:
                    return self._find_necessary_changes_for_some_object(variable, body, scope, state, truth)
                holding = make_mask(self._readings.find_witnesses(variable, body, scope, state))
                values = iterate_bits(
                    state.scene.get_category_mask(variable.category) & ~holding if truth else holding
                )
                instances = [(body, {**scope, variable.name: value}) for value in values]
                return self._find_necessary_changes_for_parts(instances, state, truth, all_needed=True)
            case f.Atom():
                return self._find_necessary_changes_for_atom(formula, scope, state, truth)
            case f.Equals():
                return _NOTHING
            case _:
                return self.find_all_fact_changes_of_predicates_in(formula)

    def _find_necessary_changes_for_parts(
        self, parts: Sequence[tuple[f.Formula, Scope]], state: State, truth: bool, *, all_needed: bool
    ) -> ChangeSet:
        """Return changes of facts; one must happen before a compound condition can have the value ``truth``.

        If one part with this value is enough, the result has the changes for every part. If all parts need
        this value (``all_needed``), it has the changes for one failing part. This is the first part whose
        changes at most `_FEW_ACTIONS` actions make, or else the part with fewest such actions.
        """
        if not all_needed:
            return frozenset().union(
                *[self.find_necessary_changes(part, scope, state, truth=truth) for part, scope in parts]
            )
        best: ChangeSet = _NOTHING
        fewest = float("inf")
        for part, scope in parts:
            if self.holds(part, scope, state) != truth:
                changes = self.find_necessary_changes(part, scope, state, truth=truth)
                number = sum([len(self.find_actions_making_change(change)) for change in changes])
                if number < fewest:
                    best, fewest = changes, number
                if fewest <= _FEW_ACTIONS:
                    break
        return best

    def _find_necessary_changes_for_some_object(
        self, variable: f.Variable, body: f.Formula, scope: Scope, state: State, truth: bool
    ) -> ChangeSet:
        """Return changes. At least one must happen before a quantified formula can have the value ``truth``.

        The formula gets this value if its body has the value for at least one object.
        """
        remaining = state.scene.get_category_mask(variable.category)
        changes: set[FactChange] = set()
        for part, part_truth in sorted(
            _split_conjuncts(body, truth), key=lambda part: self.count_predicates_changed_by_actions(part[0])
        ):
            holding = make_mask(self._readings.find_witnesses(variable, part, scope, state))
            holding = holding if part_truth else ~holding
            values = list(iterate_bits(remaining & ~holding))
            remaining &= holding
            if len(values) > _FEW_ACTIONS:
                changes.update(
                    self._find_possible_changes_towards(part, {**scope, variable.name: None}, part_truth)
                )
            else:
                for value in values:
                    changes |= self.find_necessary_changes(
                        part, {**scope, variable.name: value}, state, truth=part_truth
                    )
        return frozenset(changes)

    def count_predicates_changed_by_actions(self, formula: f.Formula) -> int:
        """Count the predicates that a condition reads and that actions change.

        Conditions that read few such predicates are examined first.
        """
        cached = self._depths.get(id(formula))
        if cached is None:
            names = find_stored_dependencies(find_predicates(formula), self._domain.vocabulary)
            cached = self._depths[id(formula)] = sum(name not in self._static for name in names), formula
        return cached[0]

    def _find_possible_changes_towards(
        self, formula: f.Formula, scope: Mapping[str, int | None], truth: bool
    ) -> Iterator[FactChange]:
        """Yield the changes of facts that may give a condition the value ``truth``.

        A variable that ``scope`` maps to None stands for any object.
        """
        vocabulary = self._domain.vocabulary
        for change in find_changes_towards(formula, scope, truth, vocabulary, self._find_object_index):
            if change.predicate not in self._static:
                yield change

    def _find_necessary_changes_for_atom(
        self, atom: f.Atom, scope: Scope, state: State, truth: bool
    ) -> ChangeSet:
        name = atom.predicate
        derived = self._domain.vocabulary.derived_by_name.get(name)
        arguments = find_object_indices_of_arguments(atom, scope, self._initial.scene)
        if derived is None:
            return _NOTHING if name in self._static else frozenset((FactChange(name, arguments, truth),))
        defined = find_definition(derived)
        if defined is None:
            return self.find_all_fact_changes_of_predicates_in(atom)
        key = (name, arguments, truth)
        if key in self._open:  # an atom cannot become true by a definition that needs the atom itself
            return _NOTHING if truth else self.find_all_fact_changes_of_predicates_in(atom)
        self._open.add(key)
        inner = dict(zip([p.name for p in defined.parameters], arguments, strict=True))
        changes = self.find_necessary_changes(defined.definition, inner, state, truth=truth)
        self._open.discard(key)
        return changes

    def find_all_fact_changes_of_predicates_in(self, formula: f.Formula) -> ChangeSet:
        """Return all possible changes of facts of the predicates that a condition reads."""
        cached = self._changes_of_predicates.get(id(formula))
        if cached is None:
            names = find_stored_dependencies(find_predicates(formula), self._domain.vocabulary)
            changes = frozenset(self._find_changes_of_predicates(names))
            cached = self._changes_of_predicates[id(formula)] = changes, formula
        return cached[0]

    def _find_changes_of_predicates(self, predicate_names: Iterable[str]) -> Iterator[FactChange]:
        for name in predicate_names:
            if name not in self._static:
                anything = (None,) * (self._domain.vocabulary.find_arity(name) or 0)
                yield from (FactChange(name, anything, truth) for truth in (True, False))


def _list_conditions_and_free_variables(schema: EffectSchema) -> list[tuple[f.Formula, frozenset[str]]]:
    conditions = (*schema.checks[len(schema.operator.checks) :], *schema.conditions)
    return [(condition, find_free_variables(condition)) for condition in conditions]


@cache
def simplify_check_given_other_checks(check: Check, operator_checks: tuple[Check, ...]) -> f.Formula:
    """Return the condition of a check, without disjuncts that contradict the operator's other checks."""
    condition = check.condition
    required = [other.condition for other in operator_checks if other is not check]
    denied = [other.operand for other in required if isinstance(other, f.Not)]
    if not isinstance(condition, f.Or):
        return condition
    return f.Or(
        tuple([part for part in condition.operands if part not in denied and f.Not(part) not in required])
    )


def _split_conjuncts(formula: f.Formula, truth: bool) -> list[tuple[f.Formula, bool]]:
    """Return pairs of a part of a condition and the truth value that the part must have.

    The condition has the value ``truth`` if and only if each part has its value.
    """
    match formula:
        case f.Not(operand):
            return _split_conjuncts(operand, not truth)
        case f.And(operands) | f.Or(operands) if isinstance(formula, f.And) == truth:
            return [part for operand in operands for part in _split_conjuncts(operand, truth)]
        case _:
            return [(formula, truth)]


def make_change_sort_key(change: FactChange) -> tuple[str, tuple[int, ...], bool]:
    """Return a key that sorts changes of facts in a fixed order."""
    return change.predicate, tuple([-1 if i is None else i for i in change.arguments]), change.truth
