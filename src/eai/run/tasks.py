"""Inspect tasks of the suites, for ``eai run`` and for ``inspect eval eai/...``; reads Inspect's logs.

Inspect's command line uses click, which shows a refused argument as one line. One log holds all answers to a
job, with their scores; answers can be read from any log.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, TypeAlias

import click
import inspect_ai
from inspect_ai.dataset import MemoryDataset, Sample
from inspect_ai.log import (
    EvalLog,
    EvalSample,
    HeadlineMetric,
    read_eval_log,
    recompute_metrics,
    write_eval_log,
)
from inspect_ai.model import GenerateConfig, Model, get_model
from inspect_ai.solver import Solver
from inspect_ai.util import registry_info
from rich.text import Text

from eai.abilities.attempt_options import AttemptOptions
from eai.abilities.declaration import get_declaration
from eai.abilities.experiment import Experiment
from eai.abilities.protocol import DEFAULT_PROTOCOL, Ability
from eai.agents.play import make_prompts_and_metadata
from eai.agents.setting import AGENT, AgentSetting
from eai.base.errors import EaiError, InputError, InterruptError, did_you_mean
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
from eai.results.epochs import ModelAnswers, PromptBeliefs, SuiteResult, find_majority_index
from eai.results.record import Record
from eai.results.responses import Response, ResponseFile
from eai.results.trials import AnswerKey, TrialSet, open_trials
from eai.run.acting import offer_task_tools, play_missing_episodes, player, read_episode_text
from eai.run.context import calls_server, require_server
from eai.run.job import ERRATA, QuestionJob, is_built_in
from eai.run.journal import AnswerJournal, ProgressWatch, RunState
from eai.run.request_errors import limit_tries_of_refused_connections
from eai.run.scorer import EXPERIMENT, SCORERS, LoggedSamples, make_record_of_logged_answer, make_score
from eai.run.solver import (
    ask_unanswered_questions,
    ask_without_journal,
    drop_unreadable_token_usage,
    make_messages,
)
from eai.run.spec import find_study_of_option, read_spec
from eai.studies.prompts.choice import make_prompt_name_experiment
from eai.studies.variation import Endpoint, StageBeforeQuestions
from eai.tasks.prompts.prompt import Prompt
from eai.tasks.source import ErrataChoice, Source


class _TaskArgumentError(InputError, click.ClickException):
    """Error for an argument of a task or a model that cannot be used."""


@contextmanager
def convert_input_errors() -> Iterator[None]:
    """Turn an InputError of the block into a `_TaskArgumentError`, which click shows as one line."""
    try:
        yield
    except InputError as error:
        raise _TaskArgumentError(str(error)) from error


def build_task(
    suite: Suite,
    prompts: Mapping[str, Prompt],
    solver: Solver,
    *,
    metadata: Mapping[str, Json] | None = None,
    experiment: Experiment | None = None,
    question_metadata: Mapping[str, Mapping[str, str]] | None = None,
) -> inspect_ai.Task:
    """Return the Inspect task that asks a model these prompts, each with its task's id and gold answer.

    Args:
        suite: the suite.
        prompts: mapping from task ids to questions.
        solver: the solver that asks them.
        metadata: metadata of the log, besides domain and ability.
        experiment: the experiment of the run, if any.
        question_metadata: mapping from task ids to the metadata of questions, for the built-in models.
    """
    benchmark, ability, source = suite.benchmark, suite.ability, suite.source
    name = suite_name(benchmark.name, ability)
    book = open_gold_answers(benchmark, ability, source)
    gold = {task_id: book[task_id].text for task_id in book if task_id in prompts}
    common_metadata = {"domain": benchmark.reference, "ability": ability.value, ERRATA: source.errata.value}
    choices = {} if experiment is None else experiment_to_json(experiment)
    experiment_metadata = {EXPERIMENT: choices} if choices else {}
    samples = []
    for task_id, prompt in prompts.items():
        metadata_of_question = {
            **common_metadata,
            "task_id": task_id,
            **(question_metadata or {}).get(task_id, {}),
        }
        metadata_of_sample: dict[str, Json] = {
            **metadata_of_question,
            "stop": list(prompt.stop),
            **experiment_metadata,
        }
        question = make_messages(prompt, metadata_of_question)
        samples.append(
            Sample(input=question, target=gold.get(task_id, ""), id=task_id, metadata=metadata_of_sample)
        )
    rules = suite.protocol.value, source.planner.value, source.errata.value
    return inspect_ai.Task(
        dataset=MemoryDataset(samples, name=name),
        solver=solver,
        scorer=SCORERS[ability](benchmark.reference, *rules),
        headline_metric=HeadlineMetric(metric=next(iter(get_declaration(ability).overview_headings))),
        name=name,
        metadata={"domain": benchmark.name, "ability": ability.value, **(metadata or {})},
    )


def register_suite_task(reference: str, ability: Ability) -> Callable[..., inspect_ai.Task]:
    """Register a suite as an Inspect task, ``eai/<domain>_<ability>``.

    Without a reference the name is ``eai/<ability>``, and ``-T domain=`` names the benchmark.
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
        with convert_input_errors():
            spec = read_spec(
                {
                    "prompts": {"set": prompts, "folder": prompt_folder},
                    "scoring": {"protocol": protocol, "planner": planner, "errata": errata},
                    **_sort_arguments_into_sections(ability, studies),
                }
            )
            scoring, experiment = spec.scoring, spec.experiment
            source = Source(planner=scoring.planner, errata=scoring.errata)
            suite = open_suite(find_benchmark(domain), ability, scoring.protocol, source=source)
            library = PromptLibrary(spec.prompts.set, spec.prompts.folder, source)
            questions = library.open(suite.benchmark, ability)
            asked = questions if tasks is None else _select_prompts(questions, tasks)
            about: Mapping[str, Mapping[str, str]] = {}
            solver = ask_without_journal(None)
            stage = spec.variation.make_stage_before_questions(
                library, {suite.domain: asked}, _raise_instead_of_asking_model
            )
            if takes_turns:
                asked, about = make_prompts_and_metadata(spec.setting, asked, suite)
                experiment, solver = Experiment(), player()
            elif spec.variation.chosen_option:
                spec.variation.select_abilities([ability])
                beliefs = None
                if stage is not None:
                    asked, beliefs = _run_goal_or_scene_stage(stage, asked, suite)
                    about = beliefs.metadata
                trials = make_trials(spec.variation.attempts, library, suite, asked, beliefs)
                solver = ask_without_journal(trials)
                experiment = combine_experiments(
                    [experiment, None if beliefs is None else beliefs.experiment]
                )
            if not takes_turns:
                experiment = combine_experiments(
                    [experiment, make_prompt_name_experiment(spec.prompts.prompt_label)]
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


def make_trials(
    options: AttemptOptions | None,
    library: PromptLibrary,
    suite: Suite,
    prompts: Mapping[str, Prompt],
    beliefs: PromptBeliefs | None,
) -> TrialSet | None:
    """Return the trials that execute answers and ask again; None if each question is sent once.

    Raises:
        InputError: the answers of the suite are not plans.
    """
    if options is None:
        return None
    look, goals = (None, {}) if beliefs is None else (beliefs.look, beliefs.tasks_with_stated_goals)
    asker = library.make_question_writer(suite.benchmark, suite.ability, prompts, look)
    return open_trials(suite, options, asker, prompts, goals)


def combine_experiments(parts: Iterable[Experiment | None]) -> Experiment:
    """Combine experiments into one with all of their choices.

    Raises:
        InputError: two experiments choose different values of the same field.
    """
    combined = Experiment()
    for experiment in parts:
        combined = combined.combine(experiment or Experiment())
    return combined


def _sort_arguments_into_sections(
    ability: Ability, arguments: Mapping[str, Any]
) -> dict[str, dict[str, Any]]:
    """Return the options of agents and studies, as a mapping by section of a specification.

    Raises:
        InputError: an option is unknown, or needs a second model, which Inspect's tasks cannot ask.
    """
    tables: dict[str, dict[str, Any]] = {}
    for name, value in arguments.items():
        if get_declaration(ability).takes_turns and name in AgentSetting.model_fields:
            tables.setdefault(AGENT, {})[name] = value
            continue
        if name.startswith("scene_") or (name, value) == ("scene", "predicted"):
            raise InputError(f"{name}: Inspect tasks have no second model for scenes; use eai run")
        tables.setdefault(find_study_of_option(name), {})[name] = value
    return tables


def _raise_instead_of_asking_model(*_: object, **__: object) -> SuiteResult:
    raise InputError(
        "goals: in Inspect, give answers from a file; only eai run asks the model for its own goals"
    )


def _run_goal_or_scene_stage(
    stage: StageBeforeQuestions, asked_prompts: Mapping[str, Prompt], suite: Suite
) -> tuple[Mapping[str, Prompt], PromptBeliefs]:
    """Return questions that state results of an earlier stage (goals or scenes), and these results.

    Raises:
        InputError: a task has no result to state; a log would leave it out of all rates.
    """
    prompts, beliefs = stage.make_prompts(Endpoint(""), asked_prompts, suite)
    missing = len(asked_prompts) - len(prompts)
    if missing:
        raise InputError(
            f"{missing} of {len(asked_prompts)} tasks cannot be asked: {beliefs.missing_reason}; "
            "leave them out with -T tasks=, or use eai run, which counts them as failed"
        )
    return prompts, beliefs


def _select_prompts(prompts: Mapping[str, Prompt], tasks: str | int | Sequence[str]) -> Mapping[str, Prompt]:
    """Return the prompts of the named tasks, in the order of the data set.

    Raises:
        InputError: a name is unknown or ambiguous.
    """
    if isinstance(tasks, int):  # Inspect reads arguments as YAML, in which 27_2 is the number 272
        matching_ids = [task_id for task_id in prompts if task_id.replace("_", "") == str(tasks)]
        if len(matching_ids) != 1:
            raise InputError(f"tasks={tasks} is a number, not a task; give the id with --sample-id")
        tasks = matching_ids
    requested_ids = {task_id.strip() for task_id in ([tasks] if isinstance(tasks, str) else tasks)} - {""}
    for task_id in requested_ids - prompts.keys():
        hint = did_you_mean(task_id, prompts)
        raise InputError(f"tasks: {task_id!r} is not a task of this suite{hint}")
    return {task_id: prompts[task_id] for task_id in prompts if task_id in requested_ids}


SUFFIX = ".eval"
"""Suffix of the file name of a log."""

JOB = "job_sha256"
"""Field of a log's metadata: digest of its job."""

InspectLog: TypeAlias = EvalLog
"""A log of Inspect, for modules that must not import Inspect."""

InspectSample: TypeAlias = EvalSample
"""A sample in a log of Inspect, for modules that must not import Inspect."""

ANSWER_LIMIT = "answer_limit"
"""Field of a log's metadata: default of the maximum number of tokens of an answer."""


def find_log(job: QuestionJob, folder: Path) -> Path | None:
    """Return the newest log with all answers to a job, or None."""
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


def write_scores(path: Path, records: Mapping[AnswerKey, Record], source: Source) -> None:
    """Write verdicts as scores into a log. They replace the scores that the log has.

    Args:
        path: the log.
        records: the record of every requested answer, all under one protocol.
        source: the planner that judged operators, and the use of errata.

    Raises:
        InputError: the log cannot be read or written.
    """
    log = read_inspect_log(path)
    for sample in log.samples or ():
        record = records[str(sample.id), sample.epoch]
        score = make_score(record, sample.epoch, answered=bool(sample.output.choices))
        sample.scores = {record.ability.value: score}
    (protocol,) = {record.protocol.value for record in records.values()}
    rules = {"protocol": protocol, "planner": source.planner.value, "errata": source.errata.value}
    for scorer in log.eval.scorers or ():
        scorer.options = {**(scorer.options or {}), **rules}
    recompute_metrics(log)
    with raise_write_errors_as_input_errors(path):
        write_eval_log(log, str(path))


def read_answers(path: Path, suite: Suite) -> ResponseFile:
    """Return the answers in a log.

    For several answers to a task, the answer with the most frequent meaning counts. If tasks count by the
    mean over epochs, each epoch becomes a response file. Samples of failed requests have no answer.

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
        raise InputError(f"{path}: expected at least one answer, found none")
    answered_samples.sort(key=lambda sample: sample.epoch)
    responses = [Response(str(sample.id), read_episode_text(sample)) for sample in answered_samples]
    model = to_file_name(log.eval.model)
    if get_declaration(suite.ability).combine_epochs is not None:
        epochs = group_pairs(zip([sample.epoch for sample in answered_samples], responses, strict=True))
        first, *further = [ResponseFile(model, tuple(answers)) for answers in epochs.values()]
        return replace(first, further_epochs=tuple(further))
    by_task = group_pairs((str(sample.id), sample) for sample in answered_samples)
    majority_samples = [_select_majority_sample(samples, suite.ability) for samples in by_task.values()]
    return ResponseFile(
        model, tuple([Response(str(sample.id), read_episode_text(sample)) for sample in majority_samples])
    )


def make_experiment_adder(path: Path, suite: Suite) -> Callable[[Record], Record] | None:
    """Return a function that adds a log's experiment to records of its answers; None without an experiment.

    Raises:
        InputError: the log cannot be read.
    """
    samples = read_inspect_log(path).samples or ()
    experiment = next((s.metadata[EXPERIMENT] for s in samples if EXPERIMENT in s.metadata), None)
    if experiment is None or get_declaration(suite.ability).combine_epochs is not None:
        return None
    by_task = group_pairs((str(sample.id), sample) for sample in samples if sample.output.choices)
    majority_samples = [
        _select_majority_sample(sorted(of_task, key=lambda s: s.epoch), suite.ability)
        for of_task in by_task.values()
    ]
    logged_samples: LoggedSamples = {
        str(s.id): (s.metadata, s.epoch, _read_question(s)) for s in majority_samples
    }
    return partial(make_record_of_logged_answer, suite, experiment, logged_samples)


def _read_question(sample: EvalSample) -> str:
    return sample.input if isinstance(sample.input, str) else sample.input[-1].text


def _select_majority_sample(samples: Sequence[EvalSample], ability: Ability) -> EvalSample:
    return samples[find_majority_index([read_episode_text(sample) for sample in samples], ability)]


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

    A suite is scored when all answers are there.

    Args:
        job: the questions and the model.
        journal: file in which answers are stored as they arrive.
        log_dir: folder of Inspect's log.
        watch: called at every answer and failure.

    Raises:
        InputError: a folder cannot be created, or the journal cannot be used.
        InterruptError: the user interrupted the run.
        EaiError: the whole run failed: unknown model, or missing or wrong key.
    """
    run = RunState(job, AnswerJournal(journal), watch)
    run.report_progress()
    log = find_log(job, log_dir) if run.is_complete else None
    if log is None:
        if calls_server(job.endpoint) and not run.is_complete:
            require_server(find_model(job.endpoint))
        with raise_write_errors_as_input_errors(log_dir):
            log_dir.mkdir(parents=True, exist_ok=True)
        log_of_run = _evaluate_in_inspect(job, _build_job_task(job, run), log_dir)
        if run.stopped is not None:
            raise run.stopped
        log = _require_finished_log(job, log_of_run)
    return ModelAnswers(
        job.endpoint.model,
        to_file_name(job.endpoint.model),
        job.prompts,
        run.last_answers,
        run.failures,
        job.epochs,
        job.trials,
        run.attempts,
        log=log,
    )


def _build_job_task(job: QuestionJob, run: RunState) -> inspect_ai.Task:
    """Return the Inspect task of the whole job, so that its log is complete.

    Questions with an answer in the journal are not sent again.
    """
    return build_task(
        job.suite,
        job.prompts,
        play_missing_episodes(run)
        if get_declaration(job.suite.ability).takes_turns
        else ask_unanswered_questions(run),
        metadata={JOB: job.sha256, ANSWER_LIMIT: job.answer_limit},
        experiment=job.experiment,
        question_metadata=job.metadata,
    )


def _evaluate_in_inspect(job: QuestionJob, task: inspect_ai.Task, log_dir: Path) -> EvalLog | None:
    """Run Inspect without scoring, because some protocols choose one way to read all answers of a model.

    The scores are written into the log afterwards (`eai.run.tasks.write_scores`). Return None if the run was
    interrupted before it began.
    """
    pace, model = job.pace, find_model(job.endpoint)
    sampling: dict[str, Any] = {**job.decoding.provider_options}
    logs = inspect_ai.eval(
        task,
        model=model,
        epochs=job.epochs,
        log_dir=str(log_dir),
        display="none",
        fail_on_error=False,
        score=False,
        temperature=job.decoding.temperature,
        max_tokens=job.decoding.max_tokens,
        **sampling,
        # an interrupt waits for the running request of a built-in model
        max_connections=1 if is_built_in(job.endpoint.model) else pace.max_connections,
        max_retries=pace.max_retries,
        attempt_timeout=pace.timeout,
        batch=pace.batch or None,
    )
    return next(iter(logs), None)


def find_model(endpoint: Endpoint) -> Model:
    """Return Inspect's model for an endpoint: a model's name, address and arguments.

    Raises:
        EaiError: the model is unknown, or a key or library is missing.
    """
    arguments: dict[str, Any] = dict(endpoint.arguments)
    try:
        model = get_model(endpoint.model, base_url=endpoint.base_url, **arguments)
        return limit_tries_of_refused_connections(drop_unreadable_token_usage(model))
    except EaiError:
        raise
    except Exception as error:  # providers raise many kinds of errors
        message = " ".join(Text.from_markup(str(getattr(error, "message", error))).plain.split())
        raise EaiError(f"{endpoint.model}: {message}") from error


def _require_finished_log(job: QuestionJob, log: EvalLog | None) -> Path:
    if log is None or log.status == "cancelled":
        raise InterruptError("interrupted; the same command resumes from here")
    if log.status == "success":
        return Path(log.location.removeprefix("file://"))
    message = log.error.message.strip().splitlines()[-1] if log.error else log.status
    raise EaiError(f"{job.endpoint.model} on {job.suite.domain} {job.suite.ability.value}: {message}")
