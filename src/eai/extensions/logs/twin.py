"""Describe symbolic twins: tasks of a benchmark with the names of logged tasks, in the benchmark's own world.

A twin shows the length of an activity, and the objects to search for. It proves nothing about a robot.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from eai.agents.game import Game
from eai.agents.reference import make_setup
from eai.agents.rules import GameRules
from eai.base.grouping import group_pairs
from eai.benchmarks.benchmark import Benchmark
from eai.extensions.logs.episode import LoggedEpisode
from eai.results.table import Row, make_table
from eai.tasks.task import Task


@make_table("twins", ("task", "outcomes", "reason", "hidden", "operators", "plan", "conditions", "at_start"))
def make_twins_table(
    episodes: Iterable[LoggedEpisode], tasks: Mapping[str, Task], benchmark: Benchmark
) -> Iterator[Row]:
    """Tasks with a symbolic twin, by length.

    outcomes: the logged outcomes. All other columns describe the twin and prove nothing about a robot. plan:
    number of steps of the shortest known plan; operators: actions of the gold plan; hidden: objects of the
    gold plan that cannot be seen at the start; conditions: conditions of the goal; at_start: conditions that
    hold at the start; reason: why the twin has no plan.
    """
    by_task = group_pairs((episode.task, episode) for episode in episodes if episode.task in tasks)
    rows = []
    for name, of_task in by_task.items():
        outcomes = ", ".join([f"{episode.setting}: {episode.outcome.value}" for episode in of_task])
        rows.append((name, outcomes, *_describe(tasks[name], benchmark)))
    yield from sorted(rows, key=lambda row: (row[5] is None, row[5]))


def _describe(task: Task, benchmark: Benchmark) -> Row:
    """Return the cells of a benchmark's task in the table of twins, from the column `reason` on."""
    if task.unplannable_reason is not None:
        return str(task.unplannable_reason), "", "", None, None, None
    setup = make_setup(task, benchmark, GameRules(observe="partial"))
    met, total = setup.share_of_conditions_met_at_start
    needed = {index for action in task.script or () for index in action.arguments}
    hidden = sorted(needed.difference(Game(setup).memory.known))
    names = ", ".join([task.scene.objects[index].name for index in hidden])
    operators = ", ".join(dict.fromkeys(action.operator for action in task.script or ()))
    return "", names, operators, setup.reference.shortest, int(total), int(met)
