"""pass@k and pass^k, compared with all choices of k of n answers, and the cost of a success."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations
from statistics import fmean

import pytest
from hypothesis import given
from hypothesis import strategies as st

from eai.abilities.attempt import AnswerUsage
from eai.results.certainty import TaskRateContribution, compute_interval_of_cost_per_success
from eai.results.cost import group_costs_and_successes_by_cost_unit, make_json_of_cost_per_success
from eai.results.rate import compute_rate
from eai.results.record import AnswerOrigin, Record
from eai.results.repeats import (
    make_pass_at_k_table,
    map_pass_at_k_metrics_to_contributions,
    pass_at_k_to_json,
    strip_epoch,
)
from eai.results.table import Estimate
from eai.tasks.share import Share
from studies.report.samples import action_run


def epochs(answers: Sequence[Sequence[bool]]) -> list[list[TaskRateContribution]]:
    """Return the cases of each epoch from the results of each task's answers."""
    numbers = range(len(answers[0]))
    return [
        [TaskRateContribution(str(i), str(i), Share(right[e], 1)) for i, right in enumerate(answers)]
        for e in numbers
    ]


def tasks_of(number: int) -> st.SearchStrategy[list[list[bool]]]:
    return st.lists(st.lists(st.booleans(), min_size=number, max_size=number), min_size=1)


@given(st.integers(1, 5).flatmap(tasks_of))
def test_pass_at_k_and_pass_hat_k_are_means_over_all_choices_of_answers(answers: list[list[bool]]) -> None:
    found = map_pass_at_k_metrics_to_contributions(epochs(answers))
    for k in range(1, len(answers[0]) + 1):
        ways = [list(combinations(right, k)) for right in answers]
        for name, holds in ((f"pass@{k}", any), (f"pass^{k}", all)):
            expected = fmean(fmean(map(holds, each)) for each in ways)
            assert compute_rate(case.share for case in found[name]).share == pytest.approx(expected)


def test_a_task_with_fewer_than_k_answers_is_left_out() -> None:
    first, second = epochs([[True, False], [True, True]])
    found = map_pass_at_k_metrics_to_contributions([first, second[:1]])
    assert [case.task for case in found["pass@2"]] == ["0"]
    assert len(found["pass^1"]) == 2


def test_the_table_of_passes_has_powers_of_two_and_the_number_of_answers() -> None:
    table = make_pass_at_k_table({"model": epochs([[True, False, True, True, False]] * 2)})
    assert [row[2] for row in table.rows] == [1, 2, 4, 5]
    last = table.rows[-1][3:]
    assert [cell.value for cell in last if isinstance(cell, Estimate)] == [100, 0]
    written = pass_at_k_to_json(map_pass_at_k_metrics_to_contributions(epochs([[True, False]] * 2)))["pass@1"]
    assert isinstance(written, dict)
    assert (written["value"], len(written["interval"])) == (50, 2)
    assert strip_epoch("gpt-4o.epoch_12") == "gpt-4o"
    assert strip_epoch("gpt-4o") == "gpt-4o"


def costing(**usage: float) -> list[Record]:
    origin = AnswerOrigin(usage=AnswerUsage(100, 10, **usage))  # type: ignore[arg-type]
    return [replace(record, origin=origin) for record in action_run("first")]


def test_the_cost_of_a_success_includes_failed_answers() -> None:
    records = costing(seconds=2.0)
    written = make_json_of_cost_per_success(group_costs_and_successes_by_cost_unit(records))
    counted = [record for record in records if record.verdict.excluded is None]
    won = sum(bool(record.verdict.success) for record in counted)  # type: ignore[attr-defined]
    assert 0 < won < len(counted) < len(records)
    assert written["tokens"]["value"] == 110 * len(counted) / won  # type: ignore[index, call-overload]
    assert written["seconds"]["value"] == 2 * len(counted) / won  # type: ignore[index, call-overload]
    assert "dollars" not in written
    low, high = written["tokens"]["interval"]  # type: ignore[index, call-overload]
    assert low < written["tokens"]["value"] < high  # type: ignore[index, call-overload]
    some = [*costing(cost=0.5)[:-1], replace(counted[0], task_id="another")]
    assert "dollars" not in group_costs_and_successes_by_cost_unit(some)


def test_the_cost_of_a_success_is_missing_without_a_success() -> None:
    cases = [TaskRateContribution(str(i), str(i), Share(7, 0)) for i in range(3)]
    assert compute_interval_of_cost_per_success(cases) is None
    assert make_json_of_cost_per_success({"tokens": cases})["tokens"] == {
        "value": None,
        "numerator": 21,
        "denominator": 0,
        "interval": None,
    }


def test_copies_of_a_task_widen_the_interval_of_a_cost() -> None:
    """Two names with different costs give less information than as many different tasks."""
    shares = [Share(10, 1), Share(30, 1)] * 6
    alone = compute_interval_of_cost_per_success(
        [TaskRateContribution(str(i), str(i), share) for i, share in enumerate(shares)]
    )
    copies = compute_interval_of_cost_per_success(
        [TaskRateContribution(str(i), str(i % 2), share) for i, share in enumerate(shares)]
    )
    assert alone is not None
    assert copies is not None
    assert copies.low < alone.low < 20 < alone.high < copies.high
