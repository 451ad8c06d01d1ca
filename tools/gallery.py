"""Draw the figures of reports and analyses that pages of docs/ show, from records of answers.

    python tools/gallery.py RECORDS [NAME...]

RECORDS has a folder a domain, an ability and a model, as `eai score answers --out RECORDS` writes them; with
names only those pictures are drawn anew.
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
from eai.extensions.scenes.rendered import photographs_of

ROOT = Path(__file__).parent.parent
PICTURES = ROOT / "docs/images/gallery"
COLORS = 128
"""So many colours are enough for a figure, and make a small file."""


class Figure(NamedTuple):
    """A figure of the gallery.

    Attributes:
        name: that of its picture.
        command: what writes it, among others.
        records: which records it is of, as patterns below their folder; none for photographs.
        file: its file among those that are written, without ending.
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
        "eai analyze cofactors scores --out cofactors",
        (f"{PLANS_B}/*",),
        "curves-behavior-action_sequencing-strict",
    ),
    Figure(
        "adjusted",
        "eai analyze cofactors scores --out cofactors",
        (f"{PLANS_B}/*",),
        "adjusted-behavior-action_sequencing-strict",
    ),
    Figure(
        "flow_all",
        "eai analyze errors scores --out errors",
        ("*/*/*",),
        "flow-all-strict",
    ),
    Figure(
        "leaves",
        "eai analyze errors scores --out errors",
        (f"{PLANS_V}/*",),
        "leaves-virtualhome-action_sequencing-strict",
    ),
    Figure(
        "why",
        "eai analyze errors scores --out errors",
        (f"{PLANS_B}/*",),
        "why-behavior-action_sequencing-strict",
    ),
    Figure(
        "recall",
        "eai analyze goals scores --out goals",
        ("behavior/goal_interpretation/*",),
        "recall-behavior-goal_interpretation-strict",
    ),
    Figure(
        "items",
        "eai analyze items scores --out items",
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
"""The activities that are shown, and from where."""

SMALL = (272, 204)
"""The size of a photograph, in pixels."""


def main() -> None:
    """Draw the pictures."""
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    records, names = Path(sys.argv[1]), sys.argv[2:]
    PICTURES.mkdir(parents=True, exist_ok=True)
    drawn = sorted((each for each in FIGURES if each.name in names or not names), key=_source)
    for (command, patterns), figures in groupby(drawn, key=_source):
        with tempfile.TemporaryDirectory(prefix="eai-gallery-") as folder:
            if not patterns:
                photograph(Path(folder))
                shrink(Path(folder) / "photographs.png", PICTURES / "rendered.png", 224)
                continue
            run(command, [path for pattern in patterns for path in sorted(records.glob(pattern))], folder)
            for figure in figures:
                shrink(Path(folder) / f"{figure.file}.png", PICTURES / f"{figure.name}.png")


def _source(figure: Figure) -> tuple[str, tuple[str, ...]]:
    return figure.command, figure.records


def run(command: str, records: Sequence[Path], out: str) -> None:
    """Run a command of `eai` on some records instead of those that it names."""
    _, *words = command.split()
    place, folder = words.index("scores"), words.index("--out") + 1
    words[folder] = out
    result = CliRunner().invoke(app, [*words[:place], *map(str, records), *words[place + 1 :]])
    if result.exit_code:
        sys.exit(result.output)


def photograph(folder: Path) -> None:
    """Write photographs side by side, in two rows."""
    suite = open_suite("behavior", Ability.ACTION_SEQUENCING)
    ids = {suite.tasks[task_id].title: task_id for task_id in suite.task_ids}
    sheet = Image.new("RGB", (4 * SMALL[0], 2 * SMALL[1]))
    for number, (title, view) in enumerate(PHOTOGRAPHS.items()):
        (taken,) = photographs_of(suite.tasks[ids[title]], (view,))
        picture = Image.open(io.BytesIO(taken.data)).resize(SMALL, Image.Resampling.LANCZOS)
        sheet.paste(picture, (number % 4 * SMALL[0], number // 4 * SMALL[1]))
    sheet.save(folder / "photographs.png")


def shrink(source: Path, target: Path, colors: int = COLORS) -> None:
    """Copy a picture with few colours."""
    with Image.open(source) as picture:
        picture.convert("RGB").quantize(colors).save(target, optimize=True)


if __name__ == "__main__":
    main()
