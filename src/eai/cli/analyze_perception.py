"""``eai analyze perception``: what errors in the perceived scene cost."""

from __future__ import annotations

from itertools import groupby
from pathlib import Path
from typing import Annotated

import typer

from eai.abilities.responses import file_name
from eai.cli.analyzed import Figures, Plots, Records, of_run, say, write_analysis
from eai.cli.options import AsJson
from eai.errors import InputError
from eai.report.runs import Run, RunKey, read_runs
from eai.studies.perception import plots as plot_perception
from eai.studies.perception.analysis import PerceptionRuns, perception_runs, perception_tables

_NAME = "perception"


def perception(
    records: Records,
    metric: Annotated[
        str | None, typer.Option(help="Which metric of the ability's main table; its first if not given.")
    ] = None,
    out: Annotated[Path, typer.Option(help="The folder for tables and plots.")] = Path(_NAME),
    plots: Plots = True,
    as_json: AsJson = False,
) -> None:
    """Success against the errors in the perceived scene: by rate, by kind, and by the facts that were lost.

    Runs of one model, domain, ability and protocol belong together; a plain run among them, with the same
    prompts (--set eai), says what the same tasks come to without errors.

    Example: eai analyze perception runs --out perception
    """
    runs = [run for run in read_runs(records) if _is_shown(run)]
    groups = [list(group) for _, group in groupby(sorted(runs, key=lambda run: run.key.order), _place)]
    seen = [group for group in groups if any(record.perceived for run in group for record in run.records)]
    if not seen:
        raise InputError(
            "expected records that say what was perceived; eai run --with perception.scene=noisy does"
        )
    written = []
    for group in seen:
        key = group[0].key
        found = perception_runs([run.records for run in group], metric)
        place = f"{key.domain}-{key.ability.value}-{key.protocol.value}-{file_name(key.model)}"
        folder = out / place if len(seen) > 1 else out
        tables = perception_tables(found)
        written.append(write_analysis(_NAME, tables, _figures(found, key), folder, plots=plots))
    say(*written, as_json=as_json)


def _is_shown(run: Run) -> bool:
    """Whether a run differs from a plain one in how it shows the scene, if in anything."""
    return run.key.experiment is None or run.key.experiment.name == _NAME


def _place(run: Run) -> tuple[str, ...]:
    key = run.key
    return (key.protocol.value, key.domain, key.ability.value, key.model)


def _figures(runs: PerceptionRuns, key: RunKey) -> Figures:
    yield of_run(key, "success_by_error_rate", plot_perception.draw(runs))
