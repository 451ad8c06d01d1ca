"""Rates on a terminal, and what ``--json`` prints of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from rich.console import Console

from eai.abilities.record import Record
from eai.abilities.verdict import Json
from eai.results.coverage import Coverage, ErrataEffect, planners_of
from eai.results.rate import Rate
from eai.results.table import Column, Estimate, NamedCells, Table
from eai.results.terminal import print_table

_SHORT = {"precision": "P", "recall": "R", "f1": "F1", "planner_success": "planner"}
PERCENT = Column("percent", digits=1, number=True)
"""A column of rates in percent."""


@dataclass(frozen=True, slots=True)
class Result:
    """One model in a table: its rates, and how much of the suite they are of."""

    rates: Mapping[str, Rate]
    coverage: Coverage


def print_rates(
    console: Console,
    title: str,
    metrics: Sequence[str],
    results: Mapping[str, Result],
    *,
    wide: bool = False,
) -> None:
    """Print rates in percent with one decimal: of one model a row a metric, of several a row a model.

    Args:
        console: where to.
        title: what the rates are of.
        metrics: which.
        results: model -> its rates.
        wide: several models in one table, however wide.
    """
    if len(results) == 1:
        (model, result), *_ = results.items()
        whole = f"{title}: {model}, {result.coverage} answered"
        rates = [result.rates[metric] for metric in metrics]
        table = Table.of_columns(
            whole,
            [
                ("", [metric.replace("_", " ").replace(".", ", ") for metric in metrics]),
                (PERCENT, [Estimate.of_rate(rate) for rate in rates]),
                (Column("of", number=True), [f"{r.numerator:g} / {r.denominator:g}" for r in rates]),
            ],
        )
        print_table(console, table)
        return
    found = results.values()
    shown = [metric for metric in metrics if any(result.rates[metric].denominator for result in found)]
    columns: list[NamedCells] = [
        ("percent", list(results)),
        (Column("answered", number=True), [str(result.coverage) for result in found]),
        *(
            (replace(PERCENT, heading=heading(metric)), [Estimate.of_rate(r.rates[metric]) for r in found])
            for metric in shown
        ),
    ]
    print_table(console, Table.of_columns(title, columns), wide=wide)


def result_json(
    records: Sequence[Record], result: Result, errata: ErrataEffect | None, folder: Path | None
) -> dict[str, Json]:
    """The ``--json`` of one model in one suite.

    Args:
        records: all of its records.
        result: their rates.
        errata: what errata did to these.
        folder: where they were written to; None if nowhere.
    """
    first, planners = records[0], planners_of(record.verdict for record in records)
    return {
        "model": first.model,
        "domain": first.domain,
        "ability": first.ability.value,
        "protocol": first.protocol.value,
        "folder": None if folder is None else str(folder),
        "coverage": result.coverage.to_json(),
        "errata": None if errata is None else errata.to_json(),
        **({"planner": ", ".join(planners)} if planners else {}),
        "metrics": {name: rate.to_json() for name, rate in result.rates.items()},
    }


def heading(metric: str) -> str:
    """A metric's name in short lines."""
    *groups, measure = metric.split(".")
    words = [word for group in groups for word in group.split("_")]
    last = [_SHORT[measure]] if measure in _SHORT else measure.split("_")
    return "\n".join([*words, *last])
