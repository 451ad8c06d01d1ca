"""Serve episodes to agents outside of this process.

Each episode has a journal, a file of its commands that reveals tampering.
"""

from __future__ import annotations

import hmac
import json
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from urllib.parse import quote, unquote

from eai.agents.command import LOOK
from eai.agents.journal import EpisodeJournal, has_begun_episode, read_journal, read_key_that_seals_journals
from eai.agents.play import OVER, EpisodeFactory, RecordedGame, read_episode
from eai.agents.setting import STANDARD, AgentSetting
from eai.base.errors import InputError
from eai.base.files import (
    lock_run_folder,
    raise_write_errors_as_input_errors,
    to_file_name,
    write_files_atomically,
)
from eai.base.grouping import group_pairs
from eai.benchmarks.suite import Suite
from eai.results.responses import COLUMNS, LINES
from eai.results.trials import TaskIdAndEpoch
from eai.tasks.prompts.prompt import Image

HARNESS = "mcp"
"""Name in results of this harness (way in which a model acts): an agent in another process, over MCP."""

_EPISODES, _ENDING = "episodes", ".journal"


def find_journal_path(folder: Path, key: TaskIdAndEpoch) -> Path:
    """Return the path of an episode's journal, the file of its commands, in the folder of the server."""
    return folder / _EPISODES / str(key[1]) / f"{quote(key[0], safe='')}{_ENDING}"


@contextmanager
def open_episode_server(
    folder: Path,
    suite: Suite,
    episode_keys: Sequence[TaskIdAndEpoch],
    setting: AgentSetting = STANDARD,
    agent: str = "agent",
) -> Iterator[EpisodeServer]:
    """Yield the server of the episodes in a folder, which no other process can use during the block.

    Raises:
        InputError: another process uses the folder, the folder cannot be used, or it holds episodes of other
            tasks or settings.
    """
    factory = EpisodeFactory(suite.benchmark, setting)
    with suppress(OSError):  # `lock_run_folder` raises if the folder is missing
        folder.mkdir(mode=0o700, parents=True)
    with lock_run_folder(folder):
        server = EpisodeServer(folder, suite, episode_keys, factory, agent)
        try:
            yield server
        finally:
            server.close()


class EpisodeServer:
    """The episodes of tasks, one for each ticket (access token). An episode begins once, with the first call.

    The folder contains a journal (sealed file of commands) of each episode, the key of the seals, and the
    answers for `eai score`. The agent must have no access to the folder.

    Args:
        folder: the folder.
        suite: the tasks.
        episode_keys: the offered episodes: pairs of a task's id and the number of an episode of this task.
        factory: the benchmark and setting of the episodes.
        agent: the name of the agent in the name of the response file.

    Attributes:
        episode_keys: the offered episodes.
        tickets: the episode of each ticket, by the ticket's text.

    Raises:
        InputError: the folder cannot be used, or holds episodes of other tasks or settings.
    """

    def __init__(
        self,
        folder: Path,
        suite: Suite,
        episode_keys: Sequence[TaskIdAndEpoch],
        factory: EpisodeFactory,
        agent: str,
    ) -> None:
        self._folder, self._suite, self._agent = folder, suite, to_file_name(agent)
        self._key = read_key_that_seals_journals(folder)
        self._factory = factory
        self._open: dict[TaskIdAndEpoch, tuple[RecordedGame, EpisodeJournal]] = {}
        self._written: set[TaskIdAndEpoch] = set()
        self.episode_keys = episode_keys
        self.tickets = {self._make_episode_access_token(key): key for key in episode_keys}
        self._write_answers()

    def play_command(self, key: TaskIdAndEpoch, command: str) -> str:
        """Carry out a command in an episode. Return the observation.

        The command `LOOK` before the first action returns the whole question.

        Raises:
            InputError: the folder cannot be written.
        """
        game, journal = self._open_episode(key)
        if journal.ended is not None:
            return OVER
        if command == LOOK and not game.turns:
            return self._factory.make_prompt(game.task).user
        observation = game.play_command(command)
        journal.write_turns(game)  # the turn must be on disk before the agent reads the observation
        if journal.ended is not None and key in self._written:
            self._write_answers()
        elif journal.ended is not None:
            self._append_ended_episode_to_response_file(key)
        return observation

    def draw_pictures_of_current_world(self, key: TaskIdAndEpoch) -> tuple[Image, ...]:
        """Return pictures of an episode's present world (`RecordedGame.draw_pictures_of_current_world`)."""
        return self._open_episode(key)[0].draw_pictures_of_current_world()

    def end_episodes(self) -> None:
        """End all episodes under way.

        Raises:
            InputError: the folder cannot be written.
        """
        for key in self.episode_keys:
            if has_begun_episode(find_journal_path(self._folder, key)):
                self._open_episode(key)[1].write_end()
        self._write_answers()

    def close(self) -> None:
        """Write the answers and close all files. A later server can resume unfinished episodes."""
        for _, journal in self._open.values():
            journal.close()
        self._write_answers()

    def _write_answers(self) -> None:
        """Write each episode that has begun as an answer.

        An unfinished episode counts as stopped by the agent.

        Raises:
            InputError: a journal was changed or has another setting, or the folder cannot be written.
        """
        begun = self._find_begun_episodes()
        write_files_atomically(
            group_pairs(
                (
                    self._get_episode_response_path(episode),
                    self._format_episode_as_response_file_line(episode),
                )
                for episode in begun
            )
        )
        self._written.update(begun)

    def _append_ended_episode_to_response_file(self, key: TaskIdAndEpoch) -> None:
        """Append an episode that has ended to the response file."""
        self._written.add(key)
        with (
            raise_write_errors_as_input_errors(self._get_episode_response_path(key)),
            self._get_episode_response_path(key).open("a", encoding="utf-8") as file,
        ):
            file.write(self._format_episode_as_response_file_line(key))

    def _get_episode_response_path(self, key: TaskIdAndEpoch) -> Path:
        """Return the path of an episode's response file. All tasks' episodes of one epoch share a file."""
        epoch = key[1]
        return self._folder / f"{self._agent}{'' if epoch == 1 else f'-{epoch}'}{LINES}"

    def _format_episode_as_response_file_line(self, key: TaskIdAndEpoch) -> str:
        path = find_journal_path(self._folder, key)
        text = read_journal(path, self._key, must_be_ended=False)
        if getattr(read_episode(text), "rules", None) != self._factory.rules:
            raise InputError(f"{path}: this episode was played with other agent options; give another --out")
        return json.dumps(dict(zip(COLUMNS, (key[0], text), strict=True))) + "\n"

    def _find_begun_episodes(self) -> list[TaskIdAndEpoch]:
        """Return all episodes that have begun in the folder, in the order of the tasks."""
        order = {task_id: number for number, task_id in enumerate(self._suite.task_ids)}
        begun: list[TaskIdAndEpoch] = []
        for path in (self._folder / _EPISODES).glob(f"*/*{_ENDING}"):
            task_id = unquote(path.name.removesuffix(_ENDING))
            if task_id not in order:
                raise InputError(
                    f"{path}: {self._suite.domain} has no task {task_id!r}, so this folder belongs to other "
                    "tasks; give another --out"
                )
            if has_begun_episode(path):
                begun.append((task_id, int(path.parent.name)))
        return sorted(begun, key=lambda key: (key[1], order[key[0]]))

    def _open_episode(self, key: TaskIdAndEpoch) -> tuple[RecordedGame, EpisodeJournal]:
        """Return an episode with its journal (file of commands). Begin the episode if it has not begun."""
        if key not in self._open:
            task_id, epoch = key
            path = find_journal_path(self._folder, key)
            setup = self._factory.make_setup(self._suite.tasks[task_id])
            path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
            game = RecordedGame(setup, self._factory.setting.slip_seed, epoch, harness=HARNESS)
            self._open[key] = game, EpisodeJournal(path, self._key, game)
        return self._open[key]

    def _make_episode_access_token(self, key: TaskIdAndEpoch) -> str:
        """Return the ticket (access token) of an episode. A restart of the server does not change it."""
        return hmac.new(self._key, f"ticket {key[1]} {key[0]}".encode(), "sha256").hexdigest()
