"""The summary beside records, and its optional fields."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from eai.abilities.protocol import Ability
from eai.abilities.transition_modeling.verdict import OperatorVerdict
from eai.benchmarks.errata import ApplicableErrata
from eai.results.batch import Scoring
from eai.results.record import Record
from eai.results.records import RECORDS, SUMMARY, make_record_batch, write_record_batches
from eai.results.responses import Response, ResponseFile
from eai.results.summary import compute_metric_rates, compute_rates_by_attempt
from results.work import TASK_IDS, echo_suite

ANSWERS = ResponseFile("m", tuple(Response(i, f"answer to {i}") for i in TASK_IDS))


def summary(folder: Path, records: list[Record], **run: Any) -> dict[str, Any]:
    described = run.get("run", {}), compute_rates_by_attempt(records)
    write_record_batches(folder, [make_record_batch(records)], lambda totals: described)
    found: dict[str, Any] = json.loads((folder / SUMMARY).read_text())
    return found


def test_a_summary_names_its_model_and_suite(tmp_path: Path) -> None:
    records = [
        replace(record, errata=None)
        for record in Scoring().score_records(echo_suite(), ANSWERS.model, ANSWERS.responses)
    ]
    told = summary(tmp_path, records)
    assert {name: told[name] for name in ("protocol", "domain", "ability", "model", "unit", "errata")} == {
        "protocol": "strict",
        "domain": "virtualhome",
        "ability": "action_sequencing",
        "model": "m",
        "unit": "percent",
        "errata": None,
    }
    assert (
        told["task_success"]
        == compute_metric_rates([each.verdict for each in records], records[0].ability)[
            "task_success"
        ].to_json()
    )
    assert told.keys().isdisjoint({"planner", "run", "study", "agent", "by_attempt"})
    assert len((tmp_path / RECORDS).read_text().splitlines()) == len(records)
    corrected = [replace(record, errata=ApplicableErrata("2.0", ("e1",))) for record in records]
    assert summary(tmp_path, corrected, run={"answered": 7})["errata"]["version"] == "2.0"
    assert summary(tmp_path, corrected, run={"answered": 7})["run"] == {"answered": 7}


@pytest.mark.parametrize(
    ("names", "told"), [(("search", None), "search"), (("val", "search"), "search, val"), ((None,), None)]
)
def test_a_summary_names_the_planners_if_known(
    tmp_path: Path, names: tuple[str | None, ...], told: str | None
) -> None:
    record = next(Scoring().score_records(echo_suite(), ANSWERS.model, ANSWERS.responses))
    record = replace(record, ability=Ability.TRANSITION_MODELING)
    verdicts = [OperatorVerdict(planner_name=name) for name in names]
    assert summary(tmp_path, [replace(record, verdict=each) for each in verdicts]).get("planner") == told
