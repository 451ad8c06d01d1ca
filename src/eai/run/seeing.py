"""Scenes in Inspect's tasks: what arguments choose, and a second model that sees for the one who is asked."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from inspect_ai.model import get_model
from inspect_ai.solver import Generate, Solver, TaskState, solver

from eai.abilities.codec import experiment_to_json
from eai.abilities.protocol import member
from eai.benchmark.prompt_library import Library
from eai.benchmark.suite import Suite
from eai.run.job import EYES
from eai.run.messages import messages_of
from eai.run.reasoning import part
from eai.run.scorer import EXPERIMENT
from eai.studies.perception.belief import scene_words
from eai.studies.perception.noise import noise_of
from eai.studies.perception.pictures import Clutter
from eai.studies.perception.scene_graph import read_scene_graph
from eai.studies.perception.scenes import ASKS, SCENE, perceived_scenes
from eai.studies.perception.showing import Scene, SceneChoice, showing_prompts


def scene_choice(
    scene: str, images: str | None, clutter: str | None, noise: str | Sequence[str] | None
) -> SceneChoice:
    """How questions show the scene, by the arguments of a task.

    Raises:
        InputError: it makes no sense.
    """
    how = member(Scene, scene, "way to show the scene")
    return SceneChoice(
        how,
        None if images is None else Path(images),
        None if clutter is None else member(Clutter, clutter, "degree of clutter"),
        eyes=EYES if how is Scene.PREDICTED else None,
        noise=noise_of([noise] if isinstance(noise, str) else noise) if noise else None,
    )


@solver(name="eai_see")
def see(choice: SceneChoice, library: Library, suite: Suite) -> Solver:
    """Has the model in the role ``eyes`` write the scene graph, and makes the question of what it wrote.

    Args:
        choice: how scenes are shown.
        library: where prompts come from.
        suite: what is asked.
    """
    words = scene_words(suite.benchmark)

    async def solve(state: TaskState, generate: Generate) -> TaskState:
        eyes, task_id = get_model(role=EYES, required=True), str(state.sample_id)
        about = {**(state.messages[-1].metadata or {}), "epoch": state.epoch}
        state.messages[-1].metadata = about
        output = await eyes.generate(state.messages)
        read = {task_id: read_scene_graph(part(output.completion).answer, words.arities)}
        label = replace(choice, eyes=str(eyes)).label
        scenes = perceived_scenes(label, {task_id: suite.tasks[task_id]}, words, read)
        prompt = showing_prompts(library, suite.benchmark, suite.ability, scenes, [task_id])[task_id]
        told = {SCENE: scenes.graphs[task_id].text}
        experiment = experiment_to_json(scenes.experiment)
        state.metadata |= {**told, EXPERIMENT: experiment, "stop": list(prompt.stop)}
        known = {name: value for name, value in about.items() if name != ASKS}
        state.messages = messages_of(prompt, {**known, **told})
        return state

    return solve
