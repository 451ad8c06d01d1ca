from __future__ import annotations

from itertools import product

import pytest
from hypothesis import given
from hypothesis import strategies as st

from eai.base.errors import DomainError
from eai.logic.formula import (
    TRUE,
    And,
    Atom,
    Constant,
    Equals,
    Eventually,
    Exactly,
    Exists,
    ForAll,
    Formula,
    ForPairs,
    Implies,
    Not,
    Or,
    Variable,
)
from eai.logic.traversal import find_free_variables
from eai.world import condition
from eai.world.condition import ConditionCompiler, FormulaEvaluator
from eai.world.derived import ComputedPredicate, LookupPredicate
from eai.world.domain import Domain
from eai.world.frame import AGENT, SlotAllocator
from eai.world.state import Fact, Scene, State, WorldObject
from eai.world.vocabulary import Vocabulary
from world import plain_sets, toy

X = Variable("x")
Y = Variable("y")
VARIABLES = [Variable(name) for name in "abc"]
terms = st.sampled_from([*VARIABLES, AGENT, Constant("lamp")])
atoms = st.one_of(
    st.builds(lambda s, t: toy.at(s, t), terms, terms),
    st.builds(lambda t: toy.holding(t), terms),
    st.builds(lambda t: toy.beside(t), terms),
    st.builds(Equals, terms, terms),
)
bound_variables = st.builds(
    Variable, st.sampled_from("abc"), st.sampled_from([None, "box", "place", "nothing"])
)


def compound(inner: st.SearchStrategy[Formula]) -> st.SearchStrategy[Formula]:
    several = st.lists(inner, max_size=3).map(tuple)
    return st.one_of(
        st.builds(Not, inner),
        st.builds(And, several),
        st.builds(Or, several),
        st.builds(Implies, inner, inner),
        st.builds(Exists, bound_variables, inner),
        st.builds(ForAll, bound_variables, inner),
        st.builds(Exactly, st.integers(0, 3), bound_variables, inner),
    )


formulas = st.recursive(atoms, compound, max_leaves=8)
facts = st.frozensets(
    st.one_of(
        st.builds(lambda x, y: Fact("at", (x, y)), st.integers(0, 5), st.integers(0, 5)),
        st.builds(lambda x: Fact("holding", (x,)), st.integers(0, 5)),
    ),
    max_size=12,
)


@given(formulas, facts, st.tuples(*[st.integers(0, 5)] * 3))
def test_compiled_conditions_agree_with_the_naive_evaluation(
    formula: Formula, chosen: frozenset[Fact], values: tuple[int, int, int]
) -> None:
    state = toy.initial().scene.state(chosen)
    bound = dict(zip("abc", values, strict=True))
    assert toy.DOMAIN.holds(formula, state, bound) == plain_sets.holds(state, chosen, formula, bound)


@pytest.mark.parametrize(
    ("pairs", "count", "expected"),
    [
        ([("red", "hall"), ("blue", "shed")], None, True),
        ([("red", "hall"), ("blue", "hall")], None, False),
        ([("red", "hall"), ("blue", "hall")], 1, True),
        ([("red", "hall"), ("red", "shed")], None, False),
        ([], 0, True),
    ],
)
def test_for_pairs_holds_if_a_pairing_exists(
    pairs: list[tuple[str, str]], count: int | None, expected: bool
) -> None:
    scene = toy.initial().scene
    state = scene.state(("at", (scene.index[x], scene.index[y])) for x, y in pairs)
    box, place = Variable("b", "box"), Variable("p", "place")
    formula = ForPairs(box, place, toy.at(Variable("b"), Variable("p")), count)
    assert toy.DOMAIN.holds(formula, state) is expected


@pytest.mark.parametrize(
    ("formula", "message"),
    [
        (Atom("unknown", ()), "predicate unknown is not declared"),
        (Atom("at", (AGENT,)), "at takes 2 arguments, not 1"),
        (Atom("holding", (Variable("z"),)), "variable z is not bound"),
        (Eventually(toy.holding(AGENT)), "Eventually is not a condition on one state"),
    ],
)
def test_compiling_a_wrong_condition_is_a_domain_error(formula: Formula, message: str) -> None:
    with pytest.raises(DomainError, match=message):
        toy.DOMAIN.holds(formula, toy.initial())


def test_quantifiers_have_their_usual_truth_on_an_empty_scene() -> None:
    state = Scene(toy.VOCABULARY, ()).state(())
    x = Variable("x")
    assert toy.DOMAIN.holds(ForAll(x, toy.holding(x)), state)
    assert not toy.DOMAIN.holds(Exists(x, toy.holding(x)), state)


def test_a_scene_lists_its_categories() -> None:
    scene = Scene(toy.VOCABULARY, (WorldObject("red", "box"), WorldObject("blue", "box")))
    assert scene.names(scene.get_category_mask("box")) == ("red", "blue")
    assert scene.get_category_mask("lamp") == 0


@pytest.mark.parametrize(
    ("formula", "expected"),
    [
        (And((toy.holding(X), Atom("looked_at", (X,)))), ["red"]),
        (Or((toy.holding(X), Atom("looked_at", (X,)))), ["robot", "hall", "shed", "blue", "lamp"]),
        (And((toy.holding(X), Not(Implies(toy.at(X, X), TRUE)), Atom("looked_at", (X,)))), []),
        (And((toy.holding(X), Exists(Variable("y", "box"), Atom("looked_at", (X,))))), ["red"]),
        (Exists(Y, And((toy.holding(Y), Atom("looked_at", (Y,)), toy.at(X, Y)))), ["red"]),
    ],
)
def test_only_objects_that_the_rest_of_a_formula_allows_are_tried(
    formula: Formula, expected: list[str]
) -> None:
    looked_at: list[str] = []

    def look(state: State, arguments: tuple[int, ...]) -> bool:
        looked_at.append(scene.objects[arguments[0]].name)
        return False

    vocabulary = Vocabulary(toy.VOCABULARY.predicates, (ComputedPredicate("looked_at", 1, look, ()),))
    scene = Scene(vocabulary, toy.initial().scene.objects)
    state = scene.state((Fact("holding", (scene.index["red"],)),))
    Domain("looking", vocabulary, ()).holds(Exists(X, formula), state)
    assert looked_at == expected


def test_a_lookup_may_depend_on_any_number_of_objects() -> None:
    """The last argument is looked up from no, one or two other arguments."""
    lookups = (
        LookupPredicate("first", 1, lambda state, known: 0b001, ()),
        LookupPredicate("next", 2, lambda state, known: 0b010 << known[0], ()),
        LookupPredicate("sum", 3, lambda state, known: 1 << known[0] + known[1], ()),
    )
    vocabulary = Vocabulary((), lookups)
    scene = Scene(vocabulary, [WorldObject(f"o{i}", "object") for i in range(3)])
    found = {
        name: {
            arguments
            for arguments in product(range(3), repeat=arity)
            if _holds(Atom(name, tuple(Constant(f"o{i}") for i in arguments)), vocabulary, scene)
        }
        for name, arity in (("first", 1), ("next", 2), ("sum", 3))
    }
    assert found == {
        "first": {(0,)},
        "next": {(0, 1), (1, 2)},
        "sum": {(i, j, i + j) for i in range(3) for j in range(3 - i)},
    }


def _holds(formula: Formula, vocabulary: Vocabulary, scene: Scene) -> bool:
    frame = SlotAllocator()
    return ConditionCompiler(vocabulary, frame).compile_test(formula)(
        scene.state(()), frame.bind_arguments(scene, ())
    )


def test_formulas_are_evaluated_with_their_free_variables() -> None:
    formula = toy.beside(X) & ~Exists(Y, toy.at(Y, X) & toy.lit(Y))
    assert find_free_variables(formula) == frozenset("x")
    readings = FormulaEvaluator(toy.VOCABULARY)
    start = toy.initial()
    index = start.scene.index
    red, shed = index["red"], index["shed"]
    assert readings.holds(formula, {"x": red}, start)
    assert not readings.holds(formula, {"x": index["lamp"]}, start)
    body = toy.at(Y, X)
    assert list(readings.find_witnesses(Variable("y"), body, {"x": shed}, start)) == [
        index["blue"],
        index["lamp"],
    ]
    assert list(readings.find_witnesses(Variable("y", "box"), body, {"x": shed}, start)) == [index["blue"]]


def test_an_evaluator_caches_a_limited_number_of_formulas(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(condition, "_MAX_CACHED_FORMULAS", 5)
    evaluator, start = FormulaEvaluator(toy.VOCABULARY), toy.initial()
    index = start.scene.index
    for name in ["red", "lamp"] * 10:  # each formula is a new object, perhaps with the id of an earlier one
        formula, held_at = toy.at(X, Constant(name)), toy.at(Y, X)
        assert not evaluator.holds(formula, {"x": index[name]}, start)
        place = index["hall" if name == "red" else "shed"]
        assert index[name] in evaluator.find_witnesses(Y, held_at, {"x": place}, start)
        assert max(len(evaluator._truths), len(evaluator._filters)) <= 5
    assert evaluator._truths
    assert evaluator._filters
