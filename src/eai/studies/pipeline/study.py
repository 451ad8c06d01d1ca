"""Study pipelines: questions contain goals from a model's earlier answers instead of the task's goals.

Results are compared with results of the same ability with the task's goals.
"""

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
from eai.studies.variation import AskModel, StageThatObtainsGoalsOrScenes, VariationOptions
from eai.tasks.options import Options

if TYPE_CHECKING:
    from eai.abilities.experiment import StudySettings
    from eai.base.json_value import Json
    from eai.benchmarks.prompt_library import PromptLibrary
    from eai.benchmarks.suite import Suite
    from eai.results.record import Record
    from eai.studies.records import StudyRecords


class _PipelineOptions(VariationOptions):
    """Which goals the questions state instead of the task's.

    Attributes:
        goals: State interpreted goals: own (the model is first asked for them), or the path of a file or
            folder with answers to goal interpretation.
        subgoals: In questions for plans, also state subgoals: own (the model first lists them for these
            goals).
    """

    goals: str | None = None
    subgoals: Literal["own"] | None = None

    @model_validator(mode="after")
    def _require_goals_for_subgoals(self) -> Self:
        if self.subgoals is not None and self.goals is None:
            raise InputError(
                "pipeline.subgoals: also give pipeline.goals, because subgoals are listed for these goals"
            )
        return self

    @property
    def option_that_enables_study(self) -> str:
        """``pipeline.goals``, the option to state goals of a model in questions; empty if not given."""
        return "" if self.goals is None else "pipeline.goals"

    @property
    def results_heading(self) -> str:
        """Heading above the results of a run. It names the source of the goals in the run's questions."""
        return f"goals: {self.goals}" + ("" if self.subgoals is None else f", subgoals: {self.subgoals}")

    def make_study_settings_to_store_in_records(self, study_name: str) -> StudySettings | None:
        """Return None. Records get these options with the goals (`GoalsAndScenesStatedInPrompts`)."""
        return None

    @property
    def changed_task_part(self) -> Literal["", "scene", "goals"]:
        """The part of a question that this study changes: the goals."""
        return "goals"

    def select_abilities(self, requested: Collection[Ability]) -> list[Ability]:
        """Return the abilities whose questions state goals; if the user names abilities, only these.

        Raises:
            InputError: the questions of a named ability state no goals.
        """
        from eai.studies.pipeline.stage_one import (
            ABILITIES_WITH_STATED_GOALS,
            require_ability_whose_questions_state_goals,
        )

        for ability in requested:
            require_ability_whose_questions_state_goals(ability)
        chosen = [
            ability for ability in PAPER_ABILITIES if ability in (requested or ABILITIES_WITH_STATED_GOALS)
        ]
        if self.subgoals is None:
            return chosen
        if Ability.ACTION_SEQUENCING not in chosen:
            raise InputError(
                "pipeline.subgoals: only questions of action_sequencing can state subgoals; "
                "choose --ability action_sequencing"
            )
        return [Ability.ACTION_SEQUENCING]

    def make_stage_that_obtains_goals_or_scenes(
        self, library: PromptLibrary, task_ids_by_domain: Mapping[str, Collection[str]], ask: AskModel
    ) -> StageThatObtainsGoalsOrScenes:
        """Return the stage that obtains a model's goals, which the run's questions then state.

        If the user chose subgoals, return a second stage, which asks for subgoals after the first stage.
        """
        from eai.studies.pipeline.stage_one import (
            obtain_goals_and_subgoals_stated_by_model,
            obtain_goals_interpreted_by_model,
        )

        first = StageThatObtainsGoalsOrScenes(
            library, task_ids_by_domain, ask, partial(obtain_goals_interpreted_by_model, str(self.goals))
        )
        if self.subgoals is None:
            return first
        return StageThatObtainsGoalsOrScenes(
            library, task_ids_by_domain, ask, obtain_goals_and_subgoals_stated_by_model, previous=first
        )


class _PipelineAnalysisOptions(Options):
    """How a pipeline is compared.

    Attributes:
        goals: A file or folder with the answers to goal interpretation. They show which goals are missing,
            and which tasks a perfect planner would solve with the stated goals.
        search: If goals is given, search for plans to the stated goals (half a minute per hundred tasks).
    """

    goals: Path | None = None
    search: bool = True


def _analyze_pipelines(records: StudyRecords, chosen: _PipelineAnalysisOptions) -> Iterator[Analysis]:
    from eai.studies.pipeline.analysis import analyze_pipelines

    return analyze_pipelines(records, chosen.goals, search_for_plans=chosen.search)


def _summarize_stated_goals_and_subgoals(
    record: Record, suite: Suite, question_metadata: Mapping[str, Any]
) -> Mapping[str, Json]:
    from eai.studies.pipeline.stage_one import summarize_goals_stated_in_question

    return summarize_goals_stated_in_question(record, suite, question_metadata)


PIPELINE = Study(
    "pipeline",
    "Interpreted goals (action sequencing, subgoal decomposition).",
    _PipelineOptions,
    choices=_PipelineAnalysisOptions,
    analyze=_analyze_pipelines,
    summarize=_summarize_stated_goals_and_subgoals,
)
