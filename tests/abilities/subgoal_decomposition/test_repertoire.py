"""What the operators of a domain are for: which may bring something about, and which help them."""

from __future__ import annotations

import pytest

import eai.world as w
from eai.abilities.subgoal_decomposition.repertoire import Repertoire
from eai.planning.subgoal import GroundAtom
from eai.world.execution import Action
from world import toy

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
def test_what_changes_nothing_that_is_asked_for_helps_nobody(name: str, helping: list[str]) -> None:
    serving = Repertoire(toy.DOMAIN).serving(frozenset({name}))
    assert [operator.name for operator in serving.helping] == helping
    assert serving.movement == ["GO"]


def test_what_an_action_does_with_the_agent_it_does_with_nothing_else() -> None:
    repertoire = Repertoire(DRESS)
    assert repertoire.wanted([GroundAtom("worn", (0, 1), True)], WARDROBE) == {Action("WEAR", (1,)): 1}
    assert repertoire.wanted([GroundAtom("worn", (2, 1), True)], WARDROBE) == {}


PUSH = w.Operator(
    "PUSH", (toy.X, toy.Y), (), (w.Delete(toy.at(toy.X, w.ANYTHING)), w.Add(toy.at(toy.X, toy.Y)))
)
CLIMB = w.Operator(
    "CLIMB",
    (toy.X,),
    (),
    (w.Delete(toy.at(w.AGENT, w.ANYTHING)), w.Add(toy.at(w.AGENT, toy.X)), w.Add(toy.lit(toy.X))),
    role=w.Role.CHANGE,
)


@pytest.mark.parametrize(
    ("predicate", "names", "expected"),
    [
        ("at", ("robot", "shed"), ["GO shed"]),  # where it is, movement alone decides
        ("at", ("red", "shed"), ["GO shed", "PUSH red shed"]),  # what is carried goes along
        ("lit", ("shed",), ["PRESS shed", "CLIMB shed"]),
    ],
)
def test_what_may_bring_a_literal_about(predicate: str, names: tuple[str, ...], expected: list[str]) -> None:
    repertoire, scene = Repertoire(toy.DOMAIN.with_operators(PUSH, CLIMB)), toy.initial().scene
    literal = GroundAtom(predicate, tuple([scene.index[name] for name in names]), True)
    wanted = repertoire.wanted([literal], scene)
    found = [" ".join([a.operator, *(scene.objects[i].name for i in a.arguments)]) for a in wanted]
    assert found == expected
    assert set(wanted.values()) == {1}
