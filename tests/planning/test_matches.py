from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import product

from eai.planning.achievers import Achiever
from eai.planning.additive_heuristic import AdditiveHeuristic
from eai.planning.matches import Matches
from eai.planning.subgoal import GroundAtom
from eai.world import Predicate, Scene, Vocabulary, affordance
from eai.world.state import State
from world import toy
from world.toy import X

heavy = Predicate("heavy", 1, static=True)
VOCABULARY = Vocabulary((toy.at, toy.holding, toy.lit, heavy), (toy.beside,))
LIFT = replace(toy.LIFT, checks=(affordance(~heavy(X), "{x} is heavy"), *toy.LIFT.checks))
DOMAIN = replace(toy.DOMAIN, vocabulary=VOCABULARY, operators=(toy.GO, LIFT, toy.DROP, toy.PRESS))
SCENE = Scene(VOCABULARY, toy.initial().scene.objects, agent=0)
INDEX, EVERYTHING = SCENE.index, SCENE.everything


def start(*heavy_ones: str) -> State:
    return SCENE.state([*toy.initial().facts(), *(("heavy", (INDEX[name],)) for name in heavy_ones)])


def carried(state: State) -> State:
    """The red box is taken to the shed, where the lamp is pressed."""
    for name, thing in (("LIFT", "red"), ("GO", "shed"), ("PRESS", "lamp")):
        operator = DOMAIN.compiled[name]
        state = operator.apply(state, operator.bind(state, [INDEX[thing]]))
    return state


def matched(matches: Matches, atom: GroundAtom, state: State) -> list[tuple[Achiever, list[list[int]]]]:
    """What achieves an atom, where anything does, and with what."""
    found = [(m.achiever, [[*b] for b in m.bindings(state, EVERYTHING)]) for m in matches.of(atom)]
    return [(achiever, bindings) for achiever, bindings in found if bindings]


def matched_anew(
    heuristic: AdditiveHeuristic, atom: GroundAtom, state: State
) -> Iterator[tuple[Achiever, list[list[int]]]]:
    for achiever in heuristic.achievers.of(atom.predicate, adding=atom.truth):
        scope = achiever.match(atom.arguments, SCENE.agent)
        bindings = [] if scope is None else [[*b] for b in achiever.bindings(state, scope, EVERYTHING)]
        if bindings:
            yield achiever, bindings


def test_what_is_found_once_is_so_in_all_states_of_an_episode() -> None:
    heuristic, first = AdditiveHeuristic(DOMAIN), start("blue")
    matches = heuristic.matches(first, EVERYTHING)
    for state in (first, carried(first)):
        assert heuristic.matches(state, EVERYTHING) is matches
        for predicate, truth in product((toy.at, toy.holding, toy.lit), (True, False)):
            for arguments in product(range(len(SCENE.objects)), repeat=predicate.arity):
                atom = GroundAtom(predicate.name, arguments, truth)
                assert matched(matches, atom, state) == list(matched_anew(heuristic, atom, state)), atom


def test_they_are_found_anew_where_something_else_is_so_for_good() -> None:
    heuristic = AdditiveHeuristic(DOMAIN)
    held = GroundAtom("holding", (INDEX["blue"],), True)
    assert not heuristic.matches(start("blue"), EVERYTHING).of(held)
    assert heuristic.matches(start("red"), EVERYTHING).of(held)
    last = heuristic.matches(start("red"), EVERYTHING)
    assert last is not heuristic.matches(start("red"), EVERYTHING & ~(1 << INDEX["blue"]))


def test_nothing_that_is_done_with_a_binding_stays() -> None:
    state = start()
    matches = AdditiveHeuristic(DOMAIN).matches(state, EVERYTHING)
    held = GroundAtom("holding", (INDEX["red"],), True)
    (match,) = matches.of(held)
    before = [[*binding] for binding in match.bindings(state, EVERYTHING)]
    for binding in match.bindings(state, EVERYTHING):
        binding.clear()
    assert [[*binding] for binding in match.bindings(state, EVERYTHING)] == before != []
