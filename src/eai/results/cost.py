"""The cost of answers: tokens and dollars of runs, and the costs that the paper reports."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from datetime import date
from functools import cache
from importlib import resources

from pydantic import ConfigDict, Field

from eai.abilities.attempt import AnswerUsage
from eai.abilities.declaration import AnswerOutcome
from eai.base.files import parse_toml
from eai.base.grouping import group_pairs
from eai.base.json_value import Json
from eai.results.certainty import (
    TaskRateContribution,
    TaskRateContributions,
    compute_interval_of_cost_per_success,
)
from eai.results.rate import compute_rate
from eai.results.record import Record
from eai.results.summary import find_answer_outcome, find_task_name
from eai.tasks.options import Options
from eai.tasks.share import Share

_MILLION = 1_000_000


@dataclass(frozen=True, slots=True)
class Spending:
    """Summed cost of some answers, in tokens and dollars.

    Attributes:
        answers: number of answers with a known number of tokens.
        usage: tokens of these answers, with the dollars of the answers whose price was known at the request.
        unpriced: tokens of the answers without a price.
        unpriced_answers: number of answers without a price.
    """

    answers: int = 0
    usage: AnswerUsage = field(default_factory=AnswerUsage)
    unpriced: AnswerUsage = field(default_factory=AnswerUsage)
    unpriced_answers: int = 0

    @property
    def tokens(self) -> int | None:
        """Number of tokens of questions and answers; None if unknown for all answers."""
        return self.usage.tokens

    def __add__(self, other: Spending) -> Spending:
        """Return the summed costs and counts of two groups of answers."""
        return Spending(
            self.answers + other.answers,
            self.usage + other.usage,
            self.unpriced + other.unpriced,
            self.unpriced_answers + other.unpriced_answers,
        )

    def apply_price(self, price: _TokenPrice | None) -> Spending:
        """Return the spending in dollars. Tokens of answers without a known price cost the given price."""
        if price is None or not self.unpriced_answers:
            return self
        dollars = price.compute_dollars(self.unpriced)
        return Spending(self.answers, self.usage + AnswerUsage(cost=dollars))


class _TokenPrice(Options):
    """Prices of a model in dollars for a million tokens; cached tokens cost as much as other tokens."""

    model_config = ConfigDict(strict=True)

    input: float = Field(ge=0)
    output: float = Field(ge=0)

    def compute_dollars(self, usage: AnswerUsage) -> float:
        """Return the price of some tokens in dollars."""
        return (self.input * (usage.input_tokens or 0) + self.output * (usage.output_tokens or 0)) / _MILLION


class PriceList(Options):
    """Prices of models with their date and source, so that readers can check the dollars.

    Its file has ``date``, ``source`` and ``models``; each model has the prices ``input`` and ``output``.
    """

    model_config = ConfigDict(strict=True)

    date: date
    source: str = Field(min_length=1)
    models: Mapping[str, _TokenPrice]


class _CostReportedInBenchmarkPaper(Options):
    """Cost of running all models of the paper once, as the paper reports it."""

    model_config = ConfigDict(strict=True)

    runs: int
    tokens: int
    queries: int
    dollars: float


def sum_spending(records: Iterable[Record]) -> Spending:
    """Return the sum of the costs in some records (scored answers).

    The cost of an answer includes its further attempts and requests. Answers without recorded tokens add
    nothing.
    """
    usages = [record.origin.usage for record in records if record.origin and record.origin.usage]
    usages = [usage for usage in usages if usage.tokens is not None]
    unpriced = [usage for usage in usages if usage.cost is None]
    return Spending(len(usages), sum(usages, AnswerUsage()), sum(unpriced, AnswerUsage()), len(unpriced))


def group_costs_and_successes_by_cost_unit(records: Iterable[Record]) -> dict[str, TaskRateContributions]:
    """Return the cost and the success (1, else 0) of each answer, for each unit of cost.

    Units are ``tokens``, ``dollars`` and ``seconds``. Failed answers have a cost, too. A unit is left out if
    an answer with a recorded usage has no amount in this unit.
    """
    scored = (record for record in records if record.verdict.excluded is None)
    answers = [(record, record.origin.usage) for record in scored if record.origin and record.origin.usage]
    cost_contributions_by_unit = group_pairs(
        pair for record, usage in answers for pair in _list_tokens_dollars_and_seconds(record, usage)
    )
    return {
        name: contributions
        for name, contributions in cost_contributions_by_unit.items()
        if len(contributions) == len(answers)
    }


def _list_tokens_dollars_and_seconds(
    record: Record, usage: AnswerUsage
) -> Iterator[tuple[str, TaskRateContribution]]:
    won = find_answer_outcome(record) is AnswerOutcome.SUCCESS
    for name, amount in (("tokens", usage.tokens), ("dollars", usage.cost), ("seconds", usage.seconds)):
        if amount is not None:
            yield name, TaskRateContribution(record.task_id, find_task_name(record), Share(amount, won))


def make_json_of_cost_per_success(
    contributions_by_cost_unit: Mapping[str, TaskRateContributions],
) -> dict[str, Json]:
    """Return the cost of a success in tokens, dollars and seconds, as in ``summary.json``.

    The cost is the sum of all costs divided by the number of successes, with an interval. It is null without
    success.
    """
    amounts: dict[str, Json] = {}
    for name, contributions in contributions_by_cost_unit.items():
        rate = compute_rate(contribution.share for contribution in contributions)
        interval = compute_interval_of_cost_per_success(contributions)
        between = None if interval is None else list(interval)
        amounts[name] = {**rate.to_json(), "value": rate.share, "interval": between}
    return amounts


@cache
def read_benchmark_paper_cost() -> _CostReportedInBenchmarkPaper:
    """Return the costs of the evaluation that the paper reports."""
    file = resources.files("eai.results") / "paper" / "evaluation_cost.toml"
    return _CostReportedInBenchmarkPaper.model_validate(parse_toml(file.read_text(encoding="utf-8")))


def divide_amount(amount: float | None, number: int) -> float | None:
    """Return an amount divided by a number, or None if the number is zero or the amount unknown."""
    return None if amount is None or not number else amount / number
