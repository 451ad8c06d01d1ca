"""Inspect's logs: the one that holds all answers to a job, the scores in it, and answers from any."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import inspect_ai
from inspect_ai.log import EvalLog, read_eval_log, recompute_metrics, write_eval_log
from inspect_ai.model import Model, get_model
from rich.text import Text

from eai.abilities.declaration import declaration_of
from eai.abilities.record import Record
from eai.abilities.responses import Response, ResponseFile, file_name
from eai.acting.setting import ACTING
from eai.benchmark.suite import Suite
from eai.data.files import writing_to
from eai.data.grouping import grouped
from eai.errors import EaiError, InputError, InterruptError
from eai.run.acting import act, episode_text
from eai.run.job import PROVIDER, Job
from eai.run.journal import Desk, Journal, Watch
from eai.run.scorer import score_of
from eai.run.solver import ask, without_odd_usage
from eai.run.tasks import build_task
from eai.scoring.epochs import Obtained, majority
from eai.scoring.trials import Place
from eai.studies.variation import Endpoint
from eai.tasks.source import Source

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


def write_scores(path: Path, records: Mapping[Place, Record], source: Source) -> None:
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
        score = score_of(record, sample.epoch, answered=bool(sample.output.choices))
        sample.scores = {record.ability.value: score}
    (protocol,) = {record.protocol.value for record in records.values()}
    rules = {"protocol": protocol, "planner": source.planner.value, "errata": source.errata.value}
    for scorer in log.eval.scorers or ():
        scorer.options = {**(scorer.options or {}), **rules}
    recompute_metrics(log)
    with writing_to(path):
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
    model = file_name(log.eval.model)
    if declaration_of(suite.ability).of_epochs is not None:
        epochs = grouped(zip([sample.epoch for sample in answered], responses, strict=True))
        first, *further = [ResponseFile(model, tuple(each)) for each in epochs.values()]
        return replace(first, further=tuple(further))
    answers = grouped((response.task_id, response.text) for response in responses)
    chosen = [Response(i, texts[majority(texts, suite.ability)]) for i, texts in answers.items()]
    return ResponseFile(model, tuple(chosen))


def _read(path: Path, *, header_only: bool = False) -> EvalLog:
    try:
        return read_eval_log(str(path), header_only=header_only)
    except Exception as error:  # a file that is no log fails in whatever way its parts do
        raise InputError(f"{path}: expected a log of Inspect's ({error})") from error


def obtain_answers(job: Job, journal: Path, log_dir: Path, *, watch: Watch | None = None) -> Obtained:
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
    desk = Desk(job, Journal(journal), watch)
    desk.report()
    log = find_log(job, log_dir) if desk.complete else None
    if log is None:
        with writing_to(log_dir):
            log_dir.mkdir(parents=True, exist_ok=True)
        evaluated = _evaluate(job, _task(job, desk), log_dir)
        if desk.stopped is not None:
            raise desk.stopped
        log = _log_of(job, evaluated)
    return Obtained(
        job.endpoint.model,
        file_name(job.endpoint.model),
        job.prompts,
        desk.answers,
        desk.failures,
        job.epochs,
        job.trials,
        desk.tried,
        log=log,
    )


def _task(job: Job, desk: Desk) -> inspect_ai.Task:
    """All of the job, so that its log is whole; what is answered already is not asked again."""
    return build_task(
        job.suite,
        job.prompts,
        act(desk) if job.suite.ability is ACTING else ask(desk),
        metadata={JOB: job.sha256},
        experiment=None if job.trials is None else job.trials.experiment,
        about=job.about,
    )


def _evaluate(job: Job, task: inspect_ai.Task, log_dir: Path) -> EvalLog | None:
    """Let Inspect ask; scoring waits until all answers are there, whose form decides how each is read.

    The scores come into the log afterwards (`eai.run.evaluation.write_scores`).

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
        return without_odd_usage(get_model(endpoint.model, base_url=endpoint.base_url, **arguments))
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
