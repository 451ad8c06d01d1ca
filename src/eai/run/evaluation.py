"""Running models on suites through Inspect, and turning its logs into answers."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import inspect_ai
from inspect_ai.log import EvalLog, EvalSample

from eai.abilities.protocol import Ability, Domain, Protocol
from eai.abilities.responses import Response, ResponseFile
from eai.errors import EaiError
from eai.run.tasks import build_task


@dataclass(frozen=True, slots=True)
class Job:
    """What is to be run.

    Attributes:
        model: an Inspect model name, built-in ones included (``eai/oracle``).
        limit: at most so many tasks, from the first on; None for all.
        task_ids: only these tasks; empty for all.
        model_args: arguments of the model's provider.
        model_base_url: where an OpenAI-compatible server listens.
    """

    model: str
    domain: Domain
    ability: Ability
    protocol: Protocol
    limit: int | None = None
    task_ids: tuple[str, ...] = ()
    model_args: Mapping[str, str] | None = None
    model_base_url: str | None = None


@dataclass(frozen=True, slots=True)
class Answers:
    """What came of a job.

    Attributes:
        file: the answers that were given, in the order of the data set.
        unanswered: for every task without an answer, why the model or its provider failed.
        log: where Inspect wrote its log.
    """

    file: ResponseFile
    unanswered: Mapping[str, str]
    log: Path


def obtain_answers(job: Job, log_dir: Path, *, display: str) -> Answers:
    """Ask the model.

    Args:
        job: what to ask whom.
        log_dir: where Inspect writes its log.
        display: Inspect's ``display``: ``full``, ``rich``, ``plain`` or ``none``.

    Raises:
        EaiError: the run as a whole failed: no such model, a key is missing, it was interrupted.
    """
    (log,) = inspect_ai.eval(
        build_task(job.domain, job.ability, job.protocol),
        model=job.model,
        model_args=dict(job.model_args or {}),
        model_base_url=job.model_base_url,
        limit=job.limit,
        sample_id=list(job.task_ids) or None,
        log_dir=str(log_dir),
        display=display,  # type: ignore[arg-type]
        fail_on_error=False,
        score_display=False,
    )
    if log.status != "success":
        message = log.error.message.strip().splitlines()[-1] if log.error else "it was interrupted"
        raise EaiError(f"{job.model} on {job.domain.value} {job.ability.value}: {log.status}: {message}")
    return _answers(job.model, log)


def slug(model: str) -> str:
    """A model's name as part of a file name."""
    return re.sub(r"[^\w.-]+", "_", model)


def _answers(model: str, log: EvalLog) -> Answers:
    samples: Sequence[EvalSample] = log.samples or []
    failed = {str(s.id): s.error.message for s in samples if s.error is not None}
    given = tuple(Response(str(s.id), s.output.completion) for s in samples if s.error is None)
    return Answers(ResponseFile(slug(model), given), failed, Path(log.location))
