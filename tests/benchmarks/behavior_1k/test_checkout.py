"""Tests of activity definitions in a checkout, which are written to files from the data."""

from __future__ import annotations

from pathlib import Path

import pytest

from eai.base.errors import InputError
from eai.base.store import DataPackStore
from eai.benchmarks.behavior_1k.checkout import FILE, read_activity_definitions
from eai.benchmarks.behavior_1k.kinds import ACTIVITIES, PACK
from eai.benchmarks.packs import open_pack
from eai.benchmarks.registry import find_benchmark
from eai.tasks.source import Source, TaskSet
from eai.tasks.task import Task

OWN = """; a comment
(define (problem putting_away_mug_0)
    (:domain omnigibson)
    (:objects mug.n.04_1 - mug.n.04 cabinet.n.01_1 - cabinet.n.01
        floor.n.01_1 - floor.n.01 agent.n.01_1 - agent.n.01)
    (:init (ontop mug.n.04_1 floor.n.01_1) (inroom cabinet.n.01_1 kitchen)
        (inroom floor.n.01_1 kitchen) (ontop agent.n.01_1 floor.n.01_1))
    (:goal (and (inside ?mug.n.04_1 ?cabinet.n.01_1) (not (open ?cabinet.n.01_1)))))
"""


def write(folder: Path, name: str, text: str) -> None:
    (folder / name).mkdir(parents=True)
    (folder / name / FILE).write_text(text, encoding="utf-8")


def test_a_definition_of_the_user_is_a_task(tmp_path: Path, activity_store: DataPackStore) -> None:
    write(tmp_path / "bddl" / "activity_definitions", "putting_away_mug", OWN)
    benchmark = find_benchmark(f"behavior-1k:{tmp_path}")
    tasks = benchmark.tasks(Source(activity_store))
    task = tasks["putting_away_mug"]
    assert (benchmark.name, [*tasks]) == ("behavior-1k-checkout", ["putting_away_mug"])
    assert task.instruction == (
        "Putting away mug. In the end it shall be so that: "
        "the mug is inside the cabinet; the cabinet is not open."
    )
    assert (task.script, task.unsolvable) == ((), None)
    assert task.initial.has("lies_on", task.scene.index["mug_1"], task.scene.index["floor_1"])


@pytest.fixture(scope="module")
def texts(activity_store: DataPackStore) -> dict[str, str]:
    """Return the definitions of the data by activity."""
    lines = open_pack(PACK, Source(activity_store)).read_member(ACTIVITIES).decode().splitlines()
    return dict(line.split("\t") for line in lines)


def test_an_unchanged_definition_keeps_its_plan_and_a_changed_one_does_not(
    tmp_path: Path, texts: dict[str, str], activity_store: DataPackStore, activities: TaskSet[Task]
) -> None:
    write(tmp_path, "can_meat", texts["can_meat"])
    write(tmp_path, "bringing_water", texts["bringing_water"].replace("(not (open", "(not (toggled_on"))
    tasks = find_benchmark(f"behavior-1k:{tmp_path}").tasks(Source(activity_store))
    same, changed = tasks["can_meat"], tasks["bringing_water"]
    assert (same.script, same.goals) == (activities["can_meat"].script, activities["can_meat"].goals)
    assert same.script
    assert changed.goals != activities["bringing_water"].goals
    assert changed.script == ()


def test_all_definitions_of_the_data_are_accepted(tmp_path: Path, texts: dict[str, str]) -> None:
    for name, text in texts.items():
        write(tmp_path, name, text)
    assert dict(read_activity_definitions(tmp_path)) == texts


def test_an_activity_with_a_kind_that_the_data_lacks_is_excluded(
    tmp_path: Path, activity_store: DataPackStore
) -> None:
    write(tmp_path, "putting_away_mug", OWN.replace("mug.n.04", "space_mug.n.07"))
    task = find_benchmark(f"behavior-1k:{tmp_path}").tasks(Source(activity_store))["putting_away_mug"]
    assert task.unsolvable == "bddl 3.6.0 does not describe space_mug.n.07"


@pytest.mark.parametrize(
    ("right", "wrong", "message"),
    [
        ("floor.n.01_1))\n    (:goal", "floor.n.01_1)\n    (:goal", r"line 8"),
        ("(:goal", "(:gaol", r"line 8.*':goal'"),
        ("(inside ?mug", "(insied ?mug", ":goal has the unknown predicate insied"),
        ("(ontop mug.n.04_1 floor.n.01_1)", "(ontop mug.n.04_1)", ":init has ontop of 1 objects: expected 2"),
        ("?mug.n.04_1", "?mug.n.04_2", ":goal has inside of mug.n.04_2, which :objects does not declare"),
        ("(ontop mug.n.04_1", "(ontop cup.n.04_1", ":init has ontop of cup.n.04_1"),
        ("- mug.n.04 ", "- mug ", "as category, such as mug.n.04, found mug"),
        (
            "cabinet.n.01_1 - cabinet.n.01",
            "mug.n.01_1 - mug.n.01",
            "as category, such as mug.n.04, found mug",
        ),
    ],
)
def test_a_damaged_definition_is_refused_with_its_place(
    right: str, wrong: str, message: str, tmp_path: Path
) -> None:
    assert right in OWN
    write(tmp_path, "putting_away_mug", OWN.replace(right, wrong))
    with pytest.raises(InputError, match=message) as error:
        find_benchmark(f"behavior-1k:{tmp_path}")
    assert str(tmp_path / "putting_away_mug" / FILE) in str(error.value)


def test_a_folder_without_definitions_or_with_two_of_a_name_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="expected activities as ACTIVITY/problem0"):
        find_benchmark(f"behavior-1k:{tmp_path}")
    write(tmp_path / "old", "putting_away_mug", OWN)
    write(tmp_path / "new", "putting_away_mug", OWN)
    with pytest.raises(InputError, match="defines the same activity"):
        find_benchmark(f"behavior-1k:{tmp_path}")
