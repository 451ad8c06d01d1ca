from __future__ import annotations

from dataclasses import replace

import pytest

from eai.abilities.protocol import Ability
from eai.abilities.transition_modeling.verdict import OperatorVerdict
from eai.abilities.verdict import PlanVerdict
from eai.benchmarks.errata import ApplicableErrata
from eai.results.coverage import TaskCoverageByAnswers, combine_coverage
from eai.results.record import NOT_ANSWERED, Record
from eai.results.totals import RunTotals
from results.verdicts import SUCCEEDED, record, whole

FAILED = PlanVerdict(executable=False, success=False)


def run(*verdicts: PlanVerdict, answered: int, size: int | None = None) -> tuple[Record, ...]:
    records = whole([record(f"{i}_1", verdict) for i, verdict in enumerate(verdicts)])
    lacking = [replace(r, unanswered="no row") for r in records[answered:]]
    return tuple(replace(r, suite_size=size or len(records)) for r in (*records[:answered], *lacking))


@pytest.mark.parametrize(
    ("records", "shown", "ranked", "remark"),
    [
        (run(SUCCEEDED, SUCCEEDED, answered=2), "2/2", True, None),
        (
            run(SUCCEEDED, FAILED, FAILED, answered=1),
            "1/3",
            True,
            "2 of 3 tasks without an answer, counted as failed.",
        ),
        (
            run(SUCCEEDED, FAILED, replace(FAILED, excluded="the reference drops it"), answered=1),
            "1/3",
            True,
            "2 of 3 tasks without an answer, counted as failed where they are in the statistics (1).",
        ),
        (
            run(SUCCEEDED, PlanVerdict(excluded=NOT_ANSWERED), answered=1),
            "1/2",
            False,
            "1 of 2 tasks without an answer, left out; the run is not ranked.",
        ),
        (
            run(SUCCEEDED, FAILED, answered=1, size=9),
            "1/9",
            False,
            "only 2 of 9 tasks were asked; 1 of 2 tasks without an answer, counted as failed; "
            "the run is not ranked.",
        ),
    ],
)
def test_coverage_counts_asked_answered_failed_and_left_out_tasks(
    records: tuple[Record, ...], shown: str, ranked: bool, remark: str | None
) -> None:
    found = RunTotals.from_records(records).coverage
    assert (str(found), found.is_complete_enough_for_ranking, found.remark_on_missing_answers) == (
        shown,
        ranked,
        remark,
    )
    numbers = found.to_json()
    assert numbers["ranked"] is ranked
    assert numbers["tasks"] == records[0].suite_size


def test_records_without_a_suite_size_are_never_ranked() -> None:
    silent = [record("1_1", SUCCEEDED), record("2_1", SUCCEEDED)]
    mixed = [*whole([record("1_1", SUCCEEDED)]), record("2_1", SUCCEEDED)]
    disagreeing = [replace(silent[0], suite_size=2), replace(silent[1], suite_size=3)]
    for records in (silent, mixed, disagreeing):
        found = RunTotals.from_records(records).coverage
        assert (str(found), found.is_complete_enough_for_ranking) == ("2/?", False)
        assert "do not say how many tasks" in str(found.remark_on_missing_answers)
        assert found.to_json()["not_asked"] is None


def test_combined_coverage_is_ranked_only_if_each_suite_is() -> None:
    complete = TaskCoverageByAnswers(3, 3, tasks=3)
    part = TaskCoverageByAnswers(1, 1, tasks=4)
    unknown = TaskCoverageByAnswers(5, 5)
    assert combine_coverage([complete, complete]) == TaskCoverageByAnswers(6, 6, tasks=6)
    assert combine_coverage([complete, part]) == TaskCoverageByAnswers(4, 4, tasks=7)
    assert not TaskCoverageByAnswers(4, 4, tasks=7).is_complete_enough_for_ranking
    assert combine_coverage([complete, unknown]) == TaskCoverageByAnswers(8, 8)
    assert combine_coverage(
        [TaskCoverageByAnswers(4, 2, 2, 1), TaskCoverageByAnswers(3, 2, 1)]
    ) == TaskCoverageByAnswers(7, 4, 3, 1)
    assert combine_coverage([]) is None


def test_older_records_have_no_planner() -> None:
    names = (None, "full 24.06", "built_in", "built_in")
    judged = [record(str(i), OperatorVerdict(planner_name=name)) for i, name in enumerate(names)]
    records = [replace(each, ability=Ability.TRANSITION_MODELING) for each in judged]
    assert RunTotals.from_records(records).planners == ("built_in", "full 24.06")


OUT = replace(SUCCEEDED, excluded="its goal holds from the beginning")


def used(task_id: str, *entries: str, excluded: bool = False, version: str = "3") -> Record:
    return replace(record(task_id, OUT if excluded else SUCCEEDED), errata=ApplicableErrata(version, entries))


def test_without_errata_there_is_no_effect() -> None:
    assert RunTotals.from_records([]).errata is None
    assert RunTotals.from_records([record("a", SUCCEEDED), record("b", OUT)]).errata is None


def test_left_out_and_corrected_tasks_are_counted_apart() -> None:
    records = [
        used("a"),
        used("b", "goal"),
        used("c", "scene", "goal", excluded=True),
        used("d", excluded=True),  # for a reason of its own
        record("e", SUCCEEDED),
    ]
    effect = RunTotals.from_records(records).errata
    assert effect is not None
    assert effect.to_json() == {
        "version": "3",
        "tasks": 5,
        "scored": 3,
        "left_out": ["c"],
        "corrected": ["b"],
    }
    assert effect.remark_on_errata == (
        "Of 5 tasks, 1 left out and 1 corrected, because the published data is wrong there "
        "(docs/errata.md); --errata none takes it as published."
    )


def test_errata_without_effect_have_no_remark() -> None:
    effect = RunTotals.from_records([used("a"), used("b", excluded=True)]).errata
    assert effect is not None
    assert effect.remark_on_errata is None


def test_each_version_of_errata_is_named_once() -> None:
    effect = RunTotals.from_records(
        [used("a", version="2"), used("b", version="3"), used("c", version="2")]
    ).errata
    assert effect is not None
    assert effect.version == "2, 3"
