"""Replay logged actions in a task, which shows the kinds of errors and the progress of an episode."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from eai.agents.command import CommandNotation
from eai.benchmarks.benchmark import Benchmark
from eai.extensions.logs.episode import EpisodeOutcome, LoggedEpisode, LoggedStep
from eai.tasks.goal_test import GoalTest
from eai.tasks.task import Task
from eai.world.action import Action, Fault
from eai.world.episode import Episode
from eai.world.fault import FaultKind


class _LoggedCommandReplayer:
    """Executes logged commands in the world of a task, and measures how many goal conditions hold."""

    def __init__(self, task: Task, benchmark: Benchmark) -> None:
        self._world = Episode(benchmark.domain, task.initial)
        self._commands = CommandNotation(task, benchmark)
        self._objects = range(len(task.scene.objects))
        self._goals = GoalTest(task)

    def try_command(self, command: str) -> FaultKind | None:
        """Try a command; return the kind of error, or None if the command was carried out."""
        meaning, _ = self._commands.read_command_and_repairs(command, self._objects, may_end_episode=False)
        if not isinstance(meaning, Action):
            return FaultKind.PARSING if meaning is None else meaning.kind
        outcome = self._world.act(meaning)
        return outcome.kind if isinstance(outcome, Fault) else None

    def measure_share_of_met_goal_conditions(self) -> float:
        """Return the share of the goal's conditions that hold now."""
        trajectory = self._world.trajectory
        operators = [action.operator for action in trajectory.executed_actions]
        reached = self._goals.evaluate_each_goal(self._world.state, operators, trajectory)
        met, total = self._goals.find_partial_success(self._world.state, operators, reached)
        return 1.0 if all(reached) else min(met / total, 0.999)


def replay_steps(
    episode: LoggedEpisode, commands: Sequence[str | None], task: Task, benchmark: Benchmark
) -> LoggedEpisode:
    """Return an episode with the kinds of errors and the progress that a replay of its actions shows.

    The replay ends before the first action whose result differs from the result in the log. This action and
    all later actions stay as they are in the log. If the log states no outcome, a replay to the end shows the
    outcome.

    Args:
        episode: the episode.
        commands: the command of each action; None for an action that changed nothing and is not tried.
        task: the task.
        benchmark: the benchmark of the task.
    """
    replay, steps = _LoggedCommandReplayer(task, benchmark), list[LoggedStep]()
    for step, command in zip(episode.steps, commands, strict=True):
        kind = step.kind if command is None else replay.try_command(command)
        if command is not None and step.accepted not in (None, kind is None):
            break
        accepted = step.accepted if command is None else kind is None
        steps.append(
            step._replace(
                accepted=accepted, kind=kind, progress=replay.measure_share_of_met_goal_conditions()
            )
        )
    done = len(steps)
    if done < len(episode.steps):
        kept = [name for name in episode.unknown if name != "kinds of errors"]
        unknown = (f"a world that agrees with action {done + 1}", *kept)
        return replace(episode, steps=(*steps, *episode.steps[done:]), unknown=unknown)
    outcome, end = episode.outcome, replay.measure_share_of_met_goal_conditions()
    if outcome is EpisodeOutcome.CANNOT_TELL:
        outcome = EpisodeOutcome.WON if end == 1 else EpisodeOutcome.GOAL_UNMET
    return replace(episode, steps=tuple(steps), outcome=outcome, progress=end, unknown=())
