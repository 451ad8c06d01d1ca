"""Diagrams of scenes: pictures in which each object is a rectangle, drawn from a state."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from eai.benchmarks.benchmark import Benchmark
from eai.extensions.scenes.drawing import Drawing, draw_object_rectangles, to_pillow_image, to_png
from eai.extensions.scenes.tiles import make_object_rectangles
from eai.studies.perception.choice import Clutter
from eai.studies.perception.scene_graph import SceneGraph, SceneGraphVocabulary
from eai.studies.perception.scenes import choose_distractor_objects
from eai.tasks.prompts.prompt import Image
from eai.tasks.task import Task
from eai.tasks.wording import list_objects_in_prompt
from eai.world.state import State

PNG = "image/png"

MAX_HEIGHT_WITH_UNRELATED_OBJECTS = 1536
"""Maximum height of a picture with objects that do not belong to the task, in pixels.

Models shrink higher pictures.
"""


def make_words_for_picture_labels(benchmark: Benchmark) -> SceneGraphVocabulary:
    """Return the words for objects and relations in pictures.

    They are the words of the texts that describe the world to an acting model. These also name the hand that
    holds an object.
    """
    return SceneGraphVocabulary(benchmark.observation_wording())


def draw_scene(
    task: Task,
    words: SceneGraphVocabulary,
    clutter: Clutter = "none",
    state: State | None = None,
    objects: Sequence[int] | None = None,
) -> tuple[Drawing, SceneGraph]:
    """Return a diagram of a task's scene, and the scene graph with all facts that the diagram shows.

    Args:
        task: the task.
        words: the names of objects and relations.
        clutter: the amount of unrelated objects.
        state: a state of the scene; the initial state if None.
        objects: indexes of the objects to show; the objects of a prompt if None.
    """
    shown = list_objects_in_prompt(task) if objects is None else objects
    others = choose_distractor_objects(task, words, shown, clutter)
    now = task if state is None else replace(task, initial=state)
    names, agent = words.list_object_names(task), task.scene.agent
    doer = None if agent is None else names[agent]
    while True:
        truth = words.make_true_graph(now, [*shown, *others])
        drawing = draw_object_rectangles(
            make_object_rectangles(truth, words, doer, [names[index] for index in others])
        )
        if drawing.height <= MAX_HEIGHT_WITH_UNRELATED_OBJECTS or not others:
            return drawing, truth
        others = others[: len(others) * 3 // 4]


def draw_task_images(
    benchmark: Benchmark, tasks: Mapping[str, Task], clutter: Clutter
) -> dict[str, tuple[Image, ...]]:
    """Return a diagram of the initial state of each task as PNG, by task id.

    Raises:
        EaiError: matplotlib, which draws the diagrams, is not installed.
    """
    words = make_words_for_picture_labels(benchmark)
    return {i: (Image(*draw_task_image(task, words, clutter)),) for i, task in tasks.items()}


def draw_task_image(task: Task, words: SceneGraphVocabulary, clutter: Clutter = "none") -> tuple[str, bytes]:
    """Return the media type and the bytes of a diagram of the initial state of a task.

    Raises:
        EaiError: matplotlib, which draws the diagram, is not installed.
    """
    return PNG, to_png(draw_scene(task, words, clutter)[0])


def draw_scene_as_array(task: Task, benchmark: Benchmark, state: State, objects: Sequence[int]) -> Any:
    """Return the diagram of some objects in a state as an array of numpy: height, width, 3 colours.

    Raises:
        EaiError: matplotlib, which draws the diagram, is not installed.
    """
    drawn = to_pillow_image(
        draw_scene(task, make_words_for_picture_labels(benchmark), state=state, objects=objects)[0]
    )
    import numpy as np  # numpy is installed with matplotlib

    return np.asarray(drawn)
