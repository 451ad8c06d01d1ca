"""The first stage of a pipeline in ``eai run``: two jobs in a row, or answers that were given before."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from eai.abilities.protocol import FOUR, Ability
from eai.abilities.responses import file_name
from eai.benchmark.prompt_library import Library
from eai.benchmark.suite import Suite, open_suite
from eai.errors import InputError
from eai.prompts.prompt import Prompt
from eai.run.job import Endpoint
from eai.scoring.epochs import Believed, SuiteResult
from eai.studies.pipeline.stage_one import (
    STAGE_TWO,
    Interpretations,
    believe,
    read_interpretations,
    refuse_no_stage_two,
)
from eai.studies.pipeline.study import OWN


@dataclass(frozen=True)
class FirstStage:
    """The first stage, once for each model and domain.

    Attributes:
        goals: ``own``, or the file or folder with the answers.
        library: where prompts come from.
        ask: asks a model for its answers to a suite, and scores them.
        wanted: the tasks that the second stage is about, by domain.
        outcomes: what came of what was asked.
    """

    goals: str
    library: Library
    ask: Callable[[Endpoint, Mapping[str, Prompt], Suite], SuiteResult]
    wanted: Mapping[str, Collection[str]]
    outcomes: list[SuiteResult] = field(default_factory=list)
    _believed: dict[tuple[str, str], Believed] = field(default_factory=dict)

    def second(
        self, endpoint: Endpoint, task_ids: Collection[str], suite: Suite
    ) -> tuple[Mapping[str, Prompt], Believed]:
        """What a model is asked in the second stage; tasks without an answer in the first are left out.

        Raises:
            InputError: there is no answer to any of the tasks.
        """
        key = (endpoint.model, suite.domain)
        if key not in self._believed:
            interpretations = self._interpretations(endpoint, suite)
            self._believed[key] = believe(interpretations, suite.benchmark, suite.source)
        believed = self._believed[key]
        asked = [task_id for task_id in task_ids if task_id in believed.beliefs]
        if not asked:
            raise InputError(f"goals {self.goals}: none of the tasks has an answer to goal interpretation")
        beliefs = {task_id: believed.beliefs[task_id] for task_id in asked}
        prompts = self.library.open(suite.benchmark, suite.ability, beliefs)
        return {task_id: prompts[task_id] for task_id in asked}, believed

    def _interpretations(self, endpoint: Endpoint, suite: Suite) -> Interpretations:
        if self.goals != OWN:
            return read_interpretations(Path(self.goals), suite.benchmark, suite.source, endpoint.model)
        first = open_suite(suite.benchmark, Ability.GOAL_INTERPRETATION, suite.protocol, source=suite.source)
        prompts = self.library.open(suite.benchmark, Ability.GOAL_INTERPRETATION)
        wanted = [task_id for task_id in first.task_ids if task_id in self.wanted[suite.domain]]
        outcome = self.ask(endpoint, {task_id: prompts[task_id] for task_id in wanted}, first)
        self.outcomes.append(outcome)
        answered = [record for record in outcome.records if record.unanswered is None]
        return file_name(endpoint.model), {record.task_id: record.response for record in answered}


def stage_two(abilities: Collection[Ability] | None) -> list[Ability]:
    """The abilities of a pipeline that are asked for, in order; both if none is named.

    Raises:
        InputError: one that is named has no first stage.
    """
    for each in abilities or ():
        refuse_no_stage_two(each)
    return [each for each in FOUR if each in (abilities or STAGE_TWO)]
