"""Ask a model to interpret goals in the first stage of a pipeline. The next questions state these goals.

Every answer has a defined outcome, and every task counts. The goals of a readable answer are stated, right or
wrong, even if they name unknown objects or predicates. If an answer is unreadable, the question of the second
stage states no goals. Without an answer to the first stage, no question is asked, and the task counts as not
answered.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeAlias

from eai.abilities.experiment import Experiment, make_study_settings_of_one_option
from eai.abilities.goal_interpretation.verdict import GoalVerdict
from eai.abilities.notation.goal_lexicon import read_stated_goals
from eai.abilities.protocol import Ability
from eai.abilities.verdict import ALL, ConfusionCounts, Unreadable
from eai.base.errors import InputError
from eai.base.files import find_files_below, to_file_name
from eai.base.grouping import group_pairs
from eai.base.json_value import Json
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.suite import Suite, open_suite
from eai.results.answer_files import find_files_of_suite
from eai.results.codec import hash_text
from eai.results.epochs import STATED, SUBGOALS, GoalsAndScenesStatedInPrompts
from eai.results.record import Record
from eai.results.records import RECORDS, read_records
from eai.results.responses import read_responses
from eai.studies.variation import ModelEndpoint, StageThatObtainsGoalsOrScenes
from eai.tasks.prompts.prompt import BelievedTask
from eai.tasks.source import Source

ABILITIES_WITH_STATED_GOALS = (Ability.ACTION_SEQUENCING, Ability.SUBGOAL_DECOMPOSITION)
"""Abilities (kinds of question) whose questions state the goals of a task: stage two of a pipeline."""

OWN = "own"
"""Value of ``pipeline.goals`` for goals that the asked model itself has interpreted."""


STUDY = "pipeline"
"""Name of this study. Records of a run store by it the model whose answers gave the questions' goals."""

_PLACE = 10

AnswersOfModel: TypeAlias = tuple[str, Mapping[str, str]]
"""Pair of a model's name and the model's answers to the questions of one ability, by task id."""


def read_interpreted_goals_for_prompts(
    path: Path, benchmark: Benchmark, ability: Ability, source: Source, model: str = ""
) -> GoalsAndScenesStatedInPrompts:
    """Read the goals that a model's answers state. Later questions state them instead of the true goals.

    The answers are in a file or folder.

    Raises:
        InputError: questions of the ability state no goals, or there are no answers.
    """
    require_ability_whose_questions_state_goals(ability)
    return make_interpreted_goals_for_prompts(
        read_goal_interpretation_answers(path, benchmark, source, model), benchmark, source
    )


def require_ability_whose_questions_state_goals(ability: Ability) -> None:
    """Raise an error if the questions of an ability state no goals."""
    if ability not in ABILITIES_WITH_STATED_GOALS:
        names = " or ".join(stage.value for stage in ABILITIES_WITH_STATED_GOALS)
        raise InputError(f"goals: questions of {ability.value} state no goals; choose {names}")


def make_interpreted_goals_for_prompts(
    interpretations: AnswersOfModel,
    benchmark: Benchmark,
    source: Source,
    perceived_scenes: Mapping[str, BelievedTask] | None = None,
) -> GoalsAndScenesStatedInPrompts:
    """Return the goals in a model's answers, which later questions state in place of the true goals.

    The result also has the counts of right and wrong goals. The answers are scored by the default rules.

    Args:
        interpretations: a model's name, and its answers to goal interpretation.
        benchmark: the benchmark.
        source: source of the benchmark's data.
        perceived_scenes: task id -> the perceived scene in the question, whose objects the answer names; by
            default the true scene.
    """
    model, answers = interpretations
    suite = open_suite(benchmark, Ability.GOAL_INTERPRETATION, source=source)
    beliefs: dict[str, BelievedTask] = {}
    stated: dict[str, Mapping[str, Json]] = {}
    for task_id in suite.task_ids:
        if task_id in answers:
            answer = answers[task_id]
            scene = (perceived_scenes or {}).get(task_id) or BelievedTask(suite.tasks[task_id])
            goals = read_stated_goals(answer, scene.task, benchmark.domain, benchmark.notation.goals).goals
            beliefs[task_id] = BelievedTask(replace(scene.task, goals=goals), answer)
            stated[task_id] = _summarize_goals_stated_in_answer(answer, task_id, suite)
    return GoalsAndScenesStatedInPrompts(
        beliefs,
        Experiment({STUDY: make_study_settings_of_one_option("goals", "goals_from", model, _PLACE)}),
        "there is no answer to goal interpretation that would state the goals",
        {task_id: {STATED: belief.answer} for task_id, belief in beliefs.items()},
        {task_id: {STUDY: summary} for task_id, summary in stated.items()},
    )


def _summarize_goals_stated_in_answer(answer: str, task_id: str, suite: Suite) -> dict[str, Json]:
    """Return the stored summary of the goals in an answer: counts of right and wrong goals, and defects."""
    read = read_stated_goals(
        answer, suite.tasks[task_id], suite.benchmark.domain, suite.benchmark.notation.goals
    )
    return {
        "goals_sha256": hash_text(answer),
        "goal_counts": list(count_right_wrong_and_missed_goals(suite.score(task_id, answer))),
        "stage_1_unreadable": read.unreadable is not None,
        "stage_1_unknown": list(read.unknown),
        "stage_1_left_out": len(read.left_out),
    }


def count_right_wrong_and_missed_goals(verdict: object) -> ConfusionCounts:
    """Return three numbers: right goals, other stated goals, and missed goals of the task.

    Other stated goals are wrong, ill-formed, or name something that does not exist.
    """
    if not isinstance(verdict, GoalVerdict) or verdict.counts is None:
        raise TypeError(f"expected a verdict with counts of goals (goal interpretation), found {verdict}")
    right, wrong, missed = verdict.counts[ALL]
    return ConfusionCounts(right, wrong + verdict.ill_formed + len(verdict.hallucinated), missed)


def read_goal_interpretation_answers(
    path: Path, benchmark: Benchmark, source: Source, model: str = ""
) -> AnswersOfModel:
    """Return the answers to goal interpretation in a file of responses or records, or a folder of such files.

    Records in a folder come before response files.

    Args:
        path: the file or folder.
        benchmark: the benchmark of the answers.
        source: source of the benchmark's data.
        model: the model whose answers are wanted, if the folder has answers of several models.

    Raises:
        InputError: there are no answers, no model has the wanted name, or the model has several runs.
    """
    are_records = path.suffix == ".jsonl"
    records = find_files_below(path, RECORDS) if path.is_dir() else [path] * are_records
    answers = list(_read_answers_from_records(records, benchmark))
    if not answers and not are_records:
        answers = list(_read_answers_from_responses(path, benchmark, source))
    by_model, wanted = group_pairs(answers), f"{benchmark.name} {Ability.GOAL_INTERPRETATION.value}"
    chosen = next(iter(by_model)) if len(by_model) == 1 else to_file_name(model) if model else ""
    if chosen not in by_model:
        names = ", ".join(sorted(by_model)) or "none"
        raise InputError(
            f"{path}: expected answers to {wanted} of one model, found {names}; give the answers of one model"
        )
    runs = by_model[chosen]
    if len(runs) > 1:
        raise InputError(f"{path}: {len(runs)} runs of {chosen} answer {wanted}; give the folder of one run")
    return chosen, runs[0]


def _read_answers_from_records(files: list[Path], benchmark: Benchmark) -> Iterator[AnswersOfModel]:
    for file in files:
        answers: dict[str, dict[str, str]] = {}
        for record in read_records(file):
            if (record.domain, record.ability) != (benchmark.name, Ability.GOAL_INTERPRETATION):
                break
            if record.unanswered is None:
                answers.setdefault(to_file_name(record.model), {})[record.task_id] = record.response
        yield from answers.items()


def _read_answers_from_responses(
    path: Path, benchmark: Benchmark, source: Source
) -> Iterator[AnswersOfModel]:
    task_ids = tuple(benchmark.tasks_for(Ability.GOAL_INTERPRETATION, source))
    for file in find_files_of_suite(path, benchmark.name, Ability.GOAL_INTERPRETATION):
        read = read_responses(file, task_ids, benchmark.data.task_id_of)
        yield read.model, {response.task_id: response.text for response in read.responses}


def obtain_goals_interpreted_by_model(
    goals: str, stage: StageThatObtainsGoalsOrScenes, endpoint: ModelEndpoint, suite: Suite
) -> GoalsAndScenesStatedInPrompts:
    """Return the goals in a model's answers, which later questions state in place of the true goals.

    The model is asked (goal interpretation), or a file is read, once for each model and domain.

    Args:
        goals: `OWN` to ask the model, or the file or folder with its answers.
        stage: the stage of the run that asks for goals, before the questions that state the goals.
        endpoint: the model.
        suite: the suite whose questions state the goals.

    Raises:
        InputError: there are no answers, or no answers to tasks of the run.
    """
    key = (endpoint.model, suite.domain)
    if key not in stage.found_beliefs:
        if goals == OWN:
            answers = _ask_for_goals(stage, endpoint, suite)
        else:
            answers = read_goal_interpretation_answers(
                Path(goals), suite.benchmark, suite.source, endpoint.model
            )
        scenes = (
            None
            if stage.previous is None
            else stage.previous.collect_goals_and_scenes_up_to_this_stage(endpoint, suite).beliefs
        )
        stage.found_beliefs[key] = make_interpreted_goals_for_prompts(
            answers, suite.benchmark, suite.source, scenes
        )
    if not stage.found_beliefs[key].beliefs.keys() & set(stage.task_ids[suite.domain]):
        raise InputError(
            f"goals {goals}: found no answer to goal interpretation for any task of the run; "
            "run tasks that have answers, or give answers for the run's tasks"
        )
    return stage.found_beliefs[key]


def obtain_goals_and_subgoals_stated_by_model(
    stage: StageThatObtainsGoalsOrScenes, endpoint: ModelEndpoint, suite: Suite
) -> GoalsAndScenesStatedInPrompts:
    """Return a model's goals, with the subgoals that the model lists for these goals.

    The model is asked once for each domain.

    Raises:
        InputError: published prompts cannot state subgoals.
    """
    if stage.library.prompts == "official" and suite.benchmark.data.prompts is not None:
        raise InputError(
            "pipeline.subgoals: published prompts state no subgoals; choose the prompts of eai by --set eai"
        )
    key = (endpoint.model, suite.domain)
    if key not in stage.found_beliefs:
        subgoal_suite = open_suite(
            suite.benchmark, Ability.SUBGOAL_DECOMPOSITION, suite.protocol, source=suite.source
        )
        prompts = stage.library.open(suite.benchmark, Ability.SUBGOAL_DECOMPOSITION)
        wanted = {i: prompts[i] for i in subgoal_suite.task_ids if i in stage.task_ids[suite.domain]}
        answers = stage.ask_for_answers(endpoint, wanted, subgoal_suite, first=stage.previous)
        goals = (
            None
            if stage.previous is None
            else stage.previous.collect_goals_and_scenes_up_to_this_stage(endpoint, suite)
        )
        stage.found_beliefs[key] = add_subgoals_to_stated_goals(
            goals, (to_file_name(endpoint.model), answers), subgoal_suite
        )
    return stage.found_beliefs[key]


def add_subgoals_to_stated_goals(
    goal_beliefs: GoalsAndScenesStatedInPrompts | None, subgoal_answers: AnswersOfModel, suite: Suite
) -> GoalsAndScenesStatedInPrompts:
    """Return a model's goals with the subgoals from its answers; unreadable answers add no subgoals.

    Args:
        goal_beliefs: the model's goals by task, or None if there are no goals. Tasks without goals are left
            out of the result.
        subgoal_answers: a model's name, and its answers to subgoal decomposition by task id.
        suite: the suite of subgoal decomposition.
    """
    model, answers = subgoal_answers
    beliefs: dict[str, BelievedTask] = {}
    summaries: dict[str, Mapping[str, Mapping[str, Any]]] = {}
    for task_id, answer in answers.items():
        if goal_beliefs is None or task_id not in goal_beliefs.beliefs:
            continue
        read = suite.benchmark.subgoal_notation().read(answer)
        subgoals = () if isinstance(read, Unreadable) else read.subgoals
        beliefs[task_id] = replace(goal_beliefs.beliefs[task_id], subgoals=subgoals)
        success = bool(getattr(suite.score(task_id, answer), "success", False))
        summaries[task_id] = {STUDY: {"subgoals_sha256": hash_text(answer), "subgoals_success": success}}
    return GoalsAndScenesStatedInPrompts(
        beliefs,
        Experiment({STUDY: make_study_settings_of_one_option("subgoals", "subgoals_from", model, _PLACE)}),
        "there is no answer to subgoal decomposition that would state subgoals",
        {task_id: {SUBGOALS: answers[task_id]} for task_id in beliefs},
        summaries,
    )


def summarize_goals_stated_in_question(
    record: Record, suite: Suite, question_metadata: Mapping[str, Any]
) -> Mapping[str, Json]:
    """Return the summary of the goals and subgoals that a question stated, for the record of its answer.

    Args:
        record: the record of the answer.
        suite: the suite of the question.
        question_metadata: the metadata of the question. They include the model's earlier answers, from which
            the goals and subgoals were taken.
    """
    task_id, models = record.task_id, record.settings_by_study[STUDY].options
    if STATED not in question_metadata:
        return {}
    beliefs = make_interpreted_goals_for_prompts(
        (models["goals_from"], {task_id: question_metadata[STATED]}), suite.benchmark, suite.source
    )
    if SUBGOALS in question_metadata:
        subgoal_suite = open_suite(
            suite.benchmark, Ability.SUBGOAL_DECOMPOSITION, suite.protocol, source=suite.source
        )
        listed = models["subgoals_from"], {task_id: question_metadata[SUBGOALS]}
        beliefs = beliefs.combine_own_scenes_with_goals_of(
            add_subgoals_to_stated_goals(beliefs, listed, subgoal_suite)
        )
    return beliefs.summaries.get(task_id, {}).get(STUDY, {})


def _ask_for_goals(
    stage: StageThatObtainsGoalsOrScenes, endpoint: ModelEndpoint, suite: Suite
) -> AnswersOfModel:
    first = open_suite(suite.benchmark, Ability.GOAL_INTERPRETATION, suite.protocol, source=suite.source)
    prompts = stage.library.open(suite.benchmark, Ability.GOAL_INTERPRETATION)
    wanted = [task_id for task_id in first.task_ids if task_id in stage.task_ids[suite.domain]]
    chosen = {task_id: prompts[task_id] for task_id in wanted}
    return to_file_name(endpoint.model), stage.ask_for_answers(endpoint, chosen, first, first=stage.previous)
