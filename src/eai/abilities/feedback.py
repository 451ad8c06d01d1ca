"""Feedback on failed answers: the next question to a model about the same task, written from templates.

`eai.abilities.replanning_options.FeedbackLevel` lists the levels of feedback. The folder
``templates/feedback`` has a template for each kind of error.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TypeAlias

from eai.abilities.attempt import Attempt
from eai.abilities.explanation import GoalReport, StepReport, VerdictExplanation
from eai.abilities.replanning_options import ReplanningOptions
from eai.abilities.reports import HIDDEN_HAZARD
from eai.abilities.trial import MultiAttemptTrial
from eai.abilities.verdict import RAISED, ErrorReport
from eai.tasks.goal_text import write_goal
from eai.tasks.prompts.own import write_initial_state
from eai.tasks.prompts.prompt import BelievedTask, Prompt
from eai.tasks.prompts.template import PromptTemplates
from eai.tasks.task import GoalKind, Task
from eai.tasks.wording import PromptAndAnswerWording
from eai.world.fault import NOT_EXECUTED, FaultKind

REASONS_PREFIX = "What went wrong in attempt"
"""Beginning of the list of reasons why an attempt failed. Built-in models recognize feedback by this text."""

_FOLDER = "feedback"

Restate: TypeAlias = Callable[[BelievedTask], Prompt]
"""Function that makes the question about a task in its present state, as a model understands this state."""

ScenePerception: TypeAlias = Callable[[Task, int], tuple[BelievedTask, Mapping[str, str]]]
"""Function that perceives the present scene of a task before the model's n-th answer, counted from 1.

It takes the task and n. It returns the task as the model sees it, and metadata to store with the question.
"""


@dataclass(frozen=True)
class MultiAttemptQuestionWriter:
    """Writes the questions to a model that may answer a task several times (in several attempts).

    Attributes:
        prompt_of: returns the first question about a task, given the task's id.
        wording: the names of predicates and objects in questions.
        restate: makes the question about a task in its present state. If it is None, a description of the
            present state is added to the first question.
        templates: the templates of feedback.
        perceive: perceives the present scene; None if questions describe the true scene.
    """

    prompt_of: Callable[[str], Prompt]
    wording: PromptAndAnswerWording
    restate: Restate | None = None
    templates: PromptTemplates = field(default_factory=PromptTemplates)
    perceive: ScenePerception | None = None

    def get_scene_metadata_for_next_question(self, trial: MultiAttemptTrial) -> Mapping[str, str]:
        """Return metadata about the scene in the next question; empty if it describes no new scene."""
        if self.perceive is not None and _is_next_question_about_reached_state(trial):
            return self._get_believed_task_and_metadata(trial)[1]
        return {}

    def write_question(self, trial: MultiAttemptTrial) -> Prompt:
        """Return the question for the next answer to the task."""
        prompt, chosen = self.prompt_of(trial.task.id), trial.options
        if not trial.attempts or chosen.feedback == "none":
            return prompt
        if chosen.form == "chat":
            return self._write_conversation(prompt, trial)
        feedback = self._write_feedback(trial) if chosen.feedback != "state" else ""
        if chosen.world == "continue" and self.restate is not None:
            prompt = self.restate(self._get_believed_task_and_metadata(trial)[0])
        elif chosen.world == "continue":
            feedback = "\n\n".join(
                [self._describe_present_state(trial), feedback or self._read_template("again_continue")]
            )
        return replace(prompt, user="\n\n".join([prompt.user.rstrip(), *filter(None, [feedback])]))

    def _write_conversation(self, prompt: Prompt, trial: MultiAttemptTrial) -> Prompt:
        """Return the first question, followed by all answers and the replies to them.

        Only the last reply describes the present state.
        """
        replies = [self._write_reply(number, trial) for number in range(1, len(trial.attempts) + 1)]
        if trial.options.world == "continue":
            replies[-1] = "\n\n".join(
                [text for text in (replies[-1], self._describe_present_state(trial)) if text]
            )
        answers = [attempt.response for attempt in trial.attempts]
        return replace(prompt, turns=tuple(zip(answers, replies, strict=True)))

    def _write_reply(self, attempt_number: int, trial: MultiAttemptTrial) -> str:
        chosen = trial.options
        values = {
            "world": self._read_template(chosen.world),
            "again": self._read_template(f"again_{chosen.world}"),
        }
        if chosen.feedback == "state":
            return " ".join(values.values())
        return self._fill_template(
            "chat", reasons=self._write_failure_reasons(attempt_number, trial), **values
        )

    def _write_feedback(self, trial: MultiAttemptTrial) -> str:
        feedback = [
            self._fill_template(
                "attempt",
                number=str(number),
                answer=attempt.response.strip() or self._read_template("nothing_written"),
                reasons=self._write_failure_reasons(number, trial),
            )
            for number, attempt in enumerate(trial.attempts, 1)
        ]
        world = trial.options.world
        return self._fill_template(
            "prompt",
            world=self._read_template(world),
            attempts="\n\n".join(feedback),
            again=self._read_template(f"again_{world}"),
        )

    def _write_failure_reasons(self, attempt_number: int, trial: MultiAttemptTrial) -> str:
        attempt, goals = trial.attempts[attempt_number - 1], trial.goal_reports[attempt_number - 1]
        reasons = self._list_failure_reasons(attempt, goals, trial.options)
        lines = "\n".join([f"- {reason}" for reason in reasons])
        return self._fill_template("reasons", number=str(attempt_number), reasons=lines)

    def _list_failure_reasons(
        self, attempt: Attempt, goals: Sequence[GoalReport], options: ReplanningOptions
    ) -> Iterator[str]:
        """Yield the reasons why an answer failed: needless and failed steps, the error, and missed goals."""
        error, explanation = attempt.verdict.error, attempt.explanation or VerdictExplanation()
        gives_reason = options.feedback == "explained"
        for number, step in enumerate(explanation.steps):
            if step.outcome == FaultKind.ADDITIONAL_STEP.value:
                yield self._describe_step_fault(
                    FaultKind.ADDITIONAL_STEP, number, step, gives_reason=gives_reason
                )
            elif step.outcome == FaultKind.SLIP.value and options.notice == "detected":
                yield self._describe_step_fault(FaultKind.SLIP, number, step, gives_reason=False)
        if error is not None and error.kind is not FaultKind.SLIP:
            yield self._explain_error(error, explanation.steps, gives_reason=gives_reason)
        told = [goal for goal in goals if goal.kind != HIDDEN_HAZARD]
        missed = [f"  {goal.kind}: {goal.goal}" for goal in told if not goal.satisfied]
        if missed and (error is None or error.kind not in NOT_EXECUTED):
            yield self._fill_template("goals", goals="\n".join(missed))

    def _explain_error(self, error: ErrorReport, steps: Sequence[StepReport], *, gives_reason: bool) -> str:
        if error.check == RAISED:
            return self._read_template("raised")
        if error.step is not None and error.kind not in NOT_EXECUTED:
            return self._describe_step_fault(
                error.kind, error.step, steps[error.step], gives_reason=gives_reason
            )
        number = "" if error.step is None else str(error.step + 1)
        meaning = self._fill_template(error.kind.value, step=number)
        if not gives_reason and error.kind is not FaultKind.ARGUMENT_NUMBER:
            return meaning
        return self._fill_template("explained", meaning=meaning, reason=error.detail)

    def _describe_step_fault(
        self, kind: FaultKind, step_number: int, step: StepReport, *, gives_reason: bool
    ) -> str:
        meaning = self._fill_template(kind.value, step=str(step_number + 1), action=step.action)
        if not gives_reason or not step.reason:
            return meaning
        if not step.earlier:
            return self._fill_template("explained", meaning=meaning, reason=step.reason)
        return self._fill_template("earlier", meaning=meaning, reason=step.reason, earlier=step.earlier)

    def _describe_present_state(self, trial: MultiAttemptTrial) -> str:
        """Return a text on the present state, and on the actions that the goals still require."""
        belief = self._get_believed_task_and_metadata(trial)[0]
        actions = [write_goal(goal.formula) for goal in belief.task.get_goals_of_kind(GoalKind.ACTION)]
        state = write_initial_state(self.wording, belief)
        if not actions:
            return self._fill_template("now", state=state)
        return self._fill_template("now_actions", state=state, actions="\n".join(actions))

    def _get_believed_task_and_metadata(
        self, trial: MultiAttemptTrial
    ) -> tuple[BelievedTask, Mapping[str, str]]:
        """Return the task as the model sees it now, with the remaining goals, and metadata to store."""
        if self.perceive is None:
            return BelievedTask(trial.task_in_next_question), {}
        return self.perceive(trial.task_in_next_question, len(trial.attempts) + 1)

    def _read_template(self, template_name: str) -> str:
        return self.templates.read(f"{_FOLDER}/{template_name}.txt")

    def _fill_template(self, template_name: str, **values: str) -> str:
        return self.templates.fill_template(f"{_FOLDER}/{template_name}.txt", values)


def _is_next_question_about_reached_state(trial: MultiAttemptTrial) -> bool:
    chosen = trial.options
    return bool(trial.attempts) and chosen.world == "continue" and chosen.feedback != "none"
