"""Measure a task: counts of its goals, objects and plan steps, and its expected difficulty.

A ridge regression predicts the difficulty of a task from its plan and goals. It was fitted to the published
tasks of a household (by ``tools/task_difficulty.py``): their difficulty in action sequencing for nine of the
paper's models (`eai.extensions.adaptive.difficulties`), in logits relative to the models' mean ability. A
single estimate is uncertain. Its error is estimated by the root mean squared error for titles that were left
out of the fit.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import cache
from importlib import resources
from itertools import pairwise, takewhile
from typing import NamedTuple

import eai.logic.formula as f
from eai.logic.traversal import find_object_names, get_bound_variables, get_subformulas, walk_subformulas
from eai.tasks.task import Task
from eai.world.derived import DefinedPredicate
from eai.world.domain import Domain
from eai.world.execution import execute_plan
from eai.world.frame import AGENT
from eai.world.operator import Operator
from eai.world.relation import iterate_bits, make_mask
from eai.world.state import Scene, State
from eai.world.vocabulary import Vocabulary

FILE = "difficulty.json"

FEATURES = ("log steps", "operators", "log goals")
"""Names of the features that predict difficulty: log(plan steps), number of operators, log(1 + goals)."""


def compute_difficulty_features(task: Task) -> Sequence[float]:
    """Return the features of a task that predict its difficulty (`FEATURES`). The task must have a plan."""
    steps = [action.operator for action in task.script]
    return math.log(len(steps)), float(len(set(steps))), math.log(1 + len(task.goals))


@dataclass(frozen=True, slots=True)
class _DifficultyModel:
    """The regression that estimates the difficulty of tasks in one household.

    Attributes:
        intercept: difficulty of a task whose features are all zero.
        weights: change of difficulty per unit of each feature.
        error: root mean squared error of an estimate for a task whose title was not used in the fit.
        r_squared: share (0 to 1) of the variance of the published tasks' difficulties that the estimates
            explain.
        rank_correlation: Spearman correlation of the estimates with the published tasks' difficulties.
    """

    intercept: float
    weights: Sequence[float]
    error: float
    r_squared: float
    rank_correlation: float

    def estimate_difficulty(self, task: Task) -> float | None:
        """Return the expected difficulty of a task in logits, or None if the task has no plan."""
        if not task.script:
            return None
        terms = zip(self.weights, compute_difficulty_features(task), strict=True)
        value = self.intercept + sum([weight * feature for weight, feature in terms])
        return round(value, 2)


def get_difficulty_model(domain: str) -> _DifficultyModel | None:
    """Return the model that estimates the difficulty of a benchmark's tasks, or None if it has no model.

    Only benchmarks for which answers of several language models are published have a difficulty model.
    """
    return _read_difficulty_models().get(domain)


@cache
def _read_difficulty_models() -> Mapping[str, _DifficultyModel]:
    text = (resources.files("eai.benchmarks.generator") / FILE).read_text(encoding="utf-8")
    return {name: _DifficultyModel(**coefficients) for name, coefficients in json.loads(text).items()}


class TaskMeasure(str, Enum):
    """A number that is counted for a task, such as the number of steps of its plan."""

    STEPS = "steps"
    """Number of steps of the plan that solves the task."""
    GOALS = "goals"
    OPERATORS = "operators"
    """Number of different operators in the plan that solves the task."""
    DISTRACTORS = "distractors"
    """Number of objects that neither the goals nor the plan need."""
    CONTAINERS = "containers"
    """Number of containers that are shut and hide their contents until the plan opens them."""
    HIDDEN = "hidden"
    """Number of objects, needed by goals or plan, that are invisible until the plan opens a container."""
    TOOL_STEPS = "tool_steps"
    """Number of plan steps that need a tool, such as a knife, which is not among their arguments."""


class _PredicateShowingOrHidingContents(NamedTuple):
    """A state of a container, such as being open, that decides whether its contents are visible.

    Attributes:
        predicate: the predicate of the state.
        reveals: True if the contents are visible while the predicate holds, False if it hides them.
    """

    predicate: str
    reveals: bool


def measure_task(task: Task, domain: Domain) -> Mapping[TaskMeasure, int]:
    """Return a mapping from each measure to its value for a task."""
    needed, tools = find_objects_of_goals_and_plan(task), find_operators_needing_implicit_tool(domain)
    operators = [action.operator for action in task.script]
    containers, hidden = _find_opened_containers_and_revealed_objects(task, needed, domain)
    return {
        TaskMeasure.STEPS: len(operators),
        TaskMeasure.GOALS: len(task.goals),
        TaskMeasure.OPERATORS: len(set(operators)),
        TaskMeasure.DISTRACTORS: len(task.scene.objects) - len(needed),
        TaskMeasure.CONTAINERS: len(containers),
        TaskMeasure.HIDDEN: len(hidden),
        TaskMeasure.TOOL_STEPS: sum(operator in tools for operator in operators),
    }


def _find_opened_containers_and_revealed_objects(
    task: Task, needed_objects: set[int], domain: Domain
) -> tuple[set[int], set[int]]:
    """Return the containers that the plan opens, and the needed objects that thereby become visible."""
    containers: set[int] = set()
    hidden: set[int] = set()
    needed_mask = make_mask(needed_objects)
    opening_lids, arities = set(find_predicates_showing_or_hiding_contents(domain)), domain.operator_arities
    known = takewhile(lambda step: arities.get(step.operator) == len(step.arguments), task.script)
    states = execute_plan(domain, task.initial, known).states if opening_lids else ()
    for before, after in pairwise(states):
        opened = {i for lid in opening_lids for i in _find_containers_opened_between(lid, before, after)}
        if opened:
            containers |= opened
            visible_before = domain.visible_object_filter(before, needed_mask)
            hidden |= set(iterate_bits(domain.visible_object_filter(after, needed_mask) & ~visible_before))
    return containers, hidden


def _find_containers_opened_between(
    visibility: _PredicateShowingOrHidingContents, before: State, after: State
) -> Iterator[int]:
    then, now = before.mask(visibility.predicate), after.mask(visibility.predicate)
    return iterate_bits(now & ~then if visibility.reveals else then & ~now)


def find_predicates_showing_or_hiding_contents(domain: Domain) -> Iterator[_PredicateShowingOrHidingContents]:
    """Yield the states of containers, such as being open, that decide whether objects in them are visible."""
    if domain.visible is not None:
        yield from _yield_predicates_showing_or_hiding_contents(
            domain.vocabulary, domain.visible, frozenset({"x"}), (), reveals=True
        )


def find_operators_needing_implicit_tool(domain: Domain) -> frozenset[str]:
    """Return names of operators that need a tool which their arguments do not name, such as a knife."""
    kinds = {p.name for p in domain.vocabulary.predicates if p.static and p.arity == 1}
    return frozenset(operator.name for operator in domain.operators if _requires_tool(operator, kinds))


def _requires_tool(operator: Operator, kinds: set[str]) -> bool:
    checks = [*operator.checks, *(check for option in operator.alternatives for check in option.checks)]
    return any(_requires_object_of_kind(check.condition, kinds) for check in checks)


def _requires_object_of_kind(formula: f.Formula, kinds: set[str]) -> bool:
    """Whether a formula requires an object of some kind in `kinds` to exist.

    Negated conditions do not count.
    """
    if isinstance(formula, f.Not):
        return False
    if isinstance(formula, f.Exists):
        return any(
            isinstance(subformula, f.Atom) and subformula.predicate in kinds
            for subformula in walk_subformulas(formula.body)
        )
    return any(_requires_object_of_kind(subformula, kinds) for subformula in get_subformulas(formula))


def make_formula_that_object_x_exists(domain: Domain) -> f.Formula:
    """Return the formula that holds if the object ``x`` exists in the scene.

    The formula consists of the domain's conditions for the visibility of ``x`` that depend neither on
    containers nor on the agent. For example, half an apple does not exist before the apple is cut.
    """
    visible = domain.visible or f.TRUE
    parts = f.get_operands(visible, f.And)
    return f.And(
        tuple([part for part in parts if _is_independent_of_containers_and_agent(domain.vocabulary, part)])
    )


def _is_independent_of_containers_and_agent(vocabulary: Vocabulary, condition: f.Formula) -> bool:
    """Whether a condition on ``x`` depends neither on the state of a container nor on the agent."""
    variable = frozenset({"x"})
    has_lid = any(
        True
        for _ in _yield_predicates_showing_or_hiding_contents(
            vocabulary, condition, variable, (), reveals=True
        )
    )
    return not has_lid and all(
        AGENT not in atom.arguments for atom in _find_atoms_in_formula_and_definitions(vocabulary, condition)
    )


def _find_atoms_in_formula_and_definitions(vocabulary: Vocabulary, formula: f.Formula) -> Iterator[f.Atom]:
    """Yield the atoms of a formula, and of the definitions of its derived predicates."""
    pending, defined = [formula], set[str]()
    while pending:
        for part in walk_subformulas(pending.pop()):
            if isinstance(part, f.Atom):
                yield part
                derived = vocabulary.derived_by_name.get(part.predicate)
                if isinstance(derived, DefinedPredicate) and part.predicate not in defined:
                    defined.add(part.predicate)
                    pending.append(derived.definition)


def _yield_predicates_showing_or_hiding_contents(
    vocabulary: Vocabulary,
    formula: f.Formula,
    object_variables: frozenset[str],
    expanded_predicates: tuple[str, ...],
    *,
    reveals: bool,
) -> Iterator[_PredicateShowingOrHidingContents]:
    """Yield the predicates of containers, such as *open*, that decide whether an object is visible.

    The formula is the condition for its visibility. Variables in `object_variables` stand for the object, all
    other variables for containers.
    """
    match formula:
        case f.Not(operand):
            yield from _yield_predicates_showing_or_hiding_contents(
                vocabulary, operand, object_variables, expanded_predicates, reveals=not reveals
            )
        case f.Atom(name, terms):
            stored, derived = vocabulary.find_stored_predicate(name), vocabulary.derived_by_name.get(name)
            variables = [term.name if isinstance(term, f.Variable) else None for term in terms]
            if stored is not None and not stored.static and len(variables) == 1:
                if variables[0] is not None and variables[0] not in object_variables:
                    yield _PredicateShowingOrHidingContents(name, reveals)
            elif isinstance(derived, DefinedPredicate) and name not in expanded_predicates:
                pairs = zip(derived.parameters, variables, strict=True)
                inner = frozenset([parameter.name for parameter, name in pairs if name in object_variables])
                yield from _yield_predicates_showing_or_hiding_contents(
                    vocabulary, derived.definition, inner, (*expanded_predicates, name), reveals=reveals
                )
        case _:
            for part in get_subformulas(formula):
                yield from _yield_predicates_showing_or_hiding_contents(
                    vocabulary, part, object_variables, expanded_predicates, reveals=reveals
                )


def find_objects_of_goals_and_plan(task: Task) -> set[int]:
    """Return the indices of the agent and of all objects that the goals or the plan need.

    A goal needs the objects that it names, and the objects over which its quantifiers range.
    """
    used = {index for action in task.script for index in action.arguments}
    goal_objects = {index for goal in task.goals for index in find_goal_objects(goal.formula, task.scene)}
    return used | goal_objects | {i for i in (task.scene.agent,) if i is not None}


def find_goal_objects(goal: f.Formula, scene: Scene) -> Iterator[int]:
    """Yield the indices of objects that a goal names, and of objects over which its quantifiers range."""
    yield from (scene.index[name] for name in find_object_names(goal))
    for part in walk_subformulas(goal):
        for variable in get_bound_variables(part):
            yield from iterate_bits(scene.get_category_mask(variable.category))
