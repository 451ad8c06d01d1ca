"""Differences on similar tasks: strata have equal weights, and strata of only one set are left out."""

from __future__ import annotations

import random

import pytest

from eai.abilities.verdict import make_rate_contribution_of_answer
from eai.extensions.contamination.study import StratifiedCase, keep_and_weight_tasks_of_shared_strata
from eai.results.certainty import TaskRateContribution, compute_difference_intervals
from eai.results.table import Estimate


def placed(which: str, *strata: tuple[str, int, int]) -> list[StratifiedCase]:
    """Tasks of strata: the name of each, how many succeed and how many do not, all of unlike names."""
    return [
        (
            TaskRateContribution(
                f"{which}{stratum}{i}", f"{which}{stratum}{i}", make_rate_contribution_of_answer(i < right)
            ),
            stratum,
        )
        for stratum, right, wrong in strata
        for i in range(right + wrong)
    ]


def test_a_stratum_weighs_what_it_weighs_in_the_first_set() -> None:
    public = placed("p", ("short", 9, 1), ("long", 10, 20), ("odd", 0, 50))
    fresh = placed("f", ("short", 30, 30), ("long", 1, 3), ("new", 7, 0))
    ones, others = keep_and_weight_tasks_of_shared_strata(public, fresh)
    assert (len(ones), len(others)) == (40, 64)
    assert Estimate.from_task_rate_contributions(ones).value == pytest.approx(100 * 19 / 40)
    assert Estimate.from_task_rate_contributions(others).value == pytest.approx(
        100 * (10 * 0.5 + 30 * 0.25) / 40
    )
    difference = Estimate.estimate_rate_difference(ones, others)
    assert difference.low < difference.value < difference.high  # type: ignore[operator]


def test_nothing_alike_is_no_difference() -> None:
    assert keep_and_weight_tasks_of_shared_strata(placed("p", ("a", 1, 1)), placed("f", ("b", 1, 1))) == (
        [],
        [],
    )


def test_tasks_of_one_name_are_one_unit() -> None:
    public, fresh = placed("p", ("a", 20, 20)), placed("f", ("a", 20, 20))
    copies = [(case._replace(name=case.task[-1:]), stratum) for case, stratum in public]
    apart, together = (
        compute_difference_intervals(*keep_and_weight_tasks_of_shared_strata(each, fresh))
        for each in (public, copies)
    )
    assert apart is not None
    assert together is not None
    assert together.names < apart.names
    assert apart.interval.high - apart.interval.low <= together.interval.high - together.interval.low


def test_intervals_hold_the_truth_as_often_as_is_said() -> None:
    rng, held = random.Random(0), 0
    for _ in range(200):
        chances = {"a": 0.8, "b": 0.3}
        sets = [
            [
                (
                    TaskRateContribution(
                        f"{w}{i}", f"{w}{i}", make_rate_contribution_of_answer(rng.random() < chances[s])
                    ),
                    s,
                )
                for i in range(80)
                for s in ["a" if rng.random() < share else "b"]
            ]
            for w, share in (("p", 0.3), ("f", 0.7))
        ]
        found = compute_difference_intervals(*keep_and_weight_tasks_of_shared_strata(*sets))
        assert found is not None
        held += found.interval.low <= 0 <= found.interval.high
    assert held >= 186  # 93 % of 200; the truth is 0
