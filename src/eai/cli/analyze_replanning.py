"""``eai analyze replanning``: what further attempts are worth, beside attempts that are told nothing."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby
from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table as Grid

from eai.abilities.responses import file_name
from eai.cli.analyzed import Figures, Plots, Records, Written, draw_figures, of_run, say
from eai.cli.console import output
from eai.cli.options import AsJson
from eai.errors import InputError
from eai.report.runs import Run, RunKey, as_counted_in_paper, read_runs
from eai.results.paper_tables import paper_setting, paper_table
from eai.results.table import Cell, Estimate, Table
from eai.results.table_files import write_tables
from eai.studies.attempts import plots as plot_attempts
from eai.studies.attempts.analysis import Arm, arms_of, remarks, tables

_NAME = "replanning"
_PAPER = ("replanning", "replanning_prose", "replanning_stochastic")


def replanning(
    records: Records,
    out: Annotated[Path, typer.Option(help="The folder for the tables.")] = Path(_NAME),
    published_counts: Annotated[
        bool,
        typer.Option(
            "--published-counts",
            help="Count as the published script did: an error only where the last attempt was used up.",
        ),
    ] = False,
    plots: Plots = True,
    as_json: AsJson = False,
) -> None:
    """Success by the number of attempts, what feedback is worth, and which errors it mends.

    Runs of one model, domain, ability and protocol belong together: those with feedback, and the one with
    attempts.feedback=none, without which nobody knows what feedback is worth.

    Example: eai analyze replanning runs --out replanning
    """
    runs = [run for run in read_runs(records) if _is_shown(run)]
    groups = [list(group) for _, group in groupby(sorted(runs, key=lambda run: run.key.order), _place)]
    if not groups:
        raise InputError(
            "expected records of replanning or slips, found none; eai run --with attempts.replans=3 does"
        )
    written: list[Written] = []
    for group in groups:
        of_runs = [as_counted_in_paper(run).records if published_counts else run.records for run in group]
        key = group[0].key
        place = f"{key.domain}-{key.protocol.value}-{file_name(key.model)}"
        arms, folder = arms_of(of_runs), out / place if len(groups) > 1 else out
        made, notes = _tables(arms, key)
        write_tables(folder, _NAME, made, [*remarks(arms), *notes])
        drawn = draw_figures(_figures(arms, key), folder) if plots else 0
        written.append(Written(tuple(table.name for table in made), drawn, folder))
        if not as_json:
            _show(made, remarks(arms), key, folder)
    if as_json:
        say(*written, as_json=True)


def _is_shown(run: Run) -> bool:
    return run.key.experiment is not None and run.key.experiment.acts


def _place(run: Run) -> tuple[str, ...]:
    key = run.key
    return (key.protocol.value, key.domain, key.ability.value, key.model)


def _tables(arms: Sequence[Arm], key: RunKey) -> tuple[list[Table], list[str]]:
    """The tables, the paper's among them, and what must be said of that."""
    made = tables(arms)
    paper, notes = _paper(key.domain)
    if paper.rows:
        made.append(paper)
        if key.protocol.value != paper_setting().protocol:
            notes.append(f"These records are of protocol {key.protocol.value}, the paper's figures are not.")
    return made, notes


def _show(made: Sequence[Table], told: Sequence[str], key: RunKey, folder: Path) -> None:
    output().print(_grid(made[0], f"{key.model}, {key.domain}, protocol {key.protocol.value}"))
    output().print(_grid(made[1], made[1].title))
    for remark in told:
        output().print(remark, markup=False, highlight=False)
    output().print(f"written to {folder}", soft_wrap=True, highlight=False, markup=False)


def _figures(arms: Sequence[Arm], key: RunKey) -> Figures:
    yield of_run(key, "success_by_attempt", plot_attempts.draw(arms))


def _paper(domain: str) -> tuple[Table, list[str]]:
    """What the paper prints for a domain, and what a reader must know of it."""
    rows: list[tuple[Cell, ...]] = []
    notes: list[str] = []
    for paper in map(paper_table, _PAPER):
        columns = {column.metric: column for column in paper.columns if column.domain == domain}
        if columns:
            notes += [note.text for note in paper.notes if not note.models]
            for name in paper.rows:
                figures = [
                    paper.figure(name, columns[metric]) if metric in columns else None for metric in _FIGURES
                ]
                rows.append((paper.title, name, *figures))
    definition = "Percent, as printed. Read the notes at the head of this page before comparing them."
    names = tuple(metric.replace("_", " ") for metric in _FIGURES)
    table = Table("paper", "The paper's figures", definition, ("table", "model", *names), tuple(rows))
    return table, list(dict.fromkeys(notes))


_FIGURES = ("task_success", "execution_success", "missing_step", "additional_step")


def _grid(table: Table, heading: str) -> Grid:
    """The first columns of a table for the screen."""
    shown = [place for place, name in enumerate(table.names) if name in _SHOWN]
    grid = Grid(title=heading, title_justify="left")
    for place in shown:
        grid.add_column(table.names[place], justify="right" if place else "left", overflow="fold")
    for row in table.rows:
        grid.add_row(*_cells([row[place] for place in shown]))
    return grid


_SHOWN = (
    *("arm", "attempts", "task success", "execution success"),
    *("told nothing", "with feedback", "difference"),
)


def _cells(cells: Sequence[Cell]) -> Iterator[str]:
    for cell in cells:
        if not isinstance(cell, Estimate):
            yield str(cell)
        elif cell.value is None:
            yield "-"
        elif cell.low is None or cell.high is None:
            yield f"{cell.value:.1f}"
        elif cell.denominator is None:
            yield f"{cell.value:+.1f}\n{cell.low:+.1f} to {cell.high:+.1f}"
        else:
            yield f"{cell.value:.1f}\n{cell.low:.1f} to {cell.high:.1f}"
