"""Action sequencing in BEHAVIOR: from an answer's text to a verdict."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from eai.abilities.action_sequencing import behavior_answer
from eai.abilities.action_sequencing.plan import (
    Rejected,
    Unreadable,
    WrittenPlan,
    WrittenStep,
    rejection_explained,
)
from eai.abilities.behavior_goals import BehaviorGoals
from eai.abilities.explanation import Explanation, goal_reports, repairs_told, step_reports
from eai.abilities.protocol import Protocol
from eai.abilities.scorer import Assessment, Scorer
from eai.abilities.verdict import ErrorReport, Verdict
from eai.benchmarks.behavior import domain as behavior
from eai.benchmarks.behavior.tasks import BehaviorTask
from eai.benchmarks.reference import behavior_plans as behavior_reference
from eai.world.domain import Domain
from eai.world.execution import Action, Trajectory, describe, execute
from eai.world.fault import FaultKind
from eai.world.state import State

_STRANGER = -1
"""The index of an object that there is not."""

_MAX_KNOWN = 1_000
"""How many steps a scorer remembers: answers to one task have most in common."""


class ActionSequencing(Scorer):
    """The scorer of one task under one protocol.

    A verdict's details hold ``goals_satisfied``: for each goal of the task, in order, whether it holds at the
    end. An answer that cannot be run meets no goal; in the reference it leaves the initial state.
    """

    def __init__(self, task: BehaviorTask, protocol: Protocol) -> None:
        self.task = task
        self.protocol = protocol
        self.domain = domain_of(protocol)
        self._initial = task.initial if protocol is Protocol.STRICT else task.initial_as_published
        self._arities = self.domain.arities
        self._goals = BehaviorGoals(task, protocol)
        self._known: dict[WrittenStep, Action] = {}

    def assess(self, text: str) -> Assessment:
        """The verdict on an answer, and what becomes of it step by step."""
        plan = self.read(text)
        if isinstance(plan, Unreadable):
            verdict = self._rejection(ErrorReport(FaultKind.PARSING, None, plan.reason), ())
            return Assessment(verdict, partial(Explanation, (f"parsing: {plan.reason}",)))
        actions = self.resolve(plan)
        if isinstance(actions, Rejected):
            verdict = self._rejection(actions.error, plan.repairs)
            return Assessment(
                verdict, partial(rejection_explained, repairs_told(plan.repairs), actions.error)
            )
        trajectory = execute(self.domain, self._initial, actions)
        verdict = self._judge(trajectory, plan.repairs)
        return Assessment(verdict, partial(self._explain, plan.repairs, trajectory))

    def _explain(self, repairs: tuple[str, ...], trajectory: Trajectory) -> Explanation:
        satisfied = self._goals.satisfied(_left_by(trajectory))
        return Explanation(
            repairs_told(repairs),
            step_reports(self.task, self.domain, trajectory),
            goal_reports(self.task.goals, satisfied),
        )

    def read(self, text: str) -> WrittenPlan | Unreadable:
        """The plan as written, or why there is none."""
        if self.protocol is Protocol.EAI_1_0_5:
            return behavior_reference.read_plan(text)
        return behavior_answer.read_plan(text)

    def resolve(self, plan: WrittenPlan) -> list[Action] | Rejected:
        """The plan as ground actions, or the first grammar error: of all names before of any arity."""
        actions = []
        misapplied = None
        for index, step in enumerate(plan.steps):
            action = self._known.get(step) or self._action(step)
            if action is None:
                return self._unknown(index, step)
            if misapplied is None and len(action.arguments) != self._arities[action.operator]:
                misapplied = index
            actions.append(action)
        return actions if misapplied is None else self._misapplied(misapplied, actions[misapplied])

    def _action(self, step: WrittenStep) -> Action | None:
        """The action that a step names, remembered for other answers; None if one of its names is unknown."""
        things = self.task.scene.index
        found = tuple([things.get(str(name).strip(), _STRANGER) for name in step.arguments])
        if step.action not in self._arities or _STRANGER in found:
            return None
        action = Action(step.action, found)
        if len(self._known) < _MAX_KNOWN:
            self._known[step] = action
        return action

    def _misapplied(self, index: int, action: Action) -> Rejected:
        """That an action has too many objects or too few."""
        name, objects = action
        detail = f"{name} takes {self._arities[name]} objects, not {len(objects)}"
        return Rejected(ErrorReport(FaultKind.ARGUMENT_NUMBER, index, detail))

    def _unknown(self, index: int, step: WrittenStep) -> Rejected:
        """What a step names that there is not: its action, or else its first such object."""
        detail = f"{step.action} is not an action"
        if step.action in self._arities:
            names = (str(name).strip() for name in step.arguments)
            stranger = next(name for name in names if name not in self.task.scene.index)
            detail = f"{step.action}: there is no {stranger}"
        return Rejected(ErrorReport(FaultKind.HALLUCINATION, index, detail))

    def _judge(self, trajectory: Trajectory, repairs: tuple[str, ...]) -> Verdict:
        failure = trajectory.failure
        error = None
        if failure is not None:
            step = len(trajectory.steps) - 1
            detail = describe(failure, self.domain, trajectory.steps[-1].action, self.task.scene)
            error = ErrorReport(failure.kind, step, detail)
        satisfied = self._goals.satisfied(_left_by(trajectory))
        return self._verdict(satisfied, error, trajectory.additional_steps, repairs)

    def _rejection(self, error: ErrorReport, repairs: tuple[str, ...]) -> Verdict:
        satisfied: Sequence[bool] = (False,) * len(self.task.goals)
        if self.protocol is Protocol.EAI_1_0_5:
            satisfied = self._goals.satisfied(self._initial)
        return self._verdict(satisfied, error, 0, repairs)

    def _verdict(
        self,
        satisfied: Sequence[bool],
        error: ErrorReport | None,
        additional_steps: int,
        repairs: tuple[str, ...],
    ) -> Verdict:
        return Verdict(
            executable=error is None,
            success=all(satisfied) and (error is None or self.protocol is Protocol.EAI_1_0_5),
            error=error,
            additional_steps=additional_steps,
            goals=self._goals.tallies(satisfied),
            repairs=repairs,
            details={"goals_satisfied": list(satisfied)},
        )


def _left_by(trajectory: Trajectory) -> State:
    """The state in which a plan leaves the world, which an action of the reference may leave half done."""
    failure = trajectory.failure
    if failure is not None and failure.kind is FaultKind.UNCATEGORISED:
        return behavior.half_done(trajectory.final, trajectory.steps[-1].action)
    return trajectory.final


def domain_of(protocol: Protocol) -> Domain:
    """The BEHAVIOR domain as a protocol has it."""
    return behavior.as_meant() if protocol is Protocol.STRICT else behavior.as_in_reference()
