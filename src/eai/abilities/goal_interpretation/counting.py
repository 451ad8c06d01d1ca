"""Counting predicted goals against those of the data set, in any domain."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Hashable, Mapping, Sequence
from typing import TypeVar

from eai.abilities.verdict import Confusion
from eai.logic.matching import maximum_matching

T = TypeVar("T", bound=Hashable)


def confusion(matched: int, predicted: int, gold: int) -> Confusion:
    """The counts for so many matches among so many predictions and gold goals."""
    return Confusion(matched, predicted - matched, gold - matched)


def count_up_to_renaming(predicted: Counter[T], gold: Counter[T], instances: Mapping[T, int]) -> Confusion:
    """Match goals that are written with names which several objects may share.

    A goal that is predicted k times matches up to k gold goals written the same way.

    Args:
        predicted: how often each goal is predicted.
        gold: how many gold goals are written in each way.
        instances: of how many different objects, or pairs of them, each predicted goal can be said; of what
            does not exist, once. Saying it more often is mere repetition, which is not counted.
    """
    said = {goal: min(times, max(1, instances[goal], gold[goal])) for goal, times in predicted.items()}
    matched = sum(min(times, gold[goal]) for goal, times in said.items())
    return confusion(matched, sum(said.values()), gold.total())


def count_alternatives(predicted: Collection[T], gold: Sequence[Collection[T]]) -> Confusion:
    """Match each prediction with at most one gold goal, and each gold goal once.

    Args:
        predicted: the predictions, without duplicates.
        gold: for each gold goal the predictions that meet it.
    """
    return confusion(len(match_alternatives(predicted, gold)), len(predicted), len(gold))


def match_alternatives(predicted: Collection[T], gold: Sequence[Collection[T]]) -> frozenset[int]:
    """The gold goals (by position) that get a prediction of their own, as many as can; see above."""
    adjacency = [[i for i, goal in enumerate(gold) if word in goal] for word in predicted]
    return frozenset(partner for partner in maximum_matching(adjacency) if partner is not None)
