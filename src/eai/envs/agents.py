"""Agents that need no model: nulls, which know nothing of the goals, and upper lines, which plan.

An agent is made for one game and returns its next command whenever it is called. The nulls take random
actions: possible ones, possible ones that lead to new states, or any. The upper lines read facts about what
has been seen from the state itself, and know the goals: they show how much the setting allows. The reference
of a task is the shortest plan known to it, and commands that win it with what they see.
"""

from __future__ import annotations

import random
from collections import Counter, deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from math import ceil
from typing import NamedTuple, TypeAlias

from eai.abilities.goal_test import GoalTest, remaining_goals, solves
from eai.abilities.planning import find_plan, planning_goal, why_no_plan
from eai.abilities.task import Goal, Task
from eai.abilities.verdict import REFUSE
from eai.envs.command import DONE
from eai.envs.game import Game, Stage
from eai.errors import InputError
from eai.generator.measures import lids, presence
from eai.logic.formula import Atom, Constant, Formula, Not, Variable
from eai.logic.rewriting import rewrite, with_terms
from eai.planning.greedy_search import GreedySearch
from eai.planning.planner import PlanningGoal, needed_actions, planner_of
from eai.planning.search import Limits, Node
from eai.planning.subgoal import subgoals_of
from eai.planning.successor_generator import PlanNode, SuccessorGenerator
from eai.world.action import Action
from eai.world.domain import Domain
from eai.world.execution import execute
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
        operators, known = game.stage.domain.operators, sorted(game.known)
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
        self._been.update(game.look.sight)
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
        self._been = {*self._game.look.sight}
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
        things, effort = game.known | self._absent(), (limits, len(game.known))
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
        known = tuple(sorted(self._game.known))
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
        places = [i for i in self._game.stage.view.landmarks if i not in self._been]
        return [(i, _about(visible, Constant(names[i].name))) for i in places]

    def _shut(self) -> Sequence[tuple[int, Formula]]:
        """Things that may hide something, and when they do not.

        First come things that goals name, then kinds that hid something or are new, and near things.
        """
        game, names = self._game, self._game.task.scene.objects
        near = set(game.look.sight)
        named = self._game.task.named_by(game.task.goals)

        def rank(index: int) -> tuple[bool, int, bool, int]:
            return index not in named, self._fruitless[self._kind(index)], index not in near, index

        found = []
        for index in sorted(game.known, key=rank):
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
        if self._steps and not self._game.known.issuperset(self._steps[0].arguments):
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
        if not self._game.task.named_by(self._pending()) <= game.known:
            return ()
        successors = SuccessorGenerator(self._domain, sorted(game.known), self._actions)
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


_EFFORT = Limits(5_000, looks=100_000)
"""How much is searched for a plan where none is known."""

_SHORTER = Limits(300, looks=50_000)
"""How much is searched for a shorter one than the gold plan."""

_LONGEST = 200
"""After how many actions a reference is given up."""

_ALLOWANCE = 8
"""How many actions looking around may cost."""


class Reference(NamedTuple):
    """How well a task can be played.

    Attributes:
        shortest: the length of the shortest plan known, by who knows the whole scene; nobody has proved that
            there is no shorter one. None where no plan is known.
        commands: commands that reach all goals with what they see, without `DONE`: the gold plan, or else an
            explorer's, or else the gold plan and commands that look for what it names; a refusal where there
            is no plan; None where none of these wins and the task is left out.
    """

    shortest: int | None
    commands: tuple[str, ...] | None

    def budget(self, times: float) -> int:
        """The number of actions that an agent has: enough to look around, and for the reference."""
        least = 0 if self.commands is None else len(self.commands)
        return max(ceil(times * (self.shortest or 0)) + _ALLOWANCE, least)


def reference_of(stage: Stage) -> Reference:
    """The reference of a task, in the view of its stage."""
    if stage.task.missing:
        return Reference(None, (refusal_of(stage),))
    lengths = [len(plan) for plan in _plans(stage.task, stage.domain)]
    endless = stage.endless()
    for name in ("gold", "explorer", "seeker"):
        game = Game(endless)
        commands = _played(game, AGENTS[name](game, 0))
        if all(game.reached):
            return Reference(min([*lengths, len(commands)]), commands)
    return Reference(min(lengths, default=None), None)


def _played(game: Game, agent: Agent) -> tuple[str, ...]:
    """The commands of an agent up to `DONE`."""
    commands: list[str] = []
    while len(commands) < _LONGEST and (command := agent()) != DONE:
        game.act(command)
        commands.append(command)
    return tuple(commands)


def _plans(task: Task, domain: Domain) -> Iterator[Sequence[Action]]:
    """The plans that are known: the gold one without needless actions, and the planner's."""
    gold = execute(domain, task.initial, task.script).executed
    has_gold = bool(task.script) and solves(domain, task, gold)
    if has_gold:
        yield gold if any(goal.is_over_time for goal in task.goals) else _shortened(task, domain, gold)
    plan = find_plan(task, planner_of(domain), _SHORTER if has_gold else _EFFORT).plan
    if solves(domain, task, plan):
        yield plan


def _shortened(task: Task, domain: Domain, plan: Sequence[Action]) -> Sequence[Action]:
    """A plan without actions that its goals do not need."""
    test, actions = GoalTest(task), planning_goal(task).actions

    def reached(node: PlanNode) -> bool:
        return node.met == len(actions) and test.all_lasting(node.state)

    return needed_actions(domain, task.initial, plan, reached, actions)
