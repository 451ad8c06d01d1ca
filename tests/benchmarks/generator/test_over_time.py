"""Generated goals over time: the certificate fulfils them, and the temptation does not."""

from __future__ import annotations

import random
from dataclasses import replace
from functools import cache, partial
from typing import Any

import pytest

import eai.logic.formula as f
from benchmarks.generator.worlds import HOUSEHOLDS, NOTHING_IS_USUAL, generator, tempting
from eai.abilities.action_sequencing.scorer import ActionSequencingScorer
from eai.abilities.protocol import Ability
from eai.abilities.verdict import PlanVerdict
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.generator import growing_plan as module
from eai.benchmarks.generator.goals import GoalSampler
from eai.benchmarks.generator.growing_plan import (
    GoalByGoalPlan,
    TemporalGoalGenerator,
    _have_no_common_object,
    _make_goal_if_only_first_fulfils,
    try_to_reach_goals_in_order,
)
from eai.benchmarks.generator.spec import GeneratedTask, TaskKind
from eai.benchmarks.generator.usual_goals import UsualGoalsOfDataSet
from eai.benchmarks.random_answers import random_walk
from eai.benchmarks.registry import find_benchmark
from eai.logic.ltl_printer import format_ltl
from eai.planning.planner import Planner
from eai.tasks.goal_test import GoalTest
from eai.tasks.source import Source
from eai.tasks.task import Task, goal
from eai.world.action import Action
from eai.world.execution import Step, Trajectory, execute_plan
from eai.world.listing import FactLister
from eai.world.state import State
from logic.naive import Facts, Naive

pytestmark = pytest.mark.usefixtures("data_store")
WALKS = 8
DETOURS = {"virtualhome": 54, "behavior": 39}
"""Seeds of tasks with a rare goal: a fact that must hold before another one, or some time after it."""


@cache
def tasks(like: str) -> list[GeneratedTask]:
    made = generator(like, kind=TaskKind.ORDER)
    return [
        each
        for each in map(made.generate_task, map(str, (*range(30), DETOURS[like])))
        if isinstance(each, GeneratedTask)
    ]


@pytest.mark.parametrize("like", HOUSEHOLDS)
def test_certificates_fulfil_the_goal_over_time_and_temptations_violate_only_it(like: str) -> None:
    benchmark = find_benchmark(like)
    assert len(tasks(like)) > 6
    for made in tasks(like):
        task = made.task
        assert [goal.is_temporal for goal in task.goals] == [False] * (len(task.goals) - 1) + [True]
        scorer = ActionSequencingScorer(task, benchmark.domain, benchmark.notation.plans)
        write = benchmark.notation.plans
        verdict = scorer.score(write.join(write.write(task.script, task.scene)))
        assert isinstance(verdict, PlanVerdict)
        assert verdict.success, task.id
        assessment = scorer.assess(write.join(write.write(tempting(made), task.scene)))
        verdict = assessment.verdict
        assert isinstance(verdict, PlanVerdict)
        assert verdict.executable, task.id
        assert verdict.goals_satisfied == (True,) * (len(task.goals) - 1) + (False,), task.id
        assert assessment.explain().goals[-1].why, task.id


def test_all_kinds_are_made() -> None:
    kinds = {type(made.task.goals[-1].formula).__name__ for like in HOUSEHOLDS for made in tasks(like)}
    assert kinds == {"Until", "Always", "Then"}


@pytest.mark.parametrize("like", HOUSEHOLDS)
def test_a_naive_evaluator_agrees_on_random_executions(like: str) -> None:
    listings = find_benchmark(like).wording(Ability.ACTION_SEQUENCING).fact_listers_of_goal_predicates
    domain, judged = find_benchmark(like).domain, set()
    for made in tasks(like)[:12]:
        task, rng = made.task, random.Random(made.task.id)
        for _ in range(WALKS):
            plan = rng.choice((task.script, tempting(made)))
            begun = execute_plan(domain, task.initial, plan[: rng.randint(0, len(plan))])
            steps = list(random_walk(domain, begun.final_state, task.relevant, rng, rng.randint(0, 4)))
            states = (*begun.states, *(state for _, state in steps))
            actions = [*begun.executed_actions, *(action for action, _ in steps)]
            course = Trajectory(states, tuple(Step(action, None) for action in actions))
            naive = naively(task, states, actions, listings)
            assert GoalTest(task).evaluate_each_goal(course.final_state, (), course)[-1] == naive, task.id
            judged.add(naive)
    assert judged == {True, False}


def naively(
    task: Task, states: tuple[State, ...], actions: list[Action], listings: tuple[FactLister, ...]
) -> bool:
    things = task.scene.objects
    categories = tuple((thing.name, thing.category) for thing in things)
    seen = [
        Facts(
            frozenset(
                (fact.predicate, tuple(things[i].name for i in fact.arguments))
                for each in listings
                for fact in each.list_facts(state, task.relevant)
            ),
            categories,
        )
        for state in states
    ]
    taken = [(a.operator, tuple(things[i].name for i in a.arguments)) for a in actions]
    return Naive(tuple(seen), tuple(taken)).on(task.goals[-1].formula, 0, len(seen) - 1, {})


WANTED = {(name, True): 1 for name in ("at", "holds", "inside", "lit")}
WAY = "GO lamp_1; PRESS lamp_1; GO box; OPEN box; GO ball; TAKE ball; GO box; PUT ball box"
LIT, PACKED = {"lit(lamp_1)": list(range(2, 9))}, {"inside(ball, box)": [8]}


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({}, LIT | PACKED),
        ({"goal_counts": {("inside", True): 1, ("lit", False): 1}}, PACKED),
        ({"uses": frozenset({("TAKE", 0, "ball")}), "taken_categories": frozenset({"ball"})}, LIT | PACKED),
        ({"uses": frozenset({("TAKE", 0, "cup")}), "taken_categories": frozenset({"cup"})}, LIT),
    ],
)
def test_new_facts_are_about_movable_objects_and_not_the_agent(
    lamps: Benchmark, changes: dict[str, Any], expected: dict[str, list[int]]
) -> None:
    task = lamps.tasks(Source())["pack"]
    steps = [
        Action(name, tuple([task.scene.index[each] for each in about]))
        for name, *about in (step.split() for step in WAY.split("; "))
    ]
    way = execute_plan(lamps.domain, task.initial, steps)
    assert way.failure is None
    prior = replace(NOTHING_IS_USUAL, **{"goal_counts": WANTED, **changes})
    became = seeker(lamps, task, prior)._map_new_facts_to_state_indices(way.states)
    assert {format_ltl(atom): when for atom, when in became.items()} == expected


def atom(name: str, *about: str) -> f.Formula:
    return f.Atom(name, tuple(map(f.Constant, about)))


ONE, OTHER = atom("lit", "lamp_1"), atom("lit", "lamp_2")


def asked(lamps: Benchmark, way: str, *goals: f.Formula) -> Task:
    """Return a task whose goals, by default two lit lamps, are reached by this plan."""
    task = lamps.tasks(Source())["light"]
    steps = [
        Action(name, tuple([task.scene.index[each] for each in about]))
        for name, *about in (step.split() for step in way.split("; "))
    ]
    return replace(task, goals=tuple(map(goal, goals or (ONE, OTHER))), script=tuple(steps))


def seeker(lamps: Benchmark, task: Task, prior: UsualGoalsOfDataSet) -> TemporalGoalGenerator:
    listings = lamps.wording(Ability.ACTION_SEQUENCING).fact_listers_of_goal_predicates
    proposals = GoalSampler(prior, task.scene, {}, {})
    begin = partial(GoalByGoalPlan, Planner(lamps.domain), task.initial)
    return TemporalGoalGenerator(task, lamps.domain, listings, proposals, random.Random(0), begin)


USUAL = replace(NOTHING_IS_USUAL, goal_counts={(name, True): 1 for name in ("lit", "is_open", "inside")})


FIRST, SECOND = "GO lamp_1; PRESS lamp_1", "GO lamp_2; PRESS lamp_2"
BOX = "GO box; OPEN box"


@pytest.mark.parametrize(
    ("way", "cuts"),
    [
        (f"{FIRST}; {SECOND}", [2, 4]),
        (f"{SECOND}; {FIRST}", [2, 4]),
        (f"{BOX}; {FIRST}; {SECOND}; GO ball", [4, 6]),
        ("GO lamp_1; PRESS lamp_1; GO box; GO lamp_2; PRESS lamp_2", [2, 5]),
    ],
)
def test_a_plan_is_cut_at_steps_after_which_one_more_goal_lasts(
    lamps: Benchmark, way: str, cuts: list[int]
) -> None:
    assert seeker(lamps, asked(lamps, way), USUAL)._steps_reaching_goals == cuts


def test_order_and_overlap_of_facts_distinguish_two_plans(lamps: Benchmark) -> None:
    task = asked(lamps, f"{BOX}; {FIRST}; {SECOND}")
    found = seeker(lamps, task, USUAL)
    ours, other = found._solving_plan, found._execute_plan(asked(lamps, f"{SECOND}; {BOX}; {FIRST}").script)
    is_open = atom("is_open", "box")
    assert [ours.becomes_true_first(*pair) for pair in ((is_open, ONE), (ONE, OTHER), (OTHER, ONE))] == [
        True,
        True,
        False,
    ]
    assert ours.becomes_true_first(ONE, ONE)
    assert ours.have_held_together(is_open, OTHER)
    goals = {format_ltl(goal): apart for apart, goal in found._propose_goals_that_plan_fails(other)}
    assert goals == {
        "not lit(lamp_2) until lit(lamp_1)": True,
        "not lit(lamp_2) until is_open(box)": True,
    }
    for text in goals:
        (goal,) = [
            each for _, each in found._propose_goals_that_plan_fails(other) if format_ltl(each) == text
        ]
        kept = _make_goal_if_only_first_fulfils(goal, ours, other)
        assert kept is not None
        assert (kept.plan, kept.temptation) == (ours.plan, other.plan)
        assert _make_goal_if_only_first_fulfils(goal, other, ours) is None
        assert _make_goal_if_only_first_fulfils(goal, ours, ours) is None
    pressing = seeker(lamps, task, replace(USUAL, action_counts={("PRESS",): 1}))
    pressed = pressing._propose_goals_that_plan_fails(pressing._solving_plan)
    told = [format_ltl(goal) for _, goal in pressed]
    assert len(told) == 2 * 3
    assert "not is_open(box) until PRESS(lamp_1)" in told


@pytest.mark.parametrize(("goals", "walks"), [((ONE,), 0), ((ONE, OTHER), 1)])
def test_goals_are_reached_in_another_order_where_there_are_several(
    lamps: Benchmark, monkeypatch: pytest.MonkeyPatch, goals: tuple[f.Formula, ...], walks: int
) -> None:
    task, reached = asked(lamps, f"{FIRST}; {SECOND}", *goals), []
    monkeypatch.setattr(module, "try_to_reach_goals_in_order", lambda walk, goals: reached.append(goals))
    monkeypatch.setattr(TemporalGoalGenerator, "_find_goal_that_plan_fails", lambda *asked: None)
    assert seeker(lamps, task, USUAL)._find_goal_about_order() is None
    assert len(reached) == walks


def test_all_goals_are_reached_or_not(lamps: Benchmark) -> None:
    def reached(*goals: f.Formula) -> tuple[bool, int]:
        walk = GoalByGoalPlan(Planner(lamps.domain), asked(lamps, FIRST).initial)
        return try_to_reach_goals_in_order(walk, goals), len(walk.conditions)

    assert reached(ONE, OTHER) == (True, 2)
    assert reached(ONE, ONE) == (True, 2), "what holds already is kept, too"
    assert reached(ONE, atom("lit", "ball")) == (False, 1)
    assert _have_no_common_object(ONE, OTHER)
    assert not _have_no_common_object(atom("inside", "ball", "box"), atom("is_open", "box"))
