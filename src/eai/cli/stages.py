"""The stage before the questions of ``eai run``: goals are interpreted, or scenes are shown in another way.

Goals are interpreted by the same model, or were before. A captioner is asked first, for all tasks of a domain
at once; its lists are then what other models read.
"""

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
from eai.prompts.template import Templates
from eai.run.job import Endpoint
from eai.scoring.epochs import Believed, SuiteResult
from eai.studies.perception.scenes import (
    SCENE_GRAPH,
    listed_scenes,
    refuse_published,
    showing_prompts,
    shown_scenes,
)
from eai.studies.perception.study import Perception
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
    """The first stage of a pipeline, once for each model and domain.

    Attributes:
        goals: ``own``, or the file or folder with the answers.
        library: where prompts come from.
        ask: asks a model for its answers to a suite, and scores them.
        wanted: the tasks that the second stage is about, by domain.
        outcomes: the results of this stage.
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
        """The prompts of the second stage and their goals; tasks without an answer in the first are left out.

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


@dataclass(frozen=True)
class Scenes:
    """The scenes of a run, once for each domain.

    Attributes:
        choice: how they are shown.
        captioner: the model that lists them for others, if there is one.
        library: where prompts come from.
        ask: asks a model for its answers to a suite, and scores them.
        wanted: the tasks that the run is about, by domain.
        outcomes: the results of the scene graphs that were asked for.
    """

    choice: Perception
    captioner: Endpoint | None
    library: Library
    ask: Callable[..., SuiteResult]
    wanted: Mapping[str, Collection[str]]
    outcomes: list[SuiteResult] = field(default_factory=list)
    _shown: dict[str, Believed] = field(default_factory=dict)

    def second(
        self, endpoint: Endpoint, task_ids: Collection[str], suite: Suite
    ) -> tuple[Mapping[str, Prompt], Believed]:
        """The prompts of a model and the scenes that they show; tasks that cannot be shown so are left out.

        Raises:
            InputError: published prompts cannot describe another scene, or a picture is missing.
        """
        refuse_published(self.choice, self.library, suite)
        if suite.domain not in self._shown:
            self._shown[suite.domain] = (
                self._show(suite) if self.captioner is None else self._listed(suite, self.captioner)
            )
        shown = self._shown[suite.domain]
        return showing_prompts(self.library, suite.benchmark, suite.ability, shown, task_ids), shown

    def _show(self, suite: Suite) -> Believed:
        tasks = {i: suite.tasks[i] for i in suite.tasks if i in self.wanted[suite.domain]}
        return shown_scenes(self.choice, suite.benchmark, tasks, Templates(self.library.folder))

    def _listed(self, suite: Suite, captioner: Endpoint) -> Believed:
        """The scenes as the captioner lists them, which sees pictures and is asked once for each task."""
        pictured = Scenes(self.choice.of_pictures(), None, self.library, self.ask, self.wanted)
        asked = open_suite(suite.benchmark, SCENE_GRAPH, source=suite.source)
        task_ids = [task_id for task_id in asked.task_ids if task_id in self.wanted[suite.domain]]
        prompts, _ = pictured.second(captioner, task_ids, asked)
        outcome = self.ask(captioner, prompts, asked, first=pictured, epochs=1)
        self.outcomes.append(outcome)
        texts = {each.task_id: each.response for each in outcome.records if each.unanswered is None}
        return listed_scenes(self.choice.label, suite, texts)
