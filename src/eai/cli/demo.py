"""``eai demo``: run other commands that show in a minute what eai does."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Annotated

import typer

from eai.cli.console import print_result_line, require_inspect_package
from eai.cli.options import DataFolder, make_flag

_TASKS = 40
_EXPLAINED = "virtualhome/action_sequencing/eai_noisy 616_1"
"""Failed answer that the demo explains: folder of its records below the demo's results, and task id."""

_BEFORE = f"""\
Two built-in models, of which one makes mistakes, do {_TASKS} tasks of each of 8 suites.
No key is needed, and no model is called. This takes about a minute, and one more
the first time, to download the tasks (27 MB)."""

_AFTER = {
    "explain {out} --failed": "all answers that failed",
    "report {out} --out report": "tables, and the explorer as a page",
    "run --model openai/gpt-4o --limit 5": "a model of yours (needs its key)",
}
"""Mapping from commands to try after the demo to descriptions of their results."""


def demo(out: Annotated[Path, make_flag(metavar="DIR")] = Path("demo"), data: DataFolder = None) -> None:
    """See in a minute what eai does: score two built-in models, and explain a failed answer.

    Example: eai demo

    Options:
        out: Folder of the results.
    """
    print_result_line(_BEFORE)
    require_inspect_package()
    folder = shlex.quote(str(out))
    at = "" if data is None else f" --data {shlex.quote(str(data))}"
    models = "--model eai/oracle --model eai/noisy"
    _print_and_run_command(f"run {models} --limit {_TASKS} --planner built_in --out {folder}{at}")
    print_result_line("\nWhy an answer failed:")
    _print_and_run_command(f"explain {folder}/{_EXPLAINED}{at}")
    print_result_line("\nTo go on:")
    commands = {command.format(out=folder): shown for command, shown in _AFTER.items()}
    width = max(map(len, commands))
    for command, shown in commands.items():
        print_result_line(f"  eai {command.ljust(width)}  # {shown}")


def _print_and_run_command(command: str) -> None:
    """Print a command of eai and run it."""
    from eai.cli import app

    print_result_line(f"\n$ eai {command}\n")
    status = app(shlex.split(command), prog_name="eai", standalone_mode=False)
    if status:
        raise typer.Exit(status)
