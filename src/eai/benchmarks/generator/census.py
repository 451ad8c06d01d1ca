"""The census of a benchmark: counts of goals, states and plans by category, from which its prior follows.

A domain allows many actions that are unusual, such as washing a book. Certificates therefore use a copy of
the domain. In the copy, operators have a precondition that each argument is usual, and unused operators are
left out.
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
from eai.benchmarks.generator.measures import needed_by
from eai.benchmarks.generator.prior import (
    Pattern,
    Patterns,
    Prior,
    Theme,
    kept,
    kinds_of,
    narrowed,
    patterns_of,
)
from eai.planning.effect_schema import effect_schemas
from eai.planning.role import role_of
from eai.tasks.goal_test import alternatives
from eai.tasks.task import Goal, GoalKind, Task
from eai.tasks.wording import subjects
from eai.world.action import Action
from eai.world.domain import Domain
from eai.world.execution import Trajectory, execute
from eai.world.listing import FactListing
from eai.world.operator import Operator, Role, affordance
from eai.world.relation import bits
from eai.world.state import Fact, Scene, State
from eai.world.vocabulary import Predicate, Vocabulary


class Usage:
    """A domain restricted to usual actions; unrestricted if the data set has no plans.

    Attributes:
        domain: the restricted domain.
    """

    def __init__(self, domain: Domain, prior: Prior) -> None:
        self.domain, self._original = domain, domain.vocabulary
        self._kinds = group_pairs((_usual(name, place), kind) for name, place, kind in sorted(prior.kinds))
        if self._kinds:
            vocabulary = Vocabulary((*self._original.predicates, *self._kinds), self._original.derived)
            used = [operator for operator in domain.operators if operator.name in prior.operators]
            self.domain = replace(domain, vocabulary=vocabulary, operators=tuple(map(_restricted, used)))

    def state(self, scene: Scene, facts: Iterable[Fact]) -> State:
        """Return a state of the restricted domain with the objects of a scene."""
        own = Scene(self.domain.vocabulary, scene.objects, scene.agent)
        return own.state((*self._known(facts), *self._added(own)))

    def original(self, state: State) -> State:
        """Return a state of the restricted domain as a state of the declared domain."""
        scene = Scene(self._original, state.scene.objects, state.scene.agent)
        return scene.state(self._known(state.facts()))

    def _known(self, facts: Iterable[Fact]) -> Iterator[Fact]:
        return (fact for fact in facts if self._original.find_stored(fact.predicate) is not None)

    def _added(self, scene: Scene) -> Iterator[Fact]:
        for predicate, kinds in self._kinds.items():
            for kind in kinds:
                yield from (Fact(predicate.name, (i,)) for i in bits(scene.category(kind)))


def _usual(operator: str, place: int) -> Predicate:
    """Return the predicate of objects that are usual as an argument of an operator."""
    return Predicate(f"usual {operator} {place}", 1, static=True)


def _restricted(operator: Operator) -> Operator:
    checks = [
        affordance(_usual(operator.name, place)(parameter), f"{{{parameter.name}}} is unusual")
        for place, parameter in enumerate(operator.parameters)
    ]
    return replace(operator, checks=(*checks, *operator.checks))


FEW_TARGETS = 1.5
"""Maximum mean number of targets at which a relation says where an object is; "next to" has more."""

_QUANTIFIED = ("ForAll", "Exists", "Exactly", "ForPairs")
_WHERE_ALL_ARE_PLAIN = {"Atom": 2, "ForAll": 6, "Exactly": 4, "Exists": 3}
"""Weight of each goal shape, if the data set has no goals with quantifiers."""

_GOING = (Role.TAKES, Role.MOVEMENT)
"""Roles of operators that take or approach an object, but do not use it."""

_AS_GOAL, _AS_EFFECT, _AS_FOUND = 4.0, 1.0, 0.05
"""Weights of a fact that is a goal, that a plan brings about, or that holds in a scene."""


def prior_of(benchmark: Benchmark, tasks: Iterable[Task]) -> Prior:
    """Count the usual goals, places and actions in the tasks of a benchmark."""
    tasks, domain = list(tasks), benchmark.domain
    listings = benchmark.wording(Ability.ACTION_SEQUENCING).listings
    states = [task.initial for task in tasks]
    courses = [execute(domain, task.initial, _sound(task.script, domain)) for task in tasks]
    done = [(action, course.final.scene) for course in courses for action in course.executed]
    kinds = frozenset([use for action, scene in done for use in kinds_of(action, scene)])
    goals = [goal for task in tasks for goal in task.goals]
    forms = Counter([_form(goal) for goal in goals])
    is_plain = not any(forms[form] for form in _QUANTIFIED)
    asked = [(formula, pattern, task.scene) for task in tasks for formula, pattern in _asked(task)]
    wanted = Counter([(p.predicate, p.truth) for _, p, scene in asked if not _is_of_agent(p, scene)])
    weights = _weights(tasks, courses, listings)
    if not kinds:
        wanted.update(product([each.predicate for each in listings], (True, False)))
        for pattern in _conceivable(wanted, states):
            weights[pattern] += _AS_FOUND
    usual = (((p.predicate, p.truth), (p, weight)) for p, weight in weights.items() if weight > 0)
    patterns = {key: dict(known) for key, known in group_pairs(usual).items() if key in wanted}
    is_odd = benchmark.notation.english.is_odd  # the negation of an odd literal is not odd
    sound = kept(patterns, lambda p: not (p.truth and is_odd(p.predicate, p.categories)))
    roles = {operator.name: role_of(operator) for operator in domain.operators}
    nestings, combinations, needy = _wanted_together(tasks)
    places, parts = _relations(domain, states)
    several = {kind for task in tasks for kind, number in _shown(task).items() if number > 1}
    return Prior(
        patterns=patterns,
        wanted=wanted,
        themes=_themes(tasks, sound),
        forms=_varied(forms) if is_plain else forms,
        paired=frozenset([pattern for formula, pattern, _ in asked if isinstance(formula, f.ForPairs)]),
        nestings=frozenset(nestings),
        combinations=frozenset(combinations),
        needy=frozenset(needy),
        actions=Counter([alternatives(goal) for goal in goals if goal.kind is GoalKind.ACTION]),
        operators=frozenset([action.operator for action, _ in done]),
        kinds=kinds,
        taken=frozenset([kind for operator, _, kind in kinds if roles[operator] is Role.TAKES]),
        used=frozenset([kind for operator, _, kind in kinds if roles[operator] not in _GOING]),
        places=places,
        parts=parts,
        several=frozenset(several if is_plain else ()),
        pieces=frozenset(_pieces(states, parts)),
        holding=frozenset(_holding(domain)),
    )


def _form(goal: Goal) -> str:
    return "Occurs" if goal.kind is GoalKind.ACTION else type(goal.formula).__name__


def _asked(task: Task) -> Iterator[tuple[f.Formula, Pattern]]:
    """Yield each goal about states with each of its patterns."""
    for goal in task.goals:
        if goal.kind is not GoalKind.ACTION:
            yield from ((goal.formula, pattern) for pattern in patterns_of(goal.formula, task.scene))


def _weights(
    tasks: Sequence[Task], courses: Sequence[Trajectory], listings: Sequence[FactListing]
) -> defaultdict[Pattern, float]:
    """Return the weight of each pattern, given the executions of the tasks' plans."""
    weights: defaultdict[Pattern, float] = defaultdict(float)
    found: dict[Pattern, None] = {}
    crowds: Counter[str] = Counter()
    for task, course in zip(tasks, courses, strict=True):
        objects = _concerned(task)
        before = _facts(task.initial, objects, listings)
        found |= before
        crowds.update(_crowds(task.initial, objects, listings))
        afterwards = [course.final, *([] if task.annotated_final is None else [task.annotated_final])]
        came_about = [_changes(before, _facts(state, objects, listings)) for state in afterwards]
        for pattern in dict.fromkeys(chain(*came_about)):
            weights[pattern] += _AS_EFFECT
        for _, pattern in _asked(task):
            weights[pattern] += _AS_GOAL
    for pattern in found:
        weights[pattern] += _AS_FOUND if crowds[pattern.predicate] <= 0 else 0.0
    return weights


_Triples: TypeAlias = set[tuple[str, str, str]]


def _wanted_together(tasks: Iterable[Task]) -> tuple[_Triples, _Triples, set[tuple[str, str]]]:
    """Return the nestings, combinations and needy states (`Prior`) in the goals of tasks."""
    nestings, combinations = _Triples(), _Triples()
    alone, accompanied = Counter[tuple[str, str]](), Counter[tuple[str, str]]()
    for task in tasks:
        wanted = {p for goal in task.goals for p in patterns_of(goal.formula, task.scene)}
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


def _shown(task: Task) -> Counter[str]:
    """Return the number of objects of each category that a task mentions or its plan uses."""
    return Counter([task.scene.objects[i].category for i in _concerned(task)])


def _themes(tasks: Iterable[Task], usual: Patterns) -> dict[str, Theme]:
    themes = {}
    for title, alike in group_pairs((task.title, task) for task in tasks).items():
        shown = Counter(chain.from_iterable(map(_shown, alike)))
        needed = {task.scene.objects[i].category for task in alike for i in needed_by(task)}
        about = needed.union(kind for kind, number in shown.items() if 2 * number > len(alike))
        themes[title] = Theme(frozenset(about), Counter(map(_ending, alike)), narrowed(usual, about))
    return themes


def _varied(forms: Counter[str]) -> Mapping[str, int]:
    """Return weights of goal shapes for a data set with plain goals only; goals for actions keep theirs."""
    states, shares = forms.total() - forms["Occurs"], sum(_WHERE_ALL_ARE_PLAIN.values())
    varied = {form: states * share for form, share in _WHERE_ALL_ARE_PLAIN.items()}
    return {**varied, "Occurs": forms["Occurs"] * shares} if forms["Occurs"] else varied


def _sound(plan: Sequence[Action], domain: Domain) -> list[Action]:
    """Return a plan up to its first step with an unknown operator or a wrong number of objects."""
    kept = []
    for action in plan:
        if domain.arities.get(action.operator) != len(action.arguments):
            break
        kept.append(action)
    return kept


def _concerned(task: Task) -> list[int]:
    """Return the objects that a task mentions or its plan uses."""
    used = (i for action in task.script for i in action.arguments)
    return list(dict.fromkeys((*subjects(task), *used)))


def _facts(state: State, objects: Sequence[int], listings: Iterable[FactListing]) -> dict[Pattern, None]:
    """Return the patterns of the facts that hold and may be goals, each once."""
    things = state.scene.objects
    return {
        Pattern(fact.predicate, tuple([things[i].category for i in fact.arguments]), True): None
        for each in listings
        for fact in each.facts(state, objects)
    }


def _crowds(state: State, objects: Sequence[int], listings: Iterable[FactListing]) -> Counter[str]:
    """Return how many pairs each relation has above `FEW_TARGETS` for each source."""
    crowds: Counter[str] = Counter()
    for each in listings:
        pairs = [fact.arguments for fact in each.facts(state, objects) if len(fact.arguments) == 2]
        crowds[each.predicate] = round(len(pairs) - FEW_TARGETS * len({source for source, _ in pairs}))
    return crowds


def _ending(task: Task) -> tuple[Pattern, ...]:
    """Return the patterns of the goals about the agent."""
    patterns = [p for goal in task.goals for p in patterns_of(goal.formula, task.scene)]
    return tuple(dict.fromkeys([pattern for pattern in patterns if _is_of_agent(pattern, task.scene)]))


def _is_of_agent(pattern: Pattern, scene: Scene) -> bool:
    return scene.agent is not None and scene.objects[scene.agent].category in pattern.categories


def _changes(before: Mapping[Pattern, None], after: Mapping[Pattern, None]) -> Iterator[Pattern]:
    """Yield the patterns that became true, and those that became false."""
    yield from (pattern for pattern in after if pattern not in before)
    yield from (pattern._replace(truth=False) for pattern in before if pattern not in after)


def _conceivable(wanted: Iterable[tuple[str, bool]], states: Sequence[State]) -> Iterator[Pattern]:
    """Yield all patterns, for a data set whose plans do not show which are odd."""
    for state in states:
        categories = dict.fromkeys(thing.category for thing in state.scene.objects)
        for predicate, truth in wanted:
            arity = state.scene.vocabulary.arity(predicate) or 0
            yield from (Pattern(predicate, chosen, truth) for chosen in product(categories, repeat=arity))


def _relations(domain: Domain, states: Sequence[State]) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the relations that say where objects are, and those between part and whole.

    Both follow from the mean number of targets of an object.
    """
    places, parts = [], []
    for predicate in domain.vocabulary.predicates:
        if predicate.arity == 2 and predicate.visible:
            relations = [state.relation(predicate.name) for state in states]
            pairs = sum([len(relation) for relation in relations])
            sources = sum([relation.sources.bit_count() for relation in relations])
            if not predicate.static and pairs <= FEW_TARGETS * sources:
                places.append(predicate.name)
            if predicate.static and pairs == sources:
                parts.append(predicate.name)
    return tuple(places), tuple(parts)


def _pieces(states: Sequence[State], parts: Sequence[str]) -> Iterator[str]:
    for state in states:
        for name in parts:
            yield from (state.scene.objects[i].category for i in bits(state.relation(name).sources))


def _holding(domain: Domain) -> Iterator[str]:
    """Yield the predicates that only actions of taking an object add."""
    taking = [operator for operator in domain.operators if role_of(operator) is Role.TAKES]
    others = {
        schema.atom.predicate
        for operator in domain.operators
        if operator not in taking
        for schema in effect_schemas(operator)
        if schema.adds
    }
    for operator in taking:
        for schema in effect_schemas(operator):
            if schema.adds and schema.atom.predicate not in others:
                yield schema.atom.predicate
