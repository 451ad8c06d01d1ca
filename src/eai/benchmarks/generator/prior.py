"""The prior of a world: what is wanted and done, of what and to what, by category of object.

It says which goals nobody would want together: those that no public task wants together.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import eai.logic.formula as f
from eai.logic.traversal import bound_variables, children, walk
from eai.world.action import Action
from eai.world.relation import bits
from eai.world.state import Scene


def clash(goal: f.Formula, other: f.Formula, scene: Scene, prior: Prior) -> bool:
    """Whether two goals are too near each other to be wanted together.

    They are if both may say where the same thing is to be, or the same of it, or if one action meets both; if
    one says how a thing is to be and the other where, and no public task wants such a thing there; if one
    puts something where the other's thing is to be and none wants such things as places there; and if one
    puts things of a kind beside each other and the other puts such somewhere else.
    """
    if not _subjects(goal, scene).isdisjoint(_subjects(other, scene)):
        return True
    parts, others = list(_literals(goal, scene)), list(_literals(other, scene))
    return bool(prior.kinds) and any(
        _is_strange(one, another, scene, prior) or _is_strange(another, one, scene, prior)
        for one in parts
        for another in others
    )


def is_idle(goal: f.Formula, others: Iterable[f.Formula], scene: Scene, prior: Prior) -> bool:
    """Whether a goal is only wanted of what something else is wanted with, and no other goal wants that.

    A dishwasher is not run empty.
    """
    needy = [
        terms[0]
        for predicate, terms in _literals(goal, scene)
        if len(terms) == 1 and (predicate, _category(terms[0], scene)) in prior.needy
    ]
    places = [terms[1] for other in others for _, terms in _literals(other, scene) if len(terms) == 2]
    return any(not any(mask & place for place in places) for mask in needy)


class _Literal(NamedTuple):
    """A literal with what each of its terms may be, as masks."""

    predicate: str
    terms: tuple[int, ...]


def _literals(goal: f.Formula, scene: Scene) -> Iterator[_Literal]:
    """The literals of a goal about objects."""
    ranges: dict[str, int] = {}
    for part in walk(goal):
        ranges |= {each.name: scene.category(each.category) for each in bound_variables(part)}
        if isinstance(part, f.Atom):
            masks = [
                ranges[term.name] if isinstance(term, f.Variable) else 1 << scene.index[term.name]
                for term in part.arguments
            ]
            yield _Literal(part.predicate, tuple(masks))


def _is_strange(literal: _Literal, other: _Literal, scene: Scene, prior: Prior) -> bool:
    """Whether nobody wants one thing to be so while the other is there: food on a plate that is put away."""
    if len(other.terms) != 2 or len(literal.terms) > 2:
        return False
    moved, place = other.terms
    if len(literal.terms) < 2:
        combined = (literal.predicate, other.predicate, _category(place, scene))
        return any(mask & moved for mask in literal.terms) and combined not in prior.combinations
    thing, its_place = literal.terms
    nesting = (literal.predicate, _category(its_place, scene), other.predicate)
    if its_place & moved and nesting not in prior.nestings:
        return True
    kind = _category(thing, scene)
    return kind == _category(its_place, scene) == _category(moved, scene) != _category(place, scene)


def _category(mask: int, scene: Scene) -> str:
    """The category of the first object of a mask."""
    return scene.objects[next(bits(mask))].category


def _subjects(goal: f.Formula, scene: Scene) -> set[tuple[str, int]]:
    """Each state that a goal speaks of with each object that it may be said of; relations of a thing are one.

    Actions have no object.
    """
    found = {(part.action, -1) for part in walk(goal) if isinstance(part, f.Occurs)}
    for predicate, (first, *others) in (literal for literal in _literals(goal, scene) if literal.terms):
        found.update(("" if others else predicate, i) for i in bits(first))
    return found


def subjects_of(goal: f.Formula, scene: Scene) -> frozenset[int]:
    """The objects of which a goal may say something."""
    return frozenset({index for _, index in _subjects(goal, scene)})


class Pattern(NamedTuple):
    """A literal about objects of which only the category is known."""

    predicate: str
    categories: tuple[str, ...]
    truth: bool


Patterns: TypeAlias = Mapping[tuple[str, bool], Mapping[Pattern, float]]
"""How usual patterns are, by predicate and truth."""


def kept(patterns: Patterns, is_kept: Callable[[Pattern], bool]) -> Patterns:
    """Those of some patterns that are to be kept; what has none is left out."""
    found = {
        key: {pattern: weight for pattern, weight in known.items() if is_kept(pattern)}
        for key, known in patterns.items()
    }
    return {key: known for key, known in found.items() if known}


def narrowed(patterns: Patterns, categories: Collection[str]) -> Patterns:
    """Those that are about objects of some categories alone."""
    about = frozenset(categories)
    return kept(patterns, lambda pattern: about.issuperset(pattern.categories))


Use: TypeAlias = tuple[str, int, str]
"""An operator, one of its places, and the category of an object with which it is used there."""


@dataclass(frozen=True)
class Theme:
    """A theme: goals that belong together, as the tasks of one title are about them.

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
    """The usual goals, places and actions of a world.

    Attributes:
        patterns: how usual it is that a literal is wanted or comes about, by predicate and truth, then by
            pattern.
        wanted: how often goals say a predicate of something else than the agent, negated or not.
        themes: what the tasks of a title are about, by title.
        forms: how often goals have each shape, by the name of the formula's class.
        paired: the literals that goals say of pairs, "each into one of its own".
        nestings: what is wanted of things that are moved and others moved to, as a box that is filled: a
            relation to a thing, the category of that, and its own relation to a third one.
        combinations: which states and places are wanted of one thing: a state, a relation, and the category
            of the other thing in it.
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
    nestings: frozenset[tuple[str, str, str]]
    combinations: frozenset[tuple[str, str, str]]
    needy: frozenset[tuple[str, str]]
    actions: Mapping[tuple[str, ...], int]
    operators: frozenset[str]
    kinds: frozenset[Use]
    places: tuple[str, ...]
    parts: tuple[str, ...]
    taken: frozenset[str]
    used: frozenset[str]
    several: frozenset[str]
    pieces: frozenset[str]
    holding: frozenset[str]


def kinds_of(action: Action, scene: Scene) -> Iterator[Use]:
    """The uses of objects by an action."""
    for place, index in enumerate(action.arguments):
        yield action.operator, place, scene.objects[index].category


def patterns_of(
    formula: f.Formula, scene: Scene, bound: Mapping[str, str | None] | None = None, *, truth: bool = True
) -> Iterator[Pattern]:
    """The patterns of the literals of a goal; what ranges over all objects has none."""
    bound = {**(bound or {}), **{variable.name: variable.category for variable in bound_variables(formula)}}
    if isinstance(formula, f.Atom):
        categories = [
            bound.get(t.name) if isinstance(t, f.Variable) else scene.objects[scene.index[t.name]].category
            for t in formula.arguments
        ]
        known = [category for category in categories if category is not None]
        if len(known) == len(categories):
            yield Pattern(formula.predicate, tuple(known), truth)
    for part in children(formula):
        yield from patterns_of(part, scene, bound, truth=truth != isinstance(formula, f.Not))
