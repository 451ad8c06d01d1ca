"""Play games without a language model: by null agents, which do not know the goals, or by planning agents.

An agent is made for one game and returns its next command whenever it is called. Null agents take random
actions. One of them takes possible actions, one takes possible actions that lead to new states, and one takes
any actions. Planning agents know the goals and read facts about known objects from the state. Their results
show how well an agent can play by the rules of the games.
"""

from __future__ import annotations

import random
from collections import Counter, deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import TypeAlias

from eai.agents.command import DONE
from eai.agents.game import Game
from eai.base.errors import InputError
from eai.benchmarks.generator.measures import (
    find_predicates_showing_or_hiding_contents,
    make_formula_that_object_x_exists,
)
from eai.logic.formula import Atom, Constant, Formula, Not, Variable
from eai.logic.rewriting import map_terms, rewrite_leaves
from eai.planning.greedy_search import GreedySearch
from eai.planning.planner import PlanningGoal, get_planner
from eai.planning.search import Limits, SearchNode
from eai.planning.subgoal import make_subgoals
from eai.planning.successor_generator import PlanNode, SuccessorGenerator
from eai.tasks.goal_test import find_remaining_goals
from eai.tasks.planning import explain_missing_plan, find_plan, to_planning_goal
from eai.tasks.task import Goal
from eai.world.action import Action
from eai.world.state import State

Agent: TypeAlias = Callable[[], str]
"""Function that returns the next command in the game for which the agent was made."""

_MAX_TRIES = 60
"""Maximum number of actions that `eai/novel` simulates in one turn to find a state not yet visited."""

_MAX_COMPARED = 12
"""Maximum number of actions that the greedy agent compares in one state."""

_VISITED_COST = 1000
"""Number that the greedy agent adds to the estimated distance to the goals in a state visited before."""

_LIMITS_OF_FIRST_SEARCH = Limits(200, thorough=False, looks=8_000)
"""Limits of the first search for a plan by the agent `eai/explorer`. It uses only known objects."""

_LIMITS_BEFORE_OPENING = Limits(300, looks=15_000)
"""Limits of the second search for a plan by the agent `eai/explorer`.

The agent makes this search when it has visited all objects that it knew from the start. If the search fails,
it opens a container.
"""

_LIMITS_OF_LAST_SEARCH = Limits(2_000)
"""Limits of the last search by the agent `eai/explorer`, after it has opened all containers."""

_EXPLORING_LIMITS = Limits(50)
"""Limits of a search for a plan by which the agent `eai/explorer` sees more objects."""


def random_agent(game: Game, seed: int = 0) -> Agent:
    """Return `eai/random`, which takes a random possible action on known objects, or `DONE`.

    All possible actions and `DONE` have equal probability.
    """
    rng = _make_rng(game, seed)

    def choose_random_possible_command() -> str:
        actions = [*game.find_possible_actions()]
        chosen = rng.randrange(len(actions) + 1)
        return DONE if chosen == len(actions) else game.setup.commands.write_command(actions[chosen])

    return choose_random_possible_command


def novelty_seeking_agent(game: Game, seed: int = 0) -> Agent:
    """Return `eai/novel`, which takes a random possible action that leads to a new state, or `DONE`."""
    rng, visited = _make_rng(game, seed), set[State]()

    def choose_command_to_new_state() -> str:
        visited.add(game.state)
        actions = [*game.find_possible_actions()]
        if not rng.randrange(len(actions) + 1):
            return DONE
        rng.shuffle(actions)
        domain, state = game.setup.domain, game.state
        new = (action for action in actions[:_MAX_TRIES] if domain.apply(state, action) not in visited)
        return game.setup.commands.write_command(next(new, actions[0]))

    return choose_command_to_new_state


def make_blind_agent(game: Game, seed: int = 0) -> Agent:
    """Return `eai/blind`, which sends a random, perhaps impossible action on known objects, or `DONE`."""
    rng = _make_rng(game, seed)

    def choose_random_command() -> str:
        operators, known = game.setup.domain.operators, sorted(game.memory.known)
        chosen = rng.randrange(len(operators) + 1)
        if chosen == len(operators):
            return DONE
        operator = operators[chosen]
        arguments = tuple([rng.choice(known) for _ in range(operator.arity)])
        return game.setup.commands.write_command(Action(operator.name, arguments))

    return choose_random_command


def _make_rng(game: Game, seed: int) -> random.Random:
    return random.Random(f"{seed} {game.task.id}")  # noqa: S311 - random actions, no secrets


def make_reference_solution_agent(game: Game, seed: int = 0) -> Agent:
    """Return an agent that plays the commands of the task's `ReferenceSolution`, then `DONE`."""
    return _make_scripted_agent(game.setup.reference.commands or ())


def gold_plan_agent(game: Game, seed: int = 0) -> Agent:
    """Return an agent that plays the gold plan or else the planner's plan, then `DONE`.

    The gold plan is the data set's own plan. Without a plan the agent declares the task impossible.
    """
    if game.task.has_no_plan:
        return make_reference_solution_agent(game)
    plan = game.task.script or find_plan(game.task, get_planner(game.setup.domain)).plan
    return _make_scripted_agent(map(game.setup.commands.write_command, plan))


def planner_agent(game: Game, seed: int = 0) -> Agent:
    """Return `eai/planner`, which knows the whole scene. It carries out a plan, then says `DONE`.

    Raises:
        InputError: the planner finds no plan.
    """
    search = find_plan(game.task, get_planner(game.setup.domain))
    if reason := explain_missing_plan(search.end):
        raise InputError(reason)
    return _make_scripted_agent(map(game.setup.commands.write_command, search.plan))


def _make_scripted_agent(commands: Iterable[str]) -> Agent:
    pending = iter(commands)
    return lambda: next(pending, DONE)


def _replace_variable_x(formula: Formula, constant: Constant) -> Formula:
    """Return a formula with its variable ``x`` replaced by an object."""
    x = Variable("x")
    return rewrite_leaves(
        formula,
        lambda leaf, bound: (
            leaf if "x" in bound else map_terms(leaf, lambda term: constant if term == x else term)
        ),
    )


class _Explorer:
    """Agent `eai/explorer`, which plans with known objects, and explores if no plan reaches the goals.

    It visits the objects known from the start, such as furniture, one by one. Then it opens containers that
    may hide objects, by the domain's definition of visibility. It says `DONE` if all goals hold, or nothing
    is left to try.

    Args:
        game: the game to play, which no other agent may play at the same time.
        seed: not used; the agent makes no random choice.
    """

    def __init__(self, game: Game, seed: int = 0) -> None:
        self._game = game
        self._domain = game.setup.domain
        self._planner = get_planner(self._domain)
        self._plan: deque[Action] = deque()
        self._expected: State | None = None
        self._planned = set[tuple[Limits, int]]()
        self._visited_objects: set[int] = set()
        self._opened: tuple[str, int] | None = None
        self._has_opened = False
        self._fruitless: Counter[str] = Counter()
        self._tried: set[tuple[Formula, bool]] = set()
        self._lids = tuple(dict.fromkeys(find_predicates_showing_or_hiding_contents(self._domain)))
        self._present = make_formula_that_object_x_exists(self._domain)

    def __call__(self) -> str:
        """Return the next command of this agent."""
        game = self._game
        self._visited_objects.update(game.memory.observation.visible)
        if all(game.reached):
            return DONE
        if self._expected != game.state:
            self._plan.clear()
        if not self._plan:
            self._plan.extend(self._find_plan() or self._plan_to_revisit_objects_known_at_start())
        if not self._plan:
            return DONE
        action = self._plan.popleft()
        self._expected = self._domain.apply(game.state, action)
        return game.setup.commands.write_command(action)

    def _find_plan(self) -> Sequence[Action]:
        """Return a plan that reaches the goals, or else a plan that lets the agent see more objects."""
        return (
            self._find_plan_for_goals()
            or self._plan_to_see_objects(self._pair_unvisited_objects_with_sight_goals())
            or self._find_plan_for_goals(_LIMITS_BEFORE_OPENING)
            or self._plan_to_open_container()
            or self._find_plan_for_goals(_LIMITS_OF_LAST_SEARCH)
        )

    def _plan_to_open_container(self) -> Sequence[Action]:
        plan = self._plan_to_see_objects(self._pair_closed_containers_with_opening_goals())
        self._has_opened |= bool(plan)
        return plan

    def _plan_to_revisit_objects_known_at_start(self) -> Sequence[Action]:
        """Return a plan to visit all objects known from the start once more.

        Some open containers can be looked into only from beside such an object. Without a container that was
        opened since the last such plan, the plan is empty.
        """
        if not self._has_opened:
            return ()
        self._has_opened = False
        self._visited_objects = {*self._game.memory.observation.visible}
        self._tried.clear()
        return self._find_plan()

    def _get_category(self, object_index: int) -> str:
        return self._game.task.scene.objects[object_index].category

    def _find_unreached_goals(self) -> list[Goal]:
        goals = zip(self._game.task.goals, self._game.reached, strict=True)
        return [goal for goal, reached in goals if not reached]

    def _find_plan_for_goals(self, limits: Limits = _LIMITS_OF_FIRST_SEARCH) -> Sequence[Action]:
        """Return a plan for the goals, or an empty plan if no search finds one.

        A first search uses only the objects of the goals; a second search uses all known objects. Nothing is
        searched while an object of an unmet goal is unknown, except objects that actions create.
        """
        game, task = self._game, self._game.task
        usable_objects = game.memory.known | self._find_objects_that_do_not_exist_yet()
        effort = (limits, len(game.memory.known))
        if (
            not self._game.task.find_objects_named_in_goals(self._find_unreached_goals()) <= usable_objects
            or effort in self._planned
        ):
            return ()
        self._planned.add(effort)
        now = replace(task, initial=game.state, goals=find_remaining_goals(task, game.executed_operators))
        for usable in (
            self._game.task.find_objects_named_in_goals(task.goals) & usable_objects,
            usable_objects,
        ):
            plan = find_plan(replace(now, relevant=tuple(sorted(usable))), self._planner, limits).plan
            if plan:
                return plan
        return ()

    def _find_objects_that_do_not_exist_yet(self) -> set[int]:
        """Return the objects of the task that an action must create first."""
        holds = self._planner.heuristic.readings.holds
        state, present = self._game.state, self._present
        return {i for i in self._game.task.relevant if not holds(present, {"x": i}, state)}

    def _plan_to_see_objects(self, targets: Sequence[tuple[int, Formula]]) -> Sequence[Action]:
        """Return a plan that makes one condition true, after which the agent may see new objects.

        Plans that act only on the object of the condition are tried first, then plans that act on all known
        objects.

        Args:
            targets: objects, each with its condition, such as a container that is to be open.
        """
        known = tuple(sorted(self._game.memory.known))
        if self._opened is not None and len(known) == self._opened[1]:
            self._fruitless[self._opened[0]] += 1
        self._opened = None
        for by_itself in (True, False):
            for index, condition in targets:
                if (condition, by_itself) not in self._tried:
                    self._tried.add((condition, by_itself))
                    goal, usable = PlanningGoal((condition,)), (index,) if by_itself else known
                    limits = replace(_EXPLORING_LIMITS, thorough=by_itself)
                    plan = self._planner.find_plan(self._game.state, goal, usable, limits).plan
                    if plan:
                        self._opened = self._get_category(index), len(known)
                        return plan
        return ()

    def _pair_unvisited_objects_with_sight_goals(self) -> Sequence[tuple[int, Formula]]:
        """Return the objects known from the start that the agent has not visited, such as furniture.

        Each comes with the condition under which the agent sees it.
        """
        visible, names = self._domain.visible, self._game.task.scene.objects
        if visible is None:
            return ()
        landmarks = [i for i in self._game.setup.observer.landmarks if i not in self._visited_objects]
        return [(i, _replace_variable_x(visible, Constant(names[i].name))) for i in landmarks]

    def _pair_closed_containers_with_opening_goals(self) -> Sequence[tuple[int, Formula]]:
        """Return objects that can hide other objects, each with the condition under which it hides nothing.

        Objects that goals name come first. The other objects are in the order of how many objects of their
        category were opened without showing new objects, fewest first. Among equals, visible objects come
        first.
        """
        game, names = self._game, self._game.task.scene.objects
        near = set(game.memory.observation.visible)
        named = self._game.task.find_objects_named_in_goals(game.task.goals)

        def rank_container_for_search(container: int) -> tuple[bool, int, bool, int]:
            return (
                container not in named,
                self._fruitless[self._get_category(container)],
                container not in near,
                container,
            )

        lids = []
        for index in sorted(game.memory.known, key=rank_container_for_search):
            for predicate, truth in self._lids:
                if game.state.has(predicate, index) is not truth:
                    atom = Atom(predicate, (Constant(names[index].name),))
                    lids.append((index, atom if truth else Not(atom)))
        return lids


class _GoldPlanAgentThatExplores(_Explorer):
    """Agent ``seeker``, which plays the correct plan that the task records.

    Before a step with objects that it has not seen, it explores.
    """

    def __init__(self, game: Game, seed: int = 0) -> None:
        super().__init__(game)
        self._steps = deque(game.task.script)

    def _find_plan(self) -> Sequence[Action]:
        """Return the next step of the gold plan.

        If the agent has not seen all objects of the step, return a plan that makes unseen objects visible.
        """
        if self._steps and not self._game.memory.known.issuperset(self._steps[0].arguments):
            return (
                self._plan_to_see_objects(self._pair_unvisited_objects_with_sight_goals())
                or self._plan_to_open_container()
            )
        return [self._steps.popleft()] if self._steps else ()


class _GreedyAgent(_Explorer):
    """Agent `eai/greedy`, which takes the action with the lowest estimated distance to the goals.

    The planner's heuristic makes the estimate. The agent explores as `eai/explorer` does. Unlike null
    agents, it knows the goals. It plans only one step ahead, but solves most tasks of the household
    benchmarks.
    """

    def __init__(self, game: Game, seed: int = 0) -> None:
        super().__init__(game)
        self._visited: set[State] = set()
        goal = to_planning_goal(game.task)
        self._actions = goal.actions
        self._target = (make_subgoals(goal.conditions, game.task.scene), len(goal.actions))

    def _find_plan_for_goals(self, limits: Limits = _LIMITS_OF_FIRST_SEARCH) -> Sequence[Action]:
        """Return a plan with one action, after which the estimated distance to the goals is smallest.

        The plan is empty if the agent has not seen an object of an unmet goal, or if no action is possible.
        """
        game = self._game
        self._visited.add(game.state)
        if not self._game.task.find_objects_named_in_goals(self._find_unreached_goals()) <= game.memory.known:
            return ()
        successors = SuccessorGenerator(self._domain, sorted(game.memory.known), self._actions)
        search = GreedySearch(self._planner.heuristic, successors, Limits(0))
        met = len(game.task.goals) - len(find_remaining_goals(game.task, game.executed_operators))
        node: PlanNode = SearchNode(game.state, met)
        costs: dict[Action, float] = {}
        for action in search.estimate_cost_and_preferred_actions(node, *self._target)[1][:_MAX_COMPARED]:
            after = successors.make_successor(node, action)
            if after is not None:
                been = _VISITED_COST * (after.state in self._visited)
                costs[action] = search.estimate_cost_and_preferred_actions(after, *self._target)[0] + been
        return [min(costs, key=costs.__getitem__)] if costs else ()


NULLS: Mapping[str, Callable[[Game, int], Agent]] = {
    "random": random_agent,
    "novel": novelty_seeking_agent,
    "blind": make_blind_agent,
}
"""The null agents by name. They do not know the goals."""

AGENTS: Mapping[str, Callable[[Game, int], Agent]] = {
    **NULLS,
    "oracle": make_reference_solution_agent,
    "gold": gold_plan_agent,
    "seeker": _GoldPlanAgentThatExplores,
    "planner": planner_agent,
    "explorer": _Explorer,
    "greedy": _GreedyAgent,
}
"""All agents by name. Except for ``gold`` and ``seeker`` they are built-in models."""
