"""Rates of the 18 models: as the paper prints them and as the public answers give them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from statistics import fmean
from typing import NamedTuple

from claim import Finding, Status, by_degree
from evidence import AS, GI, SD, TM, B, Evidence, V

from eai.results.paper_tables import PaperColumn, read_paper_protocol_and_tables, read_paper_table
from eai.results.summary import compute_average_performance, compute_weights_of_averaged_metrics

AVERAGE = "average_performance"
WORLDS = {"V": V, "B": B}
ABILITIES = {"GI": GI, "SD": SD, "AS": AS, "TM": TM}
DIGIT = 0.051
"""Two figures with one decimal are equal if they differ by at most this."""

NEAR = 1.0
"""Points by which the public answers may differ from a figure that counts as reproduced."""


class RateColumn(NamedTuple):
    """A rate of all models: a world, an ability (empty for the average) and a metric."""

    domain: str
    ability: str
    metric: str


def column_of(words: Sequence[str]) -> RateColumn:
    """Return the column that a check names, such as V, AS, task_success."""
    domain, ability, *rest = words
    if ability == "average":
        return RateColumn(WORLDS[domain], "", AVERAGE)
    return RateColumn(WORLDS[domain], ABILITIES[ability], rest[0])


def printed_figures(column: RateColumn, model: str) -> list[float]:
    """Return the different figures that the paper's full tables print for a model."""
    place = PaperColumn(column.ability, column.metric, column.domain)
    tables = [
        read_paper_table(name)
        for name in (
            *read_paper_protocol_and_tables().names_of_tables_with_all_models,
            "transition_modeling_summary",
        )
    ]
    figures = [table.find_printed_number(model, place) for table in tables]
    return sorted({figure for figure in figures if figure is not None})


def printed_rates(column: RateColumn) -> dict[str, float]:
    """Return the paper's figure for each model, of the first table that has it."""
    place = PaperColumn(column.ability, column.metric, column.domain)
    for name in (*reversed(read_paper_protocol_and_tables().names_of_tables_with_all_models), "overview"):
        table = read_paper_table(name)
        if place in table.columns:
            figures = {model: table.find_printed_number(model, place) for model in table.rows}
            return {model: figure for model, figure in figures.items() if figure is not None}
    return {}


def measured_rates(evidence: Evidence, column: RateColumn) -> dict[str, float]:
    """Return the rate of each model's public answers, in percent."""
    if column.metric == AVERAGE:
        return _averages(evidence, column.domain)
    rates = {
        model: evidence.percent(column.domain, column.ability, column.metric, model)
        for model in evidence.names
    }
    return {model: rate for model, rate in rates.items() if rate is not None}


def _averages(evidence: Evidence, domain: str) -> dict[str, float]:
    rates = {}
    for model in evidence.names:
        values = {
            place: evidence.percent(domain, place[0].value, place[1], model)
            for place in compute_weights_of_averaged_metrics()
        }
        average = compute_average_performance(values)
        if average is not None:
            rates[model] = average
    return rates


def first_places(rates: Mapping[str, float], *, lowest: bool = False) -> list[str]:
    """Return the models with the best rate to one decimal."""
    if not rates:
        return []
    limit = (min if lowest else max)(round(rate, 1) for rate in rates.values())
    return [model for model, rate in rates.items() if round(rate, 1) == limit]


def rank_of(rates: Mapping[str, float], model: str) -> int:
    """Return the rank of a model from above, 1 for the first."""
    return 1 + sum(round(rate, 1) > round(rates[model], 1) for rate in rates.values())


def rates_of(evidence: Evidence, *words: str) -> dict[str, float]:
    """Return the measured rates of a column that is given by its words."""
    return measured_rates(evidence, column_of(words))


def mean_of(evidence: Evidence, *words: str) -> float:
    """Return the mean over models of a rate, in percent."""
    return fmean(rates_of(evidence, *words).values())


def pairs_of(evidence: Evidence, first: Sequence[str], second: Sequence[str]) -> tuple[int, int]:
    """Return for how many models the first rate is higher than the second, and the number of models."""
    left, right = rates_of(evidence, *first), rates_of(evidence, *second)
    both = left.keys() & right.keys()
    return sum(left[model] > right[model] for model in both), len(both)


def all_of(*counts: tuple[int, int], text: str) -> Finding:
    """Return reproduced if every count is full, in part if more than half of all cases are."""
    whole = all(hits == number for hits, number in counts)
    hits, number = (sum(numbers) for numbers in zip(*counts, strict=True))
    return Finding(by_degree(whole, hits > number / 2), text)


def most_of(*counts: tuple[int, int], text: str) -> Finding:
    """Return reproduced if every count is more than half full, in part if some count is."""
    most = [hits > number / 2 for hits, number in counts]
    return Finding(by_degree(all(most), any(most)), text)


def if_so(holds: bool, text: str, *, in_part: bool = False) -> Finding:
    """Return reproduced if a condition holds, else in part or not supported."""
    return Finding(by_degree(holds, in_part), text)


def together(findings: Sequence[Finding]) -> Finding:
    """Combine the findings on the parts of one statement."""
    statuses = [finding.status for finding in findings]
    same = statuses[0] if len(set(statuses)) == 1 else Status.IN_PART
    return Finding(same, "; ".join(dict.fromkeys(finding.summary.rstrip(".") for finding in findings)) + ".")


def range_over_models(evidence: Evidence, metric: str, title: str) -> Finding:
    """Ask whether the best model's rate is more than twice the worst model's, in both worlds."""
    spans = [rates_of(evidence, world, "TM", metric).values() for world in "VB"]
    text = " and ".join(f"{min(rates):.0f} to {max(rates):.0f} %" for rates in spans)
    return if_so(all(max(rates) > 2 * min(rates) for rates in spans), f"{title} of {text}")
