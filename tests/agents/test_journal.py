"""Sealed journals: they replay and are scored, changes are refused, and torn lines are cut off."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path

import pytest

from agents.switches import SWITCHES
from eai.agents.journal import EpisodeJournal, read_journal, read_key_that_seals_journals
from eai.agents.play import OVER, EpisodeFactory, RecordedGame
from eai.agents.setting import ACTING, AgentSetting
from eai.agents.verdict import EpisodeVerdict
from eai.base.errors import InputError
from eai.benchmarks.suite import open_suite
from eai.results.codec import hash_text

SUITE = open_suite(SWITCHES, ACTING)
TASK = SUITE.tasks[SUITE.task_ids[0]]
ARENA = EpisodeFactory(SWITCHES)
WINNING = [*(ARENA.make_setup(TASK).reference.commands or ()), "DONE"]


def beginning(setting: AgentSetting | None = None) -> RecordedGame:
    return EpisodeFactory(SWITCHES, setting or AgentSetting()).begin_episode(TASK)


@contextmanager
def resumed(folder: Path) -> Iterator[tuple[EpisodeJournal, Callable[[str], str]]]:
    """Yield the journal in a folder, and a function that carries out a command and writes the turn."""
    play = beginning()
    with closing(EpisodeJournal(folder / "episode", read_key_that_seals_journals(folder), play)) as journal:

        def act(command: str) -> str:
            told = play.play_command(command)
            journal.write_turns(play)
            return told

        yield journal, act


def journal_of(folder: Path, commands: list[str]) -> tuple[Path, bytes]:
    with resumed(folder) as (_, act):
        for command in commands:
            act(command)
    return folder / "episode", read_key_that_seals_journals(folder)


def verdict_of(path: Path, key: bytes) -> EpisodeVerdict:
    verdict = SUITE.score(TASK.id, read_journal(path, key, beginning()))
    assert isinstance(verdict, EpisodeVerdict)
    return verdict


def test_a_journal_is_an_answer(tmp_path: Path) -> None:
    path, key = journal_of(tmp_path, WINNING)
    play = beginning()
    for command in WINNING:
        play.play_command(command)
    assert json.loads(read_journal(path, key)) == json.loads(play.write_as_json_text("stopped"))
    assert verdict_of(path, key).success
    assert (path.stat().st_mode & 0o777, (tmp_path / "key").stat().st_mode & 0o777) == (0o600, 0o400)


def test_the_last_observation_does_not_reveal_a_win(tmp_path: Path) -> None:
    with resumed(tmp_path) as (_, act):
        told = [act(command) for command in WINNING]
        assert [line for text in told for line in text.splitlines() if "goals" in line.lower()] == []
        assert told[-1].splitlines()[-1] == act("DONE") == act("LOOK") == OVER


def test_an_episode_goes_on_and_never_begins_anew(tmp_path: Path) -> None:
    path, key = journal_of(tmp_path, WINNING[:1])
    with pytest.raises(InputError, match="no final line"):
        read_journal(path, key)
    with path.open("ab") as file:  # a torn line
        file.write(path.read_bytes()[:40])
    journal_of(tmp_path, WINNING[1:])
    assert verdict_of(path, key).success
    whole = path.read_bytes()
    journal_of(tmp_path, WINNING)
    assert path.read_bytes() == whole


def test_an_end_that_was_lost_is_written_again(tmp_path: Path) -> None:
    path, _ = journal_of(tmp_path, WINNING)
    whole = path.read_bytes()
    path.write_bytes(whole[: whole[:-1].rindex(b"\n") + 1])
    journal_of(tmp_path, [])
    assert path.read_bytes() == whole


def test_an_episode_that_is_stopped_is_over(tmp_path: Path) -> None:
    path, key = tmp_path / "episode", read_key_that_seals_journals(tmp_path)
    with resumed(tmp_path) as (journal, act):
        act(WINNING[0])
        journal.write_end()
        with pytest.raises(InputError, match="the episode is over"):
            act(WINNING[1])
    assert len(verdict_of(path, key).turns) == 1
    assert (verdict_of(path, key).success, verdict_of(path, key).ended) == (False, "stopped")


def test_a_turn_that_cannot_be_written_returns_no_observation(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(file: int) -> None:
        raise OSError(28, "No space left on device")

    path, key = tmp_path / "episode", read_key_that_seals_journals(tmp_path)
    with resumed(tmp_path) as (_, act):
        act(WINNING[0])
        with monkeypatch.context() as full:
            full.setattr(os, "fsync", fail)
            with pytest.raises(InputError, match="No space left"):
                act(WINNING[1])
        with pytest.raises(
            InputError, match="cannot be written"
        ):  # the failed write may have changed the file
            act(WINNING[2])
    journal_of(tmp_path, WINNING[2:])
    assert [turn.said for turn in verdict_of(path, key).turns] == WINNING
    assert verdict_of(path, key).success


def test_another_task_setting_or_key_is_refused(tmp_path: Path) -> None:
    path, key = journal_of(tmp_path, WINNING)
    with pytest.raises(InputError, match="of another task or other agent options"):
        read_journal(path, key, beginning(AgentSetting(budget=4)))
    with pytest.raises(InputError, match="of another task or other agent options"):
        EpisodeJournal(path, key, beginning(AgentSetting(budget=4)))
    with pytest.raises(InputError, match="line 1: not a line of this journal: wrong seal"):
        read_journal(path, b"x" * 32)


def without_a_line(lines: list[bytes]) -> list[bytes]:
    return [*lines[:1], *lines[2:]]


def twice(lines: list[bytes]) -> list[bytes]:
    return [*lines, *lines]


def other_order(lines: list[bytes]) -> list[bytes]:
    return [lines[0], lines[2], lines[1], *lines[3:]]


def one_byte(lines: list[bytes]) -> list[bytes]:
    return [lines[0], lines[1].replace(b'"said": "', b'"said": " '), *lines[2:]]


@pytest.mark.parametrize("change", [without_a_line, twice, other_order, one_byte])
def test_a_changed_journal_is_refused(tmp_path: Path, change: Callable[[list[bytes]], list[bytes]]) -> None:
    path, key = journal_of(tmp_path, WINNING)
    path.write_bytes(b"".join(change(path.read_bytes().splitlines(keepends=True))))
    with pytest.raises(InputError, match="seal"):
        read_journal(path, key)


def test_a_journal_without_its_end_or_by_a_link_is_refused(tmp_path: Path) -> None:
    path, key = journal_of(tmp_path, WINNING)
    link = tmp_path / "link"
    link.symlink_to(path)
    with pytest.raises(InputError, match="not a link"):
        read_journal(link, key)
    path.write_bytes(b"")
    with pytest.raises(InputError, match="no line begins an episode"):
        read_journal(path, key)
    with pytest.raises(InputError, match="cannot be read"):
        read_journal(tmp_path / "none", key)


def test_invented_observations_do_not_replay(tmp_path: Path) -> None:
    path, key = tmp_path / "episode", read_key_that_seals_journals(tmp_path)
    with closing(EpisodeJournal(path, key, beginning())) as journal:
        journal._append_line({"act": {"said": WINNING[0], "told": hash_text("won")}})
        journal.write_end("done")
    verdict = verdict_of(path, key)
    assert (verdict.is_unreplayable, verdict.success, verdict.excluded) == (True, False, None)
    with pytest.raises(InputError, match="a replay of the journal's commands gives other observations"):
        EpisodeJournal(path, key, beginning())


KILLED = """
import os, signal, sys
from pathlib import Path
from agents.test_journal import resumed

with resumed(Path(sys.argv[1])) as (_, act):
    for command in sys.argv[2:]:
        print(act(command).splitlines()[0], flush=True)
    os.kill(os.getpid(), signal.SIGKILL)
"""


def test_a_killed_process_loses_no_turn_that_was_observed(tmp_path: Path) -> None:
    for command in WINNING:
        done = subprocess.run(
            [sys.executable, "-c", KILLED, str(tmp_path), command],
            capture_output=True,
            text=True,
            check=False,
            env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
        )
        assert done.returncode == -signal.SIGKILL, done.stderr
    path, key = tmp_path / "episode", read_key_that_seals_journals(tmp_path)
    assert [turn.said for turn in verdict_of(path, key).turns] == WINNING
    assert verdict_of(path, key).success
