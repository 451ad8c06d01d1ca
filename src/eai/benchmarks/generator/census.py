"""Count the goals, states and plans of a benchmark by object category, to learn which goals are usual.

A domain allows many actions that are unusual, such as washing a book. Plans of generated tasks therefore come
from a restricted copy of the domain. In the copy, an operator has an additional precondition for each
argument: a plan of the benchmark uses an object of this object's category as the argument. Operators that no
plan of the benchmark uses are left out of the copy.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import chain, product
from typing import TypeAlias

import eai.logic.formula as f
from eai.abilities.protocol import Ability
from eai.base.grouping import group_pairs
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.generator.measures import find_objects_of_goals_and_plan
from eai.benchmarks.generator.usual_goals import (
    LiteralPattern,
    Patterns,
    UsualGoalsOfDataSet,
    UsualGoalsOfTaskTitle,
    filter_patterns,
    find_categories_used_as_arguments,
    find_patterns,
    restrict_to_categories,
)
from eai.planning.effect_schema import make_effect_schemas
from eai.planning.role import infer_operator_role
from eai.tasks.goal_test import list_actions_that_meet_goal
from eai.tasks.task import Goal, GoalKind, Task
from eai.tasks.wording import list_objects_in_prompt
from eai.world.action import Action
from eai.world.domain import Domain
from eai.world.execution import Trajectory, execute_plan
from eai.world.listing import FactLister
from eai.world.operator import Operator, OperatorRole, affordance
from eai.world.relation import iterate_bits
from eai.world.state import Fact, Scene, State
from eai.world.vocabulary import Predicate


class DomainLimitedToActionsSeenInPlans:
    """A domain restricted to usual actions, or the original domain if the data set has no plans.

    An action is usual if plans of the data set use its operator. Each of its arguments must have the category
    of an object that a plan uses as the same argument of this operator.

    Attributes:
        domain: the restricted domain.
    """

    def __init__(self, domain: Domain, usual_goals: UsualGoalsOfDataSet) -> None:
        self.domain, self._original = domain, domain.vocabulary
        self._kinds = group_pairs(
            (_make_predicate_for_arguments_seen_in_plans(name, place), kind)
            for name, place, kind in sorted(usual_goals.uses)
        )
        if self._kinds:
            vocabulary = replace(self._original, predicates=(*self._original.predicates, *self._kinds))
            used = [operator for operator in domain.operators if operator.name in usual_goals.operators]
            self.domain = replace(
                domain,
                vocabulary=vocabulary,
                operators=tuple(map(_limit_operator_to_arguments_seen_in_plans, used)),
            )

    def make_state(self, scene: Scene, facts: Iterable[Fact]) -> State:
        """Return a state of the restricted domain: the objects of a scene, and the given facts.

        Facts are added that state which objects are usual arguments of actions.
        """
        own = Scene(self.domain.vocabulary, scene.objects, scene.agent)
        return own.state(
            (*self._select_declared_facts(facts), *self._yield_facts_marking_arguments_seen_in_plans(own))
        )

    def convert_state_to_original_domain(self, state: State) -> State:
        """Return a state of the restricted domain as a state of the original domain.

        In the original domain, plans may also contain unusual actions.
        """
        scene = Scene(self._original, state.scene.objects, state.scene.agent)
        return scene.state(self._select_declared_facts(state.facts()))

    def _select_declared_facts(self, facts: Iterable[Fact]) -> Iterator[Fact]:
        return (fact for fact in facts if self._original.find_stored_predicate(fact.predicate) is not None)

    def _yield_facts_marking_arguments_seen_in_plans(self, scene: Scene) -> Iterator[Fact]:
        for predicate, kinds in self._kinds.items():
            for kind in kinds:
                yield from (Fact(predicate.name, (i,)) for i in iterate_bits(scene.get_category_mask(kind)))


def _make_predicate_for_arguments_seen_in_plans(operator: str, argument_index: int) -> Predicate:
    """Return the predicate that marks the usual objects for one argument of an operator.

    An object is usual if a plan uses an object of its category as this argument.
    """
    return Predicate(f"usual {operator} {argument_index}", 1, static=True)


def _limit_operator_to_arguments_seen_in_plans(operator: Operator) -> Operator:
    checks = [
        affordance(
            _make_predicate_for_arguments_seen_in_plans(operator.name, place)(parameter),
            f"{{{parameter.name}}} is unusual",
        )
        for place, parameter in enumerate(operator.parameters)
    ]
    return replace(operator, checks=(*checks, *operator.checks))


MAX_MEAN_PLACES_PER_OBJECT = 1.5
"""Maximum mean number of targets per source of a relation that states places, such as *inside*.

A relation with a greater mean, such as *near*, does not tell where an object is.
"""

_QUANTIFIED = ("ForAll", "Exists", "Exactly", "ForPairs")
_WEIGHTS_OF_SHAPES = {"Atom": 2, "ForAll": 6, "Exactly": 4, "Exists": 3}
"""Shape of a goal (class name of its formula) -> weight for drawing this shape at random.

These weights apply if no goal of the data set has a quantifier. Otherwise, the counts of the data set apply.
"""

_APPROACH_ROLES = (OperatorRole.TAKES, OperatorRole.MOVEMENT)
"""Roles of operators by which the agent takes or approaches an object without using it."""

_GOAL_WEIGHT, _EFFECT_WEIGHT, _FACT_WEIGHT = 4.0, 1.0, 0.05
"""Numbers that a goal, an effect of a plan, and an initial fact add to the weight of their pattern.

A pattern is a literal with categories in place of objects.
"""


def learn_usual_goals_from_tasks(benchmark: Benchmark, tasks: Iterable[Task]) -> UsualGoalsOfDataSet:
    """Count goals, places of objects and actions in tasks of a benchmark, and return which are usual."""
    tasks, domain = list(tasks), benchmark.domain
    listings = benchmark.wording(Ability.ACTION_SEQUENCING).fact_listers_of_goal_predicates
    states = [task.initial for task in tasks]
    courses = [execute_plan(domain, task.initial, _cut_plan_at_error(task.script, domain)) for task in tasks]
    done = [(action, course.final_state.scene) for course in courses for action in course.executed_actions]
    kinds = frozenset(
        [use for action, scene in done for use in find_categories_used_as_arguments(action, scene)]
    )
    goals = [goal for task in tasks for goal in task.goals]
    forms = Counter([_get_type_name_of_goal_formula(goal) for goal in goals])
    is_plain = not any(forms[form] for form in _QUANTIFIED)
    asked = [
        (formula, pattern, task.scene)
        for task in tasks
        for formula, pattern in _yield_goals_with_literal_patterns(task)
    ]
    wanted = Counter([(p.predicate, p.truth) for _, p, scene in asked if not _is_about_agent(p, scene)])
    weights = _compute_weights_for_drawing_goal_patterns(tasks, courses, listings)
    if not kinds:
        wanted.update(product([listing.predicate for listing in listings], (True, False)))
        for pattern in _combine_predicates_with_all_categories(wanted, states):
            weights[pattern] += _FACT_WEIGHT
    usual = (((p.predicate, p.truth), (p, weight)) for p, weight in weights.items() if weight > 0)
    patterns = {key: dict(known) for key, known in group_pairs(usual).items() if key in wanted}
    # a literal may be an unlikely goal although its negation is a likely goal
    is_odd = benchmark.notation.english.is_goal_nobody_would_request
    sound = filter_patterns(patterns, lambda p: not (p.truth and is_odd(p.predicate, p.categories)))
    roles = {operator.name: infer_operator_role(operator) for operator in domain.operators}
    nestings, combinations, needy = _find_combined_goals_about_same_object(tasks)
    places, parts = _find_location_relations_and_part_relations(domain, states)
    several = {kind for task in tasks for kind, number in _count_categories(task).items() if number > 1}
    return UsualGoalsOfDataSet(
        patterns=patterns,
        goal_counts=wanted,
        themes=_find_usual_goals_by_title(tasks, sound),
        shape_counts=_compute_weights_for_drawing_formula_types(forms) if is_plain else forms,
        pair_patterns=frozenset(
            [pattern for formula, pattern, _ in asked if isinstance(formula, f.ForPairs)]
        ),
        nestings=frozenset(nestings),
        combinations=frozenset(combinations),
        dependent_states=frozenset(needy),
        action_counts=Counter(
            [list_actions_that_meet_goal(goal) for goal in goals if goal.kind is GoalKind.ACTION]
        ),
        operators=frozenset([action.operator for action, _ in done]),
        uses=kinds,
        taken_categories=frozenset(
            [kind for operator, _, kind in kinds if roles[operator] is OperatorRole.TAKES]
        ),
        used_categories=frozenset(
            [kind for operator, _, kind in kinds if roles[operator] not in _APPROACH_ROLES]
        ),
        place_relations=places,
        part_relations=parts,
        countable_categories=frozenset(several if is_plain else ()),
        part_categories=frozenset(_find_categories_of_object_parts(states, parts)),
        holding_predicate_names=frozenset(_find_predicates_of_held_objects(domain)),
        unique_states=frozenset(
            [
                predicate.name
                for predicate in domain.vocabulary.predicates
                if predicate.arity == 1 and not predicate.static
                if states and all(state.mask(predicate.name).bit_count() == 1 for state in states)
            ]
        ),
    )


def _get_type_name_of_goal_formula(goal: Goal) -> str:
    return "Occurs" if goal.kind is GoalKind.ACTION else type(goal.formula).__name__


def _yield_goals_with_literal_patterns(task: Task) -> Iterator[tuple[f.Formula, LiteralPattern]]:
    """Yield pairs: a goal about states, and the pattern of one of its literals.

    A pattern is a literal with categories in place of objects.
    """
    for goal in task.goals:
        if goal.kind is not GoalKind.ACTION:
            yield from ((goal.formula, pattern) for pattern in find_patterns(goal.formula, task.scene))


def _compute_weights_for_drawing_goal_patterns(
    tasks: Sequence[Task], executions: Sequence[Trajectory], fact_listers: Sequence[FactLister]
) -> defaultdict[LiteralPattern, float]:
    """Return a mapping from patterns to weights, for drawing random goals.

    A pattern is a literal with categories in place of objects. The weight of a pattern is the sum of these
    numbers:

    - `_GOAL_WEIGHT` for each goal with this pattern,
    - `_EFFECT_WEIGHT` for each task whose plan has an effect with this pattern,
    - `_FACT_WEIGHT` if a task has an initial fact with this pattern. Facts of a relation do not count if the
      relation has too many facts to state places (`_count_facts_beyond_place_relation_limit`).
    """
    weights: defaultdict[LiteralPattern, float] = defaultdict(float)
    initial_patterns: dict[LiteralPattern, None] = {}
    crowds: Counter[str] = Counter()
    for task, course in zip(tasks, executions, strict=True):
        objects = _find_mentioned_or_used_objects(task)
        before = _collect_patterns_of_facts_in_state(task.initial, objects, fact_listers)
        initial_patterns |= before
        crowds.update(_count_facts_beyond_place_relation_limit(task.initial, objects, fact_listers))
        afterwards = [course.final_state, *([] if task.annotated_final is None else [task.annotated_final])]
        came_about = [
            _find_changed_patterns(before, _collect_patterns_of_facts_in_state(state, objects, fact_listers))
            for state in afterwards
        ]
        for pattern in dict.fromkeys(chain(*came_about)):
            weights[pattern] += _EFFECT_WEIGHT
        for _, pattern in _yield_goals_with_literal_patterns(task):
            weights[pattern] += _GOAL_WEIGHT
    for pattern in initial_patterns:
        weights[pattern] += _FACT_WEIGHT if crowds[pattern.predicate] <= 0 else 0.0
    return weights


_Triples: TypeAlias = set[tuple[str, str, str]]


def _find_combined_goals_about_same_object(
    tasks: Iterable[Task],
) -> tuple[_Triples, _Triples, set[tuple[str, str]]]:
    """Return which combinations of two goals about one object occur in tasks.

    The attributes `nestings`, `combinations` and `dependent_states` of `UsualGoalsOfDataSet` explain the
    three results.
    """
    nestings, combinations = _Triples(), _Triples()
    alone, accompanied = Counter[tuple[str, str]](), Counter[tuple[str, str]]()
    for task in tasks:
        wanted = {p for goal in task.goals for p in find_patterns(goal.formula, task.scene)}
        states = [p for p in wanted if len(p.categories) == 1]
        relations = [p for p in wanted if len(p.categories) == 2]
        for (relation, (_, thing), _), (place, (moved, _), _) in product(relations, repeat=2):
            if thing == moved:
                nestings.add((relation, thing, place))
        for (state, (thing,), _), (relation, (moved, place), _) in product(states, relations):
            if thing == moved:
                combinations.add((state, relation, place))
        for state, (thing,), _ in (p for p in states if p.truth):
            served = any(thing == place for _, (_, place), _ in relations)
            (accompanied if served else alone)[state, thing] += 1
    return nestings, combinations, {key for key, n in accompanied.items() if n > 1 and not alone[key]}


def _count_categories(task: Task) -> Counter[str]:
    """Return a mapping from categories to the number of objects that a task mentions or its plan uses."""
    return Counter([task.scene.objects[i].category for i in _find_mentioned_or_used_objects(task)])


def _find_usual_goals_by_title(
    tasks: Iterable[Task], usual_patterns: Patterns
) -> dict[str, UsualGoalsOfTaskTitle]:
    themes = {}
    for title, alike in group_pairs((task.title, task) for task in tasks).items():
        shown = Counter(chain.from_iterable(map(_count_categories, alike)))
        needed = {
            task.scene.objects[i].category for task in alike for i in find_objects_of_goals_and_plan(task)
        }
        about = needed.union(kind for kind, number in shown.items() if 2 * number > len(alike))
        themes[title] = UsualGoalsOfTaskTitle(
            frozenset(about),
            Counter(map(_find_goal_patterns_about_agent, alike)),
            restrict_to_categories(usual_patterns, about),
        )
    return themes


def _compute_weights_for_drawing_formula_types(counts_by_formula_type: Counter[str]) -> Mapping[str, int]:
    """Return the weight of each shape of goals (formula class) for drawing goals at random.

    The caller uses these weights only if the data set has no quantified goals. `_WEIGHTS_OF_SHAPES` gives
    quantifiers to new goals. The share of goals that ask for actions stays as in the data set.
    """
    states = counts_by_formula_type.total() - counts_by_formula_type["Occurs"]
    shares = sum(_WEIGHTS_OF_SHAPES.values())
    varied = {form: states * share for form, share in _WEIGHTS_OF_SHAPES.items()}
    if counts_by_formula_type["Occurs"]:
        return {**varied, "Occurs": counts_by_formula_type["Occurs"] * shares}
    return varied


def _cut_plan_at_error(plan: Sequence[Action], domain: Domain) -> list[Action]:
    """Return the steps of a plan before the first with an unknown operator or a wrong number of objects."""
    kept = []
    for action in plan:
        if domain.operator_arities.get(action.operator) != len(action.arguments):
            break
        kept.append(action)
    return kept


def _find_mentioned_or_used_objects(task: Task) -> list[int]:
    """Return the indices of the objects that a task mentions or its plan uses."""
    used = (i for action in task.script for i in action.arguments)
    return list(dict.fromkeys((*list_objects_in_prompt(task), *used)))


def _collect_patterns_of_facts_in_state(
    state: State, objects: Sequence[int], fact_listers: Iterable[FactLister]
) -> dict[LiteralPattern, None]:
    """Return a state's facts that goals can mention, as patterns: categories replace objects.

    Each pattern occurs once.
    """
    things = state.scene.objects
    return {
        LiteralPattern(fact.predicate, tuple([things[i].category for i in fact.arguments]), True): None
        for listing in fact_listers
        for fact in listing.list_facts(state, objects)
    }


def _count_facts_beyond_place_relation_limit(
    state: State, objects: Sequence[int], fact_listers: Iterable[FactLister]
) -> Counter[str]:
    """Return the number of facts of each relation minus the maximum of a relation that states places.

    Such a relation, for example *inside*, relates an object to few others. The maximum is
    `MAX_MEAN_PLACES_PER_OBJECT` times the number of objects that are the first argument of a fact.
    """
    crowds: Counter[str] = Counter()
    for listing in fact_listers:
        pairs = [fact.arguments for fact in listing.list_facts(state, objects) if len(fact.arguments) == 2]
        crowds[listing.predicate] = round(
            len(pairs) - MAX_MEAN_PLACES_PER_OBJECT * len({source for source, _ in pairs})
        )
    return crowds


def _find_goal_patterns_about_agent(task: Task) -> tuple[LiteralPattern, ...]:
    patterns = [p for goal in task.goals for p in find_patterns(goal.formula, task.scene)]
    return tuple(dict.fromkeys([pattern for pattern in patterns if _is_about_agent(pattern, task.scene)]))


def _is_about_agent(pattern: LiteralPattern, scene: Scene) -> bool:
    return scene.agent is not None and scene.objects[scene.agent].category in pattern.categories


def _find_changed_patterns(
    before: Mapping[LiteralPattern, None], after: Mapping[LiteralPattern, None]
) -> Iterator[LiteralPattern]:
    """Yield facts that became true and negations of facts that became false, with categories for objects."""
    yield from (pattern for pattern in after if pattern not in before)
    yield from (pattern._replace(truth=False) for pattern in before if pattern not in after)


def _combine_predicates_with_all_categories(
    signed_predicates: Iterable[tuple[str, bool]], states: Sequence[State]
) -> Iterator[LiteralPattern]:
    """Yield a pattern (form of goal) for every combination of a predicate, its truth value and categories.

    If the data set has no plans, these patterns replace the patterns of the data set's goals.
    """
    for state in states:
        categories = dict.fromkeys(thing.category for thing in state.scene.objects)
        for predicate, truth in signed_predicates:
            arity = state.scene.vocabulary.find_arity(predicate) or 0
            yield from (
                LiteralPattern(predicate, chosen, truth) for chosen in product(categories, repeat=arity)
            )


def _find_location_relations_and_part_relations(
    domain: Domain, states: Sequence[State]
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return two lists of relations: relations that state places, and relations of parts to wholes.

    Actions can change a place, but not a part. A relation of the first kind relates an object to at most
    `MAX_MEAN_PLACES_PER_OBJECT` objects on average, a relation of the second kind to exactly one object.
    """
    places, parts = [], []
    for predicate in domain.vocabulary.predicates:
        if predicate.arity == 2 and predicate.visible:
            relations = [state.relation(predicate.name) for state in states]
            pairs = sum([len(relation) for relation in relations])
            sources = sum([relation.sources.bit_count() for relation in relations])
            if not predicate.static and pairs <= MAX_MEAN_PLACES_PER_OBJECT * sources:
                places.append(predicate.name)
            if predicate.static and pairs == sources:
                parts.append(predicate.name)
    return tuple(places), tuple(parts)


def _find_categories_of_object_parts(states: Sequence[State], part_relations: Sequence[str]) -> Iterator[str]:
    for state in states:
        for name in part_relations:
            yield from (state.scene.objects[i].category for i in iterate_bits(state.relation(name).sources))


def _find_predicates_of_held_objects(domain: Domain) -> Iterator[str]:
    """Yield predicates, such as "holding", that only operators for taking an object make true."""
    taking = [
        operator for operator in domain.operators if infer_operator_role(operator) is OperatorRole.TAKES
    ]
    others = {
        schema.atom.predicate
        for operator in domain.operators
        if operator not in taking
        for schema in make_effect_schemas(operator)
        if schema.adds
    }
    for operator in taking:
        for schema in make_effect_schemas(operator):
            if schema.adds and schema.atom.predicate not in others:
                yield schema.atom.predicate
