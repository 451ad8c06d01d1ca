"""Tasks of the library Inspect, one for each suite, for ``eai run`` and ``inspect eval eai/...``; reads logs.

A suite is an ability in a benchmark. A log holds the answers to a job (the questions of a suite for one
model), with their scores. Answers can be read from any log. A refused argument raises an exception of click,
which Inspect's command line shows as one line.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any, TypeAlias

import click
import inspect_ai
from inspect_ai import SampleSource
from inspect_ai.dataset import Dataset, MemoryDataset, Sample
from inspect_ai.log import (
    EvalLog,
    EvalSample,
    HeadlineMetric,
    read_eval_log,
)
from inspect_ai.model import GenerateConfig, Model, get_model
from inspect_ai.solver import Solver
from inspect_ai.util import registry_info

from eai.abilities.declaration import get_declaration
from eai.abilities.experiment import Experiment
from eai.abilities.protocol import DEFAULT_PROTOCOL, Ability
from eai.abilities.replanning_options import ReplanningOptions
from eai.agents.play import make_episode_prompts_and_metadata
from eai.agents.setting import AGENT_SETTING_FIELD, AgentSetting
from eai.base.errors import EaiError, InputError, UserInterruptError, did_you_mean
from eai.base.files import raise_write_errors_as_input_errors, require_file, to_file_name
from eai.base.grouping import group_pairs
from eai.base.json_value import Json
from eai.benchmarks.gold_answers import open_gold_answers
from eai.benchmarks.names import suite_name
from eai.benchmarks.prompt_library import PromptLibrary
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.suite import Suite, open_suite
from eai.pddl.planning import PlannerChoice
from eai.results.codec import experiment_to_json
from eai.results.epochs import (
    GoalsAndScenesStatedInPrompts,
    ModelAnswers,
    SuiteResult,
    select_item_with_majority_answer,
)
from eai.results.record import Record
from eai.results.responses import Response, ResponseFile
from eai.results.trials import ReplanningConversationFactory, make_replanning_conversation_factory
from eai.run.acting import offer_task_tools, play_missing_episodes, player, read_episode_text
from eai.run.context import is_endpoint_on_server_of_user, require_server_at_model_address
from eai.run.job import ERRATA, QuestionJob, describe_unknown_provider, is_built_in_model
from eai.run.journal import AnswerJournal, ProgressWatch, RunState
from eai.run.request_errors import (
    get_message_without_markup,
    is_library_or_key_missing,
    limit_tries_of_refused_connections,
)
from eai.run.scorer import EXPERIMENT, SCORERS, LoggedSamples, add_logged_study_results_to_record
from eai.run.solver import (
    make_messages,
    make_solver_that_asks_questions,
    make_solver_without_answer_journal,
    remove_unreadable_token_usage_in_replies,
)
from eai.run.spec import find_study_of_option, read_spec
from eai.studies.prompts.choice import make_experiment_with_prompt_name
from eai.studies.variation import ModelEndpoint, StageThatObtainsGoalsOrScenes
from eai.tasks.prompts.prompt import Prompt
from eai.tasks.source import ErrataChoice, Source


class _TaskArgumentError(InputError, click.ClickException):
    """Error for an argument of a task or a model that cannot be used."""


@contextmanager
def raise_input_errors_as_task_argument_errors() -> Iterator[None]:
    """Turn an InputError of the block into a `_TaskArgumentError`, which click shows as one line."""
    try:
        yield
    except InputError as error:
        raise _TaskArgumentError(str(error)) from error


_MAX_LOG_SAMPLES = 2000
"""Maximum number of samples in one log. Inspect holds a summary of every sample of a log in memory."""

_USUAL_CONNECTIONS = 100
"""Assumed number of simultaneous requests if the user gives no maximum. Inspect sends at most this number."""

_MAX_BUFFERED_SAMPLES = 50
"""Maximum number of finished samples that Inspect holds before it writes them. Each write copies the log."""


class _SamplesFedToInspect(SampleSource):
    """Hands the samples of a job to Inspect while it runs, so that memory does not grow with their number.

    Args:
        samples: the samples, in order.
        epochs: number of runs of each sample.
        ahead: maximum number of runs handed to Inspect that have not ended; None for no limit.
    """

    def __init__(self, samples: Iterable[Sample], *, epochs: int, ahead: int | None) -> None:
        self._samples = iter(samples)
        self._epochs = epochs
        self._ahead = sys.maxsize if ahead is None else ahead
        self._unfinished = 0

    async def next_samples(self) -> list[Sample] | None:
        """Return the next samples for Inspect to run, or None if no sample is left."""
        return self._take_next_samples_within_limit() or None

    async def sample_complete(self, sample: EvalSample) -> list[Sample]:
        """Return the samples that Inspect can start next, after a sample has finished."""
        self._unfinished -= 1
        return self._take_next_samples_within_limit()

    async def sample_abandoned(self, sample: Sample, epoch: int) -> list[Sample]:
        """Return the samples that Inspect can start next, after a waiting or running sample was cancelled."""
        self._unfinished -= 1
        return self._take_next_samples_within_limit()

    def _take_next_samples_within_limit(self) -> list[Sample]:
        free = max(0, self._ahead - self._unfinished)
        taken = list(islice(self._samples, -(-free // self._epochs)))
        self._unfinished += self._epochs * len(taken)
        return taken


def build_task(
    suite: Suite,
    prompts: Mapping[str, Prompt],
    solver: Solver,
    *,
    metadata: Mapping[str, Json] | None = None,
    experiment: Experiment | None = None,
    question_metadata: Mapping[str, Mapping[str, str]] | None = None,
    open_dataset: Callable[[Iterable[Sample]], Dataset | SampleSource] | None = None,
) -> inspect_ai.Task:
    """Return the Inspect task that asks a model these prompts, each with its task's id and gold answer.

    Args:
        suite: the suite.
        prompts: mapping from task ids to questions.
        solver: the solver that asks them.
        metadata: metadata of the log, besides domain and ability.
        experiment: the options of the run's studies (variations of its questions), if any.
        question_metadata: mapping from task ids to the metadata of questions, for the built-in models.
        open_dataset: makes Inspect's dataset from the samples; None for a dataset in memory.
    """
    benchmark, ability = suite.benchmark, suite.ability
    name = suite_name(benchmark.name, ability)
    samples = _make_samples(suite, prompts, experiment, question_metadata or {})
    rules = suite.protocol.value, suite.source.planner.value, suite.source.errata.value
    return inspect_ai.Task(
        dataset=MemoryDataset(list(samples), name=name) if open_dataset is None else open_dataset(samples),
        solver=solver,
        scorer=SCORERS[ability](benchmark.reference, *rules),
        headline_metric=HeadlineMetric(metric=next(iter(get_declaration(ability).overview_headings))),
        name=name,
        metadata={"domain": benchmark.name, "ability": ability.value, **(metadata or {})},
    )


def _make_samples(
    suite: Suite,
    prompts: Mapping[str, Prompt],
    experiment: Experiment | None,
    question_metadata: Mapping[str, Mapping[str, str]],
) -> Iterator[Sample]:
    """Yield the sample of each prompt, in order."""
    benchmark, ability, source = suite.benchmark, suite.ability, suite.source
    gold_answers = open_gold_answers(benchmark, ability, source)
    common_metadata = {"domain": benchmark.reference, "ability": ability.value, ERRATA: source.errata.value}
    choices = {} if experiment is None else experiment_to_json(experiment)
    experiment_metadata = {EXPERIMENT: choices} if choices else {}
    for task_id, prompt in prompts.items():
        metadata_of_question = {
            **common_metadata,
            "task_id": task_id,
            **question_metadata.get(task_id, {}),
        }
        metadata_of_sample: dict[str, Json] = {
            **metadata_of_question,
            "stop": list(prompt.stop),
            **experiment_metadata,
        }
        question = make_messages(prompt, metadata_of_question)
        gold = gold_answers[task_id].text if task_id in gold_answers else ""
        yield Sample(input=question, target=gold, id=task_id, metadata=metadata_of_sample)


def register_suite_task(reference: str, ability: Ability) -> Callable[..., inspect_ai.Task]:
    """Register a suite (an ability in a benchmark) as an Inspect task, ``eai/<domain>_<ability>``.

    Without a reference to a benchmark, the name is ``eai/<ability>``, and ``-T domain=`` names the benchmark.
    """

    def make_suite_task(
        domain: str = reference,
        protocol: str = DEFAULT_PROTOCOL.value,
        prompts: str = "official",
        prompt_folder: str | None = None,
        planner: str = PlannerChoice.AUTO.value,
        errata: str = ErrataChoice.CURRENT.value,
        tasks: str | int | Sequence[str] | None = None,
        **studies: Any,
    ) -> inspect_ai.Task:
        takes_turns = get_declaration(ability).takes_turns
        with raise_input_errors_as_task_argument_errors():
            spec = read_spec(
                {
                    "prompts": {"set": prompts, "folder": prompt_folder},
                    "scoring": {"protocol": protocol, "planner": planner, "errata": errata},
                    **_sort_arguments_into_spec_sections(ability, studies),
                }
            )
            scoring, experiment = spec.scoring, spec.experiment
            source = Source(planner=scoring.planner, errata=scoring.errata)
            suite = open_suite(find_benchmark(domain), ability, scoring.protocol, source=source)
            library = PromptLibrary(spec.prompts.set, spec.prompts.folder, source)
            questions = library.open(suite.benchmark, ability)
            asked = questions if tasks is None else _select_prompts(questions, tasks)
            about: Mapping[str, Mapping[str, str]] = {}
            solver = make_solver_without_answer_journal(None)
            stage = spec.combined_options_of_studies.make_stage_that_obtains_goals_or_scenes(
                library, {suite.domain: asked}, _raise_instead_of_asking_model
            )
            if takes_turns:
                asked, about = make_episode_prompts_and_metadata(spec.setting, asked, suite)
                experiment, solver = Experiment(), player()
            elif spec.combined_options_of_studies.option_that_enables_study:
                spec.combined_options_of_studies.select_abilities([ability])
                beliefs = None
                if stage is not None:
                    asked, beliefs = _make_prompts_stating_model_goals_or_scenes(stage, asked, suite)
                    about = beliefs.metadata
                trials = make_suite_conversations(
                    spec.combined_options_of_studies.replanning, library, suite, asked, beliefs
                )
                solver = make_solver_without_answer_journal(trials)
                experiment = combine_experiments(
                    [experiment, None if beliefs is None else beliefs.experiment]
                )
            if not takes_turns:
                experiment = combine_experiments(
                    [experiment, make_experiment_with_prompt_name(spec.prompts.prompt_label)]
                )
        task = build_task(suite, asked, solver, experiment=experiment, question_metadata=about)
        task.config = GenerateConfig(temperature=0.0)
        task.score_on_error = True
        task.setup = offer_task_tools() if takes_turns else None
        return task

    name = suite_name(reference, ability).lstrip("_")
    registered = inspect_ai.task(name=name)(make_suite_task)
    # in an editable installation, Inspect registers the task without the prefix "eai/"
    if registry_info(registered).name == name:
        registered = inspect_ai.task(name=f"eai/{name}")(make_suite_task)
    return registered


def make_suite_conversations(
    replanning_options: ReplanningOptions | None,
    library: PromptLibrary,
    suite: Suite,
    prompts: Mapping[str, Prompt],
    beliefs: GoalsAndScenesStatedInPrompts | None,
) -> ReplanningConversationFactory | None:
    """Return the object that executes answers and asks again; None if each question is sent once.

    Raises:
        InputError: the answers of the suite are not plans.
    """
    if replanning_options is None:
        return None
    look, goals = (
        (None, {}) if beliefs is None else (beliefs.perceive_changed_scene, beliefs.tasks_with_stated_goals)
    )
    question_writer = library.make_question_writer(suite.benchmark, suite.ability, prompts, look)
    return make_replanning_conversation_factory(suite, replanning_options, question_writer, prompts, goals)


def combine_experiments(parts: Iterable[Experiment | None]) -> Experiment:
    """Combine experiments (options for variations of the questions) into one with all options.

    Raises:
        InputError: two experiments have different values of one option.
    """
    combined = Experiment()
    for experiment in parts:
        combined = combined.combine(experiment or Experiment())
    return combined


def _sort_arguments_into_spec_sections(
    ability: Ability, arguments: Mapping[str, Any]
) -> dict[str, dict[str, Any]]:
    """Return the arguments of an Inspect task as options, by their section of a run's specification.

    Raises:
        InputError: an option is unknown, or would make the run ask a second model. Inspect's tasks ask only
            one model.
    """
    tables: dict[str, dict[str, Any]] = {}
    for name, value in arguments.items():
        if get_declaration(ability).takes_turns and name in AgentSetting.model_fields:
            tables.setdefault(AGENT_SETTING_FIELD, {})[name] = value
            continue
        if name.startswith("scene_") or (name, value) == ("scene", "predicted"):
            raise InputError(f"{name}: a task in Inspect cannot ask a second model for scenes; use eai run")
        tables.setdefault(find_study_of_option(name), {})[name] = value
    return tables


def _raise_instead_of_asking_model(*_: object, **__: object) -> SuiteResult:
    raise InputError(
        "goals: expected a file with a model's answers to goal interpretation, because tasks in Inspect do "
        "not ask a model for goals; eai run does"
    )


def _make_prompts_stating_model_goals_or_scenes(
    stage: StageThatObtainsGoalsOrScenes, asked_prompts: Mapping[str, Prompt], suite: Suite
) -> tuple[Mapping[str, Prompt], GoalsAndScenesStatedInPrompts]:
    """Return questions that state goals or scenes as a model understood them, and these goals or scenes.

    Raises:
        InputError: the model stated no goals or scene for a task. Inspect cannot count the task as failed,
            because it has no question.
    """
    prompts, beliefs = stage.make_prompts_with_goals_and_scenes(ModelEndpoint(""), asked_prompts, suite)
    missing = len(asked_prompts) - len(prompts)
    if missing:
        raise InputError(
            f"{missing} of {len(asked_prompts)} tasks cannot be asked: {beliefs.missing_reason}; "
            "leave them out with -T tasks=, or use eai run, which counts them as failed"
        )
    return prompts, beliefs


def _select_prompts(
    prompts: Mapping[str, Prompt], tasks: str | int | Sequence[str | int]
) -> Mapping[str, Prompt]:
    """Return the prompts of the named tasks, in the order of the data set.

    Raises:
        InputError: a name is unknown or ambiguous.
    """
    requested_ids = dict[str, None]()
    for name in [tasks] if isinstance(tasks, str | int) else tasks:
        matching_ids = [str(name).strip()]
        if isinstance(name, int):  # Inspect reads arguments as YAML, in which 27_2 is the number 272
            matching_ids = [task_id for task_id in prompts if task_id.replace("_", "") == str(name)]
            if len(matching_ids) != 1:
                raise InputError(f"tasks={name}: expected the id of a task, found a number; use --sample-id")
        requested_ids |= dict.fromkeys(filter(None, matching_ids))
    for task_id in requested_ids.keys() - prompts.keys():
        hint = did_you_mean(task_id, prompts)
        raise InputError(f"tasks: {task_id!r} is not a task of this suite{hint}")
    return {task_id: prompts[task_id] for task_id in prompts if task_id in requested_ids}


SUFFIX = ".eval"
"""Suffix of the file name of a log."""

JOB = "job_sha256"
"""Field of a log's metadata: digest of its job, the questions of a suite for one model."""

InspectLog: TypeAlias = EvalLog
"""A log of Inspect. Modules that must not import Inspect name the type by this alias."""

InspectSample: TypeAlias = EvalSample
"""A sample in a log of Inspect. Modules that must not import Inspect name the type by this alias."""

ANSWER_LIMIT = "answer_limit"
"""Field of a log's metadata: the maximum number of tokens of an answer that the run set by default."""


def find_log(job: QuestionJob, folder: Path) -> Path | None:
    """Return the newest log with all answers to a job (the questions of a suite for one model), or None."""
    if not folder.is_dir():
        return None
    job_sha256 = job.sha256
    # names of logs begin with the time, so the newest comes first
    for path in sorted(folder.glob(f"*{SUFFIX}"), reverse=True):
        try:
            header = read_inspect_log(path, header_only=True)
        except InputError:  # the run was killed, so its log is incomplete
            continue
        results, metadata = header.results, header.eval.metadata or {}
        is_complete = results is not None and results.completed_samples == results.total_samples
        if is_complete and metadata.get(JOB) == job_sha256:
            return path
    return None


def read_answers(path: Path, suite: Suite) -> ResponseFile:
    """Return the answers in a log, one for each task.

    If a task has several answers, the answer with the most frequent meaning is returned. If the ability's
    results are means over epochs, the result has the answers of the first epoch, and those of the other
    epochs in ``further_epochs``. Samples of failed requests have no answer.

    Raises:
        InputError: the log cannot be read, or is of another suite.
    """
    log = read_inspect_log(path)
    metadata = log.eval.metadata or {}
    suite_of_log = f"{metadata.get('domain')} {metadata.get('ability')}"
    if suite_of_log != f"{suite.domain} {suite.ability.value}":
        raise InputError(
            f"{path}: expected a log of {suite.domain} {suite.ability.value}, found {suite_of_log}"
        )
    answered_samples = [sample for sample in log.samples or () if sample.output.choices]
    if not answered_samples:
        raise InputError(f"{path}: no sample of this log has an answer; give another log")
    answered_samples.sort(key=lambda sample: sample.epoch)
    responses = [Response(str(sample.id), read_episode_text(sample)) for sample in answered_samples]
    model = to_file_name(log.eval.model)
    if get_declaration(suite.ability).combine_epochs is not None:
        epochs = group_pairs(zip([sample.epoch for sample in answered_samples], responses, strict=True))
        first, *further = [ResponseFile(model, tuple(answers)) for answers in epochs.values()]
        return replace(first, further_epochs=tuple(further))
    majority_samples = _select_sample_with_majority_answer_per_task(log, suite.ability)
    return ResponseFile(
        model, tuple([Response(str(sample.id), read_episode_text(sample)) for sample in majority_samples])
    )


def make_function_adding_logged_study_results(
    log_path: Path, suite: Suite
) -> Callable[[Record], Record] | None:
    """Return a function that adds the options and results of studies in a log to the record of an answer.

    Studies are variations of the questions. Return None if the log has no options of studies. Return None
    also if all answers to a task are averaged, because the function knows one answer to each task.

    Raises:
        InputError: the log cannot be read.
    """
    log = read_inspect_log(log_path)
    samples = log.samples or ()
    experiment = next((s.metadata[EXPERIMENT] for s in samples if EXPERIMENT in s.metadata), None)
    if experiment is None or get_declaration(suite.ability).combine_epochs is not None:
        return None
    logged_samples: LoggedSamples = {
        str(s.id): (s.metadata, s.epoch, _read_question(s))
        for s in _select_sample_with_majority_answer_per_task(log, suite.ability)
    }
    return partial(add_logged_study_results_to_record, suite, experiment, logged_samples)


def _read_question(sample: EvalSample) -> str:
    return sample.input if isinstance(sample.input, str) else sample.input[-1].text


def _select_sample_with_majority_answer_per_task(log: EvalLog, ability: Ability) -> list[EvalSample]:
    """Return a sample with the most frequent answer to each task. A task is left out if no answer wins."""
    answered = sorted([s for s in log.samples or () if s.output.choices], key=lambda sample: sample.epoch)
    by_task = group_pairs((str(sample.id), sample) for sample in answered)
    epochs = log.eval.config.epochs or 1
    chosen = (
        select_item_with_majority_answer(
            samples, [read_episode_text(sample) for sample in samples], epochs, ability
        )
        for samples in by_task.values()
    )
    return [sample for sample in chosen if sample is not None]


def read_inspect_log(path: Path, *, header_only: bool = False) -> EvalLog:
    """Read a log of Inspect.

    Raises:
        InputError: the log cannot be read.
    """
    require_file(path)
    try:
        return read_eval_log(str(path), header_only=header_only)
    except Exception as error:  # readers of logs raise many kinds of errors if a log is damaged
        raise InputError(f"{path}: expected an Inspect log ({error})") from error


def request_missing_answers(
    job: QuestionJob, journal: Path, log_dir: Path, *, watch: ProgressWatch | None = None
) -> ModelAnswers:
    """Ask a model for the answers that the journal does not have, and return all answers.

    The answers are not scored yet: a suite is scored when it has all answers.

    Args:
        job: the questions and the model.
        journal: file in which answers are stored as they arrive.
        log_dir: folder of Inspect's log.
        watch: called at every answer and failure.

    Raises:
        InputError: a folder cannot be created, or the journal cannot be used.
        UserInterruptError: the user interrupted the run.
        EaiError: the whole run failed: unknown model, or missing or wrong key.
    """
    run = RunState(job, AnswerJournal(journal), watch)
    run.call_progress_callback()
    if is_endpoint_on_server_of_user(job.endpoint) and not run.has_all_answers(job):
        require_server_at_model_address(open_model_at_endpoint(job.endpoint))
    logs: dict[str, Path] = {}
    for part in job.split_into_jobs(sys.maxsize if job.pace.batch else _MAX_LOG_SAMPLES):
        logs |= dict.fromkeys(part.prompts, _find_or_make_log(part, run, log_dir))
    return ModelAnswers(
        job.endpoint.model,
        to_file_name(job.endpoint.model),
        job.prompts,
        run.last_answers,
        run.failures,
        job.epochs,
        job.trials,
        run.attempts,
        logs=logs,
    )


def _find_or_make_log(job: QuestionJob, run: RunState, log_dir: Path) -> Path:
    """Return a log with all answers to a job, after missing answers were requested.

    The job has all tasks of the run, or some.
    """
    log = find_log(job, log_dir) if run.has_all_answers(job) else None
    if log is not None:
        return log
    with raise_write_errors_as_input_errors(log_dir):
        log_dir.mkdir(parents=True, exist_ok=True)
    log_of_run = _evaluate_in_inspect(job, _build_job_task(job, run), log_dir)
    if run.stopped is not None:
        raise run.stopped
    return _require_finished_log(job, log_of_run)


def _choose_max_connections(job: QuestionJob) -> int | None:
    """Return the maximum number of simultaneous requests, or None for Inspect's default."""
    # an interrupt waits for the running request of a built-in model
    return 1 if is_built_in_model(job.endpoint.model) else job.pace.max_connections


def _build_job_task(job: QuestionJob, run: RunState) -> inspect_ai.Task:
    """Return the Inspect task with all questions of a job, so that the log has all answers.

    Questions with an answer in the journal (file of earlier answers) are not sent again.
    """
    ahead = None if job.pace.batch else 2 * (_choose_max_connections(job) or _USUAL_CONNECTIONS)
    return build_task(
        job.suite,
        job.prompts,
        play_missing_episodes(run)
        if get_declaration(job.suite.ability).takes_turns
        else make_solver_that_asks_questions(run),
        metadata={JOB: job.sha256, ANSWER_LIMIT: job.answer_limit},
        experiment=job.experiment,
        question_metadata=job.metadata,
        open_dataset=partial(_SamplesFedToInspect, epochs=job.epochs, ahead=ahead),
    )


def _evaluate_in_inspect(job: QuestionJob, task: inspect_ai.Task, log_dir: Path) -> EvalLog | None:
    """Run Inspect without scoring: some scoring rules need all answers before they choose how to read them.

    The scores are written into the log afterwards (`eai.run.log_scores`). Return None if the run was
    interrupted before it began.
    """
    pace, model = job.pace, open_model_at_endpoint(job.endpoint)
    sampling: dict[str, Any] = {**job.decoding.provider_options}
    logs = inspect_ai.eval(
        task,
        model=model,
        epochs=job.epochs,
        log_dir=str(log_dir),
        display="none",
        fail_on_error=False,
        score=False,
        log_header_only=True,
        log_buffer=min(max(1, len(job.prompts) * job.epochs // 20), _MAX_BUFFERED_SAMPLES),
        temperature=job.decoding.temperature,
        max_tokens=job.decoding.max_tokens,
        **sampling,
        max_connections=_choose_max_connections(job),
        max_retries=pace.max_retries,
        attempt_timeout=pace.timeout,
        batch=pace.batch or None,
    )
    return next(iter(logs), None)


def open_model_at_endpoint(endpoint: ModelEndpoint) -> Model:
    """Return Inspect's model for an endpoint: a model's name, address and arguments.

    Raises:
        EaiError: the model is unknown, or a key or library is missing.
    """
    arguments: dict[str, Any] = dict(endpoint.arguments)
    try:
        model = get_model(endpoint.model, base_url=endpoint.base_url, **arguments)
        return limit_tries_of_refused_connections(remove_unreadable_token_usage_in_replies(model))
    except EaiError:
        raise
    except Exception as error:  # providers raise many kinds of errors
        message = get_message_without_markup(error)
        if message.startswith("Model API ") and message.endswith(" not recognized."):
            message = describe_unknown_provider(endpoint.model)
        elif is_library_or_key_missing(error) and "API_KEY" in message:
            message = f"{message.removesuffix('.')}, nor given as -M api_key=KEY"
        raise EaiError(f"cannot open the model {endpoint.model}: {message}") from error


def _require_finished_log(job: QuestionJob, log: EvalLog | None) -> Path:
    if log is None or log.status == "cancelled":
        raise UserInterruptError("interrupted; the same command resumes from here")
    if log.status == "success":
        return Path(log.location.removeprefix("file://"))
    message = log.error.message.strip().splitlines()[-1] if log.error else log.status
    raise EaiError(
        f"the run of {job.endpoint.model} on {job.suite.domain} {job.suite.ability.value} failed: {message}; "
        "finished answers are kept; the same command resumes from here"
    )
