"""Commands that are imported when they are asked for: most of what the others need is never loaded."""

from __future__ import annotations

from collections import UserDict
from collections.abc import Iterator, Mapping
from importlib import import_module
from shutil import get_terminal_size
from typing import Any, ClassVar, NamedTuple

from typer import Typer
from typer.core import MarkupMode, TyperCommand, TyperGroup
from typer.main import get_group

from eai.cli.helped import label
from eai.scoring.collector import collecting_seldom


class Place(NamedTuple):
    """Where a command is, and where it stands in the help.

    Attributes:
        module: a module of this package.
        name: what it is called there: a function, or an app that has commands of its own.
        panel: the panel in the help.
        kind: the class of the command, in the same module; Typer's own if None.
        bare: whether it does something without any argument, instead of printing its help.
        summary: the first paragraph of its help, so that the help of the group imports no command.
    """

    module: str
    name: str = "app"
    panel: str | None = None
    kind: str | None = None
    bare: bool = False
    summary: str = ""


PANELS = 80
"""How many columns help in panels takes; where there are fewer, it would cut the names of options."""


def _help_mode() -> MarkupMode:
    return "rich" if get_terminal_size().columns >= PANELS else None


class _Commands(UserDict[str, Any]):
    """Commands by name, or where they are until one is asked for."""

    def __getitem__(self, name: str) -> Any:
        found = self.data[name]
        if isinstance(found, Place):
            found = self.data[name] = _imported(name, found)
        return found


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
        """Write the help of the group, for which no command with a summary is imported."""
        label(self)
        commands = self.commands
        self.commands = {
            name: _summarised(name, place) if place.summary else commands[name]
            for name, place in self.places.items()
        } | {name: commands[name] for name in commands if name not in self.places}
        try:
            super().format_help(ctx, formatter)
        finally:
            self.commands = commands


def _summarised(name: str, place: Place) -> TyperCommand:
    """A command of which no more is known than its summary."""
    return TyperCommand(name, help=place.summary, rich_help_panel=place.panel)


def _imported(name: str, place: Place) -> Any:
    with collecting_seldom():
        module = import_module(f"{__package__}.{place.module}")
    found, kind = getattr(module, place.name), getattr(module, place.kind) if place.kind else None
    app = Typer(pretty_exceptions_enable=False, rich_markup_mode=_help_mode())
    if isinstance(found, Typer):
        app.add_typer(found, name=name, rich_help_panel=place.panel)
    else:
        app.command(name, cls=kind, no_args_is_help=not place.bare, rich_help_panel=place.panel)(found)
    command: Any = get_group(app).commands[name]
    for each in _with_those_below(command):
        label(each)
    return command


def _with_those_below(command: Any) -> Iterator[Any]:
    """A command and, of a group that is not lazy itself, its commands."""
    yield command
    if isinstance(command, TyperGroup) and not isinstance(command, LazyGroup):
        yield from command.commands.values()
