"""The census of a benchmark: how its world is used in its own goals, states and plans, by category of object.

Nothing here is declared: it is counted. A declaration allows more than anybody does: to wash anything, to put
books into sinks. Certificates are found in the world as it is used, a copy of the domain in which each
operator also asks of each argument that it be usual; operators that no plan uses are left out.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import chain, product

import eai.logic.formula as f
from eai.abilities.goal_test import alternatives
from eai.abilities.protocol import Ability
from eai.abilities.task import GoalKind, Task
from eai.abilities.wording import subjects
from eai.benchmark.benchmark import Benchmark
from eai.data.grouping import grouped
from eai.generator.measures import needed_by
from eai.generator.prior import Pattern, Patterns, Prior, Theme, Use, kept, kinds_of, narrowed, patterns_of
from eai.planning.effect_schema import effect_schemas
from eai.planning.role import role_of
from eai.world.domain import Domain
from eai.world.execution import Action, execute
from eai.world.listing import Listing
from eai.world.operator import Operator, Role, affordance
from eai.world.relation import bits
from eai.world.state import Fact, Scene, State
from eai.world.vocabulary import Predicate, Vocabulary


class Usage:
    """A domain restricted to what is usual; unrestricted if the data set has no plans to learn it from.

    Attributes:
        domain: the restricted domain.
    """

    def __init__(self, domain: Domain, prior: Prior) -> None:
        self.domain, self._original = domain, domain.vocabulary
        self._kinds = grouped((_usual(name, place), kind) for name, place, kind in sorted(prior.kinds))
        if self._kinds:
            vocabulary = Vocabulary((*self._original.predicates, *self._kinds), self._original.derived)
            used = [operator for operator in domain.operators if operator.name in prior.operators]
            self.domain = replace(domain, vocabulary=vocabulary, operators=tuple(map(_restricted, used)))

    def state(self, scene: Scene, facts: Iterable[Fact]) -> State:
        """A state of the restricted domain about the objects of a scene."""
        own = Scene(self.domain.vocabulary, scene.objects, scene.agent)
        return own.state((*self._known(facts), *self._added(own)))

    def original(self, state: State) -> State:
        """A state of the restricted domain as one of the declared domain, which begins an episode."""
        scene = Scene(self._original, state.scene.objects, state.scene.agent)
        return scene.state(self._known(state.facts()))

    def _known(self, facts: Iterable[Fact]) -> Iterator[Fact]:
        return (fact for fact in facts if self._original.stored(fact.predicate) is not None)

    def _added(self, scene: Scene) -> Iterator[Fact]:
        for predicate, kinds in self._kinds.items():
            for kind in kinds:
                yield from (Fact(predicate.name, (i,)) for i in bits(scene.category(kind)))


def _usual(operator: str, place: int) -> Predicate:
    """The predicate of objects that are usual as an argument of an operator."""
    return Predicate(f"usual {operator} {place}", 1, static=True)


def _restricted(operator: Operator) -> Operator:
    """The operator, which also asks of each argument that it be usual."""
    checks = [
        affordance(_usual(operator.name, place)(parameter), f"{{{parameter.name}}} is unusual")
        for place, parameter in enumerate(operator.parameters)
    ]
    return replace(operator, checks=(*checks, *operator.checks))


FEW_TARGETS = 1.5
"""Up to so many targets on average, a relation says where a thing is; a thing is next to many others."""

_QUANTIFIED = ("ForAll", "Exists", "Exactly", "ForPairs")
_WHERE_ALL_ARE_PLAIN = {"Atom": 2, "ForAll": 6, "Exactly": 4, "Exists": 3}
"""How often each shape is proposed where the data set has no quantified goals, which tell nothing of that."""

_AS_GOAL, _AS_EFFECT, _AS_FOUND = 4.0, 1.0, 0.05
"""The weights of something that is a goal, is brought about by a plan, or is so in a scene."""


def prior_of(benchmark: Benchmark, tasks: Iterable[Task]) -> Prior:
    """Count what is usual in the tasks of a benchmark."""
    census = _Census(benchmark)
    for task in tasks:
        census.count(task)
    return census.prior()


class _Census:
    """The counts, task by task."""

    def __init__(self, benchmark: Benchmark) -> None:
        self._domain, self._english = benchmark.domain, benchmark.english
        self._listings = benchmark.wording(Ability.ACTION_SEQUENCING).listings
        self._weights: defaultdict[Pattern, float] = defaultdict(float)
        self._wanted: Counter[tuple[str, bool]] = Counter()
        self._forms: Counter[str] = Counter()
        self._paired: dict[Pattern, None] = {}
        self._nestings: dict[tuple[str, str, str], None] = {}
        self._combinations: dict[tuple[str, str, str], None] = {}
        self._alone: Counter[tuple[str, str]] = Counter()
        self._accompanied: Counter[tuple[str, str]] = Counter()
        self._actions: Counter[tuple[str, ...]] = Counter()
        self._found: dict[Pattern, None] = {}
        self._crowds: Counter[str] = Counter()
        self._kinds: dict[Use, None] = {}
        self._operators: dict[str, None] = {}
        self._tasks: list[Task] = []

    def count(self, task: Task) -> None:
        """Take a task into account."""
        self._tasks.append(task)
        self._count_plan(task)
        self._count_pairs({p for goal in task.goals for p in patterns_of(goal.formula, task.scene)})
        for goal in task.goals:
            if goal.kind is GoalKind.ACTION:
                self._actions[alternatives(goal)] += 1
                self._forms["Occurs"] += 1
                continue
            self._forms[type(goal.formula).__name__] += 1
            wanted = list(patterns_of(goal.formula, task.scene))
            if isinstance(goal.formula, f.ForPairs):
                self._paired |= dict.fromkeys(wanted)
            for pattern in wanted:
                self._weights[pattern] += _AS_GOAL
                if not _is_of_agent(pattern, task.scene):
                    self._wanted[pattern.predicate, pattern.truth] += 1

    def _count_pairs(self, wanted: Collection[Pattern]) -> None:
        """Take into account what the goals of a task want together."""
        states = [p for p in wanted if len(p.categories) == 1]
        relations = [p for p in wanted if len(p.categories) == 2]
        for (relation, (_, thing), _), (place, (moved, _), _) in product(relations, repeat=2):
            if thing == moved:
                self._nestings[relation, thing, place] = None
        for (state, (thing,), _), (relation, (moved, place), _) in product(states, relations):
            if thing == moved:
                self._combinations[state, relation, place] = None
        for state, (thing,), _ in (p for p in states if p.truth):
            served = any(thing == place for _, (_, place), _ in relations)
            (self._accompanied if served else self._alone)[state, thing] += 1

    def _count_plan(self, task: Task) -> None:
        trajectory = execute(self._domain, task.initial, _sound(task.script, self._domain))
        objects = _concerned(task)
        before = _facts(task.initial, objects, self._listings)
        self._found |= before
        self._crowds.update(_crowds(task.initial, objects, self._listings))
        afterwards = [trajectory.final, *([] if task.annotated_final is None else [task.annotated_final])]
        came_about = [_changes(before, _facts(state, objects, self._listings)) for state in afterwards]
        for pattern in dict.fromkeys(chain(*came_about)):
            self._weights[pattern] += _AS_EFFECT
        for action in trajectory.executed:
            self._operators[action.operator] = None
            self._kinds.update(dict.fromkeys(kinds_of(action, task.scene)))

    def _is_odd(self, pattern: Pattern) -> bool:
        """Whether nobody would ask for it; that something odd be not so is sound."""
        return pattern.truth and self._english.is_odd(pattern.predicate, pattern.categories)

    def prior(self) -> Prior:
        """The prior that all tasks so far give."""
        states = [task.initial for task in self._tasks]
        several = {kind for task in self._tasks for kind, number in _shown(task).items() if number > 1}
        for pattern in self._found:
            self._weights[pattern] += _AS_FOUND if self._crowds[pattern.predicate] <= 0 else 0.0
        if not self._kinds:
            self._wanted.update(product([each.predicate for each in self._listings], (True, False)))
            for pattern in _conceivable(self._wanted, states):
                self._weights[pattern] += _AS_FOUND
        places, parts = _relations(self._domain, states)
        is_plain = not any(self._forms[form] for form in _QUANTIFIED)
        patterns: dict[tuple[str, bool], dict[Pattern, float]] = {}
        for pattern, weight in self._weights.items():
            if weight > 0 and (pattern.predicate, pattern.truth) in self._wanted:
                patterns.setdefault((pattern.predicate, pattern.truth), {})[pattern] = weight
        sound = kept(patterns, lambda pattern: not self._is_odd(pattern))
        roles = {operator.name: role_of(operator) for operator in self._domain.operators}
        going = (Role.TAKES, Role.MOVEMENT)
        return Prior(
            patterns=patterns,
            wanted=self._wanted,
            themes=_themes(self._tasks, sound),
            forms=_varied(self._forms) if is_plain else self._forms,
            paired=frozenset(self._paired),
            nestings=frozenset(self._nestings),
            combinations=frozenset(self._combinations),
            needy=frozenset(key for key, n in self._accompanied.items() if n > 1 and not self._alone[key]),
            actions=self._actions,
            operators=frozenset(self._operators),
            kinds=frozenset(self._kinds),
            taken=frozenset({kind for operator, _, kind in self._kinds if roles[operator] is Role.TAKES}),
            used=frozenset({kind for operator, _, kind in self._kinds if roles[operator] not in going}),
            places=places,
            parts=parts,
            several=frozenset(several if is_plain else ()),
            pieces=frozenset(_pieces(states, parts)),
            holding=frozenset(_holding(self._domain)),
        )


def _shown(task: Task) -> Counter[str]:
    """How many things of each category a task speaks of, or its plan uses."""
    return Counter([task.scene.objects[i].category for i in _concerned(task)])


def _themes(tasks: Iterable[Task], usual: Patterns) -> dict[str, Theme]:
    """The theme of each title: the categories that some of its tasks need, and that most of them show."""
    themes = {}
    for title, alike in grouped((task.title, task) for task in tasks).items():
        shown = Counter(chain.from_iterable(map(_shown, alike)))
        needed = {task.scene.objects[i].category for task in alike for i in needed_by(task)}
        about = needed.union(kind for kind, number in shown.items() if 2 * number > len(alike))
        themes[title] = Theme(frozenset(about), Counter(map(_ending, alike)), narrowed(usual, about))
    return themes


def _varied(forms: Counter[str]) -> Mapping[str, int]:
    """Shapes of goals where the data set's are all plain; goals for actions are as frequent as they were."""
    states, shares = forms.total() - forms["Occurs"], sum(_WHERE_ALL_ARE_PLAIN.values())
    varied = {form: states * share for form, share in _WHERE_ALL_ARE_PLAIN.items()}
    return {**varied, "Occurs": forms["Occurs"] * shares} if forms["Occurs"] else varied


def _sound(plan: Sequence[Action], domain: Domain) -> list[Action]:
    """A plan up to its first step that names no operator of the domain, or too few objects."""
    kept = []
    for action in plan:
        if domain.arities.get(action.operator) != len(action.arguments):
            break
        kept.append(action)
    return kept


def _concerned(task: Task) -> list[int]:
    """The objects that a task speaks of or its plan uses."""
    used = (i for action in task.script for i in action.arguments)
    return list(dict.fromkeys((*subjects(task), *used)))


def _facts(state: State, objects: Sequence[int], listings: Iterable[Listing]) -> dict[Pattern, None]:
    """The patterns of all that goals could say and that holds, each once."""
    things = state.scene.objects
    return {
        Pattern(fact.predicate, tuple([things[i].category for i in fact.arguments]), True): None
        for each in listings
        for fact in each.facts(state, objects)
    }


def _crowds(state: State, objects: Sequence[int], listings: Iterable[Listing]) -> Counter[str]:
    """By relation, how many pairs of it there are beyond those of a thing with few others."""
    crowds: Counter[str] = Counter()
    for each in listings:
        pairs = [fact.arguments for fact in each.facts(state, objects) if len(fact.arguments) == 2]
        crowds[each.predicate] = round(len(pairs) - FEW_TARGETS * len({source for source, _ in pairs}))
    return crowds


def _ending(task: Task) -> tuple[Pattern, ...]:
    """The patterns of the goals of a task about the agent."""
    patterns = [p for goal in task.goals for p in patterns_of(goal.formula, task.scene)]
    return tuple(dict.fromkeys([pattern for pattern in patterns if _is_of_agent(pattern, task.scene)]))


def _is_of_agent(pattern: Pattern, scene: Scene) -> bool:
    """Whether a pattern says something of the agent."""
    return scene.agent is not None and scene.objects[scene.agent].category in pattern.categories


def _changes(before: Mapping[Pattern, None], after: Mapping[Pattern, None]) -> Iterator[Pattern]:
    """The patterns that came about, and those that came to an end."""
    yield from (pattern for pattern in after if pattern not in before)
    yield from (pattern._replace(truth=False) for pattern in before if pattern not in after)


def _conceivable(wanted: Iterable[tuple[str, bool]], states: Sequence[State]) -> Iterator[Pattern]:
    """For a data set without plans, from which nothing is known to be odd: everything."""
    for state in states:
        categories = dict.fromkeys(thing.category for thing in state.scene.objects)
        for predicate, truth in wanted:
            arity = state.scene.vocabulary.arity(predicate) or 0
            yield from (Pattern(predicate, chosen, truth) for chosen in product(categories, repeat=arity))


def _relations(domain: Domain, states: Sequence[State]) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """The relations that say where things are, and those of parts, by how many targets a thing has."""
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
    """The categories of what is a part of something."""
    for state in states:
        for name in parts:
            yield from (state.scene.objects[i].category for i in bits(state.relation(name).sources))


def _holding(domain: Domain) -> Iterator[str]:
    """The predicates that taking a thing adds and no other action does."""
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
