"""Runs Inspect in a process of its own, which imports this module by name; its warnings stay there."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple
from unittest.mock import patch

import inspect_ai
from inspect_ai.log import EvalLog, read_eval_log, write_eval_log
from inspect_ai.model import Model, ModelOutput, ModelUsage, get_model

from eai.abilities.protocol import Ability, Protocol
from eai.base.json_value import Json
from eai.benchmarks.suite import Suite, open_suite
from eai.pddl.planning import PlannerChoice
from eai.results.epochs import ModelAnswers, score_answers
from eai.results.options import ScoringOptions
from eai.results.rate import Rate
from eai.results.record import Record
from eai.results.records import RECORDS, read_records
from eai.run.job import QuestionJob
from eai.run.log_scores import write_scores
from eai.run.registry import TASKS
from eai.run.scorer import SCORERS
from eai.run.tasks import request_missing_answers
from eai.studies.variation import ModelEndpoint
from eai.tasks.source import ErrataChoice, Source
from suites import official_prompts

PLANNER = PlannerChoice.BUILT_IN


class Asked(NamedTuple):
    """Tasks of a suite."""

    domain: str
    ability: Ability
    protocol: Protocol
    task_ids: Sequence[str]
    errata: ErrataChoice = ErrataChoice.CURRENT

    def suite(self) -> Suite:
        source = Source(planner=PLANNER, errata=self.errata)
        return open_suite(self.domain, self.ability, self.protocol, source=source)


class Whom(NamedTuple):
    """A model, and the number of answers to each task."""

    model: str
    arguments: Mapping[str, Json]
    epochs: int = 1


@dataclass(frozen=True)
class Ran:
    """The records and the log of a run."""

    rates: Mapping[str, Rate]
    records: Sequence[Record]
    of_epochs: Sequence[Mapping[str, Rate]]
    log: Path


def obtain_in_child(job: QuestionJob, journal: Path, logs: Path) -> ModelAnswers:
    """Get the answers to a job."""
    return request_missing_answers(job, journal, logs)


def obtain_with_logs_of(max_samples: int, job: QuestionJob, journal: Path, logs: Path) -> ModelAnswers:
    """Get the answers to a job. Each log has at most a number of samples."""
    with patch("eai.run.tasks._MAX_LOG_SAMPLES", max_samples):
        return request_missing_answers(job, journal, logs)


def run_in_child(asked: Asked, whom: Whom, folder: Path) -> Ran:
    """Run ``eai run``."""
    suite, model = asked.suite(), whom.model
    prompts = official_prompts(suite.domain, suite.ability)
    prompts = {task_id: prompts[task_id] for task_id in asked.task_ids}
    endpoint = ModelEndpoint(model, whom.arguments)
    job = QuestionJob(endpoint, suite, prompts, whom.epochs)
    answers = request_missing_answers(job, folder / "answers.jsonl", folder / "logs")
    result = score_answers(answers, folder, suite, ScoringOptions())
    write_scores(answers.logs, result)
    records = list(read_records(result.folder / RECORDS))
    (log,) = set(answers.logs.values())
    return Ran(result.totals.rates, records, [one.totals.rates for one in result.by_epoch], log)


def evaluate_in_child(asked: Asked, whom: Whom, folder: Path) -> Path:
    """Run ``inspect eval`` and return the path of its log."""
    return _evaluate(asked, get_model(whom.model, **whom.arguments), folder, whom.epochs)


def evaluate_experiment_in_child(asked: Asked, whom: Whom, folder: Path, choices: Mapping[str, Json]) -> Path:
    """Run ``inspect eval`` in an experiment, whose options are arguments of the task."""
    return _evaluate(asked, get_model(whom.model, **whom.arguments), folder, whom.epochs, choices)


def evaluate_answers_in_child(asked: Asked, answers: Sequence[str | None], folder: Path) -> Path:
    """Run ``inspect eval`` with a model whose request fails if there is no answer."""

    def outputs() -> Iterator[ModelOutput]:
        for text in answers:
            output = ModelOutput(model="mockllm/model", error="out of order")
            if text is not None:
                output = ModelOutput.from_content("mockllm/model", text)
            output.usage = ModelUsage()  # Inspect would count by itself, for which it downloads a tokenizer
            yield output

    return _evaluate(asked, get_model("mockllm/model", custom_outputs=outputs()), folder, 1)


def score_in_child(path: Path, asked: Asked) -> Path:
    """Run ``inspect score`` and return the path of the scored log."""
    scorer = SCORERS[asked.ability](asked.domain, asked.protocol.value, PLANNER.value)
    log = inspect_ai.score(read_eval_log(path), scorer, action="overwrite", display="none")
    return _write(log, path.with_name("scored.eval"))


def _evaluate(
    asked: Asked,
    model: Model,
    folder: Path,
    epochs: int,
    choices: Mapping[str, Json] | None = None,
) -> Path:
    task = TASKS[f"{asked.domain}_{asked.ability.value}"](
        protocol=asked.protocol.value, planner=PLANNER.value, tasks=asked.task_ids, **(choices or {})
    )
    (log,) = inspect_ai.eval(
        task,
        model=model,
        epochs=epochs,
        log_dir=str(folder),
        display="none",
        fail_on_error=False,
    )
    return _write(log, folder / "evaluated.eval")


def _write(log: EvalLog, path: Path) -> Path:
    write_eval_log(log, str(path))
    return path
