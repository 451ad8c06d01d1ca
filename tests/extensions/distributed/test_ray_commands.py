"""Commands and rewards on a cluster: results equal those of one process, also if an actor is killed."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from typing import Any

import pytest

import eai as package
from by_path import ROOT
from command_line import Command
from eai.agents.rewards import TrlReward
from eai.base.store import DataPackStore
from eai.benchmarks.gold_answers import open_gold_answers
from eai.benchmarks.registry import find_benchmark
from eai.results.batch import Scoring

ray = pytest.importorskip("ray", reason="Ray is not installed")
writer = pytest.importorskip("eai.extensions.questions.writer", reason="there are no questions")

from ray.cluster_utils import Cluster  # noqa: E402 - needs it

from eai.extensions.distributed.ray_scoring import RayScoring  # noqa: E402 - needs it

NODE = {"num_cpus": 2, "object_store_memory": 80_000_000, "include_dashboard": False}

QUESTIONS = ("export", "questions", "--domain", "lamps:lamps", "--n", "40")

COMMAND_ON_NEW_CLUSTER = f"""
import os
from ray.cluster_utils import Cluster
from eai.cli import main

cluster = Cluster(initialize_head=True, head_node_args={NODE})
os.environ["RAY_ADDRESS"] = cluster.address
try:
    main()
finally:
    cluster.shutdown()
"""
"""Program that runs a command while a cluster runs, which ``auto`` finds."""


@pytest.fixture(scope="module")
def address(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """A cluster whose processes run in another folder than the commands."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path_factory.mktemp("node"))
        cluster: Any = Cluster(initialize_head=True, head_node_args=NODE)
        yield cluster.address
        cluster.shutdown()


@pytest.fixture(autouse=True)
def beside_lamps(monkeypatch: pytest.MonkeyPatch) -> None:
    """Enter the folder of the example benchmark, which ``lamps:lamps`` names."""
    monkeypatch.chdir(ROOT / "examples" / "lamps")


def kill_first_actor(scoring: RayScoring) -> None:
    actor: Any = scoring._workers[0].connection
    ray.kill(actor._actor)


def test_questions_have_the_bytes_of_one_process(address: str, eai: Command, tmp_path: Path) -> None:
    files = tmp_path / "one.jsonl", tmp_path / "ray.jsonl"
    for file, where in zip(files, ((), ("--ray", address)), strict=True):
        outcome = eai(*QUESTIONS, "--out", file, *where)
        assert outcome.status == 0, outcome.err
    assert files[0].read_bytes() == files[1].read_bytes() != b""


def test_a_cluster_with_a_token_is_found(eai: Command, tmp_path: Path) -> None:
    """Ray reads the environment when it is imported, hence another process."""
    files = tmp_path / "one.jsonl", tmp_path / "ray.jsonl"
    assert eai(*QUESTIONS, "--out", files[0]).status == 0
    token = {"RAY_AUTH_MODE": "token", "RAY_AUTH_TOKEN": "0123456789abcdef" * 3}
    arguments = [*QUESTIONS, "--out", str(files[1]), "--ray", "auto"]
    subprocess.run(
        [sys.executable, "-c", COMMAND_ON_NEW_CLUSTER, *arguments], env={**os.environ, **token}, check=True
    )
    assert files[0].read_bytes() == files[1].read_bytes() != b""


def test_a_check_finds_the_mistakes_that_one_process_finds(
    address: str, eai: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert eai("export", "tasks", "--domain", "lamps:lamps", "--out", tmp_path / "t.jsonl").status == 0
    shutil.copy("lamps.py", tmp_path)
    monkeypatch.chdir(tmp_path)
    Path("t.jsonl").write_text(Path("t.jsonl").read_text().replace("(lit(x))", "(not lit(x))"))
    alone, on_cluster = eai("check", "t.jsonl"), eai("check", "t.jsonl", "--ray", address)
    assert "line 1: goals: expected a goal that does not hold at the start" in alone.out
    assert (on_cluster.status, on_cluster.out) == (alone.status, alone.out)


def test_an_actor_that_is_killed_loses_and_doubles_no_question(address: str) -> None:
    number = 2 * len(writer.QuestionKind) * len(writer.QuestionForm) + 5  # five in a second round
    generator = writer.QuestionGenerator(find_benchmark("lamps:lamps"))
    with RayScoring(address) as scoring:
        questions = generator.write_questions(number=number, seed=1, pool=scoring)
        written = list(islice(questions, 1))
        kill_first_actor(scoring)
        written += questions
    assert written == list(generator.write_questions(number=number, seed=1))


def test_an_actor_that_is_killed_loses_and_doubles_no_reward(address: str, data_store: DataPackStore) -> None:
    suite = package.open("virtualhome", "action_sequencing", source=package.Source(data_store))
    book = open_gold_answers(suite.benchmark, suite.ability)
    answers = [(task_id, text) for task_id in suite.task_ids[:40] for text in (book[task_id].text, "no plan")]
    reward = package.Reward(suite, "progress")
    completions = [text for _, text in answers]
    tasks = [suite.reference(task_id) for task_id, _ in answers]
    with RayScoring(address) as scoring:
        rewards = scoring.compute_rewards(reward, iter(answers))
        paid = list(islice(rewards, 1))
        kill_first_actor(scoring)
        paid += rewards
        assert TrlReward("progress", scoring)(completions=completions, task=tasks) == paid
    assert paid == list(Scoring().compute_rewards(reward, answers))
