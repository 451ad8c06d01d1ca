"""``eai play``: let a person play the same tasks as models, in the terminal or on a web page."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from eai.agents.setting import ACTING, PICTURES, AgentSetting
from eai.base.errors import InputError
from eai.benchmarks.suite import Suite
from eai.cli.console import format_count, print_note, print_result_line
from eai.cli.options import (
    OUTPUT,
    AgentSettings,
    DataFolder,
    OfDomain,
    make_flag,
    parse_external_agent_setting,
)
from eai.cli.progress import make_command_print_how_to_resume
from eai.cli.prompts import Sample, SampleSeed, TaskIds, open_suite_for_acting_and_select_tasks
from eai.results.responses import (
    SUFFIX,
    Response,
    ResponseFile,
    read_model_name,
    read_responses,
    write_responses,
)

if TYPE_CHECKING:
    from eai.agents.play import RecordedGame

_QUIT = "quit"


@make_command_print_how_to_resume
def play(
    domain: OfDomain,
    tasks: TaskIds = "",
    sample: Sample = None,
    seed: SampleSeed = 0,
    settings: AgentSettings = None,
    page: Annotated[int | None, make_flag(metavar="PORT", min=0, max=65_535)] = None,
    out: Annotated[
        Path, make_flag(help=f"File of the episodes: NAME{SUFFIX}.", panel=OUTPUT, metavar="FILE")
    ] = Path(f"person{SUFFIX}"),
    data: DataFolder = None,
) -> None:
    """Play tasks yourself, as models act. Episodes are scored, reported and compared like those of models.

    Each command is saved at once. The same call resumes where you stopped, also within a task.

    Without a terminal, commands are read line by line from standard input. With --page, the command ends
    when all tasks are over.

    Example: eai play --domain virtualhome --sample 5 --out ann_outputs.json

    Options:
        page: Play in a browser on this machine instead of the terminal; 0: at any free port.
    """
    setting = parse_external_agent_setting(settings or ())
    if page is None and setting.feedback == PICTURES:
        raise InputError("--with feedback=pictures: a terminal shows no pictures; add --page PORT")
    suite, chosen = open_suite_for_acting_and_select_tasks(domain, tasks, sample, seed, data)
    answers = _EpisodeFile(out, suite)
    tasks_left, total = _begin_or_resume_unfinished_episodes(chosen, suite, setting, answers), len(chosen)
    if page is None:
        finished = _play_in_terminal_and_count_finished_tasks(tasks_left, total, answers.save_episode)
    else:
        from eai.extensions.people.page import serve_page

        serve_page(
            page, tasks_left, total, answers.save_episode, lambda address: print_note(f"open {address}")
        )
        finished = total
    if not out.exists():
        print_result_line(
            f"{finished} of {format_count(total, 'task')} over; no command was given, so {out} is not written"
        )
        return
    print_result_line(f"{finished} of {format_count(total, 'task')} over; written to {out}")
    print_result_line(f"To score: eai score {out} --domain {domain} --ability {ACTING.value} --allow-missing")


class _EpisodeFile:
    """The response file of a person's episodes. It is written after each command.

    Raises:
        InputError: The file exists and is no response file of this suite.
    """

    def __init__(self, path: Path, suite: Suite) -> None:
        if not path.name.endswith(SUFFIX):
            raise InputError(f"--out {path}: expected a name that ends with {SUFFIX}")
        self._path, self._model = path, read_model_name(path)
        responses = read_responses(path, suite.task_ids).responses if path.exists() else ()
        self._texts = {response.task_id: response.text for response in responses}
        self._written = self._read_answer_file()

    def get_episode_text(self, task_id: str) -> str:
        """Return the episode of a task so far, or an empty text if the task was not begun."""
        return self._texts.get(task_id, "")

    def save_episode(self, play: RecordedGame) -> None:
        """Save an episode.

        Raises:
            InputError: Another program has written the file since the last command.
        """
        if self._read_answer_file() != self._written:
            raise InputError(f"{self._path}: another program has written this file; give another --out")
        self._texts[play.task.id] = play.write_as_json_text("stopped")
        responses = [Response(task_id, text) for task_id, text in self._texts.items()]
        write_responses(self._path.parent, ResponseFile(self._model, responses))
        self._written = self._read_answer_file()

    def _read_answer_file(self) -> bytes | None:
        return self._path.read_bytes() if self._path.exists() else None


def _begin_or_resume_unfinished_episodes(
    task_ids: Sequence[str], suite: Suite, setting: AgentSetting, answers: _EpisodeFile
) -> Iterator[tuple[int, RecordedGame, Sequence[str]]]:
    """Yield each task that is not over: its number, its episode, and the observations so far."""
    from eai.agents.play import EpisodeFactory
    from eai.extensions.people.person import get_new_or_resumed_episode_and_observations

    arena = EpisodeFactory(suite.benchmark, setting)
    for number, task_id in enumerate(task_ids, 1):
        setup = arena.make_setup(suite.tasks[task_id])
        play, observations = get_new_or_resumed_episode_and_observations(
            setup, setting.slip_seed, answers.get_episode_text(task_id)
        )
        if not play.is_over:
            yield number, play, observations


def _play_in_terminal_and_count_finished_tasks(
    tasks: Iterator[tuple[int, RecordedGame, Sequence[str]]], total: int, save: Callable[[RecordedGame], None]
) -> int:
    """Play the tasks in order until the person stops. Return how many tasks are over."""
    from eai.extensions.people.person import RULES

    print_result_line(f"{RULES}\n  {_QUIT}      stop here; the same command resumes\n")
    for number, play, observations in tasks:
        print_result_line(f"Task {number} of {total}\n\n{play.write_first_observation()}\n")
        for turn, text in zip(play.turns, observations, strict=True):
            print_result_line(f"> {turn.said}\n{text}\n")
        _play_task(play, save)
        if not play.is_over:
            return number - 1
    return total


def _play_task(play: RecordedGame, save: Callable[[RecordedGame], None]) -> None:
    """Execute the lines that a person types until the task is over or the person stops."""
    from eai.extensions.people.person import execute_line, list_possible_next_words

    _enable_completion(partial(list_possible_next_words, play))
    while not play.is_over:
        line = _read_line()
        if line is None or line.strip() == _QUIT:
            return
        if line.strip():
            reply = execute_line(play, line)
            save(play)
            print_result_line(f"{reply}\n")


def _read_line() -> str | None:
    """Return the next typed line, or None at the end of the input. Print the line if input is no terminal."""
    try:
        line = input("> ")
    except EOFError:
        return None
    if not sys.stdin.isatty():
        print_result_line(line)
    return line


def _enable_completion(words: Callable[[str], Sequence[str]]) -> None:
    """Complete words with the tabulator key, if a terminal supports it.

    Args:
        words: Function from the beginning of a line to the possible next words.
    """
    if find_spec("readline") is None or not sys.stdin.isatty():
        return
    import readline

    def get_word_completion(word_beginning: str, match_index: int) -> str | None:
        before = readline.get_line_buffer()[: readline.get_begidx()]
        matches = [word for word in words(before) if word.casefold().startswith(word_beginning.casefold())]
        return matches[match_index] if match_index < len(matches) else None

    readline.set_completer(get_word_completion)
    readline.set_completer_delims(" ,()")
    is_libedit = "libedit" in (readline.__doc__ or "")
    readline.parse_and_bind("bind ^I rl_complete" if is_libedit else "tab: complete")
