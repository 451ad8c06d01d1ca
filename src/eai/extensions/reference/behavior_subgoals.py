"""BEHAVIOR subgoals as eai-eval 1.0.5 reads and checks them (``subgoal_plan.py``, ``checkers.py``).

Its quirks: every ``}}`` becomes one brace; an answer ends at the first closing brace; strings that contain
the word agent or the name of a quantifier vanish; a string with `` or `` is cut there as plain text, whatever
the brackets say, and one piece is taken by lot (see `subgoals`); a t-shirt becomes a shirt, which no
scene has.

What its robot does for a subgoal depends on what the hands hold (``state_action_translator.py``). Quirk: a
hand counts as holding an object whose name is part of the name of what it holds, such as ``rag_1`` of
``rag_10``.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from functools import partial
from random import Random
from typing import TypeAlias

from eai.abilities.subgoal_decomposition.program import (
    ActionSequence,
    CompiledAnswer,
    RejectedAnswer,
    SubgoalPlanner,
    SubgoalPlans,
    reject_unparseable,
)
from eai.abilities.subgoal_decomposition.search import ExplorationLimits
from eai.abilities.subgoal_decomposition.verdict import SubgoalCategory
from eai.abilities.verdict import ErrorReport
from eai.benchmarks.behavior import predicates as p
from eai.benchmarks.behavior.notation import (
    ACTION_ARITIES,
    PREDICATE_ARITIES,
    BehaviorSubgoals,
    make_lexicon,
    map_category_predicates,
    map_published_names,
)
from eai.benchmarks.behavior.tasks import BehaviorTask
from eai.extensions.reference import behavior_quirks
from eai.extensions.reference.behavior_quirks import behavior_goal_test
from eai.extensions.reference.subgoals import ReferenceSubgoals
from eai.logic.formula import Atom, Formula, Occurs
from eai.logic.signature import Signature, describe_arity
from eai.logic.traversal import walk
from eai.planning.subgoal import GroundAtom
from eai.tasks.lexicon import FormulaLexicon
from eai.world.action import Action
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


_Hands: TypeAlias = Mapping[str, int | None]
"""The object in each hand, ``LEFT`` and ``RIGHT``, by index."""


def held(state: State) -> _Hands:
    """Return the objects in both hands in a state."""
    masks = {"LEFT": state.mask(p.in_left_hand.name), "RIGHT": state.mask(p.in_right_hand.name)}
    return {hand: mask.bit_length() - 1 if mask else None for hand, mask in masks.items()}


def _plan(literal: GroundAtom, state: State) -> SubgoalPlans:
    """The plan for a literal; none if no action brings it about."""
    predicate, arguments, truth = literal
    plan = (_achieve if truth else _undo)(predicate, arguments, held(state), state.scene)
    return SubgoalPlans(() if plan is None else (plan,))


def _place_together(on: GroundAtom, by: GroundAtom, state: State) -> SubgoalPlans:
    """The plan for two literals that are done together, in the order of `_together`."""
    (thing, support), (one, other) = on.arguments, by.arguments
    neighbour = one if thing == other else other
    actions, hand = _take(thing, held(state), state.scene)
    return SubgoalPlans(((*actions, Action(f"{hand}_PLACE_NEXTTO_ONTOP", (neighbour, support))),))


def _achieve(
    predicate: str, arguments: tuple[int, ...], hands: _Hands, scene: Scene
) -> ActionSequence | None:
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


def _undo(predicate: str, arguments: tuple[int, ...], hands: _Hands, scene: Scene) -> ActionSequence | None:
    if predicate == "inside":
        actions, _ = _take(arguments[0], hands, scene)
        return (*actions, Action("RIGHT_RELEASE", arguments[:1]))
    if predicate in _HOLDING:
        hand = _HOLDING[predicate]
        return _emptied(hand, hands) if _hand_with(arguments[0], hands, scene) == hand else ()
    if predicate in _UNDOING:
        return (*_one_free(hands), Action(_UNDOING[predicate], arguments))
    return None


def _take(thing: int, hands: _Hands, scene: Scene) -> tuple[ActionSequence, str]:
    """The actions after which a hand holds the object, and which: the left one if it alone is free."""
    hand = _hand_with(thing, hands, scene)
    if hand is not None:
        return (), hand
    hand = "LEFT" if hands["LEFT"] is None and hands["RIGHT"] is not None else "RIGHT"
    return (*_emptied(hand, hands), Action(f"{hand}_GRASP", (thing,))), hand


def _hand_with(thing: int, hands: _Hands, scene: Scene) -> str | None:
    name = scene.objects[thing].name
    full = [(hand, content) for hand, content in hands.items() if content is not None]
    return next((hand for hand, content in full if name in scene.objects[content].name), None)


def _together(first: GroundAtom, second: GroundAtom) -> tuple[GroundAtom, GroundAtom] | None:
    """Two literals that are done together: what supports the object, then what is next to it."""
    for on, by in ((first, second), (second, first)):
        if on.predicate in _SUPPORTING and by.predicate == "nextto" and on.truth and by.truth:
            return (on, by) if on.arguments[0] in by.arguments else None
    return None


def _emptied(hand: str, hands: _Hands) -> ActionSequence:
    content = hands[hand]
    return () if content is None else (Action(f"{hand}_RELEASE", (content,)),)


def _one_free(hands: _Hands) -> ActionSequence:
    """The actions after which at least one hand is free."""
    return () if hands["LEFT"] is None or hands["RIGHT"] is None else _emptied("RIGHT", hands)


_QUANTIFIERS = ("forall", "exists", "forpairs", "forn")


class _Notation(BehaviorSubgoals):
    """The reference's names; it checks numbers of objects and names of objects in an order of its own."""

    def lexicon(self, scene: Scene) -> FormulaLexicon:
        """The names of the data set, where parts of objects have none."""
        predicates = dict.fromkeys((*map_category_predicates(scene), *PREDICATE_ARITIES))
        return make_lexicon(
            scene, Signature(predicates, dict.fromkeys(ACTION_ARITIES), None), map_published_names(scene)
        )


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

    def compile(self, text: str) -> CompiledAnswer | RejectedAnswer:
        """The answer as a program for the search, or what is wrong with it."""
        return super().compile(text.replace("toggled.on", "toggledon").replace("t-shirt", "shirt"))

    def _piece(self, subgoal: str, lots: Random) -> str | None:
        if "agent" in subgoal or any(word in subgoal for word in _QUANTIFIERS):
            return None
        return lots.choice(subgoal.split(" or ")) or None

    def _misuse(self, formula: Formula) -> RejectedAnswer | None:
        return wrong_use(formula, self.lexicon.objects)

    def _plans(self, found: Sequence[Formula]) -> list[tuple[int, SubgoalPlanner]]:
        """One literal, or two that are done together, at a time."""
        atoms = [self.lexicon.to_literal(literal) for literal in found]
        steps: list[tuple[int, SubgoalPlanner]] = []
        number = 0
        while number < len(atoms):
            first, second = (*atoms, None)[number : number + 2]
            pair = None if first is None or second is None else _together(first, second)
            if pair is not None:
                steps.append((number, partial(_place_together, *pair)))
            elif first is not None:
                steps.append((number, partial(_plan, first)))
            number += 1 if pair is None else 2
        return steps

    def _test_goals_unexecuted(self) -> tuple[bool, ...]:
        return self.goals.find_reached(self.task.initial, ())


def wrong_use(formula: Formula, objects: Collection[str]) -> RejectedAnswer | None:
    """The rejection for the error that the reference finds in the primitives of a formula (semantic check).

    Numbers of objects come before objects that there are not. An exception, which makes a parsing error,
    comes of a primitive without objects, and of one whose number of objects is in no table, unless a wrong
    number was found before it. States are looked at before actions.
    """
    parts = tuple(walk(formula))
    primitives: list[tuple[str, int | None, Atom | Occurs]] = [
        *((p.predicate, PREDICATE_ARITIES.get(p.predicate), p) for p in parts if isinstance(p, Atom)),
        *((p.action, ACTION_ARITIES[p.action], p) for p in parts if isinstance(p, Occurs)),
    ]
    for name, _, part in primitives:
        if not part.arguments:
            return reject_unparseable(f"{name} has no objects")
    for name, arity, part in primitives:
        if arity is None:
            return reject_unparseable(f"{name} is in no table of numbers of objects")
        if len(part.arguments) != arity:
            detail = f"{describe_arity(name, arity, 'object')}, not {len(part.arguments)}"
            return _misused(FaultKind.ARGUMENT_NUMBER, detail)
    for name, _, part in primitives:
        for term in part.arguments:
            if term.name not in objects:
                return _misused(FaultKind.HALLUCINATION, f"{name}: there is no {term.name}")
    return None


def _misused(kind: FaultKind, detail: str) -> RejectedAnswer:
    return RejectedAnswer(SubgoalCategory.HALLUCINATION, ErrorReport(kind, None, detail))
