"""Public tasks beside generated ones of the same world: what success owes to answers that are known."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from eai.abilities.record import Record
from eai.abilities.share import of_all
from eai.abilities.verdict import PlanVerdict
from eai.results.certainty import Case
from eai.results.matched import Placed, matched_difference
from eai.results.table import Cell, Estimate, Table

STEPS = (4, 8, 12, 20)
"""Strata of plan lengths: up to so many steps of the data set's or the certificate's plan, or more."""

GOALS = (1, 2, 4, 8)
"""Strata of numbers of goals, likewise."""

REMARKS = (
    "A difference below zero says that fresh tasks are harder than public ones with plans of equal length, "
    "as many goals and goals of the same kinds. Known answers are one reason. Others are what is not "
    "matched: how goals are put together, how scenes look, how instructions are worded.",
    "A model that knows no answers (eai/planner, or one trained before the tasks were published) shows how "
    "much of the difference is of that kind; compare it with that.",
    "A difference of zero is no proof that nothing is known: memory may not help.",
)


class Pair(NamedTuple):
    """A model's answers to public tasks and to fresh ones.

    Attributes:
        model: who answered.
        suite: what both are of, in words.
        public: the records of the public tasks.
        fresh: those of the fresh ones.
    """

    model: str
    suite: str
    public: Sequence[Record]
    fresh: Sequence[Record]


def contamination_table(pairs: Sequence[Pair]) -> Table:
    """A row for each model: its success on either, and the difference where the tasks are alike."""
    return Table(
        "contamination",
        "Public and fresh tasks",
        "Success in percent of all public and of all fresh tasks; then of those alone that are alike in "
        "the length of the known plan, the number of goals and their kinds, the fresh ones weighted to the "
        "public ones; and fresh minus public in percentage points, with 95 % intervals whose units are the "
        "names of public tasks and the single fresh tasks.",
        (
            "answers_of",
            "fresh_suite",
            "public",
            "fresh",
            "public_alike",
            "fresh_alike",
            "difference",
            "public_tasks",
            "fresh_tasks",
        ),
        tuple(_rows(pairs)),
    )


def _rows(pairs: Sequence[Pair]) -> Iterator[tuple[Cell, ...]]:
    for model, suite, public, fresh in pairs:
        placed = [list(_placed(records)) for records in (public, fresh)]
        rates = [Estimate.of([case for case, _ in each]) for each in placed]
        found = matched_difference(*placed)
        if found is None:
            yield (model, suite, *rates, None, None, Estimate(None), 0, 0)
        else:
            difference = Estimate(found.difference, *found.certainty.interval)
            yield (model, suite, *rates, found.first, found.second, difference, *found.tasks)


def _placed(records: Sequence[Record]) -> Iterator[Placed]:
    """What each task contributes, and its stratum; tasks that are in no statistics are left out."""
    for record in records:
        verdict, task = record.verdict, record.task
        if isinstance(verdict, PlanVerdict) and verdict.excluded is None and task is not None:
            kinds = () if verdict.goals is None else tuple([tally.total > 0 for tally in verdict.goals])
            steps = None if task.annotated_steps is None else _bin(task.annotated_steps, STEPS)
            case = Case(record.task_id, task.name, of_all(verdict.success))
            yield Placed(case, (steps, _bin(task.goals, GOALS), kinds))


def _bin(number: int, bounds: Sequence[int]) -> int:
    return sum([number > bound for bound in bounds])
