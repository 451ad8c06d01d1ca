"""Tables of experiments: runs of several attempts, of slips or of other goals, never among single answers.

The plain run of the same model stands above its experiments, as what they are to be compared with.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import groupby

from eai.report.row import Notes, Row
from eai.report.run_summary import RunSummary
from eai.report.table import Table, cells_of_run, run_rows
from eai.report.table_specs import TableSpec, ability_title, of_ability


def experiment_tables(runs: Sequence[RunSummary]) -> list[Table]:
    """A table of each suite that has experiments, with those of its models that have any.

    Args:
        runs: the runs, plain ones too, sorted by the order of their keys.
    """
    places = groupby(runs, key=lambda item: item.key[:3])
    return [table for _, group in places if (table := _table(list(group))) is not None]


def _table(runs: Sequence[RunSummary]) -> Table | None:
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
        tuple(_rows(spec, shown, notes)),
        tuple(notes.texts),
    )


def _rows(spec: TableSpec, runs: Sequence[RunSummary], notes: Notes) -> Iterator[Row]:
    for item in runs:
        for row in run_rows(spec.columns, [item], {item.key.model: cells_of_run(item)}, notes):
            yield replace(row, model=item.key.name)
