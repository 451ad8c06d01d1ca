"""Tests of both tasksets in verifiers, with a fake server in place of the model."""

from __future__ import annotations

import asyncio
import json
import os
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from itertools import islice
from pathlib import Path
from typing import Any

import example
import pytest
import verifiers.v1 as vf
from example import PLAN

import eai
from agents.switches import CASES_BY_SHAPING, as_plan, reference
from eai.abilities.protocol import Ability
from eai.agents.rules import GameRules
from eai.base.errors import DataError
from eai.results.reward import METRICS, Shaping
from eai_verifiers.steps import StepsConfig, StepsTaskConfig, StepsTaskset
from eai_verifiers.tasks import make_single_task_suite
from eai_verifiers.taskset import HouseholdConfig, HouseholdTask, HouseholdTaskset

LAMPS = "lamps:lamps"
LIGHT = f"{LAMPS}/action_sequencing/light"
STEPS = "eai-verifiers-steps"


@pytest.fixture
def play(monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[..., list[vf.Trace]]]:
    """Run the first tasks of a taskset with a policy, or with a policy that always gives one reply."""
    server = example.Server(("127.0.0.1", 0), example.Model)
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    address = f"http://127.0.0.1:{server.server_port}/v1"

    def run(says: str | None = None, number: int = 1, **taskset: Any) -> list[vf.Trace]:
        if says is not None:
            monkeypatch.setattr(example, "policy", lambda messages: says)
        whole = {"id": "eai-verifiers", "domain": LAMPS, **taskset}
        return [each.traces[0] for each in asyncio.run(example.evaluate(whole, address, number))]

    yield run
    server.shutdown()
    server.server_close()
    thread.join()


def test_whole_answers_are_paid_and_their_faults_are_metrics(play: Callable[..., list[vf.Trace]]) -> None:
    light, pack = play(number=2)
    assert (light.ok, light.reward, light.task.data.name) == (True, 1, LIGHT)
    assert (pack.ok, pack.reward) == (True, 0)
    assert tuple(light.metrics) == METRICS
    (failed,) = play('[{"action": "PRESS", "object": "lamp_1"}]')
    assert (failed.reward, failed.metrics["fault.missing_step"]) == (0, 1)


def test_thoughts_are_no_part_of_an_answer(play: Callable[..., list[vf.Trace]]) -> None:
    (thought,) = play(f"<think>[]</think>{PLAN}")
    assert thought.reward == 1
    (unfinished,) = play(f"<think>{PLAN}")
    assert unfinished.reward == 0


def test_an_episode_is_played_step_by_step(play: Callable[..., list[vf.Trace]]) -> None:
    (won,) = play(id=STEPS)
    assert (won.ok, won.reward, won.num_turns) == (True, 1, 4)
    assert won.metrics["success"] == 1
    (lost,) = play("PRESS(sun)", id=STEPS, task={"rules": {"max_steps": 3}, "shaping": "diagnosis"})
    assert (lost.ok, lost.reward, lost.num_turns) == (True, 0, 3)
    assert lost.metrics["fault.hallucination"] == 3
    told = [message.content for message in lost.branches[-1].messages]
    assert told[0].startswith("You act in a symbolic world")
    assert told[2].startswith("Failed (hallucination): PRESS: there is no sun.")


def test_less_can_be_told_of_a_turn(play: Callable[..., list[vf.Trace]]) -> None:
    (won,) = play(id=STEPS, task={"rules": {"feedback": "outcome"}})
    assert won.branches[-1].messages[2].content == "GO(lamp_1): done."


def test_rules_limit_actions_unless_another_limit_is_given() -> None:
    options = {"rules": {"slip": 0.5, "observe": "partial"}}
    expected = GameRules(max_steps=50, slip=0.5, observe="partial")
    assert StepsTaskConfig.model_validate(options).rules == expected
    assert StepsTaskConfig(rules=GameRules(max_steps=3)).rules == GameRules(max_steps=3)
    assert StepsTaskConfig().rules == GameRules(max_steps=50)
    with pytest.raises(ValueError, match="step"):
        StepsTaskConfig.model_validate({"rules": {"step": 3}})


@pytest.mark.parametrize(("task_id", "commands", "shaping", "worth"), CASES_BY_SHAPING)
def test_the_same_actions_pay_the_same_as_a_plan_and_step_by_step(
    task_id: str, commands: tuple[str, ...], shaping: Shaping, worth: float
) -> None:
    options = {"domain": "agents.switches:SWITCHES", "task": {"shaping": shaping}}
    whole = {task.data.task: task for task in HouseholdTaskset(HouseholdConfig.model_validate(options))}
    assert whole[reference(task_id)].grade(as_plan(commands)).value == pytest.approx(worth)
    steps = {task.data.task: task for task in StepsTaskset(StepsConfig.model_validate(options))}
    game = steps[reference(task_id)].start_game()
    for command in commands:
        game.act(command)
    assert game.value == pytest.approx(worth)


def test_a_model_that_fails_is_an_error_and_no_wrong_answer(
    play: Callable[..., list[vf.Trace]], monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(model: example.Model) -> None:
        model.rfile.read(int(model.headers["Content-Length"]))
        model.send_error(400, "no such model")

    monkeypatch.setattr(example.Model, "do_POST", refuse)
    (trace,) = play()
    assert not trace.ok
    assert trace.errors


@pytest.mark.parametrize("ability", ["action_sequencing", "goal_interpretation", "subgoal_decomposition"])
def test_every_ability_pays_what_the_library_pays(ability: str) -> None:
    config = HouseholdConfig(domain=LAMPS, ability=Ability(ability), task={"shaping": "progress"})
    for task in HouseholdTaskset(config):
        for answer in (PLAN, '{"output": ["lit(lamp_1)"]}', '{"node goals": [["lit", "lamp_1"]]}', ""):
            assert task.grade(answer).value == eai.reward(task.data.task, answer, "progress")


def test_the_validator_of_verifiers_finds_every_task_valid(tmp_path: Path) -> None:
    """The gold answer earns the full reward, and an empty answer nothing."""
    validator = Path(sys.executable).with_name("vf-validate")
    options = ("--rich", "False", "--taskset.domain", LAMPS, "--runtime.type", "subprocess")
    command = [validator, "eai-verifiers", *options, "--output-dir", tmp_path]
    env = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[3] / "examples" / "lamps")}
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300, env=env)
    assert done.returncode == 0, done.stderr
    (summary,) = tmp_path.rglob("summary.json")
    found = json.loads(summary.read_text(encoding="utf-8"))
    assert found["outcomes"]["valid"] == found["total"] > 0


def new(**options: Any) -> HouseholdTaskset:
    try:
        eai.open("behavior", "action_sequencing")
    except DataError as error:
        pytest.skip(f"the data set cannot be had: {error}")
    options = {"domain": "behavior", "generated": True, "tier": "S", **options}
    return HouseholdTaskset(HouseholdConfig.model_validate(options))


def test_new_tasks_never_end_and_are_the_same_for_equal_seeds() -> None:
    assert not new().bounded
    asked = ("train", "train", "test")
    first, again, other = ([task.data for task in islice(new(split=split), 3)] for split in asked)
    assert first == again
    assert len({data.task for data in (*first, *other)}) == 6
    goals = [
        {json.loads(data.line or "")["about"]["goals_fingerprint"] for data in each}
        for each in (first, other)
    ]
    assert goals[0].isdisjoint(goals[1])
    assert all(data.prompt and data.line for data in first)


def test_a_new_task_is_all_there_is_to_know_of_it() -> None:
    """A worker process knows only the task's data."""
    (task,) = new().take(1)
    there = HouseholdTask(type(task.data).model_validate_json(task.data.model_dump_json()), task.config)
    assert task.data.line is not None
    suite = make_single_task_suite(task.data.line, Ability.ACTION_SEQUENCING)
    whole = suite.tasks[suite.task_ids[0]]
    plan = suite.benchmark.notation.plans.join(
        suite.benchmark.notation.plans.write(whole.script, whole.scene)
    )
    assert json.loads(task.data.line)["plan"]
    assert (there.grade(plan).value, there.grade("").value) == (1, 0)


def test_new_tasks_are_played_step_by_step_too() -> None:
    config = new().config.model_dump(exclude={"task"})
    (task,) = StepsTaskset(StepsConfig.model_validate(config)).take(1)
    assert task.data.prompt == task.start_game().write_manual_and_first_observation()
