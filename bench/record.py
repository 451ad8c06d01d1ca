"""Write what a program measures into its result file, and the page anew.

A program that is run with `--write` calls `write_figures` or `write_rows`. Both note the command line, the
commit and the machine.
"""

from __future__ import annotations

import os
import shlex
import subprocess
import sys
from argparse import ArgumentParser
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from bench.page import write_page
from bench.result import (
    FOLDER,
    Figure,
    Measurement,
    Result,
    format_result,
    read_result,
    replace_figures,
    replace_rows,
)
from eai.benchmarks.registry import get_title


def add_write_option(parser: ArgumentParser) -> None:
    """Add the option `--write` to a program's command line."""
    parser.add_argument(
        "--write", action="store_true", help="write the figures to bench/results and the page"
    )


def get_suite_title(domain: str, ability: str) -> str:
    """Return a suite's name in tables, such as "BEHAVIOR, action sequencing"."""
    return f"{get_title(domain)}, {ability.replace('_', ' ')}"


def write_figures(name: str, figures: Mapping[str, Figure]) -> None:
    """Write figures into a result's file, and the page anew.

    Args:
        name: Name of the result's file without ending.
        figures: Figures by claim; the file has each claim.
    """
    result = read_result(FOLDER / f"{name}.json")
    claims = replace_figures(result.claims, figures, describe_measurement())
    save_result(name, replace(result, claims=tuple(claims)))


def write_rows(name: str, rows: Sequence[Sequence[Figure]], *, table: int = 0, keys: int = 1) -> None:
    """Write rows into a table of a result's file, and the page anew.

    Args:
        name: Name of the result's file without ending.
        rows: Rows as wide as the table; a row replaces the row with the same first cells.
        table: Index of the table in the file.
        keys: Number of first cells that identify a row.
    """
    result = read_result(FOLDER / f"{name}.json")
    tables = list(result.tables)
    tables[table] = replace_rows(tables[table], rows, keys, describe_measurement())
    save_result(name, replace(result, tables=tuple(tables)))


def save_result(name: str, result: Result) -> None:
    """Write a result's file, and the page anew."""
    (FOLDER / f"{name}.json").write_text(format_result(result), encoding="utf-8")
    write_page()


def describe_measurement() -> Measurement:
    """Return how this process measures: its command line, the commit and the machine.

    Absolute paths are shortened to their last name, because results are published.
    """
    words = [Path(word).name if Path(word).is_absolute() else word for word in sys.argv[1:]]
    words = [shlex.quote(word) for word in words if word != "--write"]
    git = ["git", "rev-parse", "--short", "HEAD"]
    commit = subprocess.run(git, cwd=FOLDER, capture_output=True, text=True).stdout.strip()
    gibibytes = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30
    machine = f"{os.cpu_count()} cores, {gibibytes:.0f} GiB"
    return Measurement(" ".join([sys.argv[0], *words]), commit or None, machine)
