"""References: the shortest plan known to a task, and commands that win it with what they see."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import ceil
from typing import NamedTuple

from eai.abilities.goal_test import GoalTest, solves
from eai.abilities.planning import find_plan, planning_goal
from eai.abilities.task import Task
from eai.envs.agents import AGENTS, Agent, refusal_of
from eai.envs.command import DONE
from eai.envs.game import Game, Stage
from eai.planning.planner import needed_actions, planner_of
from eai.planning.search import Limits
from eai.planning.successor_generator import PlanNode
from eai.world.domain import Domain
from eai.world.execution import Action, execute

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
