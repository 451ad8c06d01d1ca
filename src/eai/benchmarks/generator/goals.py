"""Draw random goals for a scene, about facts that tasks usually require of its objects.

The shape of a goal, such as a quantified formula, is as frequent as in the benchmark, or all shapes are
equally frequent.
"""

from __future__ import annotations

import math
import random
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import eai.logic.formula as f
from eai.benchmarks.generator.spec import GoalFormFrequency
from eai.benchmarks.generator.usual_goals import (
    LiteralPattern,
    Patterns,
    UsualGoalsOfDataSet,
    UsualGoalsOfTaskTitle,
    filter_patterns,
    restrict_to_categories,
)
from eai.world.relation import iterate_bits
from eai.world.state import Scene

K = TypeVar("K")

X, Y = "x", "y"
"""Variables of goals."""

_SHAPES = ("Atom", "Not", "Or", "ForAll", "Exists", "Exactly", "ForPairs")
_QUANTIFIED_SHAPES = ("ForAll", "Exists", "Exactly", "ForPairs")
_MAX_COUNT = 4


@dataclass(frozen=True)
class GoalSampler:
    """Draws random goals for one scene, by patterns: literals with categories in place of objects.

    Attributes:
        usual_goals: the usual goals of the benchmark.
        scene: the scene.
        forms: class name of a goal's formula (its shape), such as ``Or`` -> weight. ``Occurs`` is the class
            of goals for actions.
        patterns: weight of each pattern of literals about objects of this scene.
        pair_patterns: patterns allowed in goals about pairs of objects. If empty, all patterns are allowed.
    """

    usual_goals: UsualGoalsOfDataSet
    scene: Scene
    forms: Mapping[str, int]
    patterns: Patterns
    pair_patterns: frozenset[LiteralPattern] = frozenset()

    @staticmethod
    def make_goal_sampler_for_scene(
        scene: Scene,
        usual_goals: UsualGoalsOfDataSet,
        goal_forms: GoalFormFrequency,
        *,
        actions: bool,
        theme: UsualGoalsOfTaskTitle | None = None,
    ) -> GoalSampler:
        """Return an object that draws random goals for a scene.

        The goals are usual goals of tasks with one title (the theme), or of all tasks if `theme` is None.
        """
        usual = restrict_to_categories(
            (usual_goals if theme is None else theme).patterns, _make_ordered_set_of_categories(scene)
        )
        patterns = filter_patterns(usual, lambda pattern: _can_be_goal(pattern, scene, usual_goals))
        fitting = {*_SHAPES, *(["Occurs"] if actions else [])}
        fitting -= (
            set()
            if _select_patterns_for_quantified_goals(patterns, scene, usual_goals)
            else {*_QUANTIFIED_SHAPES}
        )
        usual_shapes = dict.fromkeys(_SHAPES, 1) if goal_forms == "all" else usual_goals.shape_counts
        shapes = {shape: n for shape, n in usual_shapes.items() if shape in fitting and n}
        paired = frozenset[LiteralPattern]() if goal_forms == "all" else usual_goals.pair_patterns
        return GoalSampler(usual_goals, scene, shapes, patterns, paired)

    def restrict_first_object_to_categories(self, categories: Collection[str]) -> GoalSampler:
        """Return a sampler of goals whose first object has a category in `categories`."""
        patterns = filter_patterns(
            self.patterns, lambda p: bool(p.categories) and p.categories[0] in categories
        )
        return replace(self, patterns=patterns)

    def draw_literal(self, rng: random.Random, relation_probability: float = 0.0) -> f.Formula | None:
        """Return a random positive literal about objects of the scene, or None if no literal fits.

        `relation_probability` is the minimum probability of drawing a relation between two objects.
        """
        pattern = self._draw_pattern(
            rng, truth=True, relations_only=relation_probability > 0 and rng.random() < relation_probability
        )
        return None if pattern is None else self._draw_ground_literal(pattern, rng)

    def draw_goals_about_agent(
        self, goals_of_title: UsualGoalsOfTaskTitle, rng: random.Random
    ) -> list[f.Formula]:
        """Draw a random published task with a given title. Return its goals about the agent for this scene.

        Random objects of the same categories replace the objects of the task. The task is one whose
        goals about the agent fit the scene. The result is empty if no task fits, or if the drawn task has no
        goals about the agent.
        """
        here = _make_ordered_set_of_categories(self.scene)
        fitting = {
            e: n
            for e, n in goals_of_title.agent_goal_counts.items()
            if all(here.keys() >= {*p.categories} for p in e)
        }
        if not fitting:
            return []
        chosen = {category: rng.choice(self._list_category_members(category)) for category in here}
        return [
            self._make_literal_of_pattern(
                p, [f.Constant(self.scene.objects[chosen[c]].name) for c in p.categories]
            )
            for p in _draw_weighted(fitting, rng)
        ]

    def draw_goal(self, rng: random.Random) -> f.Formula | None:
        """Return a random goal, whose shape is drawn first, or None if no goal fits."""
        if not self.forms:
            return None
        shape = _draw_weighted(self.forms, rng)
        if shape == "Occurs":
            alternatives: tuple[str, ...] = _draw_weighted(self.usual_goals.action_counts, rng)
            return f.Or(tuple(map(f.Occurs, alternatives)))
        countable = _select_patterns_for_quantified_goals(self.patterns, self.scene, self.usual_goals)
        known = self if shape not in _QUANTIFIED_SHAPES else replace(self, patterns=countable)
        pattern = known._draw_pattern(rng, truth=shape != "Not")
        if pattern is None:
            return None
        match shape:
            case "Atom" | "Not":
                return self._draw_ground_literal(pattern, rng)
            case "Or":
                return self._draw_disjunction(pattern, rng)
            case "ForPairs":
                return self._make_goal_pairing_objects_one_to_one(pattern)
        return self._draw_quantified_goal(shape, pattern, rng)

    def _draw_pattern(
        self, rng: random.Random, *, truth: bool | None = None, relations_only: bool = False
    ) -> LiteralPattern | None:
        """Return a random pattern (a literal of categories, not objects), or None if no pattern fits.

        First a predicate is drawn by its frequency in goals, and then one of its patterns by weight.
        """
        arity = self.scene.vocabulary.find_arity
        wanted = {
            key: self.usual_goals.goal_counts[key]
            for key in self.patterns
            if truth in (None, key[1]) and not (relations_only and arity(key[0]) != 2)
        }
        if not wanted:
            return None
        patterns = self.patterns[_draw_weighted(wanted, rng)]
        return _draw_weighted({pattern: math.sqrt(weight) for pattern, weight in patterns.items()}, rng)

    def _list_category_members(self, category: str) -> list[int]:
        return list(iterate_bits(self.scene.get_category_mask(category)))

    def _draw_ground_literal(self, pattern: LiteralPattern, rng: random.Random) -> f.Formula | None:
        """Return a literal about random objects of the categories, or None if it would repeat an object."""
        chosen = [rng.choice(self._list_category_members(category)) for category in pattern.categories]
        if len(set(chosen)) < len(chosen):
            return None
        return self._make_literal_of_pattern(
            pattern, [f.Constant(self.scene.objects[i].name) for i in chosen]
        )

    @staticmethod
    def _make_literal_of_pattern(pattern: LiteralPattern, terms: Sequence[f.Term]) -> f.Formula:
        atom = f.Atom(pattern.predicate, tuple(terms))
        return atom if pattern.truth else f.Not(atom)

    def _draw_disjunction(self, pattern: LiteralPattern, rng: random.Random) -> f.Formula | None:
        """Return the goal that an object has either of two random relations, or None if no relations fit."""
        others = {
            other: weight
            for (_, truth), patterns in self.patterns.items()
            for other, weight in patterns.items()
            if truth and len(other.categories) == 2 and other.categories[:1] == pattern.categories[:1]
        }
        first = (
            self._draw_ground_literal(pattern, rng)
            if pattern.truth and len(pattern.categories) == 2
            else None
        )
        if not isinstance(first, f.Atom) or not others:
            return None
        second = self._draw_ground_literal(_draw_weighted(others, rng), rng)
        if not isinstance(second, f.Atom) or first.arguments[0] in second.arguments[1:]:
            return None
        same = f.Atom(second.predicate, (first.arguments[0], *second.arguments[1:]))
        return None if same == first else f.Or((first, same))

    def _draw_literal_with_variable_and_count(
        self, pattern: LiteralPattern, rng: random.Random, *, may_quantify_second: bool = False
    ) -> tuple[f.Variable, f.Formula, int] | None:
        """Return a variable for objects of a category, a literal about it, and the number of such objects.

        The category is the first category of the pattern, a literal with categories in place of objects. A
        second argument of the literal is one random object of the second category. With
        ``may_quantify_second``, a variable may replace it: the literal then holds if it holds for any object
        of the second category. Return None if a goal cannot quantify over the first category.
        """
        if not pattern.categories:
            return None
        category, *others = pattern.categories
        members = self._list_category_members(category)
        if (
            len(members) < 2
            or category in others
            or not _may_goals_quantify_over_category(category, self.usual_goals)
        ):
            return None
        terms: list[f.Term] = [f.Variable(X)]
        inner: f.Variable | None = None
        for other in others:
            targets = self._list_category_members(other)
            if may_quantify_second and len(targets) > 1 and rng.random() < 0.5:
                inner = f.Variable(Y, other)
                terms.append(f.Variable(Y))
            else:
                terms.append(f.Constant(self.scene.objects[rng.choice(targets)].name))
        body = self._make_literal_of_pattern(pattern, terms)
        return f.Variable(X, category), body if inner is None else f.Exists(inner, body), len(members)

    def _draw_quantified_goal(
        self, shape: str, pattern: LiteralPattern, rng: random.Random
    ) -> f.Formula | None:
        """Return a goal about all, some or a number of objects of a category, or None if no goal fits.

        Goals about all objects are negated with the frequency of negated goals in the benchmark.
        """
        if shape == "ForAll" and (not pattern.truth or rng.random() < self._get_share_of_negated_goals()):
            pattern = self._draw_pattern(rng, truth=False) or pattern
        made = self._draw_literal_with_variable_and_count(
            pattern, rng, may_quantify_second=shape == "ForAll" and pattern.truth
        )
        if made is None:
            return None
        variable, body, size = made
        if shape == "Exactly":
            return f.Exactly(rng.randint(1, min(size - 1, _MAX_COUNT)), variable, body)
        return f.ForAll(variable, body) if shape == "ForAll" else f.Exists(variable, body)

    def _get_share_of_negated_goals(self) -> float:
        counts = self.usual_goals.goal_counts
        negated = sum(n for (_, truth), n in counts.items() if not truth)
        return negated / max(1, sum(counts.values()))

    def _make_goal_pairing_objects_one_to_one(self, pattern: LiteralPattern) -> f.Formula | None:
        """Return the goal that relates each object of one category to a different object of another category.

        Return None in these cases:

        - The pattern does not relate two different categories, or may not be used in such goals.
        - Goals may not quantify over one of the categories.
        - The scene has only one object of the first category, or fewer objects of the second than of the
          first.
        """
        kinds = pattern.categories
        if (
            len(kinds) != 2
            or kinds[0] == kinds[1]
            or (self.pair_patterns and pattern not in self.pair_patterns)
        ):
            return None
        few, many = (len(self._list_category_members(kind)) for kind in kinds)
        if not 2 <= few <= many or not all(
            _may_goals_quantify_over_category(kind, self.usual_goals) for kind in kinds
        ):
            return None
        body = self._make_literal_of_pattern(pattern, (f.Variable(X), f.Variable(Y)))
        return f.ForPairs(f.Variable(X, kinds[0]), f.Variable(Y, kinds[1]), body)


def _make_ordered_set_of_categories(scene: Scene) -> Mapping[str, None]:
    """Return the categories of a scene's objects without duplicates, in the order of the objects."""
    return dict.fromkeys([thing.category for thing in scene.objects])


def _may_goals_quantify_over_category(category: str, usual_goals: UsualGoalsOfDataSet) -> bool:
    """Whether goals may quantify over the objects of a category."""
    return not usual_goals.countable_categories or category in usual_goals.countable_categories


def _select_patterns_for_quantified_goals(
    patterns: Patterns, scene: Scene, usual_goals: UsualGoalsOfDataSet
) -> Patterns:
    """Return the patterns whose first category may be quantified in a goal.

    A pattern is a literal with categories in place of objects. The scene must have several objects of the
    first category, and goals must be allowed to quantify over it.
    """

    def can_goals_quantify_over_first_argument(pattern: LiteralPattern) -> bool:
        first = pattern.categories[:1]
        return any(
            _may_goals_quantify_over_category(c, usual_goals) and scene.get_category_mask(c).bit_count() > 1
            for c in first
        )

    return filter_patterns(patterns, can_goals_quantify_over_first_argument)


def _can_be_goal(pattern: LiteralPattern, scene: Scene, usual_goals: UsualGoalsOfDataSet) -> bool:
    """Whether goals may have the form of a pattern: a literal with categories in place of objects.

    Such goals are plausible (`is_usual_goal`), have at most two arguments, and are not about the agent or a
    part of an object.
    """
    if len(pattern.categories) > 2:
        return False
    if scene.agent is not None and scene.objects[scene.agent].category in pattern.categories:
        return False
    if not usual_goals.part_categories.isdisjoint(pattern.categories):
        return False
    return is_usual_goal(pattern, usual_goals)


def is_usual_goal(pattern: LiteralPattern, usual_goals: UsualGoalsOfDataSet) -> bool:
    """Whether goals of the form of a pattern, a literal with categories in place of objects, are plausible.

    A relation is plausible if plans of the data set pick up objects of its first category, and use objects of
    its other categories. Goals of all other forms are plausible. If the data set has no plans, all goals are.
    """
    first, *others = pattern.categories or ("",)
    is_relation = bool(others and usual_goals.uses)
    return not is_relation or (
        first in usual_goals.taken_categories and usual_goals.used_categories.issuperset(others)
    )


def _draw_weighted(weights: Mapping[K, float], rng: random.Random) -> K:
    return rng.choices(list(weights), list(weights.values()))[0]
