"""How ``eai run`` shows the scene: as text, in pictures, as a second model sees it, or with errors."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import Annotated

import typer

from eai.abilities.protocol import Ability
from eai.abilities.responses import file_name
from eai.errors import InputError
from eai.perception.noise import Noise
from eai.perception.pictures import Clutter
from eai.run.job import EYES, PROVIDER, Endpoint, check_model

PANEL = "Perception (with --set eai)"


class Scene(str, Enum):
    """How a question shows the scene (paper, appendix on vision models: experiments 0, 1, 2 and 5).

    ``text``: as a list of what holds. ``image``: in pictures alone. ``both``: in both. ``predicted``: as the
    list that a second model made from pictures. ``noisy``: as a list with seeded errors.
    """

    TEXT = "text"
    IMAGE = "image"
    BOTH = "both"
    PREDICTED = "predicted"
    NOISY = "noisy"


ABILITIES = (Ability.GOAL_INTERPRETATION, Ability.SUBGOAL_DECOMPOSITION, Ability.ACTION_SEQUENCING)
"""The abilities whose questions tell of a scene."""

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
        metavar="DIR",
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
    typer.Option("--scene-base-url", metavar="URL", help="Where its server listens.", rich_help_panel=PANEL),
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


@dataclass(frozen=True, slots=True)
class SceneChoice:
    """What the command line says of the scene.

    Raises:
        InputError: it makes no sense; the message names the option.
    """

    scene: Scene
    images: Path | None
    clutter: Clutter | None
    eyes: Endpoint | None
    noise: Noise | None

    def __post_init__(self) -> None:
        pictured = self.scene in (Scene.IMAGE, Scene.BOTH, Scene.PREDICTED)
        for option, given, fits in (
            ("--images", self.images, pictured),
            ("--clutter", self.clutter, pictured),
            ("--scene-model", self.eyes, self.scene is Scene.PREDICTED),
            ("--noise", self.noise, self.scene is Scene.NOISY),
        ):
            if given is not None and not fits:
                raise InputError(f"{option}: means nothing with --scene {self.scene.value}")
        if self.images is not None and self.clutter is not None:
            raise InputError("--clutter: is of schematic pictures, not of --images")
        if self.scene is Scene.PREDICTED and self.eyes is None:
            raise InputError("--scene predicted: expected --scene-model, who sees; eai/eyes is built in")
        if self.scene is Scene.NOISY and self.noise is None:
            raise InputError("--scene noisy: expected --noise NAME=RATE, such as --noise missing=0.1")
        if self.eyes is not None:
            check_model(self.eyes.model)
            provider, _, name = self.eyes.model.partition("/")
            if provider == PROVIDER and name != EYES:
                raise InputError(
                    f"--scene-model {self.eyes.model}: expected {PROVIDER}/{EYES} or another provider"
                )

    @property
    def label(self) -> str:
        """What tells it from other ways to show the scene."""
        if self.noise is not None:
            return f"{self.scene.value}-{self.noise.label}"
        who = "" if self.eyes is None else f"-{file_name(self.eyes.model)}"
        return f"{self.scene.value}{who}{self.pictures}"

    @property
    def pictures(self) -> str:
        """What tells its pictures from others."""
        if self.images is not None:
            return "-own"
        return "" if self.clutter in (None, Clutter.NONE) else f"-{self.clutter.value}"


def refuse_besides(choice: SceneChoice, experiments: Mapping[str, object]) -> None:
    """Raise if a run is another experiment besides showing the scene in some way.

    Args:
        choice: what the command line says of the scene.
        experiments: the options of other experiments, with what was given.
    """
    for option, given in experiments.items():
        if given and choice.scene is not Scene.TEXT:
            raise InputError(f"{option}: not with --scene {choice.scene.value}")


def scene_abilities(abilities: Collection[Ability] | None, scene: Scene) -> list[Ability]:
    """The abilities that are asked for, in order; all that tell of a scene if none is named.

    Raises:
        InputError: the questions of one that is named tell of none.
    """
    for each in abilities or ():
        if each not in ABILITIES:
            raise InputError(f"--scene {scene.value}: questions of {each.value} tell of no scene")
    return [each for each in Ability if each in (abilities or ABILITIES)]
