"""Score BEHAVIOR subgoals as eai-eval 1.0.5 does (``subgoal_plan.py``, ``checkers.py``).

Defects of its reader:

* every ``}}`` becomes one brace, and an answer ends at the first closing brace;
* strings that contain ``agent`` or the name of a quantifier are ignored;
* a string is split at `` or ``, even inside brackets, and a random draw chooses one piece (see `subgoals`);
* ``t-shirt`` becomes ``shirt``, which no scene has.

The actions for a subgoal depend on the objects in the robot's hands (``state_action_translator.py``). Defect:
a hand that holds ``rag_10`` also counts as holding ``rag_1``, because eai-eval searches for a substring.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from functools import partial
from random import Random
from typing import TypeAlias

from eai.abilities.subgoal_decomposition.program import (
    ActionSequence,
    CompiledSubgoalAnswer,
    RejectedAnswer,
    SubgoalPlanner,
    SubgoalPlanningResult,
    reject_unparseable,
)
from eai.abilities.subgoal_decomposition.search import ExplorationLimits
from eai.abilities.subgoal_decomposition.verdict import SubgoalAnswerCategory
from eai.abilities.verdict import ErrorReport
from eai.benchmarks.behavior import predicates as p
from eai.benchmarks.behavior.notation import (
    ACTION_ARITIES,
    PREDICATE_ARITIES,
    BehaviorSubgoalNotation,
    make_behavior_lexicon,
    map_object_names_of_paper_to_indices,
    map_predicates_to_categories,
)
from eai.benchmarks.behavior.tasks import BehaviorTask
from eai.extensions.reference import behavior_quirks
from eai.extensions.reference.behavior_quirks import make_behavior_goal_test
from eai.extensions.reference.subgoals import EaiEvalSubgoalScorer
from eai.logic.formula import Atom, Formula, Occurs
from eai.logic.signature import FormulaSignature, describe_wrong_arity
from eai.logic.traversal import walk_subformulas
from eai.planning.subgoal import GroundAtom
from eai.tasks.lexicon import FormulaNameLexicon
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
"""Mapping from ``LEFT`` and ``RIGHT`` to the index of the object in this hand; None for an empty hand."""


def read_hands(state: State) -> _Hands:
    """Return for each hand the index of the object that it holds in a state; None for an empty hand."""
    masks = {"LEFT": state.mask(p.in_left_hand.name), "RIGHT": state.mask(p.in_right_hand.name)}
    return {hand: mask.bit_length() - 1 if mask else None for hand, mask in masks.items()}


def _plan_literal(literal: GroundAtom, state: State) -> SubgoalPlanningResult:
    predicate, arguments, truth = literal
    plan = (_plan_to_make_true if truth else _plan_to_make_false)(
        predicate, arguments, read_hands(state), state.scene
    )
    return SubgoalPlanningResult(() if plan is None else (plan,))


def _plan_placing_on_and_next_to(
    on_literal: GroundAtom, next_to_literal: GroundAtom, state: State
) -> SubgoalPlanningResult:
    """Return the plan that makes two literals true: it puts an object onto one object and next to another."""
    (object_index, support), (one, other) = on_literal.arguments, next_to_literal.arguments
    neighbour = one if object_index == other else other
    actions, hand = _plan_to_take_object(object_index, read_hands(state), state.scene)
    return SubgoalPlanningResult(((*actions, Action(f"{hand}_PLACE_NEXTTO_ONTOP", (neighbour, support))),))


def _plan_to_make_true(
    predicate: str, arguments: tuple[int, ...], hands: _Hands, scene: Scene
) -> ActionSequence | None:
    if predicate in _PLACING:
        object_index, place = arguments
        actions, hand = _plan_to_take_object(object_index, hands, scene)
        return (*actions, Action(f"{hand}_{_PLACING[predicate]}", (place,)))
    if predicate in _HOLDING:
        hand = _HOLDING[predicate]
        return (*_plan_to_empty_hand(hand, hands), Action(f"{hand}_GRASP", arguments))
    if predicate in _ACHIEVING:
        return (*_free_a_hand(hands), Action(_ACHIEVING[predicate], arguments))
    return None


def _plan_to_make_false(
    predicate: str, arguments: tuple[int, ...], hands: _Hands, scene: Scene
) -> ActionSequence | None:
    if predicate == "inside":
        actions, _ = _plan_to_take_object(arguments[0], hands, scene)
        return (*actions, Action("RIGHT_RELEASE", arguments[:1]))
    if predicate in _HOLDING:
        hand = _HOLDING[predicate]
        return _plan_to_empty_hand(hand, hands) if _find_hand_with(arguments[0], hands, scene) == hand else ()
    if predicate in _UNDOING:
        return (*_free_a_hand(hands), Action(_UNDOING[predicate], arguments))
    return None


def _plan_to_take_object(object_index: int, hands: _Hands, scene: Scene) -> tuple[ActionSequence, str]:
    """Return the actions that take an object, and the hand: ``LEFT`` or ``RIGHT``.

    An object in a hand stays there. Otherwise the right hand takes the object, or the left hand if only that
    one is free.
    """
    hand = _find_hand_with(object_index, hands, scene)
    if hand is not None:
        return (), hand
    hand = "LEFT" if hands["LEFT"] is None and hands["RIGHT"] is not None else "RIGHT"
    return (*_plan_to_empty_hand(hand, hands), Action(f"{hand}_GRASP", (object_index,))), hand


def _find_hand_with(object_index: int, hands: _Hands, scene: Scene) -> str | None:
    name = scene.objects[object_index].name
    full = [(hand, content) for hand, content in hands.items() if content is not None]
    return next((hand for hand, content in full if name in scene.objects[content].name), None)


def _find_on_and_next_to_literals_of_one_action(
    first: GroundAtom, second: GroundAtom
) -> tuple[GroundAtom, GroundAtom] | None:
    """Return two literals in order if one action makes both true: ``ontop`` or ``onfloor``, then ``nextto``.

    Return None if no single action makes both true.
    """
    for on, by in ((first, second), (second, first)):
        if on.predicate in _SUPPORTING and by.predicate == "nextto" and on.truth and by.truth:
            return (on, by) if on.arguments[0] in by.arguments else None
    return None


def _plan_to_empty_hand(hand: str, hands: _Hands) -> ActionSequence:
    content = hands[hand]
    return () if content is None else (Action(f"{hand}_RELEASE", (content,)),)


def _free_a_hand(hands: _Hands) -> ActionSequence:
    return () if hands["LEFT"] is None or hands["RIGHT"] is None else _plan_to_empty_hand("RIGHT", hands)


_QUANTIFIERS = ("forall", "exists", "forpairs", "forn")


class _BehaviorSubgoalNotation(BehaviorSubgoalNotation):
    """The notation of BEHAVIOR subgoals, read as eai-eval (the paper's package) reads it.

    Reading does not check how many arguments a predicate or action has.
    `reject_wrong_argument_counts_and_names` checks these numbers later.
    """

    def make_lexicon_of_names_in_subgoals(self, scene: Scene) -> FormulaNameLexicon:
        """Return the names of predicates, actions and objects that formulas of subgoals may use.

        The names are those in the data set. Parts of objects have no names there.
        """
        predicates = dict.fromkeys((*map_predicates_to_categories(scene), *PREDICATE_ARITIES))
        return make_behavior_lexicon(
            scene,
            FormulaSignature(predicates, dict.fromkeys(ACTION_ARITIES), None),
            map_object_names_of_paper_to_indices(scene),
        )


class BehaviorSubgoalDecompositionScorer(EaiEvalSubgoalScorer):
    """Scores BEHAVIOR subgoals as eai-eval (the paper's package) does.

    Subgoals that are actions or need no action are skipped. If an answer is not executed, the goals that hold
    in the initial state count as reached.
    """

    def __init__(self, task: BehaviorTask, *, limits: ExplorationLimits | None = None) -> None:
        task = replace(task, initial=task.initial_as_published)
        domain = behavior_quirks.make_subgoal_domain_with_all_quirks()
        goals = make_behavior_goal_test(task)
        super().__init__(task, domain, _BehaviorSubgoalNotation(), goals=goals, limits=limits)
        self.excluded = None

    def compile_answer(self, text: str) -> CompiledSubgoalAnswer | RejectedAnswer:
        """Return an answer's subgoals as a program, or why the answer is rejected.

        A program is a list of instructions, which the search for executions follows.
        """
        return super().compile_answer(text.replace("toggled.on", "toggledon").replace("t-shirt", "shirt"))

    def _draw_disjunct(self, subgoal: str, rng: Random) -> str | None:
        if "agent" in subgoal or any(word in subgoal for word in _QUANTIFIERS):
            return None
        return rng.choice(subgoal.split(" or ")) or None

    def _reject_wrongly_used_names(self, formula: Formula) -> RejectedAnswer | None:
        return reject_wrong_argument_counts_and_names(formula, self.lexicon.objects)

    def _make_planners_with_index_of_first_literal(
        self, literals: Sequence[Formula]
    ) -> list[tuple[int, SubgoalPlanner]]:
        """Return the planners that find actions for the literals of an answer, in order.

        Usually, a planner makes one literal true. If one action can make two successive literals true, they
        share a planner. Each planner is paired with the index of its first literal. Subgoals that are actions
        or need no action get no planner.
        """
        atoms = [self.lexicon.to_literal(literal) for literal in literals]
        steps: list[tuple[int, SubgoalPlanner]] = []
        number = 0
        while number < len(atoms):
            first, second = (*atoms, None)[number : number + 2]
            pair = (
                None
                if first is None or second is None
                else _find_on_and_next_to_literals_of_one_action(first, second)
            )
            if pair is not None:
                steps.append((number, partial(_plan_placing_on_and_next_to, *pair)))
            elif first is not None:
                steps.append((number, partial(_plan_literal, first)))
            number += 1 if pair is None else 2
        return steps

    def _get_goals_met_by_rejected_answer(self) -> tuple[bool, ...]:
        return self.goals.evaluate_each_goal(self.task.initial, ())


def reject_wrong_argument_counts_and_names(
    formula: Formula, object_names: Collection[str]
) -> RejectedAnswer | None:
    """Return why eai-eval's semantic check rejects the formula of an answer, or None if it accepts it.

    The package eai-eval checks the numbers of objects before their names, and predicates before actions. In
    two cases it raises an exception, which counts as a parsing error: a predicate or action has no objects,
    or eai-eval does not know a predicate's number of objects. Only the first error is reported. A predicate
    or action without objects always counts as the first error.
    """
    parts = tuple(walk_subformulas(formula))
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
            detail = describe_wrong_arity(name, arity, "object", len(part.arguments))
            return _reject_misused_name(FaultKind.ARGUMENT_NUMBER, detail)
    for name, _, part in primitives:
        for term in part.arguments:
            if term.name not in object_names:
                return _reject_misused_name(FaultKind.HALLUCINATION, f"{name}: there is no {term.name}")
    return None


def _reject_misused_name(kind: FaultKind, detail: str) -> RejectedAnswer:
    return RejectedAnswer(SubgoalAnswerCategory.HALLUCINATION, ErrorReport(kind, None, detail))
