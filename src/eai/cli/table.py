"""Tables on a terminal: a row a model, as many columns side by side as fit, and no number is ever cut."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from rich import box
from rich.console import Console
from rich.measure import Measurement
from rich.table import Table
from rich.text import Text

from eai.abilities.record import Record
from eai.abilities.verdict import Json
from eai.cli.console import SafeConsole
from eai.results.coverage import Coverage, planners_of
from eai.results.errata_effect import ErrataEffect
from eai.results.rate import Rate

_SHORT = {"precision": "P", "recall": "R", "f1": "F1", "planner_success": "planner"}
_NAMES = 0.4
"""The share of the width that names may take before they are folded."""


@dataclass(frozen=True, slots=True)
class Column:
    """One column.

    Attributes:
        heading: its lines.
        cells: one a row.
    """

    heading: str
    cells: Sequence[str | Text]


@dataclass(frozen=True, slots=True)
class Result:
    """What a table shows of one model: its rates, and how much of the suite they are of."""

    rates: Mapping[str, Rate]
    coverage: Coverage


def print_table(
    console: Console, title: str, names: Sequence[Column], columns: Sequence[Column], *, wide: bool = False
) -> None:
    """Print rows of numbers; what does not fit beside the names follows below, with the names again.

    Args:
        console: where to.
        title: above it all.
        names: what stands on the left of every part; the last are names, which are folded if they are long.
        columns: numbers.
        wide: all in one table, however wide.
    """
    console.print(Text(title, style="bold"), soft_wrap=True)
    limit = None if wide else int(console.width * _NAMES)
    for part in [columns] if wide else _parts(console, names, columns, limit):
        table = _table(names, part, limit)
        room = max(console.width, _width(console, table)) if wide else console.width
        SafeConsole(file=console.file, width=room, markup=False).print(table, "")


def _parts(
    console: Console, names: Sequence[Column], columns: Sequence[Column], limit: int | None
) -> Iterator[Sequence[Column]]:
    """The columns in groups that fit beside the names, each with one column at least."""
    part: list[Column] = []
    beside = taken = _width(console, _table(names, [], limit))
    for column in columns:
        width = _width(console, _table(names, [column], limit)) - beside
        if part and taken + width > console.width:
            yield part
            part, taken = [], beside
        part.append(column)
        taken += width
    if part:
        yield part


def _width(console: Console, table: Table) -> int:
    """How many characters a table takes where it has room."""
    return Measurement.get(console, console.options.update(max_width=10_000), table).maximum


def _table(names: Sequence[Column], columns: Sequence[Column], limit: int | None) -> Table:
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, show_edge=False, collapse_padding=True)
    for column in names[:-1]:
        table.add_column(column.heading, justify="right", no_wrap=True)
    table.add_column(names[-1].heading, overflow="fold", max_width=limit)
    for column in columns:
        table.add_column(Text(column.heading), justify="right", no_wrap=True)
    for row in zip(*(column.cells for column in (*names, *columns)), strict=True):
        table.add_row(*row)
    return table


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
        names = Column("", [metric.replace("_", " ").replace(".", ", ") for metric in metrics])
        counts = Column("of", [f"{rate.numerator:g} / {rate.denominator:g}" for rate in rates])
        numbers = Column("percent", [percent(rate) for rate in rates])
        print_table(console, whole, [names], [numbers, counts])
        return
    names = Column("percent", list(results))
    answered = Column("answered", [str(result.coverage) for result in results.values()])
    columns = [
        Column(heading(metric), [percent(result.rates[metric]) for result in results.values()])
        for metric in metrics
        if any(result.rates[metric].denominator for result in results.values())
    ]
    print_table(console, title, [names], [answered, *columns], wide=wide)


def result_json(
    records: Sequence[Record], result: Result, errata: ErrataEffect | None, folder: Path | None
) -> dict[str, Json]:
    """What ``--json`` prints of one model in one suite.

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


def percent(rate: Rate) -> str:
    """A rate with one decimal; a hyphen where there is nothing to take a share of."""
    return "-" if rate.percent is None else f"{rate.percent:.1f}"
