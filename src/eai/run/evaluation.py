"""Running a job through Inspect, which computes the costs of answers from prices of models."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import inspect_ai
import yaml  # type: ignore[import-untyped]
from inspect_ai.log import EvalLog
from inspect_ai.model import Model, ModelCost, ModelInfo, get_model, get_model_info, set_model_info
from pydantic import TypeAdapter, ValidationError
from rich.text import Text

from eai.abilities.options import misfit
from eai.abilities.protocol import DEFAULT_PROTOCOL
from eai.errors import EaiError, InputError, InterruptError
from eai.run.job import Endpoint, Job, Requests
from eai.run.journal import Desk, Journal, Watch, unwatched
from eai.run.logs import JOB, find_log
from eai.run.solver import ask, without_odd_usage
from eai.run.tasks import build_task
from eai.scoring.trials import Answer, Place, Tried


def read_prices(path: Path) -> Mapping[str, ModelCost]:
    """The prices in a file, by model, in dollars for a million tokens.

    Args:
        path: a YAML or JSON file in the form of Inspect's ``--model-cost-config``.

    Raises:
        InputError: the file cannot be read, or has another form.
    """
    try:
        content = yaml.safe_load(path.read_text(encoding="utf-8"))
        return TypeAdapter(dict[str, ModelCost]).validate_python(content)
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from error
    except (UnicodeDecodeError, yaml.YAMLError) as error:
        raise InputError(f"{path}: expected YAML or JSON") from error
    except ValidationError as error:
        raise InputError(f"{path}: expected prices of models ({misfit(error, whole='the file')})") from error


def set_price(model: Model, prices: Mapping[str, ModelCost]) -> None:
    """Tell Inspect the price of a model; one that is not among the prices keeps what Inspect knows.

    Inspect's own ``model_cost_config`` refuses every model that is not in its database, such as those of
    local servers.
    """
    names = (str(model), model.canonical_name())
    cost = next((prices[name] for name in names if name in prices), None)
    if cost is not None:
        known = get_model_info(model) or ModelInfo()
        set_model_info(names[0], known.model_copy(update={"cost": cost}))


@dataclass(frozen=True, slots=True)
class Answers:
    """The outcome of a job.

    Attributes:
        given: the answers by task and epoch; in an experiment the last ones.
        tried: in an experiment all answers and what became of them, by task and epoch.
        failures: for every task and epoch without an answer, why the model or its provider failed.
        log: Inspect's log of all of it, those answers included that were in the journal before.
    """

    given: Mapping[Place, Answer]
    tried: Mapping[Place, Tried]
    failures: Mapping[Place, str]
    log: Path


def obtain_answers(job: Job, journal: Path, log_dir: Path, *, watch: Watch = unwatched) -> Answers:
    """Ask the model for what the journal does not hold yet, as `obtain` does."""
    return obtain(job, partial(_task, job), journal, log_dir, watch=watch)


def obtain(
    job: Requests,
    make_task: Callable[[Desk], inspect_ai.Task],
    journal: Path,
    log_dir: Path,
    *,
    watch: Watch = unwatched,
) -> Answers:
    """Ask a model for what the journal does not hold yet.

    Args:
        job: what to ask whom.
        make_task: the Inspect task that asks for what is on a desk. A suite is scored when all answers
            are there, anything else at once.
        journal: where answers are written down as they arrive.
        log_dir: where Inspect writes its log.
        watch: told of every answer and failure.

    Raises:
        InputError: a folder cannot be made, or the journal cannot be used.
        InterruptError: the user ended it.
        EaiError: the run as a whole failed: no such model, a key is missing or wrong.
    """
    with Journal(journal) as written:
        desk = Desk(job, written, watch)
        desk.tell()
        log = find_log(job, log_dir) if desk.complete else None
        if log is None:
            _make_folder(log_dir)
            evaluated = _evaluate(job, make_task(desk), log_dir)
            if desk.stopped is not None:
                raise desk.stopped
            log = _log_of(job, evaluated)
    return Answers(desk.answers, desk.tried, desk.failures, log)


def _task(job: Job, desk: Desk) -> inspect_ai.Task:
    """All of the job, so that its log is whole; what is answered already is not asked again."""
    return build_task(
        job.benchmark,
        job.ability,
        job.prompts,
        ask(desk),
        DEFAULT_PROTOCOL if job.trials is None else job.trials.suite.protocol,
        source=job.source,
        metadata={JOB: job.sha256},
        experiment=None if job.trials is None else job.trials.experiment,
        about=job.about,
    )


def _make_folder(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be made ({error.strerror})") from error


def _evaluate(job: Requests, task: inspect_ai.Task, log_dir: Path) -> EvalLog | None:
    """Let Inspect ask; scoring waits until all answers are there, whose form decides how each is read.

    The scores come into the log afterwards (`eai.run.logs.write_scores`).

    There is no log where the run was interrupted before it began.
    """
    pace, model = job.pace, find_model(job.endpoint)
    sampling: dict[str, Any] = {**job.decoding.sampling}
    if job.endpoint.prices is not None:
        set_price(model, read_prices(job.endpoint.prices))
    logs = inspect_ai.eval(
        task,
        model=model,
        epochs=job.epochs,
        log_dir=str(log_dir),
        display="none",
        fail_on_error=False,
        score=job.is_scored_at_once,
        temperature=job.decoding.temperature,
        max_tokens=job.decoding.max_tokens,
        **sampling,
        max_connections=1 if job.endpoint.is_built_in else pace.max_connections,  # interrupts come in between
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


def _log_of(job: Requests, log: EvalLog | None) -> Path:
    """Where the log of a run is that came to its end; raises if it did not."""
    if log is None or log.status == "cancelled":
        raise InterruptError("interrupted; the same command resumes from here")
    if log.status == "success":
        return Path(log.location.removeprefix("file://"))
    message = log.error.message.strip().splitlines()[-1] if log.error else log.status
    raise EaiError(f"{job.title}: {message}")
