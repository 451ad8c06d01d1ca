"""``eai play``: a person plays tasks in the terminal, as models do."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable, Sequence
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from eai.abilities.responses import SUFFIX, model_name, read_responses
from eai.acting.setting import ACTING, Setting
from eai.benchmark.suite import Suite
from eai.cli.console import counted, say
from eai.cli.options import OUTPUT, AgentSettings, DataFolder, OfDomain, setting_of_others
from eai.cli.progress import resumable
from eai.cli.prompts import Sample, SampleSeed, TaskIds, playable
from eai.data.files import write_whole
from eai.errors import InputError

if TYPE_CHECKING:
    from eai.acting.play import Play

_QUIT = "quit"


@resumable
def play(
    domain: OfDomain,
    tasks: TaskIds = "",
    sample: Sample = None,
    seed: SampleSeed = 0,
    settings: AgentSettings = None,
    out: Annotated[
        Path,
        typer.Option(metavar="FILE", help=f"Where episodes go: NAME{SUFFIX}.", rich_help_panel=OUTPUT),
    ] = Path(f"person{SUFFIX}"),
    data: DataFolder = None,
) -> None:
    """Play tasks yourself, as models act; scores, reports and comparisons take episodes as theirs.

    Each command is kept at once. The same command resumes where you stopped, also within a task.

    Without a terminal, commands are read line by line from standard input.

    Example: eai play --domain virtualhome --sample 5 --out ann_outputs.json
    """
    setting = setting_of_others(settings or ())
    suite, chosen = playable(domain, tasks, sample, seed, data)
    over = _play_all(chosen, suite, setting, _Answers(out, suite))
    say(f"{over} of {counted(len(chosen), 'task')} over; written to {out}")
    say(f"To score: eai score {out} --domain {domain} --ability {ACTING.value} --allow-missing")


class _Answers:
    """The file of a person's episodes, as other answers; it is written after each command.

    Raises:
        InputError: there is a file of that name that is none of this suite.
    """

    def __init__(self, path: Path, suite: Suite) -> None:
        if not path.name.endswith(SUFFIX):
            raise InputError(f"--out {path}: expected a name that ends with {SUFFIX}")
        model_name(path)
        self._path = path
        self._rows: dict[str, dict[str, str | float]] = {}
        if path.exists():
            read_responses(path, suite.task_ids)
            self._rows = {row["identifier"]: row for row in json.loads(path.read_bytes())}
        self._written = self._read()

    def text(self, task_id: str) -> str:
        """The episode of a task so far; empty where none was begun."""
        return str(self._rows.get(task_id, {}).get("llm_output") or "")

    def put(self, task_id: str, text: str, seconds: float) -> None:
        """Keep an episode, and so many more seconds in which it was played.

        Raises:
            InputError: somebody else has written the file meanwhile.
        """
        if self._read() != self._written:
            raise InputError(f"{self._path}: somebody else plays into this file; give another --out")
        spent = float(self._rows.get(task_id, {}).get("seconds", 0)) + seconds
        self._rows[task_id] = {"identifier": task_id, "llm_output": text, "seconds": round(spent, 1)}
        write_whole({self._path: json.dumps([*self._rows.values()], indent=1) + "\n"})
        self._written = self._read()

    def _read(self) -> bytes | None:
        return self._path.read_bytes() if self._path.exists() else None


def _play_all(task_ids: Sequence[str], suite: Suite, setting: Setting, answers: _Answers) -> int:
    """Play what is not over yet, task by task, until the person stops; returns how many are over."""
    from eai.acting.person import RULES, begin
    from eai.acting.play import Arena

    arena = Arena(suite.benchmark, setting)
    say(f"{RULES}\n  {_QUIT}      stop here; the same command resumes\n")
    for number, task_id in enumerate(task_ids, 1):
        stage = arena.stage(suite.tasks[task_id])
        play, told = begin(stage, setting.slip_seed, answers.text(task_id))
        if play.game.over:
            continue
        say(f"Task {number} of {len(task_ids)}\n\n{play.game.opening()[0]}\n")
        for turn, text in zip(play.turns, told, strict=True):
            say(f"> {turn.said}\n{text}\n")
        _play(play, partial(answers.put, task_id))
        if not play.game.over:
            return number - 1
    return len(task_ids)


def _play(play: Play, keep: Callable[[str, float], None]) -> None:
    """Carry out what a person types, until the task is over or they stop."""
    from eai.acting.person import completions, enter

    _complete(partial(completions, play))
    while not play.game.over:
        since = time.monotonic()
        line = _line()
        if line is None or line.strip() == _QUIT:
            return
        if line.strip():
            told = enter(play, line)
            keep(play.text("stopped"), time.monotonic() - since)
            say(f"{told}\n")


def _line() -> str | None:
    """The next line that is typed, which is shown where the input is no terminal; None at the end."""
    try:
        line = input("> ")
    except EOFError:
        return None
    if not sys.stdin.isatty():
        say(line)
    return line


def _complete(words: Callable[[str], Sequence[str]]) -> None:
    """Let the tabulator complete words, where there is a terminal that can do so.

    Args:
        words: those that may follow what is on the line already.
    """
    if find_spec("readline") is None or not sys.stdin.isatty():
        return
    import readline

    def complete(text: str, number: int) -> str | None:
        before = readline.get_line_buffer()[: readline.get_begidx()]
        found = [word for word in words(before) if word.casefold().startswith(text.casefold())]
        return found[number] if number < len(found) else None

    readline.set_completer(complete)
    readline.set_completer_delims(" ,()")
    is_libedit = "libedit" in (readline.__doc__ or "")
    readline.parse_and_bind("bind ^I rl_complete" if is_libedit else "tab: complete")
