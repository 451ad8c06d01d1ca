"""Make the scenes that the questions of a run show, as facts or pictures, and count their wrong facts."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from eai.abilities.declaration import get_declaration
from eai.abilities.experiment import Experiment, make_study_settings_of_one_option
from eai.abilities.protocol import SCENE_GRAPH
from eai.base.entry_points import load_from_extension
from eai.base.errors import InputError
from eai.base.files import read_content
from eai.base.grouping import group_pairs
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.prompt_library import PromptLibrary
from eai.benchmarks.suite import Suite, open_suite
from eai.results.codec import dataclass_to_json
from eai.results.epochs import GoalsAndScenesStatedInPrompts
from eai.studies.perception.belief import make_scene_graph_vocabulary, replace_scene_by_scene_graph
from eai.studies.perception.choice import STUDY, Clutter, SceneFormat, ScenePresentationOptions
from eai.studies.perception.errors import find_perception_errors
from eai.studies.perception.noise import perceive_with_noise
from eai.studies.perception.scene_graph import SCENE, SceneGraph, SceneGraphVocabulary, read_scene_graph
from eai.studies.variation import ModelEndpoint, StageThatObtainsGoalsOrScenes
from eai.tasks.prompts.prompt import INITIAL_PLACEHOLDER, BelievedTask, Image
from eai.tasks.prompts.template import PromptTemplates
from eai.tasks.task import Task
from eai.tasks.wording import list_objects_in_prompt
from eai.world.relation import iterate_bits
from eai.world.state import Fact

_PLACE = 20

_MEDIA_TYPES = {".png": "image/png", ".jpg": "image/jpeg", ".jpeg": "image/jpeg", ".webp": "image/webp"}
"""Media types of pictures, by the suffix of the picture's file."""

_MAX_OTHERS_PER_OBJECT: Mapping[Clutter, int] = {"none": 0, "some": 1, "many": 4}


def _combine_shown_scenes_with_format_for_records(
    scene_format: str, beliefs: Mapping[str, BelievedTask], **further_fields: Any
) -> GoalsAndScenesStatedInPrompts:
    """Combine the scenes that questions show (``beliefs``) with the scene format that records store."""
    lacking = "there is no scene graph or picture that would tell of the scene"
    experiment = Experiment(
        {STUDY: make_study_settings_of_one_option("scene", "scene", scene_format, _PLACE)}
    )
    return GoalsAndScenesStatedInPrompts(beliefs, experiment, lacking, **further_fields)


def make_scenes_for_prompts_from_graphs(
    scene_format_label: str,
    tasks: Mapping[str, Task],
    words: SceneGraphVocabulary,
    graphs: Mapping[str, SceneGraph],
) -> GoalsAndScenesStatedInPrompts:
    """Return scenes that scene graphs describe; questions state them instead of the true scenes.

    Args:
        scene_format_label: name of the scene format, which becomes part of the run's name.
        tasks: the tasks.
        words: the names of predicates and objects in scene graphs.
        graphs: the scene graphs by task id; tasks without a graph are left out.
    """
    beliefs = {
        i: BelievedTask(replace_scene_by_scene_graph(tasks[i], words, graph)) for i, graph in graphs.items()
    }
    errors = {
        i: dataclass_to_json(find_perception_errors(tasks[i], words, graph)) for i, graph in graphs.items()
    }
    about = {i: {SCENE: graph.json_text} for i, graph in graphs.items()}
    return _combine_shown_scenes_with_format_for_records(
        scene_format_label,
        beliefs,
        metadata=about,
        summaries={i: {STUDY: summary} for i, summary in errors.items()},
    )


def read_scene_graphs_for_prompts(
    scene_format_label: str, suite: Suite, graph_texts: Mapping[str, str]
) -> GoalsAndScenesStatedInPrompts:
    """Read scene graphs, and return the scenes that they describe (`make_scenes_for_prompts_from_graphs`).

    Args:
        scene_format_label: name of the scene format, which becomes part of the run's name.
        suite: the suite of the tasks.
        graph_texts: mapping from task ids to the texts of scene graphs.
    """
    words = make_scene_graph_vocabulary(suite.benchmark)
    read = {
        task_id: read_scene_graph(text, words.arity_by_predicate_name_in_graphs)
        for task_id, text in graph_texts.items()
    }
    return make_scenes_for_prompts_from_graphs(scene_format_label, suite.tasks, words, read)


def make_scenes_for_prompts_without_captioner(
    options: ScenePresentationOptions,
    benchmark: Benchmark,
    tasks: Mapping[str, Task],
    templates: PromptTemplates,
) -> GoalsAndScenesStatedInPrompts:
    """Return the scenes that questions show, in any format but ``predicted``, which needs a second model.

    Raises:
        InputError: a task has no picture.
        EaiError: the library that draws pictures is not installed.
    """
    look = (
        partial(_perceive_scene_before_attempt, options, benchmark, templates)
        if options.can_question_show_scene_after_actions
        else None
    )
    if options.noise is not None:
        words = make_scene_graph_vocabulary(benchmark)
        seen = {i: perceive_with_noise(task, words, options.noise) for i, task in tasks.items()}
        return replace(
            make_scenes_for_prompts_from_graphs(options.label_of_chosen_options, tasks, words, seen),
            perceive_changed_scene=look,
        )
    return _combine_shown_scenes_with_format_for_records(
        options.label_of_chosen_options,
        _show_true_scenes_as_text_or_pictures(options, benchmark, tasks, templates),
        perceive_changed_scene=look,
    )


def _show_true_scenes_as_text_or_pictures(
    options: ScenePresentationOptions,
    benchmark: Benchmark,
    tasks: Mapping[str, Task],
    templates: PromptTemplates,
) -> dict[str, BelievedTask]:
    """Return by task id the scenes without errors as questions show them: as text, as pictures, or both."""
    if options.scene == "text":
        said = {
            i: _append_unlisted_facts_if_requested(INITIAL_PLACEHOLDER, options, task, benchmark, templates)
            for i, task in tasks.items()
        }
        return {i: BelievedTask(task, initial=said[i]) for i, task in tasks.items()}
    images = _load_task_pictures(options, benchmark, tasks)
    texts = {
        i: _write_prompt_text_about_scene_pictures(options.scene, tasks[i], benchmark, templates)
        for i in images
    }
    said = {
        i: _append_unlisted_facts_if_requested(text, options, tasks[i], benchmark, templates)
        for i, text in texts.items()
    }
    return {i: BelievedTask(tasks[i], initial=said[i], images=shown) for i, shown in images.items()}


def _perceive_scene_before_attempt(
    options: ScenePresentationOptions,
    benchmark: Benchmark,
    templates: PromptTemplates,
    changed_task: Task,
    attempt: int,
) -> tuple[BelievedTask, Mapping[str, str]]:
    """Return the scene for the question of the next attempt, as actions have changed it, with metadata.

    With noise, errors in the scene are drawn again, and the metadata has the text of the scene graph.
    """
    if options.noise is None:
        return _show_true_scenes_as_text_or_pictures(
            options, benchmark, {changed_task.id: changed_task}, templates
        )[changed_task.id], {}
    words = make_scene_graph_vocabulary(benchmark)
    seen = perceive_with_noise(changed_task, words, options.noise, str(attempt))
    return BelievedTask(replace_scene_by_scene_graph(changed_task, words, seen)), {SCENE: seen.json_text}


def _append_unlisted_facts_if_requested(
    text: str, options: ScenePresentationOptions, task: Task, benchmark: Benchmark, templates: PromptTemplates
) -> str:
    if options.context in (None, "none"):
        return text
    words = make_scene_graph_vocabulary(benchmark)
    return f"{text}\n\n{describe_unlisted_facts_and_untrue_states(task, words, options.context, templates)}"


def describe_unlisted_facts_and_untrue_states(
    task: Task, words: SceneGraphVocabulary, clutter: Clutter, templates: PromptTemplates
) -> str:
    """Return a text with objects and facts that the scene in a question leaves out, and with untrue states.

    Args:
        task: the task.
        words: names of predicates and objects in facts.
        clutter: amount of further objects, which the task is not about (`Clutter`).
        templates: the prompt templates, which have the text around the lists.
    """
    wording, described = words.wording, list_objects_in_prompt(task)
    others = choose_distractor_objects(task, words, described, clutter)
    told = {
        words.to_named_fact(fact, words.list_object_names(task))
        for fact in words.list_facts(task.initial, described)
    }
    around = words.make_true_graph(task, [*described, *others])
    states = [name for name in wording.predicates if wording.domain.vocabulary.find_arity(name) == 1]
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
    return templates.fill_template("scene_context.txt", values)


def choose_distractor_objects(
    task: Task, words: SceneGraphVocabulary, shown_objects: Sequence[int], clutter: Clutter
) -> list[int]:
    """Return objects of a scene that are not among the shown objects.

    Objects in or on shown objects come first.
    """
    state, scene = task.initial, task.scene
    said = {index for fact in words.list_facts(state, range(len(scene.objects))) for index in fact.arguments}
    supports = [state.relation(words.stored_forms[name]) for name in words.placement_predicate_names]
    near = {
        i for relation in supports for index in shown_objects for i in iterate_bits(relation.column(index))
    }
    ranked = sorted(said.difference(shown_objects), key=lambda index: (index not in near, index))
    return ranked[: _MAX_OTHERS_PER_OBJECT[clutter] * len(shown_objects)]


def _write_prompt_text_about_scene_pictures(
    scene: SceneFormat, task: Task, benchmark: Benchmark, templates: PromptTemplates
) -> str:
    text = templates.read(f"scene_{scene}.txt")
    names = make_scene_graph_vocabulary(benchmark).list_object_names(task)
    if scene == "numbered":
        return (
            f"{text}\n{', '.join([f'{number} {names[number]}' for number in list_objects_in_prompt(task)])}"
        )
    if scene != "pointed":
        return text
    where: Mapping[int, tuple[int, int, int]] = _load_module_that_makes_pictures(
        "rendered_pictures", scene
    ).map_objects_to_positions_in_pictures(task)
    lines = [
        f"{names[i]}: {'picture {}, ({}, {})'.format(*where[i])}"
        for i in list_objects_in_prompt(task)
        if i in where
    ]
    return "\n".join([text, *lines])


def _load_module_that_makes_pictures(name: str, scene: SceneFormat) -> Any:
    return load_from_extension(name, f"perception.scene {scene}")


def _load_task_pictures(
    options: ScenePresentationOptions, benchmark: Benchmark, tasks: Mapping[str, Task]
) -> Mapping[str, tuple[Image, ...]]:
    if options.images is not None:
        return read_images(options.images, tasks)
    images: Mapping[str, tuple[Image, ...]]
    if options.scene in ("rendered", "numbered", "pointed"):
        rendered = _load_module_that_makes_pictures("rendered_pictures", options.scene)
        images = rendered.render_images_of_tasks(tasks, numbered=options.scene == "numbered")
    else:
        diagrams = _load_module_that_makes_pictures("diagrams", options.scene)
        images = diagrams.draw_task_images(benchmark, tasks, options.clutter or "none")
    return images


def read_images(folder: Path, task_ids: Iterable[str]) -> dict[str, tuple[Image, ...]]:
    """Return the pictures in a folder by task id, in order of file names.

    The name of a picture's file begins with the id of the task.

    Raises:
        InputError: a task has no picture, or a file cannot be read.
    """
    all_ids = list(task_ids)
    pictures = [path for path in sorted(folder.glob("*")) if path.suffix.lower() in _MEDIA_TYPES]
    files = group_pairs((_find_task_of_file(file.stem, all_ids), file) for file in pictures if file.is_file())
    lacking = [task_id for task_id in all_ids if task_id not in files]
    if lacking:
        shown = ", ".join(lacking[:3]) + (", ..." if len(lacking) > 3 else "")
        raise InputError(
            f"images {folder}: no picture of {len(lacking)} of {len(all_ids)} tasks ({shown}); "
            "the name of a picture's file must begin with the id of its task"
        )
    return {
        i: tuple([Image(_MEDIA_TYPES[file.suffix.lower()], read_content(file)) for file in files[i]])
        for i in all_ids
    }


def _find_task_of_file(stem: str, task_ids: Sequence[str]) -> str | None:
    """Return the longest task id that begins a file's name, with no letter or digit right after the id."""
    begun = [i for i in task_ids if stem == i or (stem.startswith(i) and not stem[len(i)].isalnum())]
    return max(begun, key=len, default=None)


def _raise_if_published_prompts_are_used(
    options: ScenePresentationOptions, library: PromptLibrary, suite: Suite
) -> None:
    """Raise an error if the run uses published prompts, which show scenes only in their own format."""
    is_posed = get_declaration(suite.ability).interaction.make_question is not None
    published = suite.benchmark.data.prompts is not None and not is_posed
    if library.prompts == "official" and published:
        scene = options.scene
        raise InputError(
            f"perception.scene {scene}: published prompts show scenes only in their own format; "
            "choose the prompts of eai by --set eai (in Inspect, -T prompts=eai)"
        )


def collect_scenes_for_prompts(
    options: ScenePresentationOptions,
    stage: StageThatObtainsGoalsOrScenes,
    endpoint: ModelEndpoint,
    suite: Suite,
) -> GoalsAndScenesStatedInPrompts:
    """Return the scenes that the questions of a run show.

    The scenes of a domain are made once for all models. For the format ``predicted``, a second model (the
    captioner) first lists the scenes of all tasks of the run in a domain. The questions to the run's models
    then state these lists.

    Raises:
        InputError: the run uses published prompts, which show scenes only in their own format; or a picture
            is missing.
    """
    _raise_if_published_prompts_are_used(options, stage.library, suite)
    key = (suite.domain,)
    if key not in stage.found_beliefs:
        if options.scene == "predicted":
            stage.found_beliefs[key] = _ask_model_to_list_scenes_in_pictures(options, stage, suite)
        else:
            tasks = {i: suite.tasks[i] for i in suite.tasks if i in stage.task_ids[suite.domain]}
            templates = stage.library.templates
            stage.found_beliefs[key] = make_scenes_for_prompts_without_captioner(
                options, suite.benchmark, tasks, templates
            )
    return stage.found_beliefs[key]


def _ask_model_to_list_scenes_in_pictures(
    options: ScenePresentationOptions, stage: StageThatObtainsGoalsOrScenes, suite: Suite
) -> GoalsAndScenesStatedInPrompts:
    """Ask a second model (the captioner) to list the scenes in pictures, and return the listed scenes."""
    graph_suite = open_suite(suite.benchmark, SCENE_GRAPH, source=suite.source)
    pictured = StageThatObtainsGoalsOrScenes(
        stage.library,
        stage.task_ids,
        stage.ask,
        partial(collect_scenes_for_prompts, options.make_options_that_show_only_pictures()),
    )
    captioner = ModelEndpoint(str(options.scene_model), options.scene_args, options.scene_base_url)
    task_ids = [task_id for task_id in graph_suite.task_ids if task_id in stage.task_ids[suite.domain]]
    prompts, _ = pictured.make_prompts_with_goals_and_scenes(captioner, task_ids, graph_suite)
    answers = stage.ask_for_answers(captioner, prompts, graph_suite, first=pictured, epochs=1)
    return read_scene_graphs_for_prompts(options.label_of_chosen_options, suite, answers)
