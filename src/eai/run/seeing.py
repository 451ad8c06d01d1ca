"""Scenes in Inspect's tasks: a second model that sees for the one who is asked."""

from __future__ import annotations

from inspect_ai.model import get_model
from inspect_ai.solver import Generate, Solver, TaskState, solver

from eai.abilities.codec import experiment_to_json
from eai.benchmark.prompt_library import Library
from eai.benchmark.suite import Suite
from eai.run.job import EYES
from eai.run.messages import messages_of, part
from eai.run.scorer import EXPERIMENT
from eai.studies.perception.belief import scene_words
from eai.studies.perception.scene_graph import read_scene_graph
from eai.studies.perception.scenes import ASKS, SCENE, perceived_scenes
from eai.studies.perception.showing import showing_prompts
from eai.studies.perception.study import Perception


@solver(name="eai_see")
def see(choice: Perception, library: Library, suite: Suite) -> Solver:
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
        label = choice.model_copy(update={"scene_model": str(eyes)}).label
        scenes = perceived_scenes(label, {task_id: suite.tasks[task_id]}, words, read)
        prompt = showing_prompts(library, suite.benchmark, suite.ability, scenes, [task_id])[task_id]
        told = {SCENE: scenes.graphs[task_id].text}
        experiment = experiment_to_json(scenes.experiment)
        state.metadata |= {**told, EXPERIMENT: experiment, "stop": list(prompt.stop)}
        known = {name: value for name, value in about.items() if name != ASKS}
        state.messages = messages_of(prompt, {**known, **told})
        return state

    return solve
