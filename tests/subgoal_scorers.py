"""Scorers of subgoals of both households under ``strict``."""

from __future__ import annotations

from collections.abc import Callable

from eai.abilities.subgoal_decomposition.refinement import SubgoalRefiner
from eai.abilities.subgoal_decomposition.scorer import SubgoalDecompositionScorer
from eai.abilities.subgoal_decomposition.search import ExplorationLimits
from eai.benchmarks.behavior import domain as behavior
from eai.benchmarks.behavior.notation import BehaviorSubgoalNotation
from eai.benchmarks.behavior.tasks import BehaviorTask
from eai.benchmarks.virtualhome import domain as virtualhome
from eai.benchmarks.virtualhome.notation import VirtualHomeSubgoalNotation
from eai.tasks.task import Task


def virtualhome_subgoals(
    limits: ExplorationLimits | None = None,
) -> Callable[[Task], SubgoalDecompositionScorer]:
    """Return a function that makes the scorer of a VirtualHome task."""
    domain, notation = virtualhome.make_domain_with_switch_hands_action(), VirtualHomeSubgoalNotation()
    refinement = SubgoalRefiner(domain)
    return lambda task: SubgoalDecompositionScorer(task, domain, notation, refinement, limits=limits)


def behavior_subgoals(
    limits: ExplorationLimits | None = None,
) -> Callable[[BehaviorTask], SubgoalDecompositionScorer]:
    """Return a function that makes the scorer of a BEHAVIOR task."""
    domain, notation = behavior.make_domain_with_checks_in_paper_order(), BehaviorSubgoalNotation()
    refinement = SubgoalRefiner(domain)
    return lambda task: SubgoalDecompositionScorer(task, domain, notation, refinement, limits=limits)
