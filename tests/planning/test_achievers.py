from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import product

import pytest

import eai
from eai.abilities.action_sequencing.scorer import ActionSequencingScorer
from eai.planning import achievers as module
from eai.planning.achievers import Achiever, AchieversByPredicate, _AtomAchieverFinder
from eai.planning.additive_heuristic import AdditiveHeuristic
from eai.planning.effect_schema import make_effect_schemas
from eai.planning.subgoal import GroundAtom
from eai.world import Predicate, Scene, Vocabulary, affordance
from eai.world.frame import AGENT
from eai.world.state import State
from world import toy
from world.toy import X, Y, at

START = toy.initial()
SCENE = START.scene
EVERYTHING = SCENE.everything


def test_changes_of_the_effects_of_operators_are_listed() -> None:
    achievers = AchieversByPredicate(toy.DOMAIN)
    adding = achievers.find_achievers("at", adding=True)
    assert [(each.schema.operator.name, len(each.conditions)) for each in adding] == [("GO", 1), ("GO", 2)]
    assert adding[0].match_atom_arguments((0, 1), SCENE) == {"x": 1}
    assert adding[0].match_atom_arguments((2, 1), SCENE) is None
    assert adding[1].match_atom_arguments((2, 1), SCENE) == {"y": 2, "x": 1}
    assert [each.schema.operator.name for each in achievers.find_achievers("lit", adding=False)] == ["PRESS"]
    assert [operator.name for operator in achievers.find_changing_operators(["lit", "holding"])] == [
        "PRESS",
        "LIFT",
        "DROP",
    ]


def test_an_effect_whose_variable_hides_another_is_left_out() -> None:
    hidden = replace(toy.GO, name="HIDE", parameters=(X, Y))
    domain = replace(toy.DOMAIN, operators=(hidden,))
    assert [each.schema.atom for each in AchieversByPredicate(domain).find_achievers("at", adding=True)] == [
        at(AGENT, X)
    ]


def test_variables_that_the_atom_leaves_open_get_values() -> None:
    go, carry = AchieversByPredicate(toy.DOMAIN).find_achievers("at", adding=True)
    shed, red = SCENE.index["shed"], SCENE.index["red"]
    scopes = [
        go.map_variables_to_objects(binding)
        for binding in go.generate_complete_bindings(START, {}, EVERYTHING)
    ]
    assert scopes == [{"x": SCENE.index["hall"]}, {"x": shed}], "what is no place is left out at once"
    (binding,) = carry.generate_complete_bindings(START, {"y": red, "x": shed}, EVERYTHING)
    assert carry.get_operator_arguments(binding) == (shed,)
    (failing,) = [i for i, (_, holds) in enumerate(carry.conditions) if not holds(START, binding)]
    subgoal, atom = carry.ground_condition(failing, binding, SCENE)
    assert (subgoal.formula, subgoal.scope["y"]) == (toy.holding(Y), red)
    assert atom == GroundAtom("holding", (red,), True)
    assert list(go.generate_complete_bindings(START, {}, 0)) == []


def test_masks_and_trial_complete_a_match_alike(monkeypatch: pytest.MonkeyPatch) -> None:
    suite = eai.open("virtualhome", "action_sequencing")
    scorer = suite.scorer("27_2")
    assert isinstance(scorer, ActionSequencingScorer)
    state, everything = scorer.task.initial, scorer.task.initial.scene.everything

    def found() -> list[list[list[int]]]:
        achievers = [Achiever(schema, scorer.domain.vocabulary) for schema in schemas]
        return [
            [[*b] for b in each.generate_complete_bindings(state, {"x": scorer.task.relevant[0]}, everything)]
            for each in achievers
        ]

    schemas = [schema for operator in scorer.domain.operators for schema in make_effect_schemas(operator)]
    schemas = [schema for schema in schemas if "x" in schema.variables and len(schema.variables) <= 2]
    by_masks = found()
    monkeypatch.setattr(module, "_can_evaluate_by_masks", lambda formula, vocabulary: False)
    assert found() == by_masks
    assert any(by_masks)


heavy = Predicate("heavy", 1, static=True)
VOCABULARY = Vocabulary((toy.at, toy.holding, toy.lit, heavy), (toy.beside,))
LIFT = replace(toy.LIFT, checks=(affordance(~heavy(X), "{x} is heavy"), *toy.LIFT.checks))
DOMAIN = replace(toy.DOMAIN, vocabulary=VOCABULARY, operators=(toy.GO, LIFT, toy.DROP, toy.PRESS))
HOUSE = Scene(VOCABULARY, toy.initial().scene.objects, agent=0)
INDEX, ALL = HOUSE.index, HOUSE.everything


def start(*heavy_ones: str) -> State:
    return HOUSE.state([*toy.initial().facts(), *(("heavy", (INDEX[name],)) for name in heavy_ones)])


def carried(state: State) -> State:
    """Return the initial state with the red box in the shed and the lamp pressed."""
    for name, thing in (("LIFT", "red"), ("GO", "shed"), ("PRESS", "lamp")):
        operator = DOMAIN.compiled_operators[name]
        state = operator.apply(state, operator.bind(state, [INDEX[thing]]))
    return state


def matched(
    matches: _AtomAchieverFinder, atom: GroundAtom, state: State
) -> list[tuple[Achiever, list[list[int]]]]:
    """Return the achievers of an atom that have matches, with these matches."""
    found = [
        (m.achiever, [[*b] for b in m.generate_complete_bindings(state, ALL)])
        for m in matches.find_achievers_of_atom(atom)
    ]
    return [(achiever, bindings) for achiever, bindings in found if bindings]


def matched_anew(
    heuristic: AdditiveHeuristic, atom: GroundAtom, state: State
) -> Iterator[tuple[Achiever, list[list[int]]]]:
    for achiever in heuristic.achievers.find_achievers(atom.predicate, adding=atom.truth):
        scope = achiever.match_atom_arguments(atom.arguments, HOUSE)
        bindings = (
            [] if scope is None else [[*b] for b in achiever.generate_complete_bindings(state, scope, ALL)]
        )
        if bindings:
            yield achiever, bindings


def test_matches_are_equal_in_all_states_of_an_episode() -> None:
    heuristic, first = AdditiveHeuristic(DOMAIN), start("blue")
    matches = heuristic.achievers.get_atom_achiever_finder(first, ALL)
    for state in (first, carried(first)):
        assert heuristic.achievers.get_atom_achiever_finder(state, ALL) is matches
        for predicate, truth in product((toy.at, toy.holding, toy.lit), (True, False)):
            for arguments in product(range(len(HOUSE.objects)), repeat=predicate.arity):
                atom = GroundAtom(predicate.name, arguments, truth)
                assert matched(matches, atom, state) == list(matched_anew(heuristic, atom, state)), atom


def test_matches_are_found_again_if_unchanging_facts_differ() -> None:
    heuristic = AdditiveHeuristic(DOMAIN)
    held = GroundAtom("holding", (INDEX["blue"],), True)
    assert not heuristic.achievers.get_atom_achiever_finder(start("blue"), ALL).find_achievers_of_atom(held)
    assert heuristic.achievers.get_atom_achiever_finder(start("red"), ALL).find_achievers_of_atom(held)
    last = heuristic.achievers.get_atom_achiever_finder(start("red"), ALL)
    assert last is not heuristic.achievers.get_atom_achiever_finder(start("red"), ALL & ~(1 << INDEX["blue"]))


def test_changing_a_yielded_binding_does_not_change_cached_ones() -> None:
    state = start()
    matches = AdditiveHeuristic(DOMAIN).achievers.get_atom_achiever_finder(state, ALL)
    held = GroundAtom("holding", (INDEX["red"],), True)
    (match,) = matches.find_achievers_of_atom(held)
    before = [[*binding] for binding in match.generate_complete_bindings(state, ALL)]
    for binding in match.generate_complete_bindings(state, ALL):
        binding.clear()
    assert [[*binding] for binding in match.generate_complete_bindings(state, ALL)] == before != []
