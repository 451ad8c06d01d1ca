"""Prepare a task for games, with the values that all games of the task share."""

from __future__ import annotations

from collections.abc import Callable
from copy import copy
from functools import cached_property
from math import ceil
from typing import TYPE_CHECKING, NamedTuple

from eai.agents.command import DONE, LOOK, CommandNotation
from eai.agents.observation import Observer, make_task_text
from eai.agents.rules import GameRules
from eai.base.errors import InputError
from eai.benchmarks.benchmark import Benchmark
from eai.tasks.goal_test import GoalTest
from eai.tasks.share import Share
from eai.tasks.task import Task

if TYPE_CHECKING:
    from eai.abilities.plan_repairer import PlanRepairer

_PAIR_ACTIONS = 50
"""Maximum number of actions in impossible and ambiguous tasks, and in their solvable variants.

The number is the same for all of these tasks, so that it does not show which task can be solved."""

_EXTRA_ACTIONS = 8
"""Number of actions for looking around, added to the allowed multiple of the shortest plan."""


class ReferenceSolution(NamedTuple):
    """The shortest known plan of a task, and commands that win the task.

    Attributes:
        shortest: number of actions of the shortest known plan, found with the whole scene known; a shorter
            plan may exist. None if no plan is known.
        commands: commands with which an agent with the game's view reaches all goals, without `DONE`. The
            first candidate that wins is chosen: the recorded reference plan, the gold plan, the plan of the
            agent ``explorer``, or the gold plan with commands that search for its objects. For an impossible
            task, the only command refuses the task. None if no candidate wins; the task is then left out of
            statistics.
    """

    shortest: int | None
    commands: tuple[str, ...] | None

    def compute_action_limit(self, factor: float) -> int:
        """Return the maximum number of actions of a game: enough to win and to look around.

        It is at least the number of the commands that are known to win.

        Args:
            factor: number by which the length of the shortest known plan is multiplied.
        """
        least = 0 if self.commands is None else len(self.commands)
        return max(ceil(factor * (self.shortest or 0)) + _EXTRA_ACTIONS, least)


class GameSetup:
    """A task that is ready to be played, with the values that all games of the task share.

    Args:
        task: the task.
        benchmark: the benchmark of the task.
        rules: the rules of its games.
        find_reference: finds the shortest known plan and winning commands, on first use.

    Raises:
        InputError: the task has no goals that can be reached, or an action is named like a command of agents.
    """

    def __init__(
        self,
        task: Task,
        benchmark: Benchmark,
        rules: GameRules,
        find_reference: Callable[[GameSetup], ReferenceSolution],
    ) -> None:
        if task.unplannable_reason is not None:
            raise InputError(f"{benchmark.name}: {task.id} cannot be played: {task.unplannable_reason}")
        operators = benchmark.domain.operator_arities
        if rules.until == "done" and DONE in operators:
            raise InputError(
                f"{benchmark.name}: the command {DONE} ends episodes, so no action may have this name"
            )
        if (rules.until == "done" or rules.feedback == "changes") and LOOK in operators:
            raise InputError(
                f"{benchmark.name}: the command {LOOK} lists what is visible, so no action may have this name"
            )
        wording = benchmark.observation_wording()
        self.task = task
        self.rules = rules
        self.benchmark = benchmark
        self.domain = benchmark.domain
        self.commands = CommandNotation(task, benchmark)
        self.observer = Observer(task, wording, rules.observe, rules.view)
        self.goals = GoalTest(task)
        self.opening = make_task_text(task, wording, rules)
        self._find_reference = find_reference

    @cached_property
    def share_of_conditions_met_at_start(self) -> Share:
        """The partial success before any action: the share of goal conditions that hold at the start."""
        initial, goals = self.task.initial, self.goals
        return goals.find_partial_success(initial, (), goals.evaluate_each_goal(initial, ()))

    @cached_property
    def reference(self) -> ReferenceSolution:
        """The shortest known plan, and commands that win the game under the rules of this setup.

        An agent that sees only part of the world may need more commands than the plan has.
        """
        return self._find_reference(self)

    @cached_property
    def action_limit(self) -> int | None:
        """Maximum number of actions of a game; None for no limit."""
        limits = [] if self.rules.max_steps is None else [self.rules.max_steps]
        if self.rules.budget is not None:
            is_of_pair = self.task.allows_declining_answers
            limits.append(
                _PAIR_ACTIONS if is_of_pair else self.reference.compute_action_limit(self.rules.budget)
            )
        return min(limits, default=None)

    @cached_property
    def repairer(self) -> PlanRepairer:
        """The object that repairs failed action sequences, to measure how close they are to success."""
        # imported here, since only the reward `repair` needs it
        from eai.abilities.plan_repairer import PlanRepairer

        return PlanRepairer(self.task, self.domain, self.benchmark.notation.plans)

    def copy_setup_without_failures_and_step_limit(self) -> GameSetup:
        """Return a copy of this setup in which actions never fail by chance and their number is not limited.

        Games end by `DONE`.
        """
        setup = copy(self)
        setup.rules = self.rules.model_copy(
            update={"slip": 0.0, "max_steps": None, "budget": None, "until": "done"}
        )
        setup.__dict__.pop("action_limit", None)
        return setup
