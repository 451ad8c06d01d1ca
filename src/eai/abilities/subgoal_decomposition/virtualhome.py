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

from collections.abc import Mapping, Sequence
from functools import partial

from eai.abilities.action_sequencing.goals import TaskGoals
from eai.abilities.explanation import Explanation
from eai.abilities.protocol import Protocol
from eai.abilities.scorer import Assessment
from eai.abilities.subgoal_decomposition import answer
from eai.abilities.subgoal_decomposition.branch import Branch
from eai.abilities.subgoal_decomposition.compiled import (
    Compiled,
    Rejected,
    compile_each,
    parse_at_once,
    unparseable,
)
from eai.abilities.subgoal_decomposition.progress import GoalProgress, StateTest
from eai.abilities.subgoal_decomposition.scorer import Reached, SubgoalScorer
from eai.abilities.subgoal_decomposition.search import Goal, Limits
from eai.abilities.subgoal_decomposition.virtualhome_program import reference_program, strict_program
from eai.abilities.subgoal_decomposition.virtualhome_signature import signature, without_arguments
from eai.abilities.task import NO_GOALS, GoalKind, Task
from eai.abilities.verdict import Json, Verdict
from eai.benchmarks.reference import subgoals as reference
from eai.benchmarks.reference import virtualhome_domain
from eai.benchmarks.reference import virtualhome_subgoals as virtualhome_reference
from eai.benchmarks.reference.lots import Lots
from eai.benchmarks.virtualhome import domain as virtualhome
from eai.logic.formula import And
from eai.logic.ltl import Dialect, parse
from eai.logic.signature import Signature
from eai.world.execution import Action
from eai.world.state import State


class SubgoalDecomposition(SubgoalScorer):
    """The scorer of one task under one protocol.

    A verdict's details are the kinds of all errors of the reported branch in order (``errors``), what is
    wrong with names (``offences``), and how the search ended after how many actions (``search``,
    ``attempts``).
    """

    def __init__(self, task: Task, protocol: Protocol, *, limits: Limits | None = None) -> None:
        self._signature = signature(task.scene, protocol)
        goal = _goal(task, protocol, self._signature)
        self._as_in_reference = protocol is Protocol.EAI_1_0_5
        domain = virtualhome_domain.as_in_reference() if self._as_in_reference else virtualhome.as_meant()
        super().__init__(task, protocol, domain, task.initial, goal, limits)
        if self._as_in_reference:
            self._halts = virtualhome_reference.halts
        self._goals = TaskGoals(task, Protocol.STRICT)

    def assess(self, text: str) -> Assessment:
        """The verdict on an answer, and what becomes of it step by step in the reported branch."""
        if not self._as_in_reference and not self.task.goals:
            return Assessment(Verdict(excluded=NO_GOALS), partial(self._explain_excluded, text))
        return super().assess(text)

    def _explain_excluded(self, text: str) -> Explanation:
        return super().assess(text).explain()

    def compile(self, text: str) -> Compiled | Rejected:
        """The answer as a program for the search, or what is wrong with it."""
        if self._as_in_reference:
            return self._compile_as_reference(text)
        written = answer.read_subgoals(text, without_arguments(self.protocol))
        return compile_each(written, self._signature, partial(strict_program, self.task))

    def _compile_as_reference(self, text: str) -> Compiled | Rejected:
        lots = Lots()
        written = virtualhome_reference.read_subgoals(text, lots)
        formula = parse_at_once(written, self._signature)
        if isinstance(formula, Rejected):
            return formula
        literals = reference.literals(formula, lots)
        if literals is None or virtualhome_reference.conjoins_moments(formula):
            return unparseable("the reference cannot make a plan of this formula")
        return Compiled(tuple(literals), reference_program(self.task, literals))

    def _satisfied(self, branch: Branch) -> Sequence[bool]:
        return self._goals.satisfied(branch.states[-1], _executed(branch))

    def _reached(self, branch: Branch | None) -> Reached:
        """The goals that hold at the end of a branch.

        The reference takes the action goals one by one in any order of the actions, and ends at the first
        one that is not met (``my_scene_evaluate``).
        """
        if branch is None:
            return Reached(self._goals.none_satisfied())
        actions = _executed(branch)
        tallies = self._goals.count(branch.states[-1], actions)
        if self._as_in_reference:
            tallies = tallies._replace(action=self._goals.count_actions_singly(actions))
        return Reached(tallies)

    def _details(self, rejected: Rejected) -> Mapping[str, Json]:
        return {"offences": list(dict.fromkeys(offence.kind.value for offence in rejected.offences))}


def _executed(branch: Branch) -> list[str]:
    return [step.action.operator for step in branch.steps if step.fault is None]


def _goal(task: Task, protocol: Protocol, known: Signature) -> Goal | None:
    """The goal to reach, or None where the reference cannot read it."""
    text = task.temporal_goal
    reading = None if text is None else parse(text, known, Dialect.RELEASE)
    if reading is None or reading.offences:
        return None
    progress = GoalProgress(reading.formula, task.scene)
    return progress if protocol is Protocol.EAI_1_0_5 else _HeldAtEnd(progress, task)


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
