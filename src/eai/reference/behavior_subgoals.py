"""How eai-eval 1.0.5 reads and checks BEHAVIOR subgoals (``subgoal_plan.py``, ``checkers.py``).

Its quirks: every ``}}`` becomes one brace; an answer ends at the first closing brace; strings that contain
the word agent or the name of a quantifier vanish; a string with `` or `` is cut there as plain text, whatever
the brackets say, and one piece is taken by lot (see `lots`); a t-shirt becomes a shirt, which no
scene has.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace
from typing import NamedTuple

from eai.abilities.subgoal_decomposition.compiled import Compiled, Rejected, unparseable
from eai.abilities.subgoal_decomposition.lexicon import SubgoalLexicon
from eai.abilities.subgoal_decomposition.notation import WrittenSubgoals
from eai.abilities.subgoal_decomposition.program import Do, End, Instruction, Program
from eai.abilities.subgoal_decomposition.search import SearchLimits
from eai.abilities.subgoal_decomposition.verdict import SubgoalCategory
from eai.abilities.unreadable import Unreadable
from eai.abilities.verdict import ErrorReport
from eai.households.behavior.subgoal_notation import BehaviorSubgoals
from eai.households.behavior.subgoal_vocabulary import (
    ACTIONS,
    STATES,
    category_predicates,
    meant,
    published_names,
)
from eai.households.behavior.tasks import BehaviorTask
from eai.logic.formula import Atom, Formula, Occurs
from eai.logic.signature import Signature, takes
from eai.logic.traversal import walk
from eai.planning.subgoal import GroundAtom
from eai.reference import behavior_domain
from eai.reference.behavior_goal_test import behavior_goal_test
from eai.reference.behavior_translation import are_done_together, plans_for
from eai.reference.lots import Lots
from eai.reference.subgoals import ReferenceSubgoals, literals, parse_at_once, read_output
from eai.world.fault import FaultKind
from eai.world.state import Scene

_QUANTIFIERS = ("forall", "exists", "forpairs", "forn")


class PublishedSubgoals(BehaviorSubgoals):
    """The reference's names; it checks numbers of objects and names of objects in an order of its own."""

    def lexicon(self, scene: Scene) -> SubgoalLexicon:
        """The names of the data set, where parts of objects have none."""
        predicates = dict.fromkeys((*category_predicates(scene), *STATES))
        return meant(scene, Signature(predicates, dict.fromkeys(ACTIONS), None), published_names(scene))


class BehaviorSubgoalDecomposition(ReferenceSubgoals):
    """BEHAVIOR subgoals as the reference scores them.

    What needs no action is passed over, and so are actions. An answer that is not carried out leaves the
    goals as they are in the initial state.
    """

    def __init__(self, task: BehaviorTask, *, limits: SearchLimits | None = None) -> None:
        task = replace(task, initial=task.initial_as_published)
        domain = behavior_domain.as_in_reference_subgoals()
        goals = behavior_goal_test(task)
        super().__init__(task, domain, PublishedSubgoals(), goals=goals, limits=limits)
        self.excluded = None

    def compile_by_lot(self, text: str, lots: Lots) -> Compiled | Rejected:
        """The answer as a program for the search, or what is wrong with it."""
        formula = parse_at_once(read_subgoals(text, lots), self.lexicon.signature)
        if isinstance(formula, Rejected):
            return formula
        wrong = wrong_use(formula, self.lexicon.objects)
        if wrong is not None:
            kind, detail = wrong
            parsing = kind is FaultKind.PARSING
            category = SubgoalCategory.NOT_PARSEABLE if parsing else SubgoalCategory.HALLUCINATION
            return Rejected(category, ErrorReport(kind, None, detail))
        found = literals(formula, lots)
        if found is None:
            return unparseable("the reference cannot make a plan of this formula")
        return Compiled(tuple(found), self._program(found))

    def _program(self, found: Sequence[Formula]) -> Program:
        """One literal, or two that are done together, after the other; nothing is tested."""
        asked = [self.lexicon.literal(literal) for literal in found]
        steps: list[tuple[int, tuple[GroundAtom, ...]]] = []
        number = 0
        while number < len(asked):
            pair = tuple([literal for literal in asked[number : number + 2] if literal is not None])
            width = 2 if len(pair) == 2 and are_done_together(*pair) else 1
            first = asked[number]
            if first is not None:
                steps.append((number, pair[:width]))
            number += width
        program: list[Instruction] = [End()]
        for number, together in reversed(steps):
            program.append(Do(plans_for(together), number, len(program) - 1))
        return program

    def _reached_without_running(self) -> tuple[bool, ...]:
        return self.goals.reached(self.task.initial, ())


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
            detail = f"{takes(name, arity, 'object')}, not {len(part.arguments)}"
            return FaultKind.ARGUMENT_NUMBER, detail
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
