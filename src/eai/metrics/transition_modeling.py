"""The paper's metrics of transition modeling (tables "logical matching score" and "planner success rate")."""

from __future__ import annotations

from collections.abc import Collection

from eai.abilities.transition_modeling.task import Category
from eai.abilities.verdict import Confusion, Verdict, fields_of
from eai.metrics.rate import NOTHING, Rate, add, confusion_rates, share
from eai.pddl.planning import PlannerOutcome

OVERALL = "overall"
"""The prefix of the rates over all categories."""

CATEGORIES = tuple(category.value for category in Category if category is not Category.OBJECT_TOOLS)
"""The categories with columns of their own."""

TABLE_COLUMNS = tuple(
    f"{part}.{measure}" for part in (*CATEGORIES, OVERALL) for measure in ("f1", "planner_success")
)
"""What a terminal shows."""


def contribution(verdict: Verdict) -> dict[str, Rate]:
    """What one answer contributes to each rate.

    Counts are of preconditions and effects together. A task's planner outcome counts in each of the task's
    categories and once overall; one that no planner ran on counts in
    neither.
    """
    counts = _by_category(verdict)
    planned = verdict.planner not in (None, PlannerOutcome.NOT_RUN)
    outcome = share(verdict.planner is PlannerOutcome.SOLVED)
    categories = _categories(verdict)
    rates: dict[str, Rate] = {}
    for name in CATEGORIES:
        rates |= confusion_rates(name, counts.get(name, Confusion(0, 0, 0)))
        rates[f"{name}.planner_success"] = outcome if planned and name in categories else NOTHING
    rates |= confusion_rates(OVERALL, add(counts.values()))
    rates[f"{OVERALL}.planner_success"] = outcome if planned else NOTHING
    return rates


def _by_category(verdict: Verdict) -> dict[str, Confusion]:
    """The counts of both sides by category, all categories that are there."""
    found: dict[str, Confusion] = {}
    for side in (verdict.counts or {}).values():
        if not isinstance(side, Confusion):
            for name, confusion in side.items():
                found[name] = add((found.get(name, Confusion(0, 0, 0)), confusion))
    return found


def _categories(verdict: Verdict) -> Collection[str]:
    found = fields_of(verdict).get("task_categories")
    return [str(name) for name in found] if isinstance(found, list | tuple) else ()
