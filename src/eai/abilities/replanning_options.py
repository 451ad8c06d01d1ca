"""Options of replanning: the number of attempts at a task, the state at their start, and feedback."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass, fields
from typing import Literal, TypeAlias

from eai.abilities.experiment import SEPARATOR, Experiment, StudySettings, make_option_label
from eai.base.errors import InputError
from eai.base.files import to_file_name
from eai.world.fault import Notice

STUDY = "replanning"
"""Name of the study of several attempts at a task, in which actions may slip (have no effect)."""

_LABEL_POSITION = 30

AttemptStart: TypeAlias = Literal["restart", "continue"]
"""State in which a further attempt begins: the initial (``restart``) or the present state (``continue``)."""


FeedbackLevel: TypeAlias = Literal["none", "kind", "explained", "state"]
"""The feedback that a model gets on its earlier answers to the same task.

``none``: no feedback; the model gets the first question again (resampling). ``kind``: the model's answer, an
explanation of the kind of its error, and the missed goals. ``explained``: as ``kind``, and the failed check
in words. ``state``: nothing about the failure; the question describes the present state of the world.
"""

FeedbackForm: TypeAlias = Literal["prompt", "chat"]
"""Position of feedback: at the end of one question (``prompt``) or in turns of a conversation (``chat``)."""

EndCondition: TypeAlias = Literal["goal", "done"]
"""Condition that ends an attempt: all goals hold (``goal``), or the model ends it by a command (``done``)."""


@dataclass(frozen=True, slots=True)
class ReplanningOptions:
    """Options of replanning: a model may attempt a task several times.

    By default a task has one attempt, in which every action works.

    Attributes:
        replans: maximum number of further attempts after a failure.
        world: whether a further attempt begins in the initial state or in the state that was reached.
        feedback: what the feedback says about earlier attempts.
        form: where the feedback stands: in the prompt or in a conversation.
        slip: probability that a possible action slips: by chance, it has no effect.
        slip_seed: random seed that decides which actions slip; None if no action slips.
        notice: whether the agent notices that an action slipped.
        until: the condition that ends an attempt.
        preset: name of a published evaluation script, if plans are executed as in this script; None if not.

    Raises:
        InputError: a number is out of its range, or the preset's name cannot be the name of a file.
    """

    replans: int = 0
    world: AttemptStart = "restart"
    feedback: FeedbackLevel = "none"
    form: FeedbackForm = "prompt"
    slip: float = 0.0
    slip_seed: int | None = None
    notice: Notice = "detected"
    until: EndCondition = "done"
    preset: str | None = None

    def __post_init__(self) -> None:
        if not 0 <= self.slip <= 1:
            raise InputError(f"slip: expected a probability from 0 to 1, not {self.slip:g}")
        if self.replans < 0:
            raise InputError(f"replans: expected 0 or more, not {self.replans}")
        if self.preset is not None:
            to_file_name(self.preset)
        if self.feedback == "state" and self.world == "restart":
            raise InputError(
                "feedback state: has no effect if attempts restart in the initial state; "
                f"also give {STUDY}.world=continue"
            )

    @classmethod
    def from_experiment(cls, experiment: Experiment | None) -> ReplanningOptions | None:
        """Return an experiment's options of replanning (several attempts at a task), or None."""
        choice = None if experiment is None else experiment.study.get(STUDY)
        if choice is None:
            return None
        return cls(
            **{
                option.name: choice.options[option.name]
                for option in fields(cls)
                if option.name in choice.options
            }
        )

    @property
    def executes_answers_as_episodes(self) -> bool:
        """Whether answers are executed step by step, as in games.

        True with several attempts, with slips (possible actions that by chance have no effect), or if plans
        end as soon as all goals hold.
        """
        return bool(self.replans or self.slip or self.until == "goal")

    @property
    def experiment(self) -> Experiment:
        """The experiment (the settings of a run) that consists of only these options."""
        return Experiment({STUDY: StudySettings(self.label, asdict(self), _LABEL_POSITION)})

    @property
    def label(self) -> str:
        """A short text for the name of a run. Different options have different labels."""
        return SEPARATOR.join(self._list_label_parts())

    def _list_label_parts(self) -> Iterator[str]:
        words = f"{self.world}-{self.feedback}" + ("" if self.form == "prompt" else f"-{self.form}")
        yield f"replans-{self.replans}-{words}" if self.replans else "replans-0"
        if self.slip:
            silent = "-silent" if self.notice == "silent" else ""
            seed = "" if self.slip_seed is None else f"-seed-{self.slip_seed}"
            yield f"slip-{self.slip:g}{seed}{silent}"
        if self.until == "goal":
            yield f"until-{self.until}"
        if self.preset is not None:
            yield make_option_label("as", self.preset)
