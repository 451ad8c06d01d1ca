"""The files of results: the records of one model in one suite, and their summary."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

from eai.abilities.codec import experiment_to_json
from eai.abilities.record import Record
from eai.abilities.verdict import Json
from eai.data.files import write_whole
from eai.results.coverage import coverage_of, errata_effect, planners_of
from eai.results.rate import Rate
from eai.results.summary import by_attempt
from eai.scoring.records import line_of

SUMMARY = "summary.json"
RECORDS = "records.jsonl"


def write_results(
    folder: Path, records: list[Record], rates: Mapping[str, Rate], run: Mapping[str, Json] | None = None
) -> None:
    """Write the records and the summary of one model; ``run`` is what the summary says of a run besides.

    Raises:
        InputError: the folder cannot be written.
    """
    first, errata = records[0], errata_effect(records)
    planners = planners_of(record.verdict for record in records)
    summary: dict[str, Json] = {
        "protocol": first.protocol.value,
        "domain": first.domain,
        "ability": first.ability.value,
        "model": first.model,
        **({} if first.experiment is None else {"experiment": experiment_to_json(first.experiment)}),
        "data_sha256": first.data_sha256,
        "errata": None if errata is None else errata.to_json(),
        "coverage": coverage_of(records).to_json(),
        **({"planner": ", ".join(planners)} if planners else {}),
        "unit": "percent",
        **({} if run is None else {"run": run}),
        **{name: rate.to_json() for name, rate in rates.items()},
    }
    stages = by_attempt(records)
    if stages:
        summary["by_attempt"] = [{name: rate.to_json() for name, rate in each.items()} for each in stages]
    lines = (f"{line_of(record)}\n" for record in records)
    write_whole({folder / RECORDS: lines, folder / SUMMARY: json.dumps(summary, indent=2) + "\n"})
