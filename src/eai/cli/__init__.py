"""The command line: thin callers of the library, one module a command."""

from __future__ import annotations

import signal
import sys
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from eai import __version__
from eai.cli import (
    analyze,
    annotate,
    compare,
    data,
    explain,
    export,
    generate,
    human,
    leaderboard,
    merge,
    pictures,
    prompts,
    questions,
    report,
    run,
    score,
    submission,
    tasks,
)
from eai.cli.console import errors
from eai.errors import EaiError, InterruptError


class _Commands(TyperGroup):
    """The commands, of which any may be interrupted."""

    def invoke(self, ctx: Any) -> Any:
        """Run the command that was chosen; an interrupt that it says nothing about is told in a line."""
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            raise InterruptError("interrupted") from None


app = typer.Typer(
    name="eai",
    cls=_Commands,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
MEASURE, UNDERSTAND, MATERIAL = "Measure", "Understand", "Tasks and data"
"""The panels of the commands."""

app.command(no_args_is_help=True, rich_help_panel=MEASURE)(run.run)
app.command(no_args_is_help=True, rich_help_panel=MEASURE)(score.score)
app.command("merge", no_args_is_help=True, rich_help_panel=MEASURE)(merge.merge_shards)
app.add_typer(submission.app, name="submission", rich_help_panel=MEASURE)
app.command(no_args_is_help=True, rich_help_panel=UNDERSTAND)(explain.explain)
app.command(no_args_is_help=True, rich_help_panel=UNDERSTAND)(compare.compare)
app.command(no_args_is_help=True, rich_help_panel=UNDERSTAND)(leaderboard.leaderboard)
app.command(no_args_is_help=True, rich_help_panel=UNDERSTAND)(report.report)
app.add_typer(analyze.app, name="analyze", rich_help_panel=UNDERSTAND)
app.add_typer(data.app, name="data", rich_help_panel=MATERIAL)
app.command(no_args_is_help=True, rich_help_panel=MATERIAL)(prompts.prompts)
app.command(no_args_is_help=True, rich_help_panel=MATERIAL)(pictures.pictures)
app.add_typer(tasks.app, name="tasks", rich_help_panel=MATERIAL)
app.command("generate", no_args_is_help=True, rich_help_panel=MATERIAL)(generate.generate_tasks)
app.add_typer(annotate.app, name="annotate", rich_help_panel=MATERIAL)
app.add_typer(questions.app, name="questions", rich_help_panel=MATERIAL)
app.add_typer(human.app, name="human", rich_help_panel=MATERIAL)
app.add_typer(export.app, name="export", rich_help_panel=MATERIAL)


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
    try:
        app(prog_name="eai")
    except EaiError as error:
        errors().print(f"eai: {error}", markup=False, highlight=False, soft_wrap=True)
        sys.exit(128 + interrupted_by if isinstance(error, InterruptError) else 2)
    except BrokenPipeError:
        sys.exit(1)
