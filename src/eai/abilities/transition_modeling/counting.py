"""Counting what operators have right and wrong, by category of predicate."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from eai.abilities.transition_modeling.task import Category
from eai.abilities.verdict import ALL, Confusion
from eai.pddl.clauses import predicates_in
from eai.pddl.match import SideMatch

OTHER = "other"
"""The category of predicates that the domain does not have."""

_PLAIN: dict[str, str] = {category: category.value for category in Category}
"""The names of categories as nothing but texts."""


def count_by_category(
    sides: Iterable[SideMatch], categories: Mapping[str, Category], *, clauses: bool
) -> dict[str, Confusion]:
    """What is matched, additional and missing by category; categories without any are left out.

    Args:
        sides: preconditions, or effects.
        categories: predicate -> category.
        clauses: whether clauses are counted: each once in every category that its predicates have, `OTHER`
            among them, and once in `ALL`. Else predicates are, without those that have no category.
    """
    counts: dict[str, list[int]] = {}
    for side in sides:
        for index, parts in enumerate((side.matched, side.additional, side.missing)):
            for part in parts:
                names: set[str] = {categories.get(name, OTHER) for name in predicates_in(part)}
                if clauses:
                    names.add(ALL)
                else:
                    names.discard(OTHER)
                for name in names:
                    counts.setdefault(name, [0, 0, 0])[index] += 1
    return {_PLAIN.get(name, name): Confusion(*counts[name]) for name in sorted(counts)}
