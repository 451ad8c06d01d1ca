"""Rewards of plans by the number of edits that would repair them."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from math import inf
from random import Random

import pytest

import eai
from agents.switches import DOMAIN, as_plan, initial
from eai import Benchmark, InputError, Reward, Suite, Task, make_task, use_tasks
from eai.abilities.action_sequencing.scorer import ActionSequencingScorer
from eai.abilities.protocol import Ability
from eai.abilities.repair import DEFAULT_EFFORT
from eai.agents.gym import make
from eai.base.store import DataPackStore
from eai.planning.repair.edits import PlanEdit, PlanSteps
from eai.planning.repair.search import FewestEditsPlanRepairer
from eai.planning.search import SearchEffort
from eai.planning.successor_generator import generate_applicable_actions_of_operator
from eai.results.reward import Shaping
from eai.world import Action, Episode
from suites import answer_book
from sweeps import examples

HOUSEHOLDS = ("virtualhome", "behavior")


@pytest.fixture(autouse=True)
def there(data_store: DataPackStore) -> None:
    """Skip the tests of this module without the data of the household benchmarks."""


def suite_of(name: str) -> Suite:
    return eai.open(name, "action_sequencing")


def scorer_of(suite: Suite, task_id: str) -> ActionSequencingScorer:
    scorer = suite.scorer(task_id)
    assert isinstance(scorer, ActionSequencingScorer)
    return scorer


def drawn(name: str, random: Random) -> tuple[Suite, Task, list[Action]]:
    """Return a task with random possible actions, the start of a successful plan, or both in turn."""
    suite = suite_of(name)
    task = suite.tasks[
        random.choice([i for i in suite.task_ids if suite.tasks[i].unplannable_reason is None])
    ]
    gold = answer_book(name, Ability.ACTION_SEQUENCING)[task.id]
    scorer = scorer_of(suite, task.id)
    read = scorer.notation.read(gold.join(gold.parts))
    steps = [step for step in scorer.repairer.read_steps(read) if step is not None]  # type: ignore[arg-type]
    plan = steps[: random.choice((0, 0, 1, len(steps) - 1, len(steps)))]
    episode = Episode(suite.benchmark.domain, task.initial)
    episode.run(plan)
    for _ in range(random.randint(not plan, 3)):
        can = [a for o in scorer.domain.operators for a in _applicable(scorer, episode, o)]
        plan.append(random.choice(can))
        episode.run(plan[-1:])
    return suite, task, plan


def _applicable(scorer: ActionSequencingScorer, episode: Episode, operator: eai.Operator) -> Sequence[Action]:
    return [
        *generate_applicable_actions_of_operator(scorer.domain, operator, episode.state, scorer.task.relevant)
    ]


def written(suite: Suite, task: Task, plan: Sequence[Action]) -> str:
    notation = suite.benchmark.notation.plans
    return notation.join(notation.write(plan, task.scene))


@pytest.mark.parametrize("name", HOUSEHOLDS)
def test_only_success_gets_the_full_reward_and_a_step_earns_at_most_its_share(name: str) -> None:
    random, paid = Random(1), set()
    for _ in range(examples(12)):
        suite, task, plan = drawn(name, random)
        text = written(suite, task, plan)
        reward = Reward(suite, Shaping.REPAIR)(task.id, text)
        if reward is None:
            continue
        paid.add(reward)
        assert (reward == 1) == bool(suite.score(task.id, text).success)
        assert 0 <= reward <= len(plan) / scorer_of(suite, task.id).repairer._min_plan_steps + 1e-9
    assert {0, 1} <= paid


@pytest.mark.parametrize("name", HOUSEHOLDS)
def test_a_longer_search_never_lowers_the_reward(name: str) -> None:
    random = Random(2)
    for _ in range(examples(6)):
        suite, task, plan = drawn(name, random)
        mender = scorer_of(suite, task.id).repairer
        paid = [
            mender._compute_closeness_to_success_by_repair((*plan,), limit)
            for limit in (1, 100, 1_000, DEFAULT_EFFORT)
        ]
        assert all(before <= after for before, after in pairwise(paid))


@pytest.mark.parametrize("name", HOUSEHOLDS)
def test_a_search_that_ends_at_many_edits_finds_the_same_smaller_repairs(name: str) -> None:
    random, ended = Random(4), 0
    for _ in range(examples(8)):
        suite, task, plan = drawn(name, random)
        mender = scorer_of(suite, task.id).repairer
        repairer = mender._make_repairer(())
        proved, edits = repairer.repair(plan, SearchEffort(1_000))
        assert (mender.compute_closeness_to_success(plan) == 1) == (edits == ())
        for limit in (1, 2, 4):
            fewer = repairer.repair(plan, SearchEffort(1_000), limit)[1]
            counts = [inf if found is None else len(found) for found in (fewer, edits)]
            assert fewer == edits or min(counts) >= limit
            ended += proved >= limit
    assert ended


def test_the_rewards_of_turns_sum_to_the_reward_of_the_plan() -> None:
    random, seen = Random(3), set()
    for _ in range(12):
        suite, task, plan = drawn("virtualhome", random)
        reward = Reward(suite, "repair")(task.id, written(suite, task, plan))
        environment = make("virtualhome", task.id, reward="repair", until="done")
        environment.reset(seed=0)
        name = suite.benchmark.observation_wording().object_name
        commands = [f"{a.operator}({', '.join(name(task, i) for i in a.arguments)})" for a in plan]
        turns = [float(environment.step(command)[1]) for command in (*commands, "DONE")]
        assert sum(turns) == pytest.approx(reward or 0.0, abs=1e-9)
        seen.add(reward)
    assert {0, 1} < seen, "nothing, all, and something between"


@pytest.mark.parametrize("name", HOUSEHOLDS)
def test_empty_and_unreadable_plans_earn_nothing(name: str) -> None:
    suite = suite_of(name)
    for task_id in [i for i in suite.task_ids if suite.tasks[i].unplannable_reason is None][::40]:
        scorer, paid = scorer_of(suite, task_id), Reward(suite, "repair")
        assert (
            scorer.repairer.compute_closeness_to_success(())
            == scorer.repairer.compute_closeness_to_success((None,))
            == 0
        )
        assert scorer.repairer.compute_closeness_to_success((None,) * 300) == 0
        assert paid(task_id, "All is done.") == paid(task_id, "x" * (paid.limit + 1)) == 0


def test_only_plans_can_be_paid_by_repair() -> None:
    expected = "shaping repair: expected action_sequencing, found goal_interpretation"
    with pytest.raises(InputError, match=expected):
        Reward(eai.open("virtualhome", "goal_interpretation"), "repair")


def test_tasks_with_goals_over_time_are_not_paid_by_repair() -> None:
    asked = make_task(
        "t", "Only the lamp.", initial(), "lit(lamp)", "always (not (lit(torch)))", domain=DOMAIN
    )
    suite = eai.open(Benchmark("switches", DOMAIN, use_tasks(asked)), "action_sequencing")
    text = as_plan(["PRESS(lamp)"])
    assert Reward(suite, "success")("t", text) == 1
    assert Reward(suite, "repair")("t", text) is None


def test_the_search_for_repairs_is_bounded_and_cached(monkeypatch: pytest.MonkeyPatch) -> None:
    suite = suite_of("behavior")
    scorer = scorer_of(suite, suite.task_ids[3])
    mender, limits = scorer.repairer, list[float]()
    mend = FewestEditsPlanRepairer.repair

    def counted(
        self: FewestEditsPlanRepairer, plan: PlanSteps, effort: SearchEffort, edit_limit: float
    ) -> tuple[int, tuple[PlanEdit, ...] | None]:
        limits.append(effort.limit)
        found = mend(self, plan, effort, edit_limit)
        assert effort.used < 2 * effort.limit + 1_000
        return found

    monkeypatch.setattr(FewestEditsPlanRepairer, "repair", counted)
    plan = tuple(scorer.task.script)
    paid = [mender.compute_closeness_to_success(plan[:n]) for n in (0, 1, 2, 1, 0)]
    assert paid[:2] == paid[:2:-1]
    assert mender.compute_closeness_to_success((*plan, *plan)) is not None
    assert len(limits) == 3, "equal plans are repaired once, and a plan that succeeds never"
    assert limits == sorted(limits)
    assert limits[-1] <= DEFAULT_EFFORT / 4
