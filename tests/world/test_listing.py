from __future__ import annotations

from itertools import product

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from eai.base.errors import DomainError
from eai.logic.formula import Atom, Variable
from eai.world import (
    ComputedPredicate,
    DefinedPredicate,
    Domain,
    Exists,
    LookupPredicate,
    Predicate,
    Scene,
    State,
    Vocabulary,
    WorldObject,
)
from eai.world.listing import make_fact_lister
from eai.world.state import Fact

X, Y, Z = Variable("x"), Variable("y"), Variable("z")
ringing, lit, near = Predicate("ringing", 0), Predicate("lit", 1), Predicate("near", 2)
between = Predicate("between", 3)
VOCABULARY = Vocabulary(
    (ringing, lit, near, between),
    (
        DefinedPredicate("alone", (X,), ~Exists(Y, near(X, Y))),
        DefinedPredicate("linked", (X, Y), Exists(Z, near(X, Z) & near(Z, Y))),
        DefinedPredicate("chain", (X, Y, Z), near(X, Y) & near(Y, Z)),
        LookupPredicate("around", 2, lambda state, known: state.relation("near").column(known[0]), ("near",)),
        ComputedPredicate("dark", 0, lambda state, known: not state.mask("lit"), ("lit",)),
    ),
)
PREDICATES = ("ringing", "lit", "near", "alone", "linked", "chain", "around", "dark", "between")
SCENE = Scene(VOCABULARY, [WorldObject(f"o{i}", "object") for i in range(5)])
indices = st.integers(0, 4)


@st.composite
def states(draw: st.DrawFn) -> State:
    pairs = draw(st.lists(st.tuples(indices, indices)))
    facts = [("near", pair) for pair in pairs] + [("lit", (i,)) for i in draw(st.lists(indices))]
    facts += [("between", each) for each in draw(st.lists(st.tuples(indices, indices, indices)))]
    return SCENE.state([*facts, *[("ringing", ())] * draw(st.booleans())])


@settings(deadline=None)
@given(
    states(),
    st.lists(indices, unique=True),
    st.sampled_from(PREDICATES),
    st.booleans(),
    st.none() | st.lists(indices),
)
@example(SCENE.state([("between", (0, 1, 2)), ("between", (1, 2, 3))]), [0, 1, 2, 3], "between", False, [3])
def test_all_facts_about_objects_are_listed_in_the_order_of_the_objects(
    state: State, objects: list[int], predicate: str, repeated: bool, about: list[int] | None
) -> None:
    domain, arity = Domain("listed", VOCABULARY, ()), VOCABULARY.find_arity(predicate) or 0
    names = ("x", "y", "z")[:arity]
    atom = Atom(predicate, tuple(Variable(name) for name in names))
    holding = [
        Fact(predicate, arguments)
        for arguments in product(objects, repeat=arity)
        if repeated or len({*arguments}) == arity
        if about is None or not {*about}.isdisjoint(arguments)
        if domain.holds(atom, state, dict(zip(names, arguments, strict=True)))
    ]
    assert (
        make_fact_lister(VOCABULARY, predicate, allow_equal_arguments=repeated).list_facts(
            state, objects, about
        )
        == holding
    )


@pytest.mark.parametrize(
    ("predicate", "sources"),
    [("lit", ("lit",)), ("linked", ("near",)), ("around", ("near",)), ("dark", ("lit",))],
)
def test_a_listing_names_the_stored_predicates_that_decide_it(
    predicate: str, sources: tuple[str, ...]
) -> None:
    assert make_fact_lister(VOCABULARY, predicate).sources == sources


def test_listing_an_undeclared_predicate_is_an_error() -> None:
    with pytest.raises(DomainError, match="predicate cold is not declared"):
        make_fact_lister(VOCABULARY, "cold")
