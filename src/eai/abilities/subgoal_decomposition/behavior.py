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

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial

from eai.abilities.behavior_goals import BehaviorGoals
from eai.abilities.protocol import Protocol
from eai.abilities.subgoal_decomposition import behavior_answer
from eai.abilities.subgoal_decomposition.behavior_program import reference_program, strict_program
from eai.abilities.subgoal_decomposition.behavior_translation import Translation
from eai.abilities.subgoal_decomposition.behavior_vocabulary import published_names, signature
from eai.abilities.subgoal_decomposition.branch import Branch
from eai.abilities.subgoal_decomposition.compiled import (
    Compiled,
    Rejected,
    compile_each,
    parse_at_once,
    unparseable,
)
from eai.abilities.subgoal_decomposition.scorer import Reached, SubgoalScorer
from eai.abilities.subgoal_decomposition.search import Limits
from eai.abilities.verdict import ErrorReport, Json, SubgoalCategory
from eai.benchmarks.behavior import domain as behavior
from eai.benchmarks.behavior.tasks import BehaviorTask
from eai.benchmarks.reference import behavior_domain
from eai.benchmarks.reference import behavior_subgoals as behavior_reference
from eai.benchmarks.reference import subgoals as reference
from eai.benchmarks.reference.lots import Lots
from eai.world.execution import Action
from eai.world.fault import FaultKind
from eai.world.state import State


class SubgoalDecomposition(SubgoalScorer):
    """The scorer of one task under one protocol.

    A verdict's details are, for each goal, whether it holds at the end (``goals_satisfied``), the kinds of
    all errors of the reported branch in order (``errors``), and how the search ended after how many actions
    (``search``, ``attempts``). An answer that cannot be carried out meets no goal; in the reference it leaves
    the initial state.
    """

    def __init__(self, task: BehaviorTask, protocol: Protocol, *, limits: Limits | None = None) -> None:
        as_in_reference = protocol is Protocol.EAI_1_0_5
        domain = behavior_domain.as_in_reference_subgoals() if as_in_reference else behavior.as_meant()
        initial = task.initial_as_published if as_in_reference else task.initial
        self._goals = BehaviorGoals(task, protocol)
        super().__init__(task, protocol, domain, initial, _AllAtEnd(self._goals), limits)
        self._signature = signature(task.scene, protocol)
        self._names = published_names(task.scene)
        self._translation = Translation(task.scene, self._names, by_substring=True)

    def compile(self, text: str) -> Compiled | Rejected:
        """The answer as a program for the search, or what is wrong with it."""
        if self.protocol is Protocol.EAI_1_0_5:
            return self._compile_as_reference(text)
        written = behavior_answer.read_subgoals(text)
        return compile_each(written, self._signature, partial(strict_program, self.task.scene))

    def _compile_as_reference(self, text: str) -> Compiled | Rejected:
        lots = Lots()
        written = behavior_reference.read_subgoals(text, lots)
        formula = parse_at_once(written, self._signature)
        if isinstance(formula, Rejected):
            return formula
        wrong = behavior_reference.wrong_use(formula, self._names)
        if wrong is not None:
            kind, detail = wrong
            parsing = kind is FaultKind.PARSING
            category = SubgoalCategory.NOT_PARSEABLE if parsing else SubgoalCategory.HALLUCINATION
            return Rejected(category, ErrorReport(kind, None, detail))
        literals = reference.literals(formula, lots)
        if literals is None:
            return unparseable("the reference cannot make a plan of this formula")
        return Compiled(tuple(literals), reference_program(self._translation, literals))

    def _satisfied(self, branch: Branch) -> Sequence[bool]:
        return self._goals.satisfied(branch.states[-1])

    def _reached(self, branch: Branch | None) -> Reached:
        if branch is not None:
            satisfied = self._goals.satisfied(branch.states[-1])
        elif self.protocol is Protocol.EAI_1_0_5:
            satisfied = self._goals.satisfied(self._initial)
        else:
            satisfied = (False,) * len(self.task.goals)
        return Reached(self._goals.tallies(satisfied), {"goals_satisfied": list(satisfied)})

    def _details(self, rejected: Rejected) -> Mapping[str, Json]:
        return {"errors": []}


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
