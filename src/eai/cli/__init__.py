"""The command line: thin callers of the library, one module a command."""

from __future__ import annotations

import errno
import os
import signal
import sys
from collections import UserDict
from collections.abc import Iterator, Mapping
from importlib import import_module
from io import TextIOWrapper
from shutil import get_terminal_size
from typing import Annotated, Any, NamedTuple

import typer
from typer.core import MarkupMode, TyperCommand, TyperGroup
from typer.main import get_group

from eai import __version__
from eai.data.docstrings import meanings
from eai.errors import EaiError, InputError, InterruptError

MEASURE, UNDERSTAND, MATERIAL = "Measure", "Understand", "Tasks and data"
"""The panels of the commands."""

_FULL = frozenset({errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO})
"""The errors of a device that takes no more."""


RENAMED = {
    "submission build": "export submission RUN --out FILE",
    "submission check": "export submission FILE",
    "pictures": "export pictures",
    "questions run": "run --ability world_model --domain FILE --model NAME",
    "questions score": "score ANSWERS --ability world_model --domain FILE",
    "questions": "export questions",
    "human form": "export prompts --out FILE.html",
    "prompts": "export prompts",
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


class _Place(NamedTuple):
    """Where a command is, and where it stands in the help.

    Attributes:
        panel: the panel in the help.
        summary: the help of an app with commands, or the first paragraph of that of a function, so that the
            help of the group imports no command.
        target: the module in this package and the name there, of a function or of an app with commands; both
            are the command's name if empty.
        old_flags: the module and the function in it that refuses flags which are settings now; none if empty.
        bare: whether it does something without any argument, instead of printing its help.
    """

    panel: str
    summary: str
    target: str = ""
    old_flags: str = ""
    bare: bool = False


_PLACES = {
    "demo": _Place(
        MEASURE,
        "See in a minute what eai does: two built-in models, and an answer that failed, explained.",
        bare=True,
    ),
    "run": _Place(
        MEASURE,
        "Obtain answers through Inspect and score them. The same command resumes where it was interrupted.",
        old_flags="flags:refuse_old_flags",
    ),
    "play": _Place(
        MEASURE,
        "Play tasks yourself, as models act; scores, reports and comparisons take episodes as theirs.",
    ),
    "score": _Place(
        MEASURE,
        "Score answers: verdicts to OUT/records.jsonl, rates to OUT/summary.json, "
        "the main table to the screen.",
    ),
    "serve": _Place(MEASURE, "Let agents outside of this program act.", "serve:app"),
    "explain": _Place(
        UNDERSTAND,
        "Show what became of an answer: each step, what it changed, the failing check and why; "
        "or list answers.",
    ),
    "compare": _Place(
        UNDERSTAND, "Compare two runs task by task: exact McNemar for success, random exchanges for F1."
    ),
    "report": _Place(
        UNDERSTAND,
        "Print the main results of runs, the best first; "
        "with --out, write tables, plots and the HTML explorer.",
    ),
    "analyze": _Place(
        UNDERSTAND,
        "Make the tables and plots of a study of records; "
        "without a name, list the studies and their options.",
        old_flags="analyze:refuse_old_flags",
        bare=True,
    ),
    "generate": _Place(
        MATERIAL,
        "Generate tasks that nobody has seen. Equal arguments give equal bytes.",
        target="generate:generate_tasks",
    ),
    "data": _Place(
        MATERIAL, "The data set: fetch it, say where it is, check it, count it, annotate it.", "data:app"
    ),
    "new": _Place(
        MATERIAL,
        "Write a small domain that runs: a folder NAME with its declaration and two tasks in NAME.py.",
    ),
    "check": _Place(
        MATERIAL,
        "Check a benchmark: its declaration, its tasks, and each line of task files.",
        target="tasks:check",
    ),
    "export": _Place(
        MATERIAL,
        "Prompts, data sets for training, task files, world-model questions, pictures, challenge files.",
        target="export:app",
    ),
}
"""The commands, in the order of the help."""


class _Commands(TyperGroup):
    """The commands, which are imported when they are asked for, and of which any may be interrupted."""

    def __init__(self, **attributes: Any) -> None:
        super().__init__(**{**attributes, "rich_markup_mode": _help_mode()})
        self.commands = _Loaded({**_PLACES, **self.commands})

    def list_commands(self, ctx: Any) -> list[str]:
        """The names of the commands, for which none needs to be imported."""
        return list(self.commands)

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Write the help of the group, for which no command is imported."""
        _label(self)
        commands = self.commands
        self.commands = {
            name: TyperCommand(name, help=place.summary, rich_help_panel=place.panel)
            for name, place in _PLACES.items()
        } | {name: commands[name] for name in commands if name not in _PLACES}
        try:
            super().format_help(ctx, formatter)
        finally:
            self.commands = commands

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """The command that is named.

        Raises:
            InputError: it, or a flag of it, is called otherwise now.
        """
        for words in (" ".join(args[:2]), args[0]):
            if words in RENAMED:
                raise InputError(f"eai {words}: write eai {RENAMED[words]}")
        place = _PLACES.get(args[0])
        if place is not None and place.old_flags:
            _object_at(place.old_flags)(args[1:])
        return super().resolve_command(ctx, args)

    def invoke(self, ctx: Any) -> Any:
        """Run the command that was chosen; an interrupt that it says nothing about is one line."""
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            raise InterruptError("interrupted") from None


class _Loaded(UserDict[str, Any]):
    """Commands by name, or where they are until one is asked for."""

    def __getitem__(self, name: str) -> Any:
        found = self.data[name]
        if isinstance(found, _Place):
            found = self.data[name] = _imported(name, found)
        return found


def _object_at(target: str) -> Any:
    module, _, name = target.partition(":")
    return getattr(import_module(f"{__name__}.{module}"), name)


def _imported(name: str, place: _Place) -> Any:
    found = _object_at(place.target or f"{name}:{name}")
    app = typer.Typer(pretty_exceptions_enable=False, rich_markup_mode=_help_mode())
    if isinstance(found, typer.Typer):
        app.add_typer(found, name=name, help=place.summary, rich_help_panel=place.panel)
    else:
        app.command(name, no_args_is_help=not place.bare, rich_help_panel=place.panel)(found)
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
