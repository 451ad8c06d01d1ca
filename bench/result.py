"""Results of measurements, as the files `bench/results/NAME.json` hold them."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any, TypeAlias

FOLDER = Path(__file__).with_name("results")

Figure: TypeAlias = "str | int | float"
"""A number, or a text that holds several numbers or a unit."""


@dataclass(frozen=True, slots=True)
class Measurement:
    """How figures were measured.

    Attributes:
        command: Command line, or None if a person measured without a program.
        commit: Commit at which it was measured, or None if that is not known.
        machine: Plain description of the machine, such as "2 cores, 24 GB".
    """

    command: str | None
    commit: str | None
    machine: str


@dataclass(frozen=True, slots=True)
class Claim:
    """A statement and its figure; `measured` is None if the result's measurement applies."""

    claim: str
    figure: Figure
    measured: Measurement | None = None


@dataclass(frozen=True, slots=True)
class FigureTable:
    """Rows of figures.

    Attributes:
        title: What the table shows.
        columns: Titles of the columns.
        rows: Rows as wide as the columns; the first cells name the row.
        measured: Measurements by name of row, for rows to which the result's measurement does not apply.
    """

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[Figure, ...], ...]
    measured: Mapping[str, Measurement] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Result:
    """Figures of one command, and their section of the page.

    Attributes:
        title: Heading of the section.
        measured: Measurement of all figures without their own measurement.
        claims: Statements with one figure each.
        tables: Tables of figures.
        picture: Path of a picture from the folder of the page, or None.
    """

    title: str
    measured: Measurement
    claims: tuple[Claim, ...]
    tables: tuple[FigureTable, ...]
    picture: str | None = None


def read_result(path: Path) -> Result:
    """Read the result in a file."""
    fields: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    claims = [Claim(**{**claim, "measured": _read_measurement(claim)}) for claim in fields["claims"]]
    tables = [
        FigureTable(
            table["title"],
            tuple(table["columns"]),
            tuple(map(tuple, table["rows"])),
            {row: Measurement(**measured) for row, measured in table.get("measured", {}).items()},
        )
        for table in fields["tables"]
    ]
    measured = Measurement(fields["command"], fields["commit"], fields["machine"])
    return Result(fields["title"], measured, tuple(claims), tuple(tables), fields.get("picture"))


def read_results(folder: Path = FOLDER) -> Mapping[str, Result]:
    """Read all results, by name of file, in the order of their titles."""
    results = {path.stem: read_result(path) for path in folder.glob("*.json")}
    return dict(sorted(results.items(), key=lambda item: item[1].title.removeprefix("The ").lower()))


def format_result(result: Result) -> str:
    """Return the text of a result's file, in which each claim and each row has a line."""
    head = {"title": result.title, **asdict(result.measured)}
    if result.picture is not None:
        head["picture"] = result.picture
    parts = [f" {_format_json(name)}: {_format_json(value)}" for name, value in head.items()]
    claims = [f"  {_format_json(_select_given_fields(claim))}" for claim in result.claims]
    parts.append(f' "claims": {_format_lines(claims, " ")}')
    parts.append(f' "tables": {_format_lines([_format_table(table) for table in result.tables], " ")}')
    return "{\n" + ",\n".join(parts) + "\n}\n"


def replace_figures(
    claims: Sequence[Claim], figures: Mapping[str, Figure], measured: Measurement
) -> list[Claim]:
    """Return claims with new figures.

    Raises:
        ValueError: A figure has no claim.
    """
    if unknown := figures.keys() - {claim.claim for claim in claims}:
        raise ValueError(f"no claim of the result has this text: {', '.join(sorted(unknown))}")
    return [
        Claim(claim.claim, figures[claim.claim], measured) if claim.claim in figures else claim
        for claim in claims
    ]


def replace_rows(
    table: FigureTable, rows: Sequence[Sequence[Figure]], keys: int, measured: Measurement
) -> FigureTable:
    """Return a table with new rows. A row replaces the row with the same first cells, or is added at the end.

    Raises:
        ValueError: A row is not as wide as the table.
    """
    by_key = {row[:keys]: row for row in table.rows}
    measurements = dict(table.measured)
    for row in map(tuple, rows):
        if len(row) != len(table.columns):
            raise ValueError(f"{table.title}: expected {len(table.columns)} cells, not {len(row)}: {row}")
        by_key[row[:keys]] = row
        measurements[", ".join(map(str, row[:keys]))] = measured
    return replace(table, rows=tuple(by_key.values()), measured=measurements)


def _read_measurement(fields: Mapping[str, Any]) -> Measurement | None:
    return Measurement(**fields["measured"]) if "measured" in fields else None


def _select_given_fields(claim: Claim) -> Mapping[str, Any]:
    return {name: value for name, value in asdict(claim).items() if value is not None}


def _format_table(table: FigureTable) -> str:
    rows = _format_lines([f"    {_format_json(row)}" for row in table.rows], "   ")
    parts = [
        f'   "title": {_format_json(table.title)}',
        f'   "columns": {_format_json(table.columns)}',
        f'   "rows": {rows}',
    ]
    if table.measured:
        measured = {row: asdict(measurement) for row, measurement in table.measured.items()}
        parts.append(f'   "measured": {_format_json(measured)}')
    return "  {\n" + ",\n".join(parts) + "\n  }"


def _format_lines(lines: Sequence[str], indent: str) -> str:
    return "[\n" + ",\n".join(lines) + f"\n{indent}]" if lines else "[]"


def _format_json(value: object) -> str:
    return json.dumps(value, ensure_ascii=False)
