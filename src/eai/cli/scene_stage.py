"""The scenes that the questions of a run show: pictures, lists with errors, lists that another model made.

A model that makes lists is asked first, for all tasks of a domain at once; the others get its lists.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field

from eai.benchmark.prompt_library import Library
from eai.benchmark.suite import Suite, open_suite
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


@dataclass(frozen=True)
class Scenes:
    """The scenes of a run, once for each domain.

    Attributes:
        choice: how they are shown.
        captioner: the model that lists them for others, if there is one.
        library: where prompts come from.
        ask: asks a model for its answers to a suite, and scores them.
        wanted: the tasks that the run is about, by domain.
        outcomes: what came of the scene graphs that were asked for.
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
        """The questions that a model is asked; tasks that cannot be shown so are left out.

        Raises:
            InputError: published prompts cannot tell of another scene, or a picture is missing.
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
        prompts = pictured.second(captioner, task_ids, asked)[0]
        outcome = self.ask(captioner, prompts, asked, first=pictured, epochs=1)
        self.outcomes.append(outcome)
        texts = {each.task_id: each.response for each in outcome.records if each.unanswered is None}
        return listed_scenes(self.choice.label, suite, texts)
