"""Explanations: what became of an answer step by step, in words, for people and for reports.

Near misses say, where a goal was not reached, what came of its objects instead. A `Statement` is an atom, an
action or a step as a value beside its text.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple, TypeAlias

from eai.abilities.task import Goal, Task
from eai.logic.formula import (
    Atom,
    Constant,
    Exactly,
    Exists,
    ForAll,
    Formula,
    ForPairs,
    Occurs,
    Or,
    Term,
    Then,
    Variable,
)
from eai.logic.ltl_printer import print_ltl
from eai.logic.rewriting import rename_variables, substitute
from eai.logic.semantics import breach, explain
from eai.logic.traversal import walk
from eai.world.domain import Domain
from eai.world.execution import Action, Fault, Trajectory, names_of, witnesses_of
from eai.world.fault import FaultKind
from eai.world.operator import Check
from eai.world.state import Fact, Scene, State, change
from eai.world.timeline import timeline

_NOT = "not "


class Statement(NamedTuple):
    """An atom or an action: ``not open(jar_0)``, ``GRAB(soap.1002)``, ``TOUCH``.

    Attributes:
        name: of the predicate or action.
        arguments: of the objects; None where the text has no parentheses, as of actions that are goals.
        positive: whether it is asserted.
    """

    name: str
    arguments: tuple[str, ...] | None
    positive: bool = True

    @property
    def signed_name(self) -> str:
        """The name, after ``not`` where the statement is denied."""
        return self.name if self.positive else f"{_NOT}{self.name}"


def read_statement(text: str) -> Statement:
    """The atom or step in a text that has no value beside it, as in older records; else it is a name."""
    positive = not text.startswith(_NOT)
    name, opened, rest = (text if positive else text[len(_NOT) :]).partition("(")
    if not opened or not rest.endswith(")"):
        return Statement(text, None)
    return Statement(name, tuple([part for part in rest[:-1].split(", ") if part]), positive)


SLIP = FaultKind.SLIP.value
"""The outcome of a step that was possible and did not work."""

SLIPPED = "it was possible, but it did not work"
"""The reason of such a step."""


EXECUTED = "executed"
"""The outcome of a step that was carried out."""


@dataclass(frozen=True, slots=True)
class StepReport:
    """One step that was tried.

    Attributes:
        action: the ground action as text.
        outcome: `EXECUTED`, the kind of the fault, or ``slip``.
        reason: which check failed, in words, or that it slipped; empty if neither. Of an executed action that
            has several things to try, what it leaves undone.
        earlier: for a wrong order, after which earlier step what the action lacks held.
        added: facts that became true.
        removed: facts that became false.
        hidden_changes: how many more facts changed that can be seen, about what the task is not about.
        call: the action as a value; None in older records.
    """

    action: str
    outcome: str
    reason: str = ""
    earlier: str = ""
    added: tuple[str, ...] = ()
    removed: tuple[str, ...] = ()
    hidden_changes: int = 0
    call: Statement | None = field(default=None, compare=False)

    @property
    def statement(self) -> Statement:
        """The action as a value, also in older records."""
        return read_statement(self.action) if self.call is None else self.call


@dataclass(frozen=True, slots=True)
class GoalReport:
    """A goal of the task as text, its kind, and whether it was reached.

    Attributes:
        why: of a goal over time that was not, which part of it was violated, and when.
        predicates: what it mentions, each once; of a goal of actions, these. None in older records.
    """

    kind: str
    goal: str
    satisfied: bool
    why: str = ""
    predicates: tuple[str, ...] | None = field(default=None, compare=False)

    @property
    def mentions(self) -> tuple[str, ...]:
        """The predicates that the goal mentions, also in older records; of a goal of actions, these."""
        return names_in(self.goal) if self.predicates is None else self.predicates


@dataclass(frozen=True, slots=True)
class PartReport:
    """A part of the task's temporal goal; its parts are to be met one after the other.

    Attributes:
        part: the part as text.
        met_after: the number, in the list of all steps, of the one that led to the state in which it was
            first met after the part before it; 0 is the start, None that it was not met.
        missing: if it is the first that was not met, what of it never held, as texts: the whole part where
            its pieces held only apart from each other.
        met_at: of a part about an action that was met by one, the number of that step in the same list.
    """

    part: str
    met_after: int | None
    missing: tuple[str, ...] = ()
    met_at: int | None = None

    @property
    def when(self) -> str:
        """When it was met, in words; empty if it was not."""
        if self.met_at is not None:
            return f"at step {self.met_at}"
        if self.met_after is None:
            return ""
        return f"after step {self.met_after}" if self.met_after else "at the start"


@dataclass(frozen=True, slots=True)
class Explanation:
    """The explanation of what became of an answer.

    ``notes`` are sentences on the answer as a whole: why it could not be run, or how it was read. ``parts``
    are those of the task's temporal goal, if it has one. ``atoms`` are the stated and the wanted goals of an
    interpretation as values, by their texts; None of other answers, and in older records.
    """

    notes: tuple[str, ...] = ()
    steps: tuple[StepReport, ...] = ()
    goals: tuple[GoalReport, ...] = ()
    parts: tuple[PartReport, ...] = ()
    atoms: Mapping[str, Statement] | None = field(default=None, compare=False)

    def statement(self, text: str) -> Statement:
        """A stated or wanted goal as a value, also in older records; an entry that says nothing is a name."""
        return read_statement(text) if self.atoms is None else self.atoms.get(text, Statement(text, None))


def repair_notes(repairs: Iterable[str]) -> tuple[str, ...]:
    """A note on each repair that reading an answer took."""
    return tuple(f"read with repair: {repair}" for repair in repairs)


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
            text, call = action_text(action, task.scene), _call(action, task.scene)
            reports.append(StepReport(text, fault.kind.value, reason, earlier, call=call))
        elif slipped:
            call = _call(action, task.scene)
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
                case ForAll() | Exists() | Exactly() | ForPairs():
                    named |= set(task.relevant)
                case Atom(_, terms):
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
    difference = change(before, after)
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
        call=_call(action, focus.scene),
    )


def _undone(domain: Domain, action: Action, before: State, after: State) -> str:
    """In words, the things that an action with several to try leaves undone; empty for any other."""
    operator = domain.compiled[action.operator]
    if not operator.tries:
        return ""
    names = names_of(action, domain, before.scene)
    objects: dict[Term, Term] = {Variable(name): Constant(thing) for name, thing in names.items()}
    undone = operator.left_undone(before, after, operator.bind(before, action.arguments))
    return "; ".join(
        f"{print_ltl(substitute(condition, objects))} remains: {_reason(check, domain, action, before)}"
        for condition, check in undone
    )


def _reason(check: Check, domain: Domain, action: Action, state: State) -> str:
    """The fault of an action in a state, in words, and by name what the words leave without one."""
    reason = check.reason.format_map(names_of(action, domain, state.scene))
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


def _call(action: Action, scene: Scene) -> Statement:
    return Statement(action.operator, tuple([scene.objects[i].name for i in action.arguments]))


def action_text(action: Action, scene: Scene) -> str:
    """A ground action as ``GRAB(soap.1002)``."""
    return fact_text(Fact(action.operator, action.arguments), scene)


def fact_text(fact: Fact, scene: Scene) -> str:
    """A fact as ``INSIDE(soap.1002, cup.1003)``."""
    return f"{fact.predicate}({', '.join([scene.objects[i].name for i in fact.arguments])})"


def goal_reports(
    goals: Sequence[Goal], satisfied: Sequence[bool], course: Trajectory | None = None
) -> tuple[GoalReport, ...]:
    """A report on each goal; goals over time are those of a course, if there was one."""
    return tuple(
        GoalReport(
            goal.kind.value,
            formula_text(goal.formula),
            held,
            "" if held or course is None or not goal.is_over_time else _breach(goal.formula, course),
            _mentioned(goal.formula),
        )
        for goal, held in zip(goals, satisfied, strict=True)
    )


def _mentioned(formula: Formula) -> tuple[str, ...]:
    names: dict[str, None] = {}
    for part in walk(formula):
        match part:
            case Atom(name, _) | Occurs(name, _):
                names[name] = None
    return tuple(names)


_NAME = re.compile(r"([^\s(),]+)\(")


def names_in(goal: str) -> tuple[str, ...]:
    """The names that a goal mentions, from its text; a goal of actions has no parentheses."""
    return tuple(dict.fromkeys(_NAME.findall(goal))) or tuple(goal.split(" or "))


def _breach(formula: Formula, course: Trajectory) -> str:
    """Which part of a goal over time was violated, and when."""
    found = breach(formula, timeline(course))
    what = formula_text(rename_variables(found.part))
    if found.position is None:
        follows = isinstance(formula, Then) and found.part != formula.parts[0]
        return f"never after what comes first: {what}" if follows else f"never: {what}"
    if found.position == 0:
        return f"at the start not {what}"
    action = action_text(course.executed[found.position - 1], course.final.scene)
    return f"violated after {action}: {what}"


def part_reports(goal: Formula | None, trajectory: Trajectory) -> tuple[PartReport, ...]:
    """A report on each part of a temporal goal in the words of the domain; none where there is no goal."""
    if goal is None:
        return ()
    evidence = explain(goal, timeline(trajectory))
    parts = goal.parts if isinstance(goal, Then) else (goal,)
    met: list[int | None] = [*evidence.positions[: len(parts)]]
    blamed = [tuple([print_ltl(formula) for formula in evidence.failed])]
    numbers = [0, *(number for number, step in enumerate(trajectory.steps, 1) if step.executed)]
    reports = []
    for number, part in enumerate(parts):
        position = met[number] if number < len(met) else None
        if position is None:
            reports.append(PartReport(print_ltl(part), None, blamed.pop() if blamed else ()))
            continue
        acted = any(isinstance(each, Occurs) for each in walk(part)) and position + 1 < len(numbers)
        at = numbers[position + 1] if acted else None
        reports.append(PartReport(print_ltl(part), numbers[position], met_at=at))
    return tuple(reports)


def formula_text(formula: Formula) -> str:
    """A goal as a text that the reader of LTL takes; actions that any objects will do for by name alone."""
    match formula:
        case Occurs(action, ()):
            return action
        case Or(operands) if operands and all(isinstance(each, Occurs) for each in operands):
            return " or ".join(map(formula_text, operands))
        case _:
            return print_ltl(rename_variables(formula))


_Fact: TypeAlias = tuple[str, ...]

SHOWN = 2
"""How many near misses of one goal are shown."""


def near_misses(explanation: Explanation) -> Mapping[str, tuple[str, ...]]:
    """The facts that an answer brought about instead of the goals that it misses: goal -> facts, as texts.

    A fact is a near miss if it became true and stayed so, and is another relation of the same objects in the
    same order, a state of the same object whose coming ended the one that is wanted, or the same relation of
    the first object to another one. What holds both ways between two objects says only that they are near
    each other, and is none.
    """
    made, ended = _made(explanation), _ended(explanation)
    found = {}
    for goal in explanation.goals:
        wanted = _parts(goal.goal)
        if not goal.satisfied and wanted is not None:
            near = sorted(
                (fact for fact in made if _is_near(wanted, fact, ended)),
                key=lambda fact: fact[1:] != wanted[1:],
            )
            if near:
                found[goal.goal] = tuple(_text(fact) for fact in near[:SHOWN])
    return found


def _made(explanation: Explanation) -> list[tuple[str, ...]]:
    """The facts that the steps made true and left so, without those that hold both ways."""
    made: dict[tuple[str, ...], None] = {}
    for step in explanation.steps:
        for fact in filter(None, map(_parts, step.removed)):
            made.pop(fact, None)
        made |= dict.fromkeys(filter(None, map(_parts, step.added)))
    return [fact for fact in made if len(fact) != 3 or (fact[0], fact[2], fact[1]) not in made]


def _ended(explanation: Explanation) -> Mapping[_Fact, frozenset[_Fact]]:
    """For each fact that a step made true, the facts that this step, or another that did so, ended."""
    ended: dict[_Fact, frozenset[_Fact]] = {}
    for step in explanation.steps:
        removed = frozenset(filter(None, map(_parts, step.removed)))
        for fact in filter(None, map(_parts, step.added)):
            ended[fact] = ended.get(fact, frozenset()) | removed
    return ended


def _is_near(wanted: _Fact, fact: _Fact, ended: Mapping[_Fact, frozenset[_Fact]]) -> bool:
    same_objects = fact[1:] == wanted[1:] and fact[0] != wanted[0]
    if same_objects and len(wanted) == 2:
        return wanted in ended[fact]
    other_place = len(wanted) == len(fact) == 3 and fact[:2] == wanted[:2] and fact[2] != wanted[2]
    return same_objects or other_place


def _parts(text: str) -> tuple[str, ...] | None:
    """``INSIDE(soap.1002, cup.1003)`` as its words; None for a text of another form."""
    name, bracket, rest = text.partition("(")
    if not bracket or not rest.endswith(")") or not name.isidentifier() or "(" in rest:
        return None
    return (name, *(word.strip() for word in rest[:-1].split(",")))


def _text(fact: Iterable[str]) -> str:
    name, *arguments = fact
    return f"{name}({', '.join(arguments)})"
