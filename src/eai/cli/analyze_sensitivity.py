"""``eai analyze sensitivity``: which operator of a model breaks plans."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Annotated

import typer

from eai.abilities.protocol import Ability, Protocol
from eai.abilities.record import Record
from eai.abilities.transition_modeling.judgement import Replaced
from eai.abilities.transition_modeling.scorer import TransitionModeling
from eai.benchmark.suite import Suite, open_suite
from eai.cli.analyzed import Figures, Plots, Records, of_suite, say, write_analysis
from eai.cli.console import data_progress, note_planner
from eai.cli.options import AsJson, Planner
from eai.cli.progress import scoring_progress
from eai.cli.store import DataFolder, store
from eai.errors import InputError
from eai.pddl.planning import PlannerChoice
from eai.report.runs import read_runs
from eai.results import plot_analyses
from eai.results.table import Table
from eai.studies.sensitivity.analysis import OVERALL, Trial, sensitivity_tables, try_operators
from eai.tasks.source import Source


def sensitivity(
    records: Records,
    out: Annotated[Path, typer.Option(help="The folder for the results.")],
    replace: Annotated[
        list[Replaced] | None,
        typer.Option(
            metavar="PART",
            help="What of a gold operator is the model's: operator (if not given), precondition, effect.",
        ),
    ] = None,
    planner: Planner = PlannerChoice.AUTO,
    plots: Plots = True,
    as_json: AsJson = False,
    data: DataFolder = None,
) -> None:
    """Try each operator of the answers alone among gold operators: which one breaks plans?

    Example: eai analyze sensitivity scores --out sensitivity
    """
    if planner is PlannerChoice.NONE:
        raise InputError("--planner none: operators are tried by a planner")
    found = [
        record
        for run in read_runs(records)
        if run.key.ability is Ability.TRANSITION_MODELING
        for record in run.records
    ]
    if not found:
        raise InputError("expected records of transition modeling, found none")
    with data_progress() as report:
        suites = _suites(found, Source(store(data), report, planner))
    note_planner(list(suites.values()))
    ways = list(dict.fromkeys(replace or [Replaced.OPERATOR]))
    tables = sensitivity_tables(list(_tried(found, suites, ways)))
    written = write_analysis("sensitivity", tables, _figures(tables, ways), out, plots=plots)
    say(written, as_json=as_json)


def _suites(records: Sequence[Record], source: Source) -> dict[tuple[str, Protocol], Suite]:
    """One suite for all models, so that equal operators are planned with once."""
    return {
        key: open_suite(key[0], Ability.TRANSITION_MODELING, key[1], source=source)
        for key in dict.fromkeys((record.domain, record.protocol) for record in records)
    }


def _tried(
    records: Sequence[Record], suites: dict[tuple[str, Protocol], Suite], ways: Sequence[Replaced]
) -> Iterator[Trial]:
    with scoring_progress("trying operators", len(records), quiet=False) as told:
        for number, record in enumerate(records, 1):
            scorer = suites[record.domain, record.protocol].scorer(record.task_id)
            if isinstance(scorer, TransitionModeling):
                for way in ways:
                    yield from try_operators(scorer, record, way)
            told(number)


def _figures(tables: Sequence[Table], ways: Sequence[Replaced]) -> Figures:
    for suite, rows in plot_analyses.rows_of(tables[0]).items():
        for way in ways:
            of_way = [row for row in rows if row["replaced"] == way.value]
            label = f"percent solved with the model's {way.value}"
            shown = [row for row in of_way if row["category"] == OVERALL]
            models = plot_analyses.draw_matrix(shown, ("operator",), "solved", label, zeros=True)
            yield of_suite(suite, way.value, models)
            shown = [row for row in of_way if row["model"] == of_way[0]["model"]]
            categories = plot_analyses.draw_matrix(
                shown, ("operator",), "solved", label, across="category", zeros=True
            )
            yield of_suite(suite, f"{way.value}-categories", categories)
