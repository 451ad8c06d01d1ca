"""Cofactors: what success depends on."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from pydantic import Field

from eai.abilities.options import Options
from eai.data.grouping import grouped
from eai.results.lines import Measure
from eai.results.plots import COLUMN, INK, MUTED, RULE, draw_estimate, draw_line, draw_names, rows_of, sheet
from eai.results.table import Cell, Table
from eai.studies.records import Records
from eai.studies.study import Analysis, Figures, Study, of_suite

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


class _Choices(Options):
    """How success is set against features of tasks.

    Attributes:
        bins: How many lengths of annotated plans stand together.
        measure: What features of tasks are set against: score, executable or goals.
    """

    bins: int = Field(default=10, ge=1)
    measure: Measure = "score"


def _analyze(records: Records, chosen: _Choices) -> Iterator[Analysis]:
    from eai.studies.cofactors.analysis import cofactor_tables

    found = cofactor_tables(records.tables(), width=chosen.bins, measure=chosen.measure)
    yield Analysis(found, _figures(found, chosen.measure))


def _figures(found: Sequence[Table], measure: Measure) -> Figures:
    adjusted, _, curves, by_action, by_predicate = found
    for suite, rows in rows_of(curves).items():
        yield of_suite(suite, "curves", draw_curves(rows, f"{measure}, percent"))
    for suite, rows in rows_of(adjusted).items():
        yield of_suite(suite, "adjusted", draw_effects(rows))
    for suite, rows in rows_of(by_action).items():
        figure = draw_names(rows, "action", "executed", "executed of the steps tried")
        yield of_suite(suite, "by_action", figure)
    for suite, rows in rows_of(by_predicate).items():
        figure = draw_names(rows, "predicate", "reached", "reached of the goals that mention it")
        yield of_suite(suite, "by_predicate", figure)


SHOWN = (
    "annotated_steps",
    "annotated_operators",
    "ground_relation_goals",
    "ground_state_goals",
    "objects",
    "quantified_goals",
)
"""The features that are drawn; the table has them all."""

_PER_ROW = 2
_HEIGHT = 1.9
_EFFECT_ROW = 0.3


def draw_curves(rows: Sequence[Mapping[str, Cell]], label: str) -> Figure | None:
    """Success by feature, a panel a feature: all models together with intervals, each of them as a thin line.

    None if no feature is known.
    """
    shown = [name for name in SHOWN if any(row["feature"] == name for row in rows)]
    if not shown:
        return None
    lines = -(-len(shown) // _PER_ROW)
    figure = sheet(COLUMN * _PER_ROW, _HEIGHT * lines)
    grid = figure.subplots(lines, _PER_ROW, squeeze=False, sharey=True)
    for place, panel in enumerate(grid.flat):
        if place < len(shown):
            _draw_feature(panel, shown[place], [row for row in rows if row["feature"] == shown[place]])
        else:
            panel.set_axis_off()
    for panels in grid:
        panels[0].set_ylabel(label)
    return figure


def _draw_feature(panel: Axes, feature: str, rows: Sequence[Mapping[str, Cell]]) -> None:
    panel.set_ylim(-4, 104)
    panel.grid(axis="y", color=RULE, linewidth=0.6)
    panel.set_title(feature.replace("_", " "), fontsize=8.5)
    bins = sorted({(int(str(row["from"])), int(str(row["to"]))) for row in rows})
    models = grouped((row["model"], (int(str(row["from"])), row)) for row in rows)
    first, *others = [dict(of_model) for of_model in models.values()]
    places = range(len(bins))
    for of_bin in others:
        cells = [of_bin[low]["score"] if low in of_bin else None for low, _ in bins]
        draw_line(panel, places, cells, MUTED, "-", intervals=False, linewidth=0.6, alpha=0.55)
    cells = [first[low]["score"] if low in first else None for low, _ in bins]
    hollow = [place for place, (low, _) in enumerate(bins) if low in first and first[low]["few"]]
    draw_line(panel, places, cells, INK, hollow=hollow)
    labels = [f"{_bin(low, high)}\n{first[low]['tasks'] if low in first else ''}" for low, high in bins]
    panel.set_xticks(range(len(bins)), labels=labels, fontsize=6.5)
    panel.text(-0.02, -0.17, "tasks", transform=panel.transAxes, fontsize=6.5, ha="right", va="top")


def _bin(low: int, high: int) -> str:
    return str(low) if low == high else f"{low:,}–{high:,}"


def draw_effects(rows: Sequence[Mapping[str, Cell]]) -> Figure | None:
    """The log odds of each feature, alone (hollow) and beside the others (filled); None if there are none."""
    if not rows:
        return None
    figure = sheet(COLUMN, 1.12 + _EFFECT_ROW * len(rows))
    panel = figure.subplots()
    panel.axvline(0, color=MUTED, linewidth=0.8)
    for place, row in enumerate(rows):
        draw_estimate(panel, place - 0.14, row["alone"], MUTED, "white")
        draw_estimate(panel, place + 0.14, row["together"], INK, INK)
    panel.set_yticks(
        range(len(rows)), labels=[str(row["feature"]).replace("_", " ") for row in rows], fontsize=7
    )
    panel.invert_yaxis()
    panel.tick_params(axis="y", length=0)
    panel.spines["left"].set_visible(False)
    meaning = "log odds of success per standard deviation\n○ alone   ● beside the others\n"
    answers, names = (int(str(rows[0][column])) for column in ("answers", "names"))
    panel.set_xlabel(f"{meaning}{answers:,} answers to tasks of {names:,} names", fontsize=7)
    return figure


COFACTORS = Study(
    "cofactors",
    "Success against what tasks are like, and what is left of each feature beside the others.",
    choices=_Choices,
    analyze=_analyze,
    together=True,
)
