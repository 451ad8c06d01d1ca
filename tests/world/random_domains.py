"""Hypothesis strategies for small declared domains, and for states and plans in them."""

from __future__ import annotations

from dataclasses import dataclass

from hypothesis import strategies as st

from eai.logic.formula import Variable
from eai.world import (
    Action,
    Add,
    Check,
    Delete,
    Domain,
    Effect,
    FaultKind,
    ForEach,
    Operator,
    Predicate,
    Scene,
    State,
    Vocabulary,
    When,
    WorldObject,
    find_when_action_was_possible,
    find_when_conditions_held,
)
from pddl.random_pddl import OBJECTS, PREDICATES, atoms, formulas

VOCABULARY = Vocabulary(tuple(Predicate(name, arity) for name, arity in PREDICATES.items()))
FAULTS = (FaultKind.AFFORDANCE, FaultKind.ADDITIONAL_STEP, FaultKind.MISSING_STEP)


@dataclass(frozen=True)
class Case:
    """A domain with an initial state and a plan."""

    domain: Domain
    initial: State
    plan: tuple[Action, ...]


def effects(scope: tuple[str, ...]) -> st.SearchStrategy[Effect]:
    leaf: st.SearchStrategy[Effect] = atoms(scope).map(Add) | atoms(scope).map(Delete)
    each = Variable("each")
    return st.one_of(
        leaf,
        st.builds(When, atoms(scope), leaf.map(lambda effect: (effect,))),
        st.builds(
            ForEach,
            st.just(each),
            atoms((*scope, each.name)),
            atoms((*scope, each.name)).map(lambda atom: (Add(atom),)),
        ),
    )


def operators(name: str, arity: int) -> st.SearchStrategy[Operator]:
    scope = ("x", "y")[:arity]
    check = st.builds(Check, formulas(scope, 1), st.sampled_from(FAULTS), st.just("no"))
    return st.builds(
        Operator,
        st.just(name),
        st.just(tuple(Variable(each) for each in scope)),
        st.lists(check, max_size=2).map(tuple),
        st.lists(effects(scope), max_size=2).map(tuple),
    )


DECLARED = st.tuples(operators("a0", 0), operators("a1", 1), operators("a2", 2))


@st.composite
def cases(draw: st.DrawFn) -> Case:
    declared = draw(DECLARED)
    rule = draw(st.sampled_from((find_when_conditions_held, find_when_action_was_possible)))
    domain = Domain("random", VOCABULARY, declared, rule)
    scene = Scene(VOCABULARY, [WorldObject(o.name, o.type) for o in OBJECTS])
    index = st.integers(0, len(OBJECTS) - 1)
    fact = st.sampled_from(list(PREDICATES.items())).flatmap(
        lambda p: st.tuples(st.just(p[0]), st.tuples(*[index] * p[1]))
    )
    action = st.sampled_from(declared).flatmap(
        lambda o: st.builds(Action, st.just(o.name), st.tuples(*[index] * o.arity))
    )
    initial = scene.state(draw(st.lists(fact, max_size=8)))
    return Case(domain, initial, tuple(draw(st.lists(action, max_size=12))))
