"""Subgoal decomposition in VirtualHome: from an answer's text to a verdict.

Protocol `strict` mends these defects of eai-eval 1.0.5 (``subgoal_decomposition/``):

- Of the alternatives of an ``or`` it takes one by lot, after cutting the text wherever the word stands; here
  all are tried.
- A subgoal that needs no action (``SITTING(x)``, ``NEXT_TO(x, y)``) is skipped there; here it must hold.
- ``NEXT_TO(x, character)`` is brought about like ``NEXT_TO(character, x)``; there it is skipped.
- The goal counts there if it held at any time; here its states and relations must hold at the end.
- An exception anywhere is a parsing error there: for a negation, a quantifier, an object without an id, and
  for the goal of five tasks itself (``POUR``). Here all of these have a meaning.
- JSON is found in prose and in code fences, and may have braces inside.
- Runtime errors are reported whatever the category; there those of unreachable goals are dropped (which is a
  matter of the metrics: a verdict has them under both protocols).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

from eai.abilities.action_sequencing.goals import TaskGoals
from eai.abilities.action_sequencing.virtualhome import NO_GOALS, domain_of
from eai.abilities.explanation import Explanation, goal_reports, repairs_told, step_reports
from eai.abilities.protocol import Protocol
from eai.abilities.scorer import Assessment, Scorer
from eai.abilities.subgoal_decomposition import virtualhome_answer, virtualhome_reference
from eai.abilities.subgoal_decomposition.lots import Lots
from eai.abilities.subgoal_decomposition.progress import GoalProgress, StateTest
from eai.abilities.subgoal_decomposition.reporting import category_of, error_of
from eai.abilities.subgoal_decomposition.search import (
    Branch,
    Goal,
    Limits,
    Outcome,
    Program,
    SearchEnd,
    search,
    uncategorised,
)
from eai.abilities.subgoal_decomposition.virtualhome_program import reference_program, strict_program
from eai.abilities.subgoal_decomposition.virtualhome_signature import signature, without_arguments
from eai.abilities.subgoal_decomposition.written import Unreadable, WrittenSubgoals
from eai.abilities.verdict import ErrorReport, GoalTallies, Json, SubgoalCategory, Verdict
from eai.data.task import GoalKind, Task
from eai.errors import InputError, ParseError
from eai.logic.formula import And, Formula
from eai.logic.ltl import Dialect, parse
from eai.logic.ltl_printer import print_ltl
from eai.logic.signature import Offence, OffenceKind
from eai.world.execution import Action
from eai.world.fault import FaultKind
from eai.world.state import State

UNREACHABLE = "all subgoals are carried out, but the goal is not reached"


@dataclass(frozen=True, slots=True)
class Rejected:
    """An answer that cannot be carried out: its category, why, and what is wrong with its names."""

    category: SubgoalCategory
    error: ErrorReport
    offences: tuple[Offence, ...] = ()
    repairs: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Compiled:
    """An answer that can be carried out: its subgoals, also as a program, and the repairs made."""

    subgoals: tuple[Formula, ...]
    program: Program
    repairs: tuple[str, ...] = ()


class SubgoalDecomposition(Scorer):
    """The scorer of one task under one protocol.

    A verdict's details are the kinds of all errors of the reported branch in order (``errors``), what is
    wrong with names (``offences``), and how the search ended after how many actions (``search``,
    ``attempts``).

    Args:
        task: the task.
        protocol: the rules.
        limits: how long the search may take. Only answers with a great many alternatives get there.
    """

    def __init__(self, task: Task, protocol: Protocol, *, limits: Limits | None = None) -> None:
        self.task = task
        self.protocol = protocol
        self.domain = domain_of(protocol)
        self._limits = limits or Limits()
        self._as_in_reference = protocol is Protocol.EAI_1_0_5
        self._signature = signature(task.scene, protocol)
        self._goals = TaskGoals(task, Protocol.STRICT)
        self._goal = self._read_goal()

    def assess(self, text: str) -> Assessment:
        """The verdict on an answer, and what becomes of it step by step in the reported branch."""
        if not self._as_in_reference and not self.task.goals:
            return Assessment(Verdict(excluded=NO_GOALS), lambda: self._assess(text).explain())
        return self._assess(text)

    def _assess(self, text: str) -> Assessment:
        """The assessment as if the task were not excluded."""
        compiled = self.compile(text)
        if isinstance(compiled, Rejected):
            return self._refuse(compiled, compiled.repairs)
        outcome = self._carry_out(compiled)
        if isinstance(outcome, Rejected):
            return self._refuse(outcome, compiled.repairs)
        return Assessment(self._judge(compiled, outcome), partial(self._explain, compiled, outcome))

    def _refuse(self, rejected: Rejected, repairs: Sequence[str]) -> Assessment:
        """The assessment of an answer that cannot be carried out, with the repairs made until then."""
        wrong = [str(offence) for offence in rejected.offences] or [rejected.error.detail]
        notes = (rejected.category.value, *repairs_told(repairs), *wrong)
        return Assessment(self._rejection(rejected), partial(Explanation, notes))

    def compile(self, text: str) -> Compiled | Rejected:
        """The answer as a program for the search, or what is wrong with it."""
        if self._as_in_reference:
            return self._compile_as_reference(text)
        return self._compile_strictly(text)

    def _explain(self, compiled: Compiled, outcome: Outcome) -> Explanation:
        branch = outcome.reported
        notes = [*repairs_told(compiled.repairs)]
        notes += [f"subgoal {i + 1}: {print_ltl(f)}" for i, f in enumerate(compiled.subgoals)]
        if outcome.end is not SearchEnd.COMPLETE:
            notes.append(f"the search was ended: {outcome.end.value} {outcome.reason}".rstrip())
        error = error_of(branch, self.domain, self.task.scene)
        if error is not None and error.step is not None:
            notes.append(f"subgoal {error.step + 1} fails: {error.kind.value}, {error.detail}")
        executed = [action.operator for action in branch.trajectory.executed]
        return Explanation(
            (category_of(outcome).value, *notes),
            step_reports(self.task, self.domain, branch.trajectory),
            goal_reports(self.task.goals, self._goals.satisfied(branch.states[-1], executed)),
        )

    def _read_goal(self) -> Goal | None:
        """The goal to reach, or None where the reference cannot read it."""
        text = self.task.temporal_goal
        reading = None if text is None else parse(text, self._signature, Dialect.RELEASE)
        if reading is None or reading.offences:
            return None
        progress = GoalProgress(reading.formula, self.task.scene)
        return progress if self._as_in_reference else _HeldAtEnd(progress, self.task)

    def _compile_as_reference(self, text: str) -> Compiled | Rejected:
        lots = Lots()
        written = virtualhome_reference.read_subgoals(text, lots)
        if isinstance(written, Unreadable):
            return _unparseable(written.reason)
        try:
            reading = parse(" then ".join(written.subgoals), self._signature, Dialect.RELEASE)
        except ParseError as error:
            return _unparseable(str(error))
        rejected = _offending(reading.offences, written)
        if rejected is not None:
            return rejected
        literals = virtualhome_reference.literals(reading.formula, lots)
        if literals is None or virtualhome_reference.conjoins_moments(reading.formula):
            return _unparseable("the reference cannot make a plan of this formula")
        return Compiled(tuple(literals), reference_program(self.task, literals))

    def _compile_strictly(self, text: str) -> Compiled | Rejected:
        written = virtualhome_answer.read_subgoals(text, without_arguments(self.protocol))
        if isinstance(written, Unreadable):
            return _unparseable(written.reason)
        formulas: list[Formula] = []
        offences: list[Offence] = []
        for number, subgoal in enumerate(written.subgoals):
            try:
                reading = parse(subgoal, self._signature)
            except ParseError as error:
                return _unparseable(f"subgoal {number + 1}: {error}", written.repairs)
            formulas.append(reading.formula)
            offences += reading.offences
        rejected = _offending(offences, written)
        if rejected is not None:
            return rejected
        try:
            program = strict_program(self.task, formulas)
        except InputError as error:
            return _unparseable(str(error), written.repairs)
        return Compiled(tuple(formulas), program, written.repairs)

    def _carry_out(self, compiled: Compiled) -> Outcome | Rejected:
        if self._goal is None:
            return _unparseable("the reference cannot read the goal of this task")
        halts = virtualhome_reference.halts if self._as_in_reference else uncategorised
        outcome = search(self.domain, self.task.initial, compiled.program, self._goal, self._limits, halts)
        if outcome.end is SearchEnd.HALTED:
            return _unparseable(outcome.reason)
        return outcome

    def _judge(self, compiled: Compiled, outcome: Outcome) -> Verdict:
        branch = outcome.reported
        kinds = [fault.kind for fault in branch.faults]
        details: dict[str, Json] = {
            "errors": [kind.value for kind in kinds],
            "search": outcome.end.value,
            "attempts": outcome.attempts,
        }
        return Verdict(
            executable=outcome.executable,
            success=outcome.success,
            error=error_of(outcome.reported, self.domain, self.task.scene),
            additional_steps=kinds.count(FaultKind.ADDITIONAL_STEP),
            category=category_of(outcome),
            goals=self._tallies(branch),
            repairs=compiled.repairs,
            details=details,
        )

    def _tallies(self, branch: Branch) -> GoalTallies:
        """The goals that hold at the end of a branch.

        The reference takes the action goals one by one in any order of the actions, and ends at the first
        one that is not met (``my_scene_evaluate``).
        """
        actions = [action.operator for action in branch.trajectory.executed]
        goals = self._goals.count(branch.states[-1], actions)
        if not self._as_in_reference:
            return goals
        return goals._replace(action=self._goals.count_actions_singly(actions))

    def _rejection(self, rejected: Rejected) -> Verdict:
        return Verdict(
            executable=False,
            success=False,
            error=rejected.error,
            additional_steps=0,
            category=rejected.category,
            goals=self._goals.none_satisfied(),
            repairs=rejected.repairs,
            details={"offences": list(dict.fromkeys(o.kind.value for o in rejected.offences))},
        )


class _HeldAtEnd:
    """A goal whose parts must be met in order, and whose states and relations must hold at the end."""

    def __init__(self, progress: GoalProgress, task: Task) -> None:
        lasting = [goal.formula for goal in task.goals if goal.kind is not GoalKind.ACTION]
        self._progress = progress
        self._holds = StateTest(And(tuple(lasting)), task.scene)

    def advance(self, met: int, state: State, action: Action) -> int:
        """How many parts are met after an action."""
        return self._progress.advance(met, state, action)

    def reached(self, met: int, final: State) -> bool:
        """Whether the goal is reached."""
        return self._progress.reached(met, final) and self._holds(final)


def _unparseable(reason: str, repairs: tuple[str, ...] = ()) -> Rejected:
    error = ErrorReport(FaultKind.PARSING, None, reason)
    return Rejected(SubgoalCategory.NOT_PARSEABLE, error, repairs=repairs)


def _offending(offences: Sequence[Offence], written: WrittenSubgoals) -> Rejected | None:
    """The rejection for names that are not allowed: first unknown predicates, then numbers of objects."""
    for kind in (OffenceKind.UNKNOWN_PREDICATE, OffenceKind.WRONG_ARITY, OffenceKind.UNKNOWN_OBJECT):
        for offence in offences:
            if offence.kind is kind:
                wrong_number = kind is OffenceKind.WRONG_ARITY
                fault = FaultKind.ARGUMENT_NUMBER if wrong_number else FaultKind.HALLUCINATION
                error = ErrorReport(fault, None, offence.detail)
                return Rejected(SubgoalCategory.HALLUCINATION, error, tuple(offences), written.repairs)
    return None
