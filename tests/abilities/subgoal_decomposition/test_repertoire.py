"""The uses of a domain's operators: achievers of a literal, and operators that support them."""

from __future__ import annotations

import pytest

import eai.world as w
from eai.abilities.subgoal_decomposition.repertoire import (
    CandidateAction,
    OperatorIndex,
    is_action_needless,
    select_actions_of_operators,
)
from eai.planning.subgoal import GroundAtom
from eai.world.action import Action
from eai.world.execution import execute_plan
from eai.world.state import State
from world import toy
from world.test_execution import plan

X = w.Variable("x")
WORN = w.Predicate("worn", 2)
WEAR = w.Operator("WEAR", (X,), (), (w.Add(WORN(w.AGENT, X)),))
DRESS = w.Domain("dress", w.Vocabulary((WORN,)), (WEAR,))
WARDROBE = w.Scene(
    DRESS.vocabulary, [w.WorldObject(name, name) for name in ("robot", "hat", "coat")], agent=0
)


@pytest.mark.parametrize(
    ("name", "helping"), [("PRESS", []), ("LIFT", ["LIFT", "DROP"]), ("DROP", ["LIFT", "DROP"])]
)
def test_operators_that_change_no_needed_condition_are_no_help(name: str, helping: list[str]) -> None:
    found, movement = OperatorIndex(toy.DOMAIN).find_enabling_hand_and_movement_operators(frozenset({name}))
    assert [operator.name for operator in found] == helping
    assert movement == ["GO"]


def test_an_action_on_the_agent_takes_no_other_object_instead() -> None:
    repertoire = OperatorIndex(DRESS)
    assert repertoire.map_achieving_actions_to_literals([GroundAtom("worn", (0, 1), True)], WARDROBE) == {
        Action("WEAR", (1,)): 1
    }
    assert repertoire.map_achieving_actions_to_literals([GroundAtom("worn", (2, 1), True)], WARDROBE) == {}


PUSH = w.Operator(
    "PUSH", (toy.X, toy.Y), (), (w.Delete(toy.at(toy.X, w.ANYTHING)), w.Add(toy.at(toy.X, toy.Y)))
)
CLIMB = w.Operator(
    "CLIMB",
    (toy.X,),
    (),
    (w.Delete(toy.at(w.AGENT, w.ANYTHING)), w.Add(toy.at(w.AGENT, toy.X)), w.Add(toy.lit(toy.X))),
    role=w.OperatorRole.CHANGE,
)


@pytest.mark.parametrize(
    ("predicate", "names", "expected"),
    [
        ("at", ("robot", "shed"), ["GO shed"]),  # only movement changes the position
        ("at", ("red", "shed"), ["GO shed", "PUSH red shed"]),  # held objects move with the agent
        ("lit", ("shed",), ["PRESS shed", "CLIMB shed"]),
    ],
)
def test_the_actions_that_may_achieve_a_literal_are_listed(
    predicate: str, names: tuple[str, ...], expected: list[str]
) -> None:
    repertoire, scene = OperatorIndex(toy.DOMAIN.replace_operators(PUSH, CLIMB)), toy.initial().scene
    literal = GroundAtom(predicate, tuple([scene.index[name] for name in names]), True)
    wanted = repertoire.map_achieving_actions_to_literals([literal], scene)
    found = [" ".join([a.operator, *(scene.objects[i].name for i in a.arguments)]) for a in wanted]
    assert found == expected
    assert set(wanted.values()) == {1}


def test_open_arguments_of_a_literal_are_filled_with_fitting_objects() -> None:
    """Conditions that no action changes must hold. One object may fill two arguments."""
    link, lit = w.Predicate("link", 2, static=True), w.Predicate("lit", 1)
    y = w.Variable("y")
    switch = w.Operator("SWITCH", (X, y), (w.missing_step(link(X, y), "no link"),), (w.Add(lit(X)),))
    domain = w.Domain("net", w.Vocabulary((link, lit)), (switch,))
    repertoire = OperatorIndex(domain)
    scene = w.Scene(domain.vocabulary, [w.WorldObject(name, name) for name in "abc"])
    literal = GroundAtom("lit", (0,), True)
    state = scene.state(["link(a, a)", "link(a, c)", "link(b, c)"])
    assert repertoire.map_achieving_actions_to_literals([literal], scene, (0, 1, 2), state) == {
        Action("SWITCH", (0, 0)): 1,
        Action("SWITCH", (0, 2)): 1,
    }
    assert repertoire.map_achieving_actions_to_literals([literal], scene, (0, 1, 2)) == {
        Action("SWITCH", (0, 1)): 1,
        Action("SWITCH", (0, 2)): 1,
    }


REPERTOIRE = OperatorIndex(toy.DOMAIN)


def state_after(*steps: str) -> State:
    return execute_plan(toy.DOMAIN, toy.initial(), plan(*steps)).final_state


def ground(text: str, state: State) -> CandidateAction:
    (action,) = plan(text)
    return CandidateAction.create(action, REPERTOIRE.operators[action.operator], state)


@pytest.mark.parametrize(
    ("before", "action", "failing", "lacking", "hopeless"),
    [
        ([], "LIFT red", [], 0, False),
        ([], "PRESS lamp", [1], 0, False),  # only movement changes the position
        ([], "PRESS red", [0], 1, True),  # the class of an object never changes
        ([], "PRESS blue", [0, 1], 1, True),
        ([], "GO hall", [1], 0, False),
        ([], "DROP red", [0], 1, False),
        (["LIFT red"], "DROP red", [], 0, False),
        (["LIFT red"], "LIFT blue", [1, 2], 1, False),
        (["LIFT red"], "LIFT lamp", [0, 1, 2], 2, True),
        (["GO shed"], "PRESS lamp", [], 0, False),
    ],
)
def test_failing_checks_are_numbered_and_counted(
    before: list[str], action: str, failing: list[int], lacking: int, *, hopeless: bool
) -> None:
    state = state_after(*before)
    tried = ground(action, state)
    assert tried.find_indices_of_failing_checks(state) == failing
    assert tried.all_checks_hold(state) is (failing == [])
    assert tried.count_failing_checks_movement_cannot_fix(state) == lacking
    assert tried.needs_objects_of_other_kind(failing) is hopeless
    assert (tried.parts, tried.touched) == (0, 0), "it is for nothing yet"


@pytest.mark.parametrize(
    ("before", "action", "may_be"),
    [
        ([], "PRESS lamp", True),
        ([], "PRESS blue", True),  # the class is a fixed check, tested once a search
        (["LIFT red"], "LIFT blue", True),  # a free hand is a common check, tested once a state
        ([], "DROP red", False),
        ([], "GO hall", False),  # going to the present position is needless
    ],
)
def test_movement_can_establish_some_failing_checks(before: list[str], action: str, *, may_be: bool) -> None:
    state = state_after(*before)
    assert ground(action, state).can_movement_make_action_possible(state) is may_be


def test_a_failed_try_is_no_check_of_an_objects_kind() -> None:
    assert not ground("PRESS lamp", toy.initial()).needs_objects_of_other_kind([2])


@pytest.mark.parametrize(
    ("before", "action", "needless"),
    [([], "GO hall", True), ([], "GO shed", False), (["GO shed"], "GO shed", True), ([], "PRESS red", False)],
)
def test_an_action_is_needless_if_it_fails_as_additional_step(
    before: list[str], action: str, *, needless: bool
) -> None:
    state = state_after(*before)
    tried = ground(action, state)
    assert is_action_needless(tried.info.operator, tried.action, state) is needless


def test_distinguished_actions_keep_their_order() -> None:
    lift, go, drop, press = steps = plan("LIFT red", "GO shed", "DROP red", "PRESS lamp")
    assert select_actions_of_operators(steps, {"PRESS", "LIFT"}) == (lift, press)
    assert select_actions_of_operators(steps, {"GO", "DROP"}) == (go, drop)
    assert select_actions_of_operators(steps, ()) == ()
