from __future__ import annotations

import hmac
import json
import shutil
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest

from agents.switches import DOMAIN, initial
from by_path import ROOT
from eai import Benchmark, make_task, use_tasks
from eai.abilities.protocol import Ability
from eai.agents.episode_server import find_journal_path, open_episode_server
from eai.agents.journal import read_key_that_seals_journals
from eai.benchmarks.gold_answers import open_gold_answers
from eai.benchmarks.suite import Suite, open_suite
from eai.extensions.harbor.verify import compute_episode_rewards, compute_rewards, read_answer
from eai.logic.formula import Atom, Constant, Not
from eai.results.reward import MAX_ANSWER_CHARACTERS
from raising import BOOM, NAME, RAISING

GO, PRESS = "GO(lamp_1)", "PRESS(lamp_1)"
PLAN = ["GO(lamp_1)", "PRESS(lamp_1)", "GO(lamp_2)", "PRESS(lamp_2)", "DONE"]
LIGHT = ("light", 1)


@pytest.fixture
def suite(monkeypatch: pytest.MonkeyPatch) -> Suite:
    monkeypatch.syspath_prepend(ROOT / "examples" / "lamps")
    return open_suite("lamps:lamps", Ability("acting"))


def world(
    suite: Suite, folder: Path, commands: Sequence[str], *, task_id: str = "light", ended: bool = True
) -> Path:
    """The folder that the world of a task leaves, in which an agent said so."""
    with open_episode_server(folder, suite, [(task_id, 1)]) as worlds:
        for command in commands:
            worlds.play_command((task_id, 1), command)
        if ended:
            worlds.end_episodes()
    return folder


@pytest.mark.parametrize(
    ("commands", "won"),
    [
        (PLAN, True),
        ([], False),
        (["DONE"], False),
        (PLAN[:-1], False),
        (["DONE", *PLAN], False),
        (["\n".join(PLAN)], False),
        ([f"[{', '.join(PLAN)}]", "DONE"], False),
        (["GO(robot)"] * 40 + PLAN, False),
        (["(" * 2_000, "DONE"], False),
    ],
    ids=["plan", "nothing", "done", "silent", "late", "lines", "list", "spent", "junk"],
)
def test_an_episode_is_won_by_acting_alone(
    commands: list[str], won: bool, suite: Suite, tmp_path: Path
) -> None:
    found = compute_episode_rewards(suite, "light", world(suite, tmp_path / "journal", commands))
    assert (found["reward"], found["success"], found["valid"]) == (won, won, 1)


Lines = list[dict[str, Any]]


def sealed(lines: Lines, key: bytes) -> bytes:
    """Lines as a world seals them."""
    seal, content = "", b""
    for line in lines:
        body = json.dumps(line).encode()
        seal = hmac.new(key, seal.encode() + body, "sha256").hexdigest()
        content += f"{seal} ".encode() + body + b"\n"
    return content


def otherwise(line: dict[str, Any], **values: Any) -> dict[str, Any]:
    ((name, content),) = line.items()
    return {name: {**content, **values}}


def no_turns(lines: Lines, key: bytes) -> bytes:
    return sealed([lines[0], lines[-1]], key)


@pytest.mark.parametrize(
    "forged",
    [
        lambda lines, key: sealed(lines, b"x" * 32),
        no_turns,
        lambda lines, key: sealed(lines[:-1], key),
        lambda lines, key: sealed(
            [lines[0], *[otherwise(each, told="0" * 64) for each in lines[1:-1]], lines[-1]], key
        ),
        lambda lines, key: sealed(
            [otherwise(lines[0], rules={**lines[0]["begin"]["rules"], "steps": 999}), *lines[1:]], key
        ),
        lambda lines, key: sealed([otherwise(lines[0], task="pack"), *lines[1:]], key),
        lambda lines, key: sealed(lines, key).replace(b"GO(lamp_1)", b"GO(lamp_2)"),
        lambda lines, key: b"\n".join(
            sealed(lines, key).split(b"\n")[:2] + sealed(lines, key).split(b"\n")[3:]
        ),
        lambda lines, key: b"\xff\n\0",
    ],
    ids=["key", "no turns", "no end", "observations", "rules", "task", "byte", "line", "bytes"],
)
def test_a_forged_journal_is_worth_nothing(
    forged: Callable[[Lines, bytes], bytes], suite: Suite, tmp_path: Path
) -> None:
    """Most are sealed with the right key, which no agent can read."""
    folder = world(suite, tmp_path / "journal", PLAN)
    path, key = find_journal_path(folder, LIGHT), read_key_that_seals_journals(folder)
    lines = [json.loads(line.partition(b" ")[2]) for line in path.read_bytes().splitlines()]
    path.write_bytes(sealed(lines, key))
    assert compute_episode_rewards(suite, "light", folder)["reward"] == 1
    path.write_bytes(forged(lines, key))
    found = compute_episode_rewards(suite, "light", folder)
    assert (found["reward"], found["success"], found["valid"]) == (0, 0, forged is no_turns)


def test_a_journal_of_another_task_or_a_link_is_worth_nothing(suite: Suite, tmp_path: Path) -> None:
    won, lost = world(suite, tmp_path / "won", PLAN), world(suite, tmp_path / "lost", [], task_id="pack")
    path = find_journal_path(lost, ("pack", 1))
    path.parent.mkdir(parents=True)
    (lost / "key").unlink()
    shutil.copy(won / "key", lost / "key")
    shutil.copy(find_journal_path(won, LIGHT), path)
    assert compute_episode_rewards(suite, "pack", lost)["valid"] == 0
    path.unlink()
    path.symlink_to(find_journal_path(won, LIGHT))
    assert compute_episode_rewards(suite, "pack", lost)["valid"] == 0


@pytest.mark.parametrize(
    ("content", "read"),
    [
        (b"right", "right"),
        (b"\xff", "\ufffd"),
        (b"a" * MAX_ANSWER_CHARACTERS, "a" * MAX_ANSWER_CHARACTERS),
        (b"a" * (MAX_ANSWER_CHARACTERS + 1), ""),
    ],
)
def test_an_answer_is_read_up_to_a_limit(content: bytes, read: str, tmp_path: Path) -> None:
    (tmp_path / "answer.txt").write_bytes(content)
    assert read_answer(tmp_path / "answer.txt") == read


def test_no_file_is_no_answer(tmp_path: Path) -> None:
    assert read_answer(tmp_path / "answer.txt") == read_answer(tmp_path) == ""


def test_a_task_that_excludes_whatever_is_said_pays_nothing() -> None:
    shut = Atom("shut", (Constant("box"),))
    both = make_task("both", "Have it both ways.", initial(), shut, Not(shut))
    suite = open_suite(Benchmark("both", DOMAIN, use_tasks(both)), Ability("acting"))
    assert compute_rewards(suite, "both", "DONE") == {"reward": 0.0, "valid": 0.0}


def test_an_answer_whose_scorer_raises_is_worth_nothing() -> None:
    suite = open_suite(NAME, Ability("action_sequencing"))
    gold = open_gold_answers(RAISING, suite.ability, suite.source)
    assert compute_rewards(suite, "both", BOOM)["valid"] == 0
    assert compute_rewards(suite, "both", gold["both"].text)["reward"] == 1
