"""Repairs with fewest edits, compared with all edited plans in small cases."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cache
from itertools import count, islice, product
from random import Random
from typing import Any

import pytest

import eai
from eai.abilities.action_sequencing.scorer import ActionSequencingScorer
from eai.abilities.protocol import Ability
from eai.abilities.verdict import Unreadable
from eai.planning.planner import Planner
from eai.planning.repair.edits import PlanEdit, PlanSteps
from eai.planning.repair.search import FewestEditsPlanRepairer
from eai.planning.search import SearchEffort, SearchResult
from eai.planning.successor_generator import generate_applicable_actions_of_operator
from eai.tasks.goal_test import GoalTest
from eai.tasks.planning import to_planning_goal
from eai.tasks.task import Task
from eai.world.action import Action
from eai.world.domain import Domain
from eai.world.execution import execute_plan
from suites import answer_book
from sweeps import examples, swept

HOUSEHOLDS = ("virtualhome", "behavior")
MAX_BRUTE_FORCE_EDITS = 3
"""Number of edits from which on brute force does not distinguish distances."""


planner = cache(Planner)
"""The cached planner of a domain."""


@cache
def good_plans(name: str) -> list[tuple[ActionSequencingScorer, tuple[Action, ...]]]:
    """Yield short plans that succeed, each with the scorer of its task."""
    suite, book = eai.open(name, "action_sequencing"), answer_book(name, Ability.ACTION_SEQUENCING)
    found = []
    for task_id in suite.task_ids:
        scorer, gold = suite.scorer(task_id), book[task_id]
        text = gold.join(gold.parts)
        if not isinstance(scorer, ActionSequencingScorer) or len(gold.parts) > 6:
            continue
        if not getattr(scorer.score(text), "success", None):
            continue
        plan = scorer.notation.read(text)
        assert not isinstance(plan, Unreadable)
        steps = scorer.repairer.read_steps(plan)
        found.append((scorer, tuple([step for step in steps if step is not None])))
    return found


def succeeds(domain: Domain, task: Task, plan: PlanSteps) -> bool:
    if None in plan:
        return False
    trajectory = execute_plan(domain, task.initial, [step for step in plan if step is not None])
    taken = [action.operator for action in trajectory.executed_actions]
    return trajectory.failure is None and all(
        GoalTest(task).evaluate_each_goal(trajectory.final_state, taken, trajectory)
    )


def one_edit(
    plan: tuple[Action | None, ...], actions: Sequence[Action | None]
) -> Iterator[tuple[Action | None, ...]]:
    for i in range(len(plan) + 1):
        yield from (((*plan[:i], action, *plan[i:])) for action in actions)
        if i < len(plan):
            yield (*plan[:i], *plan[i + 1 :])
            yield from (((*plan[:i], action, *plan[i + 1 :])) for action in actions)


def by_brute_force(domain: Domain, task: Task, plan: PlanSteps, actions: Sequence[Action]) -> int:
    plans, seen = {tuple(plan)}, {tuple(plan)}
    for distance in range(MAX_BRUTE_FORCE_EDITS):
        if any(succeeds(domain, task, each) for each in plans):
            return distance
        if distance < MAX_BRUTE_FORCE_EDITS - 1:
            plans = {edited for each in plans for edited in one_edit(each, actions)} - seen
            seen |= plans
    return MAX_BRUTE_FORCE_EDITS


def edited(plan: PlanSteps, edits: Sequence[PlanEdit]) -> tuple[Action | None, ...]:
    """Apply some edits to a plan."""
    steps: list[Action | None] = []
    for i, step in enumerate((*plan, None)):
        steps += [e.action for e in edits if e.removed is None and e.step == i]
        replaced = [e for e in edits if e.removed == i]
        steps += [e.action for e in replaced if e.action] if replaced else [step] * (i < len(plan))
    return tuple(steps)


def draw(name: str, random: Random) -> tuple[ActionSequencingScorer, tuple[Action | None, ...], list[Action]]:
    """Return a plan with some faults, and the few actions that edits may insert."""
    scorer, plan = random.choice(good_plans(name))
    states = [*execute_plan(scorer.domain, scorer.task.initial, plan).states]
    pool = [
        action
        for state in random.sample(states, min(2, len(states)))
        for operator in scorer.domain.operators
        for action in generate_applicable_actions_of_operator(
            scorer.domain, operator, state, scorer.task.relevant
        )
    ]
    actions = list(dict.fromkeys([*plan, *random.sample(pool, min(4, len(pool)))]))[:8]
    faulty: tuple[Action | None, ...] = plan
    for _ in range(random.choice((1, 1, 2, 2, 3))):
        faulty = random.choice(list(one_edit(faulty, [*actions, None])))
    return scorer, faulty, actions


def restricted(
    scorer: ActionSequencingScorer, plan: PlanSteps, actions: Sequence[Action]
) -> FewestEditsPlanRepairer:
    """Return a repairer that inserts the given actions only."""
    task = scorer.task
    named = [i for step in (*plan, *actions) if step is not None for i in step.arguments]
    repairer = FewestEditsPlanRepairer(
        planner(scorer.domain),
        task.initial,
        to_planning_goal(task),
        tuple(dict.fromkeys([*task.relevant, *named])),
    )

    def get_allowed_actions(name: str) -> tuple[Action, ...]:
        return tuple([action for action in actions if action.operator == name])

    repairer.change_finder.get_actions_of_operator = get_allowed_actions  # type: ignore[method-assign]
    return repairer


@pytest.mark.parametrize(
    ("name", "number"), [*product(HOUSEHOLDS, [60]), *swept(*product(HOUSEHOLDS, [1000]))]
)
def test_the_fewest_edits_agree_with_brute_force(name: str, number: int) -> None:
    random, seen = Random(38), set()
    cases = (draw(name, random) for _ in count())
    for scorer, plan, actions in islice((case for case in cases if len(case[1]) <= 5), number):
        repairer = restricted(scorer, plan, actions)
        at_least, _ = repairer.repair(plan, SearchEffort(30_000))
        expected = by_brute_force(scorer.domain, scorer.task, plan, actions)
        assert min(at_least, MAX_BRUTE_FORCE_EDITS) == expected, (scorer.task.id, plan, actions)
        seen.add(expected)
        if expected == 1:
            single_edits = {edited(plan, [each]) for each in repairer.find_single_edit_repairs(plan)}
            for each in one_edit(plan, actions):
                if succeeds(scorer.domain, scorer.task, each) and each not in single_edits:
                    shorter = {(*each[:i], *each[i + 1 :]) for i in range(len(each))}
                    assert shorter & single_edits, "only a step that is skipped stands for one that is gone"
    assert {0, 1, 2} <= seen


@pytest.mark.parametrize("name", HOUSEHOLDS)
def test_a_reported_repair_succeeds_and_bounds_tighten_with_effort(name: str) -> None:
    random = Random(9)
    for _ in range(examples(30)):
        scorer, plan, _ = draw(name, random)
        repairer = FewestEditsPlanRepairer(
            planner(scorer.domain), scorer.task.initial, to_planning_goal(scorer.task), scorer.task.relevant
        )
        at_least, at_most = 0, float("inf")
        for limit in (1, 100, 1_000, 10_000):
            before = at_least
            at_least, edits = repairer.repair(plan, SearchEffort(limit))
            assert before <= at_least <= at_most
            assert edits is not None or at_most == float("inf")
            if edits is not None:
                assert at_least <= len(edits) <= at_most
                at_most = len(edits)
                assert succeeds(scorer.domain, scorer.task, edited(plan, edits))
        assert at_most < float("inf")
        if at_least == at_most == 1:
            singles = [*repairer.find_single_edit_repairs(plan)]
            assert singles
            assert all(succeeds(scorer.domain, scorer.task, edited(plan, [each])) for each in singles)


def test_a_plan_from_the_initial_state_is_searched_for_once(monkeypatch: pytest.MonkeyPatch) -> None:
    scorer, _ = good_plans("virtualhome")[0]
    task, calls = scorer.task, []
    plan = Planner.find_plan

    def counted(*given: Any) -> SearchResult[Action]:
        calls.append(given)
        return plan(*given)

    monkeypatch.setattr(Planner, "find_plan", counted)
    repairer = FewestEditsPlanRepairer(
        planner(scorer.domain), task.initial, to_planning_goal(task), task.relevant
    )
    repairer.repair((), SearchEffort(1))
    assert len(calls) == 2, "from where the plan leads, and from the start"
    repairer.repair((), SearchEffort(1))
    assert len(calls) == 3
