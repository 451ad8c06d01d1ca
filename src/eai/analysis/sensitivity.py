"""Sensitivity analysis (paper, "Sensitivity analysis" of transition modeling): which operator breaks plans?

In each task one operator at a time is the answer's, the others are the gold ones; a planner says whether
the problem can still be solved. Counted are the successes by operator, and by operator and category of the
task, out of all tasks that ask for it: an operator that the answer does not have is no success.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from eai.abilities.transition_modeling.scorer import TransitionModeling
from eai.abilities.transition_modeling.task import Category
from eai.abilities.verdict import Json
from eai.metrics.rate import Rate
from eai.pddl.planning import PlannerOutcome

OVERALL = "overall"
"""The row over all tasks."""


@dataclass(frozen=True, slots=True)
class OperatorOutcome:
    """What came of one operator of one answer among gold operators; None if the answer does not have it."""

    task_id: str
    operator: str
    categories: tuple[Category, ...]
    outcome: PlannerOutcome | None


@dataclass(frozen=True, slots=True)
class Sensitivity:
    """Success rates of single operators.

    Attributes:
        operators: in the order of the data set; those that occur. rates: row (`OVERALL`, then the
        categories that occur) -> operator -> rate. A task counts in each of its
            categories.
    """

    operators: tuple[str, ...]
    rates: Mapping[str, Mapping[str, Rate]]

    def to_json(self) -> dict[str, Json]:
        """The rates, by row and operator."""
        return {
            row: {operator: rate.to_json() for operator, rate in rates.items()}
            for row, rates in self.rates.items()
        }

    def to_markdown(self) -> str:
        """A table with an operator a line, each cell as percent (successes/attempts)."""
        rows = tuple(self.rates)
        lines = [f"| operator | {' | '.join(rows)} |", "|---" * (len(rows) + 1) + "|"]
        for operator in self.operators:
            cells = (_cell(self.rates[row].get(operator)) for row in rows)
            lines.append(f"| {operator} | {' | '.join(cells)} |")
        return "\n".join(lines) + "\n"


def try_operators(scorer: TransitionModeling, text: str) -> list[OperatorOutcome]:
    """What comes of each operator that a task asks for, as an answer to it has them."""
    task = scorer.task
    return [
        OperatorOutcome(task.id, name, task.categories, None if result is None else result.outcome)
        for name, result in scorer.plan_one_at_a_time(text).items()
    ]


def summarise(outcomes: Iterable[OperatorOutcome], order: Sequence[str]) -> Sensitivity:
    """The success rates.

    Args:
        outcomes: from `try_operators`, of any number of answers.
        order: all operators of the domain, in the order to keep.
    """
    counts: dict[str, dict[str, list[bool]]] = {}
    for each in outcomes:
        for row in (OVERALL, *(category.value for category in each.categories)):
            solved = each.outcome is PlannerOutcome.SOLVED
            counts.setdefault(row, {}).setdefault(each.operator, []).append(solved)
    rows = [row for row in (OVERALL, *(category.value for category in Category)) if row in counts]
    found = counts.get(OVERALL, {})
    return Sensitivity(
        operators=tuple(operator for operator in order if operator in found),
        rates={
            row: {
                operator: Rate(sum(counts[row][operator]), len(counts[row][operator]))
                for operator in order
                if operator in counts[row]
            }
            for row in rows
        },
    )


def _cell(rate: Rate | None) -> str:
    if rate is None or rate.percent is None:
        return ""
    return f"{rate.percent:.1f} ({rate.numerator:g}/{rate.denominator:g})"
