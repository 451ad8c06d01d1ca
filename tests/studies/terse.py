"""A study from outside the package: how long answers are if the question sets a limit of characters."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from typing import Any, Literal

from pydantic import Field

from eai.abilities.experiment import Experiment
from eai.benchmarks.prompt_library import PromptLibrary
from eai.benchmarks.suite import Suite
from eai.results.epochs import GoalsAndScenesStatedInPrompts
from eai.results.record import Record
from eai.results.table import Table
from eai.studies.records import StudyRecords
from eai.studies.study import Analysis, Study
from eai.studies.variation import AskModel, StageThatObtainsGoalsOrScenes, VariationOptions
from eai.tasks.options import Options
from eai.tasks.prompts.prompt import INITIAL_PLACEHOLDER, BelievedTask


class Limit(VariationOptions):
    """A limit in the question.

    Attributes:
        characters: The most characters of an answer.
    """

    characters: int = Field(default=0, ge=0)

    @property
    def option_that_enables_study(self) -> str:
        return "terse.characters" if self.characters else ""

    @property
    def changed_task_part(self) -> Literal["", "scene", "goals"]:
        return "scene"

    def make_stage_that_obtains_goals_or_scenes(
        self, library: PromptLibrary, wanted: Mapping[str, Collection[str]], ask: AskModel
    ) -> StageThatObtainsGoalsOrScenes:
        return StageThatObtainsGoalsOrScenes(library, wanted, ask, self._limited)

    def _limited(self, _: object, __: object, suite: Suite) -> GoalsAndScenesStatedInPrompts:
        told = f"{INITIAL_PLACEHOLDER}\nAnswer in {self.characters} characters."
        beliefs = {task_id: BelievedTask(task, initial=told) for task_id, task in suite.tasks.items()}
        return GoalsAndScenesStatedInPrompts(beliefs, Experiment(), "there is no such task")


def summarize(record: Record, suite: Suite, about: Mapping[str, Any]) -> dict[str, int]:
    return {"excess": max(0, len(record.response) - record.settings_by_study["terse"].options["characters"])}


def analyze(records: StudyRecords, chosen: Options) -> Iterator[Analysis]:
    rows = [(x.key.name, sum(r.summaries["terse"]["excess"] for r in x.records)) for x in records.read_runs()]
    yield Analysis([Table("terse", "Characters above the limit", "By run.", ("run", "excess"), tuple(rows))])


TERSE = Study("terse", "Limits of characters.", Limit, analyze=analyze, summarize=summarize)
