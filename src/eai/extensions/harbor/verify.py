"""Scores what an agent left behind in a task of Harbor's; runs where the verifier does.

``python -m eai.extensions.harbor.verify BENCHMARK/ABILITY/TASK`` prints the rewards as Harbor reads them.
"""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path

from eai.abilities.declaration import AnswerOutcome, declaration_of
from eai.abilities.verdict import RAISED, UNREPLAYABLE, Verdict
from eai.agents.journal import key_in, read_journal
from eai.agents.play import Arena, Play
from eai.agents.setting import STANDARD
from eai.agents.worlds import HARNESS, journal_in
from eai.base.errors import InputError
from eai.benchmarks.names import TaskReference
from eai.benchmarks.suite import Suite, open_suite
from eai.results.reward import MAX_ANSWER_CHARACTERS
from eai.results.summary import summarise

ANSWER = Path("/workdir/answer.txt")
"""The file in which an agent leaves its answer."""

WORLD = Path("/journal")
"""The folder in which a world leaves the journal of an episode."""


def is_right(suite: Suite, verdict: Verdict) -> bool:
    """Whether a verdict is on a right answer to a task that counts."""
    outcome = declaration_of(suite.ability).outcome(verdict)
    return verdict.excluded is None and outcome is AnswerOutcome.SUCCESS


def rewards(suite: Suite, task_id: str, text: str) -> dict[str, float]:
    """The rewards of an answer: 1 or 0, and beside it the main rates of the ability, from 0 to 1.

    A rate that the answer adds nothing to is left out. An episode that does not replay, or an answer whose
    scorer raises, has the rewards of an empty answer, and 0 for ``valid``.
    """
    verdict = suite.score(task_id, text)
    if verdict.excluded is not None:
        return _invalid(suite, task_id, verdict.excluded)
    if verdict.error is not None and verdict.error.check in (UNREPLAYABLE, RAISED):
        return _invalid(suite, task_id, verdict.error.detail)
    return {**_shares(suite, verdict), "valid": 1.0}


def _invalid(suite: Suite, task_id: str, reason: str) -> dict[str, float]:
    print(reason, file=sys.stderr)
    return {**_shares(suite, suite.score(task_id, "")), "valid": 0.0}


def _shares(suite: Suite, verdict: Verdict) -> dict[str, float]:
    rates = summarise([verdict], suite.ability)
    shares = {name: rates[name].share for name in declaration_of(suite.ability).overview_headings}
    known = {name: float(share) for name, share in shares.items() if share is not None}
    return {"reward": float(is_right(suite, verdict)), **known}


def answer_in(file: Path) -> str:
    """The answer in a file: nothing where there is none, or where it is longer than what is rewarded."""
    if not file.is_file():
        return ""
    with file.open(encoding="utf-8", errors="replace") as opened:
        text = opened.read(MAX_ANSWER_CHARACTERS + 1)
    return text if len(text) <= MAX_ANSWER_CHARACTERS else ""


def episode_in(folder: Path, suite: Suite, task_id: str) -> str:
    """The episode of a task in the folder of its world, as an answer; nothing if it was not begun.

    Raises:
        InputError: it has not ended, was changed, or is of another task or setting.
    """
    path = journal_in(folder, (task_id, 1))
    if not os.path.lexists(path):
        return ""
    stage = Arena(suite.benchmark).stage(suite.tasks[task_id])
    return read_journal(path, key_in(folder), Play(stage, STANDARD.slip_seed, epoch=1, harness=HARNESS))


def rewards_of_episode(suite: Suite, task_id: str, folder: Path) -> dict[str, float]:
    """The rewards of the episode in the folder of its world; those of nothing if it cannot be believed."""
    try:
        return rewards(suite, task_id, episode_in(folder, suite, task_id))
    except InputError as error:
        return _invalid(suite, task_id, str(error))


def main() -> None:
    """Print the rewards of what was left behind in the task that the command line names."""
    task = TaskReference.parse(sys.argv[1])
    suite = open_suite(task.benchmark, task.ability)
    if declaration_of(task.ability).takes_turns:
        found = rewards_of_episode(suite, task.task_id, WORLD)
    else:
        found = rewards(suite, task.task_id, answer_in(ANSWER))
    print(json.dumps(found))


if __name__ == "__main__":
    main()
