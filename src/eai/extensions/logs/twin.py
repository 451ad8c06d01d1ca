"""Compare tasks in logs of other projects with tasks of a benchmark that have the same names.

Such a task of the benchmark, its twin, is the same activity in the benchmark's own symbolic world. It shows
the length of the activity, and which objects must be searched for. It proves nothing about the robot
in the log, which may face other conditions.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from eai.agents.game import Game
from eai.agents.reference import make_setup
from eai.agents.rules import GameRules
from eai.base.grouping import group_pairs
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.labels import derive_task_labels_from_goals
from eai.extensions.logs.episode import EpisodeEndReason, LoggedEpisode
from eai.results.table import Row, collect_rows_in_table
from eai.tasks.task import Task


@collect_rows_in_table(
    "twins",
    ("task", "outcomes", "labels", "reason", "hidden", "operators", "plan", "conditions", "at_start"),
)
def make_table_of_benchmark_tasks_named_in_logs(
    episodes: Iterable[LoggedEpisode], tasks: Mapping[str, Task], benchmark: Benchmark
) -> Iterator[Row]:
    """Logged tasks for which the benchmark has a task of the same name (twin), by length of its plan.

    outcomes: outcomes in the logs. All other columns describe the twin, which is a symbolic model and may
    differ from the logged task. labels: kinds of its goals, such as transport or ordered; plan: number of
    steps in the shortest known plan; operators: actions of the gold plan; hidden: objects of the gold plan
    that cannot be seen at the start; conditions: number of conditions in the goals; at_start: number of
    conditions that hold at the start; reason: why the twin has no plan.
    """
    by_task = group_pairs((episode.task, episode) for episode in episodes if episode.task in tasks)
    rows = [
        (
            name,
            ", ".join(map(_format_setting_and_outcome, of_task)),
            *_make_cells_about_benchmark_task(tasks[name], benchmark),
        )
        for name, of_task in by_task.items()
    ]
    yield from sorted(rows, key=lambda row: (row[6] is None, row[6]))


def _format_setting_and_outcome(episode: LoggedEpisode) -> str:
    is_late = episode.ending is EpisodeEndReason.OUT_OF_TIME
    return f"{episode.setting}: {episode.outcome.value}" + is_late * f" ({episode.ending.value})"


def _make_cells_about_benchmark_task(task: Task, benchmark: Benchmark) -> Row:
    """Return the cells of a row of the table `twins` that describe a benchmark's task.

    The cells are for the columns from ``labels`` to the last column.
    """
    labels = " ".join(derive_task_labels_from_goals(task, benchmark.data.labels))
    if task.unplannable_reason is not None:
        return labels, str(task.unplannable_reason), "", "", None, None, None
    setup = make_setup(task, benchmark, GameRules(observe="partial"))
    met, total = setup.share_of_conditions_met_at_start
    script = task.script or ()
    needed = {index for action in script for index in action.arguments}
    hidden = ", ".join(
        [task.scene.objects[index].name for index in sorted(needed.difference(Game(setup).memory.known))]
    )
    operators = ", ".join(dict.fromkeys(action.operator for action in script))
    return labels, "", hidden, operators, setup.reference.shortest, int(total), int(met)
