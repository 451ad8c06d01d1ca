"""Operators with too many possible arguments to list their actions: effort is counted and runs out."""

from __future__ import annotations

from pathlib import Path
from random import Random

import pytest

import eai.logic.formula as f
from eai import InputError
from eai.abilities.action_sequencing.scorer import ActionSequencingScorer
from eai.abilities.protocol import Ability
from eai.abilities.repair import DEFAULT_EFFORT
from eai.abilities.subgoal_decomposition.repertoire import MAX_LISTED_ACTIONS, OperatorIndex
from eai.agents.gym import make
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.random_answers import random_walk
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.suite import open_suite
from eai.planning.planner import Planner, PlanningGoal
from eai.planning.possible import PossibleFacts
from eai.planning.search import Limits, SearchEndReason
from eai.planning.subgoal import GroundAtom
from eai.tasks.planning import find_plan, is_impossible
from eai.tasks.source import Source
from sweeps import first_of

LETTERS = "abcdefgh"
PARAMETERS = " ".join(f"?{letter}" for letter in LETTERS)
OBJECTS = [f"o{number}" for number in range(40)]
PRECONDITIONS = {
    "what holds is asked": " ".join(f"(p ?{letter})" for letter in LETTERS),
    "nothing is asked": "",
    "all pairs are static facts": " ".join(
        f"(link ?{a} ?{b})" for a, b in zip("abcdefg", "bcdefgh", strict=True)
    ),
}


def write(folder: Path, precondition: str) -> str:
    """Write a domain and a problem, and return the paths by which benchmarks find them."""
    (folder / "domain.pddl").write_text(
        "(define (domain wide) (:requirements :strips)"
        f" (:predicates (p ?x) (q ?x) (r ?x) (s ?x) (link ?x ?y) (w {PARAMETERS}))"
        f" (:action wide :parameters ({PARAMETERS}) :precondition (and {precondition})"
        f" :effect (and (r ?a) (w {PARAMETERS}) (not (p ?b))))"
        " (:action mk :parameters (?x) :precondition (p ?x) :effect (and (q ?x) (not (p ?x)))))"
    )
    facts = [f"(p {name})" for name in OBJECTS]
    facts += [f"(link {one} {other})" for one in OBJECTS for other in OBJECTS if one != other]
    (folder / "problem.pddl").write_text(
        f"(define (problem one) (:domain wide) (:objects {' '.join(OBJECTS)}) (:init {' '.join(facts)})"
        " (:goal (and (r o1) (q o2))))"
    )
    return f"pddl:{folder / 'domain.pddl'},{folder / 'problem.pddl'}"


@pytest.fixture(params=first_of(PRECONDITIONS))
def wide(request: pytest.FixtureRequest, tmp_path: Path) -> Benchmark:
    """Return a world with 40 objects and an operator of eight parameters."""
    return find_benchmark(write(tmp_path, PRECONDITIONS[request.param]))


def test_nothing_is_proved_with_too_many_actions(wide: Benchmark) -> None:
    task = wide.tasks(Source())["one"]
    possible = PossibleFacts(wide.domain, task.initial, task.relevant)
    assert not possible.has_examined_all_actions
    assert possible.may_hold(f.Atom("s", (f.Constant("o3"),)), {})
    assert not is_impossible(task, wide.domain)


def test_an_action_that_no_static_fact_permits_is_proved_impossible(tmp_path: Path) -> None:
    asked = f"{PRECONDITIONS['what holds is asked']} (s ?h)"
    benchmark = find_benchmark(write(tmp_path, asked))
    task = benchmark.tasks(Source())["one"]
    assert is_impossible(task, benchmark.domain)


def test_a_planner_ends_at_its_limits(wide: Benchmark) -> None:
    task = wide.tasks(Source())["one"]
    assert find_plan(task, Planner(wide.domain)).end in (SearchEndReason.SOLVED, SearchEndReason.STATES)
    goal = PlanningGoal((f.Atom("s", (f.Constant("o0"),)),))
    found = Planner(wide.domain).find_plan(task.initial, goal, task.relevant, Limits(bindings=50_000))
    assert found.end is SearchEndReason.STATES


def test_repairs_with_too_many_actions_are_bounded_by_found_plans(wide: Benchmark, tmp_path: Path) -> None:
    scorer = open_suite(wide, Ability.ACTION_SEQUENCING).scorer("one")
    assert isinstance(scorer, ActionSequencingScorer)
    for text, at_most in (("(mk o2)\n(wide o1 o2 o3 o4 o5 o6 o7 o8)", 1), ("(mk o3)", 3)):
        look_back = scorer.assess(text).analyze_failure
        assert look_back is not None
        repair = getattr(look_back(DEFAULT_EFFORT), "repair", None)
        assert repair is not None
        assert repair.at_least <= 1
        assert repair.at_most is None or repair.at_least <= repair.at_most <= at_most
    assert scorer.compute_closeness_to_success("(mk o3)") == 0


def test_possible_actions_are_listed_up_to_a_limit(wide: Benchmark) -> None:
    task = wide.tasks(Source())["one"]
    with pytest.raises(InputError, match="too many actions are possible in the task one"):
        make(wide, "one", admissible=True).reset(seed=0)
    assert len([*random_walk(wide.domain, task.initial, task.relevant, Random(1), 2)]) == 2


def test_subgoals_list_actions_up_to_a_limit(wide: Benchmark) -> None:
    task = wide.tasks(Source())["one"]
    wanted = OperatorIndex(wide.domain).map_achieving_actions_to_literals(
        [GroundAtom("r", (1,), True)], task.scene, task.relevant
    )
    assert len(wanted) == MAX_LISTED_ACTIONS
    assert all(len({*action.arguments}) == 8 for action in wanted)
