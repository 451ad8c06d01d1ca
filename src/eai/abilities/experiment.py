"""Experiments: what sets a run apart from single answers to plain questions, and its name among runs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any

from eai.base.errors import InputError
from eai.base.files import to_file_name

SEPARATOR = "+"
"""The separator of the parts of a name or a label."""

RULES_SEPARATOR = "_"
"""The separator of the rules in `Experiment.rules`."""

MAX_BUDGET = 100.0
"""Largest budget of actions, in multiples of the shortest plan known."""

MAX_STEPS = 1_000_000
"""Largest number of actions after which an episode may be cut off."""

MAX_SEED = 2**63 - 1
"""Largest seed of slips."""

_PLACE = 50
"""Default of `StudyChoice.place`."""


@dataclass(frozen=True, slots=True)
class StudyChoice:
    """The choice of a run in one study. All records of the run have it.

    Attributes:
        label: a short text that differs from the labels of other choices in the study. It is part of the name
            of the run's folder.
        options: the options of the study by name, as JSON.
        summary: what the study says of one answer, by name; empty in the choice of a run.
        place: the study's place among the studies of a label; smaller numbers come first. Files do not have
            it: they list the studies in order.

    Raises:
        InputError: no folder could have the label as its name.
    """

    label: str
    options: Mapping[str, Any] = field(default_factory=dict)
    summary: Mapping[str, Any] = field(default_factory=dict, kw_only=True)
    place: int = field(default=_PLACE, compare=False)

    def __post_init__(self) -> None:
        parts = self.label.split(SEPARATOR)
        if [to_file_name(part) for part in parts] != parts:
            raise InputError(f"label {self.label!r}: expected the name of a folder")

    def __hash__(self) -> int:
        return hash(self.label)

    def combined(self, study: str, other: StudyChoice) -> StudyChoice:
        """Return the choice with the options and labels of both.

        Raises:
            InputError: they have different values of one option.
        """
        if self == other:
            return self
        for name, value in self.options.items():
            if other.options.get(name, value) != value:
                raise InputError(f"{study}: {name} is both {value} and {other.options[name]} in one run")
        label = SEPARATOR.join(dict.fromkeys([self.label, other.label]))
        return replace(self, label=label, options={**self.options, **other.options})


def named_choice(kind: str, option: str, name: str, place: int = _PLACE) -> StudyChoice:
    """Return the choice of one option that is a name, with the label ``kind-name``."""
    return StudyChoice(named(kind, name), {option: name}, place)


def named(kind: str, name: str) -> str:
    """Return the part of a label that gives a name.

    Raises:
        InputError: no file could have the name.
    """
    return f"{kind}-{to_file_name(name)}"


@dataclass(frozen=True, slots=True)
class Experiment:
    """How a run differs from asking each question once in a world where every action works.

    It is the same in all records of a run. A plain run has no experiment at all.

    Attributes:
        study: the choices of the run by the name of their study.
        harness: what a model acts in; None where it answers a question, or that is not known.
        effort: how much it is to reason; None for the provider's default.
        rules: the rules of the game by which episodes were played, as far as they differ from the standard
            setting; None for the standard setting.

    Raises:
        InputError: no file could have the name of the harness, the effort or the rules.
    """

    study: Mapping[str, StudyChoice] = field(default_factory=dict)
    harness: str | None = None
    effort: str | None = None
    rules: str | None = None

    def __post_init__(self) -> None:
        for name in (self.harness, self.effort, self.rules):
            if name is not None:
                to_file_name(name)

    def __hash__(self) -> int:
        return hash((frozenset(self.study.items()), self.harness, self.effort, self.rules))

    @property
    def is_plain(self) -> bool:
        """Whether only its harness and effort set it apart, so that its run is ranked as others are."""
        return not self.study and self.rules is None

    def combined(self, other: Experiment) -> Experiment:
        """Return the experiment with the choices of both.

        Raises:
            InputError: both choose a value of one option, and the values differ.
        """
        for name, value in self.agent.items():
            if other.agent.get(name, value) != value:
                raise InputError(f"{name} is both {value} and {other.agent[name]} in one run")
        study = {
            name: self.study[name].combined(name, choice) if name in self.study else choice
            for name, choice in other.study.items()
        }
        return self.updated(replace(other, study=study))

    def updated(self, other: Experiment) -> Experiment:
        """Return the experiment with the choices of another one, which replace its own."""
        study = {**self.study}
        for name, choice in other.study.items():
            study[name] = replace(choice, place=study[name].place) if name in study else choice
        return replace(self, study=study, **other.agent)

    @property
    def agent(self) -> dict[str, str]:
        """The harness, the effort and the rules, without those that are None."""
        values = {each.name: getattr(self, each.name) for each in fields(self)[1:]}
        return {name: value for name, value in values.items() if value is not None}

    def without(self, study: str) -> Experiment | None:
        """Return the experiment without the choice in a study, or None if no choice is left."""
        left = replace(self, study={name: self.study[name] for name in self.study if name != study})
        return None if left == Experiment() else left

    @property
    def rules_text(self) -> str:
        """The rules of the game in words; empty for the standard rules."""
        return "" if self.rules is None else f"rules {self.rules.replace(RULES_SEPARATOR, ' ')}"

    @property
    def ordered(self) -> dict[str, StudyChoice]:
        """The choices in the order of their labels."""
        return dict(sorted(self.study.items(), key=lambda item: item[1].place))

    @property
    def label(self) -> str:
        """A short text that distinguishes it from every other experiment; the name of its folder."""
        return self._labelled(self.agent)

    @property
    def study_label(self) -> str:
        """The label without harness and effort; empty for a plain run."""
        return self._labelled({"rules": self.rules} if self.rules is not None else {})

    def _labelled(self, agent: Mapping[str, str]) -> str:
        order = ("rules", "harness", "effort")
        parts = [named(kind, agent[kind]) for kind in order if kind in agent]
        return SEPARATOR.join([*(choice.label for choice in self.ordered.values()), *parts])
