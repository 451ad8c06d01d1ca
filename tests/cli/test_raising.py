"""An answer whose scorer raises an exception costs itself alone, in every command."""

from __future__ import annotations

import json
from pathlib import Path

import gymnasium
import pytest

import eai.agents.gym
from command_line import Command
from eai import Reward
from eai.abilities.protocol import Ability
from eai.agents.episode_server import open_episode_server
from eai.agents.rewards import TrlEnvironment, TrlReward
from eai.agents.setting import ACTING
from eai.benchmarks.gold_answers import open_gold_answers
from eai.benchmarks.suite import open_suite
from eai.tasks.source import Source
from raising import BOOM, NAME, RAISING

RIGHT = {
    task: answer.text
    for task, answer in open_gold_answers(RAISING, Ability.ACTION_SEQUENCING, Source()).items()
    if answer.text
}
TASK = "both"


def scored(eai: Command, folder: Path, model: str, texts: dict[str, str], *options: object) -> Path:
    """The folder with the records of some answers to plans."""
    file = folder / f"{model}_outputs.json"
    file.write_text(json.dumps([{"identifier": task, "llm_output": text} for task, text in texts.items()]))
    suite = ("--domain", NAME, "--ability", "action_sequencing")
    done = eai("score", file, *suite, "--out", folder / model, *options)
    assert done.status == 0, done.err
    is_one_odd = BOOM in texts.values()
    assert ("1 failed because the scorer raised an exception" in " ".join(done.err.split())) == is_one_odd
    return folder / model


@pytest.mark.parametrize("workers", [1, 2])
def test_the_other_answers_are_scored_and_the_one_is_shown(
    eai: Command, tmp_path: Path, workers: int
) -> None:
    right = scored(eai, tmp_path, "right", RIGHT)
    odd = scored(eai, tmp_path, "odd", {**RIGHT, TASK: BOOM}, "--workers", workers)
    before, after = (
        {
            line["task_id"]: line
            for line in map(json.loads, (folder / "records.jsonl").read_text().splitlines())
        }
        for folder in (right, odd)
    )
    assert before.keys() == after.keys()
    named = ("model", "response_sha256", "response")
    for task in before.keys() - {TASK}:
        assert {k: v for k, v in after[task].items() if k not in named} == {
            k: v for k, v in before[task].items() if k not in named
        }
    record = after[TASK]
    assert (record["status"], record["success"], record["error"]["check"]) == ("scored", False, "raised")
    assert record["error"]["detail"].startswith("the scorer raised OverflowError (raising.py:")
    summary = json.loads((odd / "summary.json").read_text())
    whole = json.loads((right / "summary.json").read_text())["task_success"]
    assert summary["coverage"]["raised"] == 1
    assert summary["task_success"]["denominator"] == whole["denominator"]
    assert summary["task_success"]["numerator"] == whole["numerator"] - 1

    assert "the scorer raised OverflowError" in eai("explain", odd, TASK).out
    compared = eai("compare", right, odd)
    assert compared.status == 0
    assert "1 failed because the scorer raised" in " ".join(compared.err.split())
    assert "only in right (1): both" in " ".join(compared.out.split())
    assert eai("report", right, odd, "--out", tmp_path / "report", "--no-plots").status == 0
    assert "1 failed because the scorer raised" in (tmp_path / "report" / "report.md").read_text()
    pairs = eai("export", "preference", right, odd, "--domain", NAME, "--out", tmp_path / "pairs.jsonl")
    assert "1 row written" in pairs.out


def test_rewards_of_the_other_answers_are_paid() -> None:
    suite = open_suite(NAME, Ability.ACTION_SEQUENCING)
    for shaping in ("success", "goals", "progress", "diagnosis", "repair", "partial"):
        paid = Reward(suite, shaping).batch([TASK] * 3, [RIGHT[TASK], BOOM, RIGHT[TASK]])
        assert paid == [1, 0, 1], shaping
        texts = [RIGHT[TASK], BOOM]
        assert TrlReward(shaping)(completions=texts, task=[suite.reference(TASK)] * 2) == [1, 0]


def test_an_action_that_raises_fails_and_the_episode_goes_on(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    env = gymnasium.make(eai.agents.gym.ANY, benchmark=RAISING, task_id=TASK, disable_env_checker=True)
    env.reset(seed=0)
    told, paid, terminated, truncated, info = env.step(BOOM)
    assert "Failed (uncategorised): the world raised OverflowError." in told
    assert (paid, terminated, truncated, info["fault"]) == (0, False, False, "uncategorised")
    assert env.step("PRESS(lamp)")[0].startswith("PRESS(lamp): done.")
    household = TrlEnvironment()
    household.reset(task=f"{NAME}/action_sequencing/{TASK}")
    assert "the world raised OverflowError" in household.act(BOOM)
    suite = open_suite(NAME, ACTING)
    with open_episode_server(tmp_path / "served", suite, [(TASK, 1), ("greet", 1)]) as worlds:
        assert "the world raised OverflowError" in worlds.play_command((TASK, 1), BOOM)
        assert worlds.play_command((TASK, 1), "PRESS(lamp)").startswith("PRESS(lamp): done.")
        assert worlds.play_command(("greet", 1), "WAVE()").startswith("WAVE(): done.")
    assert len(caplog.records) == 3
