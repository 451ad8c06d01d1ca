"""Tasks of transition modeling: gold operators, planning problems and categories of predicates.

The gold operators of a declared domain are its own operators, exported as PDDL. A task asks for the operators
in a plan that reaches the task's goals. The planning problem of the task has the goals on states and
relations. So a task that has only action goals becomes no task of transition modeling. Predicates that texts
must not mention are left out of the problem.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache, partial
from typing import TypeAlias

from eai.logic.formula import Atom
from eai.logic.traversal import walk_subformulas
from eai.pddl.execute import PlanStep
from eai.pddl.export import ExportedProblem, ProblemToExport, export_problems
from eai.pddl.model import OperatorText, PddlAction, PddlDomain, PddlProblem, find_effect_atoms
from eai.pddl.reader import read_action, read_problem
from eai.pddl.writer import unparse_operator, write_problem
from eai.planning.planner import Planner
from eai.tasks.planning import find_plan
from eai.tasks.task import Goal, GoalKind, PredicateCategory, Task
from eai.world.action import Action
from eai.world.domain import Domain
from eai.world.execution import execute_plan


@dataclass(frozen=True, slots=True)
class OperatorLibrary:
    """The operators and the categories of predicates for all tasks of one domain.

    Attributes:
        header: the planning domain without operators.
        operators: mapping from the name of each gold (right) operator to its text, in the order of the data
            set.
        categories: mapping from predicates to their categories.
    """

    header: PddlDomain
    operators: Mapping[str, OperatorText]
    categories: Mapping[str, PredicateCategory]


StepTranslator: TypeAlias = Callable[[Task, Sequence[PlanStep]], Sequence[Action]]
"""Function that translates the steps of a plan with gold (right) operators into actions of the task.

It stops before the first step that has no corresponding action.
"""


def _return_no_actions(task: Task, steps: Sequence[PlanStep]) -> Sequence[Action]:
    return ()


@dataclass(frozen=True, eq=False)
class TransitionTask:
    """A task that asks for the operators that a planning problem needs.

    Attributes:
        id: id of the task in the data set.
        domain: the operators and the categories of predicates for all tasks of the domain.
        operators: names of the operators to write, in the order of the data set.
        categories: the task's own categories, the more specific category first.
        problem_text: the planning problem as PDDL.
        actions_of: function that translates the steps of a PDDL plan with gold (right) operators into actions
            in the world of the task. The default function translates no step.
    """

    id: str
    domain: OperatorLibrary
    operators: tuple[str, ...]
    categories: tuple[PredicateCategory, ...]
    problem_text: str
    actions_of: StepTranslator = _return_no_actions

    @cached_property
    def problem(self) -> PddlProblem:
        """The planning problem, read from its text."""
        return read_problem(self.problem_text)

    @cached_property
    def gold_operators(self) -> Mapping[str, PddlAction]:
        """The gold operators that the task asks for, as the data set states them."""
        return {name: _read_gold_operator(self.domain.operators[name].write_pddl) for name in self.operators}


_read_gold_operator = lru_cache(maxsize=256)(read_action)
"""Results are cached because many tasks ask for the same operator."""


def make_transition_tasks(
    domain: Domain, tasks: Mapping[str, Task], categories: Mapping[str, PredicateCategory] | None = None
) -> dict[str, TransitionTask]:
    """Return a mapping from ids to a domain's tasks of transition modeling, in the order of its tasks.

    Tasks that are known to have no plan are left out, because there are no operators to ask for.

    Args:
        domain: the declaration of the domain.
        tasks: the domain's tasks.
        categories: mapping from PDDL names of some predicates to their categories; other predicates get those
            of `make_default_predicate_categories`.
    """
    chosen_tasks = {
        task_id: task
        for task_id, task in tasks.items()
        if _list_state_and_relation_goals(task) and task.unsolvable is None
    }
    if not chosen_tasks:
        return {}
    sources = [
        ProblemToExport(
            task_id, task.initial, tuple(goal.formula for goal in _list_state_and_relation_goals(task))
        )
        for task_id, task in chosen_tasks.items()
    ]
    exported = export_problems(domain, sources, with_invisible_predicates=False)
    all_categories = {**make_default_predicate_categories(exported[0].domain), **(categories or {})}
    library = OperatorLibrary(
        header=replace(exported[0].domain, actions=()),
        operators={action.name: unparse_operator(action) for action in exported[0].domain.actions},
        categories=all_categories,
    )
    planner = Planner(domain)
    return {
        task_id: TransitionTask(
            task_id,
            library,
            tuple(_find_plan_operators(_get_or_find_plan(domain, task, planner), problem, library)),
            _list_goal_categories_by_frequency(problem, all_categories),
            write_problem(problem.problem),
            partial(_translate_steps_to_actions, problem),
        )
        for (task_id, task), problem in zip(chosen_tasks.items(), exported, strict=True)
    }


def _translate_steps_to_actions(
    exported: ExportedProblem, task: Task, steps: Sequence[PlanStep]
) -> Sequence[Action]:
    """Return the actions for the steps of a PDDL plan, up to the first step that stands for no action."""
    actions = []
    for step in steps:
        try:
            actions.append(exported.to_action(step))
        except KeyError:
            break
    return actions


def make_default_predicate_categories(domain: PddlDomain) -> dict[str, PredicateCategory]:
    """Return a mapping from predicates to their categories.

    The category depends on the predicate's number of arguments, and on whether an operator changes the
    predicate.
    """
    changing = {atom.predicate for action in domain.actions for atom in find_effect_atoms(action.effect)}
    changing |= {axiom.name for axiom in domain.axioms}
    categories = {}
    for predicate in domain.predicates:
        match len(predicate.parameters):
            case 0:
                categories[predicate.name] = PredicateCategory.NON_SPATIAL_RELATIONS
            case 1 if predicate.name in changing:
                categories[predicate.name] = PredicateCategory.OBJECT_STATES
            case 1:
                categories[predicate.name] = PredicateCategory.OBJECT_AFFORDANCE
            case _:
                categories[predicate.name] = PredicateCategory.SPATIAL_RELATIONS
    return categories


def _list_state_and_relation_goals(task: Task) -> Sequence[Goal]:
    return [goal for goal in task.without_goals_over_time.goals if goal.kind is not GoalKind.ACTION]


def _get_or_find_plan(domain: Domain, task: Task, planner: Planner) -> Sequence[Action]:
    """Return the task's own plan if it can be executed, otherwise a plan found by search, or no steps."""
    arities = domain.operator_arities
    sound = all(arities.get(action.operator) == len(action.arguments) for action in task.script)
    if task.script and sound and execute_plan(domain, task.initial, task.script).failure is None:
        return task.script
    return find_plan(task, planner).plan


def _find_plan_operators(
    plan: Sequence[Action], exported: ExportedProblem, library: OperatorLibrary
) -> Iterator[str]:
    """Return the names of a plan's operators, in the domain's order; all operators if the plan is empty."""
    used = {exported.to_pddl_step(action).action for action in plan} or set(library.operators)
    return (name for name in library.operators if name in used)


def _list_goal_categories_by_frequency(
    exported: ExportedProblem, category_by_predicate: Mapping[str, PredicateCategory]
) -> tuple[PredicateCategory, ...]:
    """Return the categories of the predicates in a problem's goal, the most frequent category first."""
    atoms = (part for part in walk_subformulas(exported.problem.goal) if isinstance(part, Atom))
    counts = Counter(category_by_predicate[atom.predicate] for atom in atoms)
    return tuple([category for category, _ in counts.most_common()])
