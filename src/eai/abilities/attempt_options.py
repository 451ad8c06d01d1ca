"""Attempts at a task: how many there are, in what world, and what a model hears of those that failed."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass, fields
from typing import Literal, TypeAlias

from eai.abilities.experiment import SEPARATOR, Experiment, StudyChoice, named
from eai.base.errors import InputError
from eai.base.files import to_file_name
from eai.world.fault import Notice

STUDY = "replanning"
"""Name in records of the study whose runs have several attempts, or actions that fail."""

_PLACE = 30

World: TypeAlias = Literal["restart", "continue"]
"""Where a further attempt begins: in the initial state again, or where the one before it ended."""


Feedback: TypeAlias = Literal["none", "kind", "explained", "state"]
"""The feedback to a model on its earlier attempts.

``none``: nothing, so that it is asked the same again (the resampling arm). ``kind``: its answer, the kind of
its error and what that means, and the goals that were missed. ``explained``: the failed check in words
besides. ``state``: no word on what failed; the question describes the state that the world is in now.
"""

FeedbackForm: TypeAlias = Literal["prompt", "chat"]
"""Where feedback stands: at the end of the one question, or as turns of a conversation."""

Until: TypeAlias = Literal["goal", "done"]
"""When an episode ends: in the first state in which all goals are reached, or when the agent says so."""


@dataclass(frozen=True, slots=True)
class AttemptOptions:
    """The options of attempts at a task. By default a task has one attempt, in which every action works.

    Attributes:
        replans: how many further attempts a task gets that fails.
        world: where they begin.
        feedback: what a model hears of the attempts before.
        form: where it stands.
        slip: the probability that a possible action does not work.
        slip_seed: the seed of those draws; None if nothing slips.
        notice: whether a slip is noticed.
        until: when an attempt ends.
        preset: the published script whose way of carrying plans out it follows; None for ours.

    Raises:
        InputError: a number is out of its range, or no file could have the name of the preset.
    """

    replans: int = 0
    world: World = "restart"
    feedback: Feedback = "none"
    form: FeedbackForm = "prompt"
    slip: float = 0.0
    slip_seed: int | None = None
    notice: Notice = "detected"
    until: Until = "done"
    preset: str | None = None

    def __post_init__(self) -> None:
        if not 0 <= self.slip <= 1:
            raise InputError(f"a slip probability of {self.slip:g} is not between 0 and 1")
        if self.replans < 0:
            raise InputError(f"replans: expected 0 or more, not {self.replans}")
        if self.preset is not None:
            to_file_name(self.preset)
        if self.feedback == "state" and self.world == "restart":
            raise InputError("feedback of the state says nothing in a world that begins anew")

    @classmethod
    def of(cls, experiment: Experiment | None) -> AttemptOptions | None:
        """Return the options of an experiment, or None if its answers are not carried out in attempts."""
        choice = None if experiment is None else experiment.study.get(STUDY)
        if choice is None:
            return None
        return cls(
            **{each.name: choice.options[each.name] for each in fields(cls) if each.name in choice.options}
        )

    @property
    def acts(self) -> bool:
        """Whether answers are carried out as episodes: in several attempts, or where actions slip."""
        return bool(self.replans or self.slip or self.until == "goal")

    @property
    def experiment(self) -> Experiment:
        """The experiment that has these options and no other choices."""
        return Experiment({STUDY: StudyChoice(self.label, asdict(self), _PLACE)})

    @property
    def label(self) -> str:
        """A short text that differs from that of other options."""
        return SEPARATOR.join(self._labels())

    def _labels(self) -> Iterator[str]:
        words = f"{self.world}-{self.feedback}" + ("" if self.form == "prompt" else f"-{self.form}")
        yield f"replans-{self.replans}-{words}" if self.replans else "replans-0"
        if self.slip:
            silent = "-silent" if self.notice == "silent" else ""
            seed = "" if self.slip_seed is None else f"-seed-{self.slip_seed}"
            yield f"slip-{self.slip:g}{seed}{silent}"
        if self.until == "goal":
            yield f"until-{self.until}"
        if self.preset is not None:
            yield named("as", self.preset)
