"""Verdicts on subgoals, as the reference gave them when it ran on similar answers."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

from benchmarks.behavior import kitchen
from benchmarks.virtualhome import household
from eai.abilities.verdict import Verdict
from eai.extensions.reference.behavior_subgoals import BehaviorSubgoalDecompositionScorer
from eai.extensions.reference.virtualhome_plans import VirtualHomeActionSequencingScorer
from eai.extensions.reference.virtualhome_subgoals import VirtualHomeSubgoalDecompositionScorer
from eai.world.fault import FaultKind

HOME = replace(household.make_task(), temporal_goal="OPEN(fridge.10)")
HOMES = VirtualHomeSubgoalDecompositionScorer(HOME)
SCENES = BehaviorSubgoalDecompositionScorer(kitchen.make_task())

IN_HOMES = ("OPEN(fridge.10)", "CLOSED(fridge.10)", "TOUCH(yacht.9)", "TOUCH(table.12, cup.13)")
IN_SCENES = ("open(fridge.1)", "not open(fridge.1)", "open(yacht.9)", "open(fridge.1, sink.1)")


def told(verdict: Verdict) -> str:
    """The category, and of wrong names their kind."""
    assert verdict.category is not None
    return verdict.category.value


def answer(*subgoals: str) -> str:
    return json.dumps({"output": subgoals})


@pytest.mark.parametrize(
    ("subgoal", "outcome"),
    [
        ("({a} then {b}) and {a}", "not_parseable"),
        ("{a} and ({b} then {a})", "not_parseable"),
        ("not ({a} then {b}) and {a}", "not_parseable"),
        ("(({a} then {b})or({b})) and {a}", "not_parseable"),
        # All parts have a `then`, or none has.
        ("({a} then {b}) and ({b} then {a})", "carried out"),
        ("({a} and {b}) and {a}", "carried out"),
        ("{a} and {b} then {a}", "carried out"),
        # Of an unknown name and such an `and` the one that ends first decides.
        ("(({a} then {b}) and {a}) then FLIES(x)", "not_parseable"),
        ("FLIES(x) then (({a} then {b}) and {a})", "hallucination"),
        ("({a} then {b}) and FLIES(x)", "hallucination"),
        ("(FLIES(x) then {b}) and {a}", "hallucination"),
        ("({a} then {b}) and {a} and FLIES(x)", "hallucination"),
        # Objects that there are not, and numbers of objects, are looked at later.
        ("(({a} then {b}) and {a}) then {stranger}", "not_parseable"),
        ("{stranger} then (({a} then {b}) and {a})", "not_parseable"),
        ("{misused} then (({a} then {b}) and {a})", "not_parseable"),
    ],
)
@pytest.mark.parametrize(
    ("scorer", "words"), [(HOMES, IN_HOMES), (SCENES, IN_SCENES)], ids=["virtualhome", "behavior"]
)
def test_an_and_of_moments_and_states(
    scorer: object, words: tuple[str, ...], subgoal: str, outcome: str
) -> None:
    text = subgoal.format(**dict(zip(("a", "b", "stranger", "misused"), words, strict=True)))
    category = told((HOMES if scorer is HOMES else SCENES).score(answer(text)))
    carried_out = category in ("correct", "goal_unreachable", "runtime")
    assert ("carried out" if carried_out else category) == outcome


@pytest.mark.parametrize(
    ("subgoal", "outcome"),
    [
        ("OPEN(fridge.10)", "correct"),
        ("OPEN(fridge.010)", "correct"),
        ("OPEN(fridge.00010)", "correct"),
        ("ONTOP(cup.013, bed.20) then OPEN(fridge.10)", "correct"),
        ("OPEN(fridge.100)", "hallucination"),
        ("OPEN(fridge.00)", "hallucination"),
        ("OPEN(fridge.010, cup.13)", "hallucination"),
    ],
)
def test_ids_in_virtualhome_are_numbers(subgoal: str, outcome: str) -> None:
    assert told(HOMES.score(answer(subgoal))) == outcome


def test_names_in_behavior_are_texts() -> None:
    assert told(SCENES.score(answer("open(fridge.01)"))) == "hallucination"


@pytest.mark.parametrize(("posture", "seat"), [("SIT", "chair.21"), ("LIE", "bed.20")])
def test_a_full_seat_cannot_be_diagnosed_in_subgoals_and_is_a_missing_step_in_plans(
    posture: str, seat: str
) -> None:
    """A bed has three places; it has four seats."""
    full = [f"ONTOP {thing} {seat}" for thing in ("cup.13", "milk.11", "bread.14")]
    task = replace(household.make_task(*full), temporal_goal="OPEN(fridge.10)")
    subgoals = VirtualHomeSubgoalDecompositionScorer(task).score(answer(f"ONTOP(character.65, {seat})"))
    assert told(subgoals) == "not_parseable"
    name, _, number = seat.partition(".")
    plan = json.dumps({"WALK": [name, number], posture: [name, number]})
    error = VirtualHomeActionSequencingScorer(task).score(plan).error
    assert error is not None
    assert (error.kind, error.detail) == (FaultKind.MISSING_STEP, f"there is no room left on {seat}")


@pytest.mark.parametrize(
    ("subgoal", "outcome", "actions"),
    [
        ("not dusty(plate.1)", "runtime", ["CLEAN(plate_1)"]),
        ("not not not dusty(plate.1)", "runtime", ["CLEAN(plate_1)"]),
        ("not(not(not(not(not dusty(plate.1)))))", "runtime", ["CLEAN(plate_1)"]),
        ("not not dusty(plate.1)", "not_parseable", []),
        ("not not not not dusty(plate.1)", "not_parseable", []),
        ("not not not (dusty(plate.1) and open(fridge.1))", "not_parseable", []),
    ],
)
def test_negations_come_in_odd_numbers(subgoal: str, outcome: str, actions: list[str]) -> None:
    assert told(SCENES.score(answer(subgoal))) == outcome
    assert [step.action for step in SCENES.explain(answer(subgoal)).steps] == actions


def test_what_cannot_be_translated_ends_everything_when_it_is_reached() -> None:
    negation = "not OPEN(fridge.10)"
    reached = HOMES.score(answer("OPEN(fridge.10)", negation))
    assert reached.error is not None
    assert (told(reached), reached.error.detail) == ("not_parseable", "a negation cannot be translated")
    assert told(HOMES.score(answer("OPEN(table.12)", negation))) == "runtime"
