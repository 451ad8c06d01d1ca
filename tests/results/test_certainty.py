from __future__ import annotations

import random
from collections.abc import Callable

import pytest

from eai.results.certainty import (
    Interval,
    TaskRateContribution,
    compute_difference_intervals,
    compute_intervals_of_weighted_mean,
    compute_mean_rate_over_task_names,
    compute_rate_intervals,
    compute_student_quantile,
)
from eai.tasks.share import Share
from results.near_copies import expected_f1, matches, merged, successes_by_name

PROMISED = 0.93
"""How often intervals of 95 % must hold the truth, at least."""


def alone(right: int, tasks: int) -> list[TaskRateContribution]:
    """Return tasks with different names; a given number of them is right."""
    return [TaskRateContribution(str(i), str(i), Share(i < right, 1)) for i in range(tasks)]


def copies(*names: tuple[int, int]) -> list[TaskRateContribution]:
    """Return cases of names, given the number of right tasks and of tasks of each name."""
    return [
        TaskRateContribution(f"{name}_{i}", str(name), Share(i < right, 1))
        for name, (right, tasks) in enumerate(names)
        for i in range(tasks)
    ]


@pytest.mark.parametrize(
    ("right", "tasks", "low", "high"),
    [
        (0, 100, 0, 3.70),
        (1, 100, 0.18, 5.45),
        (60, 100, 50.2, 69.1),
        (100, 100, 96.3, 100),
        (8, 10, 49.0, 94.3),
    ],
)
def test_independent_tasks_have_wilsons_interval(right: int, tasks: int, low: float, high: float) -> None:
    found = compute_rate_intervals(alone(right, tasks))
    assert found is not None
    assert found.interval == pytest.approx(Interval(low, high), abs=0.05)
    assert found.by_task == found.interval
    assert (found.tasks, found.names, found.design_effect, found.effective_task_count) == (
        tasks,
        tasks,
        1,
        tasks,
    )


def test_near_copies_have_a_wider_interval_than_different_tasks() -> None:
    together = compute_rate_intervals(copies(*[(20, 20)] * 5, *[(0, 20)] * 5))
    apart = compute_rate_intervals(copies(*[(10, 20)] * 10))
    assert together is not None
    assert apart is not None
    assert (together.tasks, together.names) == (200, 10)
    assert together.design_effect == pytest.approx(20)  # each name is worth one task
    assert together.effective_task_count == pytest.approx(10)
    assert together.by_task == apart.by_task == pytest.approx(Interval(43.1, 56.9), abs=0.05)
    assert together.interval.low < 25
    assert together.interval.high > 75
    assert apart.design_effect == pytest.approx(0)


def test_the_effective_number_of_tasks_never_exceeds_their_number() -> None:
    found = compute_rate_intervals(copies((10, 20), (11, 20), (9, 20)))
    assert found is not None
    assert 0 < (found.design_effect or 0) < 1
    assert found.effective_task_count == found.tasks == 60


def test_few_names_with_equal_results_still_have_a_wide_interval() -> None:
    for right in (0, 10):
        found = compute_rate_intervals(copies(*[(right, 10)] * 4))
        assert found is not None
        assert found.design_effect is None  # nothing varies
        assert found.effective_task_count is None
        assert found.interval.high - found.interval.low > 50
        assert found.by_task.high - found.by_task.low < 10


def test_a_rate_of_errors_that_count_several_times_has_an_interval() -> None:
    found = compute_rate_intervals([TaskRateContribution(str(i), str(i), Share(i % 4, 1)) for i in range(40)])
    assert found is not None
    assert found.interval.low < 150 < found.interval.high
    assert found.interval.low + found.interval.high == pytest.approx(300)


def test_a_rate_without_cases_has_no_interval() -> None:
    nothing = [TaskRateContribution("a", "a", Share(0, 0))]
    assert compute_rate_intervals([]) is None
    assert compute_rate_intervals(nothing) is None
    assert compute_difference_intervals(nothing, nothing) is None
    assert compute_intervals_of_weighted_mean([(0.5, alone(1, 2)), (0.5, nothing)]) is None
    assert compute_mean_rate_over_task_names(nothing) is None


def test_the_mean_over_names_gives_each_name_equal_weight() -> None:
    assert compute_mean_rate_over_task_names(copies((30, 30), (0, 10))) == 50


def test_a_mean_of_rates_of_the_same_tasks_varies_with_their_names() -> None:
    cases = copies((10, 10), (0, 10), (10, 10), (5, 10), (0, 10), (10, 10))
    whole = compute_rate_intervals(cases)
    halves = compute_intervals_of_weighted_mean([(0.5, cases), (0.5, cases)])
    assert whole is not None
    assert halves is not None
    assert halves.interval == pytest.approx(whole.interval)  # the same twice is no surer than once
    opposite = [case._replace(share=Share(1 - case.share.numerator, 1)) for case in cases]
    opposed = compute_intervals_of_weighted_mean([(0.5, cases), (0.5, opposite)])
    assert opposed is not None
    assert opposed.interval.high - opposed.interval.low < 0.7 * (whole.interval.high - whole.interval.low)


def test_a_difference_has_a_narrower_interval_if_the_same_tasks_are_right() -> None:
    first = copies((10, 10), (0, 10), (10, 10), (0, 10), (9, 10), (1, 10), (10, 10), (0, 10))
    alike = copies((10, 10), (1, 10), (10, 10), (1, 10), (10, 10), (2, 10), (10, 10), (1, 10))
    unlike = copies((0, 10), (10, 10), (0, 10), (10, 10), (1, 10), (9, 10), (5, 10), (10, 10))
    near, far = compute_difference_intervals(first, alike), compute_difference_intervals(first, unlike)
    assert near is not None
    assert far is not None
    assert near.interval.high - near.interval.low < far.interval.high - far.interval.low
    assert near.interval.low + near.interval.high == pytest.approx(2 * 100 * 5 / 80)


def test_the_interval_of_a_difference_above_100_percent_contains_it() -> None:
    low, high = (
        [TaskRateContribution(str(i), str(i), Share(errors + i % 2, 1)) for i in range(10)]
        for errors in (0, 3)
    )
    for before, after, difference in ((low, high, 300), (high, low, -300)):
        found = compute_difference_intervals(before, after)
        assert found is not None
        assert -400 <= found.interval.low < difference < found.interval.high <= 400


def test_runs_that_agree_everywhere_may_still_differ_elsewhere() -> None:
    cases = alone(60, 100)
    found = compute_difference_intervals(cases, cases)
    assert found is not None
    assert found.interval == pytest.approx(Interval(-2, 2), abs=0.1)


def test_an_interval_by_name_is_made_from_the_sums_of_names() -> None:
    cases = matches(random.Random(3), 0.4)
    whole, sums = compute_rate_intervals(cases), compute_rate_intervals(merged(cases))
    assert whole is not None
    assert sums is not None
    assert whole.interval == pytest.approx(sums.interval)


def covered(truth: float, samples: int, draw: Callable[[], Interval | None]) -> float:
    """Return the share of drawn intervals that cover the true value."""
    found = [draw() for _ in range(samples)]
    return sum(i is not None and i.low <= truth <= i.high for i in found) / samples


@pytest.mark.parametrize("rate", [0.01, 0.03, 0.1, 0.17, 0.3, 0.5, 0.8, 0.95, 0.99])
def test_intervals_of_rates_cover_the_true_value(rate: float) -> None:
    generator = random.Random(f"rate/{rate}")

    def draw() -> Interval | None:
        found = compute_rate_intervals(successes_by_name(generator, rate))
        return found and found.interval

    assert covered(100 * rate, 1000, draw) >= PROMISED


@pytest.mark.parametrize("rate", [0.05, 0.3, 0.6, 0.95])
def test_intervals_of_f1_cover_the_true_value(rate: float) -> None:
    generator = random.Random(f"f1/{rate}")

    def draw() -> Interval | None:
        found = compute_rate_intervals(merged(matches(generator, rate)))
        return found and found.interval

    assert covered(100 * expected_f1(rate), 200, draw) >= PROMISED


@pytest.mark.parametrize("rates", [(0.01, 0.1), (0.05, 0.2), (0.3, 0.5), (0.8, 0.95), (0.97, 0.99)])
def test_intervals_of_differences_cover_the_true_value(rates: tuple[float, float]) -> None:
    generator = random.Random(f"difference/{rates}")

    def draw() -> Interval | None:
        found = compute_difference_intervals(*(successes_by_name(generator, rate) for rate in rates))
        return found and found.interval

    assert covered(100 * (rates[1] - rates[0]), 500, draw) >= PROMISED


@pytest.mark.parametrize("rates", [(0.05, 0.2), (0.5, 0.5), (0.8, 0.98)])
def test_intervals_of_means_cover_the_true_value(rates: tuple[float, float]) -> None:
    generator = random.Random(f"mean/{rates}")

    def draw() -> Interval | None:
        found = compute_intervals_of_weighted_mean(
            [(0.5, successes_by_name(generator, rate)) for rate in rates]
        )
        return found and found.interval

    assert covered(50 * sum(rates), 500, draw) >= PROMISED


@pytest.mark.parametrize("rate", [0.1, 0.5, 0.9])
def test_intervals_of_repeated_errors_cover_the_true_value(rate: float) -> None:
    """Each task has two chances of an error, each with a rate of one half."""
    generator = random.Random(f"several/{rate}")

    def draw() -> Interval | None:
        names = successes_by_name(generator, rate)
        twice = [TaskRateContribution(t, n, Share(2 * numerator, of)) for t, n, (numerator, of) in names]
        found = compute_rate_intervals(twice)
        return found and found.interval

    assert covered(200 * rate, 500, draw) >= PROMISED


@pytest.mark.parametrize(
    ("freedom", "quantile"),
    [(1, 12.706), (2, 4.303), (3, 3.182), (4, 2.776), (5, 2.571), (16, 2.120), (99, 1.984), (1000, 1.962)],
)
def test_quantiles_are_those_of_printed_tables(freedom: int, quantile: float) -> None:
    assert compute_student_quantile(0.95, freedom) == pytest.approx(quantile, abs=0.0005)
