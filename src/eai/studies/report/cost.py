"""Report the cost of answers, as a section of the report and as CSV, beside the cost in the paper."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TypeAlias

from eai.abilities.protocol import Ability
from eai.base.files import to_file_name
from eai.results.certainty import TaskRateContributions, compute_interval_of_cost_per_success
from eai.results.cost import PriceList, Spending, divide_amount, read_benchmark_paper_cost
from eai.results.markdown import escape_markdown, format_markdown_table, format_text_grid
from eai.results.rate import compute_rate
from eai.results.table import Cell, Estimate, Plain, Row, TextCell, collect_rows_in_table
from eai.results.table_files import format_rows_as_csv
from eai.studies.report.run_summary import RunSummary
from eai.studies.report.table_specs import format_suite_title

_DEFINITION = """\
Tokens are those that providers counted: of questions, cached ones included, and of answers with their
reasoning. An answer that was asked for several times (attempts, votes, repairs) has the tokens of all times,
and one that is scored under several protocols is paid for once. {priced}"""
_AS_RUN = "Dollars are those that `eai run` with `model.prices` wrote when it asked"
_BY_LIST = (
    "; where it wrote none, they follow from the prices of {date} by {source}, cached tokens at the full one"
)
_AT_LEAST = ". Before a sum of answers some of which have no price stands ≥."
_KINDS = ("tokens", "dollars", "seconds")
_PAPER = """\
The paper's figures are of one run of all its models, at the prices of its day: {runs} runs, which are not 18
models in 8 suites (144), with {queries:,} queries. It does not say which tokens are counted, nor how many
each model took, so that only what a query costs can be set beside other runs, and only roughly."""


_CostKey: TypeAlias = "tuple[str, str, Ability | None]"
"""Model, domain and ability of a row in the table of costs. A total has an empty domain and no ability."""


def _make_csv_row(key: _CostKey, spent: Spending) -> dict[str, Plain]:
    """Return a row of ``cost.csv``, as values by column."""
    (model, domain, ability), usage, answers = key, spent.usage, spent.answers
    return {
        "model": model,
        "domain": domain or None,
        "ability": None if ability is None else ability.value,
        "answers": answers,
        "input_tokens": usage.input_tokens,
        "output_tokens": usage.output_tokens,
        "reasoning_tokens": usage.reasoning_tokens,
        "tokens": spent.tokens,
        "tokens_per_answer": divide_amount(spent.tokens, answers),
        "dollars": usage.cost,
        "dollars_per_1000_answers": divide_amount(_multiply_by_thousand(usage.cost), answers),
        "answers_without_price": spent.unpriced_answers,
    }


def _make_report_row(key: _CostKey, spent: Spending) -> dict[str, str]:
    """Return a row of the report's cost table: for each column heading, the text of the cell."""
    (model, domain, ability), usage, answers = key, spent.usage, spent.answers
    bound = "≥ " if spent.unpriced_answers else ""
    return {
        "model": escape_markdown(model),
        "suite": format_suite_title(domain, ability) if ability else "",
        "answers": _format_amount(answers),
        "tokens in": _format_amount(usage.input_tokens),
        "out": _format_amount(usage.output_tokens),
        "of them reasoning": _format_amount(usage.reasoning_tokens),
        "an answer": _format_amount(divide_amount(spent.tokens, answers)),
        "dollars": _format_amount(usage.cost, 2, bound),
        "per 1,000 answers": _format_amount(
            divide_amount(_multiply_by_thousand(usage.cost), answers), 2, bound
        ),
    }


def write_cost_section(
    runs: Sequence[RunSummary], prices: PriceList | None, *, with_paper_cost: bool
) -> Iterator[str]:
    """Yield the section on cost, or no section if no run has stored token counts.

    Args:
        runs: all runs, including runs with study options.
        prices: prices of tokens, for answers without a recorded cost.
        with_paper_cost: whether the paper's cost is added below the table.
    """
    lines = [_make_report_row(key, spent) for key, spent in _sum_cost_by_run(runs, prices).items()]
    if not lines:
        return
    yield "## What the answers cost\n"
    listed = (
        "" if prices is None else _BY_LIST.format(date=prices.date, source=escape_markdown(prices.source))
    )
    yield _DEFINITION.format(priced=_AS_RUN + listed + _AT_LEAST) + "\n"
    rows = [[*line.values()] for line in lines]
    if with_paper_cost:
        rows.append(_make_row_of_cost_in_paper())
    yield "\n".join(format_text_grid([*lines[0]], rows)) + "\n"
    table = _make_cost_per_success_table(runs)
    yield f"{table.definition}.\n"
    yield format_markdown_table(table)
    if with_paper_cost:
        paper = read_benchmark_paper_cost()
        yield _PAPER.format(runs=paper.runs, queries=paper.queries) + "\n"


def format_cost_csv(runs: Sequence[RunSummary], prices: PriceList | None) -> str | None:
    """Return the cost of all runs as CSV, without the paper's costs; None without token counts."""
    rows = [_make_csv_row(key, spent) for key, spent in _sum_cost_by_run(runs, prices).items()]
    return format_rows_as_csv(rows) if rows else None


def _sum_cost_by_run(runs: Sequence[RunSummary], prices: PriceList | None) -> dict[_CostKey, Spending]:
    """Return the cost of each run, and the total of all runs if there are several.

    A run that was scored under several protocols (sets of rules) counts once, under its first protocol.
    """
    price_of = {} if prices is None else {to_file_name(name): price for name, price in prices.models.items()}
    spending: dict[_CostKey, Spending] = {}
    for item in runs:
        if item.spent.answers:
            key = item.key.name, item.key.domain, item.key.ability
            spending.setdefault(key, item.spent.apply_price(price_of.get(to_file_name(item.key.model))))
    total = {("together", "", None): sum(spending.values(), Spending())}
    return spending | total if len(spending) > 1 else spending


@collect_rows_in_table("per_success", ("model", "suite", *_KINDS), title="")
def _make_cost_per_success_table(runs: Sequence[RunSummary]) -> Iterator[Row]:
    """The cost of a success.

    The cost of all answers, also of failures, is divided by the number of successes. Intervals count tasks
    with the same name as one unit. Without a success, the cell is ≥ and the whole cost. Seconds are those of
    waiting for replies in episodes; dollars are those that `eai run` wrote
    """
    for item in runs:
        amounts = (_estimate_spending_per_success(item.per_success.get(kind, ())) for kind in _KINDS)
        if item.per_success:
            yield (TextCell(item.key.name), format_suite_title(item.key.domain, item.key.ability), *amounts)


def _estimate_spending_per_success(cases: TaskRateContributions) -> Cell:
    """Return the amount spent per success; without a success, the whole amount as a lower bound."""
    if not cases:
        return None
    rate, interval = compute_rate(case.share for case in cases), compute_interval_of_cost_per_success(cases)
    return f"≥ {rate.numerator:,.4g}" if rate.share is None else Estimate(rate.share, *(interval or ()))


def _make_row_of_cost_in_paper() -> list[str]:
    paper = read_benchmark_paper_cost()
    per_query = _format_amount(divide_amount(paper.tokens, paper.queries))
    per_thousand = _format_amount(divide_amount(_multiply_by_thousand(paper.dollars), paper.queries), 2)
    counted = [f"{paper.queries:,}", f"{paper.tokens:,} in and out", "", ""]
    return [
        "*the paper, all models*",
        "",
        *counted,
        per_query,
        _format_amount(paper.dollars, 2),
        per_thousand,
    ]


def _multiply_by_thousand(dollars: float | None) -> float | None:
    return None if dollars is None else 1000 * dollars


def _format_amount(number: float | None, digits: int = 0, prefix: str = "") -> str:
    return "" if number is None else f"{prefix}{number:,.{digits}f}"
