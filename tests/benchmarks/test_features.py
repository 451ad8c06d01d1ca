from __future__ import annotations

from dataclasses import replace

import pytest

from eai.base.store import DataPackStore
from eai.benchmarks.features import TaskStatistics, compute_features
from eai.benchmarks.registry import find_benchmark
from eai.logic.formula import Always, Atom, Exists, Formula, Then, Until, Variable
from eai.tasks.source import ErrataChoice, Source
from eai.tasks.task import goal
from studies.lamps import LIT, TRIMMED, lamp_task, lamps


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
        containers=0,
        hidden=0,
        labels="horizon-atomic",
    )


@pytest.mark.parametrize(
    ("domain", "sums"),
    [
        ("behavior", {"goals": 366, "ground_goals": 673, "goal_options": 416441, "annotated_steps": 1455}),
        ("virtualhome", {"goals": 800, "action_goals": 162, "annotated_steps": 2978}),
    ],
)
def test_features_sum_to_the_table_of_the_paper(
    domain: str, sums: dict[str, int], data_store: DataPackStore
) -> None:
    benchmark = find_benchmark(domain)
    tasks = benchmark.tasks(Source(data_store, errata=ErrataChoice.NONE))
    features_of_tasks = [compute_features(task, benchmark) for task in tasks.values()]
    assert {name: sum(getattr(features, name) for features in features_of_tasks) for name in sums} == sums


DECIDED_LABELS = {
    "virtualhome": {
        "27_2": "articulated device-operation horizon-composite precision-fit transport",
        "158_1": "horizon-atomic",
        "509_2": "horizon-composite",
        "173_1": "articulated device-operation horizon-composite precision-fit",
        "814_1": "horizon-atomic transport",
        "742_1": "horizon-atomic",
    },
    "behavior": {
        "assembling_gift_baskets": "horizon-composite quantified-goal transport",
        "cleaning_high_chair": "horizon-atomic surface-treatment",
        "collecting_aluminum_cans": "horizon-atomic transport",
        "moving_boxes_to_storage": "horizon-atomic transport",
        "polishing_shoes": "horizon-composite relational-goal surface-treatment transport",
    },
    "behavior-1k": {
        "attach_a_camera_to_a_tripod": "horizon-atomic precision-fit",
        "can_meat": "articulated horizon-composite quantified-goal transport",
        "canning_food": "articulated cutting fluid-granular horizon-activity irreversible transport",
        "chop_an_onion": "cutting fluid-granular horizon-composite irreversible transport",
        "chopping_wood": "cutting horizon-activity irreversible",
        "clean_up_broken_glass": "horizon-atomic transport",
        "cook_a_brisket": "horizon-atomic irreversible thermal transport",
    },
}
"""Labels by benchmark and title, or by the id of VirtualHome. A person chose them from the goals."""


@pytest.mark.parametrize("domain", DECIDED_LABELS)
def test_goals_give_the_labels_that_a_person_chose(domain: str, data_store: DataPackStore) -> None:
    benchmark, decided = find_benchmark(domain), DECIDED_LABELS[domain]
    tasks = benchmark.tasks(Source(data_store, errata=ErrataChoice.NONE))
    id_of = {key: next(task_id for task_id in tasks if task_id.startswith(key)) for key in decided}
    assert {key: compute_features(tasks[id_of[key]], benchmark).labels for key in decided} == decided


def test_only_halves_and_diced_food_are_cut(data_store: DataPackStore) -> None:
    benchmark = find_benchmark("behavior-1k")
    task = benchmark.tasks(Source(data_store, errata=ErrataChoice.NONE))["chop_an_onion"]
    labels = []
    for category in ("diced__vidalia_onion", "half__log", "lemonade"):
        made = Atom("real", (Variable("x"),))
        task = task.replace_goals((goal(Exists(Variable("x", category), made)),))
        labels.append(compute_features(task, benchmark).labels)
    assert labels == ["cutting horizon-atomic irreversible"] * 2 + ["horizon-atomic irreversible"]


@pytest.mark.parametrize(
    ("formula", "is_ordered"),
    [
        (Then((LIT("lamp_1"), LIT("lamp_2"))), True),
        (Until(~LIT("lamp_2"), LIT("lamp_1")), True),
        (Always(~(LIT("lamp_1") & TRIMMED("lamp_1"))), False),
    ],
)
def test_a_goal_that_fixes_the_order_of_conditions_gives_a_label(formula: Formula, is_ordered: bool) -> None:
    task = lamp_task()
    labels = compute_features(replace(task, goals=(*task.goals, goal(formula))), lamps()).labels
    assert labels == ("horizon-composite ordered" if is_ordered else "horizon-composite")


def test_containers_and_hidden_objects_are_unknown_without_a_plan() -> None:
    features = compute_features(replace(lamp_task(), script=()), lamps())
    assert (features.containers, features.hidden, features.tool_steps) == (None, None, None)
