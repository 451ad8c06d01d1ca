"""The specification of a run: models, tasks, studies (variations of the questions), and limits.

It defines the flags of ``eai run``, the arguments of Inspect's tasks, and the table of options in the
documentation. Its sections are the tables of a TOML file. ``eai run FILE.toml`` reads such a file, and each
run writes one into the folder of its results. A study that the run uses is a section, too.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from itertools import count
from pathlib import Path
from typing import Annotated

from pydantic import BeforeValidator, Field, JsonValue, model_validator
from typing_extensions import Self

from eai.abilities.experiment import Experiment
from eai.abilities.protocol import PAPER_ABILITIES, Ability
from eai.agents.setting import STANDARD, AgentSetting
from eai.base.errors import InputError, did_you_mean
from eai.base.files import format_toml_text, write_files_atomically
from eai.benchmarks.registry import REFERENCES
from eai.results.options import ScoringOptions
from eai.run.job import DecodingOptions, RequestOptions
from eai.studies.registry import list_studies_with_run_options
from eai.studies.variation import ModelEndpoint, VariationOptions, combine_variations
from eai.tasks.options import Arguments, Options, WebAddress
from eai.tasks.prompts.prompt import VARIANTS, PromptSet

_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")
"""Pattern of TOML keys that need no quotes."""


def save_spec(spec: RunSpec, folder: Path) -> Path:
    """Write a specification to ``run.toml``, or to ``run-2.toml`` if that file has another specification.

    Raises:
        InputError: the folder cannot be written.
    """
    content = "\n".join(
        "".join(
            [
                f"[{name}]\n",
                *(f"{_format_toml_key(key)} = {_format_toml_value(value)}\n" for key, value in table.items()),
            ]
        )
        for name, table in spec.toml_tables.items()
    ).encode("utf-8", "backslashreplace")
    files = (folder / f"run{'' if number == 1 else f'-{number}'}.toml" for number in count(1))
    file = next(file for file in files if not file.is_file() or file.read_bytes() == content)
    write_files_atomically({file: content})
    return file


def _format_toml_key(name: str) -> str:
    return name if _BARE_KEY.fullmatch(name) else format_toml_text(name)


def _format_toml_value(value: JsonValue) -> str:
    """Return a value as TOML text; members without a value are left out, because TOML has no null."""
    if isinstance(value, str):
        return format_toml_text(value)
    if isinstance(value, Mapping):
        inner = [
            f"{_format_toml_key(name)} = {_format_toml_value(item)}"
            for name, item in value.items()
            if item is not None
        ]
        return f"{{ {', '.join(inner)} }}" if inner else "{}"
    if isinstance(value, list):
        return f"[{', '.join(_format_toml_value(item) for item in value if item is not None)}]"
    return str(value).lower() if isinstance(value, bool) else repr(value)


def _wrap_text_in_tuple(given: object) -> object:
    return (given,) if isinstance(given, str) else given


Texts = Annotated[tuple[str, ...], BeforeValidator(_wrap_text_in_tuple)]
Abilities = Annotated[tuple[Ability, ...], BeforeValidator(_wrap_text_in_tuple)]


class _ModelOptions(Options):
    """The models of a run.

    Attributes:
        name: Name in Inspect, such as openai/gpt-4o; built in, without key and network: eai/oracle (gold),
            eai/planner (finds plans), eai/noisy (corrupted gold), eai/replay (from files); the null models
            eai/copy (what the question says), eai/empty, eai/lookup (answers of similar public tasks),
            eai/random (random possible actions).
        args: Arguments of the model, such as args.rate=0.2.
        base_url: Address of a local server.
    """

    name: Texts = ()
    args: Arguments = Field(default={})
    base_url: WebAddress | None = None

    @property
    def endpoints(self) -> list[ModelEndpoint]:
        """The models of the run, each with its name, address and arguments."""
        return [ModelEndpoint(name, self.args, self.base_url) for name in self.name]


class _TaskOptions(Options):
    """The tasks of a run.

    Attributes:
        ids: Ids of tasks; the run has only these. The word short stands for forty tasks that represent a
            suite.
        limit: Maximum number of tasks of a suite.
        adaptive: Choose the most informative tasks, until the standard error of the model's ability is at
            most this number of logits.
        calibration: A folder with whole runs of three models or more, which tell tasks.adaptive how difficult
            tasks are.
        epochs: Number of answers to each task. The majority counts; for the ability acting, the mean.
    """

    domain: Texts = Field(default=(), description=f"A benchmark: {REFERENCES}. The paper's two if not given.")
    ability: Abilities = Field(
        default=(),
        description=f"{', '.join(PAPER_ABILITIES)}, which are all if none is given, or another one.",
    )
    ids: str = ""
    limit: int | None = Field(default=None, ge=1)
    adaptive: float | None = Field(default=None, ge=0.05)
    calibration: Path | None = None
    epochs: int = Field(default=1, ge=1)


class _PromptOptions(Options):
    """The prompts.

    Attributes:
        set: The prompts: the data set's (official), or ours (eai), also in few words (eai-brief), with
            questions to go through (eai-careful), in a third of the length (short), or only goals and facts
            (facts).
        folder: A folder with prompts of your own.
        name: A name for these prompts, in records and tables.
    """

    set: PromptSet = "official"
    folder: Path | None = None
    name: str | None = None

    @property
    def prompt_label(self) -> str | None:
        """Name of the prompts in records and tables: the name given by the user, or the chosen variant."""
        return self.name or (self.set if self.set in VARIANTS else None)


class RunSpec(Options):
    """The specification of a run.

    Attributes:
        model: the models.
        tasks: the tasks.
        prompts: the prompts.
        generation: options of the models' answers.
        requests: options of requests.
        scoring: options of scoring.
        agent: setting of an agent, in the ability ``acting``.
        studies: mapping from the names of the chosen studies to their options.

    Raises:
        InputError: the choices cannot be combined.
    """

    model: _ModelOptions = _ModelOptions()
    tasks: _TaskOptions = _TaskOptions()
    prompts: _PromptOptions = _PromptOptions()
    generation: DecodingOptions = DecodingOptions()
    requests: RequestOptions = RequestOptions()
    scoring: ScoringOptions = ScoringOptions()
    agent: AgentSetting = STANDARD
    studies: Mapping[str, VariationOptions] = {}

    @model_validator(mode="after")
    def _check_contradictions(self) -> Self:
        choice = self.combined_options_of_studies.option_that_enables_study
        if self.tasks.adaptive and choice:
            reason = "adaptive runs choose tasks by the difficulty of plain questions"
            raise InputError(f"tasks.adaptive: cannot be combined with {choice}; {reason}")
        return self

    @property
    def setting(self) -> AgentSetting:
        """The run's options for agents in episodes, with the run's set of prompts if it is in `VARIANTS`."""
        chosen = self.prompts.set
        return self.agent.model_copy(update={"prompts": chosen}) if chosen in VARIANTS else self.agent

    @property
    def combined_options_of_studies(self) -> VariationOptions:
        """The options of all studies of the run (variations of its questions), combined into one object.

        Raises:
            InputError: two studies contradict each other.
        """
        return combine_variations(
            [
                self.studies[study.name]
                for study in list_studies_with_run_options()
                if study.name in self.studies
            ]
        )

    @property
    def experiment(self) -> Experiment:
        """The options of studies (variations) that change the questions of the run, as records store them.

        Before its questions, a run may ask a model for the goals or scenes of the tasks. The options of this
        stage are left out; `GoalsAndScenesStatedInPrompts.experiment` has them.
        """
        variations_by_study = {
            variation.name: self.studies.get(variation.name, VariationOptions())
            for variation in list_studies_with_run_options()
        }
        choices = {
            name: variation.make_study_settings_to_store_in_records(name)
            for name, variation in variations_by_study.items()
            if variation.option_that_enables_study
        }
        return Experiment({name: choice for name, choice in choices.items() if choice is not None})

    @property
    def toml_tables(self) -> dict[str, dict[str, JsonValue]]:
        """The specification as TOML tables: every option with a value, except secret keys."""
        core = {name: getattr(self, name) for name in _CORE}
        sections: dict[str, Options] = {**core, **self.studies}
        return {
            name: options.model_dump(mode="json", exclude_none=True) for name, options in sections.items()
        }


_CORE = {name: type(field.default) for name, field in RunSpec.model_fields.items() if name != "studies"}


def get_options_by_section() -> Mapping[str, type[Options]]:
    """Return a mapping: section of a specification -> class of its options. Studies come last."""
    return {**_CORE, **{study.name: study.options for study in list_studies_with_run_options()}}


def read_spec(tables: Mapping[str, object]) -> RunSpec:
    """Return the specification of a run with the given options; all other options have their defaults.

    Options are given as a mapping by section and name.

    Raises:
        InputError: a section, an option or a value is unknown, or options contradict each other.
    """
    options_of_section = get_options_by_section()
    for name in tables:
        _refuse_unknown_name(name, options_of_section)
    read = {name: options_of_section[name].read(name, given) for name, given in tables.items()}
    studies = {name: read.pop(name) for name in [*read] if name not in _CORE}
    return RunSpec.model_validate({**read, "studies": studies})


def find_study_of_option(name: str) -> str:
    """Return the name of the study (variation of the questions) that has an option.

    Raises:
        InputError: no study has the option.
    """
    study_of_option = {
        option: study.name
        for study in list_studies_with_run_options()
        for option in study.options.model_fields
    }
    _refuse_unknown_name(name, study_of_option)
    return study_of_option[name]


def _refuse_unknown_name(name: str, known_names: Collection[str]) -> None:
    if name not in known_names:
        raise InputError(
            f"{name}: unknown{did_you_mean(name, known_names)} (there are {', '.join(known_names)})"
        )


def get_default_text_by_option() -> dict[str, str]:
    """Return a mapping from options, as ``section.name``, to their default values as text.

    The text is empty for options without a default.
    """
    return {
        f"{section}.{name}": options.format_default(name)
        for section, options in get_options_by_section().items()
        for name in options.model_fields
    }
