from __future__ import annotations

from dataclasses import replace

import pytest

from eai.abilities.subgoal_decomposition.extent import MAX_LITERALS, Extent
from eai.abilities.task import Task
from eai.errors import InputError
from eai.logic.formula import Formula
from eai.logic.ltl import parse
from world import toy

START = toy.initial()
OBJECTS = len(START.scene.objects)
TASK = Task("1", "Toy", "Tidy up.", START, (), (1, 2, 3))
EXTENT = Extent(TASK)


def formula(text: str) -> Formula:
    return parse(text).formula


@pytest.mark.parametrize(
    ("text", "literals", "to_be_done"),
    [
        ("lit(lamp)", 1, 1),
        ("lit(lamp) and not at(red, shed)", 2, 2),
        ("lit(lamp) or at(red, shed)", 2, 2),
        ("(lit(lamp) or lit(red)) and (lit(blue) or lit(box))", 4, 4 * 2),
        ("exists x. (lit(x) and at(x, shed))", 2 * OBJECTS, 3 * 2),
        ("forall x. (lit(x))", OBJECTS, OBJECTS),
        ("forall x. (forall y. (at(x, y)))", OBJECTS**2, OBJECTS**2),
        ("forall x:place. (lit(x) or lit(lamp))", None, None),
    ],
)
def test_what_a_formula_comes_down_to(text: str, literals: int | None, to_be_done: int | None) -> None:
    places = START.scene.category("place").bit_count()
    assert EXTENT.literals(formula(text)) == (2 * places if literals is None else literals)
    assert EXTENT.to_be_done(formula(text)) == (2**places * places if to_be_done is None else to_be_done)


@pytest.mark.parametrize("quantifier", ["forall", "exists"])
def test_what_asks_for_too_much_is_refused_at_once(quantifier: str) -> None:
    names = [f"x{i}" for i in range(12)]
    text = " ".join(f"{quantifier} {name}. (" for name in names) + "at(x0, x11)" + ")" * 12
    assert OBJECTS**12 > MAX_LITERALS
    with pytest.raises(InputError, match="too many alternatives"):
        EXTENT.literals(formula(text))
    with pytest.raises(InputError, match="too many alternatives"):
        EXTENT.to_be_done(formula(text))


def test_an_exists_tries_the_objects_of_the_task() -> None:
    variable = next(iter([formula("exists x. (lit(x))")])).variable  # type: ignore[attr-defined]
    assert EXTENT.usable(variable) == [1, 2, 3]
    assert EXTENT.everything(variable) == tuple(range(OBJECTS))
    assert Extent(replace(TASK, relevant=())).usable(variable) == tuple(range(OBJECTS))
