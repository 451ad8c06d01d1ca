from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import replace
from itertools import product

import pytest
from hypothesis import given
from hypothesis import strategies as st

from eai.abilities.goal_interpretation.verdict import GoalVerdict
from eai.abilities.protocol import Ability
from eai.abilities.task_features import TaskFeatures
from eai.abilities.verdict import ConfusionCounts, Verdict
from eai.results.certainty import TaskRateContribution
from eai.results.comparison import compare_runs, compute_permutation_p_value, compute_sign_flip_p
from eai.results.rate import Rate
from eai.results.record import Record
from eai.tasks.share import Share
from eai.world.fault import FaultKind
from results.near_copies import merged, successes
from results.verdicts import SUCCEEDED, failed, record

BAD = failed(FaultKind.MISSING_STEP)


def test_a_comparison_lists_tasks_that_differ_and_tasks_of_one_run() -> None:
    first = [record("a", SUCCEEDED), record("b", BAD), record("c", SUCCEEDED), record("z", BAD)]
    second = [record("c", SUCCEEDED), record("b", SUCCEEDED), record("a", BAD), record("y", BAD)]
    found = compare_runs(first, second)
    (metric, success), *_ = found.differences.items()
    assert (metric, success.first, success.second) == ("task_success", Rate(2, 3), Rate(2, 3))
    assert (success.only_first, success.only_second) == (("a",), ("b",))
    assert success.yes_no
    assert success.p_value == success.p_by_task == 1
    assert success.percentage_points == 0
    assert (found.only_in_first, found.only_in_second) == (("z",), ("y",))
    assert (found.tasks, found.names) == (3, 3)


def test_runs_of_one_task_are_compared() -> None:
    success = compare_runs([record("a", BAD)], [record("a", SUCCEEDED)]).differences["task_success"]
    assert (success.first, success.second, success.only_second) == (Rate(0, 1), Rate(1, 1), ("a",))
    assert success.p_value == 1


def test_f1_is_compared_by_exchanges() -> None:
    def run(hits: int) -> list[Verdict]:
        return [GoalVerdict(counts={"state": ConfusionCounts(hits, 3 - hits, i % 2)}) for i in range(20)]

    first, second = (
        [record(str(i), v, ability=Ability.GOAL_INTERPRETATION) for i, v in enumerate(run(hits))]
        for hits in (1, 3)
    )
    f1 = next(iter(compare_runs(first, second).differences.values()))
    assert not f1.yes_no
    assert f1.only_first == f1.only_second == ()
    assert f1.percentage_points == pytest.approx(100 * (120 / 130 - 40 / 90))
    assert f1.certainty is not None
    assert f1.certainty.interval.low > 0
    assert f1.p_value == pytest.approx(1 / 5001)


def test_equal_runs_do_not_differ() -> None:
    runs = [record(str(i), SUCCEEDED if i % 3 else BAD) for i in range(9)]
    for difference in compare_runs(runs, runs).differences.values():
        assert difference.p_value == 1
        assert difference.percentage_points == 0
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

    found = compare_runs(run(BAD), run(SUCCEEDED))
    success = found.differences["task_success"]
    assert (found.tasks, found.names) == (60, 3)
    assert success.p_by_task == pytest.approx(2 / 2**20)
    assert success.p_value == 1  # one name could as well have gone the other way
    assert success.certainty is not None
    assert success.certainty.by_task.low > 0 > success.certainty.interval.low


def test_names_of_tasks_may_come_from_the_other_run() -> None:
    old = [record(f"{i}_1", SUCCEEDED) for i in range(4)]
    new = [replace(each, task=TaskFeatures("wash", 5, 1)) for each in old]
    assert compare_runs(old, new).names == compare_runs(new, old).names == 1


@pytest.mark.parametrize(
    ("lost", "won", "p_value"),
    [(0, 0, 1.0), (1, 1, 1.0), (1, 9, 22 / 1024), (9, 1, 22 / 1024), (0, 5, 2 / 32)],
)
def test_the_test_by_task_is_mcnemars_test(lost: int, won: int, p_value: float) -> None:
    assert compute_sign_flip_p([-1] * lost + [1] * won + [0] * 7) == pytest.approx(p_value)


def test_a_sign_flip_test_takes_thousands_of_pairs() -> None:
    assert 0 < compute_sign_flip_p([-1] * 900 + [1] * 1000) < 0.05
    assert compute_sign_flip_p([1] * 2000) == 0.0


@given(st.lists(st.integers(-9, 9), max_size=8))
def test_the_sign_flip_test_counts_all_combinations_of_signs(differences: list[int]) -> None:
    sums = [
        sum(s * d for s, d in zip(signs, differences, strict=True))
        for signs in product((1, -1), repeat=len(differences))
    ]
    extreme = sum(abs(each) >= abs(sum(differences)) for each in sums)
    assert compute_sign_flip_p(differences) == pytest.approx(extreme / len(sums))


def test_random_exchanges_agree_with_exact_sign_flips() -> None:
    first = [Share(k, 10) for k in (3, 5, 1, 7, 2, 9, 4, 6, 0, 2)]
    second = [Share(k, 10) for k in (4, 7, 2, 7, 5, 9, 3, 8, 2, 5)]
    exact = compute_sign_flip_p(
        [round(b.numerator - a.numerator) for a, b in zip(first, second, strict=True)]
    )
    assert compute_permutation_p_value(first, second) == pytest.approx(exact, abs=0.01)
    assert compute_permutation_p_value(first, second) == compute_permutation_p_value(first, second)
    assert compute_permutation_p_value(first, first) == 1
    assert compute_permutation_p_value(first, [Share(0, 0)] * 10) is None


def test_equally_good_runs_rarely_differ_significantly() -> None:
    """With tasks as units, equally good models differ significantly in most samples of near copies."""
    generator = random.Random(5)
    by_name = by_task = 0
    for _ in range(100):
        runs = [successes(generator, 0.5) for _ in range(2)]
        by_task += compute_sign_flip_p(_changes(*runs)) < 0.05
        by_name += compute_sign_flip_p(_changes(*map(merged, runs))) < 0.05
    assert by_name <= 9  # 5 are expected
    assert by_task > 50


def _changes(first: Sequence[TaskRateContribution], second: Sequence[TaskRateContribution]) -> list[int]:
    return [round(b.share.numerator - a.share.numerator) for a, b in zip(first, second, strict=True)]
