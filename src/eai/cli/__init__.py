"""The command line: thin callers of the library, one module a command."""

from __future__ import annotations

import signal
import sys

import typer

from eai.cli import (
    analyze,
    compare,
    data,
    explain,
    human,
    leaderboard,
    prompts,
    report,
    run,
    score,
    submission,
    tasks,
)
from eai.cli.console import errors
from eai.errors import EaiError, InterruptError

INTERRUPTED = 128 + signal.SIGINT
"""The exit status of what was interrupted."""

app = typer.Typer(
    name="eai",
    help="Measure, diagnose and train language models for embodied decision making.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
)
app.add_typer(data.app, name="data")
app.add_typer(analyze.app, name="analyze")
app.command(no_args_is_help=True)(score.score)
app.command(no_args_is_help=True)(run.run)
app.command(no_args_is_help=True)(explain.explain)
app.command(no_args_is_help=True)(prompts.prompts)
app.add_typer(submission.app, name="submission")
app.add_typer(tasks.app, name="tasks")
app.add_typer(human.app, name="human")
app.command(no_args_is_help=True)(report.report)
app.command(no_args_is_help=True)(compare.compare)
app.command(no_args_is_help=True)(leaderboard.leaderboard)


def main() -> None:
    """Run the command line; unusable input ends with one line on standard error and exit status 2.

    An interrupt ends with exit status 130, as of any program.

    A request to terminate is an ordinary exit, so that planners are ended and their folders removed.
    """
    signal.signal(signal.SIGTERM, lambda number, frame: sys.exit(128 + number))
    try:
        app()
    except EaiError as error:
        errors().print(f"eai: {error}", markup=False, highlight=False, soft_wrap=True)
        sys.exit(INTERRUPTED if isinstance(error, InterruptError) else 2)
    except BrokenPipeError:
        sys.exit(1)
