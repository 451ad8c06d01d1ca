"""Frequencies: what the demonstrations of one title share."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator

from eai.studies.annotation.difference import Difference
from eai.studies.annotation.pattern import Pattern


def frequencies(differences: Iterable[Difference], without: Iterable[str] = ()) -> Counter[Pattern]:
    """How often each pattern occurs in all differences together.

    States and relations by class come first, then relations with one of both ends by its properties; the
    agent stays itself.

    Args:
        differences: those of one title.
        without: predicates that are not counted, because they hold of too much.
    """
    left_out = frozenset(without)
    exact: Counter[Pattern] = Counter()
    wild: Counter[Pattern] = Counter()
    for each in differences:
        for fact in each.facts:
            if fact.predicate not in left_out:
                classes = tuple(map(each.class_of, fact.arguments))
                exact[Pattern(fact.predicate, classes)] += 1
                wild.update(_generalised(each, fact.predicate, fact.arguments))
    return exact + wild


def _generalised(each: Difference, name: str, things: tuple[int, ...]) -> Iterator[Pattern]:
    if len(things) < 2:
        return
    for end, thing in enumerate(things):
        if thing != each.scene.agent:
            kinds = [each.class_of(other) for other in things]
            kinds[end] = each.properties_of(thing)
            yield Pattern(name, tuple(kinds))
