"""Matrices of shares by action and by predicate."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from eai.abilities.protocol import Ability
from eai.report.run_summary import RunSummary
from eai.results.plot_analyses import draw_matrix
from eai.results.rate import Rate
from eai.results.suites import MODEL
from eai.results.table import Cell, Estimate

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_MOST_NAMES = 40
"""So many fit a page."""

_F1 = "F1 of clauses, percent"


def draw_actions(runs: Sequence[RunSummary]) -> Figure | None:
    """The shares by action of each model, of one ability; None if they are not known."""
    label = {Ability.TRANSITION_MODELING: _F1}.get(runs[0].key.ability, "percent of steps executed")
    return _draw({item.key.model: item.breakdown.by_action for item in runs}, label)


def draw_predicates(runs: Sequence[RunSummary]) -> Figure | None:
    """The shares by predicate of each model, of one ability; None if they are not known."""
    found = {Ability.TRANSITION_MODELING: _F1, Ability.GOAL_INTERPRETATION: "percent of goals found"}
    label = found.get(runs[0].key.ability, "percent of goals reached")
    return _draw({item.key.model: item.breakdown.by_predicate for item in runs}, label)


def _draw(models: Mapping[str, Mapping[str, Rate]], label: str) -> Figure | None:
    rows: list[Mapping[str, Cell]] = []
    for name in _most_frequent(list(models.values())):
        for model, rates in models.items():
            rate = rates.get(name, Rate(0, 0))
            share = Estimate(rate.percent, numerator=rate.numerator, denominator=rate.denominator)
            rows.append({"name": name, MODEL: model, "share": share})
    return draw_matrix(rows, ("name",), "share", label, zeros=True)


def _most_frequent(columns: Sequence[Mapping[str, Rate]]) -> list[str]:
    """The names with most cases, in order; answers can have any number of names of their own."""
    cases: dict[str, float] = {}
    for column in columns:
        for name, rate in column.items():
            cases[name] = cases.get(name, 0) + rate.denominator
    return sorted(sorted(cases, key=lambda name: (-cases[name], name))[:_MOST_NAMES])
