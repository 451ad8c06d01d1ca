"""The options of ``eai run`` about the scene: told, in pictures, as another model sees it, or with errors."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from eai.studies.perception.pictures import Clutter
from eai.studies.perception.showing import Scene

PANEL = "Perception (with --set eai)"

InScene = Annotated[
    Scene,
    typer.Option(
        "--scene",
        metavar="HOW",
        help="How questions show the scene: text, image, both, predicted or noisy.",
        rich_help_panel=PANEL,
    ),
]
SceneImages = Annotated[
    Path | None,
    typer.Option(
        "--images",
        help="Pictures of your own: files that begin with the id of their task. Schematic ones if not given.",
        rich_help_panel=PANEL,
    ),
]
InClutter = Annotated[
    Clutter | None,
    typer.Option("--clutter", help="How much else is in schematic pictures.", rich_help_panel=PANEL),
]
SceneModel = Annotated[
    str | None,
    typer.Option(
        "--scene-model",
        metavar="NAME",
        help="Who makes the list of --scene predicted from pictures; eai/eyes: built in, errs now and then.",
        rich_help_panel=PANEL,
    ),
]
SceneModelArgument = Annotated[
    list[str] | None,
    typer.Option(
        "--scene-arg", metavar="KEY=VALUE", help="An argument of that model.", rich_help_panel=PANEL
    ),
]
SceneModelUrl = Annotated[
    str | None,
    typer.Option("--scene-base-url", help="Where its server listens.", rich_help_panel=PANEL),
]
SceneNoise = Annotated[
    list[str] | None,
    typer.Option(
        "--noise",
        metavar="NAME=RATE",
        help="Of --scene noisy: missing, misplaced, unnecessary, invented, unseen; seed.",
        rich_help_panel=PANEL,
    ),
]
