"""An index of a domain's operators: for each operator its role in a search, its conditions and its effects.

The index depends only on the declaration of the domain, so one index serves all scenes. Results about a
predicate are computed on the first request and cached. Results about a literal depend on whether it is
negated, and on which of its objects are equal. Threads that compute a result at the same time get equal
results.

The index knows only operators. A `CandidateAction` is an operator with objects, and belongs to one search.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from enum import Enum
from functools import cache
from itertools import islice, permutations, product
from typing import NamedTuple, TypeAlias

from eai.logic.formula import Atom, Constant, Formula, Not, Variable
from eai.logic.traversal import find_free_variables, find_predicates
from eai.planning.achievers import Achiever, generate_complete_bindings
from eai.planning.effect_schema import (
    EffectSchema,
    FactChange,
    find_changed_predicates,
    find_changes_for_literal,
    make_effect_schemas,
    make_schema_without_effect,
    match_atom,
)
from eai.planning.role import infer_operator_role
from eai.planning.search import Limits, SearchEffort
from eai.planning.subgoal import GroundAtom
from eai.world.action import Action
from eai.world.condition import ConditionCompiler, combine_tests_by_and
from eai.world.derived import find_stored_dependencies
from eai.world.domain import Domain
from eai.world.executable import CompiledOperator
from eai.world.fault import FaultKind
from eai.world.frame import AGENT, UNBOUND, ConditionTest, ObjectBySlot, SlotAllocator
from eai.world.operator import Check, Operator, OperatorRole
from eai.world.relation import make_mask
from eai.world.state import Scene, State

LiteralBits: TypeAlias = int
"""Set of a subgoal's literals: a bit mask in which bit i stands for literal i."""

Holds: TypeAlias = Callable[[State], bool]
"""Function that tests a condition in a state."""

_AGENT = 0
"""Number that stands for the agent in an `_OperatorPattern`.

The objects of the pattern's literal have numbers from 1 on.
"""

_MAX_FITTING_ACTIONS = 10_000
"""Maximum number of actions of one operator that are found for one literal.

The limit matters only if the literal leaves some parameters open, for which many objects are tried.
"""


MAX_LISTED_ACTIONS = 100_000
"""Maximum number of actions of one operator that a search lists."""


class _PreconditionCheckKind(Enum):
    """Kinds of checks of an operator, by the actions that can change the truth value of the check.

    `FIXED`: no action can change it. `COMMON`: some action can change it, but it is common to all actions by
    the operator, because it depends neither on their objects nor on the agent's position. `REST`: all other
    checks.
    """

    FIXED = "fixed"
    COMMON = "common"
    REST = "rest"


class _OperatorForSearch(NamedTuple):
    """An operator with the information that a search needs.

    Attributes:
        operator: the compiled operator.
        role: the operator's role in a search, such as movement.
        movable: for each check whether movement can change its truth value. One more item at the end says the
            same of the conditions of the operator's alternatives (`OperatorAlternative`), taken together.
        fixable: for each check whether movement can make the check true and so the action possible. It is
            False for a check whose failure means that the action is needless. The one more item at the end,
            for the alternatives, is always False.
        static_checks_hold: tests in a state whether all `FIXED` checks hold.
        common_checks_hold: tests in a state whether all `COMMON` checks hold.
        rest_checks_hold: tests in a state whether all `REST` checks hold. If the operator has alternatives,
            it tests whether the complete action is possible.
        unmovable_checks_hold: tests in a state whether those `REST` checks hold that movement cannot make
            true. Checks of alternatives are not tested.
    """

    operator: CompiledOperator
    role: OperatorRole
    movable: tuple[bool, ...]
    fixable: tuple[bool, ...]
    static_checks_hold: ConditionTest
    common_checks_hold: ConditionTest
    rest_checks_hold: ConditionTest
    unmovable_checks_hold: ConditionTest


_OperatorPattern: TypeAlias = tuple[str, tuple[int | None, ...]]
"""A pair: the name of an operator that may make a literal true, and a number or None for each argument.

The number stands for an object of the literal, or for the agent. None means that the literal does not
determine the argument.
"""


class OperatorIndex:
    """Finds the operators of a domain that change a predicate, or that make other operators possible.

    Args:
        domain: the domain.

    Attributes:
        operators: mapping from names to operators.
        movement: the operators that move the agent. Several operators with equal checks and effects are
            represented by the first.
        with_tools: names of operators that use a tool: an object that their effects do not mention. They do
            not move the agent.
        find_operators_that_change: returns the operators that change a predicate (cached).
        find_enabling_hand_and_movement_operators: takes names of operators, and returns the operators that
            can make these operators possible (cached).
    """

    def __init__(self, domain: Domain) -> None:
        self._domain = domain
        self._effects = {o.name: tuple(make_effect_schemas(o)) for o in domain.operators}
        self._writes = {o.name: frozenset(find_changed_predicates(o)) for o in domain.operators}
        self._checks = {
            o.name: self._find_stored_dependencies(_list_conditions_of_all_checks(o))
            for o in domain.operators
        }
        self._asks = {
            name: self._checks[name]
            | self._find_stored_dependencies([f for effect in effects for f in effect.conditions])
            for name, effects in self._effects.items()
        }
        self.movement = _drop_duplicates(
            [o for o in domain.operators if infer_operator_role(o) is OperatorRole.MOVEMENT]
        )
        self.with_tools = frozenset(
            [
                o.name
                for o in domain.operators
                if infer_operator_role(o) is not OperatorRole.MOVEMENT
                and self._find_parameters_without_effects(o)
            ]
        )
        self._moved = frozenset[str]().union(*[self._writes[o.name] for o in self.movement])
        self._changed = frozenset[str]().union(*self._writes.values())
        self.operators = {
            operator.name: self._make_operator_for_search(operator) for operator in domain.operators
        }
        self.find_operators_that_change = cache(self._find_operators_that_change)
        self.find_enabling_hand_and_movement_operators = cache(
            self._find_enabling_hand_and_movement_operators
        )
        self._cached_patterns = cache(self._find_patterns_of_achieving_operators)
        self._compiled = cache(self._compile_literal_test)
        self._taking = cache(
            lambda name: Achiever(
                make_schema_without_effect(self.operators[name].operator.operator), domain.vocabulary
            )
        )

    def _find_parameters_without_effects(self, operator: Operator) -> set[Variable]:
        return {*operator.parameters}.difference(
            *[effect.atom.arguments for effect in self._effects[operator.name]]
        )

    def _find_operators_that_change(self, predicate: str) -> Sequence[Operator]:
        """Return the operators that change a predicate, in declared order.

        For a derived predicate, these operators change the stored predicates in its definition.
        """
        sources = self._find_stored_dependencies([Atom(predicate)])
        return [o for o in self._domain.operators if not self._writes[o.name].isdisjoint(sources)]

    def map_operators_to_changeable_literals(self, literals: Sequence[GroundAtom]) -> dict[str, LiteralBits]:
        """Return a mapping from names of operators to the literals that each can change, as a bit mask."""
        touched: dict[str, int] = {}
        for i, literal in enumerate(literals):
            for operator in self.find_operators_that_change(literal.predicate):
                touched[operator.name] = touched.get(operator.name, 0) | 1 << i
        return touched

    def make_literal_test(self, literal: GroundAtom, scene: Scene) -> Holds:
        """Return a function that tests a literal in a state. Each predicate is compiled only once."""
        frame, truth = self._compiled(literal.predicate, len(literal.arguments), literal.truth)
        binding = frame.bind_arguments(scene, literal.arguments)
        # each test gets a copy of the list, because quantifiers write the object that they test into it
        return lambda state: truth(state, [*binding])

    def _compile_literal_test(
        self, predicate: str, arity: int, expected_truth: bool
    ) -> tuple[SlotAllocator, ConditionTest]:
        variables = tuple([Variable(f"argument {i}") for i in range(arity)])
        frame, atom = SlotAllocator(variables), Atom(predicate, variables)
        return frame, ConditionCompiler(self._domain.vocabulary, frame).compile_test(
            atom if expected_truth else Not(atom)
        )

    def map_achieving_actions_to_literals(
        self,
        literals: Sequence[GroundAtom],
        scene: Scene,
        objects_for_open_parameters: Sequence[int] = (),
        state_for_static_checks: State | None = None,
    ) -> dict[Action, LiteralBits]:
        """Return a mapping from actions to bit masks of the literals that each action may make true.

        The arguments of an action are different objects. They are objects of one literal or, for parameters
        that the literal does not determine, any of ``objects_for_open_parameters``. For a literal about the
        agent, only movements are returned, if there are any.

        Args:
            literals: the literals.
            scene: the scene.
            objects_for_open_parameters: objects for parameters that a literal does not determine.
            state_for_static_checks: a state or None. If it is a state, an action may have the same object
                twice, and the result has only actions whose fixed checks hold in the state. No action can
                change the result of a fixed check.
        """
        wanted: dict[Action, int] = {}
        for i, literal in enumerate(literals):
            for action in self._list_achieving_actions(
                literal, scene, objects_for_open_parameters, state_for_static_checks
            ):
                wanted[action] = wanted.get(action, 0) | 1 << i
        return wanted

    def _list_achieving_actions(
        self,
        literal: GroundAtom,
        scene: Scene,
        objects_for_open_parameters: Sequence[int],
        state_for_static_checks: State | None,
    ) -> Iterable[Action]:
        named = list_objects_in_argument_tuples([literal.arguments], scene)
        objects = list_objects_in_argument_tuples([named, objects_for_open_parameters], scene)
        agent = UNBOUND if scene.agent is None else scene.agent
        values = (agent, *named)
        literal_with_argument_numbers = literal._replace(
            arguments=tuple([values.index(i) for i in literal.arguments])
        )
        actions: dict[Action, None] = {}
        for operator, numbers in self._cached_patterns(literal_with_argument_numbers):
            given = [None if number is None else values[number] for number in numbers]
            if state_for_static_checks is None:
                argument_tuples = [*islice(_generate_argument_tuples(given, objects), MAX_LISTED_ACTIONS)]
            else:
                argument_tuples = self._find_possible_arguments(
                    operator, given, objects, state_for_static_checks
                )
            actions |= {
                Action(operator, arguments): None for arguments in argument_tuples if agent not in arguments
            }
        moving = [
            action for action in actions if self.operators[action.operator].role is OperatorRole.MOVEMENT
        ]
        return moving if moving and agent in literal.arguments else actions

    def _find_possible_arguments(
        self, operator: str, decided_arguments: Sequence[int | None], objects: Sequence[int], state: State
    ) -> list[tuple[int, ...]]:
        """Return the tuples of arguments with which an operator's fixed checks hold.

        No action can change the result of a fixed check. ``decided_arguments`` has the object of each
        argument that is already decided, and None for all other arguments.
        """
        taken = self._taking(operator)
        scope = {
            p: i for p, i in zip(taken.schema.variables, decided_arguments, strict=True) if i is not None
        }
        usable = make_mask(objects)
        partial = taken.make_partial_variable_binding(state.scene, scope, only_static_conditions=True)
        effort = SearchEffort(Limits().bindings)
        bindings = generate_complete_bindings(state, partial, usable, effort)
        return [taken.get_operator_arguments(binding) for binding in islice(bindings, _MAX_FITTING_ACTIONS)]

    def _find_patterns_of_achieving_operators(
        self, literal_with_argument_numbers: GroundAtom
    ) -> Sequence[_OperatorPattern]:
        changes = find_changes_for_literal(
            literal_with_argument_numbers, self._domain.vocabulary, _get_object_number_if_agent
        )
        patterns: dict[_OperatorPattern, None] = {}
        for operator in self.find_operators_that_change(literal_with_argument_numbers.predicate):
            for effect, change in product(self._effects[operator.name], changes):
                scope = _match_effect_to_change(effect, change)
                if scope is not None:
                    patterns[operator.name, tuple([scope.get(p.name) for p in operator.parameters])] = None
        return tuple(patterns)

    def _find_enabling_hand_and_movement_operators(
        self, operators_to_enable: frozenset[str]
    ) -> tuple[Sequence[Operator], Sequence[str]]:
        """Return the operators that can make some operators possible, directly or through further operators.

        The first result has the operators that take or release objects. The second result has the names of
        the operators that move the agent.
        """
        operators = self._domain.operators
        asking = [operator for operator in operators if operator.name in operators_to_enable]
        hands = [
            o for o in operators if self.operators[o.name].role in (OperatorRole.TAKES, OperatorRole.RELEASES)
        ]
        helping = self._select_enabling_operators(asking, hands, self._asks)
        movement = self._select_enabling_operators([*asking, *helping], self.movement, self._checks)
        return helping, [o.name for o in self.movement if o in movement or o.name in operators_to_enable]

    def _make_operator_for_search(self, operator: Operator) -> _OperatorForSearch:
        compiled = self._domain.compiled_operators[operator.name]
        tried = [condition for attempt in operator.alternatives for condition in attempt.conditions]
        conditions = [*([check.condition] for check in operator.checks), tried]
        moved = [
            not self._moved.isdisjoint(self._find_stored_dependencies(formulas)) for formulas in conditions
        ]
        needed = [check.fault is not FaultKind.ADDITIONAL_STEP for check in operator.checks]
        fixable = [*(can and for_need for can, for_need in zip(moved, needed, strict=False)), False]
        kinds = [
            self._classify_precondition_check(check, can)
            for check, can in zip(operator.checks, moved, strict=False)
        ]
        checks = list(zip(compiled.checks, kinds, strict=True))
        fixed, common, rest = [
            combine_tests_by_and([c.holds for c, k in checks if k is kind]) for kind in _PreconditionCheckKind
        ]
        rest = compiled.is_possible if operator.alternatives else rest
        checks_with_kind = zip(compiled.checks, kinds, fixable, strict=False)
        unmoved = combine_tests_by_and(
            [
                check.holds
                for check, kind, can in checks_with_kind
                if kind is _PreconditionCheckKind.REST and not can
            ]
        )
        return _OperatorForSearch(
            compiled,
            infer_operator_role(operator),
            tuple(moved),
            tuple(fixable),
            fixed,
            common,
            rest,
            unmoved,
        )

    def _classify_precondition_check(
        self, check: Check, can_movement_change_check: bool
    ) -> _PreconditionCheckKind:
        if self._changed.isdisjoint(self._find_stored_dependencies([check.condition])):
            return _PreconditionCheckKind.FIXED
        if can_movement_change_check or find_free_variables(check.condition):
            return _PreconditionCheckKind.REST
        return _PreconditionCheckKind.COMMON

    def _select_enabling_operators(
        self,
        operators_to_enable: Iterable[Operator],
        candidates: Sequence[Operator],
        required_predicates: Mapping[str, frozenset[str]],
    ) -> list[Operator]:
        """Return the candidates that can make some operators, ``operators_to_enable``, possible.

        A candidate can make an operator possible if it changes a predicate in the operator's conditions. The
        result also has candidates that make a returned candidate possible.
        """
        supporting: list[Operator] = []
        asking = list(operators_to_enable)
        while asking:
            conditions = frozenset[str]().union(*[required_predicates[operator.name] for operator in asking])
            asking = [
                o
                for o in candidates
                if o not in supporting and not self._writes[o.name].isdisjoint(conditions)
            ]
            supporting += asking
        return [operator for operator in candidates if operator in supporting]

    def _find_stored_dependencies(self, formulas: Iterable[Formula]) -> frozenset[str]:
        return frozenset(find_stored_dependencies(find_predicates(*formulas), self._domain.vocabulary))


def _generate_argument_tuples(
    decided_arguments: Sequence[int | None], objects: Sequence[int]
) -> Iterator[tuple[int, ...]]:
    """Yield all tuples of different objects for an operator's arguments, in the order of objects.

    Arguments that have an object already keep this object.
    """
    decided = [index for index in decided_arguments if index is not None]
    if len({*decided}) < len(decided):
        return
    others = [index for index in objects if index not in decided]
    for chosen in permutations(others, len(decided_arguments) - len(decided)):
        rest = iter(chosen)
        yield tuple([next(rest) if index is None else index for index in decided_arguments])


def list_objects_in_argument_tuples(
    argument_tuples: Iterable[Sequence[int]], scene: Scene
) -> tuple[int, ...]:
    """Return the objects in several tuples of arguments, each object once, without the agent."""
    return tuple(dict.fromkeys([i for indices in argument_tuples for i in indices if i != scene.agent]))


def _match_effect_to_change(effect: EffectSchema, change: FactChange) -> dict[str, int] | None:
    """Return a mapping from an operator's parameters to the objects with which its effect makes a change.

    The change is that a fact becomes true, or false. Return None if the effect cannot make this change.
    """
    if effect.atom.predicate != change.predicate or effect.adds is not change.truth:
        return None
    return match_atom(effect.atom, change.arguments, _get_object_number_if_agent)


def _get_object_number_if_agent(constant: Constant) -> int | None:
    """Return the number that stands for the agent in an `_OperatorPattern`; None for other constants."""
    return _AGENT if constant == AGENT else None


def _drop_duplicates(operators: Iterable[Operator]) -> list[Operator]:
    """Return the operators except those whose checks and effects equal the ones of an earlier operator."""
    operators_by_content: dict[object, Operator] = {}
    for operator in operators:
        operators_by_content.setdefault(
            (operator.parameters, operator.checks, operator.effects, operator.alternatives), operator
        )
    return list(operators_by_content.values())


def _list_conditions_of_all_checks(operator: Operator) -> Iterator[Formula]:
    for checks in (operator.checks, *(attempt.checks for attempt in operator.alternatives)):
        yield from [check.condition for check in checks]


class CandidateAction(NamedTuple):
    """An action that a search may take.

    Attributes:
        action: the action.
        info: the action's operator.
        binding: the values of the operator's variables in this search.
        possible: results of `remaining_checks_hold`, cached by state.
        results: results of `compute_state_after_action`, cached by state.
        parts: the subgoal's literals that the action may make true, as a bit mask; 0 for an action that only
            prepares another action.
        touched: the subgoal's literals that the action can change, as a bit mask.
    """

    action: Action
    info: _OperatorForSearch
    binding: ObjectBySlot
    possible: dict[State, bool]
    results: dict[State, State]
    parts: LiteralBits = 0
    touched: LiteralBits = 0

    @classmethod
    def create(cls, action: Action, info: _OperatorForSearch, state: State) -> CandidateAction:
        """Return a candidate action for a new search. Its bit masks and its caches are empty."""
        return cls(action, info, info.operator.bind(state, action.arguments), {}, {})

    def with_literal_masks(self, achieved: LiteralBits, changeable: LiteralBits) -> CandidateAction:
        """Return this candidate with two bit masks of literals.

        Args:
            achieved: the literals that the action may make true.
            changeable: the literals whose truth value the action can change.
        """
        return CandidateAction(
            self.action, self.info, self.binding, self.possible, self.results, achieved, changeable
        )

    @property
    def is_world_changing(self) -> bool:
        """Whether the action changes more than the agent's position, posture and hands.

        A search takes such an action only to make literals of the subgoal true, not to prepare other actions.
        """
        return self.info.role is OperatorRole.CHANGE

    def all_checks_hold(self, state: State) -> bool:
        """Whether all checks of the action hold in a state."""
        return self.info.operator.is_possible(state, self.binding)

    def static_checks_hold(self, state: State) -> bool:
        """Whether the fixed checks of the action hold: the checks that no action can change.

        The answer is the same in all states of an episode.
        """
        return self.info.static_checks_hold(state, self.binding)

    def remaining_checks_hold(self, state: State) -> bool:
        """Whether all checks of the action hold in a state.

        Callers must have tested that two kinds of checks hold: the checks that no action can change, and the
        checks that depend neither on the action's objects nor on the agent's position.
        """
        is_possible = self.possible.get(state)
        if is_possible is None:
            is_possible = self.possible[state] = self.info.rest_checks_hold(state, self.binding)
        return is_possible

    def can_movement_make_action_possible(self, state: State) -> bool:
        """Whether movement of the agent can make all failing checks of the action true.

        Callers must have tested that all `FIXED` and `COMMON` checks hold (`_PreconditionCheckKind`).
        So only the other checks can fail.
        """
        if not self.info.unmovable_checks_hold(state, self.binding):
            return False
        return not self.info.operator.alternatives or all(
            self.info.fixable[i] for i in self.find_indices_of_failing_checks(state)
        )

    def compute_state_after_action(self, state: State) -> State:
        """Return the state after the action, even if its checks fail."""
        result = self.results.get(state)
        if result is None:
            result = self.results[state] = self.info.operator.apply(state, self.binding)
        return result

    def find_indices_of_failing_checks(self, state: State) -> list[int]:
        """Return the indices of the failing checks in the operator's list of checks.

        An operator may have several ways to act (`OperatorAlternative`). If all checks hold but each way
        fails, the only index is the number of checks.
        """
        checks = self.info.operator.checks
        numbers = [i for i, check in enumerate(checks) if not check.holds(state, self.binding)]
        return numbers if numbers or self.all_checks_hold(state) else [len(checks)]

    def count_failing_checks_movement_cannot_fix(self, state: State) -> int:
        """Return the number of failing checks that movement cannot change."""
        checks = zip(self.info.operator.checks, self.info.movable, strict=False)
        return sum([not movable and not check.holds(state, self.binding) for check, movable in checks])

    def needs_objects_of_other_kind(self, failing_checks: Sequence[int]) -> bool:
        """Whether a failing check requires another kind of object. No other action can help then."""
        checks = self.info.operator.checks
        return any(checks[i].check.fault is FaultKind.AFFORDANCE for i in failing_checks if i < len(checks))


def is_action_needless(operator: CompiledOperator, action: Action, state: State) -> bool:
    """Whether an action fails as an additional (needless) step, because its effect holds already."""
    failures = operator.find_failures(state, operator.bind(state, action.arguments))
    return any(failure.check.check.fault is FaultKind.ADDITIONAL_STEP for failure in failures)


def select_actions_of_operators(plan: Sequence[Action], operators: Collection[str]) -> tuple[Action, ...]:
    """Return those actions of a plan that use an operator which matters to the goal."""
    return tuple([action for action in plan if action.operator in operators])
