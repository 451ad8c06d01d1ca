"""What is asked, and at what pace: the options of ``eai run`` about tasks, prompts and requests."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from eai.abilities.protocol import Ability, ability_of
from eai.cli.console import DOMAIN_HELP
from eai.cli.options import ABILITIES
from eai.prompts.prompt import PromptSet

_ASKED, _PACE = "What is asked", "Requests"
"""Panels of the help."""

Domains = Annotated[
    list[str] | None,
    typer.Option("--domain", help=f"{DOMAIN_HELP} All if not given.", rich_help_panel=_ASKED),
]
Abilities = Annotated[
    list[Ability] | None,
    typer.Option(
        "--ability",
        parser=ability_of,
        help=f"{ABILITIES}. All if not given.",
        rich_help_panel=_ASKED,
    ),
]
Tasks = Annotated[
    str,
    typer.Option(
        "--tasks",
        help="Only these, in suites that have them; short: forty that stand for a suite.",
        rich_help_panel=_ASKED,
    ),
]
Limit = Annotated[
    int | None,
    typer.Option("--limit", min=1, help="Tasks a suite, at most.", rich_help_panel=_ASKED),
]
Adaptive = Annotated[
    float | None,
    typer.Option(
        "--adaptive",
        min=0.05,
        metavar="S",
        help="Choose tasks by what they tell, until the ability's standard error is at most S logits.",
        rich_help_panel=_ASKED,
    ),
]
OfSet = Annotated[
    PromptSet,
    typer.Option("--set", help="Which prompts: the data set's, or ours.", rich_help_panel=_ASKED),
]
Prompts = Annotated[
    Path | None,
    typer.Option("--prompts", help="Prompts of your own.", rich_help_panel=_ASKED),
]
PromptName = Annotated[
    str | None,
    typer.Option("--prompt-name", help="What these prompts are called.", rich_help_panel=_ASKED),
]

MaxConnections = Annotated[
    int | None,
    typer.Option("--max-connections", min=1, help="Requests at a time.", rich_help_panel=_PACE),
]
MaxRetries = Annotated[
    int,
    typer.Option("--max-retries", min=0, help="Repeat a failed one so often.", rich_help_panel=_PACE),
]
Timeout = Annotated[
    int | None,
    typer.Option("--timeout", min=1, help="Seconds until one failed.", rich_help_panel=_PACE),
]
Batch = Annotated[
    bool, typer.Option("--batch", help="Use the provider's batch service.", rich_help_panel=_PACE)
]
Prices = Annotated[
    Path | None,
    typer.Option("--prices", help="Prices of models, as Inspect reads them.", rich_help_panel=_PACE),
]
