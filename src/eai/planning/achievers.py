"""Achievers: the effects of operators that make an atom true or false, and the conditions of these effects.

A ground atom binds some variables of an achiever. Facts that no action changes restrict the other variables.
These facts are the same in all states of a search, so the achievers of each atom are computed only once.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cache
from itertools import islice
from typing import NamedTuple, TypeAlias

import eai.logic.formula as f
from eai.logic.traversal import find_free_variables, find_predicates, walk_subformulas
from eai.planning.effect_schema import (
    EffectSchema,
    find_predicates_with_incomplete_schemas,
    make_effect_schemas,
    make_schema_without_effect,
    match_atom,
)
from eai.planning.search import SearchEffort
from eai.planning.subgoal import GroundAtom, Subgoal, find_object, find_object_indices_of_arguments
from eai.world.action import Action
from eai.world.condition import ConditionCompiler
from eai.world.derived import DefinedPredicate, LookupPredicate
from eai.world.domain import Domain
from eai.world.frame import UNBOUND, ConditionTest, ObjectBySlot, ObjectFilter, SlotAllocator
from eai.world.operator import Operator
from eai.world.relation import iterate_bits
from eai.world.state import Fact, Scene, State, compare_states
from eai.world.vocabulary import Vocabulary


class _UnboundVariable(NamedTuple):
    """A variable of an effect without an object so far, and the conditions on its object.

    A mask condition (`_can_evaluate_by_masks`) is evaluated for all objects at once. Any other condition is
    tested object by object.

    Attributes:
        slot: the slot of the variable (its position in a binding).
        is_parameter: whether the variable is a parameter of the operator. If so, its object must be one that
            actions may use.
        independent: mask conditions without other unbound variables.
        masks: mask conditions with other unbound variables, which get their objects earlier.
        tests: all other conditions.
    """

    slot: int
    is_parameter: bool
    independent: tuple[ObjectFilter, ...]
    masks: tuple[ObjectFilter, ...]
    tests: tuple[ConditionTest, ...]


class _UnboundVariableBinder(NamedTuple):
    """A procedure that finds objects for an effect's unbound variables: those without an object so far.

    Attributes:
        first: the conditions that must hold and that mention no unbound variables.
        steps: the unbound variables, in the order in which they are bound.
        needed: the conditions that actions can establish and that mention no unbound variables.
    """

    first: tuple[ConditionTest, ...]
    steps: tuple[_UnboundVariable, ...]
    needed: tuple[ConditionTest, ...]


class _PartialVariableBinding(NamedTuple):
    """An incomplete binding of the variables of an effect, and the procedure that completes the binding."""

    binding: ObjectBySlot
    join: _UnboundVariableBinder


class _GroundCondition(NamedTuple):
    """A condition of a ground action, as a subgoal.

    Attributes:
        subgoal: the condition.
        atom: the atom of a stored predicate that the condition demands; None for other conditions.
    """

    subgoal: Subgoal
    atom: GroundAtom | None


class Achiever:
    """A compiled effect of an operator. The effect makes atoms of a predicate true, or makes them false.

    Args:
        schema: the effect.
        vocabulary: the vocabulary of the domain.
        with_subgoals_on_parameters_not_in_atom: whether the effect's conditions on operator parameters
            outside the atom become subgoals, which other actions may establish. If False, only conditions
            whose variables are all in the atom become subgoals.

    Attributes:
        schema: the effect.
        conditions: the conditions that actions can establish if they do not hold, in order. Each is a pair of
            the formula and a function that tests it.
        open_variables: number of the effect's variables that the atom does not determine.
        reads_single_facts: whether each of `conditions` is about one stored fact.
        is_fixed: whether the possible bindings depend only on facts that no action changes.
    """

    def __init__(
        self,
        schema: EffectSchema,
        vocabulary: Vocabulary,
        *,
        with_subgoals_on_parameters_not_in_atom: bool = False,
    ) -> None:
        self.schema = schema
        self._vocabulary = vocabulary
        self._frame = SlotAllocator([f.Variable(name) for name in schema.variables])
        self._compiler = ConditionCompiler(vocabulary, self._frame)
        self._joins: dict[tuple[str, ...], tuple[_UnboundVariableBinder, _UnboundVariableBinder]] = {}
        self.open_variables = len(set(schema.variables) - _find_atom_variables(schema))
        own_conditions = _find_conditions_that_become_subgoals(
            schema, with_subgoals_on_parameters_not_in_atom=with_subgoals_on_parameters_not_in_atom
        )
        others = [c for c in schema.conditions if c not in own_conditions]
        needed = [c for c in (*own_conditions, *schema.checks) if c != f.TRUE]
        fixed = [c for c in needed if _is_static_formula(c, vocabulary)]
        self._filters = (*fixed, *others)
        self._fixed = [c for c in self._filters if _is_static_formula(c, vocabulary)]
        self.is_fixed = len(self._fixed) == len(self._filters)
        self.conditions = tuple((c, self._compiler.compile_test(c)) for c in needed if c not in fixed)
        self._literals = [_find_atom_of_stored_predicate(c, vocabulary) for c, _ in self.conditions]
        self.reads_single_facts = all(literal is not None for literal in self._literals)

    def match_atom_arguments(self, arguments: tuple[int, ...], scene: Scene) -> dict[str, int] | None:
        """Return a mapping from variables to objects that gives the atom these arguments, or None."""
        return match_atom(self.schema.atom, arguments, lambda constant: find_object(constant, scene))

    def has_only_usable_arguments(self, scope: Mapping[str, int], usable_objects_mask: int) -> bool:
        """Whether each object that ``scope`` gives to a parameter of the operator is in a mask of objects."""
        names = [parameter.name for parameter in self.schema.operator.parameters]
        return all(usable_objects_mask >> scope[name] & 1 for name in names if name in scope)

    def generate_complete_bindings(
        self,
        state: State,
        scope: Mapping[str, int],
        usable_objects_mask: int,
        effort: SearchEffort | None = None,
    ) -> Iterator[ObjectBySlot]:
        """Yield all bindings of the effect's variables that meet the conditions outside `conditions`.

        The formulas in `conditions` need not hold, because other actions may establish them first.

        Args:
            state: the state.
            scope: mapping from the variables that have an object already to these objects.
            usable_objects_mask: the mask of the objects that actions may use.
            effort: counter of values tried for variables. At its limit, no more bindings are yielded.

        Yields:
            A binding of `schema.variables`: the same list each time, changed in place.
        """
        return generate_complete_bindings(
            state, self.make_partial_variable_binding(state.scene, scope), usable_objects_mask, effort
        )

    def make_partial_variable_binding(
        self,
        scene: Scene,
        object_by_bound_variable: Mapping[str, int],
        *,
        only_static_conditions: bool = False,
    ) -> _PartialVariableBinding:
        """Return a binding of some variables, with a procedure that finds objects for all other variables.

        Args:
            scene: the objects.
            object_by_bound_variable: mapping from the variables that have an object already to these objects.
            only_static_conditions: whether the procedure tests only conditions on facts that no action
                changes. Its results then hold in all states of an episode.
        """
        names = self.schema.variables
        unbound = tuple([name for name in names if name not in object_by_bound_variable])
        joins = self._joins.get(unbound)
        if joins is None:
            joins = (
                self._make_binding_procedure(unbound, self._filters),
                self._make_binding_procedure(unbound, self._fixed),
            )
            self._joins[unbound] = joins
        return _PartialVariableBinding(
            self._frame.bind_arguments(
                scene, [object_by_bound_variable.get(name, UNBOUND) for name in names]
            ),
            joins[only_static_conditions],
        )

    def ground_condition(self, index: int, binding: Sequence[int], scene: Scene) -> _GroundCondition:
        """Return one of `conditions`, given by its index, as a subgoal about the objects of a binding."""
        scope, literal = self.map_variables_to_objects(binding), self._literals[index]
        condition, _ = self.conditions[index]
        if literal is None:
            return _GroundCondition(Subgoal(condition, scope, True), None)
        arguments = find_object_indices_of_arguments(literal, scope, scene)
        atom = GroundAtom(literal.predicate, arguments, literal is condition)
        return _GroundCondition(Subgoal(condition, scope, True), atom)

    def map_variables_to_objects(self, binding: Sequence[int]) -> dict[str, int]:
        """Return a binding as a mapping from variables to objects."""
        return dict(zip(self.schema.variables, binding[1:], strict=False))

    def get_operator_arguments(self, binding: Sequence[int]) -> tuple[int, ...]:
        """Return an action's arguments: the objects that a binding gives to the operator's parameters."""
        return tuple(binding[1 : 1 + self.schema.operator.arity])

    def _make_binding_procedure(
        self, unbound_variables: tuple[str, ...], conditions: Sequence[f.Formula]
    ) -> _UnboundVariableBinder:
        scope = self._frame.scope
        pending = list(conditions)
        determined = set(self.schema.variables) - set(unbound_variables)
        bound = set(determined)
        first = [c for c in pending if find_free_variables(c) <= determined]
        pending = [c for c in pending if c not in first]
        steps: list[_UnboundVariable] = []
        for name in unbound_variables:
            bound.add(name)
            ready = [c for c in pending if find_free_variables(c) <= bound]
            pending = [c for c in pending if c not in ready]
            plain = [c for c in ready if _can_evaluate_by_masks(c, self._vocabulary)]
            own_conditions = [c for c in plain if find_free_variables(c) <= determined | {name}]
            step = _UnboundVariable(
                scope[name],
                scope[name] <= self.schema.operator.arity,
                tuple(self._compiler.compile_filter(c, scope[name], scope) for c in own_conditions),
                tuple(
                    self._compiler.compile_filter(c, scope[name], scope)
                    for c in plain
                    if c not in own_conditions
                ),
                tuple(self._compiler.compile_test(c) for c in ready if c not in plain),
            )
            steps.append(step)
        needed = tuple(holds for c, holds in self.conditions if find_free_variables(c) <= determined)
        return _UnboundVariableBinder(
            tuple(self._compiler.compile_test(c) for c in first), tuple(steps), needed
        )


def generate_complete_bindings(
    state: State,
    partial: _PartialVariableBinding,
    usable_objects_mask: int,
    effort: SearchEffort | None = None,
) -> Iterator[ObjectBySlot]:
    """Yield the bindings of all variables that an incomplete binding allows in a state.

    Args:
        state: the state.
        partial: the incomplete binding, with the conditions that complete bindings must meet.
        usable_objects_mask: the mask of the objects that actions may use.
        effort: counter of values tried for variables. If its limit is exceeded, no more bindings are yielded.
            None for no limit.
    """
    binding, join = [*partial.binding], partial.join
    for holds in join.first:
        if not holds(state, binding):
            return
    values: list[int] = []
    for step in join.steps:
        mask = usable_objects_mask if step.is_parameter else state.scene.everything
        for matching in step.independent:
            mask = matching(state, binding, mask)
        if not mask:
            return
        values.append(mask)
    yield from _bind_remaining_variables(state, binding, join.steps, values, effort or SearchEffort())


def _bind_remaining_variables(
    state: State,
    binding: ObjectBySlot,
    unbound_variables: Sequence[_UnboundVariable],
    value_masks: Sequence[int],
    effort: SearchEffort,
) -> Iterator[ObjectBySlot]:
    """Yield ``binding`` once for each way to give an object to every variable in ``unbound_variables``.

    ``value_masks`` has a mask of objects for each variable: only objects in the mask are tried.
    """
    if not unbound_variables:
        yield binding
        return
    step, mask = unbound_variables[0], value_masks[0]
    for matching in step.masks:
        mask = matching(state, binding, mask)
    for index in iterate_bits(mask):
        if effort.spend_and_check_limit():
            return
        binding[step.slot] = index
        if all(test(state, binding) for test in step.tests):
            yield from _bind_remaining_variables(
                state, binding, unbound_variables[1:], value_masks[1:], effort
            )
    binding[step.slot] = UNBOUND


class AchieversByPredicate:
    """The achievers of a domain: all effects of its operators, by the predicate that they change.

    Attributes:
        schemas: mapping from the name of each operator to its effects, in the order in which they are
            written.
        by_effect: mapping from a predicate, and whether atoms become true or false, to the effects.
        predicates_with_incomplete_schemas: names of the predicates that effects without a schema may change.
    """

    def __init__(self, domain: Domain) -> None:
        self._vocabulary = vocabulary = domain.vocabulary
        fixed = {predicate.name for predicate in vocabulary.predicates if predicate.static}
        self._fixed_unary = [slot for name, slot in vocabulary.unary_slots.items() if name in fixed]
        self._fixed_binary = [slot for name, slot in vocabulary.binary_slots.items() if name in fixed]
        self._fixed_tuples = [slot for name, slot in vocabulary.tuple_slots.items() if name in fixed]
        self._compiled = cache(self._compile_achievers)
        self.schemas = {o.name: tuple(make_effect_schemas(o)) for o in domain.operators}
        self.by_effect: dict[tuple[str, bool], list[EffectSchema]] = {}
        self._writers: dict[str, dict[str, Operator]] = {}
        self.predicates_with_incomplete_schemas = {
            p for o in domain.operators for p in find_predicates_with_incomplete_schemas(o)
        }
        self._taking = {o.name: Achiever(make_schema_without_effect(o), vocabulary) for o in domain.operators}
        self._matches: _AtomAchieverFinder | None = None
        for operator in domain.operators:
            for schema in self.schemas[operator.name]:
                self.by_effect.setdefault((schema.atom.predicate, schema.adds), []).append(schema)
                self._writers.setdefault(schema.atom.predicate, {})[operator.name] = operator

    def find_achievers(
        self, predicate: str, *, adding: bool, with_subgoals_on_parameters_not_in_atom: bool = False
    ) -> Sequence[Achiever]:
        """Return the effects (`Achiever`) that make atoms of a predicate true, or false, simplest first.

        Effects are sorted by the number of variables outside the atom, then by the number of conditions. With
        ``with_subgoals_on_parameters_not_in_atom``, a condition on operator parameters outside the atom
        becomes a subgoal if it fails. Then only effects with such a condition are returned.
        """
        return self._compiled(predicate, adding, with_subgoals_on_parameters_not_in_atom)

    def _compile_achievers(
        self, predicate: str, adding: bool, with_subgoals_on_parameters_not_in_atom: bool
    ) -> Sequence[Achiever]:
        schemas = self.by_effect.get((predicate, adding), ())
        suitable = [
            schema
            for schema in schemas
            if not with_subgoals_on_parameters_not_in_atom
            or _has_subgoals_on_parameters_not_in_atom(schema, self._vocabulary)
        ]
        achievers = [
            Achiever(
                schema,
                self._vocabulary,
                with_subgoals_on_parameters_not_in_atom=with_subgoals_on_parameters_not_in_atom,
            )
            for schema in suitable
        ]
        return sorted(achievers, key=_make_complexity_sort_key)

    def get_static_parts_of_state(self, state: State) -> Sequence[object]:
        """Return the parts of a state that no action changes. All states of one episode share them."""
        unary, binary, tuples = state.unary, state.binary, state.tuples
        return [
            *[unary[slot] for slot in self._fixed_unary],
            *[binary[slot] for slot in self._fixed_binary],
            *[tuples[slot] for slot in self._fixed_tuples],
        ]

    def get_operators_as_achievers(self, operator_names: Iterable[str]) -> list[Achiever]:
        """Return an `Achiever` for each named operator. It stands for the execution of any of its actions.

        The achiever has one binding for each action of the operator. Unknown names are skipped.
        """
        return [self._taking[name] for name in operator_names if name in self._taking]

    def get_atom_achiever_finder(self, state: State, usable_objects_mask: int) -> _AtomAchieverFinder:
        """Return the object that finds the effects that make ground atoms true or false in a state.

        The object is cached and serves all states with the same unchanging facts.

        Args:
            state: the state.
            usable_objects_mask: the mask of the objects that actions may use.
        """
        if self._matches is None or not self._matches.can_be_used_in_state(state, usable_objects_mask):
            self._matches = _AtomAchieverFinder(self, state, usable_objects_mask)
        return self._matches

    def find_changing_operators(self, predicates: Iterable[str]) -> list[Operator]:
        """Return the operators that change any of the predicates, in a fixed order."""
        operators = {name: op for p in predicates for name, op in self._writers.get(p, {}).items()}
        return list(operators.values())


def _make_complexity_sort_key(achiever: Achiever) -> tuple[int, int]:
    return achiever.open_variables, len(achiever.conditions)


def _find_atom_variables(schema: EffectSchema) -> set[str]:
    return {term.name for term in schema.atom.arguments if isinstance(term, f.Variable)}


def _find_conditions_that_become_subgoals(
    schema: EffectSchema, *, with_subgoals_on_parameters_not_in_atom: bool
) -> list[f.Formula]:
    """Return the conditions of an effect that become subgoals if they do not hold.

    These are the conditions whose variables are all in the effect's atom. With
    ``with_subgoals_on_parameters_not_in_atom``, they also include conditions on the operator's other
    parameters.
    """
    atom_variables = _find_atom_variables(schema)
    conditions = [c for c in schema.conditions if find_free_variables(c) <= atom_variables]
    if with_subgoals_on_parameters_not_in_atom:
        variables = (atom_variables | {p.name for p in schema.operator.parameters}) - schema.read_variables
        conditions += [
            c for c in schema.conditions if c not in conditions and find_free_variables(c) <= variables
        ]
    return conditions


def _has_subgoals_on_parameters_not_in_atom(schema: EffectSchema, vocabulary: Vocabulary) -> bool:
    own_conditions = _find_conditions_that_become_subgoals(
        schema, with_subgoals_on_parameters_not_in_atom=False
    )
    others = [
        c
        for c in _find_conditions_that_become_subgoals(schema, with_subgoals_on_parameters_not_in_atom=True)
        if c not in own_conditions
    ]
    return any(c != f.TRUE and not _is_static_formula(c, vocabulary) for c in others)


def _can_evaluate_by_masks(formula: f.Formula, vocabulary: Vocabulary) -> bool:
    """Whether a formula can be evaluated by masks, for all values of a variable at once.

    Its predicates must be stored, or lookup predicates with an ``inverse`` function. Its quantifiers must be
    existential, and must quantify a conjunction or an equality. Both sides of an equality must be variables.
    """
    return all(
        isinstance(part, f.Not | f.And | f.Or)
        or (isinstance(part, f.Exists) and isinstance(part.body, f.And | f.Equals))
        or (
            isinstance(part, f.Equals)
            and isinstance(part.left, f.Variable)
            and isinstance(part.right, f.Variable)
        )
        or (isinstance(part, f.Atom) and _can_evaluate_predicate_by_masks(part.predicate, vocabulary))
        for part in walk_subformulas(formula)
    )


def _can_evaluate_predicate_by_masks(name: str, vocabulary: Vocabulary) -> bool:
    if vocabulary.find_stored_predicate(name) is not None:
        return True
    derived = vocabulary.derived_by_name[name]
    if isinstance(derived, LookupPredicate):
        return derived.inverse is not None
    return (
        isinstance(derived, DefinedPredicate)
        and derived.values is None
        and _can_evaluate_by_masks(derived.definition, vocabulary)
    )


def _is_static_formula(formula: f.Formula, vocabulary: Vocabulary) -> bool:
    return all(_is_static_predicate(name, vocabulary) for name in find_predicates(formula))


def _find_atom_of_stored_predicate(condition: f.Formula, vocabulary: Vocabulary) -> f.Atom | None:
    """Return the atom of a stored predicate that a condition demands or denies; None for other conditions."""
    literal = condition.operand if isinstance(condition, f.Not) else condition
    is_stored = (
        isinstance(literal, f.Atom) and vocabulary.find_stored_predicate(literal.predicate) is not None
    )
    return literal if isinstance(literal, f.Atom) and is_stored else None


def _is_static_predicate(name: str, vocabulary: Vocabulary) -> bool:
    stored = vocabulary.find_stored_predicate(name)
    if stored is not None:
        return stored.static
    derived = vocabulary.derived_by_name[name]
    if isinstance(derived, DefinedPredicate):
        return derived.values is None and _is_static_formula(derived.definition, vocabulary)
    return False


_MAX_CACHED_BINDINGS = 512
"""Maximum number of cached bindings of one effect's variables with which the effect changes one ground atom.

If there are more such bindings, they are computed again in every state.
"""

_MAX_CACHED_ACTIONS = 60_000
"""Maximum number of ground actions whose conditions are cached for all states of a search."""

_MAX_BINDINGS = 100_000
"""Maximum number of variable values that are tried to find all ways in which an effect changes an atom."""


class _GroundAction:
    """A ground action with a wanted effect.

    Args:
        achiever: the effect.
        binding: the objects of the effect's variables.
        scene: the objects.

    Attributes:
        action: the action.
        atoms: the atoms that the conditions demand; empty if any condition is not about one stored fact.
        is_test_kept: whether the result of testing the action's conditions is kept for later states, until a
            fact in the conditions changes.
    """

    __slots__ = ("_achiever", "_binding", "_conditions", "_scene", "action", "atoms", "is_test_kept")

    def __init__(self, achiever: Achiever, binding: tuple[int, ...], scene: Scene) -> None:
        self.action = Action(achiever.schema.operator.name, achiever.get_operator_arguments(binding))
        self.atoms: Sequence[GroundAtom] = ()
        self.is_test_kept = False
        self._achiever = achiever
        self._binding = binding
        self._scene = scene
        self._conditions: list[_GroundCondition | None] = [None] * len(achiever.conditions)

    def find_failing_conditions(self, state: State) -> Sequence[_GroundCondition]:
        """Return the conditions of this action that fail in a state and that other actions can establish."""
        binding = [*self._binding]
        tests = enumerate(self._achiever.conditions)
        failing = [index for index, (_, holds) in tests if not holds(state, binding)]
        return [self._get_condition(index) for index in failing] if failing else ()

    def enable_caching_of_condition_tests(self, actions_by_fact: _ActionsByConditionFact) -> None:
        """Let test results of the action be cached, if each condition is about one stored fact.

        Caching other results would cost more. ``actions_by_fact`` maps a fact to the actions whose conditions
        read the fact; this action is added to it.
        """
        if self._achiever.reads_single_facts:
            self.is_test_kept = True
            atoms = [self._get_condition(index).atom for index in range(len(self._conditions))]
            self.atoms = [atom for atom in atoms if atom is not None]
            for atom in self.atoms:
                actions_by_fact.setdefault(Fact(atom.predicate, atom.arguments), []).append(self)

    def _get_condition(self, index: int) -> _GroundCondition:
        condition = self._conditions[index]
        if condition is None:
            condition = self._achiever.ground_condition(index, self._binding, self._scene)
            self._conditions[index] = condition
        return condition


GroundActions: TypeAlias = Iterable[_GroundAction]
"""The ground actions with a wanted effect in a state."""

FailingConditionsByAction: TypeAlias = dict[_GroundAction, Sequence[_GroundCondition]]
"""Mapping from tested ground actions to their conditions that fail in a state."""

_ActionsByConditionFact: TypeAlias = dict[Fact, list[_GroundAction]]
"""Mapping from a fact to the actions whose conditions read it."""


class _CandidateActions:
    """The ground actions with a wanted effect in a state. Each action is found when it is first needed."""

    __slots__ = ("_found", "_rest")

    def __init__(self, actions: Iterator[_GroundAction]) -> None:
        self._found: list[_GroundAction] = []
        self._rest = actions

    def __iter__(self) -> Iterator[_GroundAction]:
        yield from self._found
        for action in self._rest:
            self._found.append(action)
            yield action


class _PartlyBoundAchiever:
    """An operator's effect on a ground atom, which determines the objects of some of the effect's variables.

    Args:
        achiever: the compiled effect.
        partial: the binding of the variables that the atom determines.
        cached_bindings: all complete bindings; None if they must be searched in every state.
        readers: mapping from each fact to the cached actions that have a condition on the fact. New cached
            actions are added.
        cached_action_counter: counter of cached actions. At its limit, further actions are not cached.
    """

    __slots__ = (
        "_actions",
        "_cached_action_counter",
        "_cached_bindings",
        "_failing_count",
        "_partial",
        "_readers",
        "achiever",
    )

    def __init__(
        self,
        achiever: Achiever,
        partial: _PartialVariableBinding,
        cached_bindings: Sequence[tuple[int, ...]] | None,
        readers: _ActionsByConditionFact,
        cached_action_counter: SearchEffort,
    ) -> None:
        self.achiever = achiever
        self._partial = partial
        self._cached_bindings = cached_bindings
        self._readers = readers
        self._cached_action_counter = cached_action_counter
        self._actions: dict[tuple[int, ...], _GroundAction] = {}
        self._failing_count: tuple[State | None, int] = None, 0

    def generate_complete_bindings(
        self, state: State, usable_objects_mask: int, effort: SearchEffort | None = None
    ) -> Iterator[ObjectBySlot]:
        """Yield bindings of all variables of the operator's effect in a state.

        Each binding meets the conditions of the effect, except those that other actions may establish first
        (subgoals).
        """
        if self._cached_bindings is None:
            return generate_complete_bindings(state, self._partial, usable_objects_mask, effort)
        return map(list, self._cached_bindings)

    def has_min_number_of_failing_conditions(self, state: State, min_count: float) -> bool:
        """Whether at least ``min_count`` conditions without unbound variables fail in a state."""
        conditions = self._partial.join.needed
        if len(conditions) < min_count:
            return False
        tested_state, failing = self._failing_count  # another thread may replace the attribute
        if tested_state is not state:
            binding = [*self._partial.binding]
            failing = sum([not holds(state, binding) for holds in conditions])
            self._failing_count = state, failing
        return failing >= min_count

    def find_actions_that_may_have_effect(
        self, state: State, usable_objects_mask: int, effort: SearchEffort
    ) -> GroundActions:
        """Return the ground actions that may have the effect of this achiever in a state.

        Args:
            state: the state.
            usable_objects_mask: the mask of the objects that actions may use.
            effort: counter of values tried for variables. At its limit, no more actions follow.
        """
        bindings = self.generate_complete_bindings(state, usable_objects_mask, effort)
        return _CandidateActions(self._get_action(tuple(binding), state.scene) for binding in bindings)

    def list_cached_actions(self, scene: Scene) -> list[_GroundAction] | None:
        """Return all ground actions that may have the effect in any state, or None if they are not cached."""
        if self._cached_bindings is None:
            return None
        return [self._get_action(binding, scene) for binding in self._cached_bindings]

    def _get_action(self, binding: tuple[int, ...], scene: Scene) -> _GroundAction:
        action = self._actions.get(binding)
        if action is None:
            action = _GroundAction(self.achiever, binding, scene)
            if self._cached_bindings is not None or not self._cached_action_counter.spend_and_check_limit():
                self._actions[binding] = action
                action.enable_caching_of_condition_tests(self._readers)
        return action


class _AtomAchieverFinder:
    """Finds the effects that make ground atoms true or false.

    A finder serves all states of one scene whose static predicates have the same facts.

    Args:
        achievers: the achievers of the domain.
        state: any state that the finder serves.
        usable_objects_mask: the mask of the objects that actions may use.
    """

    def __init__(self, achievers: AchieversByPredicate, state: State, usable_objects_mask: int) -> None:
        self._achievers = achievers
        self._state = state
        self._usable = usable_objects_mask
        self._fixed = achievers.get_static_parts_of_state(state)
        self._found: dict[tuple[GroundAtom, bool], Sequence[_PartlyBoundAchiever]] = {}
        self._operators: dict[Achiever, _PartlyBoundAchiever] = {}
        self._cached_action_counter = SearchEffort(_MAX_CACHED_ACTIONS)
        self._readers: _ActionsByConditionFact = {}

    def remove_outdated_test_results(
        self, tests: FailingConditionsByAction, before: State, after: State
    ) -> None:
        """Remove the test results of each action that reads a fact which differs between two states."""
        change = compare_states(before, after)
        for fact in change.added + change.removed:
            for action in self._readers.get(fact, ()):
                tests.pop(action, None)

    def can_be_used_in_state(self, state: State, usable_objects_mask: int) -> bool:
        """Whether this finder may be used for a state if actions may use the objects of a mask."""
        return (
            self._state.scene is state.scene
            and self._usable == usable_objects_mask
            and self._fixed == self._achievers.get_static_parts_of_state(state)
        )

    def find_achievers_of_atom(
        self, atom: GroundAtom, *, with_subgoals_on_parameters_not_in_atom: bool = False
    ) -> Sequence[_PartlyBoundAchiever]:
        """Return the achievers of an atom, simplest first: the effects that can make the atom true, or false.

        The atom's predicate is stored. The objects of the atom are bound to the variables of each effect.
        """
        matches = self._found.get((atom, with_subgoals_on_parameters_not_in_atom))
        if matches is None:
            matches = self._found[atom, with_subgoals_on_parameters_not_in_atom] = (
                self._compute_achievers_of_atom(
                    atom, with_subgoals_on_parameters_not_in_atom=with_subgoals_on_parameters_not_in_atom
                )
            )
        return matches

    def list_actions_towards_atom(self, atom: GroundAtom) -> list[_GroundAction] | None:
        """Return the ground actions that may give an atom its wanted truth in some state; None if unknown."""
        groups = [match.list_cached_actions(self._state.scene) for match in self.find_achievers_of_atom(atom)]
        is_unknown = atom.predicate in self._achievers.predicates_with_incomplete_schemas or None in groups
        return None if is_unknown else [action for group in groups if group for action in group]

    def make_reachable_action_finder(self, start: State) -> _ReachableActionFinder:
        """Return a new object that finds the actions that may become possible after a state."""
        return _ReachableActionFinder(self, start)

    def _compute_achievers_of_atom(
        self, atom: GroundAtom, *, with_subgoals_on_parameters_not_in_atom: bool
    ) -> Sequence[_PartlyBoundAchiever]:
        matches: list[_PartlyBoundAchiever] = []
        for achiever in self._achievers.find_achievers(
            atom.predicate,
            adding=atom.truth,
            with_subgoals_on_parameters_not_in_atom=with_subgoals_on_parameters_not_in_atom,
        ):
            scope = achiever.match_atom_arguments(atom.arguments, self._state.scene)
            if scope is not None and achiever.has_only_usable_arguments(scope, self._usable):
                fixed = achiever.make_partial_variable_binding(
                    self._state.scene, scope, only_static_conditions=True
                )
                max_bindings = _MAX_CACHED_BINDINGS + 1 if achiever.is_fixed else 1
                effort = SearchEffort(_MAX_BINDINGS)
                completions = generate_complete_bindings(self._state, fixed, self._usable, effort)
                bindings = [tuple(b) for b in islice(completions, max_bindings)]
                if bindings or effort.is_limit_exceeded:
                    partial = achiever.make_partial_variable_binding(self._state.scene, scope)
                    is_whole = (
                        len(bindings) < max_bindings
                        and not effort.is_limit_exceeded
                        and not self._cached_action_counter.spend_and_check_limit(len(bindings))
                    )
                    cached = bindings if is_whole else None
                    matches.append(
                        _PartlyBoundAchiever(
                            achiever, partial, cached, self._readers, self._cached_action_counter
                        )
                    )
        return matches

    def get_achievers_of_operators(self, operator_names: Iterable[str]) -> Sequence[_PartlyBoundAchiever]:
        """Return, for each named operator, an object that finds all ground actions of the operator."""
        matches = []
        for achiever in self._achievers.get_operators_as_achievers(operator_names):
            if achiever not in self._operators:
                partial = achiever.make_partial_variable_binding(self._state.scene, {})
                self._operators[achiever] = _PartlyBoundAchiever(
                    achiever, partial, None, self._readers, self._cached_action_counter
                )
            matches.append(self._operators[achiever])
        return matches


class _ReachableActionFinder:
    """Finds the ground actions that may become possible after a state, if facts are only added, never undone.

    All other actions are impossible in each state that is reached from this state.

    Args:
        achievers: finds the effects that make ground atoms true or false.
        start: the state.
    """

    def __init__(self, achievers: _AtomAchieverFinder, start: State) -> None:
        self._achievers = achievers
        self._start = start
        self._actions_by_achiever: dict[_PartlyBoundAchiever, Sequence[_GroundAction] | None] = {}
        self._is_reachable: dict[GroundAtom, bool] = {}

    def find_reachable_actions(self, achiever: _PartlyBoundAchiever) -> Sequence[_GroundAction] | None:
        """Return the reachable actions of an achiever, or None if its actions depend on the state."""
        if achiever not in self._actions_by_achiever:
            actions = achiever.list_cached_actions(self._start.scene)
            if actions is not None:
                self._decide_reachability([atom for action in actions for atom in action.atoms])
                actions = [action for action in actions if self._may_become_possible(action)]
            self._actions_by_achiever[achiever] = actions
        return self._actions_by_achiever[achiever]

    def _may_become_possible(self, action: _GroundAction) -> bool:
        return all(map(self._is_reachable.__getitem__, action.atoms))

    def _decide_reachability(self, atoms: list[GroundAtom]) -> None:
        """Decide which atoms, and which atoms that they depend on, are reachable. Empties the list."""
        actions_towards: dict[GroundAtom, list[_GroundAction]] = {}
        while atoms:
            atom = atoms.pop()
            if atom in self._is_reachable:
                continue
            holds = self._start.has(atom.predicate, *atom.arguments) is atom.truth
            actions = None if holds else self._achievers.list_actions_towards_atom(atom)
            self._is_reachable[atom] = actions is None
            if actions is not None:
                actions_towards[atom] = actions
                atoms += [part for action in actions for part in action.atoms]
        count = -1
        while len(actions_towards) != count:
            count = len(actions_towards)
            for atom in reversed([*actions_towards]):
                if any(map(self._may_become_possible, actions_towards[atom])):
                    self._is_reachable[atom] = True
                    del actions_towards[atom]
