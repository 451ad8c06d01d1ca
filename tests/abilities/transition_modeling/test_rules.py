"""Operators that make every atom true: a planner finds a plan for every goal, and no plan works."""

from __future__ import annotations

import json
from collections.abc import Callable
from itertools import islice

import pytest

from eai.abilities.transition_modeling.rules import PaperOperatorScoringRules
from eai.abilities.transition_modeling.scorer import TransitionModelingScorer
from eai.abilities.transition_modeling.verdict import OperatorVerdict
from eai.base.store import DataPackStore
from eai.benchmarks.published import (
    TransitionTasks,
    open_behavior_transition_tasks,
    open_virtualhome_transition_tasks,
)
from eai.pddl.model import PddlPredicate, get_variable_type
from eai.pddl.planning import PlannerOutcome
from eai.pddl.search import BuiltInPlanner
from eai.tasks.operator_task import TransitionTask
from eai.tasks.source import Source


def everything(predicates: tuple[PddlPredicate, ...]) -> str:
    """Return the effect that makes every atom true."""
    parts = []
    for predicate in predicates:
        part = f"({predicate.name} {' '.join(f'?x{i}' for i in range(len(predicate.parameters)))})"
        for place, variable in enumerate(predicate.parameters):
            part = f"(forall (?x{place} - {get_variable_type(variable)}) {part})"
        parts.append(part)
    return f"(and {' '.join(parts)})"


def write_all_true_operators(task: TransitionTask, *, with_parameters: bool) -> str:
    """Return operators without precondition that make every atom true, with or without gold parameters."""
    effect = everything(task.domain.header.predicates)
    operators = []
    for name, gold in task.gold_operators.items():
        taken = gold.parameters if with_parameters else ()
        parameters = " ".join(f"?{each.name} - {get_variable_type(each)}" for each in taken)
        operators.append(f"(:action {name} :parameters ({parameters}) :precondition () :effect {effect})")
    return json.dumps({"output": "\n".join(operators)})


@pytest.mark.parametrize("with_parameters", [False, True])
@pytest.mark.parametrize(
    ("open_tasks", "step"), [(open_virtualhome_transition_tasks, 25), (open_behavior_transition_tasks, 8)]
)
def test_operators_that_assert_everything_have_plans_and_none_works(
    open_tasks: Callable[[Source], TransitionTasks],
    step: int,
    with_parameters: bool,
    data_store: DataPackStore,
) -> None:
    tasks = open_tasks(Source(data_store))
    rules = PaperOperatorScoringRules(BuiltInPlanner())
    planned = 0
    for task in islice(tasks.values(), 0, None, step):
        text = write_all_true_operators(task, with_parameters=with_parameters)
        verdict = TransitionModelingScorer(task, rules).score(text)
        assert isinstance(verdict, OperatorVerdict)
        planned += verdict.planner is PlannerOutcome.SOLVED
        assert (verdict.plan_works, verdict.success) == (False, False), task.id
    assert planned >= 3
