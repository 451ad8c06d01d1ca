"""Options that several commands have, each with one name, one help text and one panel."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, ClassVar

import typer
from typer.core import TyperCommand

from eai.abilities.options import Options
from eai.abilities.protocol import FOUR, Ability, Protocol, ability_of, protocol_of
from eai.cli.console import DOMAIN_HELP
from eai.errors import InputError
from eai.pddl.planning import PlannerChoice
from eai.scoring.options import ScoringOptions
from eai.tasks.source import ErrataChoice, errata_choice, planner_choice

ANSWERS, SCORING, OUTPUT = "What is scored", "Scoring", "Output"
"""The panels of the help of commands that score."""

ABILITIES = f"{', '.join(FOUR)}, or another one by its name"
"""What ``--ability`` takes."""

DOMAIN = typer.Option("--domain", help=DOMAIN_HELP, rich_help_panel=ANSWERS)
ABILITY = typer.Option(
    "--ability",
    parser=ability_of,
    help=f"{ABILITIES}.",
    rich_help_panel=ANSWERS,
)

OfAbility = Annotated[Ability, typer.Option("--ability", parser=ability_of, help=f"{ABILITIES}.")]


def flag(options: type[Options], option: str, panel: str, *names: str, **more: Any) -> Any:
    """The flag of an option of a run's specification, with its meaning and its limits."""
    field = options.model_fields[option]
    for end, name in (("min", "ge"), ("max", "le")):
        more |= {end: getattr(each, name) for each in field.metadata if hasattr(each, name)}  # noqa: B035
    return typer.Option(*names, help=field.description, rich_help_panel=panel, **more)


def _scoring(option: str, *names: str, **more: Any) -> Any:
    return flag(ScoringOptions, option, SCORING, *names, **more)


Rules = Annotated[Protocol, _scoring("protocol", "--protocol", parser=protocol_of)]
Planner = Annotated[PlannerChoice, _scoring("planner", parser=planner_choice)]
Errata = Annotated[ErrataChoice, _scoring("errata", parser=errata_choice)]
PlannerSeconds = Annotated[int | None, _scoring("planner_seconds")]
PlannerMemory = Annotated[int | None, _scoring("planner_memory", metavar="MIB")]
Workers = Annotated[int, _scoring("workers")]
Explanations = Annotated[bool, _scoring("explanations")]
AllowMissing = Annotated[bool, _scoring("allow_missing", "--allow-missing")]

Ray = Annotated[
    str | None,
    typer.Option(
        "--ray",
        metavar="ADDRESS",
        help="Score on a cluster of Ray's, with so many --workers: auto, HOST:PORT, or local.",
        rich_help_panel=SCORING,
    ),
]

AsJson = Annotated[
    bool, typer.Option("--json", help="Print the results as JSON, and nothing else.", rich_help_panel=OUTPUT)
]

Wide = Annotated[
    bool,
    typer.Option("--wide", help="All columns in one table, however wide.", rich_help_panel=OUTPUT),
]


SETTING = "--with"
"""The flag for options that have no flag of their own."""


class SettingsCommand(TyperCommand):
    """A command that names the setting that a flag has become."""

    listed_by: ClassVar[str] = ""
    """The command that lists all settings."""

    def moved(self, args: Sequence[str]) -> Mapping[str, str]:
        """The flags that are settings now, with what to write instead."""
        return {}

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Parse a command line.

        Raises:
            InputError: a flag is none any more.
        """
        now = self.moved(args)
        for name in [text.partition("=")[0] for text in args]:
            if name in now:
                raise InputError(f"{name}: write {SETTING} {now[name]} ({self.listed_by} lists all options)")
        return super().parse_args(ctx, args)


def listed(text: str | None) -> list[str]:
    """What an option names, separated by commas."""
    return [name.strip() for name in (text or "").split(",") if name.strip()]
