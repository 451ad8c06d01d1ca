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
