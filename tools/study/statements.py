"""The checkable statements of the paper, section by section, and their findings.

`statements.tsv` has a line for each: the section, the statement in our own words, and how it is checked. A
check has parts, with ` & ` between them:

    claim: A1                                  the finding on a claim of this page
    cell: B/AS/task_success/o1-preview/81.0    a figure of the text
    best: V/GI/overall.f1/o1-preview           the model with the highest rate
    lowest: B/SD/missing_step/o1-preview       the model with the lowest rate
    rank: B/AS/task_success/o1-mini/2          the rank of a model
    above: V/AS/task_success/Mistral Large/o1-preview
    printed: replanning/task_success/GPT-4o/65.2    a figure of the text beside the paper's own table; the
                                               metric has its ability in front if the table has several
    count: V/goals/801                         a figure of the data set
    measure: pour                              a function of a module `measures_...`
    rates, clearly, strength, step, missed, error, asked, gold, alone      see `compared`
    read: STATUS: REASON                       decided by reading the paper and the package
    skip: REASON                               not judged
"""

from __future__ import annotations

import csv
from collections.abc import Callable, Mapping
from functools import cached_property, partial
from pathlib import Path
from typing import NamedTuple

import compared
import measures_answers
import measures_data
import measures_errors
import measures_examples
import measures_mixtures
import measures_operators
import measures_questions
import measures_rates
import measures_subgoals
import measures_tables
import measures_wording
from claim import Claim, Finding, Status, by_degree
from evidence import NAMED, Evidence
from rates import (
    DIGIT,
    NEAR,
    WORLDS,
    RateColumn,
    column_of,
    first_places,
    measured_rates,
    printed_figures,
    printed_rates,
    rank_of,
    together,
)

from eai.benchmarks.registry import find_benchmark
from eai.results.data_set import compute_data_set_statistics
from eai.results.paper_tables import read_paper_table

FILE = Path(__file__).parent / "statements.tsv"
MODULES = (
    measures_rates,
    measures_answers,
    measures_errors,
    measures_operators,
    measures_data,
    measures_questions,
    measures_examples,
    measures_subgoals,
    measures_mixtures,
    measures_tables,
    measures_wording,
)


class Statement(NamedTuple):
    """A checkable statement of the paper, in our own words."""

    section: str
    text: str
    check: str


def read_statements() -> list[Statement]:
    """Return the statements in the order of the paper."""
    with FILE.open(encoding="utf-8", newline="") as file:
        rows = csv.DictReader(file, delimiter="\t", quoting=csv.QUOTE_NONE)
        return [Statement(row["section"], row["statement"], row["check"]) for row in rows]


def measure_of(name: str) -> Callable[[Evidence], Finding]:
    """Return the function that measures a statement."""
    return next(getattr(module, name) for module in MODULES if hasattr(module, name))


class Checker:
    """Checks statements.

    Args:
        evidence: the records.
        claims: the findings on claims that could be checked, by key.
        planner: whether measures that take a planner are made.
    """

    def __init__(
        self, evidence: Evidence, claims: Mapping[str, tuple[Claim, Finding]], *, planner: bool
    ) -> None:
        self._evidence = evidence
        self._claims = claims
        self._planner = planner
        self._known: dict[str, Finding] = {}

    def find(self, check: str) -> Finding:
        """Return the finding on all parts of a check."""
        parts = [self._part(part) for part in check.split(" & ")]
        judged = [finding for finding in parts if finding.status is not Status.NOT_JUDGED]
        return together(judged or parts)

    def _part(self, part: str) -> Finding:
        if part not in self._known:
            kind, _, rest = part.partition(": ")
            self._known[part] = self._parts[kind](rest)
        return self._known[part]

    @cached_property
    def _parts(self) -> Mapping[str, Callable[[str], Finding]]:
        return {
            **{kind: self._compared(kind) for kind in compared.KINDS},
            "claim": self._claim,
            "cell": self._cell,
            "best": self._best,
            "lowest": lambda text: self._best(text, lowest=True),
            "rank": self._rank,
            "above": self._above,
            "printed": self._printed,
            "count": self._count,
            "measure": self._measure,
            "read": _read,
            "skip": lambda text: Finding(Status.NOT_JUDGED, text),
        }

    def _claim(self, key: str) -> Finding:
        if key not in self._claims:
            return Finding(Status.NOT_JUDGED, f"{key} is left out here")
        claim, finding = self._claims[key]
        return Finding(finding.status, f"[{key}](#{claim.anchor})")

    def _measure(self, name: str) -> Finding:
        if name in PLANNED and not self._planner:
            return WITHOUT_PLANNER
        return measure_of(name)(self._evidence)

    def _compared(self, kind: str) -> Callable[[str], Finding]:
        if kind == "alone" and not self._planner:
            return lambda text: WITHOUT_PLANNER
        return partial(compared.KINDS[kind], self._evidence)

    def _cell(self, text: str) -> Finding:
        *place, model, figure = text.split("/")
        column, said = column_of(place), float(figure)
        printed = printed_figures(column, model)
        ours = self._ours(column).get(model)
        in_table = any(abs(each - said) <= DIGIT for each in printed)
        comes_out = ours is None or abs(ours - said) <= NEAR + DIGIT
        shown = " or ".join(f"{each:.1f}" for each in printed) or "none"
        measured = "" if ours is None else f", public answers {ours:.1f}"
        return Finding(
            by_degree(in_table and comes_out, in_table or (ours is not None and comes_out)),
            f"{model}: table {shown}{measured}",
        )

    def _best(self, text: str, *, lowest: bool = False) -> Finding:
        *place, model = text.split("/")
        column = column_of(place)
        sides = [
            (name, rates)
            for name, rates in (("table", printed_rates(column)), ("public answers", self._ours(column)))
            if rates
        ]
        right = [model in first_places(rates, lowest=lowest) for _, rates in sides]
        shown = "; ".join(
            f"{name}: {' and '.join(first)} {rates[first[0]]:.1f}"
            for name, rates in sides
            for first in [first_places(rates, lowest=lowest)]
        )
        return Finding(
            by_degree(all(right), any(right)),
            f"{_name(column)}, {'lowest' if lowest else 'highest'} in {shown}",
        )

    def _rank(self, text: str) -> Finding:
        *place, model, number = text.split("/")
        column = column_of(place)
        sides = [("the table", printed_rates(column)), ("public answers", self._ours(column))]
        ranks = [(name, rank_of(rates, model)) for name, rates in sides if model in rates]
        right = [rank == int(number) for _, rank in ranks]
        shown = " and ".join(f"{rank} by {name}" for name, rank in ranks)
        return Finding(by_degree(all(right), any(right)), f"{_name(column)}: {model} is number {shown}")

    def _above(self, text: str) -> Finding:
        *place, first, second = text.split("/")
        column = column_of(place)
        sides = [("table", printed_rates(column)), ("public answers", self._ours(column))]
        known = [(name, rates) for name, rates in sides if first in rates and second in rates]
        right = [rates[first] > rates[second] for _, rates in known]
        shown = "; ".join(f"{name} {rates[first]:.1f} and {rates[second]:.1f}" for name, rates in known)
        return Finding(by_degree(all(right), any(right)), f"{first} and {second}: {shown}")

    def _printed(self, text: str) -> Finding:
        name, metric, *words, said = text.split("/")
        row = "/".join(words)
        figures = read_paper_table(name).rows[row]
        (figure,) = [
            value
            for column, value in figures.items()
            if metric in (column.metric, f"{column.ability}.{column.metric}")
        ]
        same = figure is not None and abs(figure - float(said)) <= DIGIT
        return Finding(by_degree(same, False), f"{row}: the table has {figure}")

    def _count(self, text: str) -> Finding:
        world, label, said = text.split("/")
        table = compute_data_set_statistics(find_benchmark(WORLDS[world]), self._evidence.published)
        value = next(figure.value for figure in table if figure.label == label)
        same = round(value, len(said.partition(".")[2])) == float(said)
        return Finding(by_degree(same, False), f"{label}: {value:,}")

    def _ours(self, column: RateColumn) -> Mapping[str, float]:
        return measured_rates(self._evidence, column)


PLANNED = (
    "mixtures",
    "mixture_of_three",
    "place_inside",
    "overall_rates",
    "spatial_operators",
    "complexity_of_operators",
    "rest_non_spatial",
    "rest_orientation",
    "rest_affordance",
    "slice_alone",
    "mixtures_by_model",
    "consistency_of_o1",
    "errors_and_plans",
    "most_perfect",
    "variation_of_operators",
)
"""The measures that take a planner, for minutes."""


WITHOUT_PLANNER = Finding(Status.NOT_JUDGED, "needs a planner, which was left out")


def _read(text: str) -> Finding:
    status, _, reason = text.partition(": ")
    return Finding(Status(status), reason)


def _name(column: RateColumn) -> str:
    metric = column.metric.replace("_", " ").replace(".", " ")
    world, ability = NAMED[column.domain], column.ability.replace("_", " ")
    return ", ".join(word for word in (world, ability, metric) if word)
