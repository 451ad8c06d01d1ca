"""Commands that are imported when they are asked for, and their help: most of the package is never loaded."""

from __future__ import annotations

from collections import UserDict
from collections.abc import Iterator, Mapping
from importlib import import_module
from shutil import get_terminal_size
from typing import Any, ClassVar, NamedTuple

from typer import Typer
from typer.core import MarkupMode, TyperCommand, TyperGroup
from typer.main import get_group

from eai.scoring.collector import collecting_seldom

HELP_OPTIONS = ("-h", "--help")

METAVARS: Mapping[str, str] = {
    f"--{option}": metavar
    for metavar, options in {
        "NAME": "ability domain errata like metric model planner prompt-name protocol reference split",
        "N": "bins conditions depth epochs examples limit max-connections max-tokens n objects"
        " sample seed workers",
        "P": "least",
        "S": "planner-seconds",
        "X": "margin",
        "DIR": "data images out prompts",
        "FILE": "explorer prices",
        "PATH": "demonstrations from goals",
        "ID,ID": "tasks",
        "SECRET": "secret",
        "URL": "model-base-url",
    }.items()
    for option in options.split()
}
"""The name of an option's value where the option does not say it itself."""

PANELS = 80
"""How many columns help in panels takes; where there are fewer, it would cut the names of options."""


class Place(NamedTuple):
    """Where a command is, and where it stands in the help.

    Attributes:
        panel: the panel in the help.
        summary: the first paragraph of its help, so that the help of the group imports no command.
        target: the module in this package and the name there, of a function or of an app with commands; both
            are the command's name if empty.
        kind: the class of the command, in the same module; Typer's own if None.
        bare: whether it does something without any argument, instead of printing its help.
    """

    panel: str
    summary: str
    target: str = ""
    kind: str | None = None
    bare: bool = False


class LazyGroup(TyperGroup):
    """A group whose commands are imported when they are asked for.

    Attributes:
        places: where they are, by name, in the order of the help.
    """

    places: ClassVar[Mapping[str, Place]]

    def __init__(self, **attributes: Any) -> None:
        super().__init__(**{**attributes, "rich_markup_mode": _help_mode()})
        self.commands = _Commands({**self.places, **self.commands})

    def list_commands(self, ctx: Any) -> list[str]:
        """The names of the commands, for which none needs to be imported."""
        return list(self.commands)

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Write the help of the group, for which no command is imported."""
        label(self)
        commands = self.commands
        self.commands = {
            name: TyperCommand(name, help=place.summary, rich_help_panel=place.panel)
            for name, place in self.places.items()
        } | {name: commands[name] for name in commands if name not in self.places}
        try:
            super().format_help(ctx, formatter)
        finally:
            self.commands = commands


class _Commands(UserDict[str, Any]):
    """Commands by name, or where they are until one is asked for."""

    def __getitem__(self, name: str) -> Any:
        found = self.data[name]
        if isinstance(found, Place):
            found = self.data[name] = _imported(name, found)
        return found


def _imported(name: str, place: Place) -> Any:
    module_name, _, attribute = (place.target or f"{name}:{name}").partition(":")
    with collecting_seldom():
        module = import_module(f"{__package__}.{module_name}")
    found, kind = getattr(module, attribute), getattr(module, place.kind) if place.kind else None
    app = Typer(pretty_exceptions_enable=False, rich_markup_mode=_help_mode())
    if isinstance(found, Typer):
        app.add_typer(found, name=name, rich_help_panel=place.panel)
    else:
        app.command(name, cls=kind, no_args_is_help=not place.bare, rich_help_panel=place.panel)(found)
    command: Any = get_group(app).commands[name]
    for each in _with_those_below(command):
        label(each)
    return command


def _help_mode() -> MarkupMode:
    return "rich" if get_terminal_size().columns >= PANELS else None


def _with_those_below(command: Any) -> Iterator[Any]:
    """A command and, of a group, all commands below it."""
    yield command
    if isinstance(command, TyperGroup):
        for each in command.commands.values():
            yield from _with_those_below(each)


def label(command: Any) -> None:
    """Have the help of a command name values by their metavars alone, and fill its paragraphs.

    Typer would say of each value what Python reads it as, and break lines where the docstring does.
    """
    command.help = "\n\n".join(" ".join(part.split()) for part in (command.help or "").split("\n\n"))
    for parameter in command.get_params(command.context_class(command, help_option_names=[*HELP_OPTIONS])):
        if parameter.param_type_name == "argument":
            parameter.metavar = parameter.metavar or parameter.name.upper()
            parameter.display_type_rich = _nothing
        elif parameter.metavar is None:
            name = max(parameter.opts, key=len)
            parameter.metavar = METAVARS.get(name, "" if parameter.is_flag else None)
        if "--protocol" in parameter.opts:
            from eai.abilities.protocol import registered_protocols

            parameter.help = f"{parameter.help} Here: {', '.join(('strict', *registered_protocols()))}."


def _nothing(ctx: Any) -> str:
    return ""
