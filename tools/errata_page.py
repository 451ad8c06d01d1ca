"""Write the table of docs/errata.md from the errata of the package: `python tools/errata_page.py`."""

from __future__ import annotations

from pathlib import Path

from eai.benchmarks.errata import _Erratum, load_all_errata
from eai.benchmarks.registry import get_title

PAGE = Path(__file__).resolve().parents[1] / "docs" / "errata.md"
BEGIN, END = "<!-- errata: tools/errata_page.py -->\n", "<!-- end -->\n"
MAX_NAMED_TASKS = 3
"""Maximum number of tasks that a row names; more tasks are counted."""

CORRECTIONS = {
    "exclude": "left out of all rates",
    "renamed": "the operator has the name that was asked for",
    "problem": "the problem declares it",
    "plan": "the plan is corrected",
    "question": "the question is corrected",
    "asks_scored": "the question asks for what is scored",
}


def make_page() -> str:
    """Return the page with a new table."""
    before, _, rest = PAGE.read_text(encoding="utf-8").partition(BEGIN)
    errata = load_all_errata()
    head = (
        f"Version `{errata.version}`.\n\n"
        "| erratum | tasks | what is wrong | how to see it | under `strict` |\n|---|---|---|---|---|\n"
    )
    return before + BEGIN + head + "".join(map(_row, errata.entries)) + END + rest.partition(END)[2]


def _row(entry: _Erratum) -> str:
    abilities = ", ".join(ability.value.replace("_", " ") for ability in entry.abilities)
    names = [task_id.split("_0_")[0] for task_id in entry.tasks]
    named = ", ".join(names[:MAX_NAMED_TASKS]) + (
        f" and {len(names) - MAX_NAMED_TASKS} more" if len(names) > MAX_NAMED_TASKS else ""
    )
    (correction,) = entry.corrections
    cells = (
        f"`{entry.id}`",
        f"{get_title(entry.domain)}, {abilities}: {named}",
        " ".join(entry.wrong.split()),
        " ".join(entry.evidence.split()),
        CORRECTIONS[correction],
    )
    return f"| {' | '.join(cells)} |\n"


if __name__ == "__main__":
    PAGE.write_text(make_page(), encoding="utf-8")
