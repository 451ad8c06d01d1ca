"""Records of schema 1: the fixture was written by the last code of that schema, its texts are made up.

The summaries beside it are that code's, as numerators and denominators.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from eai.abilities.codec import SCHEMA, record_to_json
from eai.abilities.explanation import Explanation, GoalReport, StepReport
from eai.abilities.record import Origin, Record, Usage
from eai.abilities.subgoal_decomposition.verdict import SubgoalVerdict
from eai.abilities.verdict import Counted, PlanVerdict
from eai.benchmarks.reference.schema_1 import record_from_json
from eai.errors import InputError
from eai.metrics.summary import summarise
from eai.scoring.records import read_records, write_records
from eai.world.fault import FaultKind

FOLDER = Path(__file__).with_name("schema_1")
RECORDS = FOLDER / "records.jsonl"
LINES: Sequence[dict[str, Any]] = [json.loads(line) for line in RECORDS.read_text().splitlines()]
SUMMARIES: Mapping[str, Mapping[str, list[float]]] = json.loads((FOLDER / "summaries.json").read_text())


def read() -> list[Record]:
    return list(read_records(RECORDS))


def suite_of(record: Record) -> str:
    return f"{record.protocol.value} {record.domain} {record.ability.value}"


def rates_of(records: Sequence[Record], suite: str) -> dict[str, list[float]]:
    found = [record for record in records if suite_of(record) == suite]
    rates = summarise([record.verdict for record in found], found[0].ability)
    return {name: [r.numerator, r.denominator] for name, r in rates.items() if r.denominator}


@pytest.mark.parametrize("suite", SUMMARIES)
def test_a_summary_is_what_it_was(suite: str) -> None:
    assert rates_of(read(), suite) == SUMMARIES[suite]


@pytest.mark.parametrize("suite", [suite for suite in SUMMARIES if suite.startswith("eai-1.0.5 virtualhome")])
def test_the_fixture_can_tell(suite: str) -> None:
    """Without what answers count as, the summaries of plans would be others."""
    plain = [
        replace(record, verdict=replace(record.verdict, counted=None))
        for record in read()
        if suite_of(record) == suite and isinstance(record.verdict, PlanVerdict)
    ]
    assert not plain or rates_of(plain, suite) != SUMMARIES[suite]


def test_a_file_written_again_is_of_the_new_schema_and_says_the_same(tmp_path: Path) -> None:
    records = read()
    write_records(tmp_path / "records.jsonl", records)
    again = list(read_records(tmp_path / "records.jsonl"))
    assert again == records
    lines = [json.loads(line) for line in (tmp_path / "records.jsonl").read_text().splitlines()]
    assert {line["schema"] for line in lines} == {SCHEMA}
    kept = set(LINES[0]) - {"schema", "explanation", "data_set_order", "times_counted"}
    for old, new in zip(LINES, lines, strict=True):
        if new["error"] is not None:
            assert (new["error"].pop("check"), new["error"].pop("objects")) == (None, [])
        assert {name: new[name] for name in kept} == {name: old[name] for name in kept}


def test_explanation_and_origin_are_fields_of_the_record() -> None:
    first, second = read()[:2]
    step = StepReport("LIGHT(lamp.1)", "executed", added=("LIT(lamp.1)",))
    assert first.explanation == Explanation(("a note",), (step,), (GoalReport("state", "LIT(lamp.1)", True),))
    assert first.origin is None
    assert second.origin == Origin("1" * 64, None, "stop", False, Usage(10, 2))


def line(suite: str, number: int = 0, **fields: object) -> dict[str, Any]:
    """One of the lines that are scored and come from a suite, with other fields."""
    found = [
        each
        for each in LINES
        if f"{each['protocol']} {each['domain']} {each['ability']}" == suite and each["status"] == "scored"
    ]
    return {**found[number], **fields}


def counted(values: Mapping[str, Any]) -> Counted:
    verdict = record_from_json(values).verdict
    assert isinstance(verdict, PlanVerdict)
    assert verdict.counted is not None
    return verdict.counted


WHY = {"step": None, "detail": "why"}
PLANS = "eai-1.0.5 virtualhome action_sequencing"
SUBGOALS = "eai-1.0.5 behavior subgoal_decomposition"


def test_an_unreadable_plan_may_count_twice() -> None:
    parsing = {"kind": "parsing", **WHY}
    twice = line(PLANS, error=parsing, times_counted=2, additional_steps=0)
    assert counted(twice).errors == ((FaultKind.PARSING, 2),)
    assert counted({**twice, "times_counted": 1}).errors == ((FaultKind.PARSING, 1),)
    assert counted({**twice, "error": {"kind": "affordance", **WHY}}).errors == ((FaultKind.AFFORDANCE, 1),)


def test_additional_steps_count_by_step_in_one_domain() -> None:
    three = line(PLANS, error=None, additional_steps=3)
    assert counted(three).errors == ((FaultKind.ADDITIONAL_STEP, 3),)
    assert counted({**three, "domain": "behavior"}).errors == ((FaultKind.ADDITIONAL_STEP, 1),)


def test_action_goals_count_in_the_order_of_the_data_set() -> None:
    found = counted(line(PLANS, success=True, data_set_order={"success": False, "action": [1, 2]}))
    assert found.success is False
    assert found.goals.action == (1, 2)


@pytest.mark.parametrize(
    ("category", "expected"),
    [
        ("runtime", ((FaultKind.WRONG_ORDER, 2), (FaultKind.ADDITIONAL_STEP, 1))),
        ("correct", ((FaultKind.WRONG_ORDER, 2), (FaultKind.ADDITIONAL_STEP, 1))),
        ("goal_unreachable", ()),
    ],
)
def test_errors_of_subgoals_count_by_entry(category: str, expected: object) -> None:
    entries = ["additional_step", "wrong_order", "additional_step", "wrong_order"]
    values = line(SUBGOALS, category=category, errors=entries, additional_steps=2, search="complete")
    assert counted(values).errors == expected


@pytest.mark.parametrize("fields", [{"status": "excluded", "excluded_reason": "why"}, {"goals": None}])
def test_what_is_in_no_summary_counts_as_nothing_else(fields: dict[str, object]) -> None:
    verdict = record_from_json(line(PLANS, **fields)).verdict
    assert isinstance(verdict, PlanVerdict)
    assert verdict.counted is None


def test_under_strict_an_answer_counts_as_its_verdict_says() -> None:
    strict = [record.verdict for record in read() if record.protocol.value == "strict"]
    plans = [verdict for verdict in strict if isinstance(verdict, PlanVerdict)]
    assert plans
    assert any(isinstance(verdict, SubgoalVerdict) for verdict in plans)
    assert all(verdict.counted is None for verdict in plans)


@pytest.mark.parametrize(
    ("fields", "complaint"),
    [
        ({"times_counted": "many"}, "field times_counted: "),
        ({"data_set_order": {"success": True}}, "field data_set_order.action: "),
        ({"response": "another"}, "expected the response that was scored"),
    ],
)
def test_what_is_wrong_is_named(fields: dict[str, object], complaint: str) -> None:
    with pytest.raises(InputError, match=complaint):
        record_from_json(line(PLANS, **fields))


def test_reading_changes_nothing_but_what_answers_count_as() -> None:
    for values, record in zip(LINES, read(), strict=True):
        written = record_to_json(record)
        assert written["repairs"] == values["repairs"]
        assert written["response_sha256"] == values["response_sha256"]
