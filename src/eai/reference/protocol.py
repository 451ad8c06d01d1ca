"""Protocol `eai-1.0.5` as one value: how it opens the suites of two households, and its published runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING

from eai.abilities.protocol import Ability
from eai.benchmark.benchmark import Benchmark, Opened, Opener
from eai.benchmark.protocols import Implementation
from eai.errors import InputError
from eai.reference.published_runs import (
    NAME,
    ScriptedTrial,
    as_the_paper_asked,
    counted_as_published,
    scripted_experiment,
)
from eai.tasks.source import Source, TaskSet

if TYPE_CHECKING:
    from eai.abilities.transition_modeling.task import TransitionTask


def open_virtualhome(
    benchmark: Benchmark, ability: Ability, source: Source, *, with_ids: bool | None = None
) -> Opened:
    """A suite of VirtualHome.

    Args:
        benchmark: the benchmark.
        ability: the ability.
        source: where the data comes from.
        with_ids: whether answers to plans have ids: all, or none; None looks at each.
    """
    if ability is Ability.TRANSITION_MODELING:
        return _transition_modeling(benchmark, benchmark.operators(source), source)
    from eai.households.virtualhome.benchmark import open_tasks

    tasks, task_ids = open_tasks(source), tuple(benchmark.tasks_for(ability, source))
    match ability:
        case Ability.ACTION_SEQUENCING:
            from eai.reference.virtualhome_plans import VirtualHomeActionSequencing as Plans

            return Opened(
                task_ids, tasks.sha256, lambda i: Plans(tasks[i], with_ids=with_ids), _read_together
            )
        case Ability.GOAL_INTERPRETATION:
            from eai.reference.virtualhome_goals import ByLargestId

            return Opened(task_ids, tasks.sha256, lambda i: ByLargestId(tasks[i], benchmark.domain))
        case Ability.SUBGOAL_DECOMPOSITION:
            from eai.reference.virtualhome_subgoals import VirtualHomeSubgoalDecomposition as Subgoals

            return Opened(task_ids, tasks.sha256, lambda i: Subgoals(tasks[i]))
        case _:
            raise _unscored(f"{benchmark.name} {ability.value}")


def _read_together(answers: Sequence[str]) -> Opener:
    """Plans of one file are read with ids, or without, as most of them are written."""
    from eai.reference.virtualhome_plans import written_with_ids

    return partial(open_virtualhome, with_ids=written_with_ids(answers))


def open_behavior(benchmark: Benchmark, ability: Ability, source: Source) -> Opened:
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
        case _:
            raise _unscored(f"{benchmark.name} {ability.value}")


def _transition_modeling(benchmark: Benchmark, tasks: TaskSet[TransitionTask], source: Source) -> Opened:
    from eai.abilities.transition_modeling.planners import make_planner
    from eai.abilities.transition_modeling.scorer import TransitionModeling
    from eai.reference.operator_rules import ReferenceRules

    rules = ReferenceRules(make_planner(source.planner, benchmark.planner_seconds, source.terms))
    return Opened(tuple(tasks), tasks.sha256, lambda task_id: TransitionModeling(tasks[task_id], rules))


_OPENERS: Mapping[str, Opener] = {"virtualhome": open_virtualhome, "behavior": open_behavior}


def open_suite(benchmark: Benchmark, ability: Ability, source: Source) -> Opened:
    """A suite of one of the two households.

    Raises:
        InputError: the benchmark is another one, or the ability none of the paper's.
    """
    if benchmark.name not in _OPENERS:
        raise _unscored(benchmark.name)
    return _OPENERS[benchmark.name](benchmark, ability, source)


def _unscored(suite: str) -> InputError:
    return InputError(f"{suite} is not scored under {NAME}")


EAI_1_0_5 = Implementation(
    open_suite,
    experiment=scripted_experiment,
    trial=ScriptedTrial,
    as_asked=as_the_paper_asked,
    as_counted=counted_as_published,
)
"""The protocol."""
