from __future__ import annotations

from dataclasses import replace

import pytest

from eai.abilities.protocol import Ability, Protocol
from eai.abilities.task_features import TaskFeatures
from eai.abilities.verdict import ConfusionCounts, PlanVerdict
from eai.base.errors import InputError
from eai.results.codec import dataclass_to_json
from eai.results.record import Record
from eai.results.table import Estimate, Table
from eai.studies.perception import study as plot_perception
from eai.studies.perception.study import PLAIN, make_scene_format_comparison_tables
from eai.studies.perception.verdict import ScenePerceptionErrorCounts
from eai.studies.study import choose_metric
from experiments import experiment

SUCCESS = "task_success"
NOTHING_WRONG = ScenePerceptionErrorCounts(
    4, 2, 4, 0, 0, 0, 0, 3, 3, 0, 0, {"in": ConfusionCounts(2, 0, 0), "lit": ConfusionCounts(2, 0, 0)}
)
LOST_LIT = replace(
    NOTHING_WRONG,
    perceived=3,
    missing=1,
    predicates={"in": ConfusionCounts(2, 0, 0), "lit": ConfusionCounts(1, 0, 1)},
)
LOST_IN = replace(
    NOTHING_WRONG,
    missing=0,
    misplaced=1,
    predicates={"in": ConfusionCounts(1, 1, 1), "lit": ConfusionCounts(2, 0, 0)},
)
BLIND = replace(LOST_LIT, unseen=1, names=2)
EXTRA = replace(LOST_IN, unnecessary=1, perceived=5)


def record(
    task: int, scene: str | None, perceived: ScenePerceptionErrorCounts | None, *, success: bool
) -> Record:
    return Record(
        Protocol.STRICT,
        "kitchen",
        Ability.ACTION_SEQUENCING,
        "planner",
        str(task),
        "[]",
        "0",
        PlanVerdict(executable=success, success=success),
        task=TaskFeatures(f"name {task}", None, 1),
        experiment=None if scene is None else experiment(scene=scene),
        summaries={} if perceived is None else {"perception": dataclass_to_json(perceived)},
    )


PLAIN_RUN = [record(task, None, None, success=task != 5) for task in range(6)]
NOISY = [
    record(task, "noisy-1", seen, success=success)
    for task, (seen, success) in enumerate(
        [
            (NOTHING_WRONG, True),
            (LOST_LIT, True),
            (LOST_LIT, False),
            (LOST_IN, False),
            (BLIND, False),
            (EXTRA, False),
        ]
    )
]


def tables(*runs: list[Record]) -> dict[str, Table]:
    return {table.name: table for table in make_scene_format_comparison_tables(runs, SUCCESS)}


def plain(row: tuple[object, ...]) -> list[object]:
    """A row with the values of its estimates, rounded."""
    cells = [cell.value if isinstance(cell, Estimate) else cell for cell in row]
    return [round(cell, 1) if isinstance(cell, float) else cell for cell in cells]


def test_runs_are_sorted_by_their_perceived_error_rate() -> None:
    rows = [plain(row) for row in tables(NOISY, PLAIN_RUN)["perception_runs"].rows]
    assert rows == [
        [PLAIN, None, None, None, None, None, None, None, 83.3],
        ["noisy-1", 20.8, 12.5, 16.7, 4.5, 0.0, 5.6, None, 33.3],
    ]


def test_answers_are_grouped_by_error_rate_and_compared_on_the_same_tasks() -> None:
    rows = [plain(row) for row in tables(PLAIN_RUN, NOISY)["perception_rates"].rows]
    assert rows == [[0, 0, 1, 100.0, 100.0, 0.0], [20, 40, 5, 20.0, 80.0, 60.0]]


def test_the_cost_of_a_kind_counts_only_answers_without_other_kinds() -> None:
    rows = {row[0]: plain(row)[1:] for row in tables(PLAIN_RUN, NOISY)["perception_kinds"].rows}
    assert rows == {
        "none": [1, 100.0, 100.0, 0.0],
        "missing": [2, 50.0, 100.0, 50.0],
        "misplaced": [1, 0.0, 100.0, 100.0],
        "unseen object": [1, 0.0, 100.0, 100.0],
        "several": [1, 0.0, 0.0, 0.0],
    }


def test_predicates_with_the_highest_cost_come_first() -> None:
    rows = [plain(row) for row in tables(PLAIN_RUN, NOISY)["perception_predicates"].rows]
    assert rows == [
        ["in", 16.7, 2, 1, 0.0, 100.0, 100.0],
        ["lit", 25.0, 3, 2, 50.0, 100.0, 50.0],
    ]


def test_without_a_plain_run_costs_are_empty() -> None:
    found = tables(NOISY)["perception_predicates"].rows
    assert [plain(row) for row in found] == [
        ["in", 16.7, 2, 1, 0.0, None, None],
        ["lit", 25.0, 3, 2, 50.0, None, None],
    ]


def test_tasks_with_one_name_count_as_one_unit_in_intervals() -> None:
    """The interval of tasks of one name is as wide as that of one task."""
    alike = [replace(each, task=TaskFeatures("one name", None, 1)) for each in NOISY[1:3]]
    apart = tables(NOISY[1:3])["perception_runs"].rows[0][-1]
    together = tables(alike)["perception_runs"].rows[0][-1]
    assert isinstance(apart, Estimate)
    assert isinstance(together, Estimate)
    assert apart.low is not None
    assert together.low is None or together.low <= apart.low


def test_records_without_perception_and_unknown_metrics_are_refused() -> None:
    with pytest.raises(InputError, match="no record has a perceived scene"):
        make_scene_format_comparison_tables([PLAIN_RUN], SUCCESS)
    with pytest.raises(InputError, match="metric=speed: expected one of task_success"):
        choose_metric(Ability.ACTION_SEQUENCING, "speed")


def test_the_plot_has_one_point_per_run() -> None:
    pytest.importorskip("matplotlib")
    figure = plot_perception.draw_success_by_error_rate(tables(PLAIN_RUN, NOISY)["perception_runs"], SUCCESS)
    assert figure is not None
    (panel,) = figure.axes
    points = [(line.get_xdata()[0], line.get_ydata()[0]) for line in panel.lines]
    assert [round(float(value), 1) for point in points for value in point] == [0.0, 83.3, 20.8, 33.3]
    assert panel.get_xlabel() == "facts missing or misplaced, percent (n = 6)"
