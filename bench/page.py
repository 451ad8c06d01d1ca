"""Write bench/README.md from the results in bench/results.

    python -m bench page [--check]

With `--check` nothing is written, and the exit status is 1 if the page is not up to date.
"""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterator, Sequence
from pathlib import Path

from bench.result import Claim, Figure, FigureTable, Measurement, Result, read_results

PAGE = Path(__file__).with_name("README.md")

HEAD = """\
# Benchmarks

Each section is a result: the command that measures it, the machine, the commit if known, and the figures.
`python -m bench` lists all programs. `python -m bench NAME --help` explains one.
`python -m bench page` writes this page from the files in [results](results). Do not edit it by hand.

- Speed is a ratio of two processor times, or processor time (CPU s). Other seconds depend on the machine.
- The reference is the package `eai-eval` 1.0.5, unmodified, in an environment of its own.
  `python -m bench action_sequencing` (`make bench`) runs it and `eai` on the same 342 answers.
- "The same" refers to the claim before. Two figures belong to the two things that the claim names.
"""
"""Texts of the page that are in no result."""


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--check", action="store_true", help="compare, write nothing")
    if parser.parse_args().check:
        return int(PAGE.read_text(encoding="utf-8") != make_page())
    write_page()
    return 0


def write_page() -> None:
    """Write the page from all results."""
    PAGE.write_text(make_page(), encoding="utf-8")


def make_page() -> str:
    """Return the text of the page."""
    return "\n".join([HEAD, *(line for result in read_results().values() for line in format_section(result))])


def format_table(table: FigureTable) -> list[str]:
    """Return a table in Markdown; columns of numbers are aligned to the right."""
    columns = list(zip(*table.rows, strict=True))
    rules = ["--:" if _is_numeric(column) else "---" for column in columns]
    return [
        _format_row(table.columns),
        _format_row(rules),
        *(_format_row([format_figure(cell) for cell in row]) for row in table.rows),
    ]


def format_figure(figure: Figure) -> str:
    """Return a figure as the page shows it."""
    return f"{figure:,}" if isinstance(figure, int | float) else figure


def format_measurement(measured: Measurement) -> str:
    """Return the command, the machine and the commit of a measurement."""
    command = "No program" if measured.command is None else f"`{measured.command}`"
    commit = "" if measured.commit is None else f", commit {measured.commit}"
    return f"{command}; machine: {measured.machine}{commit}"


def format_section(result: Result) -> Iterator[str]:
    """Yield the lines of a result's section."""
    yield f"## {result.title}\n"
    yield f"{format_measurement(result.measured)}\n"
    if result.claims:
        yield from (
            f"- {claim.claim}: **{format_figure(claim.figure)}**{_format_measurement_of_claim(claim)}"
            for claim in result.claims
        )
        yield ""
    for table in result.tables:
        yield f"{table.title}{_format_measurements_of_rows(table)}:\n"
        yield from [*format_table(table), ""]
    if result.picture is not None:
        yield f"![{result.title}]({result.picture})\n"


def _format_measurement_of_claim(claim: Claim) -> str:
    return "" if claim.measured is None else f" ({format_measurement(claim.measured)})"


def _format_measurements_of_rows(table: FigureTable) -> str:
    rows_of: dict[Measurement, list[str]] = {}
    for row, measured in table.measured.items():
        rows_of.setdefault(measured, []).append(row)
    texts = []
    for measured, rows in rows_of.items():
        names = "" if len(rows) == len(table.rows) else f"{', '.join(rows)}: "
        texts.append(f" ({names}{format_measurement(measured)})")
    return "".join(texts)


def _is_numeric(cells: Sequence[Figure]) -> bool:
    return all(re.fullmatch(r"-?[\d.,]*", format_figure(cell)) for cell in cells)


def _format_row(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"
