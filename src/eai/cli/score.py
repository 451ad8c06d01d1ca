"""``eai score``: from response files to records and a summary."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from eai.abilities.declarations import DECLARATIONS
from eai.abilities.responses import Response, ResponseFile, find_response_files, read_responses
from eai.benchmarks.answer_files import files_of_suite
from eai.benchmarks.source import Source
from eai.benchmarks.suite import DEFAULT_PROTOCOL, Suite, open_suite
from eai.cli.console import Result, data_progress, note_planner, output, print_rates, without_inspect
from eai.cli.data import DataFolder, store
from eai.cli.options import (
    ANSWERS,
    OUTPUT,
    AllowMissing,
    Domain,
    Explanations,
    OneAbility,
    Planner,
    Rules,
    Workers,
)
from eai.errors import InputError
from eai.metrics.coverage import coverage_of
from eai.metrics.summary import summarise
from eai.pddl.planning import PlannerChoice
from eai.scoring.batch import NO_ROW, Settings, score_run
from eai.scoring.results import write_results
from eai.scoring.stage_one import read_believed, refuse_no_stage_two

Goals = Annotated[
    Path | None,
    typer.Option(
        "--goals",
        metavar="PATH",
        help="Of a pipeline: the answers to goal interpretation whose goals the questions stated.",
        rich_help_panel=ANSWERS,
    ),
]

LOG_SUFFIX = ".eval"
"""How the names of Inspect's logs end."""


def score(
    paths: Annotated[
        list[Path],
        typer.Argument(help="Response files, folders of them, or logs of Inspect's.", metavar="PATH..."),
    ],
    domain: Domain,
    ability: OneAbility,
    protocol: Rules = DEFAULT_PROTOCOL,
    planner: Planner = PlannerChoice.AUTO,
    workers: Workers = 1,
    explanations: Explanations = True,
    allow_missing: AllowMissing = False,
    goals: Goals = None,
    out: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Where records and summary go.", rich_help_panel=OUTPUT),
    ] = None,
    data: DataFolder = None,
) -> None:
    """Score answers: verdicts to OUT/records.jsonl, rates to OUT/summary.json, the main table to the screen.

    A task without an answer counts as failed. With several files each model gets a folder of its own in OUT.

    Example: eai score gpt-4o_outputs.json --domain virtualhome --ability action_sequencing --out scores
    """
    for path in paths:
        find_response_files(path)  # what is not there is said before the data set is fetched
    results: dict[str, Result] = {}
    settings = Settings(workers, explanations, allow_missing)
    if goals is not None:
        refuse_no_stage_two(ability)
    with data_progress() as report:
        source = Source(store(data), report, planner)
        suite = open_suite(domain, ability, protocol, source=source)
    note_planner([suite])
    files = [file for path in paths for file in files_of_suite(path, suite.domain, ability)]
    given = [_in_order(_read(file, suite), suite.task_ids) for file in files]
    _refuse_twins([answers.model for answers in given])
    for answers in given:
        answered = {response.task_id for response in answers.responses}
        missing = {task_id: NO_ROW for task_id in suite.task_ids if task_id not in answered}
        records = score_run(suite, answers, missing, settings)
        if goals is not None:
            believed = read_believed(goals, suite.benchmark, ability, source, answers.model)
            records = [believed.marked(record) for record in records]
        rates = summarise([record.verdict for record in records], ability)
        results[answers.model] = Result(rates, coverage_of(records))
        if out is not None:
            write_results(out / answers.model if len(files) > 1 else out, records, rates)
    title = f"{suite.domain}, {ability.value}, protocol {protocol.value}"
    print_rates(title, DECLARATIONS[ability].terminal, results)
    if out is not None:
        output().print(f"written to {out}", soft_wrap=True, highlight=False)


def _read(file: Path, suite: Suite) -> ResponseFile:
    """The answers in a response file or a log; Inspect, which reads logs, is imported only for one."""
    if file.suffix != LOG_SUFFIX:
        return read_responses(file, suite.task_ids, suite.benchmark.task_id_of)
    try:
        from eai.run.logs import read_answers
    except ImportError as error:
        raise without_inspect(error) from error
    return read_answers(file, suite)


def _in_order(answers: ResponseFile, task_ids: tuple[str, ...]) -> ResponseFile:
    """The answers in the order of the data set."""
    by_id: dict[str, Response] = {response.task_id: response for response in answers.responses}
    return ResponseFile(answers.model, tuple(by_id[i] for i in task_ids if i in by_id))


def _refuse_twins(names: Sequence[str]) -> None:
    """Raise if two files are of one model, because their results would overwrite each other."""
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"{name}: two files are of this model; score them one at a time")
