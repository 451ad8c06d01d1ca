"""Serve episodes to agents outside of this process. Each episode has a journal that reveals tampering."""

from __future__ import annotations

import hmac
import json
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from urllib.parse import quote, unquote

from eai.agents.command import LOOK
from eai.agents.journal import Journal, is_begun, read_journal, read_key
from eai.agents.play import OVER, AgentTask, Session, read_episode
from eai.agents.setting import STANDARD, Setting
from eai.base.errors import InputError
from eai.base.files import convert_write_errors, lock_run_folder, to_file_name, write_files_atomically
from eai.base.grouping import group_pairs
from eai.benchmarks.suite import Suite
from eai.results.responses import COLUMNS, LINES
from eai.results.trials import AnswerKey
from eai.tasks.prompts.prompt import Image

HARNESS = "mcp"
"""Name that records give as the harness of agents outside of this process."""

_EPISODES, _ENDING = "episodes", ".journal"


def find_journal(folder: Path, place: AnswerKey) -> Path:
    """Return the path of an episode's journal in the folder of the server."""
    return folder / _EPISODES / str(place[1]) / f"{quote(place[0], safe='')}{_ENDING}"


@contextmanager
def open_episodes(
    folder: Path, suite: Suite, places: Sequence[AnswerKey], setting: Setting = STANDARD, agent: str = "agent"
) -> Iterator[EpisodeServer]:
    """Yield the server of the episodes in a folder, which no other process can use during the block.

    Raises:
        InputError: another process uses the folder, the folder cannot be used, or it holds episodes of other
            tasks or settings.
    """
    arena = AgentTask(suite.benchmark, setting)
    with suppress(OSError):  # `lock_run_folder` raises if the folder is missing
        folder.mkdir(mode=0o700, parents=True)
    with lock_run_folder(folder):
        worlds = EpisodeServer(folder, suite, places, arena, agent)
        try:
            yield worlds
        finally:
            worlds.close()


class EpisodeServer:
    """The episodes of tasks, one for each ticket. An episode begins once, with the first call.

    The folder contains the key that seals journals, a journal of each episode, and the answers for `eai
    score`. The agent must have no access to the folder.

    Args:
        folder: the folder.
        suite: the tasks.
        places: the offered episodes, each a task and the number of the episode among those of the task.
        arena: the benchmark and setting of the episodes.
        agent: the name of the agent in the name of the response file.

    Attributes:
        places: the offered episodes.
        tickets: the episode of each ticket, by the ticket's text.

    Raises:
        InputError: the folder cannot be used, or holds episodes of other tasks or settings.
    """

    def __init__(
        self, folder: Path, suite: Suite, places: Sequence[AnswerKey], arena: AgentTask, agent: str
    ) -> None:
        self._folder, self._suite, self._agent = folder, suite, to_file_name(agent)
        self._key = read_key(folder)
        self._arena = arena
        self._open: dict[AnswerKey, tuple[Session, Journal]] = {}
        self._written: set[AnswerKey] = set()
        self.places = places
        self.tickets = {self._make_ticket(place): place for place in places}
        self._write()

    def call(self, place: AnswerKey, command: str) -> str:
        """Carry out a command in an episode. Return the observation.

        The command `LOOK` before the first action returns the whole question.

        Raises:
            InputError: the folder cannot be written.
        """
        play, journal = self._open_episode(place)
        if journal.ended is not None:
            return OVER
        if command == LOOK and not play.turns:
            return self._arena.prompt(play.task).user
        told = play.say(command)
        journal.write(play)  # the turn must be on disk before the agent reads the observation
        if journal.ended is not None and place in self._written:
            self._write()
        elif journal.ended is not None:
            self._append(place)
        return told

    def pictures(self, place: AnswerKey) -> tuple[Image, ...]:
        """Return the pictures of the last observation in an episode (`Session.pictures`)."""
        return self._open_episode(place)[0].pictures()

    def end(self) -> None:
        """End all episodes under way.

        Raises:
            InputError: the folder cannot be written.
        """
        for place in self.places:
            if is_begun(find_journal(self._folder, place)):
                self._open_episode(place)[1].end()
        self._write()

    def close(self) -> None:
        """Write the answers and close all journals. A later server can resume unfinished episodes."""
        for _, journal in self._open.values():
            journal.close()
        self._write()

    def _write(self) -> None:
        """Write each episode that has begun as an answer.

        An unfinished episode counts as stopped by the agent.

        Raises:
            InputError: a journal was changed or has another setting, or the folder cannot be written.
        """
        begun = self._find_begun()
        write_files_atomically(
            group_pairs((self._find_response_file(episode), self._make_answer(episode)) for episode in begun)
        )
        self._written.update(begun)

    def _append(self, place: AnswerKey) -> None:
        """Append an episode that has ended to the response file."""
        self._written.add(place)
        with (
            convert_write_errors(self._find_response_file(place)),
            self._find_response_file(place).open("a", encoding="utf-8") as file,
        ):
            file.write(self._make_answer(place))

    def _find_response_file(self, place: AnswerKey) -> Path:
        """Return the path of an episode's response file. The n-th episodes of all tasks share a file."""
        epoch = place[1]
        return self._folder / f"{self._agent}{'' if epoch == 1 else f'-{epoch}'}{LINES}"

    def _make_answer(self, place: AnswerKey) -> str:
        path = find_journal(self._folder, place)
        text = read_journal(path, self._key, ended=False)
        if getattr(read_episode(text), "rules", None) != self._arena.rules:
            raise InputError(f"{path}: the episode is of another setting; give another --out")
        return json.dumps(dict(zip(COLUMNS, (place[0], text), strict=True))) + "\n"

    def _find_begun(self) -> list[AnswerKey]:
        """Return all episodes that have begun in the folder, in the order of the tasks."""
        order = {task_id: number for number, task_id in enumerate(self._suite.task_ids)}
        begun: list[AnswerKey] = []
        for path in (self._folder / _EPISODES).glob(f"*/*{_ENDING}"):
            task_id = unquote(path.name.removesuffix(_ENDING))
            if task_id not in order:
                raise InputError(f"{path}: {self._suite.domain} has no task {task_id!r}; give another --out")
            if is_begun(path):
                begun.append((task_id, int(path.parent.name)))
        return sorted(begun, key=lambda place: (place[1], order[place[0]]))

    def _open_episode(self, place: AnswerKey) -> tuple[Session, Journal]:
        """Return an episode with its journal. Begin the episode if it has not begun."""
        if place not in self._open:
            task_id, epoch = place
            path, stage = find_journal(self._folder, place), self._arena.stage(self._suite.tasks[task_id])
            path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
            play = Session(stage, self._arena.setting.slip_seed, epoch, harness=HARNESS)
            self._open[place] = play, Journal(path, self._key, play)
        return self._open[place]

    def _make_ticket(self, place: AnswerKey) -> str:
        """Return the ticket of an episode, a secret text that is equal after a restart of the server."""
        return hmac.new(self._key, f"ticket {place[1]} {place[0]}".encode(), "sha256").hexdigest()
