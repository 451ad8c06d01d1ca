"""Write and read journals of episodes. The seals show if an agent outside this process changed a journal.

Each line of a journal has a seal and a JSON object. The first object has the task and the setting. Each
further object has the command of a turn and the digest of its observation. The last object has the reason for
the end. A seal is an HMAC-SHA256 over the previous seal and this object, by a key that the agent cannot read.
A line is on the disk before its observation is sent. So no agent has read the observation of an incomplete
last line, and readers leave the line out.
"""

from __future__ import annotations

import hmac
import json
import os
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from secrets import token_bytes
from typing import Any

from eai.agents.play import RecordedGame
from eai.base.errors import InputError
from eai.base.files import read_content
from eai.tasks.source import compute_task_sha256

_KEY_BYTES = 32


def read_key_that_seals_journals(folder: Path) -> bytes:
    """Return the key that seals the journals in a folder. If there is no key, make a random one.

    A journal is a file of an episode's commands. Only the owner of the key's file can read it.

    Raises:
        InputError: the key cannot be read or written.
    """
    path = folder / "key"
    try:
        if not path.exists():
            part = folder / ".key.part"
            part.touch(0o600)
            part.write_bytes(token_bytes(_KEY_BYTES))
            part.chmod(0o400)
            part.replace(path)
        key = path.read_bytes()
    except OSError as error:
        raise InputError(f"{path}: cannot be read or written ({error.strerror})") from error
    if len(key) != _KEY_BYTES:
        raise InputError(
            f"{path}: expected the key that seals the journals of this folder ({_KEY_BYTES} bytes), found "
            f"{len(key)} bytes; give another folder"
        )
    return key


@dataclass(frozen=True, slots=True)
class _JournalContent:
    """The content of those lines of a journal that have valid seals (keyed digests, which show changes).

    Attributes:
        begin: the JSON object of the first line, with the task and the setting.
        turns: the JSON objects of the turns, in order.
        ended: the reason for the end of the episode; None if the journal has no final line.
        seal: the last seal.
        size: size of the complete lines, in bytes.
    """

    begin: Mapping[str, Any]
    turns: tuple[Mapping[str, str], ...] = ()
    ended: str | None = None
    seal: str = ""
    size: int = 0


def has_begun_episode(path: Path) -> bool:
    """Whether the episode of a journal (file of commands) has begun: the file has a complete line."""
    return path.exists() and b"\n" in path.read_bytes()


def read_journal(
    path: Path, seal_key: bytes, expected_game: RecordedGame | None = None, *, must_be_ended: bool = True
) -> str:
    """Return a journal's episode as a text in the format of answers to the ability ``acting``.

    Args:
        path: the file of the journal.
        seal_key: the key that signed each line, so that changes of the file are noticed.
        expected_game: a new episode with the expected task and setting; None to accept any episode.
        must_be_ended: whether the episode must have ended.

    Raises:
        InputError: the file cannot be read or is a link, a seal is wrong, a line is missing, or the episode
            is not the expected one.
    """
    journal = _read_journal_content(path, seal_key, expected_game)
    if must_be_ended and journal.ended is None:
        raise InputError(f"{path}: no final line: the episode was interrupted; play it to its end")
    about = {name: value for name, value in journal.begin.items() if name not in ("task", "task_sha256")}
    whole = {**about, "turns": journal.turns, "ended": journal.ended or "stopped"}
    return json.dumps(whole, ensure_ascii=False)


def _read_journal_content(path: Path, seal_key: bytes, expected_game: RecordedGame | None) -> _JournalContent:
    journal = _JournalContent({})
    if os.path.islink(path):  # noqa: PTH114 - Path.is_symlink may raise
        raise InputError(f"{path}: expected a file, not a link")
    for number, raw in enumerate(read_content(path).split(b"\n")[:-1], 1):
        try:
            journal = _add_sealed_line(journal, raw, seal_key)
        except ValueError as error:
            raise InputError(f"{path}, line {number}: not a line of this journal: {error}") from error
    if not journal.begin:
        raise InputError(f"{path}: no line begins an episode; play the episode again in a new folder")
    if expected_game is not None and journal.begin != _make_journal_header(expected_game):
        raise InputError(
            f"{path}: the episode is of another task or other agent options; give another folder"
        )
    return journal


def _make_journal_header(game: RecordedGame) -> dict[str, Any]:
    """Return the JSON object of a journal's first line.

    It has the task's id and digest, and all fields of the episode except its turns and end.
    """
    about = game.to_json("stopped")
    task = game.task
    del about["turns"], about["ended"]
    return {"task": task.id, "task_sha256": compute_task_sha256(task), **about}


def _add_sealed_line(journal: _JournalContent, line: bytes, seal_key: bytes) -> _JournalContent:
    seal, _, body = line.partition(b" ")
    if not hmac.compare_digest(seal, _compute_seal(seal_key, journal.seal, body).encode()):
        raise ValueError("wrong seal: the line was changed or moved; play the episode again in a new folder")
    journal = replace(journal, seal=seal.decode(), size=journal.size + len(line) + 1)
    match json.loads(body):
        case {"begin": dict(begin)} if not journal.begin:
            return replace(journal, begin=begin)
        case {"act": {"said": str(), "told": str()} as turn} if journal.begin and journal.ended is None:
            return replace(journal, turns=(*journal.turns, turn))
        case {"end": str(why)} if journal.begin and journal.ended is None:
            return replace(journal, ended=why)
    raise ValueError(
        "expected a first line with begin, then lines with act, then a line with end; "
        "play the episode again in a new folder"
    )


class EpisodeJournal:
    """The journal of an unfinished episode, to which each turn is added. The caller closes the journal.

    No other process may write the file, as `eai.base.files.lock_run_folder` makes sure.

    Args:
        path: the file of the journal; turns that it contains are played again.
        key: the secret key of the seals. A seal is a keyed digest of a line, and shows changes of the file.
        play: the episode, before its first turn.

    Attributes:
        ended: why the episode has ended; None if it has not.

    Raises:
        InputError: the file cannot be read or written, a seal is wrong, or the episode is not the expected
            one.
    """

    def __init__(self, path: Path, key: bytes, play: RecordedGame) -> None:
        self.ended: str | None = None
        self._path, self._key, self._seal = path, key, ""
        self._written = 0
        try:
            size = self._replay_turns_and_get_journal_size(play) if has_begun_episode(path) else 0
            path.touch(0o600)
            self._file = path.open("ab")
            self._file.truncate(size)
        except OSError as error:
            raise InputError(f"{path}: cannot be read or written ({error.strerror})") from error
        if not size:
            self._append_line({"begin": _make_journal_header(play)})
        self.write_turns(play)

    def _replay_turns_and_get_journal_size(self, game: RecordedGame) -> int:
        """Play the turns in the journal's file again. Return the size of the complete lines, in bytes."""
        before = _read_journal_content(self._path, self._key, game)
        for turn in before.turns:
            game.play_command(turn["said"])
        if [*before.turns] != game.to_json("stopped")["turns"]:
            raise InputError(
                f"{self._path}: a replay of the journal's commands gives other observations than the journal "
                "has, since eai or the data has changed; give another folder"
            )
        self._seal, self.ended, self._written = before.seal, before.ended, len(before.turns)
        return before.size

    def write_turns(self, game: RecordedGame) -> None:
        """Write all turns that are not on disk yet, and the end of the episode if it is over.

        Raises:
            InputError: the file cannot be written, or the episode has ended before these turns.
        """
        turns = game.turns[self._written :]
        if turns and self.ended is not None:
            raise InputError(f"{self._path}: the episode is over: no turn can follow")
        for turn in turns:
            self._append_line({"act": {"said": turn.said, "told": turn.told}})
        self._written = len(game.turns)
        if game.ended is not None:
            self.write_end(game.ended)

    def write_end(self, reason: str = "stopped") -> None:
        """Write that the episode has ended, if the journal does not state an end yet.

        Raises:
            InputError: the file cannot be written.
        """
        if self.ended is None:
            self._append_line({"end": reason})
            self.ended = reason

    def close(self) -> None:
        """Close the journal's file."""
        self._file.close()

    def _append_line(self, line: Mapping[str, object]) -> None:
        body = json.dumps(line).encode()
        seal = _compute_seal(self._key, self._seal, body)
        try:
            self._file.write(f"{seal} ".encode() + body + b"\n")
            self._file.flush()
            os.fsync(self._file.fileno())
        except (OSError, ValueError) as error:
            # After an error the content of the file is unknown, so a new journal must read it from disk.
            with suppress(OSError):
                self._file.close()
            raise InputError(f"{self._path}: cannot be written ({error})") from error
        self._seal = seal


def _compute_seal(seal_key: bytes, previous_seal: str, content: bytes) -> str:
    return hmac.new(seal_key, previous_seal.encode() + content, "sha256").hexdigest()
