"""``eai demo``: other commands, run one after the other, that show in a minute what eai does."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Annotated

import typer

from eai.cli.console import need_inspect, say
from eai.cli.options import DataFolder, flag

_TASKS = 40
_EXPLAINED = "virtualhome/action_sequencing/eai_noisy 616_1"
"""An answer that fails, below the folder of results."""

_BEFORE = f"""\
Two built-in models, of which one makes mistakes, do {_TASKS} tasks of each of 8 suites.
No key is needed, and no model is called. This takes about a minute, and one more
the first time, to download the tasks (27 MB)."""

_AFTER = {
    "explain {out} --failed": "all answers that failed",
    "report {out} --out report": "tables, and the explorer as a page",
    "run --model openai/gpt-4o --limit 5": "a model of yours (needs its key)",
}
"""The commands to go on with, and what each shows."""


def demo(out: Annotated[Path, flag(metavar="DIR")] = Path("runs/demo"), data: DataFolder = None) -> None:
    """See in a minute what eai does: two built-in models, and an answer that failed, explained.

    Example: eai demo

    Options:
        out: Where the results go.
    """
    say(_BEFORE)
    need_inspect()
    folder = shlex.quote(str(out))
    at = "" if data is None else f" --data {shlex.quote(str(data))}"
    models = "--model eai/oracle --model eai/noisy"
    _run(f"run {models} --limit {_TASKS} --planner built_in --out {folder}{at}")
    say("\nWhy an answer failed:")
    _run(f"explain {folder}/{_EXPLAINED}{at}")
    say("\nTo go on:")
    commands = {command.format(out=folder): shown for command, shown in _AFTER.items()}
    width = max(map(len, commands))
    for command, shown in commands.items():
        say(f"  eai {command.ljust(width)}  # {shown}")


def _run(command: str) -> None:
    """Run a command of ours, and show it."""
    from eai.cli import app

    say(f"\n$ eai {command}\n")
    status = app(shlex.split(command), prog_name="eai", standalone_mode=False)
    if status:
        raise typer.Exit(status)
