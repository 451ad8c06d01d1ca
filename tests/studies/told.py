"""What a command says in JSON of the tables that it wrote."""

from __future__ import annotations

import csv
import json
from pathlib import Path


def told_tables(output: str) -> dict[str, list[dict[str, str]]]:
    """The rows of each table that the one analysis names that is told of, by the table's name."""
    (analysis,) = json.loads(output)
    return {name: read_table(Path(analysis["folder"]) / f"{name}.csv") for name in analysis["tables"]}


def read_table(path: Path) -> list[dict[str, str]]:
    """The rows of a table as a command wrote them."""
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))
