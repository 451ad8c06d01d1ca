"""``eai analyze pipeline``: a model's pipeline against the same ability alone."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import groupby
from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table as Grid

from eai.abilities.goal_interpretation.declaration import GoalVerdict
from eai.abilities.protocol import Ability
from eai.abilities.responses import file_name
from eai.abilities.verdict import Verdict
from eai.benchmark.benchmark import Benchmark
from eai.benchmark.gold_answers import open_planned_book
from eai.benchmark.registry import find_benchmark
from eai.benchmark.suite import open_suite
from eai.cli.analyzed import Written, say
from eai.cli.console import data_progress, errors, output
from eai.cli.options import AsJson
from eai.cli.store import DataFolder, store
from eai.errors import InputError
from eai.planning.search import Limits
from eai.report.runs import Run, RunKey, read_runs
from eai.results.paper_tables import paper_models, paper_setting, paper_table
from eai.results.table import Estimate, Table
from eai.results.table_files import write_tables
from eai.studies.pipeline.analysis import Pipeline, pooled
from eai.studies.pipeline.stage_one import read_interpretations
from eai.tasks.source import Source

_NAME = "pipeline"

_LIMITS = Limits(400)
"""How much a perfect second stage may search; contradictory goals would use up any limit."""

_NOT_SHOWN = ("p", "only modular", "only pipeline")
"""The columns that are in the files alone."""


def pipeline(
    modular: Annotated[
        Path, typer.Argument(help="Records of the ability alone, or a folder of them.", metavar="MODULAR")
    ],
    piped: Annotated[
        Path, typer.Argument(help="Records of the pipeline, or a folder of them.", metavar="PIPELINE")
    ],
    out: Annotated[Path, typer.Option(help="The folder for the tables.")] = Path(_NAME),
    goals: Annotated[
        Path | None,
        typer.Option(
            help="The answers to goal interpretation: says which conditions are missing, and finds what a "
            "perfect second stage would reach.",
        ),
    ] = None,
    search: Annotated[
        bool, typer.Option(help="With --goals, search for plans (half a minute a hundred tasks).")
    ] = True,
    as_json: AsJson = False,
    data: DataFolder = None,
) -> None:
    """Compare a pipeline with the ability alone: both columns, and where the loss comes from.

    Runs of one model, domain, ability and protocol belong together; those of several models are pooled too.

    Example: eai analyze pipeline scores/modular scores/pipeline --goals answers --out pipeline
    """
    with data_progress() as report:
        source = Source(store(data), report)
    found = [
        _opened(one, other, goals, source, search=search)
        for one, other in _pairs(list(read_runs([modular])), list(read_runs([piped])))
    ]
    if not found:
        raise InputError(f"{modular} and {piped}: no model, domain, ability and protocol that both have")
    written: list[Written] = []
    for place, group in groupby(found, key=_place):
        several = [*group]
        for each in several:
            record = each.pipeline[0]
            label = "" if record.experiment is None else record.experiment.label
            folder = out / place / file_name(record.model) / label
            folder = folder if len(found) > 1 else out
            written.append(_write(each, f"{record.model}, {label}", folder, shown=not as_json))
        if len(several) > 1:
            title = f"{len(several)} pipelines"
            written.append(_write(pooled(several), title, out / place, shown=not as_json))
    if as_json:
        say(*written, as_json=True)


def _pairs(modular: Sequence[Run], piped: Sequence[Run]) -> Iterator[tuple[Run, Run]]:
    """The runs that belong together, sorted."""
    plain = {run.key: run for run in modular if run.key.experiment is None}
    for run in sorted(piped, key=lambda run: run.key.order):
        of_pipeline = run.key.experiment is not None and run.key.experiment.goals_from is not None
        alone = plain.get(RunKey(*run.key[:4]))
        if of_pipeline and alone is not None:
            yield alone, run
        elif of_pipeline:
            errors().print(f"left out, as it has no modular run: {run.key}", markup=False, soft_wrap=True)
    if not any(run.key.experiment and run.key.experiment.goals_from for run in piped):
        raise InputError(
            "PIPELINE: expected records of a pipeline; eai run --with pipeline.goals=own makes them, or eai "
            "score --goals"
        )


def _place(found: Pipeline) -> str:
    record = found.modular[0]
    return f"{record.domain}-{record.ability.value}-{record.protocol.value}"


def _opened(one: Run, other: Run, goals: Path | None, source: Source, *, search: bool) -> Pipeline:
    key = one.key
    interpreted: Mapping[str, GoalVerdict] = {}
    reachable: Mapping[str, bool] = {}
    if goals is not None:
        benchmark = find_benchmark(key.domain)
        answers = read_interpretations(goals, benchmark, source, _stage_one_model(other)).answers
        suite = open_suite(benchmark, Ability.GOAL_INTERPRETATION, source=source)
        interpreted = dict(_goal_verdicts((task, suite.score(task, text)) for task, text in answers.items()))
        if search:
            tasks = {record.task_id for record in other.records}
            wanted = {task: text for task, text in answers.items() if task in tasks}
            reachable = dict(_reached(benchmark, wanted, source))
    return Pipeline(one.records, other.records, reachable, interpreted, _paper_figures(key))


def _stage_one_model(run: Run) -> str:
    experiment = run.key.experiment
    return "" if experiment is None or experiment.goals_from is None else experiment.goals_from


def _goal_verdicts(verdicts: Iterator[tuple[str, Verdict]]) -> Iterator[tuple[str, GoalVerdict]]:
    for task, verdict in verdicts:
        if isinstance(verdict, GoalVerdict):
            yield task, verdict


def _reached(benchmark: Benchmark, answers: Mapping[str, str], source: Source) -> Iterator[tuple[str, bool]]:
    """Whether a plan for the stated goals, where there is one, reaches those of the task."""
    suite = open_suite(benchmark, Ability.ACTION_SEQUENCING, source=source)
    book = open_planned_book(benchmark, Ability.ACTION_SEQUENCING, source, answers, _LIMITS)
    for task_id in suite.task_ids:
        if task_id in answers:
            success = getattr(suite.score(task_id, book.gold(task_id).text), "success", False)
            yield task_id, bool(success)


def _paper_figures(key: RunKey) -> Mapping[str, tuple[float | None, float | None]]:
    """What the paper prints for the model, by metric."""
    name = paper_models().get(key.model)
    paper = paper_table(f"pipeline_{key.ability.value}")
    columns = [column for column in paper.columns if column.domain == key.domain]
    rows = [f"{name} ({kind})" for kind in ("modular", "pipeline")]
    if not all(row in paper.rows for row in rows):
        return {}
    return {
        column.metric: (paper.figure(rows[0], column), paper.figure(rows[1], column)) for column in columns
    }


def _remarks(found: Pipeline) -> list[str]:
    """What a reader must know of the paper's figures."""
    record = found.modular[0]
    remarks: list[str] = []
    if found.paper:
        paper = paper_table(f"pipeline_{record.ability.value}")
        remarks += [note.text for note in paper.notes if not note.models]
        if record.protocol.value != paper_setting().protocol:
            remarks.append(
                f"These records are of protocol {record.protocol.value}, the paper's figures are not."
            )
    return remarks


def _write(found: Pipeline, title: str, folder: Path, *, shown: bool) -> Written:
    tables = found.tables()
    write_tables(folder, _NAME, tables, _remarks(found))
    written = Written(tuple(table.name for table in tables), 0, folder)
    if not shown:
        return written
    record = found.modular[0]
    heading = f"{title}, {record.domain} {record.ability.value}, protocol {record.protocol.value}"
    output().print(_grid(next(table for table in tables if table.name == "goals"), heading))
    output().print(f"written to {folder}", soft_wrap=True, highlight=False, markup=False)
    return written


def _grid(table: Table, heading: str) -> Grid:
    """The table for the screen: tasks that are solved, and the difference in points, without intervals."""
    shown = [place for place, column in enumerate(table.names) if column not in _NOT_SHOWN]
    grid = Grid(title=f"{heading}: tasks solved, difference in points", title_justify="left")
    for place in shown:
        grid.add_column(table.names[place], justify="right" if place else "left")
    for row in table.rows:
        grid.add_row(*[_short(row[place]) for place in shown])
    return grid


def _short(cell: object) -> str:
    if not isinstance(cell, Estimate):
        return str(cell)
    if cell.value is None:
        return "-"
    return f"{cell.value:+.1f}" if cell.numerator is None else f"{cell.numerator:g}"
