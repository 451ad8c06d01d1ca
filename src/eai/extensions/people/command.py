"""``eai play``: a person plays tasks as models do, in the terminal or on a page."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from eai.agents.setting import ACTING, PICTURES, Setting
from eai.base.errors import InputError
from eai.benchmarks.suite import Suite
from eai.cli.console import counted, note, say
from eai.cli.options import OUTPUT, AgentSettings, DataFolder, OfDomain, flag, setting_of_others
from eai.cli.progress import resumable
from eai.cli.prompts import Sample, SampleSeed, TaskIds, playable
from eai.results.responses import SUFFIX, Response, ResponseFile, model_name, read_responses, write_responses

if TYPE_CHECKING:
    from eai.agents.play import Play

_QUIT = "quit"


@resumable
def play(
    domain: OfDomain,
    tasks: TaskIds = "",
    sample: Sample = None,
    seed: SampleSeed = 0,
    settings: AgentSettings = None,
    page: Annotated[int | None, flag(metavar="PORT", min=0, max=65_535)] = None,
    out: Annotated[Path, flag(help=f"Where episodes go: NAME{SUFFIX}.", panel=OUTPUT, metavar="FILE")] = Path(
        f"person{SUFFIX}"
    ),
    data: DataFolder = None,
) -> None:
    """Play tasks yourself, as models act; scores, reports and comparisons take episodes as theirs.

    Each command is kept at once. The same command resumes where you stopped, also within a task.

    Without a terminal, commands are read line by line from standard input. With --page, the command ends
    when all tasks are over.

    Example: eai play --domain virtualhome --sample 5 --out ann_outputs.json

    Options:
        page: Play on a page in a browser on this machine, not in the terminal; 0: at any free port.
    """
    setting = setting_of_others(settings or ())
    if page is None and setting.feedback == PICTURES:
        raise InputError("--with feedback=pictures: a terminal shows none; add --page PORT")
    suite, chosen = playable(domain, tasks, sample, seed, data)
    answers = _Answers(out, suite)
    begun, total = _begun(chosen, suite, setting, answers), len(chosen)
    if page is None:
        over = _in_terminal(begun, total, answers.put)
    else:
        from eai.extensions.people.page import serve_page

        serve_page(page, begun, total, answers.put, lambda address: note(f"open {address}"))
        over = total
    if not out.exists():
        say(f"{over} of {counted(total, 'task')} over; no command was given, so {out} is not written")
        return
    say(f"{over} of {counted(total, 'task')} over; written to {out}")
    say(f"To score: eai score {out} --domain {domain} --ability {ACTING.value} --allow-missing")


class _Answers:
    """The file of a person's episodes, as other answers; it is written after each command.

    Raises:
        InputError: there is a file of that name that is none of this suite.
    """

    def __init__(self, path: Path, suite: Suite) -> None:
        if not path.name.endswith(SUFFIX):
            raise InputError(f"--out {path}: expected a name that ends with {SUFFIX}")
        self._path, self._model = path, model_name(path)
        before = read_responses(path, suite.task_ids).responses if path.exists() else ()
        self._texts = {response.task_id: response.text for response in before}
        self._written = self._read()

    def text(self, task_id: str) -> str:
        """The episode of a task so far; empty where none was begun."""
        return self._texts.get(task_id, "")

    def put(self, play: Play) -> None:
        """Keep an episode.

        Raises:
            InputError: somebody else has written the file meanwhile.
        """
        if self._read() != self._written:
            raise InputError(f"{self._path}: somebody else plays into this file; give another --out")
        self._texts[play.task.id] = play.text("stopped")
        responses = [Response(*each) for each in self._texts.items()]
        write_responses(self._path.parent, ResponseFile(self._model, responses))
        self._written = self._read()

    def _read(self) -> bytes | None:
        return self._path.read_bytes() if self._path.exists() else None


def _begun(
    task_ids: Sequence[str], suite: Suite, setting: Setting, answers: _Answers
) -> Iterator[tuple[int, Play, Sequence[str]]]:
    """The tasks that are not over yet: number, episode, and what was observed in it so far."""
    from eai.agents.play import Arena
    from eai.extensions.people.person import begin

    arena = Arena(suite.benchmark, setting)
    for number, task_id in enumerate(task_ids, 1):
        stage = arena.stage(suite.tasks[task_id])
        play, told = begin(stage, setting.slip_seed, answers.text(task_id))
        if not play.over:
            yield number, play, told


def _in_terminal(
    begun: Iterator[tuple[int, Play, Sequence[str]]], total: int, keep: Callable[[Play], None]
) -> int:
    """Play task by task, until the person stops; returns how many are over."""
    from eai.extensions.people.person import RULES

    say(f"{RULES}\n  {_QUIT}      stop here; the same command resumes\n")
    for number, play, told in begun:
        say(f"Task {number} of {total}\n\n{play.opening()}\n")
        for turn, text in zip(play.turns, told, strict=True):
            say(f"> {turn.said}\n{text}\n")
        _play(play, keep)
        if not play.over:
            return number - 1
    return total


def _play(play: Play, keep: Callable[[Play], None]) -> None:
    """Carry out what a person types, until the task is over or they stop."""
    from eai.extensions.people.person import completions, enter

    _complete(partial(completions, play))
    while not play.over:
        line = _line()
        if line is None or line.strip() == _QUIT:
            return
        if line.strip():
            told = enter(play, line)
            keep(play)
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
