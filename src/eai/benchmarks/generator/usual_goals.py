"""The usual goals, places of objects and actions in a data set's tasks, counted by categories of objects.

Generated tasks avoid combinations of goals that no task of the data set has.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import eai.logic.formula as f
from eai.logic.traversal import get_bound_variables, get_subformulas, walk_subformulas
from eai.world.action import Action
from eai.world.relation import ObjectMask, iterate_bits
from eai.world.state import Scene


def do_goals_clash(goal: f.Formula, other: f.Formula, scene: Scene, usual_goals: UsualGoalsOfDataSet) -> bool:
    """Whether two goals should not be combined in one task.

    They should not be combined in these cases:

    - Both goals may be about the place of one object, or about the same state of one object.
    - One action may reach both goals.
    - One goal is about the state of an object, the other about its place, and no published task has such
      goals.
    - One goal puts an object on a second object, the other moves the second, and no published task has such
      goals.
    - One goal puts objects of a category beside each other, and the other puts such an object elsewhere.
    """
    if not _find_predicate_and_subject_pairs(goal, scene).isdisjoint(
        _find_predicate_and_subject_pairs(other, scene)
    ):
        return True
    parts = list(_find_literals_with_possible_objects(goal, scene))
    others = list(_find_literals_with_possible_objects(other, scene))
    return bool(usual_goals.uses) and any(
        _is_combination_unseen_in_data_set(one, another, scene, usual_goals)
        or _is_combination_unseen_in_data_set(another, one, scene, usual_goals)
        for one in parts
        for another in others
    )


def is_goal_pointless_without_missing_goal(
    goal: f.Formula, other_goals: Iterable[f.Formula], scene: Scene, usual_goals: UsualGoalsOfDataSet
) -> bool:
    """Whether a goal makes sense only together with another goal that the task does not have.

    For example, nobody starts a dishwasher without putting dishes into the machine.
    """
    needy = [
        terms[0]
        for predicate, terms in _find_literals_with_possible_objects(goal, scene)
        if len(terms) == 1
        and (predicate, _get_category_of_first_object(terms[0], scene)) in usual_goals.dependent_states
    ]
    places = [
        terms[1]
        for other in other_goals
        for _, terms in _find_literals_with_possible_objects(other, scene)
        if len(terms) == 2
    ]
    return any(not any(mask & place for place in places) for mask in needy)


class _LiteralWithPossibleObjects(NamedTuple):
    """A literal of a goal: its predicate, and a bit mask of the possible objects for each argument."""

    predicate: str
    terms: tuple[ObjectMask, ...]


def _find_literals_with_possible_objects(
    goal: f.Formula, scene: Scene
) -> Iterator[_LiteralWithPossibleObjects]:
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
            yield _LiteralWithPossibleObjects(formula.predicate, tuple(masks))


def _is_combination_unseen_in_data_set(
    literal: _LiteralWithPossibleObjects,
    other: _LiteralWithPossibleObjects,
    scene: Scene,
    usual_goals: UsualGoalsOfDataSet,
) -> bool:
    """Whether no published task combines two such goals, as in: food on a plate, this plate in a cupboard."""
    if len(other.terms) != 2 or len(literal.terms) > 2:
        return False
    moved, place = other.terms
    if len(literal.terms) < 2:
        combined = (literal.predicate, other.predicate, _get_category_of_first_object(place, scene))
        return any(mask & moved for mask in literal.terms) and combined not in usual_goals.combinations
    thing, its_place = literal.terms
    nesting = (literal.predicate, _get_category_of_first_object(its_place, scene), other.predicate)
    if its_place & moved and nesting not in usual_goals.nestings:
        return True
    kind = _get_category_of_first_object(thing, scene)
    return (
        kind
        == _get_category_of_first_object(its_place, scene)
        == _get_category_of_first_object(moved, scene)
        != _get_category_of_first_object(place, scene)
    )


def _get_category_of_first_object(object_mask: ObjectMask, scene: Scene) -> str:
    """Return the category of the first object in a bit mask."""
    return scene.objects[next(iterate_bits(object_mask))].category


def _find_predicate_and_subject_pairs(goal: f.Formula, scene: Scene) -> set[tuple[str, int]]:
    """Return what a goal asks for, as pairs of a predicate and an object index.

    - A state gives its predicate and the object.
    - A place gives an empty text and the object, because all relations state places.
    - An action gives its name and -1.
    """
    subjects = {(formula.action, -1) for formula in walk_subformulas(goal) if isinstance(formula, f.Occurs)}
    for predicate, (first, *others) in (
        literal for literal in _find_literals_with_possible_objects(goal, scene) if literal.terms
    ):
        subjects.update(("" if others else predicate, i) for i in iterate_bits(first))
    return subjects


def find_goal_subjects(goal: f.Formula, scene: Scene) -> frozenset[int]:
    """Return the indices of the objects whose state or place a goal may state."""
    return frozenset({index for _, index in _find_predicate_and_subject_pairs(goal, scene)})


class LiteralPattern(NamedTuple):
    """A literal that has categories in place of objects."""

    predicate: str
    categories: tuple[str, ...]
    truth: bool


Patterns: TypeAlias = Mapping[tuple[str, bool], Mapping[LiteralPattern, float]]
"""Predicate and truth value of a literal -> pattern -> weight, which is greater for more usual patterns.

A pattern is a literal with categories in place of objects.
"""


def filter_patterns(patterns: Patterns, is_kept: Callable[[LiteralPattern], bool]) -> Patterns:
    """Return the patterns that fulfil a condition, with their weights, by predicate and truth value.

    A pattern is a literal with categories in place of objects. Predicates without such patterns are left out.
    """
    filtered = {
        key: {pattern: weight for pattern, weight in known.items() if is_kept(pattern)}
        for key, known in patterns.items()
    }
    return {key: known for key, known in filtered.items() if known}


def restrict_to_categories(patterns: Patterns, categories: Collection[str]) -> Patterns:
    """Return the patterns (literals with categories in place of objects) with only the given categories."""
    about = frozenset(categories)
    return filter_patterns(patterns, lambda pattern: about.issuperset(pattern.categories))


CategoryUsedAsArgument: TypeAlias = tuple[str, int, str]
"""A use of an object in plans: operator, position of the argument, and category of the object."""


@dataclass(frozen=True)
class UsualGoalsOfTaskTitle:
    """A theme: the usual goals of the data set's tasks with one title.

    Attributes:
        categories: categories of objects that some of these tasks need for a goal or plan, or that most of
            these tasks mention or use.
        agent_goal_counts: set of goals about the agent (possibly empty) -> number of tasks with this set.
        patterns: the part of `UsualGoalsOfDataSet.patterns` whose patterns have only these categories.
            Literals that an instruction would hardly request are left out.
    """

    categories: frozenset[str]
    agent_goal_counts: Mapping[tuple[LiteralPattern, ...], int]
    patterns: Patterns


@dataclass(frozen=True)
class UsualGoalsOfDataSet:
    """The usual goals, places of objects and actions in the tasks of a benchmark.

    Attributes:
        patterns: predicate and truth value -> pattern -> weight. A pattern is a literal with categories in
            place of objects. Its weight is greater if such literals are more often goals or effects of plans.
        goal_counts: predicate and truth value -> number of such literals in goals. Literals about the agent
            are not counted.
        themes: title of the data set's tasks -> usual goals of tasks with this title.
        shape_counts: class name of a goal's formula (its shape) -> number of such goals.
        pair_patterns: patterns in goals that relate each object of a category to a different object of
            another category.
        nestings: combinations of two goals: something is put into an object, such as a box, and the object is
            put elsewhere. Each is the first relation, the object's category, and the second relation.
        combinations: combinations of two goals about one object, its state and its place. Each is the
            predicate of the state, the relation of the place, and the category of the place.
        dependent_states: pairs of a state's predicate and a category. The state of such an object is a goal
            only together with the goal that something is put in or on the object.
        action_counts: operators among which a goal for actions lets the agent choose -> number of such goals.
        operators: names of the operators that plans use.
        uses: uses of objects in plans; empty if the data set has no plans.
        place_relations: names of the relations that state places of objects.
        taken_categories: categories of objects that plans pick up.
        used_categories: categories of objects that plans use by actions other than movement and taking.
        part_relations: names of the relations between a part and its whole, which never change.
        countable_categories: categories over which new goals may quantify, because a task has several objects
            of each. Empty if goals of the data set have quantifiers: new goals may then quantify over all
            categories.
        part_categories: categories of parts of objects. A part exists only after it is cut off.
        holding_predicate_names: names of the predicates by which the agent holds objects.
        unique_states: states that change and that exactly one object has at the start of each task, such as
            the floor on which a robot is.
    """

    patterns: Patterns
    goal_counts: Mapping[tuple[str, bool], int]
    themes: Mapping[str, UsualGoalsOfTaskTitle]
    shape_counts: Mapping[str, int]
    pair_patterns: frozenset[LiteralPattern]
    nestings: frozenset[tuple[str, str, str]]
    combinations: frozenset[tuple[str, str, str]]
    dependent_states: frozenset[tuple[str, str]]
    action_counts: Mapping[tuple[str, ...], int]
    operators: frozenset[str]
    uses: frozenset[CategoryUsedAsArgument]
    place_relations: tuple[str, ...]
    part_relations: tuple[str, ...]
    taken_categories: frozenset[str]
    used_categories: frozenset[str]
    countable_categories: frozenset[str]
    part_categories: frozenset[str]
    holding_predicate_names: frozenset[str]
    unique_states: frozenset[str]


def find_categories_used_as_arguments(action: Action, scene: Scene) -> Iterator[CategoryUsedAsArgument]:
    """Yield each argument's use in an action: operator, position of the argument, category of the object."""
    for place, index in enumerate(action.arguments):
        yield action.operator, place, scene.objects[index].category


def find_patterns(
    formula: f.Formula,
    scene: Scene,
    category_by_variable: Mapping[str, str | None] | None = None,
    *,
    truth: bool = True,
) -> Iterator[LiteralPattern]:
    """Yield each literal of a goal with categories in place of objects and variables.

    Literals with a variable without category are skipped.
    """
    category_by_variable = {
        **(category_by_variable or {}),
        **{variable.name: variable.category for variable in get_bound_variables(formula)},
    }
    if isinstance(formula, f.Atom):
        categories = [
            category_by_variable.get(t.name)
            if isinstance(t, f.Variable)
            else scene.objects[scene.index[t.name]].category
            for t in formula.arguments
        ]
        known = [category for category in categories if category is not None]
        if len(known) == len(categories):
            yield LiteralPattern(formula.predicate, tuple(known), truth)
    for part in get_subformulas(formula):
        yield from find_patterns(part, scene, category_by_variable, truth=truth != isinstance(formula, f.Not))
