"""Costs of answers."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from pydantic import ValidationError

from eai.abilities.attempt import AnswerUsage
from eai.base.errors import InputError
from eai.results.cost import (
    PriceList,
    Spending,
    _CostReportedInBenchmarkPaper,
    _TokenPrice,
    group_costs_and_successes_by_cost_unit,
    read_benchmark_paper_cost,
    sum_spending,
)
from eai.results.record import AnswerOrigin, Record
from results.verdicts import SUCCEEDED, record

PRICES = """\
date = 2026-11-01
source = "a page"

[models."of/one"]
input = 2
output = 10.5
"""


def answer(usage: AnswerUsage | None) -> Record:
    return replace(record("1_1", SUCCEEDED), origin=AnswerOrigin(usage=usage))


def test_spending_counts_only_answers_with_known_tokens() -> None:
    records = [
        answer(AnswerUsage(100, 10, 4, 0.5)),
        answer(AnswerUsage(200, 20)),
        answer(None),
        replace(answer(None), origin=None),
    ]
    assert sum_spending(records) == Spending(2, AnswerUsage(300, 30, 4, 0.5), AnswerUsage(200, 20), 1)
    assert sum_spending(records).tokens == 330
    assert sum_spending(records[2:]) == Spending()


def test_unknown_numbers_of_tokens_are_not_zero() -> None:
    assert AnswerUsage().tokens is None
    assert AnswerUsage(seconds=2.0) + AnswerUsage() == AnswerUsage(None, None, seconds=2.0)
    found = sum_spending([answer(AnswerUsage()), answer(AnswerUsage(100, 10))])
    assert (found.answers, found.tokens) == (1, 110)
    assert sum_spending([answer(AnswerUsage())]).tokens is None
    assert group_costs_and_successes_by_cost_unit([answer(AnswerUsage()), answer(AnswerUsage(100, 10))]) == {}


def test_a_price_applies_only_to_answers_without_one() -> None:
    found = sum_spending([answer(AnswerUsage(100, 10, cost=0.5)), answer(AnswerUsage(1_000_000, 2_000_000))])
    assert found.apply_price(_TokenPrice(input=3, output=10)) == Spending(
        2, AnswerUsage(1_000_100, 2_000_010, cost=23.5)
    )
    assert found.apply_price(None) == found
    assert (found + found).unpriced_answers == 2


def test_a_price_list_needs_a_date_and_a_source(tmp_path: Path) -> None:
    file = tmp_path / "prices.toml"
    file.write_text(PRICES)
    found = PriceList.read_file(file)
    assert (str(found.date), found.source) == ("2026-11-01", "a page")
    assert found.models["of/one"].compute_dollars(AnswerUsage(500_000, 100_000)) == pytest.approx(2.05)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("date = 2026-11-01\n", "", "date: is missing"),
        ('source = "a page"\n', "", "source: is missing"),
        ("input = 2\n", "input = -2\n", "models.of/one.input: expected greater than or equal to 0, found -2"),
        ("input = 2\n", 'input = "2"\n', "models.of/one.input: expected a valid number"),
        ("output", "outptu", "models.of/one.output: is missing"),
        ("[models", "models", "expected TOML"),
    ],
)
def test_an_invalid_price_list_is_refused_with_its_place(
    old: str, new: str, told: str, tmp_path: Path
) -> None:
    file = tmp_path / "prices.toml"
    file.write_text(PRICES.replace(old, new))
    with pytest.raises(InputError, match=r"prices\.toml") as refused:
        PriceList.read_file(file)
    assert told in str(refused.value)


def test_the_papers_costs_are_read_as_printed() -> None:
    figures = read_benchmark_paper_cost()
    assert (figures.runs, figures.tokens, figures.queries) == (180, 192_280_000, 84_960)
    assert figures.dollars == 1540.70
    with pytest.raises(ValidationError):
        _CostReportedInBenchmarkPaper.model_validate({**figures.model_dump(), "tokens": "192280000"})
