"""Find the reference of a task: its shortest known plan, and commands that win its games."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import lru_cache

from eai.abilities.declining import write_refusal_command
from eai.abilities.protocol import Ability
from eai.agents.agents import AGENTS, Agent
from eai.agents.command import DONE
from eai.agents.game import Game
from eai.agents.game_setup import GameSetup, ReferenceSolution
from eai.agents.rules import TRAINING, GameRules
from eai.base.errors import InputError
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.names import TaskReference
from eai.planning.planner import drop_needless_actions, get_planner
from eai.planning.search import Limits
from eai.planning.successor_generator import PlanNode
from eai.results.reward import open_reward_suite
from eai.tasks.goal_test import GoalTest, solves_task
from eai.tasks.planning import find_plan, to_planning_goal
from eai.tasks.task import Task
from eai.world.action import Action
from eai.world.domain import Domain
from eai.world.execution import execute_plan

_PLAN_LIMITS = Limits(5_000, looks=100_000)
"""Limits of the search for a plan of a task without a gold plan."""

_SHORTER_PLAN_LIMITS = Limits(300, looks=50_000)
"""Limits of the search for a plan that is shorter than the gold plan."""

_MAX_COMMANDS = 200
"""Maximum number of commands that an agent may need to win a task, in the search for winning commands."""

_MAX_STAGES = 4096
"""Maximum number of setups of games in the cache. Making a setup takes some milliseconds."""


@lru_cache(_MAX_STAGES)
def find_setup(task: str, rules: GameRules = TRAINING) -> GameSetup:
    """Return the setup for games of the task with this name.

    Args:
        task: name of a task of action sequencing, as `Suite.reference` writes it.
        rules: the rules of the games.

    Raises:
        InputError: the task does not exist, or it cannot be played.
        DataError: the data cannot be obtained.
    """
    reference = TaskReference.parse(task)
    if reference.ability is not Ability.ACTION_SEQUENCING:
        raise InputError(
            f"{task}: expected a task of {Ability.ACTION_SEQUENCING.value}, because only these are played"
        )
    suite = open_reward_suite(reference.benchmark, reference.ability)
    if reference.task_id not in suite.tasks:
        raise InputError(f"{suite.domain} has no task {reference.task_id!r}")
    return make_setup(suite.tasks[reference.task_id], suite.benchmark, rules)


@lru_cache(_MAX_STAGES)
def make_setup(task: Task, benchmark: Benchmark, rules: GameRules) -> GameSetup:
    """Return the setup for games of a task. Players and scorers of the task share a cached setup.

    Raises:
        InputError: the task cannot be played.
    """
    return GameSetup(task, benchmark, rules, find_reference_solution)


def find_reference_solution(setup: GameSetup) -> ReferenceSolution:
    """Return the shortest known plan of a task, and commands that win the games of its setup."""
    refusal = write_refusal_command(setup.task, setup.benchmark.notation.plans)
    if refusal is not None:
        return ReferenceSolution(None, (refusal,))
    lengths = [len(plan) for plan in _find_plans(setup.task, setup.domain)]
    endless = setup.make_setup_without_limits()
    for name in ("gold", "explorer", "seeker"):
        game = Game(endless)
        commands = _play_agent(game, AGENTS[name](game, 0))
        if all(game.reached):
            return ReferenceSolution(min([*lengths, len(commands)]), commands)
    return ReferenceSolution(min(lengths, default=None), None)


def _play_agent(game: Game, agent: Agent) -> tuple[str, ...]:
    """Let an agent play a game. Return its commands before `DONE`."""
    commands: list[str] = []
    while len(commands) < _MAX_COMMANDS and (command := agent()) != DONE:
        game.act(command)
        commands.append(command)
    return tuple(commands)


def _find_plans(task: Task, domain: Domain) -> Iterator[Sequence[Action]]:
    """Yield the gold plan without needless actions, and the planner's plan, if each solves the task."""
    gold = execute_plan(domain, task.initial, task.script).executed_actions
    has_gold = bool(task.script) and solves_task(domain, task, gold)
    if has_gold:
        yield (
            gold
            if any(goal.is_over_time for goal in task.goals)
            else _drop_needless_actions(task, domain, gold)
        )
    limits = _SHORTER_PLAN_LIMITS if has_gold else _PLAN_LIMITS
    plan = find_plan(task, get_planner(domain), limits).plan
    if solves_task(domain, task, plan):
        yield plan


def _drop_needless_actions(task: Task, domain: Domain, plan: Sequence[Action]) -> Sequence[Action]:
    """Return a plan without the actions that the goals of the task do not need."""
    test, actions = GoalTest(task), to_planning_goal(task).actions

    def is_solution(node: PlanNode) -> bool:
        return node.met == len(actions) and test.meets_goals_about_states(node.state)

    return drop_needless_actions(domain, task.initial, plan, is_solution, actions)
