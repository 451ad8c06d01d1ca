"""How questions show the scene: the options of a run."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Annotated, Literal, TypeAlias

from pydantic import BeforeValidator, Field, model_validator
from typing_extensions import Self

from eai.abilities.protocol import SCENE_GRAPH, Ability
from eai.base.errors import InputError
from eai.base.files import to_file_name
from eai.studies.perception.noise import Noise, noise_of
from eai.studies.variation import Variation
from eai.tasks.options import Arguments

STUDY = "perception"
"""Name of the study in records."""

Showing: TypeAlias = Literal["text", "image", "both", "predicted", "noisy", "rendered", "numbered", "pointed"]
"""How a question shows the scene (paper, appendix on vision models: experiments 0, 1, 2 and 5).

``text``: as a list of what holds. ``image``: in pictures alone. ``both``: in both. ``predicted``: as the list
that a second model made from pictures. ``noisy``: as a list with seeded errors. Ours are ``rendered``: in
pictures of things with bodies; ``numbered``: in these, with a number at each thing; and ``pointed``: in these
as they are, and a pixel of each thing with its name.
"""

Clutter: TypeAlias = Literal["none", "some", "many"]
"""How much a picture shows besides what the task is about.

``none``: nothing. ``some``: up to as many other objects. ``many``: up to four times as many; fewer where the
picture would be too high. Objects that are in or on what is shown come first. Where a scene
has no other objects, all three are alike.
"""

PICTURED = ("image", "rendered", "numbered", "pointed")
"""The ways to show it in pictures alone."""

ABILITIES = (Ability.GOAL_INTERPRETATION, Ability.SUBGOAL_DECOMPOSITION, Ability.ACTION_SEQUENCING)
"""The abilities whose questions tell of a scene."""


def _noise(given: object) -> object:
    """Noise as a table of rates, or as texts such as ``missing=0.1``."""
    if isinstance(given, Mapping):
        given = [f"{name}={rate}" for name, rate in given.items()]
    elif isinstance(given, str):
        given = [given]
    return noise_of([str(each) for each in given]) if isinstance(given, list | tuple) else given


class Perception(Variation):
    """How the questions of a run show the scene.

    Raises:
        InputError: it makes no sense; the message names the option.

    Attributes:
        scene: How questions show the scene: text, image, both, predicted (as a second model lists it), noisy
            (with seeded errors), rendered (with bodies), numbered (with a number at each thing) or pointed
            (with a pixel of each thing).
        context: How much else a list of facts tells of the scene, with text or both: none, some or many other
            objects, and states that do not hold.
        images: A folder with pictures of your own: files that begin with the id of their task. Schematic ones
            if not given.
        clutter: How much else is in schematic pictures: none, some or many.
        noise: The rates of errors in a noisy scene, such as noise.missing=0.1: missing, misplaced,
            unnecessary, invented, unseen; and noise.seed.
        scene_model: The model that lists a predicted scene from pictures; eai/captioner: built in, errs now
            and then.
        scene_args: Arguments of that model, such as scene_args.rate=0.2.
        scene_base_url: The address of its server.
    """

    scene: Showing = "text"
    context: Clutter | None = None
    images: Path | None = None
    clutter: Clutter | None = None
    noise: Annotated[Noise | None, BeforeValidator(_noise)] = None
    scene_model: str | None = None
    scene_args: Arguments = Field(default={})
    scene_base_url: str | None = None

    @model_validator(mode="after")
    def _without_contradictions(self) -> Self:
        how = f"perception.scene {self.scene}"
        pictured = self.scene in ("image", "both", "predicted")
        for name, given, fits in (
            ("context", self.context, self.scene in ("text", "both")),
            ("images", self.images, pictured),
            ("clutter", self.clutter, pictured),
            ("scene_model", self.scene_model, self.scene == "predicted"),
            ("noise", self.noise, self.scene == "noisy"),
        ):
            if given is not None and not fits:
                raise InputError(f"perception.{name}: means nothing with {how}")
        if self.images is not None and self.clutter is not None:
            raise InputError("perception.clutter: is of schematic pictures, not of perception.images")
        if self.scene == "predicted" and self.scene_model is None:
            raise InputError(f"{how}: expected perception.scene_model, who sees; eai/captioner is built in")
        if self.scene == "noisy" and self.noise is None:
            raise InputError(f"{how}: expected rates of errors, such as perception.noise.missing=0.1")
        if self.scene_model is None and (self.scene_args or self.scene_base_url is not None):
            raise InputError("perception.scene_args, scene_base_url: expected perception.scene_model")
        return self

    @property
    def choice(self) -> str:
        """The scene, if questions do not list it as it is, or the context that they tell besides."""
        if self.scene != "text":
            return f"perception.scene {self.scene}"
        return f"perception.context {self.context}" if self._context else ""

    @property
    def heading(self) -> str:
        """How the scene is shown."""
        return f"scene: {self.label}"

    def recorded(self, study: str) -> None:
        """Return None: the stage states how the scene is shown."""

    @property
    def captioner(self) -> str | None:
        """The model that lists a predicted scene."""
        return self.scene_model

    @property
    def states(self) -> Literal["", "scene", "goals"]:
        """The scene."""
        return "scene"

    def contradiction(self, other: Variation) -> str:
        """Return why scenes cannot be shown so in the other study, whose world may change."""
        acted = other.attempts
        if acted is not None and acted.world == "continue" and acted.feedback != "none":
            if not self.can_look_again:
                return "the scene is seen at the start alone, and feedback tells of a world that has changed"
            if self.scene in ("image", "both") and acted.form == "chat":
                return "pictures of a world that has changed have no place in a chat"
        return super().contradiction(other)

    @property
    def can_look_again(self) -> bool:
        """Whether a scene that has changed can be shown: no model and no files of the user's show it."""
        return self.scene in ("text", "noisy", "image", "both") and self.images is None

    def abilities(self, named: Collection[Ability]) -> list[Ability]:
        """Return the abilities whose questions tell of a scene, in order; those of `named` if any are.

        Scene graphs are listed from pictures only, and only if they are named.

        Raises:
            InputError: the questions of an ability that is named tell of no scene.
        """
        possible = (*ABILITIES, SCENE_GRAPH) if self.scene in PICTURED else ABILITIES
        for ability in named:
            if ability not in possible:
                raise InputError(
                    f"perception.scene {self.scene}: questions of {ability.value} tell of no scene"
                )
        return [ability for ability in possible if ability in (named or ABILITIES)]

    @property
    def label(self) -> str:
        """A short text that tells it from other ways to show the scene."""
        if self.noise is not None:
            return f"{self.scene}-{self.noise.label}"
        who = "" if self.scene_model is None else f"-{to_file_name(self.scene_model)}"
        return f"{self.scene}{who}{self._pictures}{self._context}"

    def of_pictures(self) -> Self:
        """The way to show the same pictures alone, as a captioner sees them."""
        return type(self)(scene="image", images=self.images, clutter=self.clutter)

    @property
    def _context(self) -> str:
        """A short text that tells how much else is told."""
        return "" if self.context in (None, "none") else f"-context-{self.context}"

    @property
    def _pictures(self) -> str:
        """A short text that tells its pictures from others."""
        if self.images is not None:
            return "-own"
        return "" if self.clutter in (None, "none") else f"-{self.clutter}"
