"""Landmarks of repairs, held against plans that succeed: what is dropped mends what is left."""

from __future__ import annotations

from itertools import combinations
from random import Random

import pytest

import eai
from eai.abilities.action_sequencing.scorer import ActionSequencing
from eai.abilities.planning import planning_goal
from eai.abilities.protocol import Ability
from eai.abilities.verdict import Unreadable
from eai.planning.planner import Planner
from eai.planning.repair import Mender, _Entry
from eai.planning.search import Effort
from eai.world.execution import Action
from suites import answer_book
from sweeps import swept


def mender_and_gold(name: str, task_id: str, planner: Planner) -> tuple[Mender, tuple[Action, ...]] | None:
    scorer = eai.open(name, "action_sequencing").scorer(task_id)
    gold = answer_book(name, Ability.ACTION_SEQUENCING)[task_id]
    text = gold.join(gold.parts)
    if not isinstance(scorer, ActionSequencing) or not getattr(scorer.score(text), "success", None):
        return None
    plan = scorer.notation.read(text)
    assert not isinstance(plan, Unreadable)
    steps = tuple([step for step in scorer.mender.steps(plan) if step is not None])
    named = {index for step in steps for index in step.arguments}
    objects = (*scorer.task.relevant, *sorted(named.difference(scorer.task.relevant)))
    return Mender(planner, scorer.task.initial, planning_goal(scorer.task), objects), steps


@pytest.mark.parametrize(
    ("name", "every"),
    [("virtualhome", 23), ("behavior", 19), *swept(("virtualhome", 2), ("behavior", 2))],
)
def test_the_steps_that_were_dropped_hit_every_landmark(name: str, every: int) -> None:
    random, found = Random(1), []
    suite = eai.open(name, "action_sequencing")
    planner = Planner(suite.scorer(suite.task_ids[0]).domain)
    for task_id in suite.task_ids[::every]:
        case = mender_and_gold(name, task_id, planner)
        if case is None:
            continue
        mender, gold = case
        for number in {1, 2, len(gold) // 2, len(gold)}:
            dropped = set(random.sample(range(len(gold)), min(number, len(gold))))
            plan = tuple([_Entry(i, step) for i, step in enumerate(gold) if i not in dropped])
            cuts = mender.needed(plan)
            inserted = {gold[i] for i in dropped}
            assert all(cut & inserted for cut in cuts), (task_id, dropped)
            assert all(one.isdisjoint(other) for one, other in combinations(cuts, 2))
            found.append(len(cuts))
    assert max(found) > 2


def test_an_empty_plan_lacks_what_leads_to_the_goals_too() -> None:
    suite = eai.open("behavior", "action_sequencing")
    planner = Planner(suite.scorer(suite.task_ids[0]).domain)
    for task_id in suite.task_ids[::19]:
        case = mender_and_gold("behavior", task_id, planner)
        if case is None:
            continue
        mender, gold = case
        at_least = len(mender.needed(()))
        assert 1 <= at_least <= len(gold)
        assert mender.least(Effort(1)) >= at_least


def test_a_step_is_mended_where_it_fails_and_the_rest_stays() -> None:
    """Three steps of a long plan are missing: so few edits are found, though a planner would begin anew."""
    suite = eai.open("behavior", "action_sequencing")
    planner = Planner(suite.scorer(suite.task_ids[0]).domain)
    told = []
    for task_id in suite.task_ids[::7]:
        case = mender_and_gold("behavior", task_id, planner)
        if case is None or len(case[1]) < 12:
            continue
        mender, gold = case
        opening = next((i for i, step in enumerate(gold) if step.operator == "OPEN"), None)
        if opening is not None:
            plan = (*gold[:opening], *gold[opening + 1 : -2])
            _, edits = mender.mend(plan, Effort(8_000))
            told.append(None if edits is None else len(edits))
    assert told
    assert all(number is not None and number <= 3 for number in told), told
