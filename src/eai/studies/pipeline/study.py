"""Pipelines: a model's interpreted goals in the place of the task's, against the same ability alone."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from pydantic import model_validator
from typing_extensions import Self

from eai.abilities.protocol import PAPER_ABILITIES, Ability
from eai.base.errors import InputError
from eai.studies.study import Analysis, Study
from eai.studies.variation import Ask, Stage, Variation
from eai.tasks.options import Options

if TYPE_CHECKING:
    from eai.base.json_value import Json
    from eai.benchmarks.prompt_library import Library
    from eai.benchmarks.suite import Suite
    from eai.results.record import Record
    from eai.studies.records import Records


class _Pipeline(Variation):
    """Whose goals the questions state instead of the task's.

    Attributes:
        goals: Ask with interpreted goals: the model's own, asked for first (own), or those in a file or
            folder of answers to goal interpretation (its path).
        subgoals: Ask for plans with the subgoals, too, that the model itself lists for these goals (own).
    """

    goals: str | None = None
    subgoals: Literal["own"] | None = None

    @model_validator(mode="after")
    def _has_goals(self) -> Self:
        if self.subgoals is not None and self.goals is None:
            raise InputError("pipeline.subgoals: expected pipeline.goals, for which subgoals are listed")
        return self

    @property
    def choice(self) -> str:
        """Interpreted goals."""
        return "" if self.goals is None else "pipeline.goals"

    @property
    def heading(self) -> str:
        """Whose goals they are."""
        return f"goals: {self.goals}" + ("" if self.subgoals is None else f", subgoals: {self.subgoals}")

    def recorded(self, study: str) -> None:
        """Return None: the stage states the models whose goals and subgoals questions state."""

    @property
    def states(self) -> Literal["", "scene", "goals"]:
        """The goals."""
        return "goals"

    def abilities(self, named: Collection[Ability]) -> list[Ability]:
        """Those whose questions state goals.

        Raises:
            InputError: one that is named does not.
        """
        from eai.studies.pipeline.stage_one import STAGE_TWO, refuse_no_stage_two

        for each in named:
            refuse_no_stage_two(each)
        chosen = [each for each in PAPER_ABILITIES if each in (named or STAGE_TWO)]
        if self.subgoals is None:
            return chosen
        if Ability.ACTION_SEQUENCING not in chosen:
            raise InputError(
                "pipeline.subgoals: questions of action_sequencing state subgoals, others do not"
            )
        return [Ability.ACTION_SEQUENCING]

    def stage(self, library: Library, wanted: Mapping[str, Collection[str]], ask: Ask) -> Stage:
        """Goal interpretation, and subgoal decomposition for its goals if that is chosen."""
        from eai.studies.pipeline.stage_one import chained, interpreted

        first = Stage(library, wanted, ask, partial(interpreted, str(self.goals)))
        return first if self.subgoals is None else Stage(library, wanted, ask, chained, before=first)


class _Choices(Options):
    """How a pipeline is compared.

    Attributes:
        goals: The answers to goal interpretation: says which conditions are missing, and finds what a perfect
            second stage would reach.
        search: With goals, search for plans (half a minute a hundred tasks).
    """

    goals: Path | None = None
    search: bool = True


def _analyze(records: Records, chosen: _Choices) -> Iterator[Analysis]:
    from eai.studies.pipeline.analysis import analyze

    return analyze(records, chosen.goals, search=chosen.search)


def _summarize(record: Record, suite: Suite, about: Mapping[str, Any]) -> Mapping[str, Json]:
    from eai.studies.pipeline.stage_one import summary_of

    return summary_of(record, suite, about)


PIPELINE = Study(
    "pipeline",
    "Interpreted goals (action sequencing, subgoal decomposition).",
    _Pipeline,
    choices=_Choices,
    analyze=_analyze,
    summarize=_summarize,
)
