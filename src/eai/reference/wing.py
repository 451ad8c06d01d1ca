"""The wing of the reference: how protocol `eai-1.0.5` opens the suites of the two households."""

from __future__ import annotations

from typing import TYPE_CHECKING

from eai.abilities.protocol import Ability
from eai.benchmark.benchmark import Benchmark, Form, Opened
from eai.tasks.source import Source, TaskSet

if TYPE_CHECKING:
    from eai.abilities.transition_modeling.task import TransitionTask


def virtualhome_wing(benchmark: Benchmark, ability: Ability, form: Form, source: Source) -> Opened:
    """A suite of VirtualHome. All answers to plans have ids, or none has: ``form`` says which."""
    if ability is Ability.TRANSITION_MODELING:
        return _transition_modeling(benchmark, benchmark.operators(source), source)
    from eai.households.virtualhome.benchmark import open_tasks

    tasks, task_ids = open_tasks(source), tuple(benchmark.tasks_for(ability, source))
    match ability:
        case Ability.ACTION_SEQUENCING:
            from eai.reference.virtualhome_plans import VirtualHomeActionSequencing as Plans
            from eai.reference.virtualhome_plans import written_with_ids

            return Opened(task_ids, tasks.sha256, lambda i: Plans(tasks[i], with_ids=form), written_with_ids)
        case Ability.GOAL_INTERPRETATION:
            from eai.reference.virtualhome_goals import ByLargestId

            return Opened(task_ids, tasks.sha256, lambda i: ByLargestId(tasks[i], benchmark.domain))
        case Ability.SUBGOAL_DECOMPOSITION:
            from eai.reference.virtualhome_subgoals import (
                VirtualHomeSubgoalDecomposition as Subgoals,
            )

            return Opened(task_ids, tasks.sha256, lambda i: Subgoals(tasks[i]))


def behavior_wing(benchmark: Benchmark, ability: Ability, form: Form, source: Source) -> Opened:
    """A suite of BEHAVIOR.

    Of operators the names are those in the data set: ``extract_action_details`` reads a name up to its first
    hyphen, so that the reference finds the one that has a hyphen in no answer, not in the data set's own.
    """
    if ability is Ability.TRANSITION_MODELING:
        return _transition_modeling(benchmark, benchmark.operators(source), source)
    from eai.households.behavior.benchmark import open_tasks

    tasks = open_tasks(source)
    match ability:
        case Ability.ACTION_SEQUENCING:
            from eai.reference.behavior_plans import BehaviorActionSequencing as Plans

            return Opened(tuple(tasks), tasks.sha256, lambda task_id: Plans(tasks[task_id]))
        case Ability.GOAL_INTERPRETATION:
            from eai.reference.behavior_goals import ByFirstOption as Goals

            return Opened(tuple(tasks), tasks.sha256, lambda task_id: Goals(tasks[task_id]))
        case Ability.SUBGOAL_DECOMPOSITION:
            from eai.reference.behavior_subgoals import BehaviorSubgoalDecomposition as Subgoals

            return Opened(tuple(tasks), tasks.sha256, lambda task_id: Subgoals(tasks[task_id]))


def _transition_modeling(benchmark: Benchmark, tasks: TaskSet[TransitionTask], source: Source) -> Opened:
    from eai.abilities.transition_modeling.planners import make_planner
    from eai.abilities.transition_modeling.scorer import TransitionModeling
    from eai.reference.operator_rules import ReferenceRules

    rules = ReferenceRules.with_planner(make_planner(source.planner, benchmark.planner_seconds, source.terms))
    return Opened(tuple(tasks), tasks.sha256, lambda task_id: TransitionModeling(tasks[task_id], rules))
