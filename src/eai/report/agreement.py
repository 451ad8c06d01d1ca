"""How near our numbers for the paper's models come to the paper's, cell by cell."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from eai.report.run_summary import RunSummary
from eai.results.paper_tables import PaperTable, paper_models, paper_setting, paper_table

DIGIT = 0.056
"""A difference that the printed digit hides; the paper rounds to two digits and then to one."""


@dataclass(frozen=True, slots=True)
class CellPair:
    """A figure of the paper and ours, in percent."""

    model: str
    metric: str
    printed: float
    ours: float

    @property
    def difference(self) -> float:
        """The absolute difference in percentage points."""
        return abs(self.ours - self.printed)


@dataclass(frozen=True, slots=True)
class Agreement:
    """One ability's cells of one table of the paper, for the models that were run."""

    table: str
    ability: str
    domain: str
    pairs: tuple[CellPair, ...]

    def within(self, points: float) -> int:
        """How many cells differ by no more than so many percentage points."""
        return sum(pair.difference <= points + 1e-9 for pair in self.pairs)

    @property
    def worst(self) -> CellPair:
        """The cell that differs most."""
        return max(self.pairs, key=lambda pair: pair.difference)


def agreements(runs: Sequence[RunSummary]) -> list[Agreement]:
    """The comparison of the runs under the paper's protocol that are of its models.

    A run is of such a model if it has the name of the published response file. Those that are not ranked are
    left out.
    """
    setting = paper_setting()
    ours = [
        item
        for item in runs
        if item.key.protocol.value == setting.protocol
        and item.key.model in paper_models()
        and item.coverage.ranked
    ]
    found: dict[tuple[str, str, str], list[CellPair]] = {}
    for table in map(paper_table, setting.full_tables):
        for item in ours:
            key = (table.title, item.key.ability.value, item.key.domain)
            pairs = list(_pairs(table, item))
            if pairs:
                found.setdefault(key, []).extend(pairs)
    return [Agreement(*key, tuple(pairs)) for key, pairs in found.items()]


def _pairs(table: PaperTable, item: RunSummary) -> Iterator[CellPair]:
    model = paper_models()[item.key.model]
    for column in table.columns:
        if (column.ability, column.domain) == (item.key.ability.value, item.key.domain):
            printed = table.figure(model, column)
            rate = item.rates.get(column.metric)
            if printed is not None and rate is not None and rate.percent is not None:
                yield CellPair(item.key.model, column.metric, printed, rate.percent)
