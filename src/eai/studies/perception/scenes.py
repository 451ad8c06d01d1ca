"""What the questions of a run show of scenes in the place of a list of what holds, and how right it is."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from eai.abilities.experiment import Experiment
from eai.abilities.record import Perceived, Record
from eai.abilities.task import Task
from eai.prompts.prompt import Belief, Image, Prompt
from eai.prompts.template import Templates
from eai.studies.perception.belief import believed_task
from eai.studies.perception.description import SceneWords
from eai.studies.perception.errors import perception_errors
from eai.studies.perception.scene_graph import ReadGraph, SceneGraph

SCENE = "scene"
"""The field of a question's metadata that has the scene graph which it tells of instead of the scene."""

ASKS = "asks"
"""The field of a question's metadata that says what else than its ability it asks for."""

SCENE_GRAPH = "scene_graph"
"""What questions about pictures ask for."""


@dataclass(frozen=True, slots=True)
class PerceivedScenes:
    """What questions tell of scenes, by task.

    Attributes:
        label: how they do, as experiments have it.
        beliefs: what each question is to tell.
        graphs: the scene graphs that they tell of, where they do.
        errors: how wrong these are.
    """

    label: str
    beliefs: Mapping[str, Belief]
    graphs: Mapping[str, SceneGraph] = field(default_factory=dict)
    errors: Mapping[str, Perceived] = field(default_factory=dict)

    lacking = "there is no scene graph that would tell of the scene"
    """Why a task without a first stage has no second one."""

    @property
    def about(self) -> dict[str, dict[str, str]]:
        """What the built-in models are to know of the questions, by task."""
        return {task_id: {SCENE: graph.text} for task_id, graph in self.graphs.items()}

    @property
    def experiment(self) -> Experiment:
        """What a run is an experiment of that shows these scenes."""
        return Experiment(scene=self.label)

    def marked(self, record: Record) -> Record:
        """The record of an answer to a question that shows these scenes."""
        return replace(record, experiment=self.experiment, perceived=self.errors.get(record.task_id))


def perceived_scenes(
    label: str, tasks: Mapping[str, Task], words: SceneWords, read: Mapping[str, ReadGraph]
) -> PerceivedScenes:
    """What questions tell that tell of scene graphs, be they right or not.

    Args:
        label: where they are from, as experiments have it.
        tasks: the tasks.
        words: how scene graphs say what is so.
        read: the scene graphs by task; the others have none.
    """
    beliefs = {i: Belief(believed_task(tasks[i], words, each.graph)) for i, each in read.items()}
    errors = {i: perception_errors(tasks[i], words, each) for i, each in read.items()}
    return PerceivedScenes(label, beliefs, {i: each.graph for i, each in read.items()}, errors)


def pictured_scenes(
    label: str, tasks: Mapping[str, Task], images: Mapping[str, tuple[Image, ...]], told: str
) -> PerceivedScenes:
    """What questions show that come with pictures.

    Args:
        label: of what kind these are, as experiments have it.
        tasks: the tasks.
        images: the pictures of each.
        told: what a question says of the start; ``$initial`` stands for what holds there.
    """
    return PerceivedScenes(
        label, {i: Belief(tasks[i], initial=told, images=shown) for i, shown in images.items()}
    )


def scene_graph_question(
    task: Task, words: SceneWords, images: tuple[Image, ...], templates: Templates
) -> Prompt:
    """What a model is asked that is to write the scene graph of pictures."""
    values = {"vocabulary": words.wording.vocabulary(), "objects": words.wording.objects(task)}
    return Prompt(templates.fill("scene_graph.txt", values), images=images)
