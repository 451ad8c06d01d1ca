"""Rates on a terminal, and what ``--json`` prints of them."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from rich.console import Console

from eai.abilities.declaration import declaration_of
from eai.abilities.experiment import Experiment
from eai.abilities.protocol import Ability, Protocol
from eai.abilities.record import Record
from eai.abilities.verdict import Json
from eai.benchmark.registry import title_of
from eai.cli.console import note, output, say
from eai.results.coverage import Coverage, ErrataEffect, coverage_of, errata_effect, planners_of
from eai.results.rate import Rate
from eai.results.summary import summarise
from eai.results.table import Column, Estimate, NamedCells, Table
from eai.results.terminal import print_table

_SHORT = {"precision": "P", "recall": "R", "f1": "F1", "planner_success": "planner"}
_GROUPED = re.compile(r"\.(?=\D)")
"""The point between a group and a measure, which is none in a number such as 1.5."""

PERCENT = Column("percent", digits=1, number=True)
"""A column of rates in percent."""


@dataclass(frozen=True, slots=True)
class Result:
    """One model in a table.

    Attributes:
        rates: its rates.
        coverage: how much of the suite they are of.
        errata: what errata did to them.
        agent: its harness and effort, as far as they are known.
    """

    rates: Mapping[str, Rate]
    coverage: Coverage
    errata: ErrataEffect | None = None
    agent: tuple[str, ...] = ()

    @classmethod
    def of(cls, records: Sequence[Record]) -> Result:
        """The result of all records of one model and suite."""
        return cls.of_rates(summarise([record.verdict for record in records], records[0].ability), records)

    @classmethod
    def of_rates(cls, rates: Mapping[str, Rate], records: Sequence[Record]) -> Result:
        """The same where the rates are known."""
        experiment = records[0].experiment or Experiment()
        agent = tuple(filter(None, (experiment.harness, experiment.effort)))
        return cls(rates, coverage_of(records), errata_effect(records), agent)


def suite_title(domain: str, ability: Ability, protocol: Protocol) -> str:
    """The name of a suite above its results."""
    return f"{title_of(domain)}, {declaration_of(ability).title.lower()}, protocol {protocol.value}"


def _named(model: str, result: Result) -> str:
    """A model with its harness and effort."""
    return ", ".join([model, *result.agent])


def print_results(title: str, ability: Ability, results: Mapping[str, Result], *, wide: bool) -> None:
    """Print the rates of models, and what is remarkable about their coverage and errata, alike ones once."""
    print_rates(output(), title, declaration_of(ability).terminal, results, wide=wide)
    alike: dict[Coverage, list[str]] = {}
    for model, result in results.items():
        alike.setdefault(result.coverage, []).append(model)
    for coverage, models in alike.items():
        print_remark(", ".join(models), coverage)
    for remark in dict.fromkeys(each.errata.remark for each in results.values() if each.errata is not None):
        if remark is not None:
            say(remark)


def print_remark(name: str, coverage: Coverage) -> None:
    """Say on standard error what is remarkable about how much of a suite is answered."""
    if coverage.remark is not None:
        note(f"{name}: {coverage.remark}")


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
    found = results.values()
    shown = [metric for metric in metrics if any(result.rates[metric].denominator for result in found)]
    if len(results) == 1:
        (model, result), *_ = results.items()
        whole = f"{title}: {_named(model, result)}, {result.coverage} answered"
        rates = [result.rates[metric] for metric in shown]
        table = Table.of_columns(
            whole,
            [
                ("", [", ".join(_GROUPED.split(metric)).replace("_", " ") for metric in shown]),
                (PERCENT, [Estimate.of_rate(rate) for rate in rates]),
                (Column("of", number=True), [f"{r.numerator:g} / {r.denominator:g}" for r in rates]),
            ],
        )
        print_table(console, table)
        return
    columns: list[NamedCells] = [
        ("percent", [_named(*each) for each in results.items()]),
        (Column("answered", number=True), [str(result.coverage) for result in found]),
        *(
            (replace(PERCENT, heading=heading(metric)), [Estimate.of_rate(r.rates[metric]) for r in found])
            for metric in shown
        ),
    ]
    print_table(console, Table.of_columns(title, columns), wide=wide)


def result_json(records: Sequence[Record], result: Result, folder: Path | None) -> dict[str, Json]:
    """The ``--json`` of one model in one suite.

    Args:
        records: all of its records.
        result: their result.
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
        "errata": None if result.errata is None else result.errata.to_json(),
        **({"planner": ", ".join(planners)} if planners else {}),
        "metrics": {name: rate.to_json() for name, rate in result.rates.items()},
    }


def heading(metric: str) -> str:
    """A metric's name in short lines."""
    *groups, measure = _GROUPED.split(metric)
    words = [word for group in groups for word in group.split("_")]
    last = [_SHORT[measure]] if measure in _SHORT else measure.split("_")
    return "\n".join([*words, *last])
