"""The options of ``eai run`` that make a run an experiment."""

from __future__ import annotations

from typing import Annotated

import typer

from eai.abilities.experiment import Feedback, FeedbackForm, World
from eai.world.episode import Notice, Until

PANEL = "Experiments (action sequencing)"
PIPELINES = "Pipelines (action sequencing, subgoal decomposition)"

OWN = "own"
"""What ``--goals`` takes for the goals that the model itself is asked for first."""

Goals = Annotated[
    str | None,
    typer.Option(
        "--goals",
        metavar="own|PATH",
        help="Ask with interpreted goals: the model's own, asked for first, or those in a file or "
        "folder of answers to goal interpretation.",
        rich_help_panel=PIPELINES,
    ),
]

Replans = Annotated[
    int,
    typer.Option(min=0, help="Further attempts at a task that fails.", rich_help_panel=PANEL),
]
InWorld = Annotated[
    World, typer.Option("--world", help="Where further attempts begin.", rich_help_panel=PANEL)
]
OfFeedback = Annotated[
    Feedback | None,
    typer.Option(
        "--feedback",
        metavar="HOW",
        help="What is told of failures: explained (if not given), kind, state, or none: the same question.",
        rich_help_panel=PANEL,
    ),
]
InForm = Annotated[
    FeedbackForm, typer.Option("--feedback-form", help="Where it is told.", rich_help_panel=PANEL)
]
Slip = Annotated[
    float,
    typer.Option(min=0, max=1, help="How likely an action does not work.", rich_help_panel=PANEL),
]
SlipSeed = Annotated[int, typer.Option(help="The seed of the slips.", rich_help_panel=PANEL)]
OfNotice = Annotated[
    Notice, typer.Option("--slip-notice", help="Whether a slip is noticed.", rich_help_panel=PANEL)
]
Ending = Annotated[
    Until | None,
    typer.Option(
        "--until",
        metavar="WHEN",
        help="An attempt ends with its plan (done), or in the first state with all goals (goal; if not "
        "given, where the world goes on).",
        rich_help_panel=PANEL,
    ),
]
Preset = Annotated[
    str,
    typer.Option(
        "--preset",
        metavar="NAME",
        help="eai-1.0.5: slips as the reference's script has them, three replans, the state told.",
        rich_help_panel=PANEL,
    ),
]
