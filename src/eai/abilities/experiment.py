"""Experiments: settings of runs that do more than ask one question for each task. Labels of such settings."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any

from eai.base.errors import InputError
from eai.base.files import to_file_name

SEPARATOR = "+"
"""Separator of the parts of a run's name or label."""

RULES_SEPARATOR = "_"
"""Separator of the rules in `Experiment.rules`."""

MAX_BUDGET = 100.0
"""Maximum budget of actions in an episode, in multiples of the shortest known plan."""

MAX_STEPS = 1_000_000
"""Maximum number of actions in an episode. A longer episode is cut off."""

MAX_SEED = 2**63 - 1
"""Maximum random seed of slips, which are possible actions that by chance have no effect."""

_DEFAULT_POSITION = 50
"""Default of `StudySettings.label_position`, which orders labels in the name of a folder."""


@dataclass(frozen=True, slots=True)
class StudySettings:
    """The options of a run that belong to one study: a series of runs that vary options of one kind.

    For example, one study varies the number of attempts at a task. The options are stored with all answers of
    the run.

    Attributes:
        label: a short text for the name of the run's folder. It must differ if the options differ.
        options: the options of the study by name, as JSON.
        summary: values that the study computes for one answer, by name. They are stored with this answer.
            Settings of a run have none.
        label_position: position of the label in the name of a folder for several studies: labels with smaller
            numbers come first. Files list studies in this order, but do not store the number.

    Raises:
        InputError: the label cannot be the name of a folder.
    """

    label: str
    options: Mapping[str, Any] = field(default_factory=dict)
    summary: Mapping[str, Any] = field(default_factory=dict, kw_only=True)
    label_position: int = field(default=_DEFAULT_POSITION, compare=False)

    def __post_init__(self) -> None:
        parts = self.label.split(SEPARATOR)
        if [to_file_name(part) for part in parts] != parts:
            raise InputError(
                f"label {self.label!r}: expected a text that can be the name of a folder: "
                "use letters, digits, '.', '-' and '_'"
            )

    def __hash__(self) -> int:
        return hash(self.label)

    def combine(self, study: str, other: StudySettings) -> StudySettings:
        """Return settings with the options and the labels of both settings.

        Raises:
            InputError: the two settings have different values of one option.
        """
        if self == other:
            return self
        for name, value in self.options.items():
            if other.options.get(name, value) != value:
                raise InputError(
                    f"{study}: {name} has two values in one run, {value} and {other.options[name]}: "
                    "give one of them"
                )
        label = SEPARATOR.join(dict.fromkeys([self.label, other.label]))
        return replace(self, label=label, options={**self.options, **other.options})


def make_study_settings_of_one_option(
    label_prefix: str, option: str, value: str, label_position: int = _DEFAULT_POSITION
) -> StudySettings:
    """Return `StudySettings` with one option, and with the label ``PREFIX-VALUE``."""
    return StudySettings(make_option_label(label_prefix, value), {option: value}, label_position)


def make_option_label(label_prefix: str, option_value: str) -> str:
    """Return ``PREFIX-VALUE``, the part of a label that names an option's value.

    Raises:
        InputError: the value cannot be part of a file's name.
    """
    return f"{label_prefix}-{to_file_name(option_value)}"


@dataclass(frozen=True, slots=True)
class Experiment:
    """The settings that distinguish a run from plain questions about a world in which every action works.

    An experiment holds for all answers of a run; a run with plain questions has None instead.

    Attributes:
        study: mapping from names of studies (series of runs that vary options) to the run's settings for each
            study.
        harness: name of the program through which a model acts; None for a plain question, or if unknown.
        effort: the requested reasoning effort; None for the provider's default.
        rules: the rules in the run's games that differ from the standard rules; None for the standard rules.

    Raises:
        InputError: the harness, the effort or the rules cannot be the name of a file.
    """

    study: Mapping[str, StudySettings] = field(default_factory=dict)
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
    def has_standard_rules_and_no_study_options(self) -> bool:
        """Whether the run has the standard game rules and no options of a study.

        Only such runs are ranked.
        """
        return not self.study and self.rules is None

    def combine(self, other: Experiment) -> Experiment:
        """Return an experiment with the settings of both experiments.

        Raises:
            InputError: the two experiments have different values of one setting.
        """
        for name, value in self.agent_settings.items():
            if other.agent_settings.get(name, value) != value:
                raise InputError(
                    f"{name} has two values in one run, {value} and {other.agent_settings[name]}: "
                    "give one of them"
                )
        study = {
            name: self.study[name].combine(name, choice) if name in self.study else choice
            for name, choice in other.study.items()
        }
        return self.override_settings_with(replace(other, study=study))

    def override_settings_with(self, other: Experiment) -> Experiment:
        """Return this experiment with the settings of another experiment, which take precedence.

        Settings for a study replace all settings for the same study.
        """
        study = {**self.study}
        for name, choice in other.study.items():
            study[name] = (
                replace(choice, label_position=study[name].label_position) if name in study else choice
            )
        return replace(self, study=study, **other.agent_settings)

    @property
    def agent_settings(self) -> dict[str, str]:
        """The values of `harness`, `effort` and `rules` (of games), by name. None values are left out."""
        values = {setting.name: getattr(self, setting.name) for setting in fields(self)[1:]}
        return {name: value for name, value in values.items() if value is not None}

    def drop_options_of_study(self, study: str) -> Experiment | None:
        """Return this experiment without the settings for one study, or None if no settings are left."""
        left = replace(self, study={name: self.study[name] for name in self.study if name != study})
        return None if left == Experiment() else left

    @property
    def game_rules_text(self) -> str:
        """The rules of the game in words; empty for the standard rules."""
        return "" if self.rules is None else f"rules {self.rules.replace(RULES_SEPARATOR, ' ')}"

    @property
    def study_settings_in_label_order(self) -> dict[str, StudySettings]:
        """The options of each study (a series of runs with varied options), in the order of labels."""
        return dict(sorted(self.study.items(), key=lambda item: item[1].label_position))

    @property
    def label(self) -> str:
        """A short text by which this experiment differs from all others; it names the experiment's folder."""
        return self._make_label(self.agent_settings)

    @property
    def study_label(self) -> str:
        """The experiment's `label` without `harness` and `effort`; empty if no other settings are left."""
        return self._make_label({"rules": self.rules} if self.rules is not None else {})

    def _make_label(self, agent_settings: Mapping[str, str]) -> str:
        order = ("rules", "harness", "effort")
        parts = [make_option_label(name, agent_settings[name]) for name in order if name in agent_settings]
        return SEPARATOR.join(
            [*(choice.label for choice in self.study_settings_in_label_order.values()), *parts]
        )
