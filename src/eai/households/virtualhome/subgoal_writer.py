"""Plans made of VirtualHome subgoals: for built-in models and tests.

Since each subgoal is translated into several actions, and every translation turns the character away from
what it faces, a plan of actions is not a plan of subgoals. `subgoal_planner` therefore chooses actions that
subgoals can stand for, and carries out what those are translated into.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from eai.abilities.subgoal_decomposition.program import Plan
from eai.abilities.task import Task
from eai.households.virtualhome import domain as virtualhome
from eai.logic.formula import Atom, Constant, Formula, Occurs
from eai.logic.ltl_printer import print_ltl
from eai.planning.planner import Planner
from eai.reference.virtualhome_translation import (
    BROUGHT_ABOUT_BY,
    plans_of_action,
    plans_of_state,
)
from eai.world.execution import Action
from eai.world.state import Fact, Scene, State

STATES = {action: state for state, (action, *_) in BROUGHT_ABOUT_BY.items() if state != "CLEAN"}
"""The state of an object that stands for an action; the ways of cleaning have names of their own."""

PLACES = {"PUTBACK": "ONTOP", "PUTIN": "INSIDE", "POUR": "INSIDE"}
"""The relation of two objects that stands for an action."""

POSITIONS = {"SIT": "ONTOP", "LIE": "ONTOP", "TURNTO": "FACING", "FIND": "NEXT_TO"}
"""The relation of the character to an object that stands for an action."""

OTHERS = ("WALK", "GRAB", "PUTON")
"""Actions for which the state at hand decides what stands for them."""

POSTURE = "STANDUP"
"""The action for which nothing stands: it is done where a subgoal needs it."""


def subgoal_planner(actions: Iterable[str]) -> Planner:
    """A planner whose steps can each be written as a subgoal, where these actions stand for themselves."""
    written = {*STATES, *PLACES, *POSITIONS, *OTHERS, POSTURE, *actions}
    meant = virtualhome.as_meant()
    unwritten = [operator.name for operator in meant.operators if operator.name not in written]
    return Planner(meant.with_operators(without=unwritten), _carry_out)


def write_subgoals(task: Task, plan: Iterable[Action]) -> tuple[str, ...]:
    """The subgoals for a plan of `subgoal_planner`, each as a formula."""
    compiled = virtualhome.as_meant().compiled
    state = task.initial
    subgoals: list[str] = []
    for action in plan:
        if action.operator != POSTURE:
            literals = dict.fromkeys(_literals(action, state))
            subgoals += [print_ltl(_formula(literal, task.scene)) for literal in literals]
        for step in _carry_out(action, state):
            operator = compiled[step.operator]
            state = operator.apply(state, operator.bind(state, step.arguments))
    return tuple(subgoals)


def _literals(action: Action, state: State) -> Iterator[Action | Fact]:
    """What stands for an action, and before it for what it needs: going to things, turning and taking.

    So a search has little to add.
    """
    first, others = action.arguments[:1], action.arguments[1:]
    yield from _going_to(first if action.operator != "WALK" else (), state)
    for step in _carry_out(action, state)[:-1]:
        if step.operator in ("GRAB", "TURNTO") and state.scene.agent not in step.arguments:
            yield _literal(step, state)
    yield from _going_to(others, state)
    yield _literal(action, state)


def _going_to(objects: Iterable[int], state: State) -> Iterator[Fact]:
    """That the character is next to objects that it is not next to; rooms are gone into by another action."""
    agent = state.scene.agent
    for about in objects:
        if agent is not None and not state.has("ROOM", about) and not state.has("NEXT_TO", agent, about):
            yield Fact("NEXT_TO", (agent, about))


def _literal(action: Action, state: State) -> Action | Fact:
    """What stands for an action: itself, or a fact that it brings about."""
    name, arguments = action
    agent = state.scene.agent
    if agent is None:
        return action
    match name:
        case "WALK":
            is_room = state.has("ROOM", *arguments)
            return Fact("INSIDE" if is_room else "NEXT_TO", (agent, *arguments))
        case "GRAB":
            right_hand_is_free = not state.relation("HOLDS_RH").row(agent)
            return Fact("HOLDS_RH" if right_hand_is_free else "HOLDS_LH", (agent, *arguments))
        case "PUTON":
            return Fact("ONTOP", (*arguments, agent))
    if name in POSITIONS:
        return Fact(POSITIONS[name], (agent, *arguments))
    relation = STATES.get(name) or PLACES.get(name)
    if relation is None or (relation in PLACES.values() and state.has(relation, *arguments)):
        return action
    return Fact(relation, arguments)


def _carry_out(action: Action, state: State) -> Plan:
    """The translation of what stands for an action that ends in it; for walking up to a thing, finding it."""
    literal = _literal(action, state)
    if isinstance(literal, Fact):
        plans = plans_of_state(literal.predicate, literal.arguments, state)
    else:
        plans = plans_of_action(literal.operator, literal.arguments, state)
    return next((plan for plan in plans if plan[-1] == action), plans[0] if plans else ())


def _formula(literal: Action | Fact, scene: Scene) -> Formula:
    terms = tuple(Constant(scene.objects[i].name) for i in literal.arguments)
    return Atom(literal.predicate, terms) if isinstance(literal, Fact) else Occurs(literal.operator, terms)
