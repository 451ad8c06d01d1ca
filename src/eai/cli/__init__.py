"""The command line. Each command is a module that calls the library.

Commands are found by entry points. The help of ``eai`` lists commands without importing them.
"""

from __future__ import annotations

import errno
import os
import re
import signal
import sys
from collections import UserDict
from collections.abc import Iterator, Mapping
from functools import cache
from importlib.util import find_spec
from io import TextIOWrapper
from pathlib import Path
from shutil import get_terminal_size
from typing import Annotated, Any

import typer
from typer.core import MarkupMode, TyperCommand, TyperGroup
from typer.main import get_group

from eai import __version__
from eai.base.docstrings import read_docstring_entries
from eai.base.entry_points import EntryPoint, get_entry_points
from eai.base.errors import EaiError, InputError, UserInterruptError, did_you_mean

MEASURE, UNDERSTAND, MATERIAL, EXTENSIONS = "Measure", "Understand", "Tasks and data", "Extensions"
"""Titles of the panels of commands in the help of ``eai``."""

_FULL = frozenset({errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO})
"""Error numbers of the operating system for output to a full or broken device."""


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
"""Placeholders for the values of options in the help, by option. Other options show the name of the type."""

_PANELS = 80
"""Minimum width of a terminal, in characters, for help in panels.

Narrower panels would cut names of options off.
"""

_COMMANDS = "eai.commands"
"""Group of entry points that register commands.

The entry `data annotate` is the command `eai data annotate`.
"""

_BY_PANEL = {
    MEASURE: ("demo", "run", "score", "serve"),
    UNDERSTAND: ("explain", "compare", "report", "analyze"),
    MATERIAL: ("generate", "data", "new", "check", "export"),
}
"""Commands of the core by panel, in the order of the help. Commands of extensions are in the last panel."""

_FIRST_EXPORT_SUBCOMMANDS = ("export tasks", "export pictures")
"""Subcommands that the help of `eai export` lists first, in this order."""

_NEED_OPTIONS = frozenset({"run", "check"})
"""Commands without required arguments that still print their help if called without arguments."""


class _CommandGroup(TyperGroup):
    """A group of commands. A command is imported only when it is used, and can be interrupted."""

    def __init__(self, **attributes: Any) -> None:
        super().__init__(**{**attributes, "rich_markup_mode": _choose_markup_mode()})
        self._shown: dict[str, Any] = {
            name: TyperCommand(name, rich_help_panel=_find_help_panel(name))
            for name in _find_command_entry_points()
            if " " not in name
        }
        self._shown |= self.commands
        self.commands = _LazilyImportedCommands(self._shown)

    def list_commands(self, ctx: Any) -> list[str]:
        """Return the names of the commands without importing them."""
        return list(self.commands)

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Return a command by name. An unimported command is a placeholder with its name and summary."""
        command = self._shown.get(cmd_name)
        if command is not None and command.callback is None and command.help is None:
            command.help = _read_command_summary(_find_command_entry_points()[cmd_name])
        return command

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Write the help of the group, with a list of its commands."""
        _add_help_texts(self)
        super().format_help(ctx, formatter)

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Return the name of the command in the arguments, the command, and the remaining arguments."""
        name, found, rest = super().resolve_command(ctx, args)
        return name, found and _import_command_for_placeholder(found), rest

    def invoke(self, ctx: Any) -> Any:
        """Run the chosen command; an unhandled interrupt prints one line."""
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            raise UserInterruptError("interrupted") from None
        except typer.BadParameter as error:
            error.message = _reword_invalid_parameter_message(error.message)
            raise


def _reword_invalid_parameter_message(message: str) -> str:
    """Return Typer's message on a wrong value without pydantic's words, and with the most similar choice."""
    message = message.removeprefix("Value error, ").replace("Input should be", "expected")
    match = re.match(r"'(.*)' is not one of (.*)\.$", message, re.DOTALL)
    hint = did_you_mean(match[1], re.findall("'(.*?)'", match[2])) if match else ""
    return f"{message.removesuffix('.')}{hint}" if hint else message


class _LazilyImportedCommands(UserDict[str, Any]):
    """A mapping of commands by name, which imports a command when it is looked up."""

    def __getitem__(self, name: str) -> Any:
        return _import_command_for_placeholder(self.data[name])


@cache
def _find_command_entry_points() -> Mapping[str, EntryPoint]:
    listed = [name for names in _BY_PANEL.values() for name in names]
    return get_entry_points(_COMMANDS, (*listed, *_FIRST_EXPORT_SUBCOMMANDS))


def _find_help_panel(name: str) -> str:
    return next((panel for panel, names in _BY_PANEL.items() if name in names), EXTENSIONS)


def _read_command_summary(point: EntryPoint) -> str:
    """Return the first paragraph of a command's docstring, read from the source without an import.

    For a group of commands it is the docstring of the group's module, without the group's name in front.
    """
    spec = find_spec(point.module)
    if spec is None or spec.origin is None:
        raise InputError(
            f"entry point {point.name} of {_COMMANDS}: no module {point.module}; reinstall the package"
        )
    source = Path(spec.origin).read_text(encoding="utf-8")
    start = max(source.find(f"\ndef {point.attr}("), 0)
    docstring = source[start:].partition('"""')[2].partition('"""')[0]
    summary = " ".join(docstring.partition("\n\n")[0].split())
    summary = re.sub(r"\A``eai [\w ]+``: ", "", summary)
    return summary[:1].upper() + summary[1:]


@cache
def _import_command_for_placeholder(placeholder: Any) -> Any:
    """Import the command for which a placeholder stands in the group's help, and return the command."""
    if placeholder.callback is not None:
        return placeholder
    command = _import_command_with_subcommands(placeholder.name, placeholder.rich_help_panel)
    for each in _walk_commands(command):
        _add_help_texts(each)
    return command


def _import_command_with_subcommands(command_path: str, help_panel: str | None = None) -> Any:
    """Import a command or a command group. Add the commands that entry points register in the group."""
    point, name = _find_command_entry_points()[command_path], command_path.rpartition(" ")[2]
    target = point.load()
    app = typer.Typer(pretty_exceptions_enable=False, rich_markup_mode=_choose_markup_mode())
    if isinstance(target, typer.Typer):
        app.add_typer(target, name=name, help=_read_command_summary(point), rich_help_panel=help_panel)
    else:
        app.command(name, rich_help_panel=help_panel)(target)
    command: Any = get_group(app).commands[name]
    if not isinstance(command, TyperGroup):
        command.no_args_is_help = command_path in _NEED_OPTIONS or any(
            each.required for each in command.params
        )
    for below in _find_command_entry_points():
        group, _, leaf = below.rpartition(" ")
        if group == command_path:
            if not isinstance(command, TyperGroup):
                raise InputError(
                    f"rename the entry point {below} in {_COMMANDS}: "
                    f"{command_path} is a command and can have no subcommand"
                )
            command.add_command(_import_command_with_subcommands(below), leaf)
    return command


def _choose_markup_mode() -> MarkupMode:
    return "rich" if get_terminal_size().columns >= _PANELS else None


def _walk_commands(command: Any) -> Iterator[Any]:
    """Yield a command, and all commands below it if it is a group."""
    yield command
    if isinstance(command, TyperGroup):
        for each in command.commands.values():
            yield from _walk_commands(each)


def _add_help_texts(command: Any) -> None:
    """Set the help texts of a command's options from its docstring, and join the lines of paragraphs.

    The docstring describes each option below ``Options:``. Without these changes, Typer would show
    Python types of values, line breaks of the docstring, and ``--no-paper`` beside ``--paper``, which is off
    by default.
    """
    text = (command.help or "").partition("\n\nOptions:\n")[0]
    told = read_docstring_entries(command.help, "Options")
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
            from eai.abilities.protocol import find_protocol_entry_points

            parameter.help = f"{parameter.help} Here: {', '.join(('strict', *find_protocol_entry_points()))}."


app = typer.Typer(
    name="eai",
    cls=_CommandGroup,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": [*_HELP_OPTIONS]},
)


def _print_version_and_exit(asked: bool) -> None:
    if asked:
        print(f"eai {__version__}")
        raise typer.Exit


@app.callback()
def eai(
    version: Annotated[
        bool,
        typer.Option(
            "--version",
            "-V",
            callback=_print_version_and_exit,
            is_eager=True,
            help="Print the version and exit.",
        ),
    ] = False,
) -> None:
    """Measure, diagnose and train language models for embodied decision making.

    Start: eai demo   (needs no key; needs a network only to download the data set)
    """


def main() -> None:
    """Run the command line. Unusable input ends with one line on standard error and exit status 2.

    An interrupt ends with exit status 130. A request to terminate is handled as an interrupt with exit status
    143: planners are ended, their folders are removed, and finished work is saved.
    """
    interrupted_by = signal.SIGINT

    def turn_sigterm_into_interrupt(number: int, frame: object) -> None:
        nonlocal interrupted_by
        interrupted_by = signal.SIGTERM
        # a job in the background ignores interrupts, so restore the handler
        if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
            signal.signal(signal.SIGINT, signal.default_int_handler)
        signal.raise_signal(signal.SIGINT)

    signal.signal(signal.SIGTERM, turn_sigterm_into_interrupt)
    if isinstance(sys.stdout, TextIOWrapper):
        # the encoding of the locale may lack characters of the output
        sys.stdout.reconfigure(errors="backslashreplace")
    try:
        try:
            app(prog_name="eai")
        finally:
            sys.stdout.flush()
    except EaiError as error:
        from eai.cli.console import print_note

        print_note(f"eai: {error}")
        sys.exit(128 + interrupted_by if isinstance(error, UserInterruptError) else 2)
    except OSError as error:
        if error.errno not in (errno.EPIPE, *_FULL):
            raise
        # Without this, Python would try again at exit to write the output that is still buffered.
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        if error.errno == errno.EPIPE:  # the reader closed the pipe
            sys.exit(1)
        from eai.cli.console import print_note

        print_note(f"eai: the output cannot be written ({error.strerror})")
        sys.exit(2)
