"""``eai analyze prompts``: how much depends on how one asks."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Annotated

import typer

from eai.abilities.responses import file_name
from eai.abilities.verdict import Json
from eai.cli.analyzed import Figures, Records, draw_figures
from eai.cli.console import counted, tell
from eai.cli.options import AsJson
from eai.errors import InputError
from eai.report.runs import Run, read_runs
from eai.results.table_files import write_tables
from eai.studies.prompts import plots as plot_prompts
from eai.studies.prompts.analysis import PLAIN, Matrix, matrix_of, prompt_tables


def prompts(
    records: Records,
    metric: Annotated[
        str | None, typer.Option(help="Which metric of the ability's main table; its first if not given.")
    ] = None,
    reference: Annotated[
        str | None, typer.Option(help="The prompts that gains are measured from; the first if not given.")
    ] = None,
    out: Annotated[Path, typer.Option(help="The folder for tables and plots.")] = Path("prompts"),
    plots: Annotated[bool, typer.Option(help="Draw heat maps (needs the extra 'plots').")] = True,
    as_json: AsJson = False,
) -> None:
    """Set runs of models with several prompts (prompts.name) side by side, suite by suite.

    Example: eai analyze prompts runs --metric overall.f1 --out prompts
    """
    lines: list[str] = []
    written: list[Json] = []
    for suite, runs in _by_suite(read_runs(records)).items():
        matrix = matrix_of([(_name(run), run.records) for run in runs], metric)
        folder = out / file_name(suite)
        tables = prompt_tables(matrix, reference or matrix.prompts[0])
        write_tables(folder, "prompts", tables)
        if plots:
            draw_figures(_figures(matrix, suite), folder)
        sizes = f"{counted(len(matrix.prompts), 'prompt')}, {counted(len(matrix.models), 'model')}"
        lines.append(f"{suite}: {sizes}; in {folder}")
        written.append(
            {
                "suite": suite,
                "prompts": list(matrix.prompts),
                "models": list(matrix.models),
                "folder": str(folder),
            }
        )
    tell(*lines, value=written, as_json=as_json)


def _figures(matrix: Matrix, suite: str) -> Figures:
    yield "prompts", plot_prompts.draw(matrix, suite.replace("-", ", "))


def _name(run: Run) -> str:
    experiment = run.key.experiment
    return PLAIN if experiment is None or experiment.prompt_name is None else experiment.prompt_name


def _by_suite(runs: Iterable[Run]) -> dict[str, list[Run]]:
    """The runs of each suite and protocol; those of other experiments are refused."""
    suites: dict[str, list[Run]] = {}
    for run in runs:
        experiment = run.key.experiment
        if experiment is not None and (experiment.acts or experiment.goals_from is not None):
            raise InputError(f"{run.key}: expected runs that differ in their prompts alone")
        suite = f"{run.key.domain}-{run.key.ability.value}-{run.key.protocol.value}"
        suites.setdefault(suite, []).append(run)
    return suites
