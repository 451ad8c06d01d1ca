"""``eai analyze``: what records tell beyond their scores."""

from __future__ import annotations

from typing import ClassVar

import typer

from eai.cli.lazily import LazyGroup, Place


class _Analyses(LazyGroup):
    """The analyses."""

    places: ClassVar = {
        "all": Place("analyze_all", "everything"),
        "table": Place("analyze_table", "table"),
        "cofactors": Place("analyze_cofactors", "cofactors"),
        "contamination": Place("analyze_contamination", "contamination"),
        "errors": Place("analyze_errors", "errors"),
        "goals": Place("analyze_goals", "goals"),
        "sensitivity": Place("analyze_sensitivity", "sensitivity"),
        "items": Place("analyze_items", "items"),
        "prompts": Place("analyze_prompts", "prompts"),
        "annotations": Place("analyze_annotations", "rate_annotations"),
        "perception": Place("analyze_perception", "perception"),
        "pipeline": Place("analyze_pipeline", "pipeline"),
        "replanning": Place("analyze_replanning", "replanning"),
    }


app = typer.Typer(cls=_Analyses, no_args_is_help=True, help="Analyses of records.")


@app.callback()
def analyze() -> None:
    """Analyses of records."""
