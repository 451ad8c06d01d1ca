"""Items: how difficult tasks are, which tell models apart, and which are odd."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from eai.abilities.options import Options
from eai.errors import InputError
from eai.results.plots import COLUMN, INK, MUTED, RULE, clipped, draw_estimate, rows_of, sheet, value_of
from eai.results.table import Cell, Estimate, Table
from eai.studies.records import Records
from eai.studies.study import Analysis, Figures, Study, of_suite

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def _analyze(records: Records, chosen: Options) -> Iterator[Analysis]:
    from eai.studies.items.analysis import FEWEST_MODELS, item_tables
    from eai.studies.items.item_flags import item_flags

    found = item_tables(records.tables().answers, item_flags(records.source))
    if not found[0].rows:
        raise InputError(f"expected answers of at least {FEWEST_MODELS} models to one suite")
    yield Analysis(found, _figures(found))


def _figures(found: Sequence[Table]) -> Figures:
    abilities = rows_of(found[1])
    for suite, rows in rows_of(found[3]).items():
        yield of_suite(suite, "items", draw(rows, abilities[suite]))


_BINS_PER_UNIT = 2


def draw(items: Sequence[Mapping[str, Cell]], models: Sequence[Mapping[str, Cell]]) -> Figure | None:
    """How many tasks there are of each difficulty, and below, on the same scale, the models' abilities.

    A test says most of models whose abilities are where its difficulties are.

    Args:
        items: the rows of the table of tasks of a suite.
        models: those of the table of models.
    """
    difficulties = [float(row["difficulty"]) for row in items if isinstance(row["difficulty"], float)]
    if not difficulties:
        return None
    figure = sheet(COLUMN, 1.6 + 0.17 * len(models))
    top, bottom = figure.subplots(
        2, 1, sharex=True, gridspec_kw={"height_ratios": [1.2, 0.35 + 0.17 * len(models)]}
    )
    ends = [value_of(row["logit"]) for row in models]
    low, high = min([*difficulties, *ends]) - 0.3, max([*difficulties, *ends]) + 0.3
    width = 1 / _BINS_PER_UNIT
    edges = [width * step for step in range(int(low / width) - 1, int(high / width) + 2)]
    top.hist(difficulties, bins=edges, color=MUTED, edgecolor="white", linewidth=0.6)
    top.set_ylabel("tasks", fontsize=7)
    top.grid(axis="y", color=RULE, linewidth=0.6)
    top.set_axisbelow(True)
    for place, row in enumerate(models):
        cell = row["logit"]
        draw_estimate(bottom, place, cell if isinstance(cell, Estimate) else None, INK, INK)
    bottom.set_yticks(
        range(len(models)), labels=[clipped(str(row["answered_by"])) for row in models], fontsize=6.5
    )
    bottom.set_ylim(len(models) - 0.5, -0.5)
    bottom.tick_params(axis="y", length=0)
    bottom.grid(axis="x", color=RULE, linewidth=0.6)
    bottom.set_xlabel("difficulty of tasks (above), ability of models", fontsize=7, loc="right")
    return figure


ITEMS = Study(
    "items",
    "Tasks by the answers of many models: difficulty, agreement with other tasks, and what is odd.",
    analyze=_analyze,
    together=True,
)
