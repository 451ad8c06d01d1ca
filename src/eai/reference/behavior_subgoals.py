"""How eai-eval 1.0.5 reads and checks BEHAVIOR subgoals (``subgoal_plan.py``, ``checkers.py``).

Its quirks: every ``}}`` becomes one brace; an answer ends at the first closing brace; strings that contain
the word agent or the name of a quantifier vanish; a string with `` or `` is cut there as plain text, whatever
the brackets say, and one piece is taken by lot (see `Lots`); a t-shirt becomes a shirt, which no
scene has.

What its robot does for a subgoal depends on what the hands hold (``state_action_translator.py``). Quirk: a
hand counts as holding an object whose name is part of the name of what it holds, such as ``rag_1`` of
``rag_10``.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from eai.abilities.subgoal_decomposition.declaration import SubgoalCategory
from eai.abilities.subgoal_decomposition.notation import SubgoalLexicon, WrittenSubgoals
from eai.abilities.subgoal_decomposition.program import (
    Compiled,
    Do,
    End,
    Found,
    Instruction,
    Plan,
    Plans,
    Program,
    Rejected,
    unparseable,
)
from eai.abilities.subgoal_decomposition.search import ExplorationLimits
from eai.abilities.verdict import ErrorReport, Unreadable
from eai.households.behavior import predicates as p
from eai.households.behavior.subgoal_notation import (
    ACTIONS,
    STATES,
    BehaviorSubgoals,
    category_predicates,
    meant,
    published_names,
)
from eai.households.behavior.tasks import BehaviorTask
from eai.logic.formula import Atom, Formula, Occurs
from eai.logic.signature import Signature, takes
from eai.logic.traversal import walk
from eai.planning.subgoal import GroundAtom
from eai.reference import behavior_quirks
from eai.reference.behavior_goal_test import behavior_goal_test
from eai.reference.subgoals import Lots, ReferenceSubgoals, literals, parse_at_once, read_output
from eai.world.execution import Action
from eai.world.fault import FaultKind
from eai.world.state import Scene, State

_PLACING: Mapping[str, str] = {
    "inside": "PLACE_INSIDE",
    "ontop": "PLACE_ONTOP",
    "onfloor": "PLACE_ONTOP",
    "nextto": "PLACE_NEXTTO",
    "under": "PLACE_UNDER",
}
_ACHIEVING: Mapping[str, str] = {
    "cooked": "COOK",
    "burnt": "COOK",
    "frozen": "FREEZE",
    "open": "OPEN",
    "sliced": "SLICE",
    "soaked": "SOAK",
    "toggled_on": "TOGGLE_ON",
}
_UNDOING: Mapping[str, str] = {
    "dusty": "CLEAN",
    "stained": "CLEAN",
    "frozen": "UNFREEZE",
    "open": "CLOSE",
    "toggled_on": "TOGGLE_OFF",
}
_SUPPORTING = ("ontop", "onfloor")
_HOLDING: Mapping[str, str] = {p.in_right_hand.name: "RIGHT", p.in_left_hand.name: "LEFT"}


@dataclass(frozen=True, slots=True)
class _Hands:
    """The objects in the hands, by index."""

    left: int | None
    right: int | None

    def in_hand(self, hand: str) -> int | None:
        """Return the object in a hand, ``LEFT`` or ``RIGHT``."""
        return self.left if hand == "LEFT" else self.right


def held(state: State) -> _Hands:
    """Return the objects in both hands in a state."""
    left, right = state.those(p.in_left_hand.name), state.those(p.in_right_hand.name)
    return _Hands(*(mask.bit_length() - 1 if mask else None for mask in (left, right)))


def are_done_together(first: GroundAtom, second: GroundAtom) -> bool:
    """Whether these put one object onto something and next to something."""
    return _together(first, second) is not None


def plans_for(literals: Sequence[GroundAtom]) -> Plans:
    """The plan for a literal, or for two that are done together; none if no action brings it about."""

    def plans(state: State) -> Found:
        first, *rest = literals
        plan = _place_together(first, rest[0], state) if rest else _plan(first, state)
        return Found(() if plan is None else (plan,))

    return plans


def _plan(literal: GroundAtom, state: State) -> Plan | None:
    predicate, arguments, truth = literal
    return (_achieve if truth else _undo)(predicate, arguments, held(state), state.scene)


def _place_together(first: GroundAtom, second: GroundAtom, state: State) -> Plan | None:
    pair = _together(first, second)
    if pair is None:
        return None
    (thing, support), (one, other) = (each.arguments for each in pair)
    neighbour = one if thing == other else other
    actions, hand = _take(thing, held(state), state.scene)
    return (*actions, Action(f"{hand}_PLACE_NEXTTO_ONTOP", (neighbour, support)))


def _achieve(predicate: str, arguments: tuple[int, ...], hands: _Hands, scene: Scene) -> Plan | None:
    if predicate in _PLACING:
        thing, place = arguments
        actions, hand = _take(thing, hands, scene)
        return (*actions, Action(f"{hand}_{_PLACING[predicate]}", (place,)))
    if predicate in _HOLDING:
        hand = _HOLDING[predicate]
        return (*_emptied(hand, hands), Action(f"{hand}_GRASP", arguments))
    if predicate in _ACHIEVING:
        return (*_one_free(hands), Action(_ACHIEVING[predicate], arguments))
    return None


def _undo(predicate: str, arguments: tuple[int, ...], hands: _Hands, scene: Scene) -> Plan | None:
    if predicate == "inside":
        actions, _ = _take(arguments[0], hands, scene)
        return (*actions, Action("RIGHT_RELEASE", arguments[:1]))
    if predicate in _HOLDING:
        hand = _HOLDING[predicate]
        return _emptied(hand, hands) if _hand_with(arguments[0], hands, scene) == hand else ()
    if predicate in _UNDOING:
        return (*_one_free(hands), Action(_UNDOING[predicate], arguments))
    return None


def _take(thing: int, hands: _Hands, scene: Scene) -> tuple[Plan, str]:
    """The actions after which a hand holds the object, and which: the right one if both are free."""
    hand = _hand_with(thing, hands, scene)
    if hand is not None:
        return (), hand
    if hands.right is None:
        return (Action("RIGHT_GRASP", (thing,)),), "RIGHT"
    if hands.left is None:
        return (Action("LEFT_GRASP", (thing,)),), "LEFT"
    return (*_emptied("RIGHT", hands), Action("RIGHT_GRASP", (thing,))), "RIGHT"


def _hand_with(thing: int, hands: _Hands, scene: Scene) -> str | None:
    found = (hand for hand in ("LEFT", "RIGHT") if _holds(hands.in_hand(hand), thing, scene))
    return next(found, None)


def _holds(content: int | None, thing: int, scene: Scene) -> bool:
    return content is not None and scene.objects[thing].name in scene.objects[content].name


def _together(first: GroundAtom, second: GroundAtom) -> tuple[GroundAtom, GroundAtom] | None:
    """Two literals that are done together: what supports the object, then what is next to it."""
    if not first.truth or not second.truth:
        return None
    if first.predicate in _SUPPORTING and second.predicate == "nextto":
        on, by = first, second
    elif first.predicate == "nextto" and second.predicate in _SUPPORTING:
        on, by = second, first
    else:
        return None
    return (on, by) if on.arguments[0] in by.arguments else None


def _emptied(hand: str, hands: _Hands) -> Plan:
    content = hands.in_hand(hand)
    return () if content is None else (Action(f"{hand}_RELEASE", (content,)),)


def _one_free(hands: _Hands) -> Plan:
    """The actions after which at least one hand is free."""
    return () if hands.left is None or hands.right is None else _emptied("RIGHT", hands)


_QUANTIFIERS = ("forall", "exists", "forpairs", "forn")


class _Notation(BehaviorSubgoals):
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

    def __init__(self, task: BehaviorTask, *, limits: ExplorationLimits | None = None) -> None:
        task = replace(task, initial=task.initial_as_published)
        domain = behavior_quirks.as_in_reference_subgoals()
        goals = behavior_goal_test(task)
        super().__init__(task, domain, _Notation(), goals=goals, limits=limits)
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
