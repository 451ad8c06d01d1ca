"""Refinement: find the actions for one subgoal by a small search in the declared domain.

A subgoal gets at most `MAX_ACTIONS_PER_SUBGOAL` actions. Each action makes a part of the subgoal true, or
prepares another action. Only three kinds of actions (`OperatorRole`) prepare others: *movement*, *taking* an
object of the subgoal into a hand, and, if nothing else helps, *releasing* an object. So a goal that needs
many actions fails as a subgoal.

The shortest plan is taken. If several plans have this length, the search over all executions of the answer
(``search.py``) tries each plan. A number of applied actions limits the effort, never time. Operators and
objects are tried in their order. (Paper, section "Ability Module 2: Subgoal Decomposition": a breadth-first
search with a bounded number of actions for each subgoal.)
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from functools import cache, reduce
from itertools import islice, permutations, product
from operator import or_
from typing import NamedTuple

from eai.abilities.subgoal_decomposition.program import ActionSequence, SubgoalPlanner, SubgoalPlanningResult
from eai.abilities.subgoal_decomposition.repertoire import (
    MAX_LISTED_ACTIONS,
    CandidateAction,
    Holds,
    LiteralBits,
    OperatorIndex,
    is_action_needless,
    list_objects_in_argument_tuples,
)
from eai.abilities.subgoal_decomposition.uniform_cost import (
    PermittedActions,
    SearchGoal,
    find_plans_trying_action_sets_in_order,
)
from eai.planning.exclusion import MutualExclusionRules
from eai.planning.subgoal import GroundAtom
from eai.world.action import Action
from eai.world.domain import Domain
from eai.world.operator import Operator, OperatorRole
from eai.world.state import Scene, State

_MAX_TESTED_LITERALS = 200_000
"""Maximum number of tests of literals in one search.

A search may test every literal of its subgoal after each applied action. So a search for a subgoal with very
many literals applies few actions.
"""


class _SubgoalSearchInput(NamedTuple):
    """The input of a search for the actions of a subgoal.

    Attributes:
        state: the start state.
        wanted: mapping from actions that may reach the subgoal to the bit mask of the subgoal's literals that
            each action may make true.
        touched: mapping from names of operators to the bit mask of the subgoal's literals that each operator
            can change.
        named: the objects in the subgoal.
        objects: the objects that actions may use.
        candidates: cache of the search: mapping from actions to their `CandidateAction`.
        wider: returns the actions that may reach the subgoal if they may use all objects, also objects
            outside the subgoal; None if the subgoal is an action itself.
    """

    state: State
    wanted: Mapping[Action, LiteralBits]
    touched: Mapping[str, LiteralBits]
    named: Sequence[int]
    objects: Sequence[int]
    candidates: dict[Action, CandidateAction]
    wider: Callable[[State], Mapping[Action, LiteralBits]] | None = None

    def find_changeable_literals(self, operators: Iterable[str]) -> LiteralBits:
        """Return the subgoal's literals that some operators can change."""
        return reduce(or_, [self.touched.get(name, 0) for name in operators], 0)


class SubgoalRefiner:
    """Finds the actions that achieve subgoals in one domain.

    Args:
        domain: the domain.
        budget: maximum number of actions that a search may apply to states, for each literal of the subgoal.

    Attributes:
        domain: the domain.
        exclusion_rules: returns the domain's rules on facts that cannot hold together.
    """

    def __init__(self, domain: Domain, budget: int = 300) -> None:
        self.domain = domain
        self.exclusion_rules = cache(lambda: MutualExclusionRules(domain))
        self._repertoire = OperatorIndex(domain)
        self._budget = budget

    def can_bring_about(self, literal: GroundAtom) -> bool:
        """Whether any action of the domain changes the predicate of a literal."""
        return bool(self._repertoire.find_operators_that_change(literal.predicate))

    def make_planner_for_literals(
        self,
        literals: Sequence[GroundAtom],
        subgoal_holds: Holds,
        scene: Scene,
        objects: Sequence[int],
        operators_in_goal: Collection[str] = (),
        *,
        test_effort: int = 0,
    ) -> SubgoalPlanner:
        """Return a planner for a subgoal that does not hold yet.

        If no plan reaches the subgoal, the planner returns the plan that comes nearest, and its failing
        action, so that the failure can be explained. If no action fails but the plan is too long, the planner
        returns no plan.

        Args:
            literals: the literals of the subgoal.
            subgoal_holds: tests the complete subgoal in a state. It may require more than its literals.
            scene: the scene.
            objects: the objects that actions may use.
            operators_in_goal: the operators that the goal mentions. Plans that use them differently count as
                different plans, even if they end in the same state.
            test_effort: cost of a test of the subgoal, in applied actions.
        """
        tests = [
            (1 << i, self._repertoire.make_literal_test(subgoal_literal, scene))
            for i, subgoal_literal in enumerate(literals)
        ]
        everything = (1 << len(literals)) - 1
        touched = self._repertoire.map_operators_to_changeable_literals(literals)
        wanted = self._repertoire.map_achieving_actions_to_literals(literals, scene)
        named = list_objects_in_argument_tuples([literal.arguments for literal in literals], scene)

        def find_achieving_actions_on_usable_objects(state: State) -> Mapping[Action, LiteralBits]:
            fitting = None if self._repertoire.movement else state
            return self._repertoire.map_achieving_actions_to_literals(literals, scene, objects, fitting)

        def find_true_literals(
            state: State, changeable: LiteralBits, true_before: LiteralBits
        ) -> LiteralBits:
            holding = true_before & ~changeable
            for part, test in tests:
                if changeable & part and test(state):
                    holding |= part
            return holding

        def find_plans_for_one_subgoal(state: State) -> SubgoalPlanningResult:
            goal = SearchGoal(
                find_true_literals(state, everything, 0),
                find_true_literals,
                everything,
                subgoal_holds,
                operators_in_goal,
                test_effort,
            )
            return self._search_plans(
                goal,
                _SubgoalSearchInput(
                    state, wanted, touched, named, objects, {}, find_achieving_actions_on_usable_objects
                ),
            )

        return find_plans_for_one_subgoal

    def find_needless_actions_for_true_literals(
        self, literals: Sequence[GroundAtom], state: State
    ) -> ActionSequence | None:
        """Return actions whose effects are literals that hold already, or None if a literal does not hold.

        Each action fails as an additional (needless) step, because its effect holds already. For each
        literal, the result has the first needless action that may make the literal true and releases no
        object.
        """
        if not all(self._repertoire.make_literal_test(literal, state.scene)(state) for literal in literals):
            return None
        needless: list[Action] = []
        covered = 0
        for action, parts in self._repertoire.map_achieving_actions_to_literals(
            literals, state.scene
        ).items():
            releases = self._get_operator_role_of_action(action) is OperatorRole.RELEASES
            if not releases and parts & ~covered and self._is_action_needless(action, state):
                needless.append(action)
                covered |= parts
        return tuple(needless)

    def make_planner_for_action_subgoal(
        self, action: Action, scene: Scene, objects: Sequence[int]
    ) -> SubgoalPlanner:
        """Return a planner for a subgoal that is an action.

        The plan is the shortest that ends with this action.

        If no plan makes the action possible, the planner returns the failed attempt.
        """
        goal = SearchGoal(0, lambda _, touched, __: touched, 1, lambda _: True, ())
        named = list_objects_in_argument_tuples([action.arguments], scene)

        def find_plans_that_end_with_action(state: State) -> SubgoalPlanningResult:
            if self._is_action_needless(action, state):
                return SubgoalPlanningResult(((action,),))
            return self._search_plans(goal, _SubgoalSearchInput(state, {action: 1}, {}, named, objects, {}))

        return find_plans_that_end_with_action

    def _search_plans(self, goal: SearchGoal, search_input: _SubgoalSearchInput) -> SubgoalPlanningResult:
        budget = min(self._budget * goal.goal_part_count, _MAX_TESTED_LITERALS // goal.goal_part_count)
        return find_plans_trying_action_sets_in_order(
            goal, self._generate_growing_action_sets(search_input), search_input.state, budget
        )

    def _generate_growing_action_sets(self, search_input: _SubgoalSearchInput) -> Iterator[PermittedActions]:
        """Yield up to three growing sets of actions that a search may use.

        Actions of the first set use only the objects in the subgoal. The second set adds actions that release
        any object. The third set adds movement to any object. It also adds actions with any objects for
        parameters that the subgoal does not determine. In domains without movement, as most PDDL domains,
        these actions must pass their fixed checks: the checks that no action can change.

        If the domain has movement but the subgoal does not depend on the agent's position, the third set adds
        only actions with a tool. A tool is an object that the action's effects do not mention.
        """
        helping, movement = self._repertoire.find_enabling_hand_and_movement_operators(
            _get_operator_names(search_input.wanted)
        )
        moves, changes = self._separate_movement_actions(search_input.wanted, search_input)
        handled = any(
            self._get_operator_role_of_action(action) is not OperatorRole.RELEASES
            for action in search_input.wanted
        )
        takes = self._to_candidates(
            self._map_actions_of_role_to_no_literals(
                helping, OperatorRole.TAKES, search_input.named if handled else ()
            ),
            search_input,
        )
        touched = search_input.find_changeable_literals(movement)
        moving = self._to_candidates(
            self._map_movement_actions_to_no_literals(movement, search_input.named), search_input
        )
        yield PermittedActions(changes, takes, moves, moving, touched)
        releases = self._to_candidates(
            self._map_actions_of_role_to_no_literals(helping, OperatorRole.RELEASES, search_input.objects),
            search_input,
        )
        if releases:
            yield PermittedActions(changes, [*takes, *releases], moves, moving, touched)
        wider = search_input.wanted if search_input.wider is None else search_input.wider(search_input.state)
        _, movement = self._repertoire.find_enabling_hand_and_movement_operators(_get_operator_names(wider))
        if self._repertoire.movement and not movement:
            tools = self._repertoire.with_tools
            wider = {a: p for a, p in wider.items() if a in search_input.wanted or a.operator in tools}
        if movement or not wider.keys() <= search_input.wanted.keys():
            moves, changes = self._separate_movement_actions(wider, search_input)
            touched = search_input.find_changeable_literals(movement)
            moving = self._to_candidates(
                self._map_movement_actions_to_no_literals(movement, search_input.objects), search_input
            )
            yield PermittedActions(changes, [*takes, *releases], moves, moving, touched)

    def _separate_movement_actions(
        self, achieving_actions: Mapping[Action, LiteralBits], search_input: _SubgoalSearchInput
    ) -> tuple[list[CandidateAction], list[CandidateAction]]:
        """Return two lists of achieving actions: movement that the subgoal requires, and other actions."""
        may_require_movement = search_input.wider is not None
        moves = {
            a: p
            for a, p in achieving_actions.items()
            if may_require_movement and self._get_operator_role_of_action(a) is OperatorRole.MOVEMENT
        }
        changes = {action: parts for action, parts in achieving_actions.items() if action not in moves}
        return self._to_candidates(moves, search_input), self._to_candidates(changes, search_input)

    def _map_actions_of_role_to_no_literals(
        self, operators: Iterable[Operator], role: OperatorRole, objects: Sequence[int]
    ) -> dict[Action, LiteralBits]:
        """Return a mapping from the actions by operators with a role, such as movement, to 0.

        No action has the same object twice. The actions only prepare other actions. So 0 is the bit mask of
        the subgoal's literals that they make true (`LiteralBits`).
        """
        return {
            Action(o.name, arguments): 0
            for o in operators
            if self._repertoire.operators[o.name].role is role
            for arguments in islice(permutations(objects, o.arity), MAX_LISTED_ACTIONS)
        }

    def _map_movement_actions_to_no_literals(
        self, operators: Iterable[str], places: Sequence[int]
    ) -> dict[Action, LiteralBits]:
        return {
            Action(name, arguments): 0
            for name in operators
            for arguments in islice(
                product(places, repeat=self._repertoire.operators[name].operator.operator.arity),
                MAX_LISTED_ACTIONS,
            )
        }

    def _to_candidates(
        self, actions: Mapping[Action, LiteralBits], search_input: _SubgoalSearchInput
    ) -> list[CandidateAction]:
        candidates = []
        for action, parts in actions.items():
            candidate = search_input.candidates.get(action)
            if candidate is None:
                info = self._repertoire.operators[action.operator]
                candidate = search_input.candidates[action] = CandidateAction.create(
                    action, info, search_input.state
                )
            touched = search_input.touched.get(action.operator, 0) | parts
            candidates.append(candidate.with_literal_masks(parts, touched))
        return candidates

    def _is_action_needless(self, action: Action, state: State) -> bool:
        return is_action_needless(self._repertoire.operators[action.operator].operator, action, state)

    def _get_operator_role_of_action(self, action: Action) -> OperatorRole:
        return self._repertoire.operators[action.operator].role


def _get_operator_names(actions: Iterable[Action]) -> frozenset[str]:
    return frozenset([action.operator for action in actions])
