"""The benchmark as Inspect tasks, for ``eai run`` and for ``inspect eval eai/...`` alike, and Inspect's logs.

Inspect's command line, which is click's, refuses arguments that cannot be used in one line. Of logs there is
the one that holds all answers to a job, with the scores in it; answers are read from any.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

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
from eai.abilities.declaration import declaration_of
from eai.abilities.experiment import Experiment
from eai.abilities.protocol import DEFAULT_PROTOCOL, Ability
from eai.agents.play import in_setting
from eai.agents.setting import AGENT, Setting
from eai.base.errors import EaiError, InputError, InterruptError, did_you_mean
from eai.base.files import convert_write_errors, require_file, to_file_name
from eai.base.grouping import group_pairs
from eai.base.json_value import Json
from eai.benchmarks.gold_answers import open_answer_book
from eai.benchmarks.names import suite_name
from eai.benchmarks.prompt_library import Library
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.suite import Suite, open_suite
from eai.pddl.planning import PlannerChoice
from eai.results.codec import experiment_to_json
from eai.results.epochs import BeliefSet, ModelAnswers, SuiteResult, majority_index
from eai.results.record import Record
from eai.results.responses import Response, ResponseFile
from eai.results.trials import AnswerKey, Trials, open_trials
from eai.run.acting import act, enter, episode_text, player
from eai.run.job import ERRATA, PROVIDER, Job
from eai.run.journal import AnswerJournal, ProgressWatch, RunState
from eai.run.scorer import EXPERIMENT, SCORERS, LoggedSamples, make_logged_record, make_score
from eai.run.solver import ask, ask_as_published, drop_unreadable_usage, messages_of
from eai.run.spec import find_study_of_option, read_spec
from eai.studies.prompts.choice import of_prompts
from eai.studies.variation import Endpoint, Stage
from eai.tasks.prompts.prompt import Prompt
from eai.tasks.source import ErrataChoice, Source


class _RefusalError(InputError, click.ClickException):
    """An argument of a task or a model that cannot be used."""


@contextmanager
def raise_refusals() -> Iterator[None]:
    """Input that cannot be used ends what is in the block as a `_RefusalError`."""
    try:
        yield
    except InputError as error:
        raise _RefusalError(str(error)) from error


def build_task(
    suite: Suite,
    prompts: Mapping[str, Prompt],
    solver: Solver,
    *,
    metadata: Mapping[str, Json] | None = None,
    experiment: Experiment | None = None,
    about: Mapping[str, Mapping[str, str]] | None = None,
) -> inspect_ai.Task:
    """The Inspect task that puts prompts to a model, each with its task's id and gold answer.

    Args:
        suite: what is asked.
        prompts: the questions by id of their task.
        solver: what asks them.
        metadata: what the log says of the task besides its domain and ability.
        experiment: what it is an experiment of, if answers are carried out in one.
        about: what the built-in models are to know of questions besides, by task.
    """
    benchmark, ability, source = suite.benchmark, suite.ability, suite.source
    name = suite_name(benchmark.name, ability)
    book = open_answer_book(benchmark, ability, source)
    gold = {task_id: book[task_id].text for task_id in book if task_id in prompts}
    of_all = {"domain": benchmark.reference, "ability": ability.value, ERRATA: source.errata.value}
    choices = {} if experiment is None else experiment_to_json(experiment)
    of_experiment = {EXPERIMENT: choices} if choices else {}
    samples = []
    for task_id, prompt in prompts.items():
        known = {**of_all, "task_id": task_id, **(about or {}).get(task_id, {})}
        told: dict[str, Json] = {**known, "stop": list(prompt.stop), **of_experiment}
        question = messages_of(prompt, known)
        samples.append(Sample(input=question, target=gold.get(task_id, ""), id=task_id, metadata=told))
    rules = suite.protocol.value, source.planner.value, source.errata.value
    return inspect_ai.Task(
        dataset=MemoryDataset(samples, name=name),
        solver=solver,
        scorer=SCORERS[ability](benchmark.reference, *rules),
        headline_metric=HeadlineMetric(metric=next(iter(declaration_of(ability).overview_headings))),
        name=name,
        metadata={"domain": benchmark.name, "ability": ability.value, **(metadata or {})},
    )


def register_suite_task(reference: str, ability: Ability) -> Callable[..., inspect_ai.Task]:
    """Register a suite as an Inspect task, ``eai/<domain>_<ability>``.

    Without a reference it is ``eai/<ability>``, to which ``-T domain=`` names the benchmark.
    """

    def suite(
        domain: str = reference,
        protocol: str = DEFAULT_PROTOCOL.value,
        prompts: str = "official",
        prompt_folder: str | None = None,
        planner: str = PlannerChoice.AUTO.value,
        errata: str = ErrataChoice.CURRENT.value,
        tasks: str | int | Sequence[str] | None = None,
        **studies: Any,
    ) -> inspect_ai.Task:
        takes_turns = declaration_of(ability).takes_turns
        with raise_refusals():
            spec = read_spec(
                {
                    "prompts": {"set": prompts, "folder": prompt_folder},
                    "scoring": {"protocol": protocol, "planner": planner, "errata": errata},
                    **_of_sections(ability, studies),
                }
            )
            scoring, experiment = spec.scoring, spec.experiment
            source = Source(planner=scoring.planner, errata=scoring.errata)
            suite = open_suite(find_benchmark(domain), ability, scoring.protocol, source=source)
            library = Library(spec.prompts.set, spec.prompts.folder, source)
            questions = library.open(suite.benchmark, ability)
            asked = questions if tasks is None else _only(questions, tasks)
            about: Mapping[str, Mapping[str, str]] = {}
            solver = ask_as_published(None)
            stage = spec.variation.stage(library, {suite.domain: asked}, _ask_nobody)
            if takes_turns:
                asked, about = in_setting(spec.agent, asked, suite)
                experiment, solver = Experiment(), player()
            elif spec.variation.choice:
                spec.variation.abilities([ability])
                believed = None
                if stage is not None:
                    asked, believed = _staged(stage, asked, suite)
                    about = believed.metadata
                trials = make_trials(spec.variation.attempts, library, suite, asked, believed)
                solver = ask_as_published(trials)
                experiment = combine_experiments(
                    [experiment, None if believed is None else believed.experiment]
                )
            if not takes_turns:
                experiment = combine_experiments([experiment, of_prompts(spec.prompts.label)])
        task = build_task(suite, asked, solver, experiment=experiment, about=about)
        task.config = GenerateConfig(temperature=0.0)
        task.score_on_error = True
        task.setup = enter() if takes_turns else None
        return task

    name = suite_name(reference, ability).lstrip("_")
    registered = inspect_ai.task(name=name)(suite)
    if registry_info(registered).name == name:  # Inspect names the package only where it is not editable
        registered = inspect_ai.task(name=f"eai/{name}")(suite)
    return registered


def make_trials(
    options: AttemptOptions | None,
    library: Library,
    suite: Suite,
    asked: Mapping[str, Prompt],
    believed: BeliefSet | None,
) -> Trials | None:
    """Return how answers to questions are carried out; None if each is asked once.

    Raises:
        InputError: answers are no plans.
    """
    if options is None:
        return None
    look, goals = (None, {}) if believed is None else (believed.look, believed.goals)
    asker = library.asker(suite.benchmark, suite.ability, asked, look)
    return open_trials(suite, options, asker, asked, goals)


def combine_experiments(parts: Iterable[Experiment | None]) -> Experiment:
    """Return the experiment that makes all choices of several.

    Raises:
        InputError: two of them choose different values of the same field.
    """
    combined = Experiment()
    for part in parts:
        combined = combined.combine(part or Experiment())
    return combined


def _of_sections(ability: Ability, arguments: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """The options of agents and studies as sections of a specification.

    Raises:
        InputError: there is no such option, or it is of a model that would be asked first.
    """
    tables: dict[str, dict[str, Any]] = {}
    for name, value in arguments.items():
        if declaration_of(ability).takes_turns and name in Setting.model_fields:
            tables.setdefault(AGENT, {})[name] = value
            continue
        if name.startswith("scene_") or (name, value) == ("scene", "predicted"):
            raise InputError(f"{name}: in Inspect no second model lists scenes; eai run asks one")
        tables.setdefault(find_study_of_option(name), {})[name] = value
    return tables


def _ask_nobody(*_: object, **__: object) -> SuiteResult:
    raise InputError("goals: in Inspect those of answers that there are; eai run asks for a model's own")


def _staged(
    stage: Stage, asked: Mapping[str, Prompt], suite: Suite
) -> tuple[Mapping[str, Prompt], BeliefSet]:
    """The same questions stating what came of an earlier stage, and that.

    Raises:
        InputError: there is nothing to state of a task; a log would leave it out of all rates.
    """
    prompts, believed = stage.second(Endpoint(""), asked, suite)
    missing = len(asked) - len(prompts)
    if missing:
        raise InputError(
            f"{missing} of {len(asked)} tasks cannot be asked: {believed.missing_reason}; "
            "leave them out with -T tasks=, or take eai run, which counts them as failed"
        )
    return prompts, believed


def _only(prompts: Mapping[str, Prompt], tasks: str | int | Sequence[str]) -> Mapping[str, Prompt]:
    """The prompts of the named tasks, in the order of the data set.

    Raises:
        InputError: a name is no name of a task, or could be that of several.
    """
    if isinstance(tasks, int):  # Inspect reads arguments as YAML, in which 27_2 is the number 272
        meant = [task_id for task_id in prompts if task_id.replace("_", "") == str(tasks)]
        if len(meant) != 1:
            raise InputError(f"tasks={tasks} is a number and no task; --sample-id takes ids as they are")
        tasks = meant
    named = {task_id.strip() for task_id in ([tasks] if isinstance(tasks, str) else tasks)} - {""}
    for task_id in named - prompts.keys():
        hint = did_you_mean(task_id, prompts)
        raise InputError(f"tasks: {task_id!r} is not a task of this suite{hint}")
    return {task_id: prompts[task_id] for task_id in prompts if task_id in named}


SUFFIX = ".eval"
"""How the name of a log ends."""

JOB = "job_sha256"
"""The field of a log's metadata that says which job it is the log of."""


def find_log(job: Job, folder: Path) -> Path | None:
    """The newest log that holds all answers to a job, or None."""
    if not folder.is_dir():
        return None
    wanted = job.sha256
    for path in sorted(folder.glob(f"*{SUFFIX}"), reverse=True):  # their names begin with the time
        try:
            header = _read(path, header_only=True)
        except InputError:  # what a killed run left
            continue
        results, about = header.results, header.eval.metadata or {}
        whole = results is not None and results.completed_samples == results.total_samples
        if whole and about.get(JOB) == wanted:
            return path
    return None


def write_scores(path: Path, records: Mapping[AnswerKey, Record], source: Source) -> None:
    """Put verdicts into a log, in place of those that it holds.

    Args:
        path: the log.
        records: the record of every answer that was asked for, all under one protocol.
        source: what scored them: which planner judged operators, and whether errata were used.

    Raises:
        InputError: the log cannot be read or written.
    """
    log = _read(path)
    for sample in log.samples or ():
        record = records[str(sample.id), sample.epoch]
        score = make_score(record, sample.epoch, answered=bool(sample.output.choices))
        sample.scores = {record.ability.value: score}
    (protocol,) = {record.protocol.value for record in records.values()}
    rules = {"protocol": protocol, "planner": source.planner.value, "errata": source.errata.value}
    for scorer in log.eval.scorers or ():
        scorer.options = {**(scorer.options or {}), **rules}
    recompute_metrics(log)
    with convert_write_errors(path):
        write_eval_log(log, str(path))


def read_answers(path: Path, suite: Suite) -> ResponseFile:
    """The answers in a log; of several to a task the one that says what most of them say.

    Where tasks count by the mean over epochs, each epoch is a file of its own. A sample whose request failed
    is no answer.

    Raises:
        InputError: the log cannot be read, or is not of the suite.
    """
    log = _read(path)
    about = log.eval.metadata or {}
    of = f"{about.get('domain')} {about.get('ability')}"
    if of != f"{suite.domain} {suite.ability.value}":
        raise InputError(f"{path}: expected a log of {suite.domain} {suite.ability.value}, found {of}")
    answered = [sample for sample in log.samples or () if sample.output.choices]
    if not answered:
        raise InputError(f"{path}: expected at least one answer, found none")
    answered.sort(key=lambda sample: sample.epoch)
    responses = [Response(str(sample.id), episode_text(sample)) for sample in answered]
    model = to_file_name(log.eval.model)
    if declaration_of(suite.ability).combine_epochs is not None:
        epochs = group_pairs(zip([sample.epoch for sample in answered], responses, strict=True))
        first, *further = [ResponseFile(model, tuple(each)) for each in epochs.values()]
        return replace(first, further_epochs=tuple(further))
    by_task = group_pairs((str(sample.id), sample) for sample in answered)
    chosen = [_counted(samples, suite.ability) for samples in by_task.values()]
    return ResponseFile(model, tuple([Response(str(each.id), episode_text(each)) for each in chosen]))


def read_experiment(path: Path, suite: Suite) -> Callable[[Record], Record] | None:
    """Return what makes records of the answers in a log, if it is of an experiment; else None.

    Raises:
        InputError: the log cannot be read.
    """
    samples = _read(path).samples or ()
    written = next((each.metadata[EXPERIMENT] for each in samples if EXPERIMENT in each.metadata), None)
    if written is None or declaration_of(suite.ability).combine_epochs is not None:
        return None
    by_task = group_pairs((str(sample.id), sample) for sample in samples if sample.output.choices)
    chosen = [_counted(sorted(each, key=lambda s: s.epoch), suite.ability) for each in by_task.values()]
    known: LoggedSamples = {str(each.id): (each.metadata, each.epoch, _question_of(each)) for each in chosen}
    return partial(make_logged_record, suite, written, known)


def _question_of(sample: EvalSample) -> str:
    return sample.input if isinstance(sample.input, str) else sample.input[-1].text


def _counted(samples: Sequence[EvalSample], ability: Ability) -> EvalSample:
    """Of the samples of one task the one whose answer says what most of them say."""
    return samples[majority_index([episode_text(sample) for sample in samples], ability)]


def _read(path: Path, *, header_only: bool = False) -> EvalLog:
    require_file(path)
    try:
        return read_eval_log(str(path), header_only=header_only)
    except Exception as error:  # a file that is no log fails in whatever way its parts do
        raise InputError(f"{path}: expected a log of Inspect's ({error})") from error


def obtain_answers(
    job: Job, journal: Path, log_dir: Path, *, watch: ProgressWatch | None = None
) -> ModelAnswers:
    """Ask a model for what the journal does not hold yet.

    A suite is scored when all answers are there.

    Args:
        job: what to ask whom.
        journal: where answers are written down as they arrive.
        log_dir: where Inspect writes its log.
        watch: is called at every answer and failure.

    Raises:
        InputError: a folder cannot be made, or the journal cannot be used.
        InterruptError: the user ended it.
        EaiError: the run as a whole failed: no such model, a key is missing or wrong.
    """
    desk = RunState(job, AnswerJournal(journal), watch)
    desk.report()
    log = find_log(job, log_dir) if desk.is_complete else None
    if log is None:
        with convert_write_errors(log_dir):
            log_dir.mkdir(parents=True, exist_ok=True)
        evaluated = _evaluate(job, _task(job, desk), log_dir)
        if desk.stopped is not None:
            raise desk.stopped
        log = _log_of(job, evaluated)
    return ModelAnswers(
        job.endpoint.model,
        to_file_name(job.endpoint.model),
        job.prompts,
        desk.last_answers,
        desk.failures,
        job.epochs,
        job.trials,
        desk.attempts,
        log=log,
    )


def _task(job: Job, desk: RunState) -> inspect_ai.Task:
    """All of the job, so that its log is whole; what is answered already is not asked again."""
    return build_task(
        job.suite,
        job.prompts,
        act(desk) if declaration_of(job.suite.ability).takes_turns else ask(desk),
        metadata={JOB: job.sha256},
        experiment=job.experiment,
        about=job.metadata,
    )


def _evaluate(job: Job, task: inspect_ai.Task, log_dir: Path) -> EvalLog | None:
    """Let Inspect ask; scoring waits until all answers are there, whose form decides how each is read.

    The scores come into the log afterwards (`eai.run.tasks.write_scores`).

    There is no log where the run was interrupted before it began.
    """
    pace, model = job.pace, find_model(job.endpoint)
    sampling: dict[str, Any] = {**job.decoding.sampling}
    is_built_in = job.endpoint.model.startswith(f"{PROVIDER}/")
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
        max_connections=1 if is_built_in else pace.max_connections,  # interrupts come in between
        max_retries=pace.max_retries,
        attempt_timeout=pace.timeout,
        batch=pace.batch or None,
    )
    return next(iter(logs), None)


def find_model(endpoint: Endpoint) -> Model:
    """The model at an endpoint.

    Raises:
        EaiError: there is none, or what it needs is missing.
    """
    arguments: dict[str, Any] = dict(endpoint.arguments)
    try:
        return drop_unreadable_usage(get_model(endpoint.model, base_url=endpoint.base_url, **arguments))
    except EaiError:
        raise
    except Exception as error:  # providers raise what they like when a key, a library or a name is missing
        message = " ".join(Text.from_markup(str(getattr(error, "message", error))).plain.split())
        raise EaiError(f"{endpoint.model}: {message}") from error


def _log_of(job: Job, log: EvalLog | None) -> Path:
    """Where the log of a run is that came to its end; raises if it did not."""
    if log is None or log.status == "cancelled":
        raise InterruptError("interrupted; the same command resumes from here")
    if log.status == "success":
        return Path(log.location.removeprefix("file://"))
    message = log.error.message.strip().splitlines()[-1] if log.error else log.status
    raise EaiError(f"{job.endpoint.model} on {job.suite.domain} {job.suite.ability.value}: {message}")
