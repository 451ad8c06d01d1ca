"""``eai score``: from response files to records and a summary."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated

import typer

from eai.abilities.declarations import DECLARATIONS
from eai.abilities.protocol import Ability, Domain, Protocol
from eai.abilities.record import Record
from eai.abilities.responses import Response, ResponseFile, find_response_files, model_name, read_responses
from eai.abilities.suite import Source, open_suite
from eai.abilities.verdict import Json
from eai.cli.console import data_progress, output, print_rates
from eai.cli.data import DataFolder, store
from eai.errors import InputError
from eai.metrics.rate import Rate
from eai.metrics.summary import summarise
from eai.pddl.planning import PlannerChoice
from eai.scoring.batch import score_batch
from eai.scoring.records import write_records

SUMMARY = "summary.json"
RECORDS = "records.jsonl"


def score(
    paths: Annotated[
        list[Path], typer.Argument(help="Response files, or folders of them.", metavar="PATH...")
    ],
    domain: Annotated[Domain, typer.Option(help="The domain of the tasks.")],
    ability: Annotated[Ability, typer.Option(help="What the answers are.")],
    protocol: Annotated[Protocol, typer.Option(help="The rules for scoring.")] = Protocol.STRICT,
    workers: Annotated[int, typer.Option(min=1, help="Processes to score with.")] = 1,
    out: Annotated[Path | None, typer.Option(help="Where to write records and summary.")] = None,
    explanations: Annotated[
        bool, typer.Option(help="Put a step-by-step explanation into every record.")
    ] = True,
    planner: Annotated[
        PlannerChoice, typer.Option(help="Transition modeling: which planner judges operators.")
    ] = PlannerChoice.FULL,
    data: DataFolder = None,
) -> None:
    """Score answers: verdicts to OUT/records.jsonl, rates to OUT/summary.json, the main table to the screen.

    With several response files each model gets a folder of its own below OUT.

    Example: eai score gpt-4o_outputs.json --domain virtualhome --ability action_sequencing --out scores
    """
    files = [file for path in paths for file in find_response_files(path)]
    _refuse_twins(files)
    rates: dict[str, dict[str, Rate]] = {}
    with data_progress() as report:
        source = Source(store(data), report, planner)
        task_ids = open_suite(domain, ability, protocol, source=source).task_ids
    for file in files:
        answers = _in_order(read_responses(file, task_ids), task_ids)
        suite = open_suite(
            domain, ability, protocol, answers=[r.text for r in answers.responses], source=source
        )
        records = score_batch(suite, answers, workers=workers, explanations=explanations)
        rates[answers.model] = summarise([r.verdict for r in records], ability)
        if out is not None:
            write_results(out / answers.model if len(files) > 1 else out, records, rates[answers.model])
    title = f"{domain.value}, {ability.value}, protocol {protocol.value}"
    print_rates(title, DECLARATIONS[ability].terminal, rates)
    if out is not None:
        output().print(f"written to {out}", soft_wrap=True, highlight=False)


def write_results(
    folder: Path, records: list[Record], rates: Mapping[str, Rate], run: Mapping[str, Json] | None = None
) -> None:
    """Write the records and the summary of one model; ``run`` is what the summary says of a run besides.

    Raises:
        InputError: the folder cannot be written.
    """
    first = records[0]
    summary: dict[str, Json] = {
        "protocol": first.protocol.value,
        "domain": first.domain,
        "ability": first.ability.value,
        "model": first.model,
        "data_sha256": first.data_sha256,
        "unit": "percent",
        **({} if run is None else {"run": run}),
        **{name: rate.to_json() for name, rate in rates.items()},
    }
    try:
        folder.mkdir(parents=True, exist_ok=True)
        write_records(folder / RECORDS, records)
        (folder / SUMMARY).write_text(json.dumps(summary, indent=2) + "\n", encoding="utf-8")
    except OSError as error:
        raise InputError(f"{folder}: cannot be written ({error.strerror})") from error


def _in_order(answers: ResponseFile, task_ids: tuple[str, ...]) -> ResponseFile:
    """The answers in the order of the data set."""
    by_id: dict[str, Response] = {response.task_id: response for response in answers.responses}
    return ResponseFile(answers.model, tuple(by_id[i] for i in task_ids if i in by_id))


def _refuse_twins(files: list[Path]) -> None:
    """Raise if two response files are of one model, because their results would overwrite each other."""
    names = [model_name(file) for file in files]
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"{name}: two response files are of this model; score them one at a time")
