"""Ask a model about tasks, once for each task or in several attempts, and keep its answers."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import TypeAlias

from eai.abilities.attempt import AnswerUsage, Attempt
from eai.abilities.explanation import VerdictExplanation
from eai.abilities.feedback import MultiAttemptQuestionWriter
from eai.abilities.protocol import Ability
from eai.abilities.replanning_options import ReplanningOptions
from eai.abilities.scorer import Assessment, PlanScorer
from eai.abilities.trial import MultiAttemptTrial
from eai.abilities.verdict import PlanVerdict
from eai.base.errors import InputError
from eai.benchmarks.protocols import require_protocol_implementation
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
        task_id: the data set's id of the task.
        epoch: number of the round of answers to all tasks, from 1 on.
        request_sha256: digest of everything on which the answer depends: model, prompt, parameters.
        prompt_sha256: digest of the prompt alone.
        text: the answer without reasoning.
        reasoning: reasoning of the model before the answer, or empty.
        stop_reason: why the answer ended, in Inspect's words: ``stop``, ``max_tokens``, ...
        repairs: names of the changes to the text that separated or completed the answer.
        usage: tokens, cost and time of the answer.
        attempt: number of the attempt at the task, from 1 on.
    """

    task_id: str
    epoch: int
    request_sha256: str
    prompt_sha256: str
    text: str
    reasoning: str
    stop_reason: str
    repairs: tuple[str, ...]
    usage: AnswerUsage
    attempt: int = 1

    @property
    def is_cut_off(self) -> bool:
        """Whether a length limit cut the answer off."""
        return self.stop_reason in ("max_tokens", "model_length")


TaskIdAndEpoch: TypeAlias = tuple[str, int]
"""Key of an answer: the id of its task, and its epoch (round of answers to all tasks)."""


class Conversation:
    """The questions to a model about one task: one question, or one for each attempt of a trial.

    A trial is a series of attempts. It executes each answer in a world, and a failed answer leads to another
    question. Without a trial, the only answer is scored later.

    Args:
        get_question: returns the next question.
        trial: the trial; None for a single question.
        describe_changed_scene: returns metadata on the scene of the next question; empty if the scene has not
            changed.

    Attributes:
        answered_questions: the questions with an answer, in order.
    """

    def __init__(
        self,
        get_question: Callable[[], Prompt],
        trial: MultiAttemptTrial | None = None,
        describe_changed_scene: Callable[[], Mapping[str, str]] = dict,
    ) -> None:
        self._get_question = get_question
        self._trial = trial
        self._describe_changed_scene = describe_changed_scene
        self.answered_questions: list[Prompt] = []

    @property
    def is_over(self) -> bool:
        """Whether the conversation has no further questions."""
        return bool(self.answered_questions) if self._trial is None else self._trial.has_no_attempt_left

    @property
    def question(self) -> Prompt:
        """The next question."""
        return self._get_question()

    @property
    def changed_scene_metadata_of_next_question(self) -> Mapping[str, str]:
        """Metadata on the scene of the next question; empty if the scene has not changed."""
        return self._describe_changed_scene()

    @property
    def executed_actions(self) -> tuple[Action, ...]:
        """Actions of earlier attempts that changed the world in which the next attempt starts.

        Empty if each attempt starts in the first state of the task.
        """
        if self._trial is None or self._trial.options.feedback == "none":
            return ()
        return self._trial.executed_actions

    @property
    def attempts(self) -> tuple[Attempt, ...]:
        """One attempt for each answer, with its outcome; empty if answers are scored later."""
        return () if self._trial is None else tuple(self._trial.attempts)

    def add_answer(self, text: str) -> None:
        """Add the model's answer to the current question. Afterwards, `question` is the next question."""
        self.answered_questions.append(self.question)
        if self._trial is not None:
            self._trial.try_answer(text)


def add_answer_details_to_attempts(
    attempts: Iterable[Attempt], answers: Iterable[Answer]
) -> Iterator[Attempt]:
    """Yield each attempt with the digest of its prompt, its tokens, and the corrections of its text."""
    for attempt, answer in zip(attempts, answers, strict=True):
        yield replace(
            attempt, prompt_sha256=answer.prompt_sha256, usage=answer.usage, answer_repairs=answer.repairs
        )


@dataclass(frozen=True)
class ReplanningConversationFactory:
    """Begins conversations in which a model has several attempts at a task of a suite.

    The function `make_replanning_conversation_factory` makes this object.

    Attributes:
        suite: the suite, adapted to the model's answers (`Suite.choose_suite_for_answers`).
        options: the number of attempts, the kind of feedback, and the rate of actions that are made to fail.
        question_writer: writes the question of each attempt.
        tasks_with_stated_goals: mapping from ids to tasks with other goals than in the data set. Questions
            state these goals.
    """

    suite: Suite
    options: ReplanningOptions
    question_writer: MultiAttemptQuestionWriter
    tasks_with_stated_goals: Mapping[str, Task] = field(default_factory=dict)

    def start_conversation(self, task_id: str, epoch: int = 1) -> Conversation:
        """Begin the conversation about a task in one epoch (round of answers to all tasks)."""
        trial = begin_trial(
            self.suite, self.options, task_id, epoch, self.tasks_with_stated_goals.get(task_id)
        )
        return Conversation(
            partial(self.question_writer.write_question, trial),
            trial,
            partial(self.question_writer.get_scene_metadata_for_next_question, trial),
        )


def replay_attempts_at_task(
    suite: Suite, options: ReplanningOptions, task_id: str, answers: Iterable[str], epoch: int = 1
) -> tuple[Attempt, ...]:
    """Execute recorded answers to a task again, and return the attempts with their outcomes.

    Args:
        suite: the suite, opened for answers to such questions (`Suite.choose_suite_for_answers`).
        options: number of attempts, kind of feedback, and rate of actions made to fail.
        task_id: id of the task.
        answers: the answers in order.
        epoch: epoch of the answers.
    """
    trial = begin_trial(suite, options, task_id, epoch)
    for text in answers:
        trial.try_answer(text)
    return tuple(trial.attempts)


def begin_trial(
    suite: Suite,
    options: ReplanningOptions,
    task_id: str,
    epoch: int = 1,
    stated_goals_task: Task | None = None,
) -> MultiAttemptTrial:
    """Return a new trial: a series of attempts at a task, in which a model may repair a failed plan.

    If the options name no rules for such series, the rules of this package apply. ``stated_goals_task`` is
    the task with goals from an earlier answer of a model, if questions state these; else None.

    Raises:
        InputError: answers to the task are not plans.
    """
    scorer = suite.scorer(task_id)
    if not isinstance(scorer, PlanScorer):
        raise InputError(
            f"{suite.domain} {suite.ability.value}: only plans can be attempted again; "
            "choose the ability action_sequencing"
        )
    kind = (
        MultiAttemptTrial if options.preset is None else require_protocol_implementation(options.preset).trial
    )
    return kind(scorer, options, epoch, stated_goals_task)


def make_trial_record(
    suite: Suite, options: ReplanningOptions, model: str, task_id: str, attempts: Sequence[Attempt]
) -> Record:
    """Return the record of a task after all attempts at it; the verdict is that of the last attempt."""
    attempts = [_add_cause_of_unreadable_answer(suite, attempt) for attempt in attempts]
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


def _add_cause_of_unreadable_answer(suite: Suite, attempt: Attempt) -> Attempt:
    explanation = attempt.explanation or VerdictExplanation()
    named = suite.add_cause_if_unreadable(attempt.response, Assessment(attempt.verdict, lambda: explanation))
    if not isinstance(named.verdict, PlanVerdict):
        return attempt
    return replace(attempt, verdict=named.verdict, explanation=attempt.explanation and named.explain())


def make_replanning_conversation_factory(
    suite: Suite,
    options: ReplanningOptions,
    question_writer: MultiAttemptQuestionWriter,
    task_ids: Iterable[str],
    tasks_with_stated_goals: Mapping[str, Task] | None = None,
) -> ReplanningConversationFactory:
    """Return the object that begins trials (series of attempts) at some tasks of a suite.

    Some protocols (scoring rules) find out from all answers of a model whether its plans name objects with
    ids. But a trial executes each answer before the next one is known. Therefore these protocols look at the
    questions instead, which contain example answers.

    Raises:
        InputError: the answers of the suite are not plans.
    """
    if suite.ability is not Ability.ACTION_SEQUENCING:
        raise InputError(
            f"{suite.domain} {suite.ability.value}: only plans can be attempted again; "
            "choose the ability action_sequencing"
        )
    suite_of_questions = suite.choose_suite_for_answers(
        [question_writer.prompt_of(task_id).user for task_id in task_ids]
    )
    return ReplanningConversationFactory(
        suite_of_questions, options, question_writer, tasks_with_stated_goals or {}
    )
