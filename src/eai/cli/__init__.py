"""The command line: thin callers of the library, one module a command."""

from __future__ import annotations

import errno
import os
import signal
import sys
from io import TextIOWrapper
from typing import Annotated, Any, ClassVar

import typer

from eai import __version__
from eai.cli.lazily import HELP_OPTIONS, LazyGroup, Place
from eai.errors import EaiError, InputError, InterruptError

MEASURE, UNDERSTAND, MATERIAL = "Measure", "Understand", "Tasks and data"
"""The panels of the commands."""

_FULL = frozenset({errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO})
"""The errors of a device that takes no more."""


_RENAMED = {
    "submission build": "export submission RUN --out FILE",
    "submission check": "export submission FILE",
    "pictures": "export pictures",
    "questions run": "run --ability world_model --domain FILE --model NAME",
    "questions score": "score ANSWERS --ability world_model --domain FILE",
    "questions": "export questions",
    "human form": "prompts --out FILE.html",
    "data croissant": "export tasks --croissant --out DIR",
    "leaderboard": "report RUNS",
    "merge": "score DIR --merge",
    "tasks check": "check",
    "tasks write": "export tasks",
    "tasks import": "export tasks FILE... --domain NAME --out FILE",
    "tasks schema": "check --schema",
    "tasks reveal": "check FOLDER --split NAME --secret SECRET",
    "tasks overlap": "check B --against A",
    "data validate": "data info --check",
    "annotate frequencies": "data annotate differences --count",
    "annotate assign": "data annotate goals --assigned",
    "annotate concrete": "data annotate goals",
    "annotate check": "data annotate goals --check",
    "annotate": "data annotate",
}
"""The present names of commands that README and documentation once showed, by their former names."""


class _Commands(LazyGroup):
    """The commands, of which any may be interrupted."""

    places: ClassVar = {
        "run": Place(
            MEASURE,
            "Obtain answers through Inspect and score them. "
            "The same command resumes where it was interrupted.",
            kind="RunCommand",
        ),
        "play": Place(
            MEASURE,
            "Play tasks yourself, as models act; scores, reports and comparisons take episodes as theirs.",
        ),
        "score": Place(
            MEASURE,
            "Score answers: verdicts to OUT/records.jsonl, rates to OUT/summary.json, "
            "the main table to the screen.",
        ),
        "serve": Place(MEASURE, "Let agents outside of this program act.", "serve:app"),
        "explain": Place(
            UNDERSTAND,
            "Show what became of an answer: each step, what it changed, the failing check and why; "
            "or list answers.",
        ),
        "compare": Place(
            UNDERSTAND, "Compare two runs task by task: exact McNemar for success, random exchanges for F1."
        ),
        "report": Place(
            UNDERSTAND,
            "Print the main results of runs, the best first; "
            "with --out, write tables, plots and the HTML explorer.",
        ),
        "analyze": Place(
            UNDERSTAND,
            "Make the tables and plots of a study of records; "
            "without a name, list the studies and their options.",
            kind="AnalyzeCommand",
            bare=True,
        ),
        "prompts": Place(
            MATERIAL,
            'Write prompts as a list of {"identifier", "llm_prompt"}; '
            "a system message goes to a file beside it.",
        ),
        "generate": Place(
            MATERIAL,
            "Generate tasks that nobody has seen. Equal arguments give equal bytes.",
            target="generate:generate_tasks",
        ),
        "data": Place(
            MATERIAL, "The data set: fetch it, say where it is, check it, count it, annotate it.", "data:app"
        ),
        "new": Place(
            MATERIAL,
            "Write a small domain that runs: a folder NAME with its declaration and two tasks in NAME.py.",
        ),
        "check": Place(
            MATERIAL,
            "Check a benchmark: its declaration, its tasks, and each line of task files.",
            target="tasks:check",
        ),
        "export": Place(
            MATERIAL,
            "Data sets for training, task files, world-model questions, pictures, challenge files.",
            target="export:app",
        ),
    }

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """The command that is named.

        Raises:
            InputError: it is called otherwise now.
        """
        for words in (args[:2], args[:1]):
            if " ".join(words) in _RENAMED:
                raise InputError(f"eai {' '.join(words)}: write eai {_RENAMED[' '.join(words)]}")
        return super().resolve_command(ctx, args)

    def invoke(self, ctx: Any) -> Any:
        """Run the command that was chosen; an interrupt that it says nothing about is one line."""
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            raise InterruptError("interrupted") from None


app = typer.Typer(
    name="eai",
    cls=_Commands,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": [*HELP_OPTIONS]},
)


def _version(asked: bool) -> None:
    if asked:
        print(f"eai {__version__}")
        raise typer.Exit


@app.callback()
def eai(
    version: Annotated[
        bool,
        typer.Option("--version", "-V", callback=_version, is_eager=True, help="Print the version and exit."),
    ] = False,
) -> None:
    """Measure, diagnose and train language models for embodied decision making.

    Start: eai run --model eai/noisy -M rate=0.2 --limit 5   (no key, no network but for the data set)
    """


def main() -> None:
    """Run the command line; unusable input ends with one line on standard error and exit status 2.

    An interrupt ends with exit status 130, as of any program. A request to terminate is an interrupt, with
    exit status 143: planners are ended, their folders removed, and what is done is kept.
    """
    interrupted_by = signal.SIGINT

    def interrupt(number: int, frame: object) -> None:
        nonlocal interrupted_by
        interrupted_by = signal.SIGTERM
        if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # as in the background of a script
            signal.signal(signal.SIGINT, signal.default_int_handler)
        signal.raise_signal(signal.SIGINT)

    signal.signal(signal.SIGTERM, interrupt)
    if isinstance(sys.stdout, TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # a lone surrogate, or what a locale lacks
    try:
        try:
            app(prog_name="eai")
        finally:
            sys.stdout.flush()
    except EaiError as error:
        from eai.cli.console import note

        note(f"eai: {error}")
        sys.exit(128 + interrupted_by if isinstance(error, InterruptError) else 2)
    except OSError as error:
        if error.errno not in (errno.EPIPE, *_FULL):
            raise
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # or Python would try it again at its end
        if error.errno == errno.EPIPE:  # who reads it has had enough
            sys.exit(1)
        from eai.cli.console import note

        note(f"eai: the output cannot be written ({error.strerror})")
        sys.exit(2)
