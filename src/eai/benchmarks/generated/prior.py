"""What is usual in a world: what is wanted and done, of what and to what, by category of object."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import NamedTuple

from eai.world.execution import Action
from eai.world.state import Scene


class Pattern(NamedTuple):
    """A literal about objects of which only the category is known."""

    predicate: str
    categories: tuple[str, ...]
    truth: bool


class Kind(NamedTuple):
    """That an operator is used with an object of a category in one of its places."""

    operator: str
    place: int
    category: str


@dataclass(frozen=True)
class Theme:
    """What belongs together, as the tasks of one title are about it.

    Attributes:
        categories: of all objects that their goals name or their plans use.
        endings: what their goals say of the agent, all at once, as often as they do; the empty one too.
    """

    categories: frozenset[str]
    endings: Mapping[tuple[Pattern, ...], int]


@dataclass(frozen=True)
class Prior:
    """What is usual.

    Attributes:
        patterns: how usual it is that a literal is wanted or comes about, by predicate and truth, then by
            pattern.
        odd: those of these patterns for which nobody would ask.
        wanted: how often goals say a predicate of something else than the agent, negated or not.
        themes: what the tasks of a title are about, by title.
        forms: how often goals have each shape, by the name of the formula's class.
        paired: the literals that goals say of pairs, "each into one of its own".
        actions: how often each choice of actions is a goal.
        operators: those that plans use.
        kinds: what plans do to what; empty if the data set has no plans.
        places: the relations that say where things are.
        taken: the categories of what plans take in hand.
        used: the categories of what plans do something with besides going there and taking it.
        parts: the relations that bind a thing for good to one other, which it never goes without.
        pieces: the categories of the parts, which are nothing until they are cut off.
        holding: the predicates by which the agent holds things.
    """

    patterns: Mapping[tuple[str, bool], Mapping[Pattern, float]]
    odd: frozenset[Pattern]
    wanted: Mapping[tuple[str, bool], int]
    themes: Mapping[str, Theme]
    forms: Mapping[str, int]
    paired: frozenset[Pattern]
    actions: Mapping[tuple[str, ...], int]
    operators: frozenset[str]
    kinds: frozenset[Kind]
    places: tuple[str, ...]
    parts: tuple[str, ...]
    taken: frozenset[str]
    used: frozenset[str]
    pieces: frozenset[str]
    holding: frozenset[str]


def kinds_of(action: Action, scene: Scene) -> Iterator[Kind]:
    """What an action does to what."""
    for place, index in enumerate(action.arguments):
        yield Kind(action.operator, place, scene.objects[index].category)
