"""What a question is made of before it is put into words in one of its forms."""

from __future__ import annotations

import random
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias, TypeVar

from eai.logic.formula import Formula
from eai.questions.question import Accept
from eai.questions.setting import Setting
from eai.world.state import State

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Item:
    """What is asked, with what is right and what is wrong.

    Attributes:
        state: what holds when it is asked.
        operators: the names of the operators whose rules are told.
        depth: how many actions there are to think of.
        right: texts of which any is a right choice, first what is easily taken for wrong.
        wrong: texts of which any is a wrong choice, first what is easily taken for right.
        answer: the gold answers in open form.
        accept: whether all of these are wanted.
        values: what else the templates speak of.
        formulas: goals that are told, for the sake of the predicates in them.
        about: the labels of texts that do not begin with their operator or predicate: that operator first.
        actions: whether what is right and wrong are actions: where they are to choose from, no rules but
            theirs are told.
        yes_no: the texts of which yes or no is asked, as something alike has the other answer; all if None.
    """

    state: State
    operators: Collection[str]
    depth: int
    right: Sequence[str]
    wrong: Sequence[str]
    answer: Sequence[str]
    accept: Accept = Accept.ALL
    values: Mapping[str, str] = field(default_factory=dict)
    formulas: tuple[Formula, ...] = ()
    about: Mapping[str, Sequence[str]] = field(default_factory=dict)
    actions: bool = False
    yes_no: Collection[str] | None = None


Maker: TypeAlias = Callable[[Setting, random.Random, int], Item | None]
"""Makes an item of a setting, at random, or none; the number says which class of answers it is to be of."""


def with_counterparts(
    right: Sequence[str], wrong: Sequence[str], operator: Callable[[str], str]
) -> frozenset[str]:
    """The texts of which one with the other answer has the same operator."""
    shared = set(map(operator, right)) & set(map(operator, wrong))
    return frozenset([text for text in (*right, *wrong) if operator(text) in shared])


def some(rng: random.Random, things: Sequence[T], most: int) -> list[T]:
    """Some different things, at random, in their order; all if there are no more than that."""
    if len(things) <= most:
        return list(things)
    return [things[i] for i in sorted(rng.sample(range(len(things)), most))]


def numbered(texts: Sequence[str]) -> str:
    """Lines with numbers from 1."""
    return "\n".join([f"{number}. {text}" for number, text in enumerate(texts, 1)])


def listed(texts: Sequence[str]) -> str:
    """Lines with a dash."""
    return "\n".join([f"- {text}" for text in texts])
