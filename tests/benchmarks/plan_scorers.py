"""The plan scorers of both households under ``strict``."""

from __future__ import annotations

from eai.abilities.action_sequencing.scorer import ActionSequencing
from eai.abilities.notation.plans import JsonPlans
from eai.benchmarks.behavior import domain as behavior
from eai.benchmarks.behavior.tasks import BehaviorTask
from eai.benchmarks.virtualhome import domain as virtualhome
from eai.benchmarks.virtualhome.plan_notation import VirtualHomePlans
from eai.tasks.task import Task


def virtualhome_scorer(task: Task) -> ActionSequencing:
    """Return the scorer of a task in VirtualHome."""
    return ActionSequencing(task, virtualhome.domain_in_paper_order(), VirtualHomePlans())


def behavior_scorer(task: BehaviorTask) -> ActionSequencing:
    """Return the scorer of a task in BEHAVIOR."""
    return ActionSequencing(task, behavior.domain_in_paper_order(), JsonPlans())
