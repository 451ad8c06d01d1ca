"""What is usual in a world: what is wanted and done, of what and to what, by category of object."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import eai.logic.formula as f
from eai.logic.traversal import children
from eai.world.execution import Action
from eai.world.state import Scene


class Pattern(NamedTuple):
    """A literal about objects of which only the category is known."""

    predicate: str
    categories: tuple[str, ...]
    truth: bool


Patterns: TypeAlias = Mapping[tuple[str, bool], Mapping[Pattern, float]]
"""How usual patterns are, by predicate and truth."""


def narrowed(patterns: Patterns, categories: Collection[str]) -> Patterns:
    """Those that are about objects of some categories alone."""
    about = frozenset(categories)
    found = {
        key: {pattern: weight for pattern, weight in known.items() if about.issuperset(pattern.categories)}
        for key, known in patterns.items()
    }
    return {key: known for key, known in found.items() if known}


class Kind(NamedTuple):
    """That an operator is used with an object of a category in one of its places."""

    operator: str
    place: int
    category: str


class Nesting(NamedTuple):
    """That something is to be in a relation to a thing of a category that is to be in another to a third."""

    relation: str
    category: str
    place: str


class Combination(NamedTuple):
    """That a thing is to be in a state and in a relation to a thing of a category."""

    state: str
    relation: str
    category: str


@dataclass(frozen=True)
class Theme:
    """What belongs together, as the tasks of one title are about it.

    Attributes:
        categories: of what the goals or the plan of one of them need, and of what most of them show.
        endings: what their goals say of the agent, all at once, as often as they do; the empty one too.
        patterns: how usual the literals are, of all that are usual, that are about these categories alone and
            not odd; as those of `Prior`.
    """

    categories: frozenset[str]
    endings: Mapping[tuple[Pattern, ...], int]
    patterns: Patterns


@dataclass(frozen=True)
class Prior:
    """What is usual.

    Attributes:
        patterns: how usual it is that a literal is wanted or comes about, by predicate and truth, then by
            pattern.
        wanted: how often goals say a predicate of something else than the agent, negated or not.
        themes: what the tasks of a title are about, by title.
        forms: how often goals have each shape, by the name of the formula's class.
        paired: the literals that goals say of pairs, "each into one of its own".
        nestings: what is wanted of things that are moved and others moved to, as a box that is filled.
        combinations: which states and places are wanted of one thing.
        needy: the states, with the category of the thing, that are wanted only together with a relation of
            something else to it.
        actions: how often each choice of actions is a goal.
        operators: those that plans use.
        kinds: what plans do to what; empty if the data set has no plans.
        places: the relations that say where things are.
        taken: the categories of what plans take in hand.
        used: the categories of what plans do something with besides going there and taking it.
        parts: the relations that bind a thing for good to one other, which it never goes without.
        several: where no goal of the data set is about all, some or so many things of a kind, the categories
            of which some task is about several things; else empty, and all or some of any kind may be wanted.
        pieces: the categories of the parts, which are nothing until they are cut off.
        holding: the predicates by which the agent holds things.
    """

    patterns: Patterns
    wanted: Mapping[tuple[str, bool], int]
    themes: Mapping[str, Theme]
    forms: Mapping[str, int]
    paired: frozenset[Pattern]
    nestings: frozenset[Nesting]
    combinations: frozenset[Combination]
    needy: frozenset[tuple[str, str]]
    actions: Mapping[tuple[str, ...], int]
    operators: frozenset[str]
    kinds: frozenset[Kind]
    places: tuple[str, ...]
    parts: tuple[str, ...]
    taken: frozenset[str]
    used: frozenset[str]
    several: frozenset[str]
    pieces: frozenset[str]
    holding: frozenset[str]


def kinds_of(action: Action, scene: Scene) -> Iterator[Kind]:
    """What an action does to what."""
    for place, index in enumerate(action.arguments):
        yield Kind(action.operator, place, scene.objects[index].category)


def patterns_of(
    formula: f.Formula, scene: Scene, bound: Mapping[str, str | None] | None = None, *, truth: bool = True
) -> Iterator[Pattern]:
    """The patterns of the literals of a goal; what ranges over all objects has none."""
    bound = bound or {}
    match formula:
        case f.Atom(predicate, terms):
            categories = [
                bound.get(t.name)
                if isinstance(t, f.Variable)
                else scene.objects[scene.index[t.name]].category
                for t in terms
            ]
            known = [category for category in categories if category is not None]
            if len(known) == len(categories):
                yield Pattern(predicate, tuple(known), truth)
        case f.Not(operand):
            yield from patterns_of(operand, scene, bound, truth=not truth)
        case f.ForAll(variable, body) | f.Exists(variable, body) | f.Exactly(_, variable, body):
            yield from patterns_of(body, scene, {**bound, variable.name: variable.category}, truth=truth)
        case f.ForPairs(first, second, body):
            inner = {**bound, first.name: first.category, second.name: second.category}
            yield from patterns_of(body, scene, inner, truth=truth)
        case _:
            for part in children(formula):
                yield from patterns_of(part, scene, bound, truth=truth)
