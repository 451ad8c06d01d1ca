"""Smallest repairs in records, in words and in tables."""

from __future__ import annotations

from pathlib import Path

import eai
from eai.abilities.repair import (
    DEFAULT_EFFORT,
    Edit,
    SmallestPlanRepair,
    classify_and_locate_fault,
    describe_repair,
)
from eai.abilities.verdict import PlanVerdict
from eai.results.batch import score_run
from eai.results.codec import record_from_json, record_to_json
from eai.results.options import ScoringOptions
from eai.results.responses import Response, ResponseFile
from eai.studies.records import StudyRecords
from eai.studies.registry import find_study
from record_files import write_records

SUITE = eai.open("virtualhome", "action_sequencing")
TASK = "27_2"
WALK = '{"WALK": ["washing_machine", 1001]}'


def repair_of(plan: str) -> SmallestPlanRepair:
    assessment = SUITE.scorer(TASK).assess(plan)
    assert assessment.analyze_failure is not None
    verdict = assessment.analyze_failure(DEFAULT_EFFORT)
    assert isinstance(verdict, PlanVerdict)
    assert verdict.repair is not None
    assert (verdict.repair.distance == 0) == bool(verdict.success)
    return verdict.repair


def test_an_unreadable_answer_has_no_repair_distance() -> None:
    repair = repair_of("All is washed.")
    assert (repair.distance, repair.why_null) == (None, "unreadable")
    assert [*describe_repair(repair)] == ["smallest repair: not known (unreadable)"]


def test_the_cause_of_a_failure_follows_from_all_single_edits() -> None:
    before, after = Edit("insert", 1, "OPEN(door)"), Edit("insert", 3, "OPEN(door)")
    assert classify_and_locate_fault([before, Edit("delete", 1, was="GO(hall)")]) == ("step", 1)
    assert classify_and_locate_fault([after, before]) == ("interval", 1)
    assert classify_and_locate_fault([after, Edit("delete", 1, was="GO(hall)")]) == ("several", None)


def test_repairs_are_in_records_and_tables(tmp_path: Path) -> None:
    answers = ResponseFile("m", (Response(TASK, WALK),))
    (record,) = score_run(SUITE, answers, {}, ScoringOptions(look_back=DEFAULT_EFFORT))
    assert record.verdict.repair is not None
    assert record_from_json(record_to_json(record)) == record
    write_records(tmp_path / "records.jsonl", [record])
    study = find_study("repair")
    assert study.analyze is not None
    (analysis,) = study.analyze(StudyRecords((tmp_path,)), study.choices())
    (row,) = analysis.tables[0].row_dicts()
    assert (row["failed"], row["unknown"]) == (1, 0)
