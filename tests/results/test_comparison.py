from __future__ import annotations

from dataclasses import replace

import pytest

from eai.abilities.goal_interpretation.declaration import GoalVerdict
from eai.abilities.protocol import Ability
from eai.abilities.record import Record, TaskFeatures
from eai.abilities.verdict import Confusion, Verdict
from eai.results.comparison import compare
from eai.results.rate import Rate
from eai.world.fault import FaultKind
from results.verdicts import SUCCEEDED, failed, record

BAD = failed(FaultKind.MISSING_STEP)


def test_tasks_that_differ_and_tasks_of_one_run_only() -> None:
    first = [record("a", SUCCEEDED), record("b", BAD), record("c", SUCCEEDED), record("z", BAD)]
    second = [record("c", SUCCEEDED), record("b", SUCCEEDED), record("a", BAD), record("y", BAD)]
    found = compare(first, second)
    success = found.differences[0]
    assert (success.metric, success.first, success.second) == ("task_success", Rate(2, 3), Rate(2, 3))
    assert (success.only_first, success.only_second) == (("a",), ("b",))
    assert success.yes_no
    assert success.p_value == success.p_by_task == 1
    assert success.points == 0
    assert found.differing == ("a", "b")
    assert (found.only_in_first, found.only_in_second) == (("z",), ("y",))
    assert (found.tasks, found.names) == (3, 3)


def test_runs_of_one_task_are_compared() -> None:
    success = compare([record("a", BAD)], [record("a", SUCCEEDED)]).differences[0]
    assert (success.first, success.second, success.only_second) == (Rate(0, 1), Rate(1, 1), ("a",))
    assert success.p_value == 1


def test_f1_is_compared_by_exchanges() -> None:
    def run(hits: int) -> list[Verdict]:
        return [GoalVerdict(counts={"state": Confusion(hits, 3 - hits, i % 2)}) for i in range(20)]

    first, second = (
        [record(str(i), v, ability=Ability.GOAL_INTERPRETATION) for i, v in enumerate(run(hits))]
        for hits in (1, 3)
    )
    f1 = compare(first, second).differences[0]
    assert not f1.yes_no
    assert f1.only_first == f1.only_second == ()
    assert f1.points == pytest.approx(100 * (120 / 130 - 40 / 90))
    assert f1.certainty is not None
    assert f1.certainty.interval.low > 0
    assert f1.p_value == pytest.approx(1 / 5001)


def test_equal_runs_do_not_differ() -> None:
    runs = [record(str(i), SUCCEEDED if i % 3 else BAD) for i in range(9)]
    for difference in compare(runs, runs).differences:
        assert difference.p_value == 1
        assert difference.points == 0
        assert difference.certainty is not None
        assert difference.certainty.interval.low == -difference.certainty.interval.high


def test_near_copies_that_differ_together_are_one_difference() -> None:
    def run(verdict: Verdict) -> list[Record]:
        """Three names of twenty tasks; those of one name have this verdict."""
        return [
            replace(
                record(f"{name}_{i}", verdict if name == "a" else SUCCEEDED), task=TaskFeatures(name, 5, 1)
            )
            for name in "abc"
            for i in range(20)
        ]

    found = compare(run(BAD), run(SUCCEEDED))
    success = found.differences[0]
    assert (found.tasks, found.names) == (60, 3)
    assert success.p_by_task == pytest.approx(2 / 2**20)
    assert success.p_value == 1  # one name could as well have gone the other way
    assert success.certainty is not None
    assert success.certainty.by_task.low > 0 > success.certainty.interval.low


def test_names_may_be_known_from_the_other_run() -> None:
    old = [record(f"{i}_1", SUCCEEDED) for i in range(4)]
    new = [replace(each, task=TaskFeatures("wash", 5, 1)) for each in old]
    assert compare(old, new).names == compare(new, old).names == 1
