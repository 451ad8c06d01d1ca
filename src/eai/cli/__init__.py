"""The command line: thin callers of the library, one module a command."""

from __future__ import annotations

import errno
import os
import signal
import sys
from collections import UserDict
from collections.abc import Iterator, Mapping
from functools import cache
from importlib import import_module
from io import TextIOWrapper
from shutil import get_terminal_size
from typing import Annotated, Any

import typer
from typer.core import MarkupMode, TyperCommand, TyperGroup
from typer.main import get_group

from eai import __version__
from eai.data.docstrings import meanings
from eai.errors import EaiError, InterruptError

MEASURE, UNDERSTAND, MATERIAL = "Measure", "Understand", "Tasks and data"
"""The panels of the commands."""

_FULL = frozenset({errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO})
"""The errors of a device that takes no more."""


_HELP_OPTIONS = ("-h", "--help")

_METAVARS: Mapping[str, str] = {
    f"--{option}": metavar
    for metavar, options in {
        "NAME": "ability domain errata like model planner prompt-name protocol split",
        "N": "conditions depth epochs limit max-connections max-tokens n objects sample seed workers",
        "P": "least",
        "S": "planner-seconds",
        "X": "margin",
        "DIR": "data out prompts",
        "FILE": "prices",
        "PATH": "demonstrations from goals",
        "ID,ID": "tasks",
        "SECRET": "secret",
        "URL": "model-base-url",
    }.items()
    for option in options.split()
}
"""The name of an option's value where the option does not say it itself."""

_PANELS = 80
"""How many columns help in panels takes; where there are fewer, it would cut the names of options."""

_COMMANDS = {
    MEASURE: {
        "demo": "See in a minute what eai does: two built-in models, and an answer that failed, explained.",
        "run": "Obtain answers through Inspect and score them. "
        "The same command resumes where it was interrupted.",
        "play": "Play tasks yourself, as models act; "
        "scores, reports and comparisons take episodes as theirs.",
        "score": "Score answers: verdicts to OUT/records.jsonl, rates to OUT/summary.json, "
        "the main table to the screen.",
        "serve": "Let agents outside of this program act.",
    },
    UNDERSTAND: {
        "explain": "Show what became of an answer: each step, what it changed, the failing check and why; "
        "or list answers.",
        "compare": "Compare two runs task by task: exact McNemar for success, random exchanges for F1.",
        "report": "Print the main results of runs, the best first; "
        "with --out, write tables, plots and the HTML explorer.",
        "analyze": "Make the tables and plots of a study of records; "
        "without a name, list the studies and their options.",
    },
    MATERIAL: {
        "generate": "Generate tasks that nobody has seen. Equal arguments give equal bytes.",
        "data": "The data set: fetch it, say where it is, check it, count it, annotate it.",
        "new": "Write a small domain that runs: a folder NAME with its declaration and two tasks in NAME.py.",
        "check": "Check a benchmark: its declaration, its tasks, and each line of task files.",
        "export": "Prompts, data sets for training, task files, world-model questions, pictures, "
        "challenge files.",
    },
}
"""The commands by panel, in the order of the help, each with the first paragraph of its own.

It stands here, too, so that the help of the group imports no command.
"""

_PLACES = {
    "serve": "serve:app",
    "generate": "generate:generate_tasks",
    "data": "data:app",
    "check": "tasks:check",
    "export": "export:app",
}
"""The module in this package, and the name there, of a command that is no function NAME in a module NAME."""

_BARE = frozenset({"demo", "analyze"})
"""The commands that do something without any argument, instead of printing their help."""


class _Commands(TyperGroup):
    """The commands, which are imported when they are asked for, and of which any may be interrupted."""

    def __init__(self, **attributes: Any) -> None:
        super().__init__(**{**attributes, "rich_markup_mode": _help_mode()})
        self._shown: dict[str, Any] = {
            name: TyperCommand(name, help=summary, rich_help_panel=panel)
            for panel, summaries in _COMMANDS.items()
            for name, summary in summaries.items()
        }
        self._shown |= self.commands
        self.commands = _Loaded(self._shown)

    def list_commands(self, ctx: Any) -> list[str]:
        """The names of the commands, for which none needs to be imported."""
        return list(self.commands)

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """The command as the help of the group shows it, for which it is not imported."""
        return self._shown.get(cmd_name)

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Write the help of the group."""
        _label(self)
        super().format_help(ctx, formatter)

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """The command that is named."""
        name, found, rest = super().resolve_command(ctx, args)
        return name, found and _imported(found), rest

    def invoke(self, ctx: Any) -> Any:
        """Run the command that was chosen; an interrupt that it says nothing about is one line."""
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            raise InterruptError("interrupted") from None


class _Loaded(UserDict[str, Any]):
    """Commands by name; whoever asks for one has it imported."""

    def __getitem__(self, name: str) -> Any:
        return _imported(self.data[name])


def _object_at(place: str) -> Any:
    module, _, name = place.partition(":")
    return getattr(import_module(f"{__name__}.{module}"), name)


@cache
def _imported(shown: Any) -> Any:
    """A command by how the help of the group shows it; one that does something is that already."""
    if shown.callback is not None:
        return shown
    name, panel = shown.name, shown.rich_help_panel
    found = _object_at(_PLACES.get(name, f"{name}:{name}"))
    app = typer.Typer(pretty_exceptions_enable=False, rich_markup_mode=_help_mode())
    if isinstance(found, typer.Typer):
        app.add_typer(found, name=name, help=shown.help, rich_help_panel=panel)
    else:
        app.command(name, no_args_is_help=name not in _BARE, rich_help_panel=panel)(found)
    command: Any = get_group(app).commands[name]
    for each in _with_those_below(command):
        _label(each)
    return command


def _help_mode() -> MarkupMode:
    return "rich" if get_terminal_size().columns >= _PANELS else None


def _with_those_below(command: Any) -> Iterator[Any]:
    """A command and, of a group, all commands below it."""
    yield command
    if isinstance(command, TyperGroup):
        for each in command.commands.values():
            yield from _with_those_below(each)


def _label(command: Any) -> None:
    """Have the help of a command name values by their metavars alone, and fill its paragraphs.

    What each option means is told below ``Options:`` in the docstring. Typer would say of each value what
    Python reads it as, and break lines where the docstring does. It would also take ``--no-paper`` beside
    ``--paper``, which is off if it is not given.
    """
    text, told = (command.help or "").partition("\n\nOptions:\n")[0], meanings(command.help, "Options")
    command.help = "\n\n".join(" ".join(part.split()) for part in text.split("\n\n"))
    for parameter in command.get_params(command.context_class(command, help_option_names=[*_HELP_OPTIONS])):
        if parameter.param_type_name == "argument":
            parameter.metavar = parameter.metavar or parameter.name.upper()
            parameter.display_type_rich = lambda ctx: ""
        elif parameter.metavar is None:
            name = max(parameter.opts, key=len)
            parameter.metavar = "" if parameter.is_flag else _METAVARS.get(name)
        parameter.help = told.get(parameter.name, parameter.help)
        if parameter.default is False:
            parameter.secondary_opts = []
        if "--protocol" in parameter.opts:
            from eai.abilities.protocol import registered_protocols

            parameter.help = f"{parameter.help} Here: {', '.join(('strict', *registered_protocols()))}."


app = typer.Typer(
    name="eai",
    cls=_Commands,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": [*_HELP_OPTIONS]},
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

    Start: eai demo   (no key, no network but for the data set)
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
