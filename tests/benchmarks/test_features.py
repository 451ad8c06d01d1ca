from __future__ import annotations

import pytest

from eai.base.store import Store
from eai.benchmarks.features import TaskStatistics, compute_features
from eai.benchmarks.registry import find_benchmark
from eai.tasks.source import ErrataChoice, Source
from studies.lamps import lamp_task, lamps


def test_a_task_has_its_expected_features() -> None:
    assert compute_features(lamp_task(), lamps()) == TaskStatistics(
        annotated_steps=6,
        annotated_operators=4,
        tool_steps=1,
        goals=2,
        state_goals=1,
        relation_goals=0,
        action_goals=1,
        quantified_goals=1,
        goal_options=1,
        ground_goals=3,
        ground_state_goals=2,
        ground_relation_goals=0,
        ground_action_goals=1,
        goals_at_start=0,
        objects=4,
        object_categories=3,
        initial_facts=2,
        instruction_words=4,
    )


@pytest.mark.parametrize(
    ("domain", "sums"),
    [
        ("behavior", {"goals": 366, "ground_goals": 673, "goal_options": 416441, "annotated_steps": 1455}),
        ("virtualhome", {"goals": 800, "action_goals": 162, "annotated_steps": 2978}),
    ],
)
def test_features_sum_to_the_table_of_the_paper(domain: str, sums: dict[str, int], data_store: Store) -> None:
    benchmark = find_benchmark(domain)
    tasks = benchmark.tasks(Source(data_store, errata=ErrataChoice.NONE))
    features_of_tasks = [compute_features(task, benchmark) for task in tasks.values()]
    assert {name: sum(getattr(features, name) for features in features_of_tasks) for name in sums} == sums
