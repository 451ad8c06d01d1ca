"""Feedback: what a model is asked after it has failed, as text from templates.

How much it hears is the experiment's choice (`eai.abilities.experiment.Feedback`); the words are those of
the files in ``templates/feedback``, of which each kind of error has one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace

from eai.abilities.experiment import Experiment
from eai.abilities.explanation import Explanation, StepReport
from eai.abilities.record import Attempt
from eai.abilities.reports import UNTOLD, formula_text
from eai.abilities.task import GoalKind, Task
from eai.abilities.trial import Trial
from eai.abilities.verdict import RAISED, ErrorReport
from eai.abilities.wording import Wording
from eai.prompts.prompt import Prompt
from eai.prompts.template import Templates
from eai.world.fault import NOT_CARRIED_OUT, FaultKind

REASONS = "What went wrong in attempt"
"""How the reasons of an attempt begin, in our own words; the built-in model that heeds them looks for it."""

_FOLDER = "feedback"

Restate = Callable[[Task], Prompt]
"""The question about a task as it is believed to be."""


@dataclass(frozen=True)
class Asker:
    """The questions to a model in each attempt of a trial.

    Attributes:
        prompt_of: the question of the first attempt, by task.
        wording: what facts are called.
        restate: the question about a task that has changed; None where questions cannot be rendered anew, so
            that what holds now is added to them.
        templates: the words of feedback.
    """

    prompt_of: Callable[[str], Prompt]
    wording: Wording
    restate: Restate | None = None
    templates: Templates = field(default_factory=Templates)

    def question(self, trial: Trial) -> Prompt:
        """The next question."""
        prompt, chosen = self.prompt_of(trial.task.id), trial.experiment
        if not trial.attempts or chosen.feedback == "none":
            return prompt
        if chosen.form == "chat":
            return self._conversation(prompt, trial)
        feedback = self._feedback_on(trial.attempts, chosen) if chosen.feedback != "state" else ""
        if chosen.world == "continue" and self.restate is not None:
            prompt = self.restate(trial.remaining)
        elif chosen.world == "continue":
            feedback = "\n\n".join([self._now(trial), feedback or self._text("again_continue")])
        return replace(prompt, user="\n\n".join([prompt.user.rstrip(), *filter(None, [feedback])]))

    def _conversation(self, prompt: Prompt, trial: Trial) -> Prompt:
        """The first question with all answers and what was said to each; of the state only what it is now."""
        said = [self._reply(number, each, trial.experiment) for number, each in enumerate(trial.attempts, 1)]
        if trial.experiment.world == "continue":
            said[-1] = "\n\n".join([part for part in (said[-1], self._now(trial)) if part])
        answers = [each.response for each in trial.attempts]
        return replace(prompt, turns=tuple(zip(answers, said, strict=True)))

    def _reply(self, number: int, attempt: Attempt, chosen: Experiment) -> str:
        """The reply to one answer in a conversation."""
        values = {"world": self._text(chosen.world), "again": self._text(f"again_{chosen.world}")}
        if chosen.feedback == "state":
            return " ".join(values.values())
        return self._fill("chat", reasons=self._reasons(number, attempt, chosen), **values)

    def _feedback_on(self, attempts: Sequence[Attempt], chosen: Experiment) -> str:
        """The feedback on all attempts at the end of a question."""
        feedback = [
            self._fill(
                "attempt",
                number=str(number),
                answer=each.response.strip() or self._text("nothing_written"),
                reasons=self._reasons(number, each, chosen),
            )
            for number, each in enumerate(attempts, 1)
        ]
        return self._fill(
            "prompt",
            world=self._text(chosen.world),
            attempts="\n\n".join(feedback),
            again=self._text(f"again_{chosen.world}"),
        )

    def _reasons(self, number: int, attempt: Attempt, chosen: Experiment) -> str:
        lines = "\n".join([f"- {reason}" for reason in self._each_reason(attempt, chosen)])
        return self._fill("reasons", number=str(number), reasons=lines)

    def _each_reason(self, attempt: Attempt, chosen: Experiment) -> Iterator[str]:
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
        told = [goal for goal in explanation.goals if goal.kind != UNTOLD]
        missed = [f"  {goal.kind}: {goal.goal}" for goal in told if not goal.satisfied]
        if missed and (error is None or error.kind not in NOT_CARRIED_OUT):
            yield self._fill("goals", goals="\n".join(missed))

    def _of_error(self, error: ErrorReport, steps: Sequence[StepReport], *, explains: bool) -> str:
        """The error that ended an attempt."""
        if error.check == RAISED:
            return self._text("raised")
        if error.step is not None and error.kind not in NOT_CARRIED_OUT:
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
        task = trial.remaining
        actions = [formula_text(goal.formula) for goal in task.goals_of(GoalKind.ACTION)]
        state = self.wording.initial(task)
        if not actions:
            return self._fill("now", state=state)
        return self._fill("now_actions", state=state, actions="\n".join(actions))

    def _text(self, name: str) -> str:
        return self.templates.text(f"{_FOLDER}/{name}.txt")

    def _fill(self, name: str, **values: str) -> str:
        return self.templates.fill(f"{_FOLDER}/{name}.txt", values)
