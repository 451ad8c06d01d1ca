"""How protocol `strict` reads BEHAVIOR subgoals.

An answer is an object with the key ``output``, anywhere in the text: a list of formulas. What is about the
robot or has a quantifier, which the prompt rules out, is left out; ``toggled.on`` and the hyphen of t-shirts
are spelt as formulas can have them. All of these are repairs.
"""

from __future__ import annotations

import re

from eai.abilities.subgoal_decomposition import answer
from eai.abilities.subgoal_decomposition.written import Unreadable, WrittenSubgoals

_QUANTIFIER = re.compile(r"\b(?:forall|exists|forn|forpairs|fornpairs)\b")
_ROBOT = re.compile(r"\bagent(?:_n_01)?\b")
_SPELLINGS = (("toggled.on", "toggledon"), ("toggled_on", "toggledon"), ("t-shirt", "t_shirt"))


def read_subgoals(text: str) -> WrittenSubgoals | Unreadable:
    """The subgoals in an answer, or why there are none."""
    written = answer.read_subgoals(text, frozenset())
    if isinstance(written, Unreadable):
        return written
    repairs = dict.fromkeys(written.repairs)
    kept: list[str] = []
    for subgoal in written.subgoals:
        if _QUANTIFIER.search(subgoal):
            repairs["quantifier"] = None
        elif _ROBOT.search(subgoal):
            repairs["robot"] = None
        else:
            spelt = _spelt(subgoal)
            repairs |= {} if spelt == subgoal else {"spelling": None}
            kept.append(spelt)
    return WrittenSubgoals(tuple(kept), tuple(repairs))


def _spelt(subgoal: str) -> str:
    for written, meant in _SPELLINGS:
        subgoal = subgoal.replace(written, meant)
    return subgoal
