"""Matrices of shares by action and by predicate."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from eai.analysis.suites import MODEL
from eai.analysis.table import Cell, Estimate
from eai.metrics.rate import Rate
from eai.report.plot_analyses import draw_matrix
from eai.report.run_summary import RunSummary

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_MOST_NAMES = 40
"""So many fit a page."""


def draw_actions(runs: Sequence[RunSummary]) -> Figure | None:
    """The shares by action of each model; None if they are not known."""
    return _draw({item.key.model: item.breakdown.by_action for item in runs})


def draw_predicates(runs: Sequence[RunSummary]) -> Figure | None:
    """The shares by predicate of each model; None if they are not known."""
    return _draw({item.key.model: item.breakdown.by_predicate for item in runs})


def _draw(models: Mapping[str, Mapping[str, Rate]]) -> Figure | None:
    rows: list[Mapping[str, Cell]] = []
    for name in _most_frequent(list(models.values())):
        for model, rates in models.items():
            rate = rates.get(name, Rate(0, 0))
            share = Estimate(rate.percent, numerator=rate.numerator, denominator=rate.denominator)
            rows.append({"name": name, MODEL: model, "share": share})
    return draw_matrix(rows, ("name",), "share", "percent", zeros=True)


def _most_frequent(columns: Sequence[Mapping[str, Rate]]) -> list[str]:
    """The names with most cases, in order; answers can have any number of names of their own."""
    cases: dict[str, float] = {}
    for column in columns:
        for name, rate in column.items():
            cases[name] = cases.get(name, 0) + rate.denominator
    return sorted(sorted(cases, key=lambda name: (-cases[name], name))[:_MOST_NAMES])
