"""Counting what operators have right and wrong, by category of predicate."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from eai.abilities.transition_modeling.task import Category
from eai.abilities.verdict import Confusion
from eai.pddl.matching import SideMatch

OTHER = "other"
"""The category of predicates that the domain does not have."""


def count_by_category(
    sides: Iterable[SideMatch], categories: Mapping[str, Category], *, count_others: bool
) -> dict[str, Confusion]:
    """Matched, additional and missing predicates by category; categories without any are left out.

    Args:
        sides: preconditions, or effects.
        categories: predicate -> category.
        count_others: whether predicates without a category count, as `OTHER`.
    """
    counts: dict[Category | None, list[int]] = {}
    for side in sides:
        for index, names in enumerate((side.matched, side.additional, side.missing)):
            for name in names:
                category = categories.get(name)
                if category is not None or count_others:
                    counts.setdefault(category, [0, 0, 0])[index] += 1
    named = {OTHER if category is None else category.value: found for category, found in counts.items()}
    return {name: Confusion(*named[name]) for name in sorted(named)}
