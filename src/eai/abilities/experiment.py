"""Experiments: what sets a run apart from single answers to plain questions, and its name among runs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from typing import Any, Literal, TypeAlias

from eai.base.errors import InputError
from eai.base.files import file_name
from eai.world.fault import Notice

SEPARATOR = "+"
"""The separator of the parts of a name or a label."""

RULES_SEPARATOR = "_"
"""The separator of the rules in `Experiment.rules`."""


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


MAX_BUDGET = 100.0
"""Largest budget of actions, in multiples of the shortest plan known."""

MAX_STEPS = 1_000_000
"""Largest number of actions after which an episode may be cut off."""

MAX_SEED = 2**63 - 1
"""Largest seed of slips."""


@dataclass(frozen=True, slots=True)
class Experiment:
    """How a run differs from asking each question once in a world where every action works.

    It is the same in all records of a run; what it comes to in one task stands elsewhere in its record. What
    is left at its default is as in a plain run, which has no experiment at all.

    Attributes:
        replans: how many further attempts a task gets that fails.
        world: where they begin.
        feedback: what a model hears of the attempts before.
        form: where it stands.
        slip: the probability that a possible action does not work.
        slip_seed: the seed of those draws; None if nothing slips.
        notice: whether a slip is noticed.
        until: when an attempt ends.
        goals_from: the model whose goals the questions state instead of the task's; None for the task's.
        subgoals_from: the model whose subgoals the questions state besides; None if they state no subgoals.
        preset: the published script whose way of carrying plans out it follows; None for ours.
        prompt_name: what the prompts are called among several ways to ask; None where they have no name.
        scene: how the questions show the scene: ``image``, ``both``, ``predicted-...``, ``noisy-...``, with
            what distinguishes these; None where they describe it as it is.
        harness: what a model acts in; None where it answers a question, or that is not known.
        effort: how much it is to reason; None for the provider's default.
        rules: the rules of the game by which episodes were played, as far as they differ from the standard
            setting; None for the standard setting.

    Raises:
        InputError: a number is out of its range, or no file could have the name.
    """

    replans: int = 0
    world: World = "restart"
    feedback: Feedback = "none"
    form: FeedbackForm = "prompt"
    slip: float = 0.0
    slip_seed: int | None = None
    notice: Notice = "detected"
    until: Until = "done"
    goals_from: str | None = None
    subgoals_from: str | None = None
    preset: str | None = None
    prompt_name: str | None = None
    scene: str | None = None
    harness: str | None = None
    effort: str | None = None
    rules: str | None = None

    def __post_init__(self) -> None:
        if not 0 <= self.slip <= 1:
            raise InputError(f"a slip probability of {self.slip:g} is not between 0 and 1")
        if self.replans < 0:
            raise InputError(f"replans: expected 0 or more, not {self.replans}")
        models = (self.goals_from, self.subgoals_from)
        for name in (
            *models,
            self.preset,
            self.prompt_name,
            self.scene,
            self.harness,
            self.effort,
            self.rules,
        ):
            if name is not None:
                file_name(name)
        if self.feedback == "state" and self.world == "restart":
            raise InputError("feedback of the state says nothing in a world that begins anew")

    @property
    def is_plain(self) -> bool:
        """Whether only its harness and effort set it apart, so that its run is ranked as others are."""
        return self == Experiment(harness=self.harness, effort=self.effort)

    def combined(self, other: Experiment) -> Experiment:
        """Return the experiment with the choices of both.

        Raises:
            InputError: both choose a value of one field, and the values differ.
        """
        choices = other.choices
        for name, value in self.choices.items():
            if choices.get(name, value) != value:
                raise InputError(f"{name}: one study chooses {value}, another one {choices[name]}")
        return replace(self, **choices)

    @property
    def choices(self) -> dict[str, Any]:
        """The fields that are not at their defaults, by name."""
        values = {field.name: getattr(self, field.name) for field in fields(self)}
        return {each.name: values[each.name] for each in fields(self) if values[each.name] != each.default}

    def without(self, *names: str) -> Experiment | None:
        """Return the experiment with these fields at their defaults, or None if no choice is left."""
        left = {name: value for name, value in self.choices.items() if name not in names}
        return Experiment(**left) if left else None

    @property
    def rules_text(self) -> str:
        """The rules of the game in words; empty for the standard rules."""
        return "" if self.rules is None else f"rules {self.rules.replace(RULES_SEPARATOR, ' ')}"

    @property
    def acts(self) -> bool:
        """Whether answers are carried out as episodes: in several attempts, or where actions slip."""
        return bool(self.replans or self.slip or self.until == "goal")

    @property
    def name(self) -> str:
        """Its kinds: ``pipeline``, ``perception``, ``replanning``, ``prompts``, ``rules`` and ``agent``."""
        kinds = {
            "pipeline": self.goals_from is not None or self.subgoals_from is not None,
            "perception": self.scene is not None,
            "replanning": self.acts,
            "prompts": self.prompt_name is not None,
            "rules": self.rules is not None,
            "agent": self.harness is not None or self.effort is not None,
        }
        return SEPARATOR.join([kind for kind, is_part in kinds.items() if is_part])

    @property
    def label(self) -> str:
        """A short text that distinguishes it from every other experiment; the name of its folder."""
        parts = [*_named("goals", self.goals_from), *_named("subgoals", self.subgoals_from)]
        parts += [*_named("scene", self.scene), *self._carried_out()]
        parts += [*_named("prompt", self.prompt_name), *_named("as", self.preset)]
        parts += _named("rules", self.rules)
        parts += [*_named("harness", self.harness), *_named("effort", self.effort)]
        return SEPARATOR.join(parts)

    @property
    def study_label(self) -> str:
        """The label without harness and effort; empty for a plain run."""
        rest = self.without("harness", "effort")
        return "" if rest is None else rest.label

    def _carried_out(self) -> Iterator[str]:
        """The parts of the label that say how answers are carried out."""
        if self.acts:
            words = f"{self.world}-{self.feedback}"
            if self.form != "prompt":
                words += f"-{self.form}"
            yield f"replans-{self.replans}-{words}" if self.replans else "replans-0"
        if self.slip:
            silent = "-silent" if self.notice == "silent" else ""
            seed = "" if self.slip_seed is None else f"-seed-{self.slip_seed}"
            yield f"slip-{self.slip:g}{seed}{silent}"
        if self.until == "goal":
            yield f"until-{self.until}"


def _named(kind: str, name: str | None) -> list[str]:
    """The part of a label that says a name; none where there is no name."""
    return [] if name is None else [f"{kind}-{file_name(name)}"]
