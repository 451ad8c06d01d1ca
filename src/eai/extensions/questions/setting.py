"""The material of questions: a task in a small scene, the rules of its domain, and a path of actions.

The rules are the requirements and effects of actions, in words and formulas, exactly as declared.
An `Item` is the content of a question before it is phrased in one of its forms.
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
from eai.benchmarks.generator.scene import restrict_state
from eai.extensions.questions.question import Accept
from eai.logic.traversal import object_names
from eai.planning.planner import Planner
from eai.planning.search import Limits
from eai.tasks.planning import find_plan
from eai.tasks.rules import DomainRules
from eai.tasks.task import GoalKind, Task
from eai.tasks.wording import prompt_objects
from eai.world.action import Action
from eai.world.domain import Domain
from eai.world.execution import execute
from eai.world.fault import FaultKind
from eai.world.state import Fact, Scene, State, compare_states

_STEPS = 24
"""Maximum number of actions in a path."""

_WALK = 6
"""Number of random actions tried for the path of a task without a plan."""

_TRIES = 40
"""Maximum number of random draws for one action."""

_ABSURD = 0.25
"""Probability that an impossible action is kept if its objects are of the wrong kind."""

_LIMITS = Limits(60)

K = TypeVar("K", bound=Hashable)
T = TypeVar("T")


@dataclass(frozen=True)
class Setting:
    """The material of the questions about one task.

    Attributes:
        task: the task, in a scene that has only the shown objects.
        rules: the rules of the domain that prompts can show.
        way: actions that can be executed in order from the start of the task.
        states: the states along the way: one more than actions.
        seed: seed of the choices that all questions about the task share.
        repertoires: sets of actions with the states they lead to, by number, filled on demand. None marks
            a set that leads to too many states.
    """

    task: Task
    rules: DomainRules
    way: tuple[Action, ...]
    states: tuple[State, ...]
    seed: str
    repertoires: dict[int, Repertoire | None] = field(default_factory=dict, compare=False, repr=False)

    @property
    def domain(self) -> Domain:
        """The declared domain of the task."""
        return self.rules.domain

    @property
    def scene(self) -> Scene:
        """All objects of the task."""
        return self.task.scene

    @cached_property
    def goals(self) -> tuple[f.Formula, ...]:
        """The goals of the task for its final state."""
        return tuple([goal.formula for goal in self.task.goals])

    @cached_property
    def works(self) -> bool:
        """Whether the way reaches all goals, and some goals do not hold at the start."""
        return not all(self.reached(self.states[0])) and all(self.reached(self.states[-1]))

    @cached_property
    def things(self) -> tuple[int, ...]:
        """Indices of all objects except the agent."""
        return tuple([i for i in range(len(self.scene.objects)) if i != self.scene.agent])

    def after(self, state: State, action: Action) -> State | None:
        """Return the state after an action; None if a requirement is not met."""
        operator = self.domain.compiled[action.operator]
        binding = operator.bind(state, action.arguments)
        return operator.apply(state, binding) if operator.is_possible(state, binding) else None

    def failing(self, state: State, action: Action) -> tuple[int, ...]:
        """Return the numbers, from 1, of an action's unmet requirements."""
        operator = self.domain.compiled[action.operator]
        binding = operator.bind(state, action.arguments)
        return tuple([n for n, check in enumerate(operator.checks, 1) if not check.holds(state, binding)])

    def reached(self, state: State) -> tuple[bool, ...]:
        """Return for each goal whether it holds in a state."""
        return tuple([self.rules.evaluator.holds(goal, {}, state) for goal in self.goals])

    def added(self, before: State, after: State) -> list[Fact]:
        """Return the changeable facts that hold in the second state but not in the first."""
        return [fact for fact in compare_states(before, after).added if fact.predicate in self.rules.fluents]

    def changes(self, before: State, after: State) -> tuple[str, ...]:
        """Return the differences between two states as texts, such as ``lit(lamp)`` and ``not lit(lamp)``."""
        removed = [f"not {self.text_of(fact)}" for fact in self.added(after, before)]
        return (*self.texts(self.added(before, after)), *removed)

    def alike(self, one: State, other: State) -> bool:
        """Whether two states have the same changeable facts."""
        return not self.added(one, other) and not self.added(other, one)

    def facts(self, state: State) -> list[Fact]:
        """Return the facts of a state whose predicates actions can change."""
        return [fact for fact in state.facts() if fact.predicate in self.rules.fluents]

    def text_of(self, what: Fact | Action) -> str:
        """Return a fact or an action as text."""
        return action_text(what, self.scene) if isinstance(what, Action) else fact_text(what, self.scene)

    def texts(self, those: Iterable[Fact] | Iterable[Action]) -> list[str]:
        """Return each fact or action as text."""
        return list(map(self.text_of, those))

    def some_action(
        self, rng: random.Random, state: State, *, possible: bool, operators: Sequence[str] = ()
    ) -> Action | None:
        """Draw a possible (or impossible) action on different objects; None if none was found.

        All operators, or those named in ``operators``, are equally likely.
        """
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
        """Whether an action can never be possible, because of the kinds of its objects."""
        checks = self.domain.compiled[action.operator].operator.checks
        return any(checks[n - 1].fault is FaultKind.AFFORDANCE for n in self.failing(state, action))


def open_setting(task: Task, rules: DomainRules, planner: Planner, seed: str) -> Setting:
    """Prepare the material of a task for questions.

    The way is the task's own plan, as far as the shown objects suffice. If the task has no plan, the way
    is a plan found by search, or some random actions.
    """
    closed, rng = _closed(task), random.Random(seed)  # noqa: S311 - chance, not secrets
    plan = closed.script or _search_plan(closed, planner)
    way = _executed(closed, rules, plan) or _wandering(closed, rules, rng)
    return Setting(closed, rules, way, execute(rules.domain, closed.initial, way).states, seed)


def _closed(task: Task) -> Task:
    """Reduce a task to the objects that a prompt shows and its plan uses. Goals about actions are dropped."""
    named = [i for action in task.script for i in action.arguments]
    kept = sorted({*prompt_objects(task), *named})
    number = {index: i for i, index in enumerate(kept)}
    initial = restrict_state(task.initial, kept)
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


def _executed(task: Task, rules: DomainRules, plan: Sequence[Action]) -> tuple[Action, ...]:
    """Return the steps of a plan that can be executed and shown, without unneeded ones."""
    arities = rules.domain.arities
    known = takewhile(lambda action: arities.get(action.operator) == len(action.arguments), plan)
    executed = execute(rules.domain, task.initial, known).executed
    return tuple(takewhile(lambda action: action.operator in rules.operator_names, executed))[:_STEPS]


def _search_plan(task: Task, planner: Planner) -> Sequence[Action]:
    """Search a plan for a task; return no steps if it has no goals or a goal seems unreachable."""
    goals = [goal.formula for goal in task.goals]
    if goals and all(planner.looks_reachable(task.initial, goal, task.planning_objects) for goal in goals):
        return find_plan(task, planner, _LIMITS).plan
    return ()


def _wandering(task: Task, rules: DomainRules, rng: random.Random) -> tuple[Action, ...]:
    setting, taken, state = Setting(task, rules, (), (), ""), list[Action](), task.initial
    for _ in range(_WALK):
        action = setting.some_action(rng, state, possible=True)
        if action is not None and (after := setting.after(state, action)) is not None:
            taken.append(action)
            state = after
    return tuple(taken)


@dataclass(frozen=True)
class Repertoire:
    """Some actions, each usable any number of times, and all states that they lead to.

    All of them are explored, so an absent state is proved to be unreachable.

    Attributes:
        actions: the actions.
        states: every reachable state, in breadth-first order from the start.
        edges: for each state, the possible actions and the states they lead to, both as numbers.
        depths: for each state, the minimum number of actions that lead to it.
        gained: for each state, the facts that hold in it but not at the start.
    """

    actions: tuple[Action, ...]
    states: tuple[State, ...]
    edges: tuple[tuple[tuple[int, int], ...], ...]
    depths: tuple[int, ...]
    gained: tuple[tuple[Fact, ...], ...]

    @property
    def becoming_true(self) -> frozenset[Fact]:
        """The facts that do not hold at the start but hold in some reachable state."""
        return frozenset().union(*self.gained)

    def within(self, actions: Sequence[int]) -> Repertoire:
        """Return the part that is reachable with a subset of the actions, given by number."""
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
        """Return the minimum number of actions from each state to a goal state, if it reaches one."""
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
    """Explore all states that some actions lead to; None if there are more than ``most``."""

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
    """Return nodes in breadth-first order, their edges and depths, and stop after ``most`` nodes."""
    numbers, nodes, depths = {start: 0}, [start], [0]
    edges: list[tuple[tuple[int, int], ...]] = []
    for n, node in enumerate(nodes):  # the list grows while it is read
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
    """The content of a question, with right and wrong texts.

    Attributes:
        state: the state that the question shows.
        operators: names of the operators whose rules are shown.
        depth: number of actions to consider.
        right: texts that can be the right choice, most deceptive first.
        wrong: texts that can be a wrong choice, most tempting first.
        answer: the gold answers in open form.
        accept: whether an answer must name all gold answers, or only one.
        values: further values for the templates.
        formulas: goals that are shown, so that the rules include their predicates.
        about: labels of texts that do not begin with their operator or predicate; it is their first label.
        actions: whether `right` and `wrong` are actions. Then a question with choices shows only their rules.
        yes_no: texts that may be asked as yes or no, since a similar text has the other answer; None for all.
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
"""Makes the item of a question at random, or None. The number selects the wanted class of answers."""


def with_counterparts(
    right: Sequence[str], wrong: Sequence[str], operator: Callable[[str], str]
) -> frozenset[str]:
    """Return the texts whose operator occurs in both a right and a wrong text."""
    shared = set(map(operator, right)) & set(map(operator, wrong))
    return frozenset([text for text in (*right, *wrong) if operator(text) in shared])


def some(rng: random.Random, things: Sequence[T], most: int) -> list[T]:
    """Draw at most ``most`` elements, and keep their order."""
    if len(things) <= most:
        return list(things)
    return [things[i] for i in sorted(rng.sample(range(len(things)), most))]


def numbered(texts: Sequence[str]) -> str:
    """Return the texts as lines, numbered from 1."""
    return "\n".join([f"{number}. {text}" for number, text in enumerate(texts, 1)])


def listed(texts: Sequence[str]) -> str:
    """Return the texts as lines that begin with a dash."""
    return "\n".join([f"- {text}" for text in texts])
