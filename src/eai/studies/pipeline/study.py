"""Pipelines: the options of the study."""

from __future__ import annotations

from eai.abilities.options import Options, option
from eai.studies.study import Study

OWN = "own"
"""The value of ``goals`` for the goals that the model itself is asked for first."""


class Pipeline(Options):
    """Whose goals the questions state instead of the task's."""

    goals: str | None = option(
        "Ask with interpreted goals: the model's own, asked for first (own), or those in a file "
        "or folder of answers to goal interpretation (its path)."
    )


PIPELINE = Study("pipeline", "Interpreted goals (action sequencing, subgoal decomposition).", Pipeline)
