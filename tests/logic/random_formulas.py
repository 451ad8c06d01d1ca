"""Random formulas and traces for property tests."""

from __future__ import annotations

from functools import cache

from hypothesis import strategies as st

from eai.logic.formula import (
    Always,
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
    Next,
    Not,
    Occurs,
    Or,
    Term,
    Then,
    Until,
    Variable,
)
from eai.logic.trace import TakenAction, Trace
from logic.naive import Facts

PREDICATES = {"open": 1, "next_to": 2, "notable": 1, "-raining": 0}
ACTIONS = {"grab": 1, "pour": 2, "sleep": 0}
OBJECTS = ("cup.1", "cup.2", "sofa", "true_north", "tüte")
VARIABLES = ("x", "y", "z0", "forall_x")
CATEGORIES = (None, "cup", "bottle.n.01", "sofa-bed")


@cache
def _terms(scope: tuple[str, ...]) -> st.SearchStrategy[Term]:
    names = st.sampled_from(OBJECTS).map(Constant)
    return st.one_of(names, st.sampled_from(scope).map(Variable)) if scope else names


@cache
def _leaves(scope: tuple[str, ...], equality: bool) -> st.SearchStrategy[Formula]:
    def primitive(kind: type[Atom] | type[Occurs], arities: dict[str, int]) -> st.SearchStrategy[Formula]:
        return st.sampled_from(sorted(arities)).flatmap(
            lambda name: st.tuples(*[_terms(scope)] * arities[name]).map(lambda terms: kind(name, terms))
        )

    leaves = [primitive(Atom, PREDICATES), primitive(Occurs, ACTIONS)]
    if equality:
        leaves.append(st.builds(Equals, _terms(scope), _terms(scope)))
    return st.one_of(leaves)


@cache
def formulas(
    depth: int = 3, scope: tuple[str, ...] = (), temporal: bool = True, beyond_paper: bool = True
) -> st.SearchStrategy[Formula]:
    """Return a strategy for closed formulas; ``beyond_paper`` adds the operators of the larger grammar."""
    leaves = _leaves(scope, equality=beyond_paper)
    if depth == 0:
        return leaves

    def sub(*bound: str) -> st.SearchStrategy[Formula]:
        return formulas(depth - 1, (*scope, *bound), temporal, beyond_paper)

    def quantified(name: str) -> st.SearchStrategy[Formula]:
        category = st.sampled_from(CATEGORIES) if beyond_paper else st.none()
        variable = category.map(lambda c: Variable(name, c))
        kinds: list[st.SearchStrategy[Formula]] = [
            st.builds(ForAll, variable, sub(name)),
            st.builds(Exists, variable, sub(name)),
            st.builds(Exactly, st.integers(0, 3), variable, sub(name)),
        ]
        if beyond_paper:
            other = st.sampled_from([v for v in VARIABLES if v != name])
            count = st.none() | st.integers(0, 3)
            kinds.append(
                other.flatmap(
                    lambda o: st.builds(ForPairs, variable, st.just(Variable(o, "cup")), sub(name, o), count)
                )
            )
        return st.one_of(kinds)

    several = st.lists(sub(), min_size=2, max_size=3).map(tuple)
    options = [
        leaves,
        sub().map(Not),
        several.map(And),
        several.map(Or),
        st.sampled_from(VARIABLES).flatmap(quantified),
    ]
    if temporal:
        options.append(several.map(Then))
    if beyond_paper:
        options += [st.sampled_from([And(()), Or(())]), st.builds(Implies, sub(), sub())]
    if temporal and beyond_paper:
        options += [sub().map(Next), sub().map(Eventually), sub().map(Always), st.builds(Until, sub(), sub())]
    return st.one_of(options)


SCENE = (("cup.1", "cup"), ("cup.2", "cup"), ("sofa", "bottle.n.01"))


@st.composite
def traces(draw: st.DrawFn) -> tuple[list[Facts], list[TakenAction]]:
    length = draw(st.integers(1, 5))

    def arguments(arity: int) -> st.SearchStrategy[tuple[str, ...]]:
        return st.tuples(*[st.sampled_from([name for name, _ in SCENE])] * arity)

    def ground(arities: dict[str, int]) -> st.SearchStrategy[tuple[str, tuple[str, ...]]]:
        return st.sampled_from(sorted(arities)).flatmap(
            lambda name: arguments(arities[name]).map(lambda given: (name, given))
        )

    states = [Facts(draw(st.frozensets(ground(PREDICATES), max_size=8)), SCENE) for _ in range(length)]
    actions = [draw(ground(ACTIONS)) for _ in range(length - 1)]
    return states, actions


def trace(*texts: str) -> Trace:
    """Return a trace from the names of true atoms and of actions in turn: ``trace("p q", "GRAB", "")``."""
    states = [Facts(frozenset((name, ()) for name in text.split()), SCENE) for text in texts[::2]]
    return Trace(states, [(text, ()) for text in texts[1::2]])
