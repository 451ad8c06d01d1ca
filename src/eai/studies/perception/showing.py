"""How questions show scenes: what is chosen, and what each question then tells and shows."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from eai.abilities.protocol import FOUR, Ability
from eai.abilities.task import Task
from eai.benchmark.benchmark import Benchmark
from eai.benchmark.prompt_library import Library
from eai.benchmark.suite import Suite
from eai.errors import InputError
from eai.prompts.prompt import Image, Prompt, PromptSet
from eai.prompts.template import Templates
from eai.studies.perception.belief import scene_words
from eai.studies.perception.noise import perceive
from eai.studies.perception.pictures import Clutter, drawn_images, images_in
from eai.studies.perception.scene_graph import ReadGraph, read_scene_graph
from eai.studies.perception.scenes import PerceivedScenes, perceived_scenes, pictured_scenes
from eai.studies.perception.study import Perception, Scene

ABILITIES = (Ability.GOAL_INTERPRETATION, Ability.SUBGOAL_DECOMPOSITION, Ability.ACTION_SEQUENCING)
"""The abilities whose questions tell of a scene."""


def scene_abilities(abilities: Collection[Ability] | None, scene: Scene) -> list[Ability]:
    """The abilities that are asked for, in order; all that tell of a scene if none is named.

    Raises:
        InputError: the questions of one that is named tell of none.
    """
    for each in abilities or ():
        if each not in ABILITIES:
            raise InputError(f"perception.scene {scene.value}: questions of {each.value} tell of no scene")
    return [each for each in FOUR if each in (abilities or ABILITIES)]


def shown_scenes(
    choice: Perception, benchmark: Benchmark, tasks: Mapping[str, Task], templates: Templates
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
    choice: Perception, benchmark: Benchmark, tasks: Mapping[str, Task]
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


def refuse_published(choice: Perception, library: Library, benchmark: Benchmark) -> None:
    """Raise if a scene is to be shown in another way by published prompts."""
    if library.prompts is PromptSet.OFFICIAL and benchmark.published_prompts is not None:
        scene = choice.scene.value
        raise InputError(
            f"perception.scene {scene}: published prompts tell of scenes in their own way; "
            "ask ours (--set eai, in Inspect -T prompts=eai)"
        )
