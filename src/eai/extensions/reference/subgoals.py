"""Read and count subgoals as eai-eval 1.0.5 (the paper's package) does in every domain (``subgoal_plan.py``).

Random draws: eai-eval chooses between alternatives with Python's ``random.choice``. It calls this
function once for every subgoal that it keeps, even without alternatives, then once for every remaining
``or``. The published runs set no seed. Here each answer starts with ``random.seed(0)``.
"""

from __future__ import annotations

import json
import re
from abc import abstractmethod
from bisect import bisect
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import accumulate
from random import Random

import eai.logic.formula as f
from eai.abilities.subgoal_decomposition.program import (
    CompiledSubgoalAnswer,
    ExecuteSubgoalPlansInstruction,
    Instruction,
    RejectedAnswer,
    SubgoalPlanner,
    SubgoalPlanningResult,
    SubgoalProgram,
    reject_misused_names,
    reject_unparseable,
)
from eai.abilities.subgoal_decomposition.scorer import SubgoalDecompositionScorer
from eai.abilities.subgoal_decomposition.search import ExplorationResult, SubgoalExecutionBranch
from eai.abilities.subgoal_decomposition.verdict import SubgoalAnswerCategory, SubgoalVerdict
from eai.abilities.verdict import SummaryCounts, Unreadable
from eai.base.errors import ParseError
from eai.logic.ltl import read_formula
from eai.logic.signature import FormulaSignature
from eai.logic.traversal import find_temporal_subformula_ids, get_subformulas
from eai.world.action import Fault
from eai.world.fault import FaultKind
from eai.world.state import State

SEED = 0

_OBJECT = re.compile(r"{[^{}]*}")
_THEN = " then "

_KINDS_COUNTED_SEVERAL_TIMES = (FaultKind.WRONG_ORDER, FaultKind.MISSING_STEP, FaultKind.AFFORDANCE)
"""Kinds of error that eai-eval counts as often as they occur in its report on an answer.

Other kinds count at most once.
"""


class EaiEvalSubgoalScorer(SubgoalDecompositionScorer):
    """Scores subgoals as eai-eval (the paper's package) does in every domain.

    All subgoals of an answer form one text. The robot makes the literals of this text true one after the
    other, without a test whether they hold already. Tasks without goals are scored, too. All errors
    that eai-eval lists for an answer count as runtime errors, unless the answer executes but misses the goal
    (``subgoal_eval_utils.py``).
    """

    def compile_answer(self, text: str) -> CompiledSubgoalAnswer | RejectedAnswer:
        """Return an answer's subgoals as a program, or why the answer is rejected.

        A program is a list of instructions. The search for executions follows it through all its branches.
        Random draws start from `SEED`.
        """
        rng = Random(SEED)  # noqa: S311 - the same generator as the reference's
        written = read_subgoal_texts(text)
        if isinstance(written, Unreadable):
            return reject_unparseable(written.reason)
        pieces = [self._draw_disjunct(subgoal, rng) for subgoal in written]
        kept = [piece for piece in pieces if piece is not None]
        formula = parse_subgoals_as_one_text(kept, self.lexicon.signature)
        if isinstance(formula, RejectedAnswer):
            return formula
        misuse = self._reject_wrongly_used_names(formula)
        if misuse is not None:
            return misuse
        literals = draw_disjuncts_and_list_literals(formula, rng)
        if literals is None:
            return reject_unparseable("the reference cannot make a plan of this formula")
        return CompiledSubgoalAnswer(tuple(literals), self._compile_literals_into_search_program(literals))

    @abstractmethod
    def _draw_disjunct(self, subgoal: str, rng: Random) -> str | None:
        """Draw one alternative of a subgoal such as ``a or b``; None if eai-eval ignores the subgoal."""

    def _reject_wrongly_used_names(self, formula: f.Formula) -> RejectedAnswer | None:
        """Return why an answer is rejected if its formula uses a name wrongly; otherwise None."""
        return None

    @abstractmethod
    def _make_planners_with_index_of_first_literal(
        self, literals: Sequence[f.Formula]
    ) -> list[tuple[int, SubgoalPlanner]]:
        """Return the planners that find actions for the literals of an answer, in order.

        A literal is an atom, an action, or the negation of an atom or action. A planner is for one literal
        or for several successive literals. It is paired with the index of its first literal.
        """

    def _compile_literals_into_search_program(self, literals: Sequence[f.Formula]) -> SubgoalProgram:
        """Return a program (list of instructions) with which the search makes the literals true in order.

        Each instruction calls a planner, which returns plans (lists of actions) for one or several literals.
        The search executes these plans even if the literals hold already.
        """
        program: list[Instruction] = [None]
        for number, plans in reversed(self._make_planners_with_index_of_first_literal(literals)):
            program.append(ExecuteSubgoalPlansInstruction(plans, number, len(program) - 1))
        return program

    def raises_exception_in_eai_eval(self, fault: Fault) -> bool:
        """Whether eai-eval raises an exception because of a fault. A fault is a failed check of an action.

        The exception counts as a parsing error. Such a fault has no kind of error in eai-eval.
        """
        return fault.kind is FaultKind.UNCATEGORISED

    def _explore_executions_of_subgoals(
        self, compiled: CompiledSubgoalAnswer
    ) -> ExplorationResult | RejectedAnswer:
        """Search the ways to execute an answer's subgoals.

        If eai-eval raises an exception in any branch of the search, the answer is rejected.
        """
        try:
            outcome = super()._explore_executions_of_subgoals(compiled)
        except _EaiEvalCrashError as halt:
            return reject_unparseable(str(halt))
        if isinstance(outcome, RejectedAnswer):
            return outcome
        faults = (fault for branch in outcome.ended for fault in branch.faults)
        halting = next(filter(self.raises_exception_in_eai_eval, faults), None)
        return outcome if halting is None else reject_unparseable(halting.check.reason)

    def _judge_exploration(
        self, compiled: CompiledSubgoalAnswer, outcome: ExplorationResult
    ) -> SubgoalVerdict:
        verdict = super()._judge_exploration(compiled, outcome)
        entries = Counter(kind for kind in verdict.errors if kind in _KINDS_COUNTED_SEVERAL_TIMES)
        if verdict.additional_steps:
            entries[FaultKind.ADDITIONAL_STEP] = 1
        if verdict.category is SubgoalAnswerCategory.GOAL_UNREACHABLE:
            entries.clear()
        return _set_counted_errors(verdict, entries)

    def _select_execution_branches_to_judge(
        self, outcome: ExplorationResult
    ) -> tuple[SubgoalExecutionBranch, ...]:
        """Return only the branch of the search that eai-eval reports, even if others reach more goals."""
        return (outcome.reported,)

    def _make_rejection_verdict(self, rejected: RejectedAnswer) -> SubgoalVerdict:
        return _set_counted_errors(super()._make_rejection_verdict(rejected), {})


class _EaiEvalCrashError(Exception):
    """Raised for a subgoal at which eai-eval raises an exception. The message says why."""


def make_planner_that_rejects_answer(reason: str) -> SubgoalPlanner:
    """Return a planner for a subgoal at which eai-eval (the paper's package) raises an exception.

    The planner finds no plans, but raises an error when the search calls it. The error ends the search, and
    the answer is rejected for the given reason.
    """

    def raise_crash_error_instead_of_planning(state: State) -> SubgoalPlanningResult:
        raise _EaiEvalCrashError(reason)

    return raise_crash_error_instead_of_planning


def _set_counted_errors(verdict: SubgoalVerdict, errors: Mapping[FaultKind, int]) -> SubgoalVerdict:
    if verdict.goals is None:
        return verdict
    return replace(verdict, counted=SummaryCounts(bool(verdict.success), verdict.goals, errors))


def parse_subgoals_as_one_text(
    subgoals: Sequence[str], signature: FormulaSignature
) -> f.Formula | RejectedAnswer:
    """Parse the subgoals of an answer as one text.

    The package eai-eval rejects an ``and`` if some of its operands contain ``then`` and others do not, and it
    rejects unknown names. If a text has both errors, eai-eval reports the error whose subformula ends first.
    The number and the names of objects are checked later (``simple_tl_parser.py``, ``simple_tl.py``
    SimpleTLAnd).
    """
    text = _THEN.join(subgoals)
    try:
        formula, misuses = read_formula(text, signature, "release")
    except ParseError as error:
        return reject_unparseable(str(error))
    if _has_partly_temporal_conjunction(formula, signature):
        return reject_unparseable("an 'and' has parts with 'then' and parts without")
    if not misuses:
        return formula
    ends = [*accumulate([len(subgoal) + len(_THEN) for subgoal in subgoals])]
    lines = [0, *accumulate([len(line) + 1 for line in text.split("\n")])]
    numbers = [bisect(ends, lines[misuse.line - 1] + misuse.column - 1) for misuse in misuses]
    return reject_misused_names([*zip(numbers, misuses, strict=True)], ())


def _has_partly_temporal_conjunction(formula: f.Formula, signature: FormulaSignature) -> bool:
    """Whether the first error in a formula's text is an ``and`` with ``then`` in only some of its operands.

    The result is False if an atom with an unknown predicate comes first. The subformula that ends first in
    the text comes first.
    """
    temporal = find_temporal_subformula_ids(formula)
    if not temporal:
        return False
    for part in _list_subformulas_in_postorder(formula):
        if isinstance(part, f.And) and len({id(operand) in temporal for operand in part.operands}) > 1:
            return True
        if isinstance(part, f.Atom) and part.predicate not in signature.predicates:
            return False
    return False


def _list_subformulas_in_postorder(formula: f.Formula) -> Iterable[f.Formula]:
    """Return a formula and all its subformulas, in the order in which they end in the text."""
    parts, pending = [], [formula]
    while pending:
        parts.append(pending.pop())
        pending += get_subformulas(parts[-1])
    return reversed(parts)


def read_subgoal_texts(text: str) -> list[str] | Unreadable:
    """Return the strings of an answer's list ``output``, without blanks at their ends.

    ``}}`` counts as one brace, and the first closing brace ends the answer.
    """
    match = _OBJECT.search(text.strip().replace("}}", "}"))
    if match is None:
        return Unreadable("there is no JSON object")
    try:
        output = json.loads(match[0]).get("output")
    except (ValueError, RecursionError) as error:
        return Unreadable(f"the first pair of braces holds no JSON object: {error}")
    if not isinstance(output, list) or not all(isinstance(subgoal, str) for subgoal in output):
        return Unreadable('"output" is not a list of strings')
    return [subgoal.strip() for subgoal in output]


def draw_disjuncts_and_list_literals(formula: f.Formula, rng: Random) -> list[f.Formula] | None:
    """Return the literals of a formula in order: atoms, actions and their negations.

    A random draw chooses one operand of each ``or``. The result is None if eai-eval rejects the formula.
    """
    if isinstance(formula, (f.Atom, f.Occurs)):
        return [formula]
    if isinstance(formula, f.Or):
        return draw_disjuncts_and_list_literals(rng.choice(formula.operands), rng)
    if isinstance(formula, f.Not):
        negated = _find_negated_atom(formula)
        return None if negated is None else [f.Not(negated)]
    if not isinstance(formula, (f.And, f.Then)):
        return None
    literals_so_far: list[f.Formula] = []
    for part in get_subformulas(formula):
        inner = draw_disjuncts_and_list_literals(part, rng)
        if inner is None:
            return None
        literals_so_far += inner
    return literals_so_far


def _find_negated_atom(formula: f.Formula) -> f.Formula | None:
    """Return the negated atom or action of a formula, or None if the formula is no negated atom or action."""
    odd = False
    while isinstance(formula, f.Not):
        formula, odd = formula.operand, not odd
    return formula if odd and isinstance(formula, (f.Atom, f.Occurs)) else None
