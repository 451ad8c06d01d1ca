"""Explanations: what became of an answer step by step, in words, for people and for reports."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from eai.abilities.task import Goal, Task
from eai.logic.evidence import explain
from eai.logic.formula import Atom, Formula, Occurs, Or, Then
from eai.logic.ltl_printer import print_ltl
from eai.world.domain import Domain
from eai.world.execution import Action, Fault, Trajectory, describe
from eai.world.fault import FaultKind
from eai.world.state import Fact, Scene, change
from eai.world.timeline import timeline

SLIP = "slip"
"""The outcome of a step that was possible and did not work."""

SLIPPED = "it was possible, but it did not work"
"""What there is to say of such a step."""


@dataclass(frozen=True, slots=True)
class StepReport:
    """One step that was tried.

    Attributes:
        action: the ground action as text.
        outcome: ``executed``, the kind of the fault, or ``slip``.
        reason: which check failed, in words, or that it slipped; empty if it was executed.
        earlier: for a wrong order, after which earlier step the action would have been possible.
        added: facts that became true.
        removed: facts that became false.
        hidden_changes: how many more facts changed, about objects that the task is not about.
    """

    action: str
    outcome: str
    reason: str = ""
    earlier: str = ""
    added: tuple[str, ...] = ()
    removed: tuple[str, ...] = ()
    hidden_changes: int = 0


@dataclass(frozen=True, slots=True)
class GoalReport:
    """A goal of the task as text, its kind, and whether it was reached."""

    kind: str
    goal: str
    satisfied: bool


@dataclass(frozen=True, slots=True)
class PartReport:
    """A part of the task's temporal goal; its parts are to be met one after the other.

    Attributes:
        part: the part as text.
        met_after: how many executed steps came before the state in which it was first met after the part
            before it; None if it was not. An action belongs to the state in which it is taken.
        missing: if it is the first that was not met, what of it never held, as texts: the whole part where
            its pieces held only apart from each other.
    """

    part: str
    met_after: int | None
    missing: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Explanation:
    """What became of an answer.

    ``notes`` are sentences on the answer as a whole: why it could not be run, or how it was read. ``parts``
    are those of the task's temporal goal, if it has one.
    """

    notes: tuple[str, ...] = ()
    steps: tuple[StepReport, ...] = ()
    goals: tuple[GoalReport, ...] = ()
    parts: tuple[PartReport, ...] = ()


def repairs_told(repairs: Iterable[str]) -> tuple[str, ...]:
    """What there is to say of the repairs that reading an answer took."""
    return tuple(f"read with repair: {repair}" for repair in repairs)


def step_reports(task: Task, domain: Domain, trajectory: Trajectory) -> tuple[StepReport, ...]:
    """A report on every step of a trajectory that was tried."""
    focus = _Focus.of(task)
    reports = []
    executed = 0
    for step in trajectory.steps:
        if step.fault is not None:
            reports.append(_failed(task, domain, trajectory, step.action, step.fault))
        elif step.slipped:
            reports.append(StepReport(action_text(step.action, task.scene), SLIP, SLIPPED))
        else:
            reports.append(_executed(focus, trajectory, executed, step.action))
            executed += 1
    return tuple(reports)


@dataclass(frozen=True, slots=True)
class _Focus:
    """The facts of a task that are worth telling.

    Attributes:
        scene: the scene of the task.
        predicates: what can be seen.
        objects: the agent and what the task is about.
    """

    scene: Scene
    predicates: frozenset[str]
    objects: frozenset[int | None]

    @classmethod
    def of(cls, task: Task) -> _Focus:
        """The focus of a task."""
        scene = task.scene
        visible = frozenset(p.name for p in scene.vocabulary.predicates if p.visible)
        return cls(scene, visible, frozenset({*task.relevant, scene.agent}))

    def told(self, facts: Iterable[Fact]) -> tuple[str, ...]:
        """Those of the facts that are visible, and about nothing but its objects, as texts."""
        return tuple(
            [
                fact_text(fact, self.scene)
                for fact in facts
                if fact.predicate in self.predicates and self.objects.issuperset(fact.arguments)
            ]
        )


def _executed(focus: _Focus, trajectory: Trajectory, index: int, action: Action) -> StepReport:
    difference = change(trajectory.states[index], trajectory.states[index + 1])
    added = focus.told(difference.added)
    removed = focus.told(difference.removed)
    visible = len(added) + len(removed)
    return StepReport(
        action_text(action, focus.scene),
        "executed",
        added=added,
        removed=removed,
        hidden_changes=len(difference.added) + len(difference.removed) - visible,
    )


def _failed(task: Task, domain: Domain, trajectory: Trajectory, action: Action, fault: Fault) -> StepReport:
    earlier = ""
    if fault.kind is FaultKind.WRONG_ORDER and fault.earlier is not None:
        before = trajectory.executed[fault.earlier - 1] if fault.earlier else None
        step = f"step {fault.earlier}, {action_text(before, task.scene)}" if before else "the start"
        earlier = f"it would have been possible after {step}"
    reason = describe(fault, domain, action, task.scene)
    return StepReport(action_text(action, task.scene), fault.kind.value, reason, earlier)


def action_text(action: Action, scene: Scene) -> str:
    """A ground action as ``GRAB(soap.1002)``."""
    return fact_text(Fact(action.operator, action.arguments), scene)


def fact_text(fact: Fact, scene: Scene) -> str:
    """A fact as ``INSIDE(soap.1002, cup.1003)``."""
    return f"{fact.predicate}({', '.join([scene.objects[i].name for i in fact.arguments])})"


def goal_reports(goals: Sequence[Goal], satisfied: Sequence[bool]) -> tuple[GoalReport, ...]:
    """A report on each goal."""
    return tuple(
        GoalReport(goal.kind.value, formula_text(goal.formula), held)
        for goal, held in zip(goals, satisfied, strict=True)
    )


def part_reports(goal: Formula | None, trajectory: Trajectory) -> tuple[PartReport, ...]:
    """A report on each part of a temporal goal in the words of the domain; none where there is no goal."""
    if goal is None:
        return ()
    evidence = explain(goal, timeline(trajectory))
    parts = goal.parts if isinstance(goal, Then) else (goal,)
    met: list[int | None] = [*evidence.positions[: len(parts)]]
    blamed = [tuple([print_ltl(formula) for formula in evidence.failed])]
    reports = []
    for number, part in enumerate(parts):
        after = met[number] if number < len(met) else None
        missing = blamed.pop() if after is None and blamed else ()
        reports.append(PartReport(print_ltl(part), after, missing))
    return tuple(reports)


def formula_text(formula: Formula) -> str:
    """A goal's formula as a short text: alternatives of actions by name, all else as the paper's LTL."""
    match formula:
        case Atom(predicate, arguments):
            names = (t.name for t in arguments)
            return f"{predicate}({', '.join(names)})"
        case Occurs(action):
            return action
        case Or(operands):
            return " or ".join(formula_text(operand) for operand in operands)
        case _:
            return print_ltl(formula)
