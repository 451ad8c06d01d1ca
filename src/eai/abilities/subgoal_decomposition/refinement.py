"""Refinement: which actions carry out a subgoal, found by a small search on the declared domain.

A subgoal is carried out by `MAX_ACTIONS` at most. An action that changes the world brings about a
part of it; three other things (`Role`) may be done for its sake: *movement*, *taking* what the subgoal
names into a hand, and *releasing* what a hand holds, where nothing else helps. So the goal of a task is
no subgoal, unless it is as near as that. The shortest sequence is taken; of equally short ones all are handed
on, for the search that carries out the whole answer to try. Effort is bounded by a number of applied actions,
never by time; operators and objects are tried in their order. (Paper, section "Ability Module 2: Subgoal
Decomposition": a breadth-first search with a bounded number of actions for each subgoal.)
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from functools import cache, reduce
from itertools import islice, permutations, product
from operator import or_
from typing import NamedTuple

from eai.abilities.subgoal_decomposition.program import ActionSequence, SubgoalPlanner, SubgoalPlans
from eai.abilities.subgoal_decomposition.repertoire import (
    MAX_LISTED,
    CandidateAction,
    Holds,
    Repertoire,
    is_needless,
    list_objects,
)
from eai.abilities.subgoal_decomposition.uniform_cost import Permitted, SearchGoal, find_plans
from eai.planning.exclusion import ExclusionRules
from eai.planning.subgoal import GroundAtom
from eai.world.action import Action
from eai.world.domain import Domain
from eai.world.operator import Operator, Role
from eai.world.state import Scene, State

_MAX_TESTED_LITERALS = 200_000
"""How many literals one search may test; of a subgoal with very many fewer actions are applied."""


class _SearchNeeds(NamedTuple):
    """The means of a search.

    Attributes:
        state: where it begins.
        wanted: what may bring the subgoal about, and the mask of the parts that each action is for.
        touched: for each operator the mask of the parts that it can change besides.
        named: the objects that the subgoal names.
        objects: what actions may be about.
        grounds: the actions that have been thought of.
        wider: gives what may bring the subgoal about by means of other objects; None where an action is
            wanted for its own sake, not for where it leads.
    """

    state: State
    wanted: Mapping[Action, int]
    touched: Mapping[str, int]
    named: Sequence[int]
    objects: Sequence[int]
    grounds: dict[Action, CandidateAction]
    wider: Callable[[State], Mapping[Action, int]] | None = None

    def combine_touched(self, operators: Iterable[str]) -> int:
        """The mask of the parts that some operators can change."""
        return reduce(or_, [self.touched.get(name, 0) for name in operators], 0)


class Refinement:
    """Finds what carries out subgoals of one domain.

    Args:
        domain: the domain.
        budget: how many actions a search may apply to states for each literal of a subgoal.

    Attributes:
        domain: the domain.
        exclusion_rules: gives what its declaration says about facts that exclude each other.
    """

    def __init__(self, domain: Domain, budget: int = 300) -> None:
        self.domain = domain
        self.exclusion_rules = cache(lambda: ExclusionRules(domain))
        self._repertoire = Repertoire(domain)
        self._budget = budget

    def brings_about(self, literal: GroundAtom) -> bool:
        """Whether any action changes what the literal is about."""
        return bool(self._repertoire.find_writers(literal.predicate))

    def make_planner(
        self,
        literals: Sequence[GroundAtom],
        holds: Holds,
        scene: Scene,
        objects: Sequence[int],
        distinguished: Collection[str] = (),
        *,
        test_effort: int = 0,
    ) -> SubgoalPlanner:
        """The actions in a state that make a subgoal hold, where it does not yet.

        Where it cannot be made to hold, it is what comes nearest, and then the action that fails, to be
        diagnosed; nothing if none fails but there are too many.

        Args:
            literals: what the subgoal says of objects.
            holds: whether the subgoal holds; it may say more than its literals.
            scene: the scene.
            objects: what actions may be about.
            distinguished: the operators of which it matters that they are taken.
            test_effort: how many applied actions a test of the subgoal stands for.
        """
        tests = [(1 << i, self._repertoire.make_test(each, scene)) for i, each in enumerate(literals)]
        everything = (1 << len(literals)) - 1
        touched = self._repertoire.find_touched(literals)
        wanted = self._repertoire.find_achievers(literals, scene)
        named = list_objects([literal.arguments for literal in literals], scene)

        def wider(state: State) -> Mapping[Action, int]:
            fitting = None if self._repertoire.movement else state
            return self._repertoire.find_achievers(literals, scene, objects, fitting)

        def met(state: State, touched: int, before: int) -> int:
            found = before & ~touched
            for part, test in tests:
                if touched & part and test(state):
                    found |= part
            return found

        def plans(state: State) -> SubgoalPlans:
            goal = SearchGoal(met(state, everything, 0), met, everything, holds, distinguished, test_effort)
            return self._search(goal, _SearchNeeds(state, wanted, touched, named, objects, {}, wider))

        return plans

    def find_needless(self, literals: Sequence[GroundAtom], state: State) -> ActionSequence | None:
        """The actions that would bring literals about and say themselves that they are not needed.

        That is for each literal the first that does, as its object is as it makes it; None if one of the
        literals does not hold.
        """
        if not all(self._repertoire.make_test(each, state.scene)(state) for each in literals):
            return None
        found: list[Action] = []
        covered = 0
        for action, parts in self._repertoire.find_achievers(literals, state.scene).items():
            releases = self._role(action) is Role.RELEASES
            if not releases and parts & ~covered and self._is_needless(action, state):
                found.append(action)
                covered |= parts
        return tuple(found)

    def make_action_planner(self, action: Action, scene: Scene, objects: Sequence[int]) -> SubgoalPlanner:
        """An action, after the shortest sequence that makes it possible; the attempt where there is none."""
        goal = SearchGoal(0, lambda _, touched, __: touched, 1, lambda _: True, ())
        named = list_objects([action.arguments], scene)

        def plans(state: State) -> SubgoalPlans:
            if self._is_needless(action, state):
                return SubgoalPlans(((action,),))
            return self._search(goal, _SearchNeeds(state, {action: 1}, {}, named, objects, {}))

        return plans

    def _search(self, goal: SearchGoal, need: _SearchNeeds) -> SubgoalPlans:
        budget = min(self._budget * goal.size, _MAX_TESTED_LITERALS // goal.size)
        return find_plans(goal, self._permitted_sets(need), need.state, budget)

    def _permitted_sets(self, need: _SearchNeeds) -> Iterator[Permitted]:
        """The permitted actions, widened step by step.

        First what is about nothing but the objects that are named; then releasing any object; then going to
        any object, and changes of any where the literal leaves open about which. Where the agent moves, but
        none of these depends on where it is, that is only by means of any tool; where it does not, as in most
        of PDDL, it is by whatever fits.
        """
        helping, movement = self._repertoire.find_supporters(_operator_names(need.wanted))
        moves, changes = self._split_movement(need.wanted, need)
        handled = any(self._role(action) is not Role.RELEASES for action in need.wanted)
        takes = self._to_candidates(
            self._actions_of_role(helping, Role.TAKES, need.named if handled else ()), need
        )
        touched = need.combine_touched(movement)
        moving = self._to_candidates(self._moves(movement, need.named), need)
        yield Permitted(changes, takes, moves, moving, touched)
        releases = self._to_candidates(self._actions_of_role(helping, Role.RELEASES, need.objects), need)
        if releases:
            yield Permitted(changes, [*takes, *releases], moves, moving, touched)
        wider = need.wanted if need.wider is None else need.wider(need.state)
        _, movement = self._repertoire.find_supporters(_operator_names(wider))
        if self._repertoire.movement and not movement:
            tools = self._repertoire.with_tools
            wider = {a: p for a, p in wider.items() if a in need.wanted or a.operator in tools}
        if movement or not wider.keys() <= need.wanted.keys():
            moves, changes = self._split_movement(wider, need)
            touched = need.combine_touched(movement)
            moving = self._to_candidates(self._moves(movement, need.objects), need)
            yield Permitted(changes, [*takes, *releases], moves, moving, touched)

    def _split_movement(
        self, wanted: Mapping[Action, int], need: _SearchNeeds
    ) -> tuple[list[CandidateAction], list[CandidateAction]]:
        """The movement that is wanted for where it leads, and all else that is wanted."""
        leading = need.wider is not None
        moves = {a: p for a, p in wanted.items() if leading and self._role(a) is Role.MOVEMENT}
        changes = {action: parts for action, parts in wanted.items() if action not in moves}
        return self._to_candidates(moves, need), self._to_candidates(changes, need)

    def _actions_of_role(
        self, operators: Iterable[Operator], role: Role, objects: Sequence[int]
    ) -> dict[Action, int]:
        """The actions by operators of a role about different objects; they are for no part."""
        return {
            Action(o.name, arguments): 0
            for o in operators
            if self._repertoire.operators[o.name].role is role
            for arguments in islice(permutations(objects, o.arity), MAX_LISTED)
        }

    def _moves(self, operators: Iterable[str], places: Sequence[int]) -> dict[Action, int]:
        """The movement to places; it is for no part."""
        return {
            Action(name, arguments): 0
            for name in operators
            for arguments in islice(
                product(places, repeat=self._repertoire.operators[name].operator.operator.arity), MAX_LISTED
            )
        }

    def _to_candidates(self, actions: Mapping[Action, int], need: _SearchNeeds) -> list[CandidateAction]:
        grounds = []
        for action, parts in actions.items():
            ground = need.grounds.get(action)
            if ground is None:
                known = self._repertoire.operators[action.operator]
                ground = need.grounds[action] = CandidateAction.create(action, known, need.state)
            touched = need.touched.get(action.operator, 0) | parts
            grounds.append(ground.assign_parts(parts, touched))
        return grounds

    def _is_needless(self, action: Action, state: State) -> bool:
        return is_needless(self._repertoire.operators[action.operator].operator, action, state)

    def _role(self, action: Action) -> Role:
        return self._repertoire.operators[action.operator].role


def _operator_names(actions: Iterable[Action]) -> frozenset[str]:
    return frozenset([action.operator for action in actions])
