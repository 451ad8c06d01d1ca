"""Features of tasks, whatever is answered: all that a score may be set against."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from math import prod

from eai.benchmarks.benchmark import Benchmark
from eai.logic.choice import Literal, choice_options, count_options
from eai.logic.formula import Atom, Exactly, Exists, ForAll, Formula, ForPairs, Not, Occurs
from eai.logic.traversal import children, walk
from eai.tasks.goal_test import GoalTest
from eai.tasks.task import Goal, GoalKind, Task
from eai.world.domain import Domain
from eai.world.operator import Operator
from eai.world.relation import bits, mask_of


@dataclass(frozen=True, slots=True, kw_only=True)
class Features:
    """The features of one task.

    A *goal* is a part of the task's goal as plans are tested for it, which may speak of objects in general
    ("every jar is open"). A *ground goal* is a condition on certain objects, as goal interpretation asks for
    it: those of the first way to meet each goal, what stands in two of them twice.

    Attributes:
        annotated_steps: how many steps the data set's own plan has; None if there is none.
        annotated_operators: how many different operators it uses; likewise.
        tool_steps: how many of its steps need a thing of some kind that they do not name: something to
            slice with, a sink to soak in; likewise.
        goals: how many goals it has.
        state_goals: those that speak of states alone.
        relation_goals: those that speak of relations.
        action_goals: those that are actions to be taken.
        quantified_goals: those that speak of objects in general.
        goal_options: how many ways there are to choose one way to meet each goal.
        ground_goals: how many ground goals it has.
        ground_state_goals: those of one object.
        ground_relation_goals: those of two objects.
        ground_action_goals: those that are actions.
        goals_at_start: how many goals hold before anything is done.
        objects: how many objects the task is about.
        object_categories: of how many categories they are.
        initial_facts: how many changeable facts about them alone hold at the start.
        instruction_words: how many words the instruction has.
    """

    annotated_steps: int | None
    annotated_operators: int | None
    tool_steps: int | None
    goals: int
    state_goals: int
    relation_goals: int
    action_goals: int
    quantified_goals: int
    goal_options: int
    ground_goals: int
    ground_state_goals: int
    ground_relation_goals: int
    ground_action_goals: int
    goals_at_start: int
    objects: int
    object_categories: int
    initial_facts: int
    instruction_words: int


def features_of(task: Task, benchmark: Benchmark) -> Features:
    """The features of a task of a benchmark."""
    steps, tools = [step.operator for step in task.script], operators_with_tools(benchmark.domain)
    kinds = Counter(goal.kind for goal in task.goals)
    alternatives = benchmark.notation.goals.alternatives(task.at_the_end)
    conditions = [part for goal in alternatives for part in next(choice_options(goal.options), ())]
    ground = Counter(map(_kind, conditions))
    about = set(task.relevant)
    return Features(
        annotated_steps=len(steps) or None,
        annotated_operators=len(set(steps)) or None,
        tool_steps=sum(step in tools for step in steps) if steps else None,
        goals=len(task.goals),
        state_goals=kinds[GoalKind.STATE],
        relation_goals=kinds[GoalKind.RELATION],
        action_goals=kinds[GoalKind.ACTION],
        quantified_goals=sum(map(_is_quantified, task.goals)),
        goal_options=prod(
            count_options(goal.formula, task.scene.names_of_category) for goal in task.at_the_end.goals
        ),
        ground_goals=ground.total(),
        ground_state_goals=ground[GoalKind.STATE],
        ground_relation_goals=ground[GoalKind.RELATION],
        ground_action_goals=ground[GoalKind.ACTION],
        goals_at_start=sum(GoalTest(task).reached(task.initial, ())),
        objects=len(about),
        object_categories=len({task.scene.objects[i].category for i in about}),
        initial_facts=_initial_facts(task),
        instruction_words=len(task.instruction.split()),
    )


def _kind(condition: Literal) -> GoalKind:
    match condition.operand if isinstance(condition, Not) else condition:
        case Occurs():
            return GoalKind.ACTION
        case Atom(_, (_, _, *_)):
            return GoalKind.RELATION
        case _:
            return GoalKind.STATE


def _is_quantified(goal: Goal) -> bool:
    return any(isinstance(part, (ForAll, Exists, Exactly, ForPairs)) for part in walk(goal.formula))


def _initial_facts(task: Task) -> int:
    about, state = mask_of(task.relevant), task.initial
    shown = [p for p in task.scene.vocabulary.predicates if p.visible and not p.static]
    alone = sum((state.mask(p.name) & about).bit_count() for p in shown if p.arity == 1)
    relations = [state.relation(p.name) for p in shown if p.arity == 2]
    return alone + sum((each.row(i) & about).bit_count() for each in relations for i in bits(about))


def operators_with_tools(domain: Domain) -> frozenset[str]:
    """The operators of which a check asks for a thing of some kind that the action does not name."""
    kinds = {p.name for p in domain.vocabulary.predicates if p.static and p.arity == 1}
    return frozenset(operator.name for operator in domain.operators if _needs_a_tool(operator, kinds))


def _needs_a_tool(operator: Operator, kinds: set[str]) -> bool:
    checks = [*operator.checks, *(check for each in operator.tries for check in each.checks)]
    return any(_asks_for(check.condition, kinds) for check in checks)


def _asks_for(formula: Formula, kinds: set[str]) -> bool:
    """Whether there must be something of one of these kinds; what is denied is not asked for."""
    if isinstance(formula, Not):
        return False
    if isinstance(formula, Exists):
        return any(isinstance(part, Atom) and part.predicate in kinds for part in walk(formula.body))
    return any(_asks_for(part, kinds) for part in children(formula))
