"""Agents without a model: null agents, which do not know the goals, and planning agents.

An agent is made for one game and returns its next command whenever it is called. Null agents take random
actions: possible actions, possible actions that lead to new states, or any actions. Planning agents know the
goals and read facts about known objects from the state: they show how much the setting allows.
"""

from __future__ import annotations

import random
from collections import Counter, deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import TypeAlias

from eai.abilities.verdict import REFUSE
from eai.agents.command import DONE
from eai.agents.game import Game
from eai.agents.stage import Stage
from eai.base.errors import InputError
from eai.benchmarks.generator.measures import lids, presence
from eai.logic.formula import Atom, Constant, Formula, Not, Variable
from eai.logic.rewriting import rewrite, with_terms
from eai.planning.greedy_search import GreedySearch
from eai.planning.planner import PlanningGoal, planner_of
from eai.planning.search import Limits, Node
from eai.planning.subgoal import subgoals_of
from eai.planning.successor_generator import PlanNode, SuccessorGenerator
from eai.tasks.goal_test import remaining_goals
from eai.tasks.planning import find_plan, planning_goal, why_no_plan
from eai.tasks.task import Goal
from eai.world.action import Action
from eai.world.state import State

Agent: TypeAlias = Callable[[], str]
"""Returns the next command in the game that it was made for."""

_TRIES = 60
"""How many possible actions the novel agent looks at for one that leads to a new state."""

_BREADTH = 12
"""How many actions the greedy agent looks ahead along."""

_DETOUR = 1000
"""How much worse than any other a state is where it has been."""

_GOAL = Limits(200, thorough=False, looks=8_000)
"""How much the explorer searches for a plan with what it has seen."""

_MORE = Limits(300, looks=15_000)
"""How much it does so where it has been everywhere, before it opens things."""

_LAST = Limits(2_000)
"""How much it does so when nothing is left to look at."""

_SIGHT = Limits(50)
"""How much it searches for a way to see more."""


def random_agent(game: Game, seed: int = 0) -> Agent:
    """`eai/random`: any possible action about what has been seen, or `DONE`, all with the same chance."""
    rng = _rng(game, seed)

    def command() -> str:
        actions = [*game.admissible()]
        chosen = rng.randrange(len(actions) + 1)
        return DONE if chosen == len(actions) else game.stage.commands.write(actions[chosen])

    return command


def novel_agent(game: Game, seed: int = 0) -> Agent:
    """`eai/novel`: as the random one, but of the actions one that leads to a state where it has not been."""
    rng, visited = _rng(game, seed), set[State]()

    def command() -> str:
        visited.add(game.state)
        actions = [*game.admissible()]
        if not rng.randrange(len(actions) + 1):
            return DONE
        rng.shuffle(actions)
        domain, state = game.stage.domain, game.state
        new = (each for each in actions[:_TRIES] if domain.after(state, each) not in visited)
        return game.stage.commands.write(next(new, actions[0]))

    return command


def blind_agent(game: Game, seed: int = 0) -> Agent:
    """`eai/blind`: any operator with any objects that have been seen, possible or not, or `DONE`."""
    rng = _rng(game, seed)

    def command() -> str:
        operators, known = game.stage.domain.operators, sorted(game.memory.known)
        chosen = rng.randrange(len(operators) + 1)
        if chosen == len(operators):
            return DONE
        operator = operators[chosen]
        arguments = tuple([rng.choice(known) for _ in range(operator.arity)])
        return game.stage.commands.write(Action(operator.name, arguments))

    return command


def _rng(game: Game, seed: int) -> random.Random:
    return random.Random(f"{seed} {game.task.id}")  # noqa: S311 - chance, not secrets


def reference_agent(game: Game, seed: int = 0) -> Agent:
    """The reference that can be played in this view, then `DONE`."""
    return _following(game.stage.reference.commands or ())


def gold_agent(game: Game, seed: int = 0) -> Agent:
    """The data set's own plan, or else the planner's, then `DONE`; a refusal of what has no plan."""
    if game.task.missing:
        return lambda: refusal_of(game.stage)
    plan = game.task.script or find_plan(game.task, planner_of(game.stage.domain)).plan
    return _following(map(game.stage.commands.write, plan))


def refusal_of(stage: Stage) -> str:
    """The command that says what a task lacks."""
    return stage.benchmark.plans.encoded(f"{REFUSE}({', '.join(stage.task.missing or ())})")


def planner_agent(game: Game, seed: int = 0) -> Agent:
    """Return `eai/planner`, which knows the whole scene and carries out a plan, then says `DONE`.

    Raises:
        InputError: the planner finds no plan.
    """
    found = find_plan(game.task, planner_of(game.stage.domain))
    if reason := why_no_plan(found.end):
        raise InputError(reason)
    return _following(map(game.stage.commands.write, found.plan))


def _following(commands: Iterable[str]) -> Agent:
    pending = iter(commands)
    return lambda: next(pending, DONE)


def _about(formula: Formula, thing: Constant) -> Formula:
    """A formula about ``x``, said of a thing."""
    x = Variable("x")
    return rewrite(
        formula,
        lambda leaf, bound: (
            leaf if "x" in bound else with_terms(leaf, lambda term: thing if term == x else term)
        ),
    )


class _Explorer:
    """`eai/explorer`: plans over what it has seen, and looks further where that does not reach the goals.

    Looking further is to go where it has not been, landmark by landmark, and then to open what may hide
    something, as the domain's `visible` says. It says `DONE` when all goals hold, or nothing is left to try.

    Args:
        game: the game, which it plays from now on.
        seed: as of all agents; nothing is left to chance.
    """

    def __init__(self, game: Game, seed: int = 0) -> None:
        self._game = game
        self._domain = game.stage.domain
        self._planner = planner_of(self._domain)
        self._plan: deque[Action] = deque()
        self._expected: State | None = None
        self._planned = set[tuple[Limits, int]]()
        self._been: set[int] = set()
        self._opened: tuple[str, int] | None = None
        self._has_opened = False
        self._fruitless: Counter[str] = Counter()
        self._tried: set[tuple[Formula, bool]] = set()
        self._lids = tuple(dict.fromkeys(lids(self._domain)))
        self._present = presence(self._domain)

    def __call__(self) -> str:
        """The next command."""
        game = self._game
        self._been.update(game.memory.observation.visible)
        if all(game.reached):
            return DONE
        if self._expected != game.state:
            self._plan.clear()
        if not self._plan:
            self._plan.extend(self._further() or self._once_more())
        if not self._plan:
            return DONE
        action = self._plan.popleft()
        self._expected = self._domain.after(game.state, action)
        return game.stage.commands.write(action)

    def _further(self) -> Sequence[Action]:
        """A plan to the goals, or to see more."""
        return (
            self._to_goals()
            or self._to_sight(self._places())
            or self._to_goals(_MORE)
            or self._to_open()
            or self._to_goals(_LAST)
        )

    def _to_open(self) -> Sequence[Action]:
        plan = self._to_sight(self._shut())
        self._has_opened |= bool(plan)
        return plan

    def _once_more(self) -> Sequence[Action]:
        """The same from the beginning, if something was opened: what was in it may be seen from elsewhere."""
        if not self._has_opened:
            return ()
        self._has_opened = False
        self._been = {*self._game.memory.observation.visible}
        self._tried.clear()
        return self._further()

    def _kind(self, index: int) -> str:
        return self._game.task.scene.objects[index].category

    def _pending(self) -> list[Goal]:
        """The goals that are not reached."""
        goals = zip(self._game.task.goals, self._game.reached, strict=True)
        return [goal for goal, reached in goals if not reached]

    def _to_goals(self, limits: Limits = _GOAL) -> Sequence[Action]:
        """A plan to the goals, if all that they name and do not have yet has been seen or is to be made.

        It is looked for with what they name, and else with all such things.
        """
        game, task = self._game, self._game.task
        things, effort = game.memory.known | self._absent(), (limits, len(game.memory.known))
        if not self._game.task.named_by(self._pending()) <= things or effort in self._planned:
            return ()
        self._planned.add(effort)
        now = replace(task, initial=game.state, goals=remaining_goals(task, game.taken))
        for usable in (self._game.task.named_by(task.goals) & things, things):
            plan = find_plan(replace(now, relevant=tuple(sorted(usable))), self._planner, limits).plan
            if plan:
                return plan
        return ()

    def _absent(self) -> set[int]:
        """The objects of the task that are not there yet, which can be made: no place hides them."""
        holds = self._planner.heuristic.readings.holds
        state, present = self._game.state, self._present
        return {i for i in self._game.task.relevant if not holds(present, {"x": i}, state)}

    def _to_sight(self, hopes: Sequence[tuple[int, Formula]]) -> Sequence[Action]:
        """A plan to see what may be hidden: by actions about one thing, or else about all that is known."""
        known = tuple(sorted(self._game.memory.known))
        if self._opened is not None and len(known) == self._opened[1]:
            self._fruitless[self._opened[0]] += 1
        self._opened = None
        for by_itself in (True, False):
            for index, condition in hopes:
                if (condition, by_itself) not in self._tried:
                    self._tried.add((condition, by_itself))
                    goal, usable = PlanningGoal((condition,)), (index,) if by_itself else known
                    limits = replace(_SIGHT, thorough=by_itself)
                    plan = self._planner.plan(self._game.state, goal, usable, limits).plan
                    if plan:
                        self._opened = self._kind(index), len(known)
                        return plan
        return ()

    def _places(self) -> Sequence[tuple[int, Formula]]:
        """The landmarks where it has not been, and when it sees them."""
        visible, names = self._domain.visible, self._game.task.scene.objects
        if visible is None:
            return ()
        places = [i for i in self._game.stage.observer.landmarks if i not in self._been]
        return [(i, _about(visible, Constant(names[i].name))) for i in places]

    def _shut(self) -> Sequence[tuple[int, Formula]]:
        """Things that may hide something, and when they do not.

        First come things that goals name, then kinds that hid something or are new, and near things.
        """
        game, names = self._game, self._game.task.scene.objects
        near = set(game.memory.observation.visible)
        named = self._game.task.named_by(game.task.goals)

        def rank(index: int) -> tuple[bool, int, bool, int]:
            return index not in named, self._fruitless[self._kind(index)], index not in near, index

        found = []
        for index in sorted(game.memory.known, key=rank):
            for predicate, truth in self._lids:
                if game.state.has(predicate, index) is not truth:
                    atom = Atom(predicate, (Constant(names[index].name),))
                    found.append((index, atom if truth else Not(atom)))
        return found


class _Seeker(_Explorer):
    """The data set's own plan; it looks for what a step names before it, as the explorer looks further."""

    def __init__(self, game: Game, seed: int = 0) -> None:
        super().__init__(game)
        self._steps = deque(game.task.script)

    def _further(self) -> Sequence[Action]:
        """The next step, if what it names has been seen, or a plan to see more."""
        if self._steps and not self._game.memory.known.issuperset(self._steps[0].arguments):
            return self._to_sight(self._places()) or self._to_open()
        return [self._steps.popleft()] if self._steps else ()


class _Greedy(_Explorer):
    """`eai/greedy`: of the possible actions the one after which the planner's heuristic is least.

    It looks further as the explorer does. It is an upper line, no null: one step of planning wins most of the
    public tasks.
    """

    def __init__(self, game: Game, seed: int = 0) -> None:
        super().__init__(game)
        self._visited: set[State] = set()
        goal = planning_goal(game.task)
        self._actions = goal.actions
        self._target = (subgoals_of(goal.conditions, game.task.scene), len(goal.actions))

    def _to_goals(self, limits: Limits = _GOAL) -> Sequence[Action]:
        """The action that seems best, if all that the goals name and do not have yet has been seen."""
        game = self._game
        self._visited.add(game.state)
        if not self._game.task.named_by(self._pending()) <= game.memory.known:
            return ()
        successors = SuccessorGenerator(self._domain, sorted(game.memory.known), self._actions)
        search = GreedySearch(self._planner.heuristic, successors, Limits(0))
        met = len(game.task.goals) - len(remaining_goals(game.task, game.taken))
        node: PlanNode = Node(game.state, met)
        costs: dict[Action, float] = {}
        for action in search.estimate(node, *self._target)[1][:_BREADTH]:
            after = successors.successor(node, action)
            if after is not None:
                been = _DETOUR * (after.state in self._visited)
                costs[action] = search.estimate(after, *self._target)[0] + been
        return [min(costs, key=costs.__getitem__)] if costs else ()


NULLS: Mapping[str, Callable[[Game, int], Agent]] = {
    "random": random_agent,
    "novel": novel_agent,
    "blind": blind_agent,
}
"""The agents that know nothing of the goals."""

AGENTS: Mapping[str, Callable[[Game, int], Agent]] = {
    **NULLS,
    "oracle": reference_agent,
    "gold": gold_agent,
    "seeker": _Seeker,
    "planner": planner_agent,
    "explorer": _Explorer,
    "greedy": _Greedy,
}
"""All agents, of which those but ``gold`` and ``seeker`` are built-in models."""
