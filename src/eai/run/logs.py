"""Inspect's logs: the one that holds all answers to a job, the scores in it, and answers from any."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from inspect_ai.log import EvalLog, read_eval_log, recompute_metrics, write_eval_log

from eai.abilities.record import Record
from eai.abilities.responses import Response, ResponseFile, file_name
from eai.benchmark.suite import Suite
from eai.errors import InputError
from eai.run.job import Requests
from eai.run.scorer import score_of
from eai.scoring.majority import majority
from eai.scoring.trials import Place
from eai.tasks.source import Source

SUFFIX = ".eval"
"""How the name of a log ends."""

JOB = "job_sha256"
"""The field of a log's metadata that says which job it is the log of."""


def find_log(job: Requests, folder: Path) -> Path | None:
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
    try:
        write_eval_log(log, str(path))
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror})") from error


def read_answers(path: Path, suite: Suite) -> ResponseFile:
    """The answers in a log; of several to a task the one that says what most of them say.

    A sample whose request failed is no answer.

    Raises:
        InputError: the log cannot be read, or is not of the suite.
    """
    log = _read(path)
    about = log.eval.metadata or {}
    of = f"{about.get('domain')} {about.get('ability')}"
    if of != f"{suite.domain} {suite.ability.value}":
        raise InputError(f"{path}: expected a log of {suite.domain} {suite.ability.value}, found {of}")
    answers: dict[str, list[str]] = {}
    for sample in sorted(log.samples or (), key=lambda sample: sample.epoch):
        if sample.output.choices:
            answers.setdefault(str(sample.id), []).append(sample.output.completion)
    if not answers:
        raise InputError(f"{path}: expected at least one answer, found none")
    chosen = [Response(i, texts[majority(texts, suite.ability)]) for i, texts in answers.items()]
    return ResponseFile(file_name(log.eval.model), tuple(chosen))


def _read(path: Path, *, header_only: bool = False) -> EvalLog:
    try:
        return read_eval_log(str(path), header_only=header_only)
    except Exception as error:  # a file that is no log fails in whatever way its parts do
        raise InputError(f"{path}: expected a log of Inspect's ({error})") from error
