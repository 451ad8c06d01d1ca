"""Measure whether rewards can train a model: rewards of null models, and tasks with mixed rewards.

A task has mixed rewards if its answers get different rewards, which training by GRPO needs.
Null models answer without trying to solve tasks, such as with empty or random answers.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable
from typing import Literal, NamedTuple

from eai.abilities.protocol import Ability
from eai.base.errors import InputError
from eai.base.grouping import group_pairs
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.copied_answers import (
    open_answers_copied_from_questions,
    open_answers_of_similar_tasks,
    open_empty_answers,
)
from eai.benchmarks.gold_answers import AnswersByTask
from eai.benchmarks.random_answers import open_random_answers
from eai.results.batch import Scoring
from eai.results.rate import Rate
from eai.results.record import Record
from eai.results.repeats import strip_epoch
from eai.results.reward import Reward
from eai.tasks.source import Source, TaskSet

_RANDOM_SEED = "0 1 1"
"""Seed of the random answers: the default seed 0, epoch 1 and attempt 1.

So they equal the first answers that the built-in model `eai/random` gives in a run.
"""


class _TrivialBaselineRewards(NamedTuple):
    """The rewards of a null model (a model that does not try to solve tasks).

    Attributes:
        mean: mean reward over all tasks with a reward.
        full: share of these tasks with the full reward.
    """

    mean: Rate
    full: Rate


def measure_rewards_of_trivial_baselines(
    reward: Reward, scoring: Scoring | None = None
) -> dict[str, _TrivialBaselineRewards]:
    """Return the rewards of null models (models that do not try to solve tasks), by model name.

    Models that cannot answer the suite (ability in a benchmark) are left out. If ``scoring`` is None, this
    process computes the rewards.
    """
    suite = reward.suite
    rewards = {}
    for name, open_answers in OPEN_NULL_MODEL_ANSWERS.items():
        try:
            answers = open_answers(suite.benchmark, suite.ability, suite.source)
        except InputError:  # the null model does not answer questions of this ability
            continue
        texts = [(task_id, answers[task_id].text) for task_id in suite.task_ids]
        rewards_by_task = (scoring or Scoring()).compute_rewards(reward, texts)
        paid = [value for value in rewards_by_task if value is not None]
        full = Rate(sum(value == 1 for value in paid), len(paid))
        rewards[name] = _TrivialBaselineRewards(Rate(sum(paid), len(paid)), full)
    return rewards


def count_tasks_by_reward_spread(
    records: Iterable[Record], reward: Reward, scoring: Scoring | None = None
) -> Counter[str]:
    """Count the tasks with several answers of one model by the rewards of the answers.

    The counts are ``mixed`` for different rewards, ``none`` if all rewards are 0, ``full`` if all are 1, and
    ``equal`` if all are another number. ``single`` counts tasks with one answer. Training by rewards relative
    to the other answers to a task (GRPO) learns only from mixed tasks.
    """
    answered = [record for record in records if record.unanswered is None]
    texts = [(record.task_id, record.response) for record in answered]
    rewards = (scoring or Scoring()).compute_rewards(reward, texts)
    names = [(strip_epoch(record.model), record.task_id) for record in answered]
    groups = group_pairs(zip(names, rewards, strict=True))
    return Counter(_classify_reward_spread(values) for values in groups.values() if None not in values)


def _classify_reward_spread(
    rewards: list[float | None],
) -> Literal["single", "mixed", "none", "full", "equal"]:
    if len(rewards) < 2:
        return "single"
    if len({*rewards}) > 1:
        return "mixed"
    return "none" if rewards[0] == 0 else "full" if rewards[0] == 1 else "equal"


def _make_random_answers_by_task(benchmark: Benchmark, ability: Ability, source: Source) -> AnswersByTask:
    answer, tasks = open_random_answers(benchmark, ability, source), benchmark.tasks_for(ability, source)
    return TaskSet(tasks, lambda task_id: answer(task_id, _RANDOM_SEED, ()), tasks.sha256)


OPEN_NULL_MODEL_ANSWERS: dict[str, Callable[[Benchmark, Ability, Source], AnswersByTask]] = {
    "eai/copy": open_answers_copied_from_questions,
    "eai/empty": open_empty_answers,
    "eai/lookup": open_answers_of_similar_tasks,
    "eai/random": _make_random_answers_by_task,
}
"""For each null model (trivial built-in model of `eai run`), the function that returns its answers."""
