"""The tasks of a suite as they are put to a model, once each or again and again, and its answers."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import TypeAlias

from eai.abilities.attempt import Attempt, Usage
from eai.abilities.attempt_options import AttemptOptions
from eai.abilities.feedback import QuestionWriter
from eai.abilities.protocol import Ability
from eai.abilities.scorer import PlanScorer
from eai.abilities.trial import Trial
from eai.base.errors import InputError
from eai.benchmarks.protocols import preset
from eai.benchmarks.suite import Suite
from eai.results.record import Record
from eai.results.records import make_record
from eai.tasks.prompts.prompt import Prompt
from eai.tasks.task import Task
from eai.world.action import Action


@dataclass(frozen=True, slots=True)
class Answer:
    """An answer of a model.

    Attributes:
        task_id: the data set's id.
        epoch: which of several answers to the task it is, from 1 on.
        request_sha256: digest of all that decides the answer: model, prompt, parameters.
        prompt_sha256: digest of the prompt alone.
        text: the answer without reasoning.
        reasoning: what the model thought before it, or empty.
        stop_reason: why it ended, as Inspect says it: ``stop``, ``max_tokens``, ...
        repairs: names of what was done to the text to separate or complete the answer.
        usage: what it took.
        attempt: in which attempt at the task it was given, from 1 on.
    """

    task_id: str
    epoch: int
    request_sha256: str
    prompt_sha256: str
    text: str
    reasoning: str
    stop_reason: str
    repairs: tuple[str, ...]
    usage: Usage
    attempt: int = 1

    @property
    def truncated(self) -> bool:
        """Whether a limit of length cut it off."""
        return self.stop_reason in ("max_tokens", "model_length")


AnswerKey: TypeAlias = tuple[str, int]
"""Id of the task, and epoch."""


class Conversation:
    """A task as it is put to a model: there is a question until it is over.

    Without a trial it is asked once, and what becomes of its answer is found out afterwards.

    Args:
        ask: makes the next question.
        trial: what carries the answers out.
        about: makes the metadata of the next question on the scene that it tells of, if that has changed.

    Attributes:
        asked: the questions that are answered, in order.
    """

    def __init__(
        self,
        ask: Callable[[], Prompt],
        trial: Trial | None = None,
        about: Callable[[], Mapping[str, str]] = dict,
    ) -> None:
        self._ask = ask
        self._trial = trial
        self._about = about
        self.asked: list[Prompt] = []

    @property
    def is_over(self) -> bool:
        """Whether there is nothing more to ask."""
        return bool(self.asked) if self._trial is None else self._trial.is_over

    @property
    def question(self) -> Prompt:
        """The next question."""
        return self._ask()

    @property
    def metadata(self) -> Mapping[str, str]:
        """The metadata of the next question on the scene that it tells of, if that has changed."""
        return self._about()

    @property
    def executed_actions(self) -> tuple[Action, ...]:
        """The actions executed in the world that the question is about, if it says how that is now."""
        if self._trial is None or self._trial.options.feedback == "none":
            return ()
        return self._trial.executed_actions

    @property
    def attempts(self) -> tuple[Attempt, ...]:
        """The outcomes of the answers, where they are carried out."""
        return () if self._trial is None else tuple(self._trial.attempts)

    def add_answer(self, text: str) -> None:
        """Take the answer to the question."""
        self.asked.append(self.question)
        if self._trial is not None:
            self._trial.try_answer(text)


def describe_attempts(attempts: Iterable[Attempt], answers: Iterable[Answer]) -> Iterator[Attempt]:
    """Attempts at a task with what is known of the answers that were carried out in them."""
    for attempt, answer in zip(attempts, answers, strict=True):
        yield replace(
            attempt, prompt_sha256=answer.prompt_sha256, usage=answer.usage, answer_repairs=answer.repairs
        )


@dataclass(frozen=True)
class Trials:
    """How the tasks of a suite are tried in an experiment; `open_trials` makes it.

    Attributes:
        suite: the suite, as it reads answers.
        options: how many attempts there are, and in what world.
        asker: what asks.
        stated: by id, tasks with the goals that questions state instead of the tasks' own.
    """

    suite: Suite
    options: AttemptOptions
    asker: QuestionWriter
    stated: Mapping[str, Task] = field(default_factory=dict)

    def start_conversation(self, task_id: str, epoch: int = 1) -> Conversation:
        """A task as it is put to a model."""
        trial = begin_trial(self.suite, self.options, task_id, epoch, self.stated.get(task_id))
        return Conversation(
            partial(self.asker.write_question, trial), trial, partial(self.asker.describe_scene, trial)
        )


def replay(
    suite: Suite, options: AttemptOptions, task_id: str, answers: Iterable[str], epoch: int = 1
) -> tuple[Attempt, ...]:
    """The outcomes of answers that were given before.

    Args:
        suite: the suite, as it reads answers to such questions (`Suite.over`).
        options: how many attempts there are, and in what world.
        task_id: the task.
        answers: the answers, in order.
        epoch: which epoch they are of.
    """
    trial = begin_trial(suite, options, task_id, epoch)
    for text in answers:
        trial.try_answer(text)
    return tuple(trial.attempts)


def begin_trial(
    suite: Suite, options: AttemptOptions, task_id: str, epoch: int = 1, stated: Task | None = None
) -> Trial:
    """A new trial of a task, in the way of a preset or in ours.

    ``stated`` has the goals that questions state instead of the task's own.

    Raises:
        InputError: answers to the task are no plans.
    """
    scorer = suite.scorer(task_id)
    if not isinstance(scorer, PlanScorer):
        raise InputError(f"{suite.domain} {suite.ability.value} has no plans to carry out")
    kind = Trial if options.preset is None else preset(options.preset).trial
    return kind(scorer, options, epoch, stated)


def make_trial_record(
    suite: Suite, options: AttemptOptions, model: str, task_id: str, attempts: Sequence[Attempt]
) -> Record:
    """The record of a task that was tried: its verdict is that of the last attempt."""
    last = attempts[-1]
    return make_record(
        suite,
        model,
        task_id,
        last.response,
        last.verdict,
        explanation=last.explanation,
        task=suite.features(task_id),
        experiment=options.experiment,
        attempts=tuple(attempts),
    )


def open_trials(
    suite: Suite,
    options: AttemptOptions,
    asker: QuestionWriter,
    task_ids: Iterable[str],
    stated: Mapping[str, Task] | None = None,
) -> Trials:
    """The trials of some tasks of a suite, whose questions may state other goals (`Trials.stated`).

    Where a protocol reads each answer as all are written, that cannot be waited for: answers are read as the
    examples in the questions are written.

    Raises:
        InputError: the answers of the suite are no plans.
    """
    if suite.ability is not Ability.ACTION_SEQUENCING:
        raise InputError(
            f"{suite.domain} {suite.ability.value}: only plans are carried out, attempt by attempt"
        )
    together = suite.over([asker.prompt_of(task_id).user for task_id in task_ids])
    return Trials(together, options, asker, stated or {})
