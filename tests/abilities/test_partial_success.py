"""Partial success: the share of a goal's conditions that a plan meets."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Sequence
from itertools import chain, product
from random import Random
from statistics import mean

import pytest

from eai.abilities.action_sequencing.scorer import ActionSequencingScorer
from eai.abilities.notation.plans import JsonPlanNotation
from eai.abilities.protocol import Ability
from eai.abilities.verdict import PlanVerdict
from eai.benchmarks.suite import open_suite
from eai.logic.choice import Literal, count_dnf_terms, generate_dnf_terms
from eai.logic.formula import (
    Always,
    And,
    Atom,
    Constant,
    Exactly,
    Exists,
    ForAll,
    Formula,
    Not,
    Occurs,
    Or,
    Variable,
)
from eai.tasks.goal_test import GoalTest, StateTest
from eai.tasks.share import Share
from eai.tasks.task import Goal, GoalKind, Task
from eai.world.action import Action
from eai.world.domain import Domain
from eai.world.episode import Episode
from eai.world.state import State
from oracle import read_shared
from sweeps import every
from world import toy

BOX, PLACE = Variable("b", "box"), Variable("p", "place")
LIT: Formula = Atom("lit", (Constant("lamp"),))
ALL_IN_SHED = ForAll(BOX, Atom("at", (BOX, Constant("shed"))))
SOME_IN_SHED = Exists(BOX, Atom("at", (BOX, Constant("shed"))))


def task(*goals: Goal | Formula) -> Task:
    """Return a task in the toy world; formulas are goals about states."""
    goals_of_task = tuple(goal if isinstance(goal, Goal) else Goal(GoalKind.STATE, goal) for goal in goals)
    return Task("1", "Toy", "Play.", toy.initial(), goals_of_task, tuple(range(6)))


def action(*alternatives: str) -> Goal:
    return Goal(GoalKind.ACTION, Or(tuple(Occurs(name) for name in alternatives)))


def partial(given: Task, actions: Sequence[str] = (), state: State | None = None) -> Share:
    test, final = GoalTest(given), state or given.initial
    return test.find_partial_success(final, actions, test.evaluate_each_goal(final, actions))


def test_each_condition_of_a_quantified_goal_counts() -> None:
    """One of the two boxes is in the shed. The goal is missed, but one of its conditions is met."""
    given = task(ALL_IN_SHED)
    test = GoalTest(given)
    assert test.evaluate_each_goal(given.initial, ()) == (False,)
    assert partial(given) == (1, 2)


def test_partial_success_counts_the_option_that_is_met_best() -> None:
    assert partial(task(SOME_IN_SHED, LIT)) == (1, 2)


def test_a_condition_that_two_goals_demand_counts_once() -> None:
    assert partial(task(ALL_IN_SHED, Atom("at", (Constant("blue"), Constant("shed"))))) == (1, 2)


def test_defined_predicates_and_negations_are_conditions() -> None:
    assert partial(task(Not(LIT), ForAll(BOX, Atom("beside", (BOX,))))) == (2, 3)


@pytest.mark.parametrize(
    ("actions", "met"),
    [(["LIFT", "DROP"], 1), (["LIFT", "GO", "DROP", "GO"], 1), (["DROP", "LIFT"], 0), (["LIFT"], 0), ([], 0)],
)
def test_the_sequence_of_action_goals_is_one_condition(actions: list[str], met: int) -> None:
    given = task(ALL_IN_SHED, action("LIFT"), action("DROP", "PUT"))
    assert partial(given, actions) == (1 + met, 3)


def test_a_goal_over_time_is_one_condition() -> None:
    dark = ForAll(Variable("l", "lamp"), Not(Atom("lit", (Variable("l"),))))
    given = task(ALL_IN_SHED, Always(And((dark, Not(LIT)))))
    assert partial(given) == (2, 3)


def test_a_goal_without_a_finite_list_of_options_is_one_condition() -> None:
    given = task(ALL_IN_SHED, Not(Exactly(1, BOX, Atom("at", (BOX, Constant("shed"))))))
    assert partial(given) == (1, 3)


def test_two_objects_meet_the_conditions_of_exactly_one_but_miss_the_goal() -> None:
    """An option does not restrict the other objects, as in BEHAVIOR's definition of goals."""
    given = task(Exactly(1, BOX, Atom("at", (BOX, Constant("shed")))))
    index = given.scene.index
    red, shed = index["red"], index["shed"]
    episode = Episode(toy.DOMAIN, given.initial)
    episode.run([Action("LIFT", (red,)), Action("GO", (shed,))])
    assert GoalTest(given).evaluate_each_goal(episode.state, ()) == (False,)
    assert partial(given, state=episode.state) == (1, 1)


def test_a_goal_without_requirements_is_one_condition() -> None:
    given = task(ForAll(Variable("c", "cat"), LIT))
    assert partial(given) == (1, 1)
    assert GoalTest(given).partial_success_of_unexecuted_answer == (0, 1)


def test_an_answer_that_never_ran_meets_none_of_the_shortest_option() -> None:
    two = And((LIT, Atom("holding", (Constant("red"),))))
    given = task(ALL_IN_SHED, Or((two, Atom("holding", (Constant("blue"),)))))
    scorer = ActionSequencingScorer(given, toy.DOMAIN, JsonPlanNotation())
    for text in ("no plan", '[{"action": "FLY", "object": "red"}]', '[{"action": "GO"}]'):
        verdict = scorer.score(text)
        assert isinstance(verdict, PlanVerdict)
        assert verdict.partial == (0, 3)
    assert partial(given) == (1, 3)
    unanswered = scorer.score_missing_answer()
    assert isinstance(unanswered, PlanVerdict)
    assert unanswered.partial == (0, 3)


def test_a_plan_counts_up_to_the_step_that_fails() -> None:
    scorer = ActionSequencingScorer(task(ALL_IN_SHED, LIT), toy.DOMAIN, JsonPlanNotation())
    steps = [("GO", "shed"), ("PRESS", "lamp"), ("LIFT", "red")]
    verdict = scorer.score(json.dumps([{"action": name, "object": thing} for name, thing in steps]))
    assert isinstance(verdict, PlanVerdict)
    assert (verdict.executable, verdict.partial) == (False, (2, 3))


def test_a_plan_of_gpt_4o_meets_half_of_the_conditions_and_no_goal() -> None:
    answers = read_shared("answers", "behavior", "action_sequencing", "gpt-4o-2024-05-13_outputs.json.gz")
    suite = open_suite("behavior", Ability.ACTION_SEQUENCING)
    (task_id,) = [each for each in suite.task_ids if each.startswith("washing_pots_and_pans")]
    (text,) = [row["llm_output"] for row in answers if row["identifier"] == task_id]
    verdict = suite.score(task_id, text)
    assert isinstance(verdict, PlanVerdict)
    assert not any(verdict.goals_satisfied)
    assert verdict.partial == (5, 10)


@every(10)
def test_partial_success_equals_the_best_of_all_options_after_random_plans(every: int) -> None:
    suite = open_suite("behavior", Ability.ACTION_SEQUENCING)
    compared = 0
    for number, (task_id, given) in enumerate(suite.tasks.items()):
        formulas = [goal.formula for goal in given.goals]
        listed = 1
        for formula in formulas:
            listed *= count_dnf_terms(formula, given.scene.names_of_category)
        if number % every or given.unplannable_reason is not None or listed > 1_000:
            continue
        test = GoalTest(given)
        ways = [list(generate_dnf_terms(each, given.scene.names_of_category)) for each in formulas]
        for state in _states(suite.benchmark.domain, given, Random(number)):
            expected = max(_share(state, given, chain.from_iterable(way)) for way in product(*ways))
            share = test.find_partial_success(state, (), test.evaluate_each_goal(state, ()))
            assert share.numerator / share.denominator == pytest.approx(expected), task_id
            compared += 1
    assert compared > 10


def _states(domain: Domain, given: Task, rng: Random) -> Iterator[State]:
    """Return the states of a random play."""
    episode = Episode(domain, given.initial)
    yield episode.state
    for _ in range(20):
        operator = rng.choice(domain.operators)
        arguments = tuple([rng.choice(given.relevant) for _ in operator.parameters])
        episode.act(Action(operator.name, arguments))
    yield episode.state


def _share(state: State, given: Task, option: Iterable[Literal]) -> float:
    """Return the share of true conditions of an option."""
    conditions = dict.fromkeys(option)
    return mean([StateTest(condition, given.scene)(state) for condition in conditions])
