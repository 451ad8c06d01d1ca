"""What the questions of a run show of the scene: pictures, lists with errors, lists that another model made.

A model that sees is asked first, for all tasks of a domain at once; its lists are then what others are told.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple, TypeAlias

from eai.abilities.responses import file_name
from eai.benchmark.prompt_library import Library
from eai.benchmark.suite import Suite
from eai.prompts.prompt import Prompt
from eai.prompts.template import Templates
from eai.run.job import Endpoint
from eai.studies.perception.belief import scene_words
from eai.studies.perception.results import in_words, write_scene_graphs
from eai.studies.perception.scene_graph import read_scene_graph
from eai.studies.perception.scenes import SCENE_GRAPH, PerceivedScenes, perceived_scenes, scene_graph_question
from eai.studies.perception.showing import (
    pictures_for,
    refuse_published,
    showing_prompts,
    shown_scenes,
)
from eai.studies.perception.study import Perception


class _SceneStage(NamedTuple):
    """What a model is asked that is shown the scene in this way: the prompts of the tasks that can be."""

    prompts: Mapping[str, Prompt]
    believed: PerceivedScenes


AskEyes: TypeAlias = Callable[
    [Endpoint, Mapping[str, Prompt], Suite, Mapping[str, str], Path], Mapping[str, str]
]
"""Asks a model for scene graphs: endpoint, questions, suite, right answers, folder; gives its answers."""


@dataclass(frozen=True)
class Scenes:
    """How the scenes of a run are shown, once for each domain and ability.

    Attributes:
        choice: what the command line says.
        eyes: the model that sees for others, if there is one.
        library: where prompts come from.
        ask: asks the model that sees.
        wanted: the tasks that the run is about, by domain.
        out: the folder of the run.
        told: what was found out about the model that sees, a line a domain.
    """

    choice: Perception
    eyes: Endpoint | None
    library: Library
    ask: AskEyes
    wanted: Mapping[str, Collection[str]]
    out: Path
    told: list[str] = field(default_factory=list)
    _shown: dict[str, PerceivedScenes] = field(default_factory=dict)

    def second(self, endpoint: Endpoint, task_ids: Collection[str], suite: Suite) -> _SceneStage:
        """What a model is asked; tasks that cannot be shown so are left out.

        Raises:
            InputError: published prompts cannot tell of another scene, or a picture is missing.
        """
        refuse_published(self.choice, self.library, suite.benchmark)
        if suite.domain not in self._shown:
            self._shown[suite.domain] = self._show(suite)
        shown = self._shown[suite.domain]
        return _SceneStage(
            showing_prompts(self.library, suite.benchmark, suite.ability, shown, task_ids), shown
        )

    def _show(self, suite: Suite) -> PerceivedScenes:
        choice, words = self.choice, scene_words(suite.benchmark)
        tasks = {i: suite.tasks[i] for i in suite.tasks if i in self.wanted[suite.domain]}
        templates = Templates(self.library.folder)
        if self.eyes is None:
            return shown_scenes(choice, suite.benchmark, tasks, templates)
        images = pictures_for(choice, suite.benchmark, tasks)
        asked = {i: scene_graph_question(task, words, images[i], templates) for i, task in tasks.items()}
        right = {i: words.describe(task).text for i, task in tasks.items()}
        name = f"{file_name(self.eyes.model)}{choice.pictures}"
        folder = self.out / suite.domain / SCENE_GRAPH / name
        answers = self.ask(self.eyes, asked, suite, right, folder)
        read = {task_id: read_scene_graph(text, words.arities) for task_id, text in answers.items()}
        scenes = perceived_scenes(choice.label, tasks, words, read)
        write_scene_graphs(folder, name, suite.domain, read, scenes.errors)
        self.told.append(
            f"{suite.domain}, scenes as {self.eyes.model} sees them: {in_words(scenes.errors)}; in {folder}"
        )
        return scenes
