"""Options that several commands have, each with one name, one help text and one panel."""

from __future__ import annotations

from typing import Annotated

import typer

from eai.abilities.protocol import Ability, Protocol, ability_of, protocol_of
from eai.cli.console import DOMAIN_HELP
from eai.pddl.planning import PlannerChoice
from eai.scoring.options import ScoringOptions
from eai.tasks.source import ErrataChoice, errata_choice, planner_choice

ANSWERS, SCORING, OUTPUT = "What is scored", "Scoring", "Output"
"""The panels of the help of commands that score."""

ABILITIES = ", ".join(each.value for each in Ability)
"""What ``--ability`` takes."""

DOMAIN = typer.Option("--domain", help=DOMAIN_HELP, rich_help_panel=ANSWERS)
ABILITY = typer.Option(
    "--ability",
    parser=ability_of,
    help=f"{ABILITIES}.",
    rich_help_panel=ANSWERS,
)

OfAbility = Annotated[Ability, typer.Option("--ability", parser=ability_of, help=f"{ABILITIES}.")]

Rules = Annotated[
    Protocol,
    typer.Option(
        "--protocol",
        parser=protocol_of,
        help=ScoringOptions.about("protocol"),
        show_default=False,
        rich_help_panel=SCORING,
    ),
]

Planner = Annotated[
    PlannerChoice,
    typer.Option(
        "--planner",
        parser=planner_choice,
        help=ScoringOptions.about("planner"),
        show_default=False,
        rich_help_panel=SCORING,
    ),
]

Errata = Annotated[
    ErrataChoice,
    typer.Option(
        "--errata",
        parser=errata_choice,
        help=ScoringOptions.about("errata"),
        show_default=False,
        rich_help_panel=SCORING,
    ),
]

PlannerSeconds = Annotated[
    int | None,
    typer.Option(
        "--planner-seconds",
        min=1,
        help=ScoringOptions.about("planner_seconds"),
        rich_help_panel=SCORING,
    ),
]

PlannerMemory = Annotated[
    int | None,
    typer.Option(
        "--planner-memory",
        min=64,
        metavar="MIB",
        help=ScoringOptions.about("planner_memory"),
        rich_help_panel=SCORING,
    ),
]

Workers = Annotated[
    int, typer.Option("--workers", min=1, help=ScoringOptions.about("workers"), rich_help_panel=SCORING)
]

Ray = Annotated[
    str | None,
    typer.Option(
        "--ray",
        metavar="ADDRESS",
        help="Score on a cluster of Ray's, with so many --workers: auto, HOST:PORT, or local.",
        rich_help_panel=SCORING,
    ),
]

Explanations = Annotated[
    bool,
    typer.Option(
        "--explanations/--no-explanations",
        help=ScoringOptions.about("explanations"),
        rich_help_panel=SCORING,
    ),
]

AllowMissing = Annotated[
    bool,
    typer.Option(
        "--allow-missing",
        help=ScoringOptions.about("allow_missing"),
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


def listed(text: str | None) -> list[str]:
    """What an option names, separated by commas."""
    return [name.strip() for name in (text or "").split(",") if name.strip()]
