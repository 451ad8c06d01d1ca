"""Make the reports of an explanation: on each step of a trajectory, each goal and each part of a goal."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass

import eai.logic.formula as f
from eai.abilities.explanation import (
    EXECUTED,
    SLIP,
    SLIPPED,
    AtomOrAction,
    GoalPartReport,
    GoalReport,
    StepReport,
)
from eai.logic.ltl_printer import format_ltl
from eai.logic.rewriting import standardize_variable_names, substitute_terms
from eai.logic.semantics import explain_truth, find_violation
from eai.logic.traversal import walk_subformulas
from eai.tasks.goal_text import write_goal
from eai.tasks.special import HazardousTaskMark
from eai.tasks.task import Task
from eai.world.action import Action, Fault
from eai.world.domain import Domain
from eai.world.execution import (
    Trajectory,
    find_objects_explaining_failed_check,
    map_parameters_to_names,
    to_trace,
)
from eai.world.fault import FaultKind
from eai.world.operator import Check
from eai.world.state import Fact, Scene, State, compare_states


def report_steps(task: Task, domain: Domain, trajectory: Trajectory) -> tuple[StepReport, ...]:
    """Return a report on each tried step of a trajectory."""
    fact_filter = _FactFilter.from_task(task)
    reports = []
    carried_out: list[int] = []
    for number, (action, fault, slipped) in enumerate(trajectory.steps):
        before = trajectory.states[len(carried_out)]
        if fault is not None:
            tries = fault.check not in domain.compiled_operators[action.operator].operator.checks
            undone = _describe_failed_effects(domain, action, before, before) if tries else ""
            reason = undone or _describe_fault(fault.check, domain, action, before)
            earlier = _describe_when_condition_held(fault, trajectory, carried_out, task.scene)
            text, call = action_text(action, task.scene), to_action_with_object_names(action, task.scene)
            reports.append(StepReport(text, fault.kind.value, reason, earlier, call=call))
        elif slipped:
            call = to_action_with_object_names(action, task.scene)
            reports.append(StepReport(action_text(action, task.scene), SLIP, SLIPPED, call=call))
        else:
            carried_out.append(number)
            after = trajectory.states[len(carried_out)]
            reports.append(_report_executed_action(fact_filter, domain, action, before, after))
    return tuple(reports)


@dataclass(frozen=True, slots=True)
class _FactFilter:
    """Selects the changed facts that a report on a step shows.

    It hides relations of the agent to itself.

    Attributes:
        scene: the scene of the task.
        predicates: the visible predicates, which prompts may mention.
        objects: the agent and the objects that matter to the task.
        goals: the objects in the task's goals; if goals quantify over a class, all objects that matter to the
            task.
    """

    scene: Scene
    predicates: frozenset[str]
    objects: frozenset[int | None]
    goals: frozenset[int]

    @classmethod
    def from_task(cls, task: Task) -> _FactFilter:
        scene = task.scene
        visible = frozenset(p.name for p in scene.vocabulary.predicates if p.visible)
        named: set[int] = set()
        for part in (part for goal in task.goals for part in walk_subformulas(goal.formula)):
            match part:
                case f.ForAll() | f.Exists() | f.Exactly() | f.ForPairs():
                    named |= set(task.relevant)
                case f.Atom(_, terms):
                    named |= {i for term in terms if (i := scene.index.get(term.name)) is not None}
        return cls(scene, visible, frozenset({*task.relevant, scene.agent}), frozenset(named))

    def select_visible_facts(self, facts: Iterable[Fact]) -> list[Fact]:
        """Return the facts with visible predicates, without relations of the agent to itself."""
        itself = (self.scene.agent,) * 2
        return [fact for fact in facts if fact.predicate in self.predicates and fact.arguments != itself]

    def write_visible_facts(self, facts: Sequence[Fact], action_objects: Collection[int]) -> tuple[str, ...]:
        """Return the facts that the report on an action shows, as texts.

        These facts are about objects that matter to the task. A symmetric relation is among them only if
        both objects occur in the goals or the action. Otherwise the report on an object that moves would
        name all of its many neighbours.
        """
        meant = frozenset({*self.goals, *action_objects})
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


def _report_executed_action(
    fact_filter: _FactFilter, domain: Domain, action: Action, before: State, after: State
) -> StepReport:
    difference = compare_states(before, after)
    added = fact_filter.select_visible_facts(difference.added)
    removed = fact_filter.select_visible_facts(difference.removed)
    placed = [fact.arguments[0] for fact in removed if len(fact.arguments) == 1]
    added_texts = fact_filter.write_visible_facts(added, {*action.arguments, *placed})
    removed_texts = fact_filter.write_visible_facts(removed, action.arguments)
    return StepReport(
        action_text(action, fact_filter.scene),
        EXECUTED,
        reason=_describe_failed_effects(domain, action, before, after),
        added=added_texts,
        removed=removed_texts,
        hidden_changes=len(added) + len(removed) - len(added_texts) - len(removed_texts),
        call=to_action_with_object_names(action, fact_filter.scene),
    )


def _describe_failed_effects(domain: Domain, action: Action, before: State, after: State) -> str:
    """Return a text on the alternatives (ways to act) of an executed action that failed, with the reasons.

    Each `OperatorAlternative` has its own condition and checks. It failed if one of its checks failed and its
    condition still holds after the action. The text is empty if no alternative failed.
    """
    operator = domain.compiled_operators[action.operator]
    if not operator.alternatives:
        return ""
    names = map_parameters_to_names(action, domain, before.scene)
    objects: dict[f.Term, f.Term] = {
        f.Variable(name): f.Constant(object_name) for name, object_name in names.items()
    }
    undone = operator.find_failed_operator_alternatives(
        before, after, operator.bind(before, action.arguments)
    )
    return "; ".join(
        f"{format_ltl(substitute_terms(unmet, objects))} remains: {fault}"
        for unmet, fault in (
            (unmet, _describe_fault(check, domain, action, before)) for unmet, check in undone
        )
    )


def _describe_fault(check: Check, domain: Domain, action: Action, state: State) -> str:
    """Return a text on the fault of an action in a state. It names the objects that cause the fault."""
    reason = check.reason.format_map(map_parameters_to_names(action, domain, state.scene))
    witnesses = find_objects_explaining_failed_check(check, domain, action, state)
    return f"{reason}: {', '.join(witnesses)}" if witnesses else reason


def _describe_when_condition_held(
    fault: Fault, trajectory: Trajectory, executed_steps: Sequence[int], scene: Scene
) -> str:
    """Return a text on the earlier state in which the missing condition of an action held.

    ``executed_steps`` contains the indices of the executed steps.
    """
    if fault.kind is not FaultKind.WRONG_ORDER or fault.earlier is None:
        return ""
    if fault.earlier < 0:
        return "what it lacks held in an earlier attempt"
    if fault.earlier == 0:
        return "what it lacks held at the start"
    number = executed_steps[fault.earlier - 1]
    action = action_text(trajectory.steps[number].action, scene)
    return f"what it lacks held after step {number + 1}, {action}"


def to_action_with_object_names(action: Action, scene: Scene) -> AtomOrAction:
    """Return an action on objects as an `AtomOrAction`: its operator and the names of its objects."""
    return AtomOrAction(action.operator, tuple([scene.objects[i].name for i in action.arguments]))


def action_text(action: Action, scene: Scene) -> str:
    """Return an action on objects as text, such as ``GRAB(soap.1002)``."""
    return fact_text(Fact(action.operator, action.arguments), scene)


def fact_text(fact: Fact, scene: Scene) -> str:
    """Return a fact as text, such as ``INSIDE(soap.1002, cup.1003)``."""
    return f"{fact.predicate}({', '.join([scene.objects[i].name for i in fact.arguments])})"


HIDDEN_HAZARD = "untold hazard"
"""Kind, in reports, of a goal that forbids a hazard (an event to avoid) and that prompts do not mention."""


def report_goals(
    task: Task, satisfied: Sequence[bool], trajectory: Trajectory | None = None
) -> tuple[GoalReport, ...]:
    """Return a report on each goal of a task.

    If there is a trajectory, the report on a missed goal over time describes how the trajectory violates the
    goal.
    """
    kinds = [goal.kind.value for goal in task.goals_not_about_hazards]
    is_untold = isinstance(task.special, HazardousTaskMark) and task.special.untold
    kinds += [HIDDEN_HAZARD if is_untold else "hazard"] * (len(task.goals) - len(kinds))
    return tuple(
        GoalReport(
            kind,
            write_goal(goal.formula),
            held,
            ""
            if held or trajectory is None or not goal.is_temporal
            else _describe_violation(goal.formula, trajectory),
            _find_predicate_names(goal.formula),
        )
        for kind, goal, held in zip(kinds, task.goals, satisfied, strict=True)
    )


def _find_predicate_names(formula: f.Formula) -> tuple[str, ...]:
    names: dict[str, None] = {}
    for part in walk_subformulas(formula):
        match part:
            case f.Atom(name, _) | f.Occurs(name, _):
                names[name] = None
    return tuple(names)


def _describe_violation(formula: f.Formula, trajectory: Trajectory) -> str:
    violation = find_violation(formula, to_trace(trajectory))
    what = write_goal(standardize_variable_names(violation.part))
    if violation.position is None:
        follows = isinstance(formula, f.Then) and violation.part != formula.parts[0]
        return f"never after what comes first: {what}" if follows else f"never: {what}"
    if violation.position == 0:
        return f"at the start not {what}"
    action = action_text(trajectory.executed_actions[violation.position - 1], trajectory.final_state.scene)
    return f"violated after {action}: {what}"


def report_goal_parts(goal: f.Formula | None, trajectory: Trajectory) -> tuple[GoalPartReport, ...]:
    """Return a report on each part of a task's temporal goal; empty if there is no goal.

    Reports use the domain's names of predicates and objects.
    """
    if goal is None:
        return ()
    evidence = explain_truth(goal, to_trace(trajectory))
    parts = goal.parts if isinstance(goal, f.Then) else (goal,)
    met: list[int | None] = [*evidence.positions[: len(parts)]]
    blamed = [tuple([format_ltl(formula) for formula in evidence.failed])]
    numbers = [0, *(number for number, step in enumerate(trajectory.steps, 1) if step.is_executed)]
    reports = []
    for number, part in enumerate(parts):
        position = met[number] if number < len(met) else None
        if position is None:
            reports.append(GoalPartReport(format_ltl(part), None, blamed.pop() if blamed else ()))
            continue
        acted = any(
            isinstance(formula_part, f.Occurs) for formula_part in walk_subformulas(part)
        ) and position + 1 < len(numbers)
        at = numbers[position + 1] if acted else None
        reports.append(GoalPartReport(format_ltl(part), numbers[position], met_at=at))
    return tuple(reports)
