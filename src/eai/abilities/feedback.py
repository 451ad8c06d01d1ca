"""Feedback: what a model is asked after it has failed, as text from templates.

`eai.abilities.attempt_options.Feedback` lists how much it hears. The words are those of the files in
``templates/feedback``, of which each kind of error has one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TypeAlias

from eai.abilities.attempt import Attempt
from eai.abilities.attempt_options import AttemptOptions
from eai.abilities.explanation import Explanation, GoalReport, StepReport
from eai.abilities.reports import UNTOLD
from eai.abilities.trial import Trial
from eai.abilities.verdict import RAISED, ErrorReport
from eai.tasks.goal_text import formula_text
from eai.tasks.prompts.own import initial_text
from eai.tasks.prompts.prompt import Belief, Prompt
from eai.tasks.prompts.template import Templates
from eai.tasks.task import GoalKind, Task
from eai.tasks.wording import Wording
from eai.world.fault import NOT_EXECUTED, FaultKind

REASONS = "What went wrong in attempt"
"""How the reasons of an attempt begin, in our own words; the built-in model that heeds them looks for it."""

_FOLDER = "feedback"

Restate: TypeAlias = Callable[[Belief], Prompt]
"""The question about a task as it is believed to be."""

Look: TypeAlias = Callable[[Task, int], tuple[Belief, Mapping[str, str]]]
"""Perceives a task's present scene before an attempt: the belief, and the metadata of the question."""


@dataclass(frozen=True)
class Asker:
    """The questions to a model in each attempt of a trial.

    Attributes:
        prompt_of: the question of the first attempt, by task.
        wording: what facts are called.
        restate: the question about a task that has changed; None where questions cannot be rendered anew, so
            that what holds now is added to them.
        templates: the words of feedback.
        look: how a scene that has changed is perceived; None if it is told as it is.
    """

    prompt_of: Callable[[str], Prompt]
    wording: Wording
    restate: Restate | None = None
    templates: Templates = field(default_factory=Templates)
    look: Look | None = None

    def about(self, trial: Trial) -> Mapping[str, str]:
        """Return the metadata of the next question on the scene that it tells of, if that has changed."""
        return self._seen(trial)[1] if self.look is not None and _tells_present_world(trial) else {}

    def question(self, trial: Trial) -> Prompt:
        """The next question."""
        prompt, chosen = self.prompt_of(trial.task.id), trial.options
        if not trial.attempts or chosen.feedback == "none":
            return prompt
        if chosen.form == "chat":
            return self._conversation(prompt, trial)
        feedback = self._feedback_on(trial) if chosen.feedback != "state" else ""
        if chosen.world == "continue" and self.restate is not None:
            prompt = self.restate(self._seen(trial)[0])
        elif chosen.world == "continue":
            feedback = "\n\n".join([self._now(trial), feedback or self._text("again_continue")])
        return replace(prompt, user="\n\n".join([prompt.user.rstrip(), *filter(None, [feedback])]))

    def _conversation(self, prompt: Prompt, trial: Trial) -> Prompt:
        """The first question with all answers and what was said to each; of the state only what it is now."""
        said = [self._reply(number, trial) for number in range(1, len(trial.attempts) + 1)]
        if trial.options.world == "continue":
            said[-1] = "\n\n".join([part for part in (said[-1], self._now(trial)) if part])
        answers = [each.response for each in trial.attempts]
        return replace(prompt, turns=tuple(zip(answers, said, strict=True)))

    def _reply(self, number: int, trial: Trial) -> str:
        """The reply to one answer in a conversation."""
        chosen = trial.options
        values = {"world": self._text(chosen.world), "again": self._text(f"again_{chosen.world}")}
        if chosen.feedback == "state":
            return " ".join(values.values())
        return self._fill("chat", reasons=self._reasons(number, trial), **values)

    def _feedback_on(self, trial: Trial) -> str:
        """The feedback on all attempts at the end of a question."""
        feedback = [
            self._fill(
                "attempt",
                number=str(number),
                answer=each.response.strip() or self._text("nothing_written"),
                reasons=self._reasons(number, trial),
            )
            for number, each in enumerate(trial.attempts, 1)
        ]
        world = trial.options.world
        return self._fill(
            "prompt",
            world=self._text(world),
            attempts="\n\n".join(feedback),
            again=self._text(f"again_{world}"),
        )

    def _reasons(self, number: int, trial: Trial) -> str:
        attempt, goals = trial.attempts[number - 1], trial.told[number - 1]
        reasons = self._each_reason(attempt, goals, trial.options)
        lines = "\n".join([f"- {reason}" for reason in reasons])
        return self._fill("reasons", number=str(number), reasons=lines)

    def _each_reason(
        self, attempt: Attempt, goals: Sequence[GoalReport], chosen: AttemptOptions
    ) -> Iterator[str]:
        """Why an attempt failed: the steps that were not executed, and the goals that were missed."""
        error, explanation = attempt.verdict.error, attempt.explanation or Explanation()
        explains = chosen.feedback == "explained"
        for number, step in enumerate(explanation.steps):
            if step.outcome == FaultKind.ADDITIONAL_STEP.value:
                yield self._of_step(FaultKind.ADDITIONAL_STEP, number, step, explains=explains)
            elif step.outcome == FaultKind.SLIP.value and chosen.notice == "detected":
                yield self._of_step(FaultKind.SLIP, number, step, explains=False)
        if error is not None and error.kind is not FaultKind.SLIP:
            yield self._of_error(error, explanation.steps, explains=explains)
        told = [goal for goal in goals if goal.kind != UNTOLD]
        missed = [f"  {goal.kind}: {goal.goal}" for goal in told if not goal.satisfied]
        if missed and (error is None or error.kind not in NOT_EXECUTED):
            yield self._fill("goals", goals="\n".join(missed))

    def _of_error(self, error: ErrorReport, steps: Sequence[StepReport], *, explains: bool) -> str:
        """The error that ended an attempt."""
        if error.check == RAISED:
            return self._text("raised")
        if error.step is not None and error.kind not in NOT_EXECUTED:
            return self._of_step(error.kind, error.step, steps[error.step], explains=explains)
        number = "" if error.step is None else str(error.step + 1)
        meaning = self._fill(error.kind.value, step=number)
        if not explains and error.kind is not FaultKind.ARGUMENT_NUMBER:
            return meaning
        return self._fill("explained", meaning=meaning, reason=error.detail)

    def _of_step(self, kind: FaultKind, number: int, step: StepReport, *, explains: bool) -> str:
        """A step that was not executed."""
        meaning = self._fill(kind.value, step=str(number + 1), action=step.action)
        if not explains or not step.reason:
            return meaning
        if not step.earlier:
            return self._fill("explained", meaning=meaning, reason=step.reason)
        return self._fill("earlier", meaning=meaning, reason=step.reason, earlier=step.earlier)

    def _now(self, trial: Trial) -> str:
        """The state of the world, and what is left of the actions that a plan has to take."""
        belief = self._seen(trial)[0]
        actions = [formula_text(goal.formula) for goal in belief.task.goals_of(GoalKind.ACTION)]
        state = initial_text(self.wording, belief)
        if not actions:
            return self._fill("now", state=state)
        return self._fill("now_actions", state=state, actions="\n".join(actions))

    def _seen(self, trial: Trial) -> tuple[Belief, Mapping[str, str]]:
        """The belief about what is left of a task, and the metadata of a question that states it."""
        if self.look is None:
            return Belief(trial.remaining), {}
        return self.look(trial.remaining, len(trial.attempts) + 1)

    def _text(self, name: str) -> str:
        return self.templates.text(f"{_FOLDER}/{name}.txt")

    def _fill(self, name: str, **values: str) -> str:
        return self.templates.fill(f"{_FOLDER}/{name}.txt", values)


def _tells_present_world(trial: Trial) -> bool:
    """Whether the next question tells of the world as it is now."""
    chosen = trial.options
    return bool(trial.attempts) and chosen.world == "continue" and chosen.feedback != "none"
