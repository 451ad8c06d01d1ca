"""How eai-eval 1.0.5 reads VirtualHome subgoals (spec sections b and e; reference: ``subgoal_plan.py``).

Its quirks: an answer ends at the first closing brace; strings without anything like ``word(...)`` vanish; a
string with `` or `` is cut there as plain text, whatever the brackets say, and one piece is taken by lot
(see `lots`); a quantifier is a parsing error, and so is a negation or an object without an id, but
only when the search gets to it.
"""

from __future__ import annotations

import re

from eai.abilities.subgoal_decomposition.search import uncategorised
from eai.abilities.subgoal_decomposition.written import Unreadable, WrittenSubgoals
from eai.benchmarks.reference.lots import Lots
from eai.benchmarks.reference.subgoals import read_output
from eai.logic.formula import FALSE, And, Formula
from eai.logic.traversal import children, is_state_formula, walk
from eai.world.execution import Fault

_PRIMITIVE = re.compile(r"\w+\(.*?\)")
_WITHOUT_ARGUMENTS = frozenset({"SLEEP", "WAKEUP", "STANDUP"})


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
    return lots.choice(subgoal.split(" or ")) if _PRIMITIVE.search(subgoal) else None


def halts(fault: Fault) -> bool:
    """Whether the reference raises an exception when it diagnoses a fault, which makes a parsing error.

    It does so for faults that it does not categorise and, in the revision with which its verdicts were
    published, for a missing step of which it does not say what is missing (``checkers.py``,
    ``check_missing_preconds``). Release 1.0.5 calls the latter a missing step; 1 row of nine models differs.
    """
    return uncategorised(fault) or fault.check.sought == (FALSE,)


def conjoins_moments(formula: Formula) -> bool:
    """Whether some ``and`` has parts with ``then`` and parts without, which the reference rejects."""
    return any(
        isinstance(part, And) and len({is_state_formula(operand) for operand in children(part)}) > 1
        for part in walk(formula)
    )
