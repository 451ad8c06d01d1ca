"""The plan scorers of both households under ``strict``."""

from __future__ import annotations

from eai.abilities.action_sequencing.scorer import ActionSequencingScorer
from eai.abilities.notation.plans import JsonPlanNotation
from eai.benchmarks.behavior import domain as behavior
from eai.benchmarks.behavior.tasks import BehaviorTask
from eai.benchmarks.virtualhome import domain as virtualhome
from eai.benchmarks.virtualhome.plan_notation import VirtualHomePlanNotation
from eai.tasks.task import Task


def virtualhome_scorer(task: Task) -> ActionSequencingScorer:
    """Return the scorer of a task in VirtualHome."""
    return ActionSequencingScorer(
        task, virtualhome.make_domain_with_checks_in_paper_order(), VirtualHomePlanNotation()
    )


def behavior_scorer(task: BehaviorTask) -> ActionSequencingScorer:
    """Return the scorer of a task in BEHAVIOR."""
    return ActionSequencingScorer(task, behavior.make_domain_with_checks_in_paper_order(), JsonPlanNotation())
