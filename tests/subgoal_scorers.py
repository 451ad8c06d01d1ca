"""The scorers of subgoals under each protocol."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from eai.abilities.protocol import Protocol
from eai.abilities.subgoal_decomposition.refinement import Refinement
from eai.abilities.subgoal_decomposition.scorer import SubgoalDecomposition
from eai.abilities.subgoal_decomposition.search import ExplorationLimits
from eai.benchmarks.behavior import domain as behavior
from eai.benchmarks.behavior.notation import BehaviorSubgoals
from eai.benchmarks.behavior.tasks import BehaviorTask
from eai.benchmarks.virtualhome import domain as virtualhome
from eai.benchmarks.virtualhome.notation import VirtualHomeSubgoals
from eai.tasks.task import Task
from protocols import of_reference


def virtualhome_subgoals(
    protocol: Protocol, limits: ExplorationLimits | None = None
) -> Callable[[Task], SubgoalDecomposition]:
    """What makes the scorer of a VirtualHome task."""
    if protocol is Protocol("eai-1.0.5"):
        return partial(of_reference("virtualhome_subgoals").VirtualHomeSubgoalDecomposition, limits=limits)
    domain, notation = virtualhome.with_either_hand(), VirtualHomeSubgoals()
    refinement = Refinement(domain)
    return lambda task: SubgoalDecomposition(task, domain, notation, refinement, limits=limits)


def behavior_subgoals(
    protocol: Protocol, limits: ExplorationLimits | None = None
) -> Callable[[BehaviorTask], SubgoalDecomposition]:
    """What makes the scorer of a BEHAVIOR task."""
    if protocol is Protocol("eai-1.0.5"):
        return partial(of_reference("behavior_subgoals").BehaviorSubgoalDecomposition, limits=limits)
    domain, notation = behavior.as_meant(), BehaviorSubgoals()
    refinement = Refinement(domain)
    return lambda task: SubgoalDecomposition(task, domain, notation, refinement, limits=limits)
