"""Training data from answers in records: used and unused records, and rewards."""

from __future__ import annotations

import json
from collections import Counter
from typing import Any

import pytest

import eai
from agents.switches import SWITCHES
from eai.abilities.protocol import Ability, Protocol
from eai.abilities.verdict import PlanVerdict
from eai.results.record import AnswerOrigin, Record
from eai.results.reward import Reward
from eai.results.training_data import (
    ASKED_OTHERWISE,
    EXPERIMENT,
    NO_ANSWER,
    TrainingRow,
    make_preference_rows,
    make_prompt_rows,
    make_reward_rows,
    select_verified_rows,
)
from eai.tasks.prompts.prompt import Prompt
from experiments import experiment

PROMPT = Prompt("Do it.", "You are a robot.")
PROMPTS = dict.fromkeys(("both", "greet", "half", "done", "none"), PROMPT)
HALF = json.dumps([{"action": "PRESS", "object": "lamp"}])
"""A plan that gains one of the two goals of ``both``."""


def suite_reward() -> Reward:
    return Reward(eai.open(SWITCHES, "action_sequencing"), "progress")


def record(task_id: str = "both", **told: Any) -> Record:
    return Record(
        Protocol.STRICT,
        "switches",
        Ability.ACTION_SEQUENCING,
        "m",
        task_id,
        HALF,
        "0" * 64,
        PlanVerdict(executable=True, success=False),
        **told,
    )


def named_prompts(name: str, prompt_sha256: str) -> Record:
    """Return a record of a run whose prompts have a name and a known digest."""
    return record(experiment=experiment(prompt_name=name), origin=AnswerOrigin(prompt_sha256=prompt_sha256))


@pytest.mark.parametrize(
    ("given", "why"),
    [
        (record(), None),
        (record(origin=AnswerOrigin()), None),
        (record(origin=AnswerOrigin(prompt_sha256=PROMPT.sha256)), None),
        (record(origin=AnswerOrigin(prompt_sha256="0" * 64)), ASKED_OTHERWISE),
        (record(experiment=experiment(replans=1)), EXPERIMENT),
        (record(experiment=experiment(prompt_name="facts")), EXPERIMENT),
        (named_prompts("facts", PROMPT.sha256), None),
        (named_prompts("facts", "0" * 64), ASKED_OTHERWISE),
        (record(unanswered="the provider refused"), NO_ANSWER),
        (record("none"), NO_ANSWER),
        (record("done"), NO_ANSWER),
    ],
)
def test_an_unused_record_is_counted_by_its_reason(given: Record, why: str | None) -> None:
    left_out: Counter[str] = Counter()
    found = list(make_reward_rows([given, given], suite_reward(), PROMPTS, left_out))
    answer = {
        "prompt": [{"role": "system", "content": "You are a robot."}, {"role": "user", "content": "Do it."}],
        "completion": [{"role": "assistant", "content": HALF}],
        "task": "switches/action_sequencing/both",
        "model": "m",
        "reward": 0.5,
    }
    assert found == ([answer, answer] if why is None else [])
    assert left_out == ({} if why is None else {why: 2})


def test_prompts_are_exported_only_for_tasks_that_pay() -> None:
    rows = list(make_prompt_rows(suite_reward(), PROMPTS))
    assert [row["task"] for row in rows] == [
        f"switches/action_sequencing/{t}" for t in ("both", "greet", "half")
    ]
    assert rows[0] == {
        "prompt": [{"role": "system", "content": "You are a robot."}, {"role": "user", "content": "Do it."}],
        "task": "switches/action_sequencing/both",
        "data_source": "switches/action_sequencing",
        "reward_model": {"style": "rule", "ground_truth": "switches/action_sequencing/both"},
        "env_class": "eai",
        "reward_spec": {"method": "rule", "ground_truth": "switches/action_sequencing/both"},
    }


def answers(*worths: float, task: str = "a") -> list[TrainingRow]:
    told = [[{"role": "assistant", "content": f"answer {number}"}] for number in range(len(worths))]
    of_task = {"prompt": [{"role": "user", "content": "Do it."}], "task": task, "model": "m"}
    return [
        {**of_task, "completion": each, "reward": worth} for each, worth in zip(told, worths, strict=True)
    ]


@pytest.mark.parametrize(("least", "kept"), [(1.0, [1]), (0.5, [0, 1]), (0.4, [0, 1, 2])])
def test_equal_answers_are_kept_once(least: float, kept: list[int]) -> None:
    given = answers(0.5, 1, 0.4)
    rows = list(select_verified_rows([*given, *given], least))
    assert [row["completion"] for row in rows] == [
        [{"role": "assistant", "content": f"answer {number}"}] for number in kept
    ]
    assert [row["reward"] for row in rows] == [given[number]["reward"] for number in kept]
    assert rows[0]["prompt"] == [{"role": "user", "content": "Do it."}]


@pytest.mark.parametrize(
    ("worths", "margin", "pairs"),
    [
        ((0.5, 1, 0), 0, [("answer 1", "answer 0", 0.5), ("answer 1", "answer 2", 1)]),
        ((0.5, 1, 0), 0.5, [("answer 1", "answer 2", 1)]),
        ((1, 1, 0), 0, [("answer 0", "answer 2", 1)]),
        ((0.5, 0.5), 0, []),
        ((1,), 0, []),
    ],
)
def test_the_best_answer_is_paired_with_each_worse_one(
    worths: tuple[float, ...], margin: float, pairs: list[tuple[str, str, float]]
) -> None:
    rows = list(make_preference_rows([*answers(*worths), *answers(0, task="b"), *answers(*worths)], margin))
    told = [(row["chosen"][0]["content"], row["rejected"][0]["content"], row["margin"]) for row in rows]
    assert told == pairs
