"""Landmarks, compared with plans that succeed: the dropped steps of such a plan hit its missed landmarks."""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from itertools import combinations
from operator import or_
from random import Random

import pytest

import eai
from eai.abilities.action_sequencing.scorer import ActionSequencingScorer
from eai.abilities.protocol import Ability
from eai.abilities.verdict import Unreadable
from eai.planning.landmarks import Landmarks, _HittingSetSearch
from eai.planning.planner import Planner
from eai.planning.repair.search import FewestEditsPlanRepairer
from eai.planning.search import SearchEffort
from eai.tasks.planning import to_planning_goal
from eai.world.action import Action
from suites import answer_book
from sweeps import examples, swept


def repairer_and_gold(
    name: str, task_id: str, planner: Planner
) -> tuple[FewestEditsPlanRepairer, tuple[Action, ...]] | None:
    scorer = eai.open(name, "action_sequencing").scorer(task_id)
    gold = answer_book(name, Ability.ACTION_SEQUENCING)[task_id]
    text = gold.join(gold.parts)
    if not isinstance(scorer, ActionSequencingScorer) or not getattr(scorer.score(text), "success", None):
        return None
    plan = scorer.notation.read(text)
    assert not isinstance(plan, Unreadable)
    steps = tuple([step for step in scorer.repairer.read_steps(plan) if step is not None])
    named = {index for step in steps for index in step.arguments}
    objects = (*scorer.task.relevant, *sorted(named.difference(scorer.task.relevant)))
    return FewestEditsPlanRepairer(
        planner, scorer.task.initial, to_planning_goal(scorer.task), objects
    ), steps


def lacking(repairer: FewestEditsPlanRepairer, plan: Sequence[Action]) -> tuple[Landmarks, int]:
    """Return the landmarks found for a plan, and the minimum number of steps that it lacks."""
    landmarks, least = repairer.make_landmarks_for_repair_of(plan), -1
    while (
        now := landmarks.compute_lower_bound_of_hitting_set_size(landmarks.get_mask_of_cuts_missed_by(plan))
    ) > least:
        least = now
        landmarks.add_cuts_missed_by(frozenset(plan), SearchEffort(2_000))
    return landmarks, least


@pytest.mark.parametrize(
    ("name", "every"), [("virtualhome", 23), ("behavior", 19), *swept(("virtualhome", 2), ("behavior", 2))]
)
def test_a_successful_plan_hits_every_landmark_and_misses_few_after_dropping_steps(
    name: str, every: int
) -> None:
    random, found = Random(1), []
    suite = eai.open(name, "action_sequencing")
    planner = Planner(suite.scorer(suite.task_ids[0]).domain)
    for task_id in suite.task_ids[::every]:
        case = repairer_and_gold(name, task_id, planner)
        if case is None:
            continue
        repairer, gold = case
        for number in {1, 2, len(gold) // 2, len(gold)}:
            dropped = set(random.sample(range(len(gold)), min(number, len(gold))))
            plan = [step for i, step in enumerate(gold) if i not in dropped]
            landmarks, least = lacking(repairer, plan)
            assert all(cut & {*gold} for cut in landmarks.cuts), (task_id, dropped)
            assert least <= len({gold[i] for i in dropped})
            found.append(least)
    assert max(found) > 3


def test_an_empty_plan_also_lacks_the_steps_that_lead_to_the_goals() -> None:
    suite = eai.open("behavior", "action_sequencing")
    planner = Planner(suite.scorer(suite.task_ids[0]).domain)
    for task_id in suite.task_ids[::19]:
        case = repairer_and_gold("behavior", task_id, planner)
        if case is None:
            continue
        repairer, gold = case
        _, at_least = lacking(repairer, ())
        assert 1 <= at_least <= len(gold)
        assert repairer.compute_proved_min_plan_length(SearchEffort(20_000)) >= at_least


def test_a_chain_of_dependent_steps_has_many_landmarks() -> None:
    """The agent takes a brush, puts it into a running sink, soaks it, takes it again and cleans a floor."""
    suite = eai.open("behavior", "action_sequencing")
    task_id = next(each for each in suite.task_ids if each.startswith("cleaning_floors_"))
    case = repairer_and_gold("behavior", task_id, Planner(suite.scorer(task_id).domain))
    assert case is not None
    repairer, gold = case
    assert lacking(repairer, ())[1] == 5, "in the relaxation it stays in the hand that it is taken with"
    assert lacking(repairer, [step for step in gold if step.operator != "SOAK"])[1] == 1
    for step in gold:
        assert lacking(repairer, [step])[1] in (4, 5)


def test_the_minimum_hitting_set_agrees_with_brute_force() -> None:
    random = Random(3)
    for _ in range(examples(200)):
        number = random.randint(1, 7)
        patterns = sorted({random.randrange(1, 1 << number) for _ in range(random.randint(1, 7))})
        mask = reduce(or_, patterns)
        sizes = range(1, len(patterns) + 1)
        fewest = next(n for n in sizes for some in combinations(patterns, n) if reduce(or_, some) == mask)
        found = _HittingSetSearch(patterns, mask)
        assert found.least == len(found.best) == fewest
        assert reduce(or_, found.best) == mask


def test_a_long_plan_without_three_steps_is_repaired_by_three_edits() -> None:
    """A planner alone would start again and need many more edits."""
    suite = eai.open("behavior", "action_sequencing")
    planner = Planner(suite.scorer(suite.task_ids[0]).domain)
    edit_counts = []
    for task_id in suite.task_ids[::7]:
        case = repairer_and_gold("behavior", task_id, planner)
        if case is None or len(case[1]) < 12:
            continue
        repairer, gold = case
        opening = next((i for i, step in enumerate(gold) if step.operator == "OPEN"), None)
        if opening is not None:
            plan = (*gold[:opening], *gold[opening + 1 : -2])
            _, edits = repairer.repair(plan, SearchEffort(8_000))
            edit_counts.append(None if edits is None else len(edits))
    assert edit_counts
    assert all(number is not None and number <= 3 for number in edit_counts), edit_counts
