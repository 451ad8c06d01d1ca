"""Compute features of tasks, such as the number of goals. Analyses relate scores to these features."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from math import prod

from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.generator.measures import TaskMeasure, measure_task
from eai.benchmarks.labels import derive_task_labels_from_goals
from eai.logic.choice import Literal, count_dnf_terms, generate_dnf_terms_of_tree
from eai.logic.formula import Atom, Exactly, Exists, ForAll, ForPairs, Not, Occurs
from eai.logic.traversal import walk_subformulas
from eai.tasks.goal_test import GoalTest
from eai.tasks.task import Goal, GoalKind, Task
from eai.world.relation import iterate_bits, make_mask


@dataclass(frozen=True, slots=True, kw_only=True)
class TaskStatistics:
    """The features of one task.

    A *goal* is one of the conditions for which plans are tested. It may quantify over objects ("every jar is
    open"). A *ground goal* is a condition on certain objects, as in goal interpretation. If a goal has
    several options, ground goals are counted in the first option. A condition in two goals counts twice.

    Attributes:
        annotated_steps: number of steps of the data set's own plan; None if there is no plan.
        annotated_operators: number of different operators in the data set's own plan; None if there is no
            plan.
        tool_steps: number of steps of the data set's own plan that need an object without naming it, such
            as a knife or a sink; None if there is no plan.
        goals: number of goals.
        state_goals: number of goals about states only.
        relation_goals: number of goals with relations.
        action_goals: number of goals that are actions to be taken.
        quantified_goals: number of goals that quantify over objects.
        goal_options: number of ways to choose one option (set of conditions that reaches the goal) for each
            goal.
        ground_goals: number of ground goals.
        ground_state_goals: number of ground goals about one object.
        ground_relation_goals: number of ground goals about two objects.
        ground_action_goals: number of ground goals that are actions.
        goals_at_start: number of goals that hold in the initial state.
        objects: number of relevant objects.
        object_categories: number of categories of relevant objects.
        initial_facts: number of initial facts that actions can change, and that mention only relevant
            objects.
        instruction_words: number of words of the instruction.
        containers: number of containers that the data set's own plan opens and that hide their contents until
            then; None if there is no plan.
        hidden: number of needed objects that are invisible until that plan opens a container; None if there
            is no plan.
        labels: labels that rules derive from the goals (`eai.benchmarks.labels`), sorted and separated by
            spaces.
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
    containers: int | None
    hidden: int | None
    labels: str


def compute_features(task: Task, benchmark: Benchmark) -> TaskStatistics:
    """Return statistics of a task, such as counts of its goals, objects and plan steps, and its labels."""
    measures = measure_task(task, benchmark.domain) if task.script else {}
    kinds = Counter(goal.kind for goal in task.goals)
    alternatives = benchmark.notation.goals.list_alternatives_of_goals(task.without_goals_over_time)
    conditions = [
        condition for goal in alternatives for condition in next(generate_dnf_terms_of_tree(goal.options), ())
    ]
    ground = Counter(map(_classify_condition, conditions))
    indices = set(task.relevant)
    return TaskStatistics(
        annotated_steps=measures.get(TaskMeasure.STEPS),
        annotated_operators=measures.get(TaskMeasure.OPERATORS),
        tool_steps=measures.get(TaskMeasure.TOOL_STEPS),
        goals=len(task.goals),
        state_goals=kinds[GoalKind.STATE],
        relation_goals=kinds[GoalKind.RELATION],
        action_goals=kinds[GoalKind.ACTION],
        quantified_goals=sum(map(_is_quantified, task.goals)),
        goal_options=prod(
            count_dnf_terms(goal.formula, task.scene.names_of_category)
            for goal in task.without_goals_over_time.goals
        ),
        ground_goals=ground.total(),
        ground_state_goals=ground[GoalKind.STATE],
        ground_relation_goals=ground[GoalKind.RELATION],
        ground_action_goals=ground[GoalKind.ACTION],
        goals_at_start=sum(GoalTest(task).evaluate_each_goal(task.initial, ())),
        objects=len(indices),
        object_categories=len({task.scene.objects[i].category for i in indices}),
        initial_facts=_count_initial_facts(task),
        instruction_words=len(task.instruction.split()),
        containers=measures.get(TaskMeasure.CONTAINERS),
        hidden=measures.get(TaskMeasure.HIDDEN),
        labels=" ".join(derive_task_labels_from_goals(task, benchmark.data.labels)),
    )


def _classify_condition(condition: Literal) -> GoalKind:
    match condition.operand if isinstance(condition, Not) else condition:
        case Occurs():
            return GoalKind.ACTION
        case Atom(_, (_, _, *_)):
            return GoalKind.RELATION
        case _:
            return GoalKind.STATE


def _is_quantified(goal: Goal) -> bool:
    return any(
        isinstance(formula, (ForAll, Exists, Exactly, ForPairs)) for formula in walk_subformulas(goal.formula)
    )


def _count_initial_facts(task: Task) -> int:
    mask, state = make_mask(task.relevant), task.initial
    predicates = [p for p in task.scene.vocabulary.predicates if p.visible and not p.static]
    unary_facts = sum((state.mask(p.name) & mask).bit_count() for p in predicates if p.arity == 1)
    relations = [state.relation(p.name) for p in predicates if p.arity == 2]
    return unary_facts + sum(
        (relation.row(i) & mask).bit_count() for relation in relations for i in iterate_bits(mask)
    )
