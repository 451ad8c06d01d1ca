"""Contamination: what success on public tasks owes to answers that are known, beside fresh tasks.

The two rates are on different tasks and are compared where these are alike. Tasks are put into strata of what
they are like. Those of the second set are weighted so that each stratum weighs as much as in the first
(post-stratification); strata that only one set has are left out of both.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable, Iterator, Sequence
from typing import TypeAlias

from eai.abilities.declaration import declaration_of
from eai.abilities.verdict import PlanVerdict, share_of_one
from eai.base.errors import InputError
from eai.results.certainty import Case
from eai.results.rate import rate_of
from eai.results.record import Record
from eai.results.runs import Run
from eai.results.table import Estimate, Row, make_table
from eai.studies.records import Records
from eai.studies.study import Analysis, Study
from eai.tasks.options import Options
from eai.tasks.share import Share

STEPS = (4, 8, 12, 20)
"""Strata of plan lengths: up to so many steps of the data set's or the certificate's plan, or more."""

GOALS = (1, 2, 4, 8)
"""Strata of numbers of goals, likewise."""

_REMARKS = (
    "A difference below zero says that fresh tasks are harder than public ones with plans of equal length, "
    "as many goals and goals of the same kinds. Known answers are one reason. Others are what is not "
    "matched: how goals are put together, how scenes look, how instructions are worded.",
    "A model that knows no answers (eai/planner, or one trained before the tasks were published) shows how "
    "much of the difference is of that kind; compare it with that.",
    "A difference of zero is no proof that nothing is known: memory may not help.",
)


Placed: TypeAlias = tuple[Case, Hashable]
"""The contribution of one task to a rate, and the stratum of tasks that are like it."""


def matched(first: Sequence[Placed], second: Sequence[Placed]) -> tuple[list[Case], list[Case]]:
    """The tasks of two sets in strata that both have, the second ones weighted to the strata of the first.

    No name is one of both sets. The gain from strata is not reckoned with in the interval of a difference of
    theirs, so that it is rather too wide.
    """
    sizes, others = (Counter(stratum for _, stratum in each) for each in (first, second))
    return (
        [_apart(case, "first") for case, stratum in first if stratum in others],
        [
            _apart(case, "second", sizes[stratum] / others[stratum])
            for case, stratum in second
            if sizes[stratum]
        ],
    )


def _apart(case: Case, which: str, weight: float = 1) -> Case:
    """A task that is none of the other set, with a weight."""
    share = Share(weight * case.share.numerator, weight * case.share.denominator)
    return Case(f"{which} {case.task}", f"{which} {case.name}", share)


Pair: TypeAlias = tuple[str, str, Sequence[Record], Sequence[Record]]
"""A model, its suite in words, its records of public tasks, and those of fresh ones."""


@make_table(
    "contamination",
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
)
def contamination_table(pairs: Sequence[Pair]) -> Iterator[Row]:
    """Public and fresh tasks.

    Success in percent of all public and of all fresh tasks; then of those alone that are alike in the length
    of the known plan, the number of goals and their kinds, the fresh ones weighted to the public ones; and
    fresh minus public in percentage points, with 95 % intervals whose units are the names of public tasks and
    the single fresh tasks.
    """
    for model, suite, public, fresh in pairs:
        placed = [list(_placed(records)) for records in (public, fresh)]
        rates = [Estimate.from_cases([case for case, _ in each]) for each in placed]
        ones, others = matched(*placed)
        percents = [rate_of(case.share for case in each).percent for each in (ones, others)]
        difference = Estimate.from_difference(ones, others)
        yield (model, suite, *rates, *percents, difference, len(ones), len(others))


def _placed(records: Sequence[Record]) -> Iterator[Placed]:
    """The contribution of each task and its stratum; tasks that are in no statistics are left out."""
    for record in records:
        verdict, task = record.verdict, record.task
        if isinstance(verdict, PlanVerdict) and verdict.excluded is None and task is not None:
            kinds = () if verdict.goals is None else tuple([share.denominator > 0 for share in verdict.goals])
            steps = None if task.annotated_steps is None else _bin(task.annotated_steps, STEPS)
            case = Case(record.task_id, task.name, share_of_one(verdict.success))
            yield case, (steps, _bin(task.goals, GOALS), kinds)


def _bin(number: int, bounds: Sequence[int]) -> int:
    return sum([number > bound for bound in bounds])


def _analyze(records: Records, chosen: Options) -> Iterator[Analysis]:
    """A run of a benchmark is paired with those of the same model on task files of its world.

    These are named after it: lamps with lamps-tasks.

    Raises:
        InputError: there is no such pair.
    """
    pairs = list(_pairs(list(records.runs())))
    if not pairs:
        raise InputError("expected runs of a model on a benchmark and on generated tasks of its world")
    yield Analysis([contamination_table(pairs)], remarks=_REMARKS)


def _pairs(runs: Sequence[Run]) -> Iterator[Pair]:
    for public in runs:
        for fresh in runs:
            one, other = public.key, fresh.key
            alike = one._replace(domain=other.domain) == other and declaration_of(one.ability).has_plans
            if alike and other.domain.startswith(f"{one.domain}-"):
                suite = f"{other.domain} {one.ability.value}"
                yield one.name, suite, public.records, fresh.records


CONTAMINATION = Study(
    "contamination",
    "Success on public tasks beside fresh ones: the difference where tasks are alike.",
    analyze=_analyze,
)
