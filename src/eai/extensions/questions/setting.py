"""The settings of questions: a task's world cut down to what is shown, its rules, and a way through it.

The rules of a domain are what its actions need and do, in words and formulas, exactly as they are declared.
An `Item` is what a question is made of before it is put into words in one of its forms.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Collection, Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import takewhile
from typing import TypeAlias, TypeVar

import eai.logic.formula as f
from eai.abilities.reports import action_text, fact_text
from eai.base.grouping import group_pairs
from eai.benchmarks.generator.scene import with_only
from eai.extensions.questions.question import Accept
from eai.logic.traversal import object_names
from eai.planning.planner import Planner
from eai.planning.search import Limits
from eai.tasks.planning import find_plan
from eai.tasks.rules import Rules
from eai.tasks.task import GoalKind, Task
from eai.tasks.wording import subjects
from eai.world.action import Action
from eai.world.domain import Domain
from eai.world.execution import execute
from eai.world.fault import FaultKind
from eai.world.state import Fact, Scene, State, compare_states

_STEPS = 24
"""The longest plan that questions are about."""

_WALK = 6
"""How many actions are taken at random where a task has no plan."""

_TRIES = 40
"""How often an action is drawn at random before it is given up."""

_ABSURD = 0.25
"""How often an action is taken for an impossible one that its objects are not made for."""

_LIMITS = Limits(60)

K = TypeVar("K", bound=Hashable)
T = TypeVar("T")


@dataclass(frozen=True)
class Setting:
    """The material of the questions about one task.

    Attributes:
        task: the task, in a scene that has what is shown and nothing else.
        rules: what can be shown of the domain.
        way: actions that can be carried out one after the other from the start of the task.
        states: the states along the way, one more than actions.
        seed: of what is chosen once for all questions about the task.
        repertoires: what some actions lead to, by number, as far as it was asked for; None if to too much.
    """

    task: Task
    rules: Rules
    way: tuple[Action, ...]
    states: tuple[State, ...]
    seed: str
    repertoires: dict[int, Repertoire | None] = field(default_factory=dict, compare=False, repr=False)

    @property
    def domain(self) -> Domain:
        """The declaration."""
        return self.rules.domain

    @property
    def scene(self) -> Scene:
        """All objects there are."""
        return self.task.scene

    @cached_property
    def goals(self) -> tuple[f.Formula, ...]:
        """The goals of the task at the end."""
        return tuple([goal.formula for goal in self.task.goals])

    @cached_property
    def works(self) -> bool:
        """Whether the way reaches all goals, and there are some that do not hold at the start."""
        return not all(self.reached(self.states[0])) and all(self.reached(self.states[-1]))

    @cached_property
    def things(self) -> tuple[int, ...]:
        """All objects but the agent."""
        return tuple([i for i in range(len(self.scene.objects)) if i != self.scene.agent])

    def after(self, state: State, action: Action) -> State | None:
        """The state after an action; None where one of its requirements is not met."""
        operator = self.domain.compiled[action.operator]
        binding = operator.bind(state, action.arguments)
        return operator.apply(state, binding) if operator.is_possible(state, binding) else None

    def failing(self, state: State, action: Action) -> tuple[int, ...]:
        """The requirements of an action that are not met, by number from 1."""
        operator = self.domain.compiled[action.operator]
        binding = operator.bind(state, action.arguments)
        return tuple([n for n, check in enumerate(operator.checks, 1) if not check.holds(state, binding)])

    def reached(self, state: State) -> tuple[bool, ...]:
        """Of each goal whether it holds."""
        return tuple([self.rules.readings.holds(goal, {}, state) for goal in self.goals])

    def added(self, before: State, after: State) -> list[Fact]:
        """The facts that hold in one state and not in another, of those that can change and be shown."""
        return [fact for fact in compare_states(before, after).added if fact.predicate in self.rules.fluents]

    def changes(self, before: State, after: State) -> tuple[str, ...]:
        """The difference of one state from another, as ``lit(lamp)`` and ``not lit(lamp)``."""
        removed = [f"not {self.text_of(fact)}" for fact in self.added(after, before)]
        return (*self.texts(self.added(before, after)), *removed)

    def alike(self, one: State, other: State) -> bool:
        """Whether two states are the same, as far as can be shown."""
        return not self.added(one, other) and not self.added(other, one)

    def facts(self, state: State) -> list[Fact]:
        """The facts of a state that can change."""
        return [fact for fact in state.facts() if fact.predicate in self.rules.fluents]

    def text_of(self, what: Fact | Action) -> str:
        """A fact or an action as text."""
        return action_text(what, self.scene) if isinstance(what, Action) else fact_text(what, self.scene)

    def texts(self, those: Iterable[Fact] | Iterable[Action]) -> list[str]:
        """The text of each of some facts or actions."""
        return list(map(self.text_of, those))

    def some_action(
        self, rng: random.Random, state: State, *, possible: bool, operators: Sequence[str] = ()
    ) -> Action | None:
        """An action on different things at random, by each operator (or of these) equally often; or None."""
        among = [each for each in self.rules.operators if each.name in operators] or self.rules.operators
        for _ in range(_TRIES):
            operator = rng.choice(among)
            arguments = tuple(rng.sample(self.things, min(operator.arity, len(self.things))))
            action = Action(operator.name, arguments)
            if len(arguments) < operator.arity or (self.after(state, action) is not None) is not possible:
                continue
            if possible or not self._is_absurd(state, action) or rng.random() < _ABSURD:
                return action
        return None

    def _is_absurd(self, state: State, action: Action) -> bool:
        """Whether an action will never be possible, as its objects are not made for it."""
        checks = self.domain.compiled[action.operator].operator.checks
        return any(checks[n - 1].fault is FaultKind.AFFORDANCE for n in self.failing(state, action))


def open_setting(task: Task, rules: Rules, planner: Planner, seed: str) -> Setting:
    """The setting of a task.

    The way is its own plan, as far as that can be carried out where there is nothing but what is shown; a
    plan that search finds, where it has none; or else some actions taken at random.
    """
    closed, rng = _closed(task), random.Random(seed)  # noqa: S311 - chance, not secrets
    plan = closed.script or _search_plan(closed, planner)
    way = _executed(closed, rules, plan) or _wandering(closed, rules, rng)
    return Setting(closed, rules, way, execute(rules.domain, closed.initial, way).states, seed)


def _closed(task: Task) -> Task:
    """The task where nothing exists but what a prompt shows and its own plan uses, without action goals."""
    named = [i for action in task.script for i in action.arguments]
    kept = sorted({*subjects(task), *named})
    number = {index: i for i, index in enumerate(kept)}
    initial = with_only(task.initial, kept)
    conditions = [goal for goal in task.goals if goal.kind is not GoalKind.ACTION]
    goals = [goal for goal in conditions if set(object_names(goal.formula)) <= initial.scene.index.keys()]
    return Task(
        task.id,
        task.title,
        task.instruction,
        initial,
        tuple(goals),
        tuple(range(len(kept))),
        tuple([Action(name, tuple([number[i] for i in among])) for name, among in task.script]),
    )


def _executed(task: Task, rules: Rules, plan: Sequence[Action]) -> tuple[Action, ...]:
    """The steps of a plan that are executed without needless ones, as far as they can be shown."""
    arities = rules.domain.arities
    known = takewhile(lambda action: arities.get(action.operator) == len(action.arguments), plan)
    executed = execute(rules.domain, task.initial, known).executed
    return tuple(takewhile(lambda action: action.operator in rules.names, executed))[:_STEPS]


def _search_plan(task: Task, planner: Planner) -> Sequence[Action]:
    """A plan that search finds; nothing where there are no goals, or where one looks out of reach."""
    goals = [goal.formula for goal in task.goals]
    if goals and all(planner.looks_reachable(task.initial, goal, task.planned_with) for goal in goals):
        return find_plan(task, planner, _LIMITS).plan
    return ()


def _wandering(task: Task, rules: Rules, rng: random.Random) -> tuple[Action, ...]:
    """Some actions taken at random."""
    setting, taken, state = Setting(task, rules, (), (), ""), list[Action](), task.initial
    for _ in range(_WALK):
        action = setting.some_action(rng, state, possible=True)
        if action is not None and (after := setting.after(state, action)) is not None:
            taken.append(action)
            state = after
    return tuple(taken)


@dataclass(frozen=True)
class Repertoire:
    """Some actions, each of which may be taken as often as one likes, and everything they lead to.

    It is exhausted, so that what is out of reach is proved to be.

    Attributes:
        actions: the actions.
        states: every state that can be reached, the start first, nearer ones before farther ones.
        edges: for every state the actions that are possible in it, each with the state that it leads to; both
            by number.
        depths: for every state how many actions it takes to get there.
        gained: for every state the facts that hold in it and not at the start.
    """

    actions: tuple[Action, ...]
    states: tuple[State, ...]
    edges: tuple[tuple[tuple[int, int], ...], ...]
    depths: tuple[int, ...]
    gained: tuple[tuple[Fact, ...], ...]

    @property
    def becoming_true(self) -> frozenset[Fact]:
        """All facts that do not hold at the start and do at some time."""
        return frozenset().union(*self.gained)

    def within(self, actions: Sequence[int]) -> Repertoire:
        """The states that some of the actions, by their numbers, lead to."""
        place = {number: n for n, number in enumerate(actions)}

        def successors(n: int) -> Iterator[tuple[int, int]]:
            return ((place[action], target) for action, target in self.edges[n] if action in place)

        kept, edges, depths = _explored(0, successors)
        return Repertoire(
            tuple([self.actions[number] for number in actions]),
            tuple([self.states[n] for n in kept]),
            edges,
            depths,
            tuple([self.gained[n] for n in kept]),
        )

    def distances_to(self, goals: Iterable[int]) -> Mapping[int, int]:
        """The fewest actions from each state to one of these; where none lead there a state is left out."""
        sources = group_pairs((target, n) for n, edges in enumerate(self.edges) for _, target in edges)
        level, depth = list(goals), 0
        found = dict.fromkeys(level, depth)
        while level:
            depth += 1
            before = dict.fromkeys([source for target in level for source in sources.get(target, ())])
            level = [n for n in before if n not in found]
            found.update(dict.fromkeys(level, depth))
        return found


def exhaust(setting: Setting, start: State, actions: Sequence[Action], most: int) -> Repertoire | None:
    """All that some actions lead to from a state; None if that is more states than ``most``."""

    def successors(state: State) -> Iterator[tuple[int, State]]:
        for number, action in enumerate(actions):
            after = setting.after(state, action)
            if after is not None:
                yield number, after

    states, edges, depths = _explored(start, successors, most)
    if len(states) > most:
        return None
    gained = [tuple(setting.added(start, state)) for state in states]
    return Repertoire(tuple(actions), tuple(states), edges, depths, tuple(gained))


def _explored(
    start: K, successors: Callable[[K], Iterator[tuple[int, K]]], most: float = math.inf
) -> tuple[list[K], tuple[tuple[tuple[int, int], ...], ...], tuple[int, ...]]:
    """All nodes in breadth-first order, their numbered edges and their depths, until there are too many."""
    numbers, nodes, depths = {start: 0}, [start], [0]
    edges: list[tuple[tuple[int, int], ...]] = []
    for n, node in enumerate(nodes):  # which grows on the way
        found = []
        for action, after in successors(node):
            if after not in numbers:
                numbers[after] = len(nodes)
                nodes.append(after)
                depths.append(depths[n] + 1)
            found.append((action, numbers[after]))
        edges.append(tuple(found))
        if len(nodes) > most:
            break
    return nodes, tuple(edges), tuple(depths)


@dataclass(frozen=True, slots=True)
class Item:
    """The matter of a question, with what is right and what is wrong.

    Attributes:
        state: what holds when it is asked.
        operators: the names of the operators whose rules are shown.
        depth: how many actions there are to think of.
        right: texts of which any is a right choice, first what is easily taken for wrong.
        wrong: texts of which any is a wrong choice, first what is easily taken for right.
        answer: the gold answers in open form.
        accept: whether all of these are wanted.
        values: what else the templates speak of.
        formulas: goals that are shown, for the sake of the predicates in them.
        about: the labels of texts that do not begin with their operator or predicate: that operator first.
        actions: whether what is right and wrong are actions: where they are to choose from, no rules but
            theirs are shown.
        yes_no: the texts of which yes or no is asked, as something alike has the other answer; all if None.
    """

    state: State
    operators: Collection[str]
    depth: int
    right: Sequence[str]
    wrong: Sequence[str]
    answer: Sequence[str]
    accept: Accept = "all"
    values: Mapping[str, str] = field(default_factory=dict)
    formulas: tuple[f.Formula, ...] = ()
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
