"""Score the answer that an agent left in the container of a Harbor task.

``python -m eai.extensions.harbor.verify BENCHMARK/ABILITY/TASK`` runs in the verifier's container and prints
rewards as Harbor reads them.
"""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path

from eai.abilities.declaration import AnswerOutcome, get_declaration
from eai.abilities.verdict import RAISED, UNREPLAYABLE, Verdict
from eai.agents.episode_server import HARNESS, find_journal_path
from eai.agents.journal import read_journal, read_key_that_seals_journals
from eai.agents.play import EpisodeFactory, RecordedGame
from eai.agents.setting import STANDARD
from eai.base.errors import InputError
from eai.benchmarks.names import TaskReference
from eai.benchmarks.suite import Suite, open_suite
from eai.results.reward import MAX_ANSWER_CHARACTERS
from eai.results.summary import compute_metric_rates

ANSWER = Path("/workdir/answer.txt")
"""Path of the file with the agent's answer."""

JOURNAL_FOLDER = Path("/journal")
"""Folder of the journals (lists of actions) of episodes.

The server on which an agent acts in a simulated world writes them.
"""


def is_right_answer(suite: Suite, verdict: Verdict) -> bool:
    """Whether an answer is right and its task is not excluded."""
    outcome = get_declaration(suite.ability).outcome(verdict)
    return verdict.excluded is None and outcome is AnswerOutcome.SUCCESS


def compute_rewards(suite: Suite, task_id: str, text: str) -> dict[str, float]:
    """Return the rewards of an answer by name.

    ``reward`` is 1 for a right answer, else 0. Further rewards are the answer's values, from 0 to 1, of the
    main metrics of the ability. A metric that is undefined for the answer is left out. ``valid`` is 1. If an
    episode cannot be replayed, or the scorer raises an error, ``valid`` is 0 and the other rewards are those
    of an empty answer.
    """
    verdict = suite.score(task_id, text)
    if verdict.excluded is not None:
        return _make_rewards_of_invalid_answer(suite, task_id, verdict.excluded)
    if verdict.error is not None and verdict.error.check in (UNREPLAYABLE, RAISED):
        return _make_rewards_of_invalid_answer(suite, task_id, verdict.error.detail)
    return {**_compute_reward_and_rates(suite, verdict), "valid": 1.0}


def _make_rewards_of_invalid_answer(suite: Suite, task_id: str, reason: str) -> dict[str, float]:
    print(reason, file=sys.stderr)
    return {**_compute_reward_and_rates(suite, suite.score(task_id, "")), "valid": 0.0}


def _compute_reward_and_rates(suite: Suite, verdict: Verdict) -> dict[str, float]:
    rates = compute_metric_rates([verdict], suite.ability)
    shares = {name: rates[name].share for name in get_declaration(suite.ability).overview_headings}
    rated = {name: float(share) for name, share in shares.items() if share is not None}
    return {"reward": float(is_right_answer(suite, verdict)), **rated}


def read_answer(file: Path) -> str:
    """Return the answer in a file, or an empty text if the file is missing or too long for a reward."""
    if not file.is_file():
        return ""
    with file.open(encoding="utf-8", errors="replace") as opened:
        text = opened.read(MAX_ANSWER_CHARACTERS + 1)
    return text if len(text) <= MAX_ANSWER_CHARACTERS else ""


def read_text_of_ended_episode(folder: Path, suite: Suite, task_id: str) -> str:
    """Return the text of a task's episode from a folder of journals; empty if no action was taken.

    Raises:
        InputError: The episode has not ended, was changed, or belongs to another task or setting.
    """
    path = find_journal_path(folder, (task_id, 1))
    if not os.path.lexists(path):
        return ""
    setup = EpisodeFactory(suite.benchmark).make_setup(suite.tasks[task_id])
    return read_journal(
        path,
        read_key_that_seals_journals(folder),
        RecordedGame(setup, STANDARD.slip_seed, epoch=1, harness=HARNESS),
    )


def compute_episode_rewards(suite: Suite, task_id: str, folder: Path) -> dict[str, float]:
    """Return the rewards of an episode by name; those of an empty answer if the episode's file is invalid."""
    try:
        return compute_rewards(suite, task_id, read_text_of_ended_episode(folder, suite, task_id))
    except InputError as error:
        return _make_rewards_of_invalid_answer(suite, task_id, str(error))


def main() -> None:
    """Print the rewards of an answer to the task that the command line names."""
    task = TaskReference.parse(sys.argv[1])
    suite = open_suite(task.benchmark, task.ability)
    if get_declaration(task.ability).takes_turns:
        rewards = compute_episode_rewards(suite, task.task_id, JOURNAL_FOLDER)
    else:
        rewards = compute_rewards(suite, task.task_id, read_answer(ANSWER))
    print(json.dumps(rewards))


if __name__ == "__main__":
    main()
