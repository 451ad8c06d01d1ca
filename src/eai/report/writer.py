"""Writing a report: tables, plots and the explorer into a folder."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import groupby
from pathlib import Path

from eai.data.files import write_whole
from eai.questions.records import QuestionRun
from eai.report import latex
from eai.report.agreement import agreements
from eai.report.besides import tables_besides
from eai.report.cost import cost_csv, cost_section
from eai.report.data_files import tables_csv, tables_json
from eai.report.document import Plot, report_markdown
from eai.report.narrow import Narrow
from eai.report.questions import questions_json, questions_latex
from eai.report.row import Notes, Row
from eai.report.run_summary import RunSummary, plain_runs
from eai.report.table import Table, cells_of_run, make_table, run_rows
from eai.report.table_specs import TableSpec, ability_title, of_ability, tables_of
from eai.results.cost import PriceList

WHOLE = Narrow()
"""All of every table."""


def make_tables(runs: Sequence[RunSummary], *, with_paper: bool) -> list[Table]:
    """All tables, by protocol and domain, in the order of the paper's.

    Args:
        runs: the runs, sorted by the order of their keys.
        with_paper: whether the paper's models appear beside ours.
    """
    places = groupby(runs, key=lambda item: (item.key.protocol, item.key.domain))
    return [
        table
        for (protocol, domain), group in ((place, list(items)) for place, items in places)
        for spec in tables_of(item.key.ability for item in group)
        if (table := make_table(spec, protocol, domain, group, with_paper=with_paper))
    ]


def write_tables(
    folder: Path,
    runs: Sequence[RunSummary],
    tables: Sequence[Table],
    plots: Sequence[Plot],
    *,
    with_paper: bool,
    narrow: Narrow = WHOLE,
    prices: PriceList | None = None,
    questions: Sequence[QuestionRun] = (),
) -> int:
    """Write ``report.md``, ``report.tex`` with ``tables.tex``, ``tables.json`` and ``tables.csv``.

    Experiments have tables of their own. With the paper there is also what it reports besides. Where records
    say what their answers took, there is ``cost.csv``. Runs of world-model questions are in ``report.md``,
    ``tables.tex`` and ``questions.json``.

    Args:
        folder: where the files go.
        runs: all runs, experiments too.
        tables: the tables of the plain runs.
        plots: the plots of the plain runs.
        with_paper: whether the paper's models appear beside ours.
        narrow: what of them is shown in LaTeX, where a page has an end.
        prices: what tokens cost that were not priced when they were asked for.
        questions: the runs of world-model questions, by domain and questions.

    Raises:
        InputError: a model or column to be shown is in none of them.

    Returns:
        how many tables were written.
    """
    plain = plain_runs(runs)
    experiments = _experiment_tables(runs)
    besides = tables_besides(plain) if with_paper else []
    written = [*tables, *experiments, *besides]
    compared = agreements(plain) if with_paper else []
    cost = "\n".join(cost_section(runs, prices, with_paper=with_paper))
    contents = {
        "report.md": report_markdown(runs, tables, experiments, besides, compared, cost, plots, questions),
        "tables.tex": "\n".join([*_latex(written, questions, narrow)]),
        "report.tex": f"{latex.PREAMBLE}\\input{{tables}}\n{latex.ENDING}",
        "tables.json": tables_json(written),
        "tables.csv": tables_csv(written),
    }
    if (paid := cost_csv(runs, prices)) is not None:
        contents["cost.csv"] = paid
    if questions:
        contents["questions.json"] = questions_json(questions)
    write_whole({folder / name: text for name, text in contents.items()})
    return len(written)


def _experiment_tables(runs: Sequence[RunSummary]) -> list[Table]:
    """A table of each suite that has experiments, with those of its models that have any.

    The plain run of the same model stands above its experiments, as what they are to be compared with.

    Args:
        runs: the runs, plain ones too, sorted by the order of their keys.
    """
    places = groupby(runs, key=lambda item: item.key[:3])
    return [table for _, group in places if (table := _experiment_table(list(group))) is not None]


def _experiment_table(runs: Sequence[RunSummary]) -> Table | None:
    """The table of one suite, or None if it has no experiment."""
    models = {item.key.model for item in runs if item.key.experiment is not None}
    shown = [item for item in runs if item.key.model in models]
    if not shown:
        return None
    key = shown[0].key
    spec = of_ability(key.ability)
    notes = Notes()
    return Table(
        f"experiments_{spec.name}",
        f"Experiments: {ability_title(key.ability).lower()}",
        key.protocol,
        key.domain,
        spec.columns,
        ((),) * len(spec.columns),
        tuple(_experiment_rows(spec, shown, notes)),
        tuple(notes.texts),
    )


def _experiment_rows(spec: TableSpec, runs: Sequence[RunSummary], notes: Notes) -> Iterator[Row]:
    for item in runs:
        for row in run_rows(spec.columns, [item], {item.key.model: cells_of_run(item)}, notes):
            yield replace(row, model=item.key.name)


def _latex(tables: Sequence[Table], questions: Sequence[QuestionRun], narrow: Narrow) -> Iterator[str]:
    """Every table in LaTeX."""
    for table in narrow.tables(tables, besides={run.model for run in questions}):
        yield latex.table_latex(table, intervals=narrow.intervals)
    yield from questions_latex(questions, narrow.models)
