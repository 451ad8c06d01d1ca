"""Subgoal decomposition in BEHAVIOR: from an answer's text to a verdict.

Protocol `strict` mends these defects of eai-eval 1.0.5 (``subgoal_decomposition/``):

- Of the alternatives of an ``or`` it takes one by lot, after cutting the text wherever the word stands; here
  all are tried.
- An action as a subgoal, and a state that needs no action, are skipped there; here the one is carried out and
  the other must hold, as far as the symbolic scene knows it.
- A negated conjunction or disjunction, any exception, and an answer with braces inside are parsing errors
  there. Here they have a meaning.
- T-shirts and the parts of sliced objects have no names there.
- A hand holds ``rag_1`` there when it holds ``rag_10``.
- Runtime errors are reported whatever the category; there those of unreachable goals are dropped (which is a
  matter of the metrics: a verdict has them under both protocols).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

from eai.abilities.behavior_goals import BehaviorGoals
from eai.abilities.explanation import Explanation, goal_reports, repairs_told, step_reports
from eai.abilities.protocol import Protocol
from eai.abilities.scorer import Assessment, Scorer
from eai.abilities.subgoal_decomposition import behavior_answer, behavior_reference, virtualhome_reference
from eai.abilities.subgoal_decomposition.behavior_program import reference_program, strict_program
from eai.abilities.subgoal_decomposition.behavior_translation import Translation
from eai.abilities.subgoal_decomposition.behavior_vocabulary import published_names, signature
from eai.abilities.subgoal_decomposition.lots import Lots
from eai.abilities.subgoal_decomposition.reporting import category_of, error_of
from eai.abilities.subgoal_decomposition.search import (
    Limits,
    Outcome,
    Program,
    SearchEnd,
    search,
)
from eai.abilities.subgoal_decomposition.written import Unreadable
from eai.abilities.verdict import ErrorReport, Json, SubgoalCategory, Verdict
from eai.data.behavior_tasks import BehaviorTask
from eai.domains import behavior
from eai.errors import InputError, ParseError
from eai.logic.formula import Formula
from eai.logic.ltl import Dialect, parse
from eai.logic.ltl_printer import print_ltl
from eai.logic.signature import Offence, OffenceKind
from eai.world.execution import Action
from eai.world.fault import FaultKind
from eai.world.state import State


@dataclass(frozen=True, slots=True)
class Rejected:
    """An answer that cannot be carried out: its category, why, and the repairs made."""

    category: SubgoalCategory
    error: ErrorReport
    repairs: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Compiled:
    """An answer that can be carried out: its subgoals as text and as a program, and the repairs made."""

    subgoals: tuple[str, ...]
    program: Program
    repairs: tuple[str, ...] = ()


class SubgoalDecomposition(Scorer):
    """The scorer of one task under one protocol.

    A verdict's details are, for each goal, whether it holds at the end (``goals_satisfied``), the kinds of
    all errors of the reported branch in order (``errors``), and how the search ended after how many actions
    (``search``, ``attempts``). An answer that cannot be carried out leaves the initial state.
    """

    def __init__(self, task: BehaviorTask, protocol: Protocol, *, limits: Limits | None = None) -> None:
        self.task = task
        self.protocol = protocol
        self._as_in_reference = protocol is Protocol.EAI_1_0_5
        self.domain = behavior.as_in_reference_subgoals() if self._as_in_reference else behavior.as_meant()
        self._initial = task.initial_as_published if self._as_in_reference else task.initial
        self._limits = limits or Limits()
        self._signature = signature(task.scene, protocol)
        self._names = published_names(task.scene)
        self._translation = Translation(task.scene, self._names, by_substring=True)
        self._goals = BehaviorGoals(task, protocol)

    def assess(self, text: str) -> Assessment:
        """The verdict on an answer, and what becomes of it step by step in the reported branch."""
        compiled = self.compile(text)
        if isinstance(compiled, Rejected):
            return self._refuse(compiled, compiled.repairs)
        outcome = self._carry_out(compiled)
        if isinstance(outcome, Rejected):
            return self._refuse(outcome, compiled.repairs)
        return Assessment(self._judge(compiled.repairs, outcome), partial(self._explain, compiled, outcome))

    def _refuse(self, rejected: Rejected, repairs: Sequence[str]) -> Assessment:
        """The assessment of an answer that cannot be carried out, with the repairs made until then."""
        notes = (rejected.category.value, *repairs_told(repairs), rejected.error.detail)
        return Assessment(self._rejection(rejected), partial(Explanation, notes))

    def compile(self, text: str) -> Compiled | Rejected:
        """The answer as a program for the search, or what is wrong with it."""
        if self._as_in_reference:
            return self._compile_as_reference(text)
        return self._compile_strictly(text)

    def _explain(self, compiled: Compiled, outcome: Outcome) -> Explanation:
        notes = [*repairs_told(compiled.repairs)]
        notes += [f"subgoal {i + 1}: {subgoal}" for i, subgoal in enumerate(compiled.subgoals)]
        if outcome.end is not SearchEnd.COMPLETE:
            notes.append(f"the search was ended: {outcome.end.value} {outcome.reason}".rstrip())
        error = error_of(outcome.reported, self.domain, self.task.scene)
        if error is not None and error.step is not None:
            notes.append(f"subgoal {error.step + 1} fails: {error.kind.value}, {error.detail}")
        trajectory = outcome.reported.trajectory
        return Explanation(
            (category_of(outcome).value, *notes),
            step_reports(self.task, self.domain, trajectory),
            goal_reports(self.task.goals, self._goals.satisfied(trajectory.final)),
        )

    def _compile_as_reference(self, text: str) -> Compiled | Rejected:
        lots = Lots()
        written = behavior_reference.read_subgoals(text, lots)
        if isinstance(written, Unreadable):
            return _unparseable(written.reason)
        try:
            reading = parse(" then ".join(written.subgoals), self._signature, Dialect.RELEASE)
        except ParseError as error:
            return _unparseable(str(error))
        if reading.offences:
            return _offending(reading.offences, ())
        wrong = behavior_reference.wrong_use(reading.formula, self._names)
        if wrong is not None:
            kind, detail = wrong
            parsing = kind is FaultKind.PARSING
            category = SubgoalCategory.NOT_PARSEABLE if parsing else SubgoalCategory.HALLUCINATION
            return Rejected(category, ErrorReport(kind, None, detail))
        literals = virtualhome_reference.literals(reading.formula, lots)
        if literals is None:
            return _unparseable("the reference cannot make a plan of this formula")
        names = tuple(print_ltl(literal) for literal in literals)
        return Compiled(names, reference_program(self._translation, literals))

    def _compile_strictly(self, text: str) -> Compiled | Rejected:
        written = behavior_answer.read_subgoals(text)
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
        if offences:
            return _offending(offences, written.repairs)
        try:
            program = strict_program(self.task.scene, formulas)
        except InputError as error:
            return _unparseable(str(error), written.repairs)
        return Compiled(written.subgoals, program, written.repairs)

    def _carry_out(self, compiled: Compiled) -> Outcome | Rejected:
        goal = _AllAtEnd(self._goals)
        outcome = search(self.domain, self._initial, compiled.program, goal, self._limits)
        return _unparseable(outcome.reason) if outcome.end is SearchEnd.HALTED else outcome

    def _judge(self, repairs: tuple[str, ...], outcome: Outcome) -> Verdict:
        branch = outcome.reported
        kinds = [fault.kind for fault in branch.faults]
        satisfied = self._goals.satisfied(branch.states[-1])
        details: dict[str, Json] = {
            "goals_satisfied": list(satisfied),
            "errors": [kind.value for kind in kinds],
            "search": outcome.end.value,
            "attempts": outcome.attempts,
        }
        return Verdict(
            executable=outcome.executable,
            success=outcome.success,
            error=error_of(branch, self.domain, self.task.scene),
            additional_steps=kinds.count(FaultKind.ADDITIONAL_STEP),
            category=category_of(outcome),
            goals=self._goals.tallies(satisfied),
            repairs=repairs,
            details=details,
        )

    def _rejection(self, rejected: Rejected) -> Verdict:
        satisfied = self._goals.satisfied(self._initial)
        return Verdict(
            executable=False,
            success=False,
            error=rejected.error,
            additional_steps=0,
            category=rejected.category,
            goals=self._goals.tallies(satisfied),
            repairs=rejected.repairs,
            details={"goals_satisfied": list(satisfied), "errors": []},
        )


@dataclass(frozen=True, slots=True)
class _AllAtEnd:
    """The goal that all goals of a task hold in the last state."""

    goals: BehaviorGoals

    def advance(self, met: int, state: State, action: Action) -> int:
        """Nothing of the past matters."""
        return met

    def reached(self, met: int, final: State) -> bool:
        """Whether all goals hold."""
        return all(self.goals.satisfied(final))


def _unparseable(reason: str, repairs: tuple[str, ...] = ()) -> Rejected:
    return Rejected(SubgoalCategory.NOT_PARSEABLE, ErrorReport(FaultKind.PARSING, None, reason), repairs)


def _offending(offences: Sequence[Offence], repairs: tuple[str, ...]) -> Rejected:
    """The rejection for names that are not allowed: unknown predicates first, then numbers of objects."""
    order = (OffenceKind.UNKNOWN_PREDICATE, OffenceKind.WRONG_ARITY, OffenceKind.UNKNOWN_OBJECT)
    worst = min(offences, key=lambda offence: order.index(offence.kind))
    wrong_number = worst.kind is OffenceKind.WRONG_ARITY
    kind = FaultKind.ARGUMENT_NUMBER if wrong_number else FaultKind.HALLUCINATION
    return Rejected(SubgoalCategory.HALLUCINATION, ErrorReport(kind, None, worst.detail), repairs)
