"""Replanning and actions that fail: the options of the study."""

from __future__ import annotations

from pydantic import model_validator
from typing_extensions import Self

from eai.abilities.experiment import Experiment, Feedback, FeedbackForm, World
from eai.abilities.options import Options, option
from eai.benchmark.protocols import preset_experiment
from eai.errors import InputError
from eai.studies.study import Study
from eai.world.episode import Notice, Until


class Attempts(Options):
    """How often plans are tried, and how reliable actions are.

    Raises:
        InputError: choices contradict each other.
    """

    replans: int = option("Further attempts at a task that fails.", 0, ge=0)
    world: World = option(
        "Where further attempts begin: restart (in the initial state), or continue (where the "
        "one before ended).",
        World.RESTART,
    )
    feedback: Feedback | None = option(
        "What a model is told of failures: explained (if not given), kind, state, or none: the same question."
    )
    feedback_form: FeedbackForm = option(
        "Where it is told: prompt (at the end of the question), or chat (as turns of a conversation).",
        FeedbackForm.PROMPT,
    )
    slip: float = option("The probability that a possible action does not work.", 0.0, ge=0, le=1)
    slip_seed: int = option("The seed of the slips.", 0)
    slip_notice: Notice = option("Whether a slip is noticed: detected, or silent.", Notice.DETECTED)
    until: Until | None = option(
        "An attempt ends with its plan (done), or in the first state with all goals (goal; if "
        "not given, where the world continues)."
    )
    preset: str = option(
        "A protocol: slips as its published script has them, three replans, the state told.", ""
    )

    @model_validator(mode="after")
    def _without_contradictions(self) -> Self:
        _ = self.experiment
        return self

    @property
    def experiment(self) -> Experiment | None:
        """The experiment, in which choices that do not matter are as in a plain run; None for a plain run.

        Feedback explains, and an attempt in a world that continues ends with the goal, where nothing is
        chosen.
        """
        scripted = preset_experiment(self.preset, self.slip, self.slip_seed, self.replans)
        if scripted is not None:
            return scripted
        feedback = self.feedback or (Feedback.EXPLAINED if self.replans else Feedback.NONE)
        if feedback is not Feedback.NONE and not self.replans:
            raise InputError(f"attempts.feedback {feedback.value}: there is none without attempts.replans")
        continues = self.world is World.CONTINUE and bool(self.replans)
        experiment = Experiment(
            self.replans,
            World.CONTINUE if continues else World.RESTART,
            feedback,
            FeedbackForm.PROMPT if feedback is Feedback.NONE else self.feedback_form,
            self.slip,
            self.slip_seed if self.slip else None,
            self.slip_notice if self.slip else Notice.DETECTED,
            self.until or (Until.GOAL if continues else Until.DONE),
        )
        return experiment if experiment.acts else None


ATTEMPTS = Study("attempts", "Replanning and actions that fail (action sequencing).", Attempts)
