"""Scenes as the questions of a run show them, instead of a list of what holds, and how right that is."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from eai.abilities.declaration import declaration_of
from eai.abilities.experiment import Experiment, make_name_choice
from eai.abilities.protocol import SCENE_GRAPH
from eai.base.entry_points import load_offer
from eai.base.errors import InputError
from eai.base.files import read_content
from eai.base.grouping import group_pairs
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.prompt_library import Library
from eai.benchmarks.suite import Suite, open_suite
from eai.results.codec import dataclass_to_json
from eai.results.epochs import BeliefSet
from eai.studies.perception.belief import believed_task, scene_words
from eai.studies.perception.choice import STUDY, Clutter, Perception, Showing
from eai.studies.perception.errors import perception_errors
from eai.studies.perception.noise import perceive
from eai.studies.perception.scene_graph import SCENE, SceneGraph, SceneWords, read_scene_graph
from eai.studies.variation import Endpoint, Stage
from eai.tasks.prompts.prompt import INITIAL_PLACEHOLDER, Belief, Image
from eai.tasks.prompts.template import Templates
from eai.tasks.task import Task
from eai.tasks.wording import prompt_objects
from eai.world.relation import bits
from eai.world.state import Fact

_PLACE = 20

_MEDIA_TYPES = {".png": "image/png", ".jpg": "image/jpeg", ".jpeg": "image/jpeg", ".webp": "image/webp"}
"""The media types of pictures by how their files' names end."""

_TIMES: Mapping[Clutter, int] = {"none": 0, "some": 1, "many": 4}


def _believed(label: str, beliefs: Mapping[str, Belief], **more: Any) -> BeliefSet:
    """Scenes as beliefs; ``label`` says how they are shown."""
    lacking = "there is no scene graph or picture that would tell of the scene"
    experiment = Experiment({STUDY: make_name_choice("scene", "scene", label, _PLACE)})
    return BeliefSet(beliefs, experiment, lacking, **more)


def perceived_scenes(
    label: str, tasks: Mapping[str, Task], words: SceneWords, graphs: Mapping[str, SceneGraph]
) -> BeliefSet:
    """The scenes of questions that tell of scene graphs, be they right or not.

    Args:
        label: where they are from, as experiments have it.
        tasks: the tasks.
        words: how scene graphs say what is so.
        graphs: the scene graphs by task; the others have none.
    """
    beliefs = {i: Belief(believed_task(tasks[i], words, each)) for i, each in graphs.items()}
    errors = {i: dataclass_to_json(perception_errors(tasks[i], words, each)) for i, each in graphs.items()}
    about = {i: {SCENE: each.text} for i, each in graphs.items()}
    return _believed(
        label, beliefs, metadata=about, summaries={i: {STUDY: each} for i, each in errors.items()}
    )


def listed_scenes(label: str, suite: Suite, texts: Mapping[str, str]) -> BeliefSet:
    """The scenes of questions that tell of scene graphs as a model wrote them, by task."""
    words = scene_words(suite.benchmark)
    read = {task_id: read_scene_graph(text, words.arities) for task_id, text in texts.items()}
    return perceived_scenes(label, suite.tasks, words, read)


def shown_scenes(
    choice: Perception, benchmark: Benchmark, tasks: Mapping[str, Task], templates: Templates
) -> BeliefSet:
    """The scenes of questions where no second model lists them for the one who is asked.

    Raises:
        InputError: there is no picture of a task.
        EaiError: the library that draws pictures is not installed.
    """
    look = partial(_seen_anew, choice, benchmark, templates) if choice.can_look_again else None
    if choice.noise is not None:
        words = scene_words(benchmark)
        seen = {i: perceive(task, words, choice.noise) for i, task in tasks.items()}
        return replace(perceived_scenes(choice.label, tasks, words, seen), look=look)
    return _believed(choice.label, _shown(choice, benchmark, tasks, templates), look=look)


def _shown(
    choice: Perception, benchmark: Benchmark, tasks: Mapping[str, Task], templates: Templates
) -> dict[str, Belief]:
    """The beliefs of questions that show scenes as they are, by task; none without a picture."""
    if choice.scene == "text":
        said = {
            i: _with_context(INITIAL_PLACEHOLDER, choice, task, benchmark, templates)
            for i, task in tasks.items()
        }
        return {i: Belief(task, initial=said[i]) for i, task in tasks.items()}
    images = _pictures(choice, benchmark, tasks)
    texts = {i: _said(choice.scene, tasks[i], benchmark, templates) for i in images}
    said = {i: _with_context(text, choice, tasks[i], benchmark, templates) for i, text in texts.items()}
    return {i: Belief(tasks[i], initial=said[i], images=shown) for i, shown in images.items()}


def _seen_anew(
    choice: Perception, benchmark: Benchmark, templates: Templates, task: Task, attempt: int
) -> tuple[Belief, Mapping[str, str]]:
    """A scene that has changed, as it is perceived before an attempt, with errors of its own."""
    if choice.noise is None:
        return _shown(choice, benchmark, {task.id: task}, templates)[task.id], {}
    words = scene_words(benchmark)
    seen = perceive(task, words, choice.noise, str(attempt))
    return Belief(believed_task(task, words, seen)), {SCENE: seen.text}


def _with_context(
    text: str, choice: Perception, task: Task, benchmark: Benchmark, templates: Templates
) -> str:
    """The words of the question about the scene, with what else is told of it."""
    if choice.context in (None, "none"):
        return text
    return f"{text}\n\n{context_of(task, scene_words(benchmark), choice.context, templates)}"


def context_of(task: Task, words: SceneWords, much: Clutter, templates: Templates) -> str:
    """Return what a list of facts leaves out: other objects of the scene, and states that do not hold.

    Args:
        task: the task.
        words: how facts are named.
        much: how many other objects are listed, as many as pictures show with this clutter.
        templates: the words around the lists.
    """
    wording, described = words.wording, prompt_objects(task)
    others = others_in_view(task, words, described, much)
    told = {words.named(fact, words.names(task)) for fact in words.holding(task.initial, described)}
    around = words.describe(task, [*described, *others])
    states = [name for name in wording.predicates if wording.domain.vocabulary.arity(name) == 1]
    untrue = [
        f"not {fact}"
        for name in states
        for index in described
        if (fact := wording.write_fact(task, Fact(name, (index,)))) not in set(map(str, told))
    ]
    values = {
        "objects": "\n".join([wording.describe_object(task, index) for index in others]) or "-",
        "facts": "\n".join([str(fact) for fact in around.facts if fact not in told]) or "-",
        "untrue": "\n".join(untrue) or "-",
    }
    return templates.fill("scene_context.txt", values)


def others_in_view(task: Task, words: SceneWords, shown: Sequence[int], clutter: Clutter) -> list[int]:
    """Return further objects of a scene, first those that are in or on what is shown."""
    state, scene = task.initial, task.scene
    said = {index for fact in words.holding(state, range(len(scene.objects))) for index in fact.arguments}
    supports = [state.relation(words.stored[name]) for name in words.supports]
    near = {i for relation in supports for index in shown for i in bits(relation.column(index))}
    ranked = sorted(said.difference(shown), key=lambda index: (index not in near, index))
    return ranked[: _TIMES[clutter] * len(shown)]


def _said(scene: Showing, task: Task, benchmark: Benchmark, templates: Templates) -> str:
    """The words of the question about its pictures."""
    text = templates.read(f"scene_{scene}.txt")
    names = scene_words(benchmark).names(task)
    if scene == "numbered":
        return f"{text}\n{', '.join([f'{number} {names[number]}' for number in prompt_objects(task)])}"
    if scene != "pointed":
        return text
    where: Mapping[int, tuple[int, int, int]] = _offered("rendered_pictures", scene).places_of(task)
    lines = [
        f"{names[i]}: {'picture {}, ({}, {})'.format(*where[i])}" for i in prompt_objects(task) if i in where
    ]
    return "\n".join([text, *lines])


def _offered(name: str, scene: Showing) -> Any:
    return load_offer(name, f"perception.scene {scene}")


def _pictures(
    choice: Perception, benchmark: Benchmark, tasks: Mapping[str, Task]
) -> Mapping[str, tuple[Image, ...]]:
    if choice.images is not None:
        return images_in(choice.images, tasks)
    images: Mapping[str, tuple[Image, ...]]
    if choice.scene in ("rendered", "numbered", "pointed"):
        rendered = _offered("rendered_pictures", choice.scene)
        images = rendered.photographed(tasks, numbered=choice.scene == "numbered")
    else:
        diagrams = _offered("diagrams", choice.scene)
        images = diagrams.drawn_images(benchmark, tasks, choice.clutter or "none")
    return images


def images_in(folder: Path, task_ids: Iterable[str]) -> dict[str, tuple[Image, ...]]:
    """The pictures in a folder by task: the files whose names begin with its id, in their order.

    Raises:
        InputError: there is no picture of a task, or a file cannot be read.
    """
    known = list(task_ids)
    found = [each for each in sorted(folder.glob("*")) if each.suffix.lower() in _MEDIA_TYPES]
    files = group_pairs((_owner(file.stem, known), file) for file in found if file.is_file())
    lacking = [task_id for task_id in known if task_id not in files]
    if lacking:
        shown = ", ".join(lacking[:3]) + (", ..." if len(lacking) > 3 else "")
        raise InputError(f"images {folder}: no picture of {len(lacking)} of {len(known)} tasks ({shown})")
    return {
        i: tuple([Image(_MEDIA_TYPES[file.suffix.lower()], read_content(file)) for file in files[i]])
        for i in known
    }


def _owner(stem: str, task_ids: Sequence[str]) -> str | None:
    """The task whose id a file's name begins with: the longest one, ended by no letter or digit."""
    begun = [i for i in task_ids if stem == i or (stem.startswith(i) and not stem[len(i)].isalnum())]
    return max(begun, key=len, default=None)


def _refuse_published(choice: Perception, library: Library, suite: Suite) -> None:
    """Raise if a scene is to be shown in another way by published prompts."""
    is_posed = declaration_of(suite.ability).interaction.make_question is not None
    published = suite.benchmark.data.prompts is not None and not is_posed
    if library.prompts == "official" and published:
        scene = choice.scene
        raise InputError(
            f"perception.scene {scene}: published prompts tell of scenes in their own way; "
            "ask ours (--set eai, in Inspect -T prompts=eai)"
        )


def scenes(choice: Perception, stage: Stage, endpoint: Endpoint, suite: Suite) -> BeliefSet:
    """The scenes of a run, once for each domain and the same for all models.

    A captioner is asked first, for all tasks of a domain at once; its lists are then what other models read.

    Raises:
        InputError: published prompts cannot describe another scene, or a picture is missing.
    """
    _refuse_published(choice, stage.library, suite)
    key = (suite.domain,)
    if key not in stage.known:
        if choice.scene == "predicted":
            stage.known[key] = _listed(choice, stage, suite)
        else:
            tasks = {i: suite.tasks[i] for i in suite.tasks if i in stage.wanted[suite.domain]}
            templates = stage.library.templates
            stage.known[key] = shown_scenes(choice, suite.benchmark, tasks, templates)
    return stage.known[key]


def _listed(choice: Perception, stage: Stage, suite: Suite) -> BeliefSet:
    """The scenes as a captioner lists them, who is shown pictures."""
    asked = open_suite(suite.benchmark, SCENE_GRAPH, source=suite.source)
    pictured = Stage(stage.library, stage.wanted, stage.ask, partial(scenes, choice.of_pictures()))
    captioner = Endpoint(str(choice.scene_model), choice.scene_args, choice.scene_base_url)
    task_ids = [task_id for task_id in asked.task_ids if task_id in stage.wanted[suite.domain]]
    prompts, _ = pictured.second(captioner, task_ids, asked)
    answers = stage.answers(captioner, prompts, asked, first=pictured, epochs=1)
    return listed_scenes(choice.label, suite, answers)
