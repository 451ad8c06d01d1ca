"""Find the reference of a task: its shortest known plan, and commands that reach its goals in an episode.

A task from a task file may record both. Each recorded plan is carried out before it is used.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

from eai.abilities.declining import write_agent_command_refusing_task
from eai.abilities.protocol import Ability
from eai.agents.agents import AGENTS
from eai.agents.command import DONE
from eai.agents.game import Game
from eai.agents.game_setup import GameSetup, ReferenceSolution
from eai.agents.rules import STANDARD, TRAINING, GameRules
from eai.base.errors import InputError, did_you_mean
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
from eai.world.fault import FaultKind

_PLAN_LIMITS = Limits(5_000, looks=100_000)
"""Limits of the search for a plan of a task without a gold plan."""

_SHORTER_PLAN_LIMITS = Limits(300, looks=50_000)
"""Limits of the search for a plan that is shorter than the gold plan."""

_MAX_COMMANDS = 200
"""Number of commands after which a built-in agent that searches for a way to win a task gives up."""

_MAX_CACHED_SETUPS = 4096
"""Maximum number of cached setups (tasks prepared for games). Making a setup takes some milliseconds."""


@lru_cache(_MAX_CACHED_SETUPS)
def find_setup(task: str, rules: GameRules = TRAINING) -> GameSetup:
    """Return the world, goals and rules with which a task can be played as a game, action by action.

    Args:
        task: a task, as ``BENCHMARK/action_sequencing/TASK``.
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
        hint = did_you_mean(reference.task_id, suite.task_ids)
        raise InputError(f"{suite.domain} has no task {reference.task_id!r}{hint}")
    return make_setup(suite.tasks[reference.task_id], suite.benchmark, rules)


@lru_cache(_MAX_CACHED_SETUPS)
def make_setup(task: Task, benchmark: Benchmark, rules: GameRules) -> GameSetup:
    """Return the setup of a task (the task prepared for games), which players and scorers share.

    Raises:
        InputError: the task cannot be played.
    """
    return GameSetup(task, benchmark, rules, find_reference_solution)


def find_reference_solution(setup: GameSetup) -> ReferenceSolution:
    """Return the length of a task's shortest known plan, and commands that win a game with a given setup.

    Plans that the task records are carried out. Other plans are searched for.

    Raises:
        InputError: a plan that the task records does not reach the goals.
    """
    task = setup.task
    refusal = write_agent_command_refusing_task(task, setup.benchmark.notation.plans)
    if refusal is not None:
        return ReferenceSolution(None, (refusal,))
    if task.shortest_plan and not solves_task(setup.domain, task, task.shortest_plan):
        raise InputError(
            f"{task.id}: the plan `shortest` does not reach the goals; correct it, or leave it out "
            "(`eai check` shows the failed step)"
        )
    plans = [task.shortest_plan] if task.shortest_plan else _find_plans(task, setup.domain)
    lengths = [len(plan) for plan in plans]
    if task.reference_plan and _has_standard_visibility(setup.rules):
        for mistake in _find_mistakes_in_reference(setup):
            raise InputError(
                f"{task.id}: correct the plan `reference`, or leave it out; it does not win: {mistake}"
            )
        commands = tuple(map(setup.commands.write_command, task.reference_plan))
        return ReferenceSolution(min([*lengths, len(commands)]), commands)
    won = next(_find_games_won_by_agents(setup), None)
    if won is None:
        return ReferenceSolution(min(lengths, default=None), None)
    return ReferenceSolution(min([*lengths, len(won.commands)]), won.commands)


class _CommandsOfWonGame(NamedTuple):
    """Commands of a game that reached all goals, without the final `DONE`.

    Attributes:
        commands: the commands as text.
        actions: the actions that they name.
    """

    commands: tuple[str, ...]
    actions: tuple[Action, ...]


def _find_games_won_by_agents(setup: GameSetup) -> Iterator[_CommandsOfWonGame]:
    """Let built-in agents play a task without a limit of actions. Yield each game that reaches all goals."""
    endless = setup.copy_setup_without_failures_and_step_limit()
    for name in ("gold", "explorer", "seeker"):
        game = Game(endless)
        agent, commands, actions = AGENTS[name](game, 0), list[str](), list[Action]()
        while len(commands) < _MAX_COMMANDS and (command := agent()) != DONE:
            game.act(command)
            commands.append(command)
            actions += [] if game.action is None else [game.action]
        if all(game.reached):
            yield _CommandsOfWonGame(tuple(commands), tuple(actions))


def _has_standard_visibility(rules: GameRules) -> bool:
    """Whether agents see as much of the world by these rules as by the standard rules."""
    return (rules.view, rules.observe) == (STANDARD.view, STANDARD.observe)


def _find_mistakes_in_reference(setup: GameSetup) -> Iterator[str]:
    """Play the actions that a task records as its reference. Yield a message if they do not win."""
    game = Game(setup.copy_setup_without_failures_and_step_limit())
    for number, action in enumerate(setup.task.reference_plan):
        game.act(setup.commands.write_command(action))
        if game.outcome.fault not in (None, FaultKind.ADDITIONAL_STEP):
            yield f"reference.{number}: expected an action that is possible: {game.outcome.text}"
            return
    if not all(game.reached):
        yield f"reference: expected to reach goals.{game.reached.index(False)}"


def add_reference_plans(task: Task, benchmark: Benchmark) -> Task:
    """Return a copy of a task that records two plans: the shortest known plan, and the reference plan.

    The reference plan reaches the goals in an episode with the options `STANDARD`, in which agents see only a
    part of the world. If no plan is known, an empty plan is recorded. A task is returned unchanged if it
    records a shortest plan or has no plan, or if its domain has an operator named `DONE`.
    """
    if task.shortest_plan or task.has_no_plan or DONE in benchmark.domain.operator_arities:
        return task
    setup = GameSetup(task, benchmark, STANDARD, find_reference_solution)
    reference = next((game.actions for game in _find_games_won_by_agents(setup)), ())
    plans = [
        *_find_plans(task, benchmark.domain),
        *([execute_plan(benchmark.domain, task.initial, reference).executed_actions] if reference else []),
    ]
    shortest = min(plans, key=len, default=())
    return replace(task, shortest_plan=tuple(shortest), reference_plan=reference)


def describe_wrong_recorded_plans(
    task: Task, benchmark: Benchmark, *, searches_shorter_plans: bool
) -> Iterator[str]:
    """Yield a message on each wrong plan that a task records: its shortest plan, or its reference plan.

    The shortest plan may need knowledge of the whole scene. An agent in the standard setting, which sees only
    a part of the world, can carry out the reference plan.

    Args:
        task: a task whose recorded plans reach its goals (`eai.tasks.task_files.find_mistakes_in_task`).
        benchmark: the benchmark of the task.
        searches_shorter_plans: whether shorter plans are searched for. Otherwise, only the reference plan is
            played.
    """
    recorded = {"shortest": task.shortest_plan, "reference": task.reference_plan}
    if task.reference_plan:
        setup = GameSetup(task, benchmark, STANDARD, find_reference_solution)
        yield from _find_mistakes_in_reference(setup)
    if not searches_shorter_plans or not any(recorded.values()):
        return
    found = add_reference_plans(replace(task, shortest_plan=(), reference_plan=()), benchmark)
    for member, plan in (("shortest", found.shortest_plan), ("reference", found.reference_plan)):
        number = len(recorded[member])
        if 0 < len(plan) < number:
            yield f"{member}: expected at most {len(plan)} steps, as a search finds, found {number}"


def _find_plans(task: Task, domain: Domain) -> Iterator[Sequence[Action]]:
    """Yield the task's gold plan without needless actions, and a plan that a planner finds.

    A plan that does not solve the task is left out.
    """
    gold = execute_plan(domain, task.initial, task.script).executed_actions
    has_gold = bool(task.script) and solves_task(domain, task, gold)
    if has_gold:
        yield (
            gold
            if any(goal.is_temporal for goal in task.goals)
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
