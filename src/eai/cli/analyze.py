"""``eai analyze``: what records tell beyond their scores."""

from __future__ import annotations

import typer

from eai.cli import (
    analyze_all,
    analyze_annotations,
    analyze_cofactors,
    analyze_contamination,
    analyze_errors,
    analyze_goals,
    analyze_items,
    analyze_perception,
    analyze_pipeline,
    analyze_prompts,
    analyze_replanning,
    analyze_sensitivity,
    analyze_table,
)

app = typer.Typer(no_args_is_help=True, help="Analyses of records.")
app.command("all", no_args_is_help=True)(analyze_all.everything)
app.command(no_args_is_help=True)(analyze_table.table)
app.command(no_args_is_help=True)(analyze_cofactors.cofactors)
app.command(no_args_is_help=True)(analyze_contamination.contamination)
app.command(no_args_is_help=True)(analyze_errors.errors)
app.command(no_args_is_help=True)(analyze_goals.goals)
app.command(no_args_is_help=True)(analyze_sensitivity.sensitivity)
app.command(no_args_is_help=True)(analyze_items.items)
app.command(no_args_is_help=True)(analyze_prompts.prompts)
app.command("annotations", no_args_is_help=True)(analyze_annotations.rate_annotations)
app.command(no_args_is_help=True)(analyze_perception.perception)
app.command(no_args_is_help=True)(analyze_pipeline.pipeline)
app.command(no_args_is_help=True)(analyze_replanning.replanning)


@app.callback()
def analyze() -> None:
    """Analyses of records."""
