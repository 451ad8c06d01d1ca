"""Draw the figures of reports and analyses that pages of docs/ show, from records of answers.

    python tools/gallery.py RECORDS [NAME...]

RECORDS has a folder for each domain, ability and model, as `eai score answers --out RECORDS` writes it. If
names are given, only these pictures are drawn.
"""

from __future__ import annotations

import io
import sys
import tempfile
from collections.abc import Sequence
from itertools import groupby
from pathlib import Path
from typing import NamedTuple

from PIL import Image
from typer.testing import CliRunner

from eai.abilities.protocol import Ability
from eai.benchmarks.suite import open_suite
from eai.cli import app
from eai.extensions.scenes.rendered import render_task_images

ROOT = Path(__file__).parent.parent
PICTURES = ROOT / "docs/images/gallery"
COLORS = 128
"""Number of colours in a picture; a small palette makes a small file."""


class Figure(NamedTuple):
    """A figure of the gallery.

    Attributes:
        name: Name of the picture.
        command: Command that draws the figure; it may draw others too.
        records: Patterns of the records that the figure shows, below their folder; empty for photographs.
        file: Path of the drawn file below the command's output folder, without ending.
    """

    name: str
    command: str
    records: tuple[str, ...]
    file: str


REPORT = "eai report scores --out report --paper --summary --formats png"
THREE = ("gpt-4o*", "llama-3-8b*", "o1-mini*")
PLANS_B, PLANS_V = "behavior/action_sequencing", "virtualhome/action_sequencing"

FIGURES = (
    Figure(
        "summary",
        REPORT,
        ("*/*/gpt-4o*",),
        "plots/summary-gpt-4o-2024-05-13-strict",
    ),
    Figure(
        "radar",
        REPORT,
        ("*/*/*",),
        "plots/radar-strict",
    ),
    Figure(
        "outcomes",
        REPORT,
        tuple(f"behavior/*/{model}" for model in THREE),
        "plots/outcomes-behavior-strict",
    ),
    Figure(
        "flow",
        REPORT,
        tuple(f"{PLANS_V}/{model}" for model in THREE),
        "plots/flow-action_sequencing-virtualhome-strict",
    ),
    Figure(
        "difficulty",
        REPORT,
        tuple(f"behavior/*/{model}" for model in THREE),
        "plots/difficulty-action_sequencing-behavior-strict",
    ),
    Figure(
        "actions",
        REPORT,
        tuple(f"behavior/*/{model}" for model in THREE),
        "plots/actions-subgoal_decomposition-behavior-strict",
    ),
    Figure(
        "curves",
        "eai analyze cofactors scores --out cofactors --formats png",
        (f"{PLANS_B}/*",),
        "curves-behavior-action_sequencing-strict",
    ),
    Figure(
        "adjusted",
        "eai analyze cofactors scores --out cofactors --formats png",
        (f"{PLANS_B}/*",),
        "adjusted-behavior-action_sequencing-strict",
    ),
    Figure(
        "flow_all",
        "eai analyze errors scores --out errors --formats png",
        ("*/*/*",),
        "flow-all-strict",
    ),
    Figure(
        "leaves",
        "eai analyze errors scores --out errors --formats png",
        (f"{PLANS_V}/*",),
        "leaves-virtualhome-action_sequencing-strict",
    ),
    Figure(
        "why",
        "eai analyze errors scores --out errors --formats png",
        (f"{PLANS_B}/*",),
        "why-behavior-action_sequencing-strict",
    ),
    Figure(
        "recall",
        "eai analyze goals scores --out goals --formats png",
        ("behavior/goal_interpretation/*",),
        "recall-behavior-goal_interpretation-strict",
    ),
    Figure(
        "items",
        "eai analyze items scores --out items --formats png",
        ("virtualhome/subgoal_decomposition/*",),
        "items-virtualhome-subgoal_decomposition-strict",
    ),
    Figure(
        "rendered",
        "eai export pictures --domain behavior --limit 8 --format rendered --out photographs",
        (),
        "photographs",
    ),
)

PHOTOGRAPHS = {
    "assembling_gift_baskets": "head",
    "cleaning_up_the_kitchen_only": "near",
    "cleaning_bedroom": "head",
    "bottling_fruit": "head",
    "clearing_the_table_after_dinner": "near",
    "cleaning_bathrooms": "head",
    "boxing_books_up_for_storage": "head",
    "filling_a_Christmas_stocking": "near",
}
"""Names of the cameras by the activity that they show."""

PHOTOGRAPH_SIZE = (272, 204)
"""Width and height of a photograph in pixels."""


def main() -> None:
    """Draw the figures that the arguments name, or all."""
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    records, names = Path(sys.argv[1]), sys.argv[2:]
    PICTURES.mkdir(parents=True, exist_ok=True)
    chosen = [figure for figure in FIGURES if figure.name in names or not names]
    drawn = sorted(chosen, key=_get_source)
    for (command, patterns), figures in groupby(drawn, key=_get_source):
        with tempfile.TemporaryDirectory(prefix="eai-gallery-") as folder:
            if not patterns:
                write_photographs(Path(folder))
                shrink(Path(folder) / "photographs.png", PICTURES / "rendered.png", 224)
                continue
            run(command, [path for pattern in patterns for path in sorted(records.glob(pattern))], folder)
            for figure in figures:
                shrink(Path(folder) / f"{figure.file}.png", PICTURES / f"{figure.name}.png")


def _get_source(figure: Figure) -> tuple[str, tuple[str, ...]]:
    return figure.command, figure.records


def run(command: str, records: Sequence[Path], out: str) -> None:
    """Run a command of `eai` on other records than it names, with another output folder."""
    _, *words = command.split()
    words[words.index("--out") + 1] = out
    scores = words.index("scores")
    result = CliRunner().invoke(app, [*words[:scores], *map(str, records), *words[scores + 1 :]])
    if result.exit_code:
        sys.exit(result.output)


def write_photographs(folder: Path) -> None:
    """Write all photographs into one picture with two rows."""
    suite = open_suite("behavior", Ability.ACTION_SEQUENCING)
    ids = {suite.tasks[task_id].title: task_id for task_id in suite.task_ids}
    sheet = Image.new("RGB", (4 * PHOTOGRAPH_SIZE[0], 2 * PHOTOGRAPH_SIZE[1]))
    for number, (title, view) in enumerate(PHOTOGRAPHS.items()):
        (photograph,) = render_task_images(suite.tasks[ids[title]], (view,))
        picture = Image.open(io.BytesIO(photograph.data)).resize(PHOTOGRAPH_SIZE, Image.Resampling.LANCZOS)
        sheet.paste(picture, (number % 4 * PHOTOGRAPH_SIZE[0], number // 4 * PHOTOGRAPH_SIZE[1]))
    sheet.save(folder / "photographs.png")


def shrink(source: Path, target: Path, colors: int = COLORS) -> None:
    """Copy a picture with a small palette of colours."""
    with Image.open(source) as picture:
        picture.convert("RGB").quantize(colors).save(target, optimize=True)


if __name__ == "__main__":
    main()
