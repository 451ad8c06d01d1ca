"""Rewards of null models equal those of their answers, and groups of answers are counted by their rewards."""

from __future__ import annotations

from dataclasses import replace

import pytest

import eai
from agents.switches import SWITCHES
from eai.abilities.protocol import PAPER_ABILITIES
from eai.benchmarks.copied_answers import open_answers_copied_from_questions
from eai.results.learnability import count_tasks_by_reward_spread, measure_rewards_of_trivial_baselines
from eai.results.reward import Reward
from results.test_training_data import HALF, record, suite_reward


@pytest.mark.parametrize("ability", PAPER_ABILITIES, ids=str)
def test_null_models_earn_the_mean_of_their_answers_rewards(ability: str) -> None:
    reward = Reward(eai.open(SWITCHES, ability), "progress")
    rewards = measure_rewards_of_trivial_baselines(reward)
    assert {"eai/copy", "eai/empty", "eai/random"} <= rewards.keys()
    book = open_answers_copied_from_questions(SWITCHES, reward.suite.ability)
    paid = [reward(task_id, book[task_id].text) for task_id in reward.suite.task_ids]
    values = [value for value in paid if value is not None]
    mean, full = rewards["eai/copy"]
    assert (mean.numerator, mean.denominator) == (sum(values), len(values))
    assert full.numerator == sum(value == 1 for value in values)
    assert measure_rewards_of_trivial_baselines(reward) == rewards


def test_groups_are_counted_by_the_rewards_of_their_answers() -> None:
    reward = suite_reward()
    half = record()
    wrong, late = replace(half, response="nothing"), replace(half, unanswered="late")
    other = replace(half, model="other")
    epoch = replace(half, model="m.epoch_2")
    assert 0 < (reward("both", HALF) or 0) < 1

    def count(*records: eai.Record) -> dict[str, int]:
        return dict(count_tasks_by_reward_spread(records, reward))

    assert count(half) == {"single": 1}
    assert count(half, other) == {"single": 2}
    assert count(half, late) == {"single": 1}
    assert count(half, wrong) == {"mixed": 1}
    assert count(half, epoch) == {"equal": 1}
    assert count(wrong, wrong) == {"none": 1}
    assert count(half, wrong, other, other) == {"mixed": 1, "equal": 1}
    assert count() == {}
