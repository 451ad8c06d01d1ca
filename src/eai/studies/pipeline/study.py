"""Pipelines: a model's interpreted goals in the place of the task's, against the same ability alone."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from eai.abilities.options import Options, option
from eai.studies.study import Analysis, Study

if TYPE_CHECKING:
    from eai.studies.records import Records

OWN = "own"
"""The value of ``goals`` for the goals that the model itself is asked for first."""


class Pipeline(Options):
    """Whose goals the questions state instead of the task's."""

    goals: str | None = option(
        "Ask with interpreted goals: the model's own, asked for first (own), or those in a file "
        "or folder of answers to goal interpretation (its path)."
    )


class _Choices(Options):
    """How a pipeline is compared."""

    goals: Path | None = option(
        "The answers to goal interpretation: says which conditions are missing, and finds what a perfect "
        "second stage would reach."
    )
    search: bool = option("With goals, search for plans (half a minute a hundred tasks).", True)


def _analyze(records: Records, chosen: _Choices) -> Iterator[Analysis]:
    from eai.studies.pipeline.analysis import analyze

    return analyze(records, chosen.goals, search=chosen.search)


PIPELINE = Study(
    "pipeline",
    "Interpreted goals (action sequencing, subgoal decomposition).",
    Pipeline,
    choices=_Choices,
    analyze=_analyze,
)
