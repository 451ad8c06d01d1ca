"""Make explanations: reports on the steps of a trajectory, on goals, and on parts of a temporal goal."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass

import eai.logic.formula as f
from eai.abilities.explanation import EXECUTED, SLIP, SLIPPED, GoalReport, PartReport, Statement, StepReport
from eai.logic.ltl_printer import print_ltl
from eai.logic.rewriting import rename_variables, substitute
from eai.logic.semantics import explain, find_violation
from eai.logic.traversal import walk
from eai.tasks.goal_text import formula_text
from eai.tasks.task import Task
from eai.world.action import Action, Fault
from eai.world.domain import Domain
from eai.world.execution import Trajectory, argument_names, to_trace, witnesses_of
from eai.world.fault import FaultKind
from eai.world.operator import Check
from eai.world.state import Fact, Scene, State, compare_states


def step_reports(task: Task, domain: Domain, trajectory: Trajectory) -> tuple[StepReport, ...]:
    """A report on every step of a trajectory that was tried."""
    focus = _Focus.of(task)
    reports = []
    carried_out: list[int] = []
    for number, (action, fault, slipped) in enumerate(trajectory.steps):
        before = trajectory.states[len(carried_out)]
        if fault is not None:
            tries = fault.check not in domain.compiled[action.operator].operator.checks
            undone = _undone(domain, action, before, before) if tries else ""
            reason = undone or _reason(fault.check, domain, action, before)
            earlier = _earlier(fault, trajectory, carried_out, task.scene)
            text, call = action_text(action, task.scene), call_of(action, task.scene)
            reports.append(StepReport(text, fault.kind.value, reason, earlier, call=call))
        elif slipped:
            call = call_of(action, task.scene)
            reports.append(StepReport(action_text(action, task.scene), SLIP, SLIPPED, call=call))
        else:
            carried_out.append(number)
            after = trajectory.states[len(carried_out)]
            reports.append(_executed(focus, domain, action, before, after))
    return tuple(reports)


@dataclass(frozen=True, slots=True)
class _Focus:
    """The changes of a task that are worth telling: what relates the agent to itself is not.

    Attributes:
        scene: the scene of the task.
        predicates: what can be seen.
        objects: the agent and what the task is about.
        goals: the objects that its goals name; all that it is about where they speak of any of a kind.
    """

    scene: Scene
    predicates: frozenset[str]
    objects: frozenset[int | None]
    goals: frozenset[int]

    @classmethod
    def of(cls, task: Task) -> _Focus:
        """The focus of a task."""
        scene = task.scene
        visible = frozenset(p.name for p in scene.vocabulary.predicates if p.visible)
        named: set[int] = set()
        for part in (part for goal in task.goals for part in walk(goal.formula)):
            match part:
                case f.ForAll() | f.Exists() | f.Exactly() | f.ForPairs():
                    named |= set(task.relevant)
                case f.Atom(_, terms):
                    named |= {i for term in terms if (i := scene.index.get(term.name)) is not None}
        return cls(scene, visible, frozenset({*task.relevant, scene.agent}), frozenset(named))

    def seen(self, facts: Iterable[Fact]) -> list[Fact]:
        """Those of the facts that can be seen."""
        itself = (self.scene.agent,) * 2
        return [fact for fact in facts if fact.predicate in self.predicates and fact.arguments != itself]

    def visible_texts(self, facts: Sequence[Fact], handled: Collection[int]) -> tuple[str, ...]:
        """Those of the facts that are worth telling of an action, as texts: about nothing but its objects.

        What holds both ways between two things, and not the agent, has to be about objects of goals or those
        that the action handles: a thing that is taken away was next to many.
        """
        meant = frozenset({*self.goals, *handled})
        together = frozenset(facts)
        texts = []
        for fact in facts:
            between_things = len(fact.arguments) == 2 and self.scene.agent not in fact.arguments
            both_ways = between_things and Fact(fact.predicate, fact.arguments[::-1]) in together
            if self.objects.issuperset(fact.arguments) and (
                not both_ways or meant.issuperset(fact.arguments)
            ):
                texts.append(fact_text(fact, self.scene))
        return tuple(texts)


def _executed(focus: _Focus, domain: Domain, action: Action, before: State, after: State) -> StepReport:
    difference = compare_states(before, after)
    added, removed = focus.seen(difference.added), focus.seen(difference.removed)
    placed = [fact.arguments[0] for fact in removed if len(fact.arguments) == 1]
    added_texts = focus.visible_texts(added, {*action.arguments, *placed})
    removed_texts = focus.visible_texts(removed, action.arguments)
    return StepReport(
        action_text(action, focus.scene),
        EXECUTED,
        reason=_undone(domain, action, before, after),
        added=added_texts,
        removed=removed_texts,
        hidden_changes=len(added) + len(removed) - len(added_texts) - len(removed_texts),
        call=call_of(action, focus.scene),
    )


def _undone(domain: Domain, action: Action, before: State, after: State) -> str:
    """In words, the things that an action with several to try leaves undone; empty for any other."""
    operator = domain.compiled[action.operator]
    if not operator.tries:
        return ""
    names = argument_names(action, domain, before.scene)
    objects: dict[f.Term, f.Term] = {f.Variable(name): f.Constant(thing) for name, thing in names.items()}
    undone = operator.find_failed_tries(before, after, operator.bind(before, action.arguments))
    return "; ".join(
        f"{print_ltl(substitute(condition, objects))} remains: {_reason(check, domain, action, before)}"
        for condition, check in undone
    )


def _reason(check: Check, domain: Domain, action: Action, state: State) -> str:
    """The fault of an action in a state, in words, and by name what the words leave without one."""
    reason = check.reason.format_map(argument_names(action, domain, state.scene))
    witnesses = witnesses_of(check, domain, action, state)
    return f"{reason}: {', '.join(witnesses)}" if witnesses else reason


def _earlier(fault: Fault, trajectory: Trajectory, carried_out: Sequence[int], scene: Scene) -> str:
    """When what an action lacks held; ``carried_out`` are the numbers of the steps that were executed."""
    if fault.kind is not FaultKind.WRONG_ORDER or fault.earlier is None:
        return ""
    if fault.earlier < 0:
        return "what it lacks held in an earlier attempt"
    if fault.earlier == 0:
        return "what it lacks held at the start"
    number = carried_out[fault.earlier - 1]
    action = action_text(trajectory.steps[number].action, scene)
    return f"what it lacks held after step {number + 1}, {action}"


def call_of(action: Action, scene: Scene) -> Statement:
    """A ground action as a value."""
    return Statement(action.operator, tuple([scene.objects[i].name for i in action.arguments]))


def action_text(action: Action, scene: Scene) -> str:
    """A ground action as ``GRAB(soap.1002)``."""
    return fact_text(Fact(action.operator, action.arguments), scene)


def fact_text(fact: Fact, scene: Scene) -> str:
    """A fact as ``INSIDE(soap.1002, cup.1003)``."""
    return f"{fact.predicate}({', '.join([scene.objects[i].name for i in fact.arguments])})"


UNTOLD = "untold hazard"
"""The kind of a goal of which who is asked is told nothing."""


def goal_reports(
    task: Task, satisfied: Sequence[bool], course: Trajectory | None = None
) -> tuple[GoalReport, ...]:
    """A report on each goal of a task; goals over time are those of a course, if there was one."""
    hazard = UNTOLD if task.untold else "hazard"
    kinds = [goal.kind.value for goal in task.goals[: len(task.goals) - len(task.hazards)]]
    return tuple(
        GoalReport(
            kind,
            formula_text(goal.formula),
            held,
            "" if held or course is None or not goal.is_over_time else _breach(goal.formula, course),
            _mentioned(goal.formula),
        )
        for kind, goal, held in zip(
            [*kinds, *[hazard] * len(task.hazards)], task.goals, satisfied, strict=True
        )
    )


def _mentioned(formula: f.Formula) -> tuple[str, ...]:
    names: dict[str, None] = {}
    for part in walk(formula):
        match part:
            case f.Atom(name, _) | f.Occurs(name, _):
                names[name] = None
    return tuple(names)


def _breach(formula: f.Formula, course: Trajectory) -> str:
    """Which part of a goal over time was violated, and when."""
    found = find_violation(formula, to_trace(course))
    what = formula_text(rename_variables(found.part))
    if found.position is None:
        follows = isinstance(formula, f.Then) and found.part != formula.parts[0]
        return f"never after what comes first: {what}" if follows else f"never: {what}"
    if found.position == 0:
        return f"at the start not {what}"
    action = action_text(course.executed[found.position - 1], course.final.scene)
    return f"violated after {action}: {what}"


def part_reports(goal: f.Formula | None, trajectory: Trajectory) -> tuple[PartReport, ...]:
    """A report on each part of a temporal goal in the words of the domain; none where there is no goal."""
    if goal is None:
        return ()
    evidence = explain(goal, to_trace(trajectory))
    parts = goal.parts if isinstance(goal, f.Then) else (goal,)
    met: list[int | None] = [*evidence.positions[: len(parts)]]
    blamed = [tuple([print_ltl(formula) for formula in evidence.failed])]
    numbers = [0, *(number for number, step in enumerate(trajectory.steps, 1) if step.executed)]
    reports = []
    for number, part in enumerate(parts):
        position = met[number] if number < len(met) else None
        if position is None:
            reports.append(PartReport(print_ltl(part), None, blamed.pop() if blamed else ()))
            continue
        acted = any(isinstance(each, f.Occurs) for each in walk(part)) and position + 1 < len(numbers)
        at = numbers[position + 1] if acted else None
        reports.append(PartReport(print_ltl(part), numbers[position], met_at=at))
    return tuple(reports)
