from __future__ import annotations

from dataclasses import replace

import pytest

from eai.abilities.subgoal_decomposition import program_builder
from eai.abilities.subgoal_decomposition.program_builder import MAX_LITERALS, _QuantifierRange
from eai.base.errors import InputError
from eai.logic.formula import Formula
from eai.logic.ltl import parse
from eai.tasks.task import Task
from world import toy

START = toy.initial()
OBJECTS = len(START.scene.objects)
PLACES = START.scene.get_category_mask("place").bit_count()
TASK = Task("1", "Toy", "Tidy up.", START, (), (1, 2, 3))
EXTENT = _QuantifierRange(TASK)
QUANTIFIERS = (
    "forall {0}. ({2})",
    "exists {0}. ({2})",
    "forn 2. {0}. ({2})",
    "forpairs {0}, {1}. ({2})",
    "fornpairs 2. {0}, {1}. ({2})",
)


def formula(text: str) -> Formula:
    return parse(text)


@pytest.mark.parametrize(
    ("text", "literals", "count_alternative_literals"),
    [
        ("lit(lamp)", 1, 1),
        ("lit(lamp) and not at(red, shed)", 2, 2),
        ("lit(lamp) or at(red, shed)", 2, 2),
        ("(lit(lamp) or lit(red)) and (lit(blue) or lit(box))", 4, 4 * 2),
        ("exists x. (lit(x) and at(x, shed))", 2 * OBJECTS, 3 * 2),
        ("exists x. (lit(x)) and exists y. (at(y, shed))", 2 * OBJECTS, 3 * 3 * 2),
        ("forall x. (lit(x))", OBJECTS, OBJECTS),
        ("forall x. (forall y. (at(x, y)))", OBJECTS**2, OBJECTS**2),
        ("forall x:place. (lit(x) or lit(lamp))", 2 * PLACES, 2**PLACES * PLACES),
    ],
)
def test_the_literals_of_a_formula_are_counted(
    text: str, literals: int, count_alternative_literals: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert EXTENT.count_literals(formula(text)) == literals
    largest = max(literals, count_alternative_literals)
    monkeypatch.setattr(program_builder, "MAX_LITERALS", largest)
    EXTENT.require_dnf_within_literal_limit(formula(text))
    monkeypatch.setattr(program_builder, "MAX_LITERALS", largest - 1)
    with pytest.raises(InputError):
        EXTENT.require_dnf_within_literal_limit(formula(text))


@pytest.mark.parametrize("quantifier", ["forall", "exists"])
def test_a_subgoal_with_too_many_literals_is_rejected_at_once(quantifier: str) -> None:
    names = [f"x{i}" for i in range(12)]
    text = " ".join(f"{quantifier} {name}. (" for name in names) + "at(x0, x11)" + ")" * 12
    assert OBJECTS**12 > MAX_LITERALS
    with pytest.raises(InputError, match="more than 100,000 literals"):
        EXTENT.count_literals(formula(text))
    with pytest.raises(InputError, match="more than 100,000 literals"):
        EXTENT.require_dnf_within_literal_limit(formula(text))


@pytest.mark.parametrize("outer", QUANTIFIERS)
@pytest.mark.parametrize("inner", QUANTIFIERS)
def test_every_quantifier_in_every_other_is_multiplied(outer: str, inner: str) -> None:
    text = outer.format("a", "b", inner.format("c", "d", "not (lit(a) implies lit(c))"))
    variables = text.count("pairs") + text.count(". (")
    assert EXTENT.count_literals(formula(text)) == 2 * OBJECTS**variables
    assert EXTENT.count_literals(formula(f"not ({text}) or {text}")) == 4 * OBJECTS**variables
    deep = text
    for _ in range(5):
        deep = outer.format("a", "b", deep)
    with pytest.raises(InputError, match="more than 100,000 literals"):
        EXTENT.count_literals(formula(deep))


@pytest.mark.parametrize("quantifier", QUANTIFIERS)
def test_a_category_bounds_what_any_quantifier_ranges_over(quantifier: str) -> None:
    text = quantifier.format("a: place", "b: place", "lit(a)")
    assert EXTENT.count_literals(formula(text)) == PLACES ** (2 if "pairs" in text else 1)


@pytest.mark.parametrize("inner", QUANTIFIERS)
def test_a_quantifier_over_an_empty_class_counts_as_one(inner: str) -> None:
    """If an empty class made the count 0, such a subgoal would run for minutes."""
    nothing = inner.format("c: unicorn", "d: unicorn", "lit(c)")
    assert EXTENT.count_literals(formula(nothing)) == 1
    assert EXTENT.count_literals(formula(f"forall a. (forpairs b, e. ({nothing}))")) == OBJECTS**3
    assert EXTENT.count_literals(formula("forpairs a, b: unicorn. (lit(a))")) == OBJECTS


def test_alternatives_without_literals_are_counted() -> None:
    """Each pair of objects has three alternatives without literals. They must not be expanded one by one."""
    nothing = "exists b. (forall c: unicorn. (at(b, c)))"
    EXTENT.require_dnf_within_literal_limit(formula(nothing))
    with pytest.raises(InputError, match="more than 100,000 literals"):
        EXTENT.require_dnf_within_literal_limit(formula(f"forall a. (forall e. ({nothing}))"))


def test_an_exists_tries_the_objects_of_the_task() -> None:
    variable = next(iter([formula("exists x. (lit(x))")])).variable  # type: ignore[attr-defined]
    assert EXTENT.list_relevant_objects(variable) == [1, 2, 3]
    assert EXTENT.list_values_of_variable(variable) == tuple(range(OBJECTS))
    assert _QuantifierRange(replace(TASK, relevant=())).list_relevant_objects(variable) == tuple(
        range(OBJECTS)
    )
