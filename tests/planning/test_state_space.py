"""Plans, proofs, recoverability and repairs compared with all states of small random PDDL worlds."""

from __future__ import annotations

from itertools import cycle, islice
from pathlib import Path
from random import Random

import pytest

import eai.logic.formula as f
from eai.abilities.action_sequencing.scorer import ActionSequencingScorer
from eai.abilities.protocol import Ability
from eai.abilities.repair import DEFAULT_EFFORT
from eai.abilities.verdict import PlanVerdict
from eai.agents.scorer import StateAndTakenActions, find_if_and_when_goals_become_unreachable
from eai.benchmarks.suite import open_suite
from eai.pddl.execute import DerivedPredicates, PddlState
from eai.pddl.search import search
from eai.planning.exclusion import MutualExclusionRules
from eai.planning.planner import Planner
from eai.planning.possible import PossibleFacts, find_unreachable_goals
from eai.planning.repair.search import FewestEditsPlanRepairer
from eai.planning.search import Limits, SearchEffort, SearchEndReason
from eai.planning.subgoal import GroundAtom
from eai.tasks.planning import find_plan, to_planning_goal
from eai.world.action import Action
from eai.world.state import State
from planning.random_worlds import DERIVED, PREDICATES, World, draw_plan, worlds
from planning.repair.test_search import edited, one_edit
from sweeps import swept

EVERYTHING = Limits(3_000, looks=10_000_000)
"""Limits of a search that reaches all states of a random world."""


def check_plans(world: World) -> None:
    """Check that planners find a plan if and only if one exists, and that proofs of unreachability hold."""
    shortest = world.distances.get(world.initial)
    end = SearchEndReason.UNREACHABLE if shortest is None else SearchEndReason.SOLVED
    task, domain = world.task, world.domain
    found = find_plan(task, Planner(domain), EVERYTHING)
    assert found.end is end
    if shortest is not None:
        assert world.succeeds(found.plan)
    by_problem = search(world.source, world.problem, EVERYTHING)
    is_recursive = bool(DerivedPredicates(world.source.axioms).cycles)
    assert by_problem.end is (SearchEndReason.STATES if is_recursive else end)
    if by_problem.end is SearchEndReason.SOLVED:
        assert world.executor.find_failed_step(by_problem.plan) is None
    if shortest is not None:
        conditions = [each.formula for each in task.goals]
        assert find_unreachable_goals(domain, task.initial, task.relevant, conditions) == []


def check_states(world: World, random: Random) -> None:
    """Check that literals called impossible or exclusive hold in no state."""
    domain, initial = world.domain, world.task.initial
    possible = PossibleFacts(domain, initial, world.task.relevant)
    names = [*initial.scene.index]
    literals = []
    for name, types in {**PREDICATES, **DERIVED}.items():
        for _ in range(4):
            chosen = tuple([f.Constant(random.choice(names)) for _ in types])
            literals.append((f.Atom(name, chosen), random.random() < 0.6))
    holding = {
        literal: [world.executor.holds(literal[0], state, {}) == literal[1] for state in world.after]
        for literal in literals
    }
    for (atom, truth), states in holding.items():
        assert possible.may_hold(atom, {}, truth) or not any(states), (atom, truth)
    starts, rules = cycle(walk(world, Random(0))), MutualExclusionRules(domain)
    for _ in range(40):
        start, first = next(starts)
        pair = random.sample([*holding], random.choice((1, 2, 2)))
        ground = [
            GroundAtom(atom.predicate, tuple([initial.scene.index[t.name] for t in atom.arguments]), truth)
            for atom, truth in pair
        ]
        excluded = rules.make_mutual_exclusion_prover(start).are_exclusive(ground)
        assert excluded == MutualExclusionRules(domain).make_mutual_exclusion_prover(start).are_exclusive(
            ground
        ), pair
        if excluded:
            for state in reachable(world, first):
                assert not all(world.executor.holds(a, state, {}) == truth for a, truth in pair), pair


def walk(world: World, random: Random) -> list[tuple[State, PddlState]]:
    """Return the states of a random walk, as states of the engine and of the executor."""
    engine, state = world.task.initial, world.initial
    states = [(engine, state)]
    while world.after[state] and len(states) < 5:
        action = random.choice([*world.after[state]])
        state, engine = world.after[state][action], world.domain.apply(engine, action)
        states.append((engine, state))
    return states


def reachable(world: World, first: PddlState) -> list[PddlState]:
    """Return all states after a state."""
    states = {first: None}
    pending = [first]
    while pending:
        new = [state for state in world.after[pending.pop()].values() if state not in states]
        states |= dict.fromkeys(new)
        pending += new
    return [*states]


def check_outlook(world: World, random: Random) -> None:
    """Check that the goal is called lost after a step of a walk if and only if it is unreachable there."""
    visited = walk(world, random)
    states = [state for _, state in visited]
    moments: list[StateAndTakenActions] = [(engine, ()) for engine, _ in visited]
    outlook, lost_at = find_if_and_when_goals_become_unreachable(
        world.task, world.domain, moments, EVERYTHING.states
    )
    lost = [state not in world.distances for state in states]
    assert (outlook, lost_at) == (("lost", lost.index(True)) if lost[-1] else ("open", None))


def check_repairs(world: World, random: Random) -> bool:
    """Check the bounds of repairs, that reported edits succeed, and that all single edits are found."""
    task = world.task
    repairer = FewestEditsPlanRepairer(
        Planner(world.domain), task.initial, to_planning_goal(task), task.relevant
    )
    shortest = world.distances.get(world.initial)
    assert shortest is None or repairer.compute_proved_min_plan_length(SearchEffort(20_000)) <= shortest
    exact = False
    for plan in [(), *[draw_plan(world, random) for _ in range(4)]]:
        fewest = world.edits(plan)
        at_least, edits = repairer.repair(plan, SearchEffort(random.choice((300, 20_000))))
        assert fewest is None or at_least <= fewest, (plan, at_least, fewest)
        if edits is None:
            continue
        assert fewest is not None
        assert fewest <= len(edits)
        assert world.succeeds(edited(plan, edits)), (plan, edits)
        exact = exact or at_least == len(edits) > 0
        if at_least == len(edits) == 1:
            check_singles(world, repairer, plan)
    return exact


def check_singles(world: World, repairer: FewestEditsPlanRepairer, plan: tuple[Action | None, ...]) -> None:
    singles = {edited(plan, [each]) for each in repairer.find_single_edit_repairs(plan)}
    assert all(map(world.succeeds, singles))
    for each in one_edit(plan, [*world.steps]):
        if world.succeeds(each) and each not in singles:
            shorter = {(*each[:i], *each[i + 1 :]) for i in range(len(each))}
            assert shorter & singles, (plan, each)


@pytest.mark.parametrize(("seed", "number"), [(1, 6), *swept((2, 300))])
def test_planning_agrees_with_all_states_of_random_worlds(seed: int, number: int) -> None:
    random, lengths, exact = Random(seed), set[int | None](), 0
    for world in islice(worlds(random), number):
        check_plans(world)
        check_states(world, random)
        check_outlook(world, random)
        exact += check_repairs(world, random)
        lengths.add(world.distances.get(world.initial))
    assert 2 in lengths
    assert exact


DOCK = """(define (domain dock) (:requirements :strips :typing) (:types place) (:constants home - place)
(:predicates (at ?p - place) (road ?a - place ?b - place) (charged))
(:action move :parameters (?a - place ?b - place) :precondition (and (at ?a) (road ?a ?b))
  :effect (and (at ?b) (not (at ?a))))
(:action fly_home :parameters (?a - place) :precondition (at ?a) :effect (and (at home) (not (at ?a))))
(:action charge :parameters () :precondition (at home) :effect (charged)))"""
FAR = """(define (problem far) (:domain dock) (:objects a b c - place)
(:init (at a) (road a b) (road b c) (road c home)) (:goal (charged)))"""


@pytest.fixture
def dock(tmp_path: Path) -> ActionSequencingScorer:
    """Return the scorer of a task with an effect about a constant."""
    (tmp_path / "domain.pddl").write_text(DOCK)
    (tmp_path / "problem.pddl").write_text(FAR)
    suite = open_suite(f"pddl:{tmp_path / 'domain.pddl'},{tmp_path}", Ability.ACTION_SEQUENCING)
    scorer = suite.scorer("far")
    assert isinstance(scorer, ActionSequencingScorer)
    return scorer


@pytest.mark.parametrize("plan", ["(charge)", "(fly_home a)"])
def test_an_effect_about_a_constant_repairs_a_plan(dock: ActionSequencingScorer, plan: str) -> None:
    look_back = dock.assess(plan).analyze_failure
    assert look_back is not None
    verdict = look_back(DEFAULT_EFFORT)
    assert isinstance(verdict, PlanVerdict)
    assert verdict.repair is not None
    assert (verdict.repair.at_least, verdict.repair.at_most) == (1, 1)
    assert dock.compute_closeness_to_success(plan) == 0.5


def test_a_plan_uses_an_effect_about_a_constant(dock: ActionSequencingScorer) -> None:
    plan = find_plan(dock.task, Planner(dock.domain)).plan
    assert [action.operator for action in plan] == ["fly_home", "charge"]
