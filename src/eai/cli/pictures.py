"""``eai export pictures``: schematic pictures of tasks, each with all that can be seen in it."""

from __future__ import annotations

from enum import Enum
from pathlib import Path
from typing import Annotated

import typer

from eai.abilities.protocol import Ability
from eai.benchmark.suite import open_suite
from eai.cli.chosen_tasks import tasks_of
from eai.cli.console import DOMAIN_HELP, counted, data_progress, tell
from eai.cli.options import AsJson
from eai.cli.store import DataFolder, store
from eai.data.files import write_whole
from eai.studies.perception.drawing import png, svg
from eai.studies.perception.pictures import Clutter, picture_of, picture_words
from eai.tasks.source import Source


class Format(str, Enum):
    """How pictures are written."""

    PNG = "png"
    SVG = "svg"


def pictures(
    domain: Annotated[str, typer.Option(help=DOMAIN_HELP)],
    tasks: Annotated[str, typer.Option(help="Only these; short: forty.")] = "",
    limit: Annotated[int | None, typer.Option(min=1, help="So many, at most.")] = None,
    clutter: Annotated[Clutter, typer.Option(help="How much else is shown.")] = Clutter.NONE,
    form: Annotated[Format, typer.Option("--format", help="PNG needs the extra 'plots'.")] = Format.PNG,
    out: Annotated[Path, typer.Option(help="The folder to write to.")] = Path("pictures"),
    as_json: AsJson = False,
    data: DataFolder = None,
) -> None:
    """Draw the initial state of tasks; beside each picture stands its scene graph, as JSON.

    Objects lie in what they are in or on, and say what else holds of them. Equal states give equal bytes.

    Example: eai export pictures --domain virtualhome --tasks 27_2 --format svg --out pictures
    """
    with data_progress() as report:
        suite = open_suite(domain, Ability.ACTION_SEQUENCING, source=Source(store(data), report))
    (named,) = tasks_of(tasks, [suite])
    words = picture_words(suite.benchmark)
    chosen = [task_id for task_id in suite.task_ids if not named or task_id in named][:limit]
    for task_id in chosen:
        drawing, truth = picture_of(suite.tasks[task_id], words, clutter)
        drawn = png(drawing) if form is Format.PNG else svg(drawing)
        beside = out / f"{task_id}.json"
        write_whole({out / f"{task_id}.{form.value}": drawn, beside: f"{truth.text}\n"})
    message = f"{counted(len(chosen), 'picture')}, each with its scene graph; in {out}"
    tell(message, value={"folder": str(out), "pictures": len(chosen)}, as_json=as_json)
