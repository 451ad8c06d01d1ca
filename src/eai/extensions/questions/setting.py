"""The material of questions: a task in a small scene, the rules of its domain, and a path of actions.

Rules are the requirements and effects of actions, in words and formulas, as the domain declares them.
A `QuestionWithRightAndWrongTexts` is the content of a question before its form is chosen.
A form is yes or no, multiple choice, or open.
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
from eai.logic.traversal import find_object_names
from eai.planning.planner import Planner
from eai.planning.search import Limits
from eai.tasks.planning import find_plan
from eai.tasks.rules import DomainRulesInPrompts
from eai.tasks.task import GoalKind, Task
from eai.tasks.wording import list_objects_in_prompt
from eai.world.action import Action
from eai.world.domain import Domain
from eai.world.execution import execute_plan
from eai.world.fault import FaultKind
from eai.world.state import Fact, Scene, State, compare_states

_MAX_PATH_ACTIONS = 24
"""Maximum number of actions in a task's path: its plan, or random actions if it has no plan."""

_RANDOM_ACTIONS = 6
"""Number of random actions in the path (executable actions) of a task that has no plan.

The path is shorter if the draws find no possible action.
"""

_MAX_ACTION_DRAWS = 40
"""Maximum number of random draws to find one possible (or impossible) action."""

_UNSUITABLE_PROBABILITY = 0.25
"""Probability that a drawn impossible action is used although its objects are of the wrong kind.

Such an action is impossible in every state, so it is easy to recognize.
"""

_SEARCH_LIMITS = Limits(60)

K = TypeVar("K", bound=Hashable)
T = TypeVar("T")


@dataclass(frozen=True)
class QuestionSetting:
    """The material of the questions about one task.

    Attributes:
        task: the task, in a scene that has only the objects that prompts show.
        rules: the rules of the domain that prompts can show.
        path: actions that can be executed in order from the start of the task.
        states: the states along the path, from the start to the state after the last action.
        seed: seed of the random choices that all questions about the task share.
        state_graphs: for each set of drawn actions, the graph of all states to which the actions lead, or
            None if there are too few actions or too many states. The keys number the sets. Filled when
            needed.
    """

    task: Task
    rules: DomainRulesInPrompts
    path: tuple[Action, ...]
    states: tuple[State, ...]
    seed: str
    state_graphs: dict[int, GraphOfReachableStates | None] = field(
        default_factory=dict, compare=False, repr=False
    )

    @property
    def domain(self) -> Domain:
        """The domain (predicates and operators) of the task."""
        return self.rules.domain

    @property
    def scene(self) -> Scene:
        """The scene: all objects of the task."""
        return self.task.scene

    @cached_property
    def goals(self) -> tuple[f.Formula, ...]:
        """The goals of the task for its final state."""
        return tuple([goal.formula for goal in self.task.goals])

    @cached_property
    def has_path_from_unmet_to_met_goals(self) -> bool:
        """Whether the task's path (its executable actions) leads from unmet to met goals of the task."""
        return not all(self.evaluate_goals(self.states[0])) and all(self.evaluate_goals(self.states[-1]))

    @cached_property
    def non_agent_object_indices(self) -> tuple[int, ...]:
        """Indices of all objects except the agent."""
        return tuple([i for i in range(len(self.scene.objects)) if i != self.scene.agent])

    def find_next_state(self, state: State, action: Action) -> State | None:
        """Return the state after an action, or None if a requirement of the action is not met."""
        operator = self.domain.compiled_operators[action.operator]
        binding = operator.bind(state, action.arguments)
        return operator.apply(state, binding) if operator.is_possible(state, binding) else None

    def list_unmet_requirement_numbers(self, state: State, action: Action) -> tuple[int, ...]:
        """Return which requirements of an action are not met: their numbers, counted from 1."""
        operator = self.domain.compiled_operators[action.operator]
        binding = operator.bind(state, action.arguments)
        return tuple([n for n, check in enumerate(operator.checks, 1) if not check.holds(state, binding)])

    def evaluate_goals(self, state: State) -> tuple[bool, ...]:
        """Return a truth value for each goal: whether it holds in a state."""
        return tuple([self.rules.evaluator.holds(goal, {}, state) for goal in self.goals])

    def find_added_facts(self, before: State, after: State) -> list[Fact]:
        """Return the facts that hold only in the second state.

        Facts that no action can change, or that prompts never show, are left out.
        """
        return [
            fact
            for fact in compare_states(before, after).added
            if fact.predicate in self.rules.changeable_visible_predicates
        ]

    def format_changes(self, before: State, after: State) -> tuple[str, ...]:
        """Return the differences between two states as texts, such as ``lit(lamp)`` and ``not lit(lamp)``."""
        removed = [f"not {self.format_fact_or_action(fact)}" for fact in self.find_added_facts(after, before)]
        return (*self.format_elements(self.find_added_facts(before, after)), *removed)

    def is_same_state(self, one: State, other: State) -> bool:
        """Whether two states agree in all visible facts whose predicates actions can change."""
        return not self.find_added_facts(one, other) and not self.find_added_facts(other, one)

    def list_changeable_facts(self, state: State) -> list[Fact]:
        """Return the visible facts of a state that actions can change."""
        return [fact for fact in state.facts() if fact.predicate in self.rules.changeable_visible_predicates]

    def format_fact_or_action(self, fact_or_action: Fact | Action) -> str:
        """Return a fact or an action as text, such as ``lit(lamp)``."""
        if isinstance(fact_or_action, Action):
            return action_text(fact_or_action, self.scene)
        return fact_text(fact_or_action, self.scene)

    def format_elements(self, facts_or_actions: Iterable[Fact] | Iterable[Action]) -> list[str]:
        """Return each fact or action as text."""
        return list(map(self.format_fact_or_action, facts_or_actions))

    def draw_action(
        self, rng: random.Random, state: State, *, possible: bool, operators: Sequence[str] = ()
    ) -> Action | None:
        """Draw a possible (or impossible) action whose objects all differ; return None if none was found.

        All operators, or all operators named in ``operators``, are equally likely.
        """
        candidates = [
            operator for operator in self.rules.operators if operator.name in operators
        ] or self.rules.operators
        for _ in range(_MAX_ACTION_DRAWS):
            operator = rng.choice(candidates)
            arguments = tuple(
                rng.sample(
                    self.non_agent_object_indices, min(operator.arity, len(self.non_agent_object_indices))
                )
            )
            action = Action(operator.name, arguments)
            if (
                len(arguments) < operator.arity
                or (self.find_next_state(state, action) is not None) is not possible
            ):
                continue
            if (
                possible
                or not self._has_objects_of_wrong_kind(state, action)
                or rng.random() < _UNSUITABLE_PROBABILITY
            ):
                return action
        return None

    def _has_objects_of_wrong_kind(self, state: State, action: Action) -> bool:
        """Whether an action can never be possible, because of the kinds of its objects."""
        checks = self.domain.compiled_operators[action.operator].operator.checks
        return any(
            checks[n - 1].fault is FaultKind.AFFORDANCE
            for n in self.list_unmet_requirement_numbers(state, action)
        )


def make_question_setting(
    task: Task, rules: DomainRulesInPrompts, planner: Planner, seed: str
) -> QuestionSetting:
    """Return the material of questions about a task: the task, a path (sequence of actions) and its states.

    The path is the beginning of the task's own plan, up to the first step with an object that prompts do not
    show. If the task has no plan, the path is a plan found by search, or some random actions.
    """
    small_task, rng = _restrict_to_objects_of_prompt_and_plan(task), random.Random(seed)  # noqa: S311 - chance, not secrets
    plan = small_task.script or _search_plan(small_task, planner)
    path = _find_executable_steps(small_task, rules, plan) or _walk_randomly(small_task, rules, rng)
    return QuestionSetting(
        small_task, rules, path, execute_plan(rules.domain, small_task.initial, path).states, seed
    )


def _restrict_to_objects_of_prompt_and_plan(task: Task) -> Task:
    """Reduce a task to objects that its prompt shows or its plan uses, and to goals about its final state."""
    named = [i for action in task.script for i in action.arguments]
    kept = sorted({*list_objects_in_prompt(task), *named})
    number = {index: i for i, index in enumerate(kept)}
    initial = restrict_state(task.initial, kept)
    conditions = [goal for goal in task.without_goals_over_time.goals if goal.kind is not GoalKind.ACTION]
    goals = [
        goal for goal in conditions if set(find_object_names(goal.formula)) <= initial.scene.index.keys()
    ]
    return Task(
        task.id,
        task.title,
        task.instruction,
        initial,
        tuple(goals),
        tuple(range(len(kept))),
        tuple([Action(name, tuple([number[i] for i in among])) for name, among in task.script]),
    )


def _find_executable_steps(
    task: Task, rules: DomainRulesInPrompts, plan: Sequence[Action]
) -> tuple[Action, ...]:
    """Return the first steps of a plan that can be executed, at most `_MAX_PATH_ACTIONS` steps.

    The result ends before the first step that is impossible or that has an operator without rules in prompts.
    """
    arities = rules.domain.operator_arities
    well_formed = takewhile(lambda action: arities.get(action.operator) == len(action.arguments), plan)
    executed = execute_plan(rules.domain, task.initial, well_formed).executed_actions
    return tuple(takewhile(lambda action: action.operator in rules.operator_names, executed))[
        :_MAX_PATH_ACTIONS
    ]


def _search_plan(task: Task, planner: Planner) -> Sequence[Action]:
    """Search for a plan of a task. Return no steps if the task has no goals or a goal seems unreachable."""
    goals = [goal.formula for goal in task.goals]
    if goals and all(
        planner.looks_reachable(task.initial, goal, task.planning_object_indices) for goal in goals
    ):
        return find_plan(task, planner, _SEARCH_LIMITS).plan
    return ()


def _walk_randomly(task: Task, rules: DomainRulesInPrompts, rng: random.Random) -> tuple[Action, ...]:
    setting, taken, state = QuestionSetting(task, rules, (), (), ""), list[Action](), task.initial
    for _ in range(_RANDOM_ACTIONS):
        action = setting.draw_action(rng, state, possible=True)
        if action is not None and (after := setting.find_next_state(state, action)) is not None:
            taken.append(action)
            state = after
    return tuple(taken)


@dataclass(frozen=True)
class GraphOfReachableStates:
    """All states that some actions lead to. Each action can be used any number of times.

    The exploration is complete, so a state that is absent is proved to be unreachable.

    Attributes:
        actions: the actions.
        states: every reachable state, in breadth-first order from the start.
        edges: for each state, pairs of a possible action and the state after it. Both are indices.
        depths: for each state, the minimum number of actions that lead to it.
        added_facts: for each state, the facts that hold in it but not at the start.
    """

    actions: tuple[Action, ...]
    states: tuple[State, ...]
    edges: tuple[tuple[tuple[int, int], ...], ...]
    depths: tuple[int, ...]
    added_facts: tuple[tuple[Fact, ...], ...]

    @property
    def reachable_facts(self) -> frozenset[Fact]:
        """The facts that do not hold at the start but hold in some reachable state."""
        return frozenset().union(*self.added_facts)

    def restrict_to_actions(self, actions: Sequence[int]) -> GraphOfReachableStates:
        """Return the part of the graph that stays reachable with only the given actions (indices)."""
        new_numbers = {number: n for n, number in enumerate(actions)}

        def list_allowed_actions_with_next_states(state_index: int) -> Iterator[tuple[int, int]]:
            return (
                (new_numbers[action], target)
                for action, target in self.edges[state_index]
                if action in new_numbers
            )

        kept, edges, depths = _explore_graph(0, list_allowed_actions_with_next_states)
        return GraphOfReachableStates(
            tuple([self.actions[number] for number in actions]),
            tuple([self.states[n] for n in kept]),
            edges,
            depths,
            tuple([self.added_facts[n] for n in kept]),
        )

    def find_distances_to_goal_states(self, goal_states: Iterable[int]) -> Mapping[int, int]:
        """Return a mapping from state to the minimum number of actions from this state to a goal state.

        States are given as indices. States that cannot reach a goal state are left out.
        """
        sources = group_pairs((target, n) for n, edges in enumerate(self.edges) for _, target in edges)
        level, depth = list(goal_states), 0
        distances = dict.fromkeys(level, depth)
        while level:
            depth += 1
            before = dict.fromkeys([source for target in level for source in sources.get(target, ())])
            level = [n for n in before if n not in distances]
            distances.update(dict.fromkeys(level, depth))
        return distances


def explore_states(
    setting: QuestionSetting, start: State, actions: Sequence[Action], max_states: int
) -> GraphOfReachableStates | None:
    """Explore all states that some actions lead to. Return None if there are more than ``max_states``."""

    def list_successors(state: State) -> Iterator[tuple[int, State]]:
        for number, action in enumerate(actions):
            after = setting.find_next_state(state, action)
            if after is not None:
                yield number, after

    states, edges, depths = _explore_graph(start, list_successors, max_states)
    if len(states) > max_states:
        return None
    gained = [tuple(setting.find_added_facts(start, state)) for state in states]
    return GraphOfReachableStates(tuple(actions), tuple(states), edges, depths, tuple(gained))


def _explore_graph(
    start: K, successors: Callable[[K], Iterator[tuple[int, K]]], max_nodes: float = math.inf
) -> tuple[list[K], tuple[tuple[tuple[int, int], ...], ...], tuple[int, ...]]:
    """Return all nodes in breadth-first order, the edges of each node and the depth of each node.

    An edge is a pair of a label and the index of the next node. The search stops after ``max_nodes`` nodes.
    """
    numbers, nodes, depths = {start: 0}, [start], [0]
    edges: list[tuple[tuple[int, int], ...]] = []
    for n, node in enumerate(nodes):  # the loop appends to `nodes`
        node_edges = []
        for action, after in successors(node):
            if after not in numbers:
                numbers[after] = len(nodes)
                nodes.append(after)
                depths.append(depths[n] + 1)
            node_edges.append((action, numbers[after]))
        edges.append(tuple(node_edges))
        if len(nodes) > max_nodes:
            break
    return nodes, tuple(edges), tuple(depths)


@dataclass(frozen=True, slots=True)
class QuestionWithRightAndWrongTexts:
    """The content of a question, with right and wrong texts.

    Attributes:
        state: the state that the question shows.
        operators: names of the operators whose rules are shown.
        depth: number of actions to consider.
        right: texts that can be the right choice. Texts that readers are least likely to believe come
            first.
        wrong: texts that can be a wrong choice. Texts that readers are most likely to believe come first.
        answer: the gold answers if the question is asked in open form, without choices.
        accept: whether an answer must name all gold answers, or only one.
        values: further values that the templates of prompts insert, by the name of the field.
        formulas: formulas of goals in the prompt, which then also shows facts with their predicates.
        labels: labels of texts that do not begin with an operator or predicate. Texts with equal labels are
            similar for shortcuts.
        are_actions: whether `right` and `wrong` are actions, whose rules a question with choices shows.
        yes_no_texts: texts that a yes-no question may use; None for all. A text is left out if no similar
            text has the other answer.
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
    labels: Mapping[str, Sequence[str]] = field(default_factory=dict)
    are_actions: bool = False
    yes_no_texts: Collection[str] | None = None


ItemMaker: TypeAlias = Callable[[QuestionSetting, random.Random, int], QuestionWithRightAndWrongTexts | None]
"""Function that makes the content of a question at random, or returns None if it fails.

Its last argument is the number of the question. The number selects, for example, the wanted length or outcome
of a plan, so that questions alternate.
"""


def find_texts_with_shared_operator(
    right_texts: Sequence[str], wrong_texts: Sequence[str], get_operator: Callable[[str], str]
) -> frozenset[str]:
    """Return the texts whose operator occurs in both a right and a wrong text.

    The operator of such a text does not reveal whether the text is right.
    """
    shared = set(map(get_operator, right_texts)) & set(map(get_operator, wrong_texts))
    return frozenset([text for text in (*right_texts, *wrong_texts) if get_operator(text) in shared])


def draw_sample_keeping_order(rng: random.Random, elements: Sequence[T], max_count: int) -> list[T]:
    """Draw at most ``max_count`` elements of a sequence at random, and keep their order."""
    if len(elements) <= max_count:
        return list(elements)
    return [elements[i] for i in sorted(rng.sample(range(len(elements)), max_count))]


def format_numbered_list(texts: Sequence[str]) -> str:
    """Return the texts as lines, numbered from 1."""
    return "\n".join([f"{number}. {text}" for number, text in enumerate(texts, 1)])


def format_list(texts: Sequence[str]) -> str:
    """Return the texts as lines that begin with a dash."""
    return "\n".join([f"- {text}" for text in texts])
