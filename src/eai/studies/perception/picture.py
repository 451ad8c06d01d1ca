"""Pictures of scenes: schematic ones, drawn from a state, and people's own, from a folder."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal, TypeAlias

from eai.base.errors import InputError
from eai.base.files import read_content
from eai.base.grouping import group_pairs
from eai.benchmarks.benchmark import Benchmark
from eai.studies.perception.drawing import Drawing, draw, image_of, png
from eai.studies.perception.scene_graph import SceneGraph, SceneWords
from eai.studies.report.tiles import tiles_of
from eai.tasks.prompts.prompt import Image
from eai.tasks.task import Task
from eai.tasks.wording import subjects
from eai.world.relation import bits
from eai.world.state import State

PNG = "image/png"
MEDIA_TYPES = {".png": PNG, ".jpg": "image/jpeg", ".jpeg": "image/jpeg", ".webp": "image/webp"}
"""The media types of pictures by how their files' names end."""

MOST_HEIGHT = 1536
"""How high a picture is at most, in pixels, unless a task takes more; models shrink higher ones."""


Clutter: TypeAlias = Literal["none", "some", "many"]
"""How much a picture shows besides what the task is about.

``none``: nothing. ``some``: up to as many other objects. ``many``: up to four times as many; fewer where the
picture would be higher than `MOST_HEIGHT`. Objects that are in or on what is shown come first. Where a scene
has no other objects, all three are alike.
"""

_TIMES: Mapping[Clutter, int] = {"none": 0, "some": 1, "many": 4}


def picture_words(benchmark: Benchmark) -> SceneWords:
    """How pictures say what is so: as observations do, so that they show hands too."""
    return SceneWords(benchmark.observed_wording())


def picture_of(
    task: Task,
    words: SceneWords,
    clutter: Clutter = "none",
    state: State | None = None,
    objects: Sequence[int] | None = None,
) -> tuple[Drawing, SceneGraph]:
    """The picture of a task's scene, and all that can be seen in it.

    Args:
        task: the task.
        words: what things are called.
        clutter: how much else is shown.
        state: a state of the scene; the initial one if None.
        objects: what to show, by index; what a prompt speaks of if None.
    """
    shown = subjects(task) if objects is None else objects
    others = others_in_view(task, words, shown, clutter)
    now = task if state is None else replace(task, initial=state)
    names, agent = words.names(task), task.scene.agent
    doer = None if agent is None else names[agent]
    while True:
        truth = words.describe(now, [*shown, *others])
        drawing = draw(tiles_of(truth, words, doer, [names[index] for index in others]))
        if drawing.height <= MOST_HEIGHT or not others:
            return drawing, truth
        others = others[: len(others) * 3 // 4]


def drawn_images(
    benchmark: Benchmark, tasks: Mapping[str, Task], clutter: Clutter
) -> dict[str, tuple[Image, ...]]:
    """A schematic picture of the initial state of each task, as PNG.

    Raises:
        EaiError: the library that draws them is not installed.
    """
    words = picture_words(benchmark)
    return {i: (Image(*drawn_image(task, words, clutter)),) for i, task in tasks.items()}


def drawn_image(task: Task, words: SceneWords, clutter: Clutter = "none") -> tuple[str, bytes]:
    """A schematic picture of the initial state of a task, with its media type.

    Raises:
        EaiError: the library that draws them is not installed.
    """
    return PNG, png(picture_of(task, words, clutter)[0])


def pixels(task: Task, benchmark: Benchmark, state: State, objects: Sequence[int]) -> Any:
    """The picture of some objects in a state of a task, as an array of numpy's: height, width, 3 colours.

    Raises:
        EaiError: the library that draws them is not installed.
    """
    drawn = image_of(picture_of(task, picture_words(benchmark), state=state, objects=objects)[0])
    import numpy as np  # which comes with matplotlib

    return np.asarray(drawn)


def images_in(folder: Path, task_ids: Iterable[str]) -> dict[str, tuple[Image, ...]]:
    """The pictures in a folder by task: the files whose names begin with its id, in their order.

    Raises:
        InputError: there is no picture of a task, or a file cannot be read.
    """
    known = list(task_ids)
    found = [each for each in sorted(folder.glob("*")) if each.suffix.lower() in MEDIA_TYPES]
    files = group_pairs((_owner(file.stem, known), file) for file in found if file.is_file())
    lacking = [task_id for task_id in known if task_id not in files]
    if lacking:
        shown = ", ".join(lacking[:3]) + (", ..." if len(lacking) > 3 else "")
        raise InputError(f"images {folder}: no picture of {len(lacking)} of {len(known)} tasks ({shown})")
    return {
        i: tuple([Image(MEDIA_TYPES[file.suffix.lower()], read_content(file)) for file in files[i]])
        for i in known
    }


def _owner(stem: str, task_ids: Sequence[str]) -> str | None:
    """The task whose id a file's name begins with: the longest one, ended by no letter or digit."""
    begun = [i for i in task_ids if stem == i or (stem.startswith(i) and not stem[len(i)].isalnum())]
    return max(begun, key=len, default=None)


def others_in_view(task: Task, words: SceneWords, shown: Sequence[int], clutter: Clutter) -> list[int]:
    """Return further objects of a scene, first those that are in or on what is shown."""
    state, scene = task.initial, task.scene
    said = {index for fact in words.holding(state, range(len(scene.objects))) for index in fact.arguments}
    supports = [state.relation(words.stored[name]) for name in words.supports]
    near = {i for relation in supports for index in shown for i in bits(relation.column(index))}
    ranked = sorted(said.difference(shown), key=lambda index: (index not in near, index))
    return ranked[: _TIMES[clutter] * len(shown)]
