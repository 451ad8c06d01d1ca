from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import pytest

from eai.abilities.attempt import Attempt
from eai.abilities.experiment import Experiment
from eai.abilities.explanation import VerdictExplanation
from eai.results.rate import Rate
from eai.results.record import Record
from eai.results.summary import compute_rates_by_attempt, drop_later_attempts, find_max_attempts_per_task
from eai.world.fault import FaultKind
from experiments import experiment
from results.verdicts import SUCCEEDED, failed, record

WRONG, MISSING = failed(FaultKind.WRONG_ORDER), failed(FaultKind.MISSING_STEP)
TWICE = experiment(replans=2)


def tried(task_id: str, attempts: Sequence[Attempt], experiment: Experiment | None = TWICE) -> Record:
    last = attempts[-1]
    plain = record(task_id, last.verdict, response=last.response)
    return replace(plain, explanation=last.explanation, attempts=tuple(attempts), experiment=experiment)


FIRST = Attempt("one", WRONG, explanation=VerdictExplanation(notes=("too soon",)))
SECOND = Attempt("two", MISSING)
THIRD = Attempt("three", SUCCEEDED, explanation=VerdictExplanation(notes=("done",)))
TRIED = tried("a", [FIRST, SECOND, THIRD])


@pytest.mark.parametrize(
    ("attempts", "kept"), [(1, (FIRST,)), (2, (FIRST, SECOND)), (3, TRIED.attempts), (4, TRIED.attempts)]
)
def test_a_limit_on_attempts_keeps_the_last_attempt_within_it(
    attempts: int, kept: tuple[Attempt, ...]
) -> None:
    assert drop_later_attempts(TRIED, attempts) == tried("a", kept)


def test_a_limit_on_attempts_does_not_change_a_record_without_attempts() -> None:
    plain = record("a", WRONG)
    assert drop_later_attempts(plain, 1) is plain


@pytest.mark.parametrize(
    ("records", "most"),
    [
        ([], 0),
        ([record("a", SUCCEEDED)], 0),
        ([replace(record("a", SUCCEEDED), experiment=experiment(goals_from="m"))], 0),
        ([tried("a", [THIRD], experiment(slip=0.1))], 1),
        ([tried("a", [THIRD])], 3),  # it could have had them
        ([replace(record("lost", WRONG), experiment=TWICE), TRIED], 3),
    ],
)
def test_the_maximum_number_of_attempts_follows_from_the_replans(records: list[Record], most: int) -> None:
    assert find_max_attempts_per_task(records) == most
    assert len(compute_rates_by_attempt(records)) == most


def test_success_does_not_fall_with_the_number_of_attempts() -> None:
    records = [TRIED, tried("b", [THIRD]), tried("c", [SECOND, FIRST, SECOND])]
    found = compute_rates_by_attempt(records)
    assert [rates["task_success"] for rates in found] == [Rate(1, 3), Rate(1, 3), Rate(2, 3)]
    assert [rates["wrong_order"] for rates in found] == [Rate(1, 3), Rate(1, 3), Rate(0, 3)]
    assert [rates["missing_step"] for rates in found] == [Rate(1, 3), Rate(1, 3), Rate(1, 3)]
