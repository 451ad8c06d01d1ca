"""``eai export pictures``: diagrams and rendered pictures of tasks."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal, TypeAlias

from eai.abilities.protocol import Ability
from eai.base.errors import InputError
from eai.base.files import write_files_atomically
from eai.benchmarks.suite import open_suite
from eai.cli import options
from eai.cli.console import format_count, print_result
from eai.cli.options import AsJson, DataFolder, make_flag, open_data_source
from eai.cli.prompts import select_tasks_of_suites
from eai.extensions.scenes.diagrams import draw_scene, make_words_for_picture_labels
from eai.extensions.scenes.drawing import Drawing, to_png, to_svg
from eai.extensions.scenes.rendered import VIEWS, make_film, render_task_images
from eai.studies.perception.choice import Clutter
from eai.tasks.task import Task
from eai.world.domain import Domain
from eai.world.execution import execute_plan

_ImageFormat: TypeAlias = Literal["png", "svg", "rendered", "gif"]


def export_pictures(
    domain: options.OfDomain,
    tasks: str = "",
    limit: Annotated[int | None, make_flag(min=1)] = None,
    clutter: Clutter = "none",
    form: Annotated[_ImageFormat, make_flag("--format")] = "png",
    out: Path = Path("pictures"),
    as_json: AsJson = False,
    data: DataFolder = None,
) -> None:
    """Draw the initial state of tasks, and write the scene graph of each picture as JSON.

    In a diagram, each object lies in its container or on its support; all other facts about it are written in
    its rectangle. Equal states give equal bytes.

    Rendered scenes exist for BEHAVIOR, and for tasks of BEHAVIOR-1K if all their objects have bodies.

    Example: eai export pictures --domain virtualhome --tasks 27_2 --format svg --out pictures

    Options:
        tasks: Only these tasks; `short` for forty chosen tasks.
        limit: Maximum number of tasks.
        clutter: Amount of unrelated objects in the picture.
        form: png (extra 'plots') and svg draw diagrams. rendered draws three views of a three-dimensional
            scene; gif shows the data set's plan in this scene (both: extra 'physics').
        out: The folder to write to.
    """
    with open_data_source(data) as source:
        suite = open_suite(domain, Ability.ACTION_SEQUENCING, source=source)
    (chosen,) = select_tasks_of_suites(tasks, [suite], limit)
    words = make_words_for_picture_labels(suite.benchmark)
    refused: list[InputError] = []
    for task_id in chosen:
        drawing, truth = draw_scene(suite.tasks[task_id], words, clutter)
        try:
            drawn = _make_picture_files(suite.tasks[task_id], drawing, form, suite.benchmark.domain)
        except InputError as error:
            refused.append(error)
            continue
        beside = out / f"{task_id}.json"
        write_files_atomically(
            {**{out / f"{task_id}{end}": each for end, each in drawn.items()}, beside: f"{truth.json_text}\n"}
        )
    if refused and len(refused) == len(chosen):
        raise refused[0]
    made = len(chosen) - len(refused)
    without = f"\n{format_count(len(refused), 'scene')} cannot be built: {refused[0]}" if refused else ""
    message = f"{format_count(made, 'picture')}, each with its scene graph; in {out}{without}"
    print_result(message, value={"folder": str(out), "pictures": made}, as_json=as_json)


def _make_picture_files(
    task: Task, drawing: Drawing, form: _ImageFormat, domain: Domain
) -> dict[str, str | bytes]:
    match form:
        case "png":
            return {".png": to_png(drawing)}
        case "svg":
            return {".svg": to_svg(drawing)}
        case "rendered":
            taken = zip(VIEWS, render_task_images(task), strict=True)
            return {f"_{view}.png": image.data for view, image in taken}
        case "gif":
            return {".gif": make_film(task, execute_plan(domain, task.initial, task.script).states)}
