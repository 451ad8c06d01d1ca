"""The cost of answers: tokens and dollars of runs, and what the paper's cost."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from datetime import date
from functools import cache
from importlib import resources

from pydantic import ConfigDict, Field

from eai.abilities.attempt import Usage
from eai.abilities.declaration import AnswerOutcome
from eai.base.files import parse_toml
from eai.base.grouping import group_pairs
from eai.base.json_value import Json
from eai.results.certainty import Case, Cases, interval_of_ratio
from eai.results.rate import rate_of
from eai.results.record import Record
from eai.results.summary import name_of, outcome_of
from eai.tasks.options import Options
from eai.tasks.share import Share

_MILLION = 1_000_000


@dataclass(frozen=True, slots=True)
class Spending:
    """The cost of the answers of runs.

    Attributes:
        answers: those of which the tokens are known.
        usage: all their tokens, and the dollars of those that were priced when they were asked for.
        unpriced: the tokens of the others.
        unpriced_answers: how many they are.
    """

    answers: int = 0
    usage: Usage = field(default_factory=Usage)
    unpriced: Usage = field(default_factory=Usage)
    unpriced_answers: int = 0

    @property
    def tokens(self) -> int | None:
        """Tokens of questions and answers; None if no answer's are known."""
        return self.usage.tokens

    def __add__(self, other: Spending) -> Spending:
        """Both together."""
        return Spending(
            self.answers + other.answers,
            self.usage + other.usage,
            self.unpriced + other.unpriced,
            self.unpriced_answers + other.unpriced_answers,
        )

    def apply_price(self, price: _Price | None) -> Spending:
        """The same with a price for what has none."""
        if price is None or not self.unpriced_answers:
            return self
        dollars = price.compute_dollars(self.unpriced)
        return Spending(self.answers, self.usage + Usage(cost=dollars))


class _Price(Options):
    """The prices of a model, in dollars for a million tokens; cached ones cost what others do."""

    model_config = ConfigDict(strict=True)

    input: float = Field(ge=0)
    output: float = Field(ge=0)

    def compute_dollars(self, usage: Usage) -> float:
        """The dollars of some tokens."""
        return (self.input * (usage.input_tokens or 0) + self.output * (usage.output_tokens or 0)) / _MILLION


class PriceList(Options):
    """Prices of models, of one day and from one place: without them nobody could check the dollars.

    In a file they are ``date``, ``source``, and ``input`` and ``output`` for each of ``models``.
    """

    model_config = ConfigDict(strict=True)

    date: date
    source: str = Field(min_length=1)
    models: Mapping[str, _Price]


class _PaperCost(Options):
    """The cost of one run of all the paper's models."""

    model_config = ConfigDict(strict=True)

    runs: int
    tokens: int
    queries: int
    dollars: float


def sum_spending(records: Iterable[Record]) -> Spending:
    """The cost of answers, as far as their records say; attempts, votes and repairs are part of an answer."""
    usages = [record.origin.usage for record in records if record.origin and record.origin.usage]
    usages = [usage for usage in usages if usage.tokens is not None]
    unpriced = [usage for usage in usages if usage.cost is None]
    return Spending(len(usages), sum(usages, Usage()), sum(unpriced, Usage()), len(unpriced))


def cost_cases(records: Iterable[Record]) -> dict[str, Cases]:
    """The cost of each answer in ``tokens``, ``dollars`` and ``seconds``, and whether it is a success.

    Answers that failed cost, too. What is not known of every answer with a usage is left out.
    """
    counted = (record for record in records if record.verdict.excluded is None)
    answers = [(each, each.origin.usage) for each in counted if each.origin and each.origin.usage]
    found = group_pairs(pair for record, usage in answers for pair in _amounts(record, usage))
    return {name: cases for name, cases in found.items() if len(cases) == len(answers)}


def _amounts(record: Record, usage: Usage) -> Iterator[tuple[str, Case]]:
    won = outcome_of(record) is AnswerOutcome.SUCCESS
    for name, amount in (("tokens", usage.tokens), ("dollars", usage.cost), ("seconds", usage.seconds)):
        if amount is not None:
            yield name, Case(record.task_id, name_of(record), Share(amount, won))


def cost_cases_to_json(found: Mapping[str, Cases]) -> dict[str, Json]:
    """The same as sums, and their ratio with its interval, as in ``summary.json``; null without a success."""
    written: dict[str, Json] = {}
    for name, cases in found.items():
        rate, interval = rate_of(case.share for case in cases), interval_of_ratio(cases)
        between = None if interval is None else list(interval)
        written[name] = {**rate.to_json(), "value": rate.share, "interval": between}
    return written


@cache
def read_paper_cost() -> _PaperCost:
    """The paper's own figures."""
    file = resources.files("eai.results") / "paper" / "evaluation_cost.toml"
    return _PaperCost.model_validate(parse_toml(file.read_text(encoding="utf-8")))


def divide_amount(amount: float | None, of: int) -> float | None:
    """An amount for each of so many; None if there are none, or the amount is not known."""
    return None if amount is None or not of else amount / of
