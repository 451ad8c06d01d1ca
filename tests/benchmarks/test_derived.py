"""Computed derived predicates equal their formulas, in any state of every built-in domain."""

from __future__ import annotations

import random
from collections.abc import Iterator

import pytest

from benchmarks.behavior import kitchen
from benchmarks.virtualhome import household
from eai.benchmarks.behavior import domain as behavior
from eai.benchmarks.behavior_1k import predicates as predicates_1k
from eai.benchmarks.behavior_1k.operators import build_domain
from eai.benchmarks.virtualhome import domain as virtualhome
from eai.world.derived import (
    ComputedPredicate,
    DefinedPredicate,
    LookupPredicate,
    find_definition,
    replace_formula_by_faster_function,
)
from eai.world.domain import Domain
from eai.world.state import Fact, Scene, State
from eai.world.vocabulary import DerivedPredicate

SEATS = ("sofa.90", "bed.91", "bench.92")
OBJECTS = ("floor", "oven", "pan", "bowl", "plate", "apple", "water")
DOMAINS = {
    "behavior": (behavior.make_domain_with_checks_in_paper_order(), kitchen.make_task().initial.scene),
    "behavior-1k": (build_domain(), Scene(predicates_1k.VOCABULARY, {name: name for name in OBJECTS})),
    "virtualhome": (
        virtualhome.make_domain_with_checks_in_paper_order(),
        household.make_task(more_objects=SEATS).initial.scene,
    ),
}
COMPUTED = [
    pytest.param(domain, scene, derived, id=f"{name} {derived.name}")
    for name, (domain, scene) in DOMAINS.items()
    for derived in domain.vocabulary.derived
    if isinstance(replace_formula_by_faster_function(derived), ComputedPredicate | LookupPredicate)
]
SUPPORTS = {"lies_in", "lies_on", *predicates_1k.SUPPORTS}
"""Relations under which no action gives an object two supports, or a cycle of supports."""


@pytest.mark.parametrize(("domain", "scene", "derived"), COMPUTED)
def test_a_computed_predicate_equals_its_formula(
    domain: Domain, scene: Scene, derived: DerivedPredicate
) -> None:
    formula = find_definition(derived)
    assert formula is not None, "every computed predicate has a formula"
    held = 0
    for state in make_states(scene):
        for arguments in list_tuples(scene, derived.arity):
            names = [parameter.name for parameter in formula.parameters]
            by_formula = domain.holds(formula.definition, state, dict(zip(names, arguments, strict=True)))
            assert by_formula is compute(derived, state, arguments), (arguments, list(state.facts()))
            held += by_formula
    assert held, "the predicate must hold in some state"


def compute(derived: DerivedPredicate, state: State, arguments: tuple[int, ...]) -> bool:
    """Return the value of a derived predicate by its function."""
    match replace_formula_by_faster_function(derived):
        case ComputedPredicate(test=test):
            return test(state, arguments)
        case LookupPredicate(values=values, inverse=inverse):
            holds = bool(values(state, arguments[:-1]) >> arguments[-1] & 1)
            if inverse is not None:
                assert bool(inverse(state, arguments[1:]) >> arguments[0] & 1) is holds, (
                    "the inverse must agree with the function"
                )
            return holds
        case _:
            raise AssertionError(derived.name)


def list_tuples(scene: Scene, arity: int) -> Iterator[tuple[int, ...]]:
    objects = range(len(scene.objects))
    yield from ((x,) for x in objects) if arity == 1 else ((x, y) for x in objects for y in objects)


def make_states(scene: Scene, number: int = 12) -> Iterator[State]:
    """Yield random states, from nearly empty to crowded; single-valued predicates stay single-valued."""
    for seed in range(number):
        chance = random.Random(seed)
        facts: list[Fact] = []
        resting: set[int] = set()
        for predicate in scene.vocabulary.predicates:
            pairs = list(list_tuples(scene, predicate.arity)) if predicate.arity else [()]
            share = chance.choice((0.2, 0.5, 0.8)) if predicate.arity == 1 else 1.5 / len(scene.objects)
            chosen = [pair for pair in pairs if chance.random() < share]
            if predicate.name in SUPPORTS:
                free = {x: y for x, y in chosen if x > y and x not in resting}
                resting |= free.keys()
                chosen = list(free.items())
            elif predicate.single:
                chosen = list({pair[:-1]: pair for pair in chosen}.values())
            facts += [Fact(predicate.name, pair) for pair in chosen]
        yield scene.state(facts)


def test_the_tested_predicates_include_the_main_ones() -> None:
    names = {case.id for case in COMPUTED}
    assert names >= {"behavior inside", "behavior floor_below", "virtualhome room_of", "virtualhome bed_full"}
    assert names >= {"behavior-1k inside", "behavior-1k floor_of"}


def test_a_sliced_object_without_halves_keeps_its_own_facts() -> None:
    domain, scene = DOMAINS["behavior"]
    plate, carton = (scene.index[name] for name in ("plate_1", "carton_1"))
    facts = [Fact("is_sliced", (plate,)), Fact("lies_in", (plate, carton)), Fact("is_dusty", (plate,))]
    state = scene.state(facts)
    held = {
        (derived.name, other)
        for derived in domain.vocabulary.derived
        if isinstance(derived, DefinedPredicate) and derived.name in ("inside", "ontop", "dusty", "cooked")
        for other in range(len(scene.objects))
        if domain.holds(derived.definition, state, {"x": plate, "y": other})
    }
    assert {name for name, _ in held} == {"inside", "dusty"}
    assert ("inside", carton) in held
