"""The scorers of plans of both households under both protocols."""

from __future__ import annotations

from eai.abilities.action_sequencing.scorer import ActionSequencing
from eai.abilities.notation.plans import JsonPlans
from eai.abilities.protocol import Protocol
from eai.benchmarks.behavior import domain as behavior
from eai.benchmarks.behavior.tasks import BehaviorTask
from eai.benchmarks.virtualhome import domain as virtualhome
from eai.benchmarks.virtualhome.plan_notation import VirtualHomePlans
from eai.tasks.task import Task
from protocols import of_reference


def virtualhome_scorer(task: Task, protocol: Protocol, *, with_ids: bool | None = None) -> ActionSequencing:
    """The scorer of a task in VirtualHome; the reference can be told that objects have ids."""
    if protocol is Protocol("eai-1.0.5"):
        return of_reference("virtualhome_plans").VirtualHomeActionSequencing(task, with_ids=with_ids)
    return ActionSequencing(task, virtualhome.as_meant(), VirtualHomePlans())


def behavior_scorer(task: BehaviorTask, protocol: Protocol) -> ActionSequencing:
    """The scorer of a task in BEHAVIOR."""
    if protocol is Protocol("eai-1.0.5"):
        return of_reference("behavior_plans").BehaviorActionSequencing(task)
    return ActionSequencing(task, behavior.as_meant(), JsonPlans())
