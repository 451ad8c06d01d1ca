"""The JSON output of a command about its tables."""

from __future__ import annotations

import csv
import json
from pathlib import Path


def told_tables(output: str) -> dict[str, list[dict[str, str]]]:
    """Return the rows of each table of the only analysis in the output, by the table's name."""
    (analysis,) = json.loads(output)
    return {name: read_table(Path(analysis["folder"]) / f"{name}.csv") for name in analysis["tables"]}


def read_table(path: Path) -> list[dict[str, str]]:
    """Return the rows of a table that a command wrote."""
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))
