"""How eai-eval 1.0.5 reads VirtualHome subgoals (``subgoal_plan.py``).

Its quirks: an answer ends at the first closing brace; strings without anything like ``word(...)`` vanish; a
string with `` or `` is cut there as plain text, whatever the brackets say, and one piece is taken by lot
(see `lots`); ids are numbers, so that ``soap.01002`` is ``soap.1002``; a quantifier is a parsing error, and
so is a negation or an object without an id, but only when the search gets to it.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

from eai.abilities.goal_test import GoalTest
from eai.abilities.subgoal_decomposition.compiled import Compiled, Rejected, unparseable
from eai.abilities.subgoal_decomposition.notation import WrittenSubgoals
from eai.abilities.subgoal_decomposition.program import Do, End, Halt, Instruction, Program
from eai.abilities.subgoal_decomposition.progress import GoalProgress
from eai.abilities.subgoal_decomposition.search import Outcome, SearchLimits, uncategorised
from eai.abilities.task import Task
from eai.abilities.unreadable import Unreadable
from eai.households.virtualhome.subgoal_notation import ACTIONS, VirtualHomeSubgoals
from eai.logic.formula import FALSE, Atom, Formula, Occurs
from eai.logic.ltl import Dialect, parse
from eai.logic.ltl_printer import print_ltl
from eai.reference import virtualhome_domain
from eai.reference.lots import Lots
from eai.reference.subgoals import ReferenceSubgoals, literals, parse_at_once, read_output
from eai.reference.virtualhome_translation import plans_for, plans_to_take
from eai.world.execution import Fault

_PRIMITIVE = re.compile(r"\w+\(.*?\)")
_LEADING_ZEROS = re.compile(r"\.0+(?=[0-9])")
_WITHOUT_ARGUMENTS = frozenset({"SLEEP", "WAKEUP", "STANDUP"})


class VirtualHomeSubgoalDecomposition(ReferenceSubgoals):
    """VirtualHome subgoals as the reference scores them: the goal counts if it held at any time."""

    def __init__(self, task: Task, *, limits: SearchLimits | None = None) -> None:
        domain, words = virtualhome_domain.as_in_reference(), VirtualHomeSubgoals(ACTIONS)
        super().__init__(task, domain, words, goals=_ActionsSingly(task), limits=limits)
        self.halts = halts
        self.excluded = None

    def compile_by_lot(self, text: str, lots: Lots) -> Compiled | Rejected:
        """The answer as a program for the search, or what is wrong with it."""
        formula = parse_at_once(read_subgoals(text, lots), self.lexicon.signature)
        if isinstance(formula, Rejected):
            return formula
        found = literals(formula, lots)
        if found is None:
            return unparseable("the reference cannot make a plan of this formula")
        return Compiled(tuple(found), self._program(found))

    def _temporal_goal(self) -> Formula | None:
        text = self.task.temporal_goal
        reading = None if text is None else parse(text, self.lexicon.signature, Dialect.RELEASE)
        return None if reading is None or reading.offences else reading.formula

    def _goal_to_reach(self) -> GoalProgress:
        return GoalProgress(self.temporal_goal or FALSE, self.task.scene)

    def _carry_out(self, compiled: Compiled) -> Outcome | Rejected:
        if self.temporal_goal is None:
            return unparseable("the reference cannot read the goal of this task")
        return super()._carry_out(compiled)

    def _program(self, found: Sequence[Formula]) -> Program:
        """One literal after the other, nothing tested; what cannot be translated ends the search."""
        program: list[Instruction] = [End()]
        for number in reversed(range(len(found))):
            program.append(self._instruction(found[number], number, len(program) - 1))
        return program

    def _instruction(self, literal: Formula, number: int, then: int) -> Instruction:
        if not isinstance(literal, (Atom, Occurs)):
            return Halt("a negation cannot be translated")
        if any(term.name not in self.lexicon.objects for term in literal.arguments):
            return Halt(f"{print_ltl(literal)}: an object without an id cannot be translated")
        if isinstance(literal, Occurs):
            action = self.lexicon.action(literal)
            return Do(plans_to_take(action), number, then)
        asked = self.lexicon.literal(literal)
        if asked is None:
            raise AssertionError(f"{print_ltl(literal)} is about no objects")
        return Do(plans_for(asked), number, then)


class _ActionsSingly(GoalTest):
    """Action goals are met in any order, up to the first that is not met (``my_scene_evaluate``)."""

    def _met(self, goals: Sequence[tuple[str, ...]], actions: Sequence[str]) -> Sequence[int]:
        met = [not set(wanted).isdisjoint(actions) for wanted in goals]
        return range((*met, False).index(False))


def read_subgoals(text: str, lots: Lots) -> WrittenSubgoals | Unreadable:
    """The subgoals that the reference finds in an answer, alternatives drawn by lot."""
    output = read_output(text)
    if isinstance(output, Unreadable):
        return output
    pieces = [_piece(subgoal, lots) for subgoal in output]
    return WrittenSubgoals(tuple([piece for piece in pieces if piece is not None]))


def _piece(subgoal: str, lots: Lots) -> str | None:
    if subgoal in _WITHOUT_ARGUMENTS:
        return f"{subgoal}()"
    if _PRIMITIVE.search(subgoal) is None:
        return None
    return _LEADING_ZEROS.sub(".", lots.choice(subgoal.split(" or ")))


def halts(fault: Fault) -> bool:
    """Whether the reference raises an exception when it diagnoses a fault, which makes a parsing error.

    It does so for faults that it does not categorise, and for a missing step of which it does not say what is
    missing, such as SIT where no seat is left (``checkers.py``, ``check_missing_preconds``). In plans release
    1.0.5 calls the latter a missing step, because action sequencing has a test of order of its own
    (``simulation/evolving_graph/checker.py``); in subgoals it has not changed.
    """
    return uncategorised(fault) or fault.check.sought == (FALSE,)
