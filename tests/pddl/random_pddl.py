"""Hypothesis strategies for small domains, operators and problems."""

from __future__ import annotations

from hypothesis import strategies as st

from eai.logic.formula import (
    And,
    Atom,
    Constant,
    Equals,
    Exists,
    ForAll,
    Formula,
    Implies,
    Not,
    Or,
    Term,
    Variable,
)
from eai.pddl.model import (
    Add,
    AndEffect,
    Delete,
    ForAllEffect,
    PddlAction,
    PddlDomain,
    PddlEffect,
    PddlPredicate,
    PddlProblem,
    TypedName,
    WhenEffect,
)

PREDICATES = {"p": 1, "q": 2, "r": 0, "t": 3}
OBJECTS = (TypedName("a", "thing"), TypedName("b", "thing"), TypedName("c"))
TYPES = (TypedName("thing"),)
CATEGORIES = st.sampled_from([None, "thing"])


def atoms(scope: tuple[str, ...], *, constants: bool = True) -> st.SearchStrategy[Atom]:
    names = [Variable(name) for name in scope] + ([Constant(o.name) for o in OBJECTS] if constants else [])
    term: st.SearchStrategy[Term] = st.sampled_from(names) if names else st.nothing()
    usable = [name for name, arity in PREDICATES.items() if names or not arity]
    return st.sampled_from(usable).flatmap(
        lambda name: st.tuples(*[term] * PREDICATES[name]).map(lambda arguments: Atom(name, arguments))
    )


def formulas(scope: tuple[str, ...], depth: int = 3) -> st.SearchStrategy[Formula]:
    leaf: st.SearchStrategy[Formula] = atoms(scope)
    if scope:
        variables = st.sampled_from([Variable(name) for name in scope])
        leaf = leaf | st.builds(Equals, variables, variables)
    if not depth:
        return leaf
    part = formulas(scope, depth - 1)
    parts = st.lists(part, max_size=3).map(tuple)
    name = f"v{depth}"
    bound = formulas((*scope, name), depth - 1)
    variable = CATEGORIES.map(lambda category: Variable(name, category))
    return st.one_of(
        leaf,
        part.map(Not),
        parts.map(And),
        parts.map(Or),
        st.builds(Implies, part, part),
        st.builds(ForAll, variable, bound),
        st.builds(Exists, variable, bound),
    )


def effects(scope: tuple[str, ...], depth: int = 2) -> st.SearchStrategy[PddlEffect]:
    leaf: st.SearchStrategy[PddlEffect] = atoms(scope).map(Add) | atoms(scope).map(Delete)
    if not depth:
        return leaf
    part = effects(scope, depth - 1)
    name = f"e{depth}"
    variable = CATEGORIES.map(lambda category: Variable(name, category))
    return st.one_of(
        leaf,
        st.lists(part, max_size=3).map(tuple).map(AndEffect),
        st.builds(ForAllEffect, variable, effects((*scope, name), depth - 1)),
        st.builds(WhenEffect, formulas(scope, 1), part),
    )


def actions(name: str) -> st.SearchStrategy[PddlAction]:
    scope = ("x", "y")
    parameters = st.tuples(*(CATEGORIES.map(lambda c, n=n: Variable(n, c)) for n in scope))
    return st.builds(PddlAction, st.just(name), parameters, formulas(scope, 2), effects(scope))


DOMAINS = st.lists(st.sampled_from(["act", "move", "use"]), unique=True, max_size=3).flatmap(
    lambda names: st.tuples(*map(actions, names)).map(
        lambda found: PddlDomain(
            name="made-up",
            requirements=(":adl",),
            types=TYPES,
            constants=OBJECTS,
            predicates=tuple(
                PddlPredicate(name, tuple(Variable(f"x{i}") for i in range(arity)))
                for name, arity in PREDICATES.items()
            ),
            actions=found,
        )
    )
)
PROBLEMS = st.builds(
    PddlProblem,
    name=st.just("made-up-problem"),
    domain=st.just("made-up"),
    objects=st.just(()),
    initial=st.lists(atoms(()), unique=True, max_size=6).map(tuple),
    denied=st.just(()),
    goal=formulas((), 2),
)
