"""How eai-eval 1.0.5 reads and checks BEHAVIOR subgoals (``subgoal_plan.py``, ``checkers.py``).

Its quirks: every ``}}`` becomes one brace; an answer ends at the first closing brace; strings that contain
the word agent or the name of a quantifier vanish; a string with `` or `` is cut there as plain text, whatever
the brackets say, and one piece is taken by lot (see `lots`); a t-shirt becomes a shirt, which no
scene has.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import NamedTuple

from eai.abilities.subgoal_decomposition.behavior_vocabulary import ACTIONS, STATES
from eai.abilities.subgoal_decomposition.written import Unreadable, WrittenSubgoals
from eai.benchmarks.reference.lots import Lots
from eai.benchmarks.reference.subgoals import read_output
from eai.logic.formula import Atom, Formula, Occurs
from eai.logic.traversal import walk
from eai.world.fault import FaultKind

_QUANTIFIERS = ("forall", "exists", "forpairs", "forn")


def read_subgoals(text: str, lots: Lots) -> WrittenSubgoals | Unreadable:
    """The subgoals that the reference finds in an answer, alternatives drawn by lot."""
    output = read_output(text.replace("toggled.on", "toggledon").replace("t-shirt", "shirt"))
    if isinstance(output, Unreadable):
        return output
    pieces = [lots.choice(subgoal.split(" or ")) for subgoal in output if _is_kept(subgoal)]
    return WrittenSubgoals(tuple([piece for piece in pieces if piece]))


def _is_kept(subgoal: str) -> bool:
    return "agent" not in subgoal and not any(word in subgoal for word in _QUANTIFIERS)


def wrong_use(formula: Formula, objects: Collection[str]) -> tuple[FaultKind, str] | None:
    """What the reference finds wrong with the primitives of a formula: its semantic check.

    Numbers of objects come before objects that there are not. An exception, which makes a parsing error,
    comes of a primitive without objects, and of one whose number of objects is in no table, unless a wrong
    number was found before it. States are looked at before actions.
    """
    parts = tuple(walk(formula))
    primitives = [
        *(_Primitive(p.predicate, STATES.get(p.predicate), p) for p in parts if isinstance(p, Atom)),
        *(_Primitive(p.action, ACTIONS[p.action], p) for p in parts if isinstance(p, Occurs)),
    ]
    for name, _, part in primitives:
        if not part.arguments:
            return FaultKind.PARSING, f"{name} has no objects"
    for name, arity, part in primitives:
        if arity is None:
            return FaultKind.PARSING, f"{name} is in no table of numbers of objects"
        if len(part.arguments) != arity:
            return FaultKind.ARGUMENT_NUMBER, f"{name} takes {arity} objects, not {len(part.arguments)}"
    for name, _, part in primitives:
        for term in part.arguments:
            if term.name not in objects:
                return FaultKind.HALLUCINATION, f"{name}: there is no {term.name}"
    return None


class _Primitive(NamedTuple):
    """A state or action in a formula, and the number of objects that it takes, if that is known."""

    name: str
    arity: int | None
    part: Atom | Occurs
