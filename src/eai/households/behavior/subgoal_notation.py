"""How BEHAVIOR subgoals are read and written.

An answer is an object with the key ``output``, anywhere in the text: a list of formulas. What is about the
robot or has a quantifier, which the prompt rules out, is left out; ``toggled.on`` and the hyphen of t-shirts
are spelt as formulas can have them. All of these are repairs.
"""

from __future__ import annotations

import re

from eai.abilities.subgoal_decomposition.lexicon import SubgoalLexicon
from eai.abilities.subgoal_decomposition.notation import SubgoalNotation, WrittenSubgoals, read_output
from eai.abilities.unreadable import Unreadable
from eai.households.behavior import domain as behavior
from eai.households.behavior.subgoal_vocabulary import lexicon
from eai.world.state import Scene

_QUANTIFIER = re.compile(r"\b(?:forall|exists|forn|forpairs|fornpairs)\b")
_ROBOT = re.compile(r"\bagent(?:_n_01)?\b")
_SPELLINGS = (("toggled.on", "toggledon"), ("toggled_on", "toggledon"), ("t-shirt", "t_shirt"))


class BehaviorSubgoals(SubgoalNotation):
    """The words of BEHAVIOR's prompts."""

    def __init__(self) -> None:
        super().__init__(behavior.as_meant())

    def lexicon(self, scene: Scene) -> SubgoalLexicon:
        """The prompts' names of states, actions and objects."""
        return lexicon(scene)

    def read(self, text: str) -> WrittenSubgoals | Unreadable:
        """The subgoals in an answer, or why there are none."""
        written = read_output(text, frozenset())
        if isinstance(written, Unreadable):
            return written
        repairs = dict.fromkeys(written.repairs)
        kept: list[str] = []
        left_out = [*written.left_out]
        for subgoal in written.subgoals:
            if _QUANTIFIER.search(subgoal):
                repairs["quantifier"] = None
                left_out.append(subgoal)
            elif _ROBOT.search(subgoal):
                repairs["robot"] = None
                left_out.append(subgoal)
            else:
                spelt = _spelt(subgoal)
                repairs |= {} if spelt == subgoal else {"spelling": None}
                kept.append(spelt)
        return WrittenSubgoals(tuple(kept), tuple(repairs), tuple(left_out))


def _spelt(subgoal: str) -> str:
    for written, meant in _SPELLINGS:
        subgoal = subgoal.replace(written, meant)
    return subgoal
