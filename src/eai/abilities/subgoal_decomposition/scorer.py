"""Scoring subgoals: from an answer that is compiled to its verdict, the same for every domain."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial

from eai.abilities.explanation import Explanation, goal_reports, repairs_told, step_reports
from eai.abilities.protocol import Protocol
from eai.abilities.scorer import Assessment, Scorer
from eai.abilities.subgoal_decomposition.branch import Branch
from eai.abilities.subgoal_decomposition.compiled import Compiled, Rejected, unparseable
from eai.abilities.subgoal_decomposition.reporting import category_of, error_of
from eai.abilities.subgoal_decomposition.search import (
    Goal,
    Limits,
    Outcome,
    SearchEnd,
    search,
    uncategorised,
)
from eai.abilities.task import Task
from eai.abilities.verdict import GoalTallies, Json, Verdict
from eai.logic.ltl_printer import print_ltl
from eai.world.domain import Domain
from eai.world.execution import Fault
from eai.world.fault import FaultKind
from eai.world.state import State


@dataclass(frozen=True, slots=True)
class Reached:
    """The goals that an answer reaches, by kind, and what a verdict's details say of them."""

    tallies: GoalTallies
    details: Mapping[str, Json] = field(default_factory=dict)


class SubgoalScorer(Scorer):
    """The scorer of one task under one protocol.

    Args:
        task: the task.
        protocol: the rules.
        domain: the world in which subgoals are carried out.
        initial: the state in which they are.
        goal: what they are to reach; None where the reference cannot read it.
        limits: how long the search may take. Only answers with a great many alternatives get there.
    """

    def __init__(
        self,
        task: Task,
        protocol: Protocol,
        domain: Domain,
        initial: State,
        goal: Goal | None,
        limits: Limits | None,
    ) -> None:
        self.task = task
        self.protocol = protocol
        self.domain = domain
        self._initial = initial
        self._goal = goal
        self._limits = limits or Limits()
        self._halts: Callable[[Fault], bool] = uncategorised

    @abstractmethod
    def compile(self, text: str) -> Compiled | Rejected:
        """The answer as a program for the search, or what is wrong with it."""

    @abstractmethod
    def _reached(self, branch: Branch | None) -> Reached:
        """What a branch reaches, or an answer that is not carried out."""

    @abstractmethod
    def _satisfied(self, branch: Branch) -> Sequence[bool]:
        """For each goal of the task, in order, whether a branch reaches it."""

    @abstractmethod
    def _details(self, rejected: Rejected) -> Mapping[str, Json]:
        """What else a verdict says of an answer that is not carried out."""

    def assess(self, text: str) -> Assessment:
        """The verdict on an answer, and what becomes of it step by step in the reported branch."""
        compiled = self.compile(text)
        if isinstance(compiled, Rejected):
            return self._refuse(compiled, compiled.repairs)
        outcome = self._carry_out(compiled)
        if isinstance(outcome, Rejected):
            return self._refuse(outcome, compiled.repairs)
        verdict = self._judge(compiled.repairs, outcome)
        return Assessment(verdict, partial(self._explain, compiled, outcome))

    def _refuse(self, rejected: Rejected, repairs: Sequence[str]) -> Assessment:
        """The assessment of an answer that cannot be carried out, with the repairs made until then."""
        return Assessment(self._rejection(rejected), partial(_refusal, rejected, repairs))

    def _explain(self, compiled: Compiled, outcome: Outcome) -> Explanation:
        notes = [*repairs_told(compiled.repairs)]
        notes += [f"subgoal {i + 1}: {print_ltl(f)}" for i, f in enumerate(compiled.subgoals)]
        if outcome.end is not SearchEnd.COMPLETE:
            notes.append(f"the search was ended: {outcome.end.value} {outcome.reason}".rstrip())
        error = error_of(outcome.reported, self.domain, self.task.scene)
        if error is not None and error.step is not None:
            notes.append(f"subgoal {error.step + 1} fails: {error.kind.value}, {error.detail}")
        return Explanation(
            (category_of(outcome).value, *notes),
            step_reports(self.task, self.domain, outcome.reported.trajectory),
            goal_reports(self.task.goals, self._satisfied(outcome.reported)),
        )

    def _carry_out(self, compiled: Compiled) -> Outcome | Rejected:
        if self._goal is None:
            return unparseable("the reference cannot read the goal of this task")
        outcome = search(self.domain, self._initial, compiled.program, self._goal, self._limits, self._halts)
        return unparseable(outcome.reason) if outcome.end is SearchEnd.HALTED else outcome

    def _judge(self, repairs: tuple[str, ...], outcome: Outcome) -> Verdict:
        branch = outcome.reported
        reached = self._reached(branch)
        kinds = [fault.kind for fault in branch.faults]
        details = {
            **reached.details,
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
            goals=reached.tallies,
            repairs=repairs,
            details=details,
        )

    def _rejection(self, rejected: Rejected) -> Verdict:
        reached = self._reached(None)
        return Verdict(
            executable=False,
            success=False,
            error=rejected.error,
            additional_steps=0,
            category=rejected.category,
            goals=reached.tallies,
            repairs=rejected.repairs,
            details={**reached.details, **self._details(rejected)},
        )


def _refusal(rejected: Rejected, repairs: Sequence[str]) -> Explanation:
    wrong = [str(offence) for offence in rejected.offences] or [rejected.error.detail]
    return Explanation((rejected.category.value, *repairs_told(repairs), *wrong))
