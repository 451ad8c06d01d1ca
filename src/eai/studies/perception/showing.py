"""How questions show scenes: what is chosen, and what each question then tells and shows."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from enum import Enum
from pathlib import Path

from eai.abilities.protocol import Ability
from eai.abilities.responses import file_name
from eai.abilities.task import Task
from eai.benchmark.benchmark import Benchmark
from eai.benchmark.prompt_library import Library
from eai.benchmark.suite import Suite
from eai.errors import InputError
from eai.prompts.prompt import Image, Prompt, PromptSet
from eai.prompts.template import Templates
from eai.studies.perception.belief import scene_words
from eai.studies.perception.noise import Noise, perceive
from eai.studies.perception.pictures import Clutter, drawn_images, images_in
from eai.studies.perception.scene_graph import ReadGraph, read_scene_graph
from eai.studies.perception.scenes import PerceivedScenes, perceived_scenes, pictured_scenes


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


@dataclass(frozen=True, slots=True)
class SceneChoice:
    """How the questions of a run show the scene.

    Attributes:
        scene: in which of the five ways.
        images: the folder with people's own pictures; None for schematic ones.
        clutter: how much else is in schematic pictures; None for nothing.
        eyes: the model that sees for another one.
        noise: the errors that are put in.

    Raises:
        InputError: it makes no sense; the message names the option.
    """

    scene: Scene = Scene.TEXT
    images: Path | None = None
    clutter: Clutter | None = None
    eyes: str | None = None
    noise: Noise | None = None

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

    @property
    def label(self) -> str:
        """What tells it from other ways to show the scene."""
        if self.noise is not None:
            return f"{self.scene.value}-{self.noise.label}"
        who = "" if self.eyes is None else f"-{file_name(self.eyes)}"
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
        choice: how questions show the scene.
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


def shown_scenes(
    choice: SceneChoice, benchmark: Benchmark, tasks: Mapping[str, Task], templates: Templates
) -> PerceivedScenes:
    """What questions show where no second model sees for the one who is asked.

    Raises:
        InputError: there is no picture of a task.
        EaiError: the library that draws pictures is not installed.
    """
    if choice.noise is not None:
        words = scene_words(benchmark)
        seen = {i: ReadGraph(perceive(task, words, choice.noise)) for i, task in tasks.items()}
        return perceived_scenes(choice.label, tasks, words, seen)
    told = templates.text(f"scene_{choice.scene.value}.txt")
    return pictured_scenes(choice.label, tasks, pictures_for(choice, benchmark, tasks), told)


def pictures_for(
    choice: SceneChoice, benchmark: Benchmark, tasks: Mapping[str, Task]
) -> Mapping[str, tuple[Image, ...]]:
    """The pictures of each task.

    Raises:
        InputError, EaiError: as of `shown_scenes`.
    """
    if choice.images is not None:
        return images_in(choice.images, tasks)
    return drawn_images(benchmark, tasks, choice.clutter or Clutter.NONE)


def showing_prompts(
    library: Library,
    benchmark: Benchmark,
    ability: Ability,
    shown: PerceivedScenes,
    task_ids: Collection[str],
) -> dict[str, Prompt]:
    """The prompts of tasks that show scenes, of those tasks whose scenes can be shown.

    Raises:
        InputError: published prompts cannot tell of another scene.
    """
    beliefs = {task_id: shown.beliefs[task_id] for task_id in task_ids if task_id in shown.beliefs}
    prompts = library.open(benchmark, ability, beliefs)
    return {task_id: prompts[task_id] for task_id in beliefs}


def told_scene(label: str, suite: Suite, task_id: str, graph: str | None) -> PerceivedScenes:
    """What a question about a task told that was asked before.

    Args:
        label: how it showed the scene, as experiments have it.
        suite: the suite that it is of.
        task_id: the task.
        graph: the scene graph that it told of, as text; None where it came with pictures alone.
    """
    if graph is None:
        return PerceivedScenes(label, {})
    words = scene_words(suite.benchmark)
    read = {task_id: read_scene_graph(graph, words.arities)}
    return perceived_scenes(label, suite.tasks, words, read)


def refuse_published(choice: SceneChoice, library: Library, benchmark: Benchmark) -> None:
    """Raise if a scene is to be shown in another way by published prompts."""
    if library.prompts is PromptSet.OFFICIAL and benchmark.published_prompts is not None:
        scene = choice.scene.value
        raise InputError(
            f"--scene {scene}: published prompts tell of scenes in their own way; "
            "ask ours (--set eai, in Inspect -T prompts=eai)"
        )
