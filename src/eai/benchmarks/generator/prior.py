"""Usual goals, places of objects and actions in a world, by category of objects, counted in public tasks.

Generated tasks avoid combinations of goals that no public task has.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import eai.logic.formula as f
from eai.logic.traversal import get_bound_variables, get_subformulas, walk_subformulas
from eai.world.action import Action
from eai.world.relation import iterate_bits
from eai.world.state import Scene


def do_goals_clash(goal: f.Formula, other: f.Formula, scene: Scene, prior: UsualGoals) -> bool:
    """Whether two goals should not be combined in one task.

    They should not be combined in these cases:

    - Both may be about the place, or the same state, of one object, or one action may reach both.
    - One is about the state of an object, the other about its place, and no public task combines such goals.
    - One puts an object on a second object, the other moves the second object, and no public task has both.
    - One puts objects of a category beside each other, and the other puts such an object elsewhere.
    """
    if not _find_stated_subjects(goal, scene).isdisjoint(_find_stated_subjects(other, scene)):
        return True
    parts, others = list(_find_masked_literals(goal, scene)), list(_find_masked_literals(other, scene))
    return bool(prior.uses) and any(
        _is_unusual_combination(one, another, scene, prior)
        or _is_unusual_combination(another, one, scene, prior)
        for one in parts
        for another in others
    )


def is_goal_pointless(goal: f.Formula, others: Iterable[f.Formula], scene: Scene, prior: UsualGoals) -> bool:
    """Whether a goal is pointless, because it needs another goal that the task does not have.

    For example, nobody starts a dishwasher without putting dishes into it.
    """
    needy = [
        terms[0]
        for predicate, terms in _find_masked_literals(goal, scene)
        if len(terms) == 1 and (predicate, _get_category_of_mask(terms[0], scene)) in prior.dependent_states
    ]
    places = [
        terms[1] for other in others for _, terms in _find_masked_literals(other, scene) if len(terms) == 2
    ]
    return any(not any(mask & place for place in places) for mask in needy)


class _MaskedLiteral(NamedTuple):
    """A literal of a goal: its predicate, and a bit mask of the possible objects for each argument."""

    predicate: str
    terms: tuple[int, ...]


def _find_masked_literals(goal: f.Formula, scene: Scene) -> Iterator[_MaskedLiteral]:
    ranges: dict[str, int] = {}
    for formula in walk_subformulas(goal):
        ranges |= {
            variable.name: scene.get_category_mask(variable.category)
            for variable in get_bound_variables(formula)
        }
        if isinstance(formula, f.Atom):
            masks = [
                ranges[term.name] if isinstance(term, f.Variable) else 1 << scene.index[term.name]
                for term in formula.arguments
            ]
            yield _MaskedLiteral(formula.predicate, tuple(masks))


def _is_unusual_combination(
    literal: _MaskedLiteral, other: _MaskedLiteral, scene: Scene, prior: UsualGoals
) -> bool:
    """Whether no public task combines two such literals: food on a plate and the plate in a cupboard."""
    if len(other.terms) != 2 or len(literal.terms) > 2:
        return False
    moved, place = other.terms
    if len(literal.terms) < 2:
        combined = (literal.predicate, other.predicate, _get_category_of_mask(place, scene))
        return any(mask & moved for mask in literal.terms) and combined not in prior.combinations
    thing, its_place = literal.terms
    nesting = (literal.predicate, _get_category_of_mask(its_place, scene), other.predicate)
    if its_place & moved and nesting not in prior.nestings:
        return True
    kind = _get_category_of_mask(thing, scene)
    return (
        kind
        == _get_category_of_mask(its_place, scene)
        == _get_category_of_mask(moved, scene)
        != _get_category_of_mask(place, scene)
    )


def _get_category_of_mask(mask: int, scene: Scene) -> str:
    """Return the category of the first object in a bit mask."""
    return scene.objects[next(iterate_bits(mask))].category


def _find_stated_subjects(goal: f.Formula, scene: Scene) -> set[tuple[str, int]]:
    """Return what a goal states of objects, as pairs of a predicate and an object's index.

    The pair of a relation has an empty string as predicate. The pair of an action has its name, and -1 as
    object.
    """
    subjects = {(formula.action, -1) for formula in walk_subformulas(goal) if isinstance(formula, f.Occurs)}
    for predicate, (first, *others) in (
        literal for literal in _find_masked_literals(goal, scene) if literal.terms
    ):
        subjects.update(("" if others else predicate, i) for i in iterate_bits(first))
    return subjects


def find_subjects(goal: f.Formula, scene: Scene) -> frozenset[int]:
    """Return the indices of the objects about which a goal may state a fact."""
    return frozenset({index for _, index in _find_stated_subjects(goal, scene)})


class LiteralPattern(NamedTuple):
    """A literal with categories of objects in place of objects."""

    predicate: str
    categories: tuple[str, ...]
    truth: bool


Patterns: TypeAlias = Mapping[tuple[str, bool], Mapping[LiteralPattern, float]]
"""Weights of patterns of literals, by predicate and truth value."""


def filter_patterns(patterns: Patterns, is_kept: Callable[[LiteralPattern], bool]) -> Patterns:
    """Return the patterns that fulfil a condition. Predicates without such patterns are left out."""
    filtered = {
        key: {pattern: weight for pattern, weight in known.items() if is_kept(pattern)}
        for key, known in patterns.items()
    }
    return {key: known for key, known in filtered.items() if known}


def restrict_to_categories(patterns: Patterns, categories: Collection[str]) -> Patterns:
    """Return the patterns whose categories are all among the given categories."""
    about = frozenset(categories)
    return filter_patterns(patterns, lambda pattern: about.issuperset(pattern.categories))


ArgumentUse: TypeAlias = tuple[str, int, str]
"""How plans use objects: operator, position of the argument, and category of the object."""


@dataclass(frozen=True)
class TitleTheme:
    """A theme: usual goals about the objects of public tasks with one title.

    Attributes:
        categories: categories of objects that a goal or a plan needs, and categories that most tasks of the
            title mention or use.
        agent_goal_counts: number of tasks with each set of goals about the agent, the empty set included.
        patterns: weights of usual literals about these categories, as in `UsualGoals`.
    """

    categories: frozenset[str]
    agent_goal_counts: Mapping[tuple[LiteralPattern, ...], int]
    patterns: Patterns


@dataclass(frozen=True)
class UsualGoals:
    """The usual goals, places and actions of a world.

    Attributes:
        patterns: weight of each pattern as a goal or effect, by predicate and truth value, then by pattern.
        goal_counts: number of literals of goals, except about the agent, by predicate and truth value.
        themes: title of public tasks -> its theme.
        shape_counts: number of goals of each shape, by the name of the formula's class.
        pair_patterns: patterns in goals that each object of a category has its own object of another.
        nestings: goals about objects that are both moved and moved to, such as a box that is filled. Each is
            the relation to the object, its category, and its relation to a third object.
        combinations: a state and a place that are goals of one object: the predicate of the state, the
            relation of the place, and the category of its target.
        dependent_states: predicate of a state and category, if the state of such an object is a goal only
            together with a relation to the object.
        action_counts: choice of actions, as operators -> number of goals with this choice.
        operators: names of the operators that plans use.
        uses: uses of categories in plans; empty if the data set has no plans.
        place_relations: names of the relations that state places of objects.
        taken_categories: categories of objects that plans take in hand.
        used_categories: categories of objects that plans use by other actions than movement and taking.
        part_relations: names of the relations between a part and its whole, which never change.
        countable_categories: categories over which quantifiers of new goals may range: a task has several
            objects of each. Empty for all categories, if goals of the data set have quantifiers.
        part_categories: categories of parts, which exist only after they are cut off.
        holding_predicates: predicates by which the agent holds objects.
    """

    patterns: Patterns
    goal_counts: Mapping[tuple[str, bool], int]
    themes: Mapping[str, TitleTheme]
    shape_counts: Mapping[str, int]
    pair_patterns: frozenset[LiteralPattern]
    nestings: frozenset[tuple[str, str, str]]
    combinations: frozenset[tuple[str, str, str]]
    dependent_states: frozenset[tuple[str, str]]
    action_counts: Mapping[tuple[str, ...], int]
    operators: frozenset[str]
    uses: frozenset[ArgumentUse]
    place_relations: tuple[str, ...]
    part_relations: tuple[str, ...]
    taken_categories: frozenset[str]
    used_categories: frozenset[str]
    countable_categories: frozenset[str]
    part_categories: frozenset[str]
    holding_predicates: frozenset[str]


def find_argument_uses(action: Action, scene: Scene) -> Iterator[ArgumentUse]:
    """Yield the use of each object in an action: one use for each argument."""
    for place, index in enumerate(action.arguments):
        yield action.operator, place, scene.objects[index].category


def find_patterns(
    formula: f.Formula, scene: Scene, bound: Mapping[str, str | None] | None = None, *, truth: bool = True
) -> Iterator[LiteralPattern]:
    """Yield the patterns of the literals of a goal. Literals with a variable without category are skipped."""
    bound = {
        **(bound or {}),
        **{variable.name: variable.category for variable in get_bound_variables(formula)},
    }
    if isinstance(formula, f.Atom):
        categories = [
            bound.get(t.name) if isinstance(t, f.Variable) else scene.objects[scene.index[t.name]].category
            for t in formula.arguments
        ]
        known = [category for category in categories if category is not None]
        if len(known) == len(categories):
            yield LiteralPattern(formula.predicate, tuple(known), truth)
    for part in get_subformulas(formula):
        yield from find_patterns(part, scene, bound, truth=truth != isinstance(formula, f.Not))
