"""Derived predicates follow chains of supports to their end."""

from __future__ import annotations

import random
from itertools import product

import pytest

from benchmarks.behavior.kitchen import make_task, parse_actions
from eai.benchmarks.behavior import domain as behavior
from eai.benchmarks.behavior.predicates import VOCABULARY
from eai.logic.formula import Atom, Constant
from eai.world.action import Action
from eai.world.execution import attempt_action, execute_plan
from eai.world.history import History
from eai.world.relation import iterate_bits
from eai.world.state import State

DOMAIN = behavior.make_domain_with_checks_in_paper_order()
IN_CARTON = (
    "RIGHT_GRASP plate_2",
    "RIGHT_PLACE_ONTOP plate_1",
    "RIGHT_GRASP plate_1",
    "RIGHT_PLACE_INSIDE carton_1",
)


def take_random_walk(seed: int, steps: int = 60) -> list[State]:
    """Return the states of a random walk."""
    choice = random.Random(seed)
    state = make_task().initial
    past = History(state)
    for _ in range(steps):
        operator = choice.choice(DOMAIN.operators)
        arguments = tuple(choice.randrange(len(state.scene.objects)) for _ in operator.parameters)
        outcome = attempt_action(DOMAIN, past, Action(operator.name, arguments))
        if isinstance(outcome, State):
            past = past.extend(outcome)
    return list(past.states)


@pytest.mark.parametrize("seed", range(5))
def test_an_object_has_at_most_one_support_and_never_supports_itself(seed: int) -> None:
    for state in take_random_walk(seed):
        for x in range(len(state.scene.objects)):
            supports = list(iterate_bits(state.relation("lies_in").row(x))) + list(
                iterate_bits(state.relation("lies_on").row(x))
            )
            assert len(supports) <= 1
            assert not DOMAIN.holds(Atom("carried_by", (_name(state, x), _name(state, x))), state)


def _name(state: State, index: int) -> Constant:
    return Constant(state.scene.objects[index].name)


def test_indirect_supports_are_found() -> None:
    initial = make_task().initial
    state = execute_plan(DOMAIN, initial, parse_actions(initial, *IN_CARTON)).final_state
    plate, other, carton = (Constant(name) for name in ("plate_1", "plate_2", "carton_1"))
    assert DOMAIN.holds(Atom("carried_by", (other, plate)), state)
    assert DOMAIN.holds(Atom("carried_by", (other, carton)), state)
    assert DOMAIN.holds(Atom("inside", (other, carton)), state)
    assert not DOMAIN.holds(Atom("directly_inside", (other, carton)), state)
    assert DOMAIN.holds(Atom("floor_below", (other, Constant("room_floor_garage_0"))), state)
    assert not DOMAIN.holds(Atom("shut_in", (other,)), state)
    closed = execute_plan(DOMAIN, state, parse_actions(initial, "CLOSE carton_1")).final_state
    assert DOMAIN.holds(Atom("shut_in", (other,)), closed)


def test_a_cycle_of_supports_does_not_loop_forever() -> None:
    """No action creates a cycle, but a wrongly perceived scene may have one."""
    scene = make_task().initial.scene
    circle = [("lies_in", "carton_1", "saucepan_1"), ("lies_on", "saucepan_1", "carton_1")]
    beside = [("lies_on", "plate_1", "carton_1"), ("lies_in", "plate_2", "plate_1")]
    itself = [("lies_in", "rag_1", "rag_1"), ("lies_on", "rag_10", "rag_10")]
    facts = [(name, (scene.index[x], scene.index[y])) for name, x, y in (*circle, *beside, *itself)]
    state = scene.state(facts)
    indices = range(len(scene.objects))
    for predicate in VOCABULARY.derived:
        for arguments in product([_name(state, index) for index in indices], repeat=predicate.arity):
            DOMAIN.holds(Atom(predicate.name, arguments), state)
    assert DOMAIN.holds(Atom("carried_by", (Constant("plate_2"), Constant("saucepan_1"))), state)
    assert not DOMAIN.holds(
        Atom("floor_below", (Constant("plate_2"), Constant("room_floor_garage_0"))), state
    )
    past = History(state)
    for operator in DOMAIN.operators:
        for arguments in product(indices, repeat=operator.arity):
            attempt_action(DOMAIN, past, Action(operator.name, arguments))
