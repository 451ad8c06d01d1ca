"""Define the options of the study of perception: how questions show the scene."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Annotated, Literal, TypeAlias

from pydantic import BeforeValidator, Field, model_validator
from typing_extensions import Self

from eai.abilities.experiment import StudySettings
from eai.abilities.protocol import SCENE_GRAPH, Ability
from eai.base.errors import InputError
from eai.base.files import to_file_name
from eai.studies.perception.noise import PerceptionNoise, parse_noise
from eai.studies.variation import VariationOptions
from eai.tasks.options import Arguments, WebAddress

STUDY = "perception"
"""Name of this study. Records store its options (such as the scene's format) and results by this name."""

SceneFormat: TypeAlias = Literal[
    "text", "image", "both", "predicted", "noisy", "rendered", "numbered", "pointed"
]
"""Format of the scene in a question (paper, appendix on vision models: experiments 0, 1, 2 and 5).

- text: a list of facts.
- image: only pictures.
- both: facts and pictures.
- predicted: the list of facts that a second model made from pictures.
- noisy: a list of facts with random errors, reproducible by a seed.
- rendered (not in the paper): pictures rendered from 3D bodies of objects.
- numbered (not in the paper): rendered pictures with a number at each object.
- pointed (not in the paper): rendered pictures, with a pixel and the name of each object.
"""

Clutter: TypeAlias = Literal["none", "some", "many"]
"""Choice of how many objects a picture shows beside the objects of the task.

``none``: no other objects. ``some``: at most one other object for each object of the task. ``many``: at most
four for each, or fewer if the picture would be too high. Objects in or on objects of the task come first.
"""

PICTURE_FORMATS = ("image", "rendered", "numbered", "pointed")
"""Formats in which questions show the scene only in pictures."""

SCENE_ABILITIES = (Ability.GOAL_INTERPRETATION, Ability.SUBGOAL_DECOMPOSITION, Ability.ACTION_SEQUENCING)
"""Abilities (kinds of question) whose questions describe a scene, in the order of reports."""


def _parse_error_rates_of_noisy_scene(option: object) -> object:
    """Return the error rates of a noisy scene, from a table or from texts such as ``missing=0.1``."""
    if isinstance(option, Mapping):
        option = [f"{name}={rate}" for name, rate in option.items()]
    elif isinstance(option, str):
        option = [option]
    return parse_noise([str(setting) for setting in option]) if isinstance(option, list | tuple) else option


class ScenePresentationOptions(VariationOptions):
    """How the questions of a run show the scene.

    Raises:
        InputError: options contradict each other, or a needed option is missing; the message names the
            options.

    Attributes:
        scene: How questions show the scene: text, image, both, predicted (facts that a second model lists),
            noisy (facts with seeded errors), rendered (pictures of 3D bodies), numbered (rendered, with a
            number at each object) or pointed (rendered, with a pixel of each object).
        context: How much more a list of facts describes, if the scene is text or both: none, some or many
            other objects, and states that do not hold.
        images: A folder with your own pictures; their file names begin with the id of the task. Without it,
            schematic pictures are drawn.
        clutter: How many other objects schematic pictures show: none, some or many.
        noise: The rates of errors in a noisy scene, such as noise.missing=0.1: missing, misplaced,
            unnecessary, invented, unseen; and noise.seed.
        scene_model: The model that lists a predicted scene from pictures; eai/captioner is built in and errs
            now and then.
        scene_args: Arguments of that model, such as scene_args.rate=0.2.
        scene_base_url: The address of its server.
    """

    scene: SceneFormat = "text"
    context: Clutter | None = None
    images: Path | None = None
    clutter: Clutter | None = None
    noise: Annotated[PerceptionNoise | None, BeforeValidator(_parse_error_rates_of_noisy_scene)] = None
    scene_model: str | None = None
    scene_args: Arguments = Field(default={})
    scene_base_url: WebAddress | None = None

    @model_validator(mode="after")
    def _check_options(self) -> Self:
        scene_option = f"perception.scene {self.scene}"
        pictured = self.scene in ("image", "both", "predicted")
        for name, given, fits in (
            ("context", self.context, self.scene in ("text", "both")),
            ("images", self.images, pictured),
            ("clutter", self.clutter, pictured),
            ("scene_model", self.scene_model, self.scene == "predicted"),
            ("noise", self.noise, self.scene == "noisy"),
        ):
            if given is not None and not fits:
                raise InputError(f"perception.{name}: has no effect with {scene_option}; leave it out")
        if self.images is not None and self.clutter is not None:
            raise InputError(
                "perception.clutter: has no effect on your own pictures (perception.images); leave it out"
            )
        if self.scene == "predicted" and self.scene_model is None:
            raise InputError(
                f"{scene_option}: also give perception.scene_model, the model that lists the scene, such as "
                "the built-in model eai/captioner"
            )
        if self.scene == "noisy" and self.noise is None:
            raise InputError(
                f"{scene_option}: expected rates of errors, such as perception.noise.missing=0.1"
            )
        if self.scene_model is None and (self.scene_args or self.scene_base_url is not None):
            raise InputError(
                "perception.scene_args, perception.scene_base_url: have no effect without "
                "perception.scene_model; also give the model to which they belong"
            )
        return self

    @property
    def option_that_enables_study(self) -> str:
        """Name and value of the chosen option: ``perception.scene``, or else ``perception.context``.

        The latter adds facts to questions: about objects outside the shown scene, and states that do not
        hold. The text is empty if no option is chosen.
        """
        if self.scene != "text":
            return f"perception.scene {self.scene}"
        return f"perception.context {self.context}" if self._label_suffix_of_context_option else ""

    @property
    def results_heading(self) -> str:
        """Heading above the results of a run. It names the format in which questions show the scene."""
        return f"scene: {self.label_of_chosen_options}"

    def make_study_settings_to_store_in_records(self, study_name: str) -> StudySettings | None:
        """Return None. Records get these options with the scenes (`GoalsAndScenesStatedInPrompts`)."""
        return None

    @property
    def captioning_model(self) -> str | None:
        """Model that describes pictures by a scene graph; None if the scene is not ``predicted``."""
        return self.scene_model

    @property
    def changed_task_part(self) -> Literal["", "scene", "goals"]:
        """The part of a question that this study changes: the scene."""
        return "scene"

    def explain_conflict(self, other: VariationOptions) -> str:
        """Return why a run cannot combine these options with another study's options; empty if it can."""
        acted = other.replanning
        if acted is not None and acted.world == "continue" and acted.feedback != "none":
            if not self.can_question_show_scene_after_actions:
                return "the scene is only shown at the start, but feedback describes a changed world"
            if self.scene in ("image", "both") and acted.form == "chat":
                return "a chat cannot show pictures of a changed world"
        return super().explain_conflict(other)

    @property
    def can_question_show_scene_after_actions(self) -> bool:
        """Whether a question after some actions can show the scene as these actions changed it.

        Pictures that the user gave, and scenes that a second model listed before the run, cannot change.
        """
        return self.scene in ("text", "noisy", "image", "both") and self.images is None

    def select_abilities(self, requested: Collection[Ability]) -> list[Ability]:
        """Return, in order, the abilities whose questions describe a scene.

        If the user names abilities, return only these. The ability ``scene_graph`` is included only if the
        user names it and only pictures show the scene.

        Raises:
            InputError: the questions of a named ability describe no scene.
        """
        possible = (*SCENE_ABILITIES, SCENE_GRAPH) if self.scene in PICTURE_FORMATS else SCENE_ABILITIES
        for ability in requested:
            if ability not in possible:
                raise InputError(
                    f"perception.scene {self.scene}: questions of {ability.value} describe no scene; "
                    f"choose one of the abilities {', '.join([ability.value for ability in possible])}"
                )
        return [ability for ability in possible if ability in (requested or SCENE_ABILITIES)]

    @property
    def label_of_chosen_options(self) -> str:
        """Short text that names the chosen options, different for each choice."""
        if self.noise is not None:
            return f"{self.scene}-{self.noise.label}"
        who = "" if self.scene_model is None else f"-{to_file_name(self.scene_model)}"
        return (
            f"{self.scene}{who}{self._label_suffix_of_picture_options}{self._label_suffix_of_context_option}"
        )

    def make_options_that_show_only_pictures(self) -> Self:
        """Return options for questions that ask a model to describe the scenes: same pictures, no text."""
        return type(self)(scene="image", images=self.images, clutter=self.clutter)

    @property
    def _label_suffix_of_context_option(self) -> str:
        return "" if self.context in (None, "none") else f"-context-{self.context}"

    @property
    def _label_suffix_of_picture_options(self) -> str:
        if self.images is not None:
            return "-own"
        return "" if self.clutter in (None, "none") else f"-{self.clutter}"
