"""``eai analyze``: what records tell beyond their scores."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from eai.abilities.protocol import Ability
from eai.abilities.record import Record
from eai.abilities.transition_modeling.scorer import TransitionModeling
from eai.analysis.sensitivity import Sensitivity, summarise, try_operators
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.source import Source
from eai.benchmarks.suite import open_suite
from eai.cli import (
    analyze_annotations,
    analyze_cofactors,
    analyze_errors,
    analyze_goals,
    analyze_items,
    analyze_pipeline,
    analyze_prompts,
    analyze_replanning,
    analyze_table,
)
from eai.cli.console import data_progress, output
from eai.cli.data import DataFolder, store
from eai.cli.options import Planner
from eai.errors import InputError
from eai.pddl.planning import PlannerChoice
from eai.report import plot_sensitivity
from eai.scoring.records import read_records
from eai.scoring.results import RECORDS

app = typer.Typer(no_args_is_help=True, help="Analyses of records.")
app.command(no_args_is_help=True)(analyze_table.table)
app.command(no_args_is_help=True)(analyze_cofactors.cofactors)
app.command(no_args_is_help=True)(analyze_errors.errors)
app.command(no_args_is_help=True)(analyze_goals.goals)
app.command(no_args_is_help=True)(analyze_items.items)
app.command(no_args_is_help=True)(analyze_prompts.prompts)
app.command("annotations", no_args_is_help=True)(analyze_annotations.rate_annotations)
app.command(no_args_is_help=True)(analyze_pipeline.pipeline)
app.command(no_args_is_help=True)(analyze_replanning.replanning)


@app.callback()
def analyze() -> None:
    """Analyses of records."""


@app.command(no_args_is_help=True)
def sensitivity(
    records: Annotated[Path, typer.Argument(help="A records.jsonl of transition modeling, or its folder.")],
    out: Annotated[Path, typer.Option(help="Where the results go.")] = Path("sensitivity"),
    planner: Planner = PlannerChoice.AUTO,
    plots: Annotated[bool, typer.Option(help="Draw heat maps (needs the extra 'plots').")] = True,
    data: DataFolder = None,
) -> None:
    """Try each operator of the answers alone among gold operators: which one breaks plans?

    Example: eai analyze sensitivity scores --out sensitivity
    """
    path = records / RECORDS if records.is_dir() else records
    groups: dict[tuple[str, str], list[Record]] = {}
    for record in read_records(path):
        if record.ability is not Ability.TRANSITION_MODELING:
            raise InputError(f"{path}: expected records of transition_modeling, not {record.ability.value}")
        groups.setdefault((record.domain, record.model), []).append(record)
    for (domain, model), found in groups.items():
        result = _analyze(find_benchmark(domain), found, planner, data)
        name = f"{domain}-{model}"
        try:
            out.mkdir(parents=True, exist_ok=True)
            (out / f"{name}.json").write_text(json.dumps(result.to_json(), indent=1) + "\n", encoding="utf-8")
            (out / f"{name}.md").write_text(result.to_markdown(), encoding="utf-8")
        except OSError as error:
            raise InputError(f"{out}: cannot be written ({error.strerror})") from error
        if plots:
            plot_sensitivity.save(result, f"{model}, {domain}", out / name)
        output().print(f"{name}: {len(result.operators)} operators", highlight=False)


def _analyze(
    benchmark: Benchmark, records: list[Record], planner: PlannerChoice, data: DataFolder
) -> Sensitivity:
    with data_progress() as report:
        source = Source(store(data), report, planner)
        suite = open_suite(benchmark, Ability.TRANSITION_MODELING, records[0].protocol, source=source)
    made = ((task_id, suite.scorer(task_id)) for task_id in suite.task_ids)
    scorers = {task_id: scorer for task_id, scorer in made if isinstance(scorer, TransitionModeling)}
    outcomes = [
        outcome
        for record in records
        if record.task_id in scorers and record.unanswered is None
        for outcome in try_operators(scorers[record.task_id], record.response)
    ]
    operators = (name for scorer in scorers.values() for name in scorer.task.domain.operators)
    return summarise(outcomes, tuple(dict.fromkeys(operators)))
