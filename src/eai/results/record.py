"""Records: one scored answer with its task, its run and its origin."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from eai.abilities.attempt import AnswerUsage, Attempt
from eai.abilities.experiment import Experiment, StudySettings
from eai.abilities.explanation import VerdictExplanation
from eai.abilities.protocol import Ability, Protocol
from eai.abilities.task_features import TaskFeatures
from eai.abilities.verdict import Verdict
from eai.base.files import to_model_name
from eai.benchmarks.errata_use import ApplicableErrata
from eai.tasks.task import TaskExclusion

NOT_ANSWERED = TaskExclusion("not answered")
"""Reason for excluding a task without an answer, if the user allows missing answers.

The run is then not ranked.
"""


@dataclass(frozen=True, slots=True)
class AnswerOrigin:
    """The source of an answer in a run: its prompt, and how the model's reply ended.

    A task without an answer has an origin, too, which states only the prompt.

    Attributes:
        prompt_sha256: digest of the prompt.
        stop_reason: reason why the answer ended: ``stop``, ``max_tokens``, ...
        truncated: whether a length limit cut the answer off.
        usage: tokens, cost and time of the answer.
        answer_repairs: names of the changes to the model's text before scoring.
    """

    prompt_sha256: str | None = None
    stop_reason: str | None = None
    truncated: bool | None = None
    usage: AnswerUsage | None = None
    answer_repairs: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Record:
    """A verdict, with the answer, the task and the run that it belongs to.

    Attributes:
        domain: the name of the domain.
        model: the name of the model that answered, such as ``eai/noisy``.
        task_id: the data set's id.
        response: the answer as it was scored; empty if the file of the record leaves answers out.
        data_sha256: digest of the data that the answer was scored against.
        verdict: a verdict of the class that the ability declares.
        errata: the errata (known errors of the data set) that scoring used; None if none were used.
        sample: number of the answer, from 0, if a task has several answers that all count; else None.
        explanation: the verdict in words, if the user asked for it.
        origin: the source of the answer, if the run knows it.
        task: the features of the task, if known.
        unanswered: the reason why there is no answer; None if there is an answer, even an empty one.
        suite_size: number of tasks of the suite; None if unknown. A complete run has a record of each.
        experiment: the options of the run's studies (variations of its questions); None if the run asked each
            question once, unchanged.
        summaries: mapping from a study to its summary of the answer.
        attempts: all answers to the task in order, if the run gave several attempts. The verdict is that of
            the last attempt.
    """

    protocol: Protocol
    domain: str
    ability: Ability
    model: str
    task_id: str
    response: str
    data_sha256: str
    verdict: Verdict
    explanation: VerdictExplanation | None = None
    origin: AnswerOrigin | None = None
    task: TaskFeatures | None = None
    unanswered: str | None = None
    suite_size: int | None = None
    experiment: Experiment | None = None
    summaries: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    attempts: tuple[Attempt, ...] = ()
    errata: ApplicableErrata | None = None
    sample: int | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "model", to_model_name(self.model))

    @property
    def is_cut_off(self) -> bool:
        """Whether a length limit cut the answer off."""
        return self.origin is not None and bool(self.origin.truncated)

    @property
    def all_answer_repairs(self) -> tuple[str, ...]:
        """Names of all corrections of the answer's text; corrections made before scoring come first."""
        before = () if self.origin is None else self.origin.answer_repairs
        return (*before, *self.verdict.repairs)

    @property
    def settings_by_study(self) -> dict[str, StudySettings]:
        """Mapping from each study of the run (a variation of its questions) to its options and results."""
        choices = {} if self.experiment is None else self.experiment.study_settings_in_label_order
        return {n: replace(choice, summary=self.summaries.get(n, {})) for n, choice in choices.items()}

    def add_experiment(self, experiment: Experiment) -> Record:
        """Return this record with further options of its run.

        If the record already has options of a study, further options of this study replace all of them.
        """
        if experiment == Experiment():
            return self
        return replace(self, experiment=(self.experiment or Experiment()).override_settings_with(experiment))

    def drop_explanations(self) -> Record:
        """Return the record without its explanation and the explanations of its attempts at the task."""
        attempts = tuple([replace(attempt, explanation=None) for attempt in self.attempts])
        return replace(self, explanation=None, attempts=attempts)
