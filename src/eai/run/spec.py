"""The specification of a run: who is asked what, under which studies, within which limits.

The flags of ``eai run``, the arguments of Inspect's tasks, the file beside a run and the table of options in
the documentation are made from it. Its sections are tables of the file, which is TOML, as ``eai run
FILE.toml`` takes it and writes it beside its results; a study that is chosen is one more.
"""

from __future__ import annotations

import json
import re
from collections.abc import Collection, Mapping
from itertools import count
from pathlib import Path
from typing import Annotated

from pydantic import BeforeValidator, Field, JsonValue, model_validator
from typing_extensions import Self

from eai.abilities.experiment import Experiment
from eai.abilities.protocol import PAPER_ABILITIES, Ability
from eai.agents.setting import STANDARD, Setting
from eai.base.errors import InputError, did_you_mean
from eai.base.files import write_whole
from eai.benchmarks.registry import REFERENCES
from eai.results.options import ScoringOptions
from eai.run.job import Decoding, Pace
from eai.studies.registry import studies_of_runs
from eai.studies.variation import Endpoint, Variation, combine
from eai.tasks.options import Arguments, Options
from eai.tasks.prompts.prompt import VARIANTS, PromptSet

_BARE = re.compile(r"[A-Za-z0-9_-]+")
"""Keys that need no quotes."""


def save(spec: RunSpec, folder: Path) -> Path:
    """Write a specification to ``run.toml``, or to ``run-2.toml`` and so on where other runs have theirs.

    Raises:
        InputError: the folder cannot be written.
    """
    content = "\n".join(
        "".join([f"[{name}]\n", *(f"{_key(key)} = {_value(value)}\n" for key, value in table.items())])
        for name, table in spec.tables.items()
    ).encode("utf-8", "backslashreplace")
    files = (folder / f"run{'' if number == 1 else f'-{number}'}.toml" for number in count(1))
    file = next(each for each in files if not each.is_file() or each.read_bytes() == content)
    write_whole({file: content})
    return file


def _key(name: str) -> str:
    return name if _BARE.fullmatch(name) else _text(name)


def _text(text: str) -> str:
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _value(value: JsonValue) -> str:
    """A value in TOML, which has no null: members without a value are left out."""
    if isinstance(value, str):
        return _text(value)
    if isinstance(value, Mapping):
        inner = [f"{_key(name)} = {_value(each)}" for name, each in value.items() if each is not None]
        return f"{{ {', '.join(inner)} }}" if inner else "{}"
    if isinstance(value, list):
        return f"[{', '.join(_value(each) for each in value if each is not None)}]"
    return str(value).lower() if isinstance(value, bool) else repr(value)


def _several(given: object) -> object:
    return (given,) if isinstance(given, str) else given


Texts = Annotated[tuple[str, ...], BeforeValidator(_several)]
Abilities = Annotated[tuple[Ability, ...], BeforeValidator(_several)]


class _ChosenModels(Options):
    """Who is asked.

    Attributes:
        name: As Inspect names it, openai/gpt-4o say; built in, without key and network: eai/oracle (gold),
            eai/planner (finds plans), eai/noisy (corrupted gold), eai/replay (from files); the null models
            eai/copy (what the question says), eai/empty, eai/lookup (answers of similar public tasks),
            eai/random (random possible actions).
        args: Arguments of the model, such as args.rate=0.2.
        base_url: The address of a local server.
    """

    name: Texts = ()
    args: Arguments = Field(default={})
    base_url: str | None = None

    @property
    def endpoints(self) -> list[Endpoint]:
        """The models, and how to reach them."""
        return [Endpoint(name, self.args, self.base_url) for name in self.name]


class _ChosenTasks(Options):
    """The tasks.

    Attributes:
        ids: Only these, in suites that have them; short: forty that stand for a suite.
        limit: Tasks a suite, at most.
        adaptive: Choose the most informative tasks, until the ability's standard error is at most S logits.
        calibration: A folder with whole runs of three models or more, which tell tasks.adaptive how difficult
            tasks are.
        epochs: Answers a task; the majority counts, in acting the mean.
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


class _ChosenPrompts(Options):
    """How it is asked.

    Attributes:
        set: The prompts: the data set's (official), or ours (eai), also in few words (eai-brief) or with
            questions to go through (eai-careful).
        folder: A folder with prompts of your own.
        name: A name for these prompts, in records and tables.
    """

    set: PromptSet = "official"
    folder: Path | None = None
    name: str | None = None

    @property
    def label(self) -> str | None:
        """The name of the prompts in records and tables: the user's, or that of a variant of ours."""
        return self.name or (self.set if self.set in VARIANTS else None)


class RunSpec(Options):
    """The specification of a run.

    Attributes:
        model: who is asked.
        tasks: what is asked.
        prompts: how it is asked.
        generation: how models answer.
        requests: how requests are made.
        scoring: how answers are scored.
        agent: how an agent acts, in the ability ``acting``.
        studies: the options of the studies that are chosen, by name.

    Raises:
        InputError: what is chosen cannot be combined.
    """

    model: _ChosenModels = _ChosenModels()
    tasks: _ChosenTasks = _ChosenTasks()
    prompts: _ChosenPrompts = _ChosenPrompts()
    generation: Decoding = Decoding()
    requests: Pace = Pace()
    scoring: ScoringOptions = ScoringOptions()
    agent: Setting = STANDARD
    studies: Mapping[str, Variation] = {}

    @model_validator(mode="after")
    def _without_contradictions(self) -> Self:
        choice = self.variation.choice
        if self.tasks.adaptive and choice:
            reason = "it chooses tasks by how difficult their plain questions are"
            raise InputError(f"tasks.adaptive: not with {choice}; {reason}")
        return self

    @property
    def variation(self) -> Variation:
        """The options of the studies that the run combines.

        Raises:
            InputError: two of them contradict each other.
        """
        return combine([self.studies[each.key] for each in studies_of_runs() if each.key in self.studies])

    @property
    def experiment(self) -> Experiment:
        """The choices of studies in records, without those that a stage before the questions states."""
        variations = {each.name: self.studies.get(each.key, Variation()) for each in studies_of_runs()}
        chosen = {name: each.recorded(name) for name, each in variations.items() if each.choice}
        return Experiment({name: choice for name, choice in chosen.items() if choice is not None})

    @property
    def tables(self) -> dict[str, dict[str, JsonValue]]:
        """The specification as tables of a file: every option that has a value, and no keys of servers."""
        core = {name: getattr(self, name) for name in _CORE}
        sections: dict[str, Options] = {**core, **self.studies}
        return {name: each.model_dump(mode="json", exclude_none=True) for name, each in sections.items()}


_CORE = {name: type(field.default) for name, field in RunSpec.model_fields.items() if name != "studies"}


def sections() -> Mapping[str, type[Options]]:
    """The sections of a specification by name, those of studies last."""
    return {**_CORE, **{study.key: study.options for study in studies_of_runs()}}


def read_spec(tables: Mapping[str, object]) -> RunSpec:
    """The specification that tables of options make, by the names of sections.

    Raises:
        InputError: there is no such section or option, it has no such value, or they contradict each other.
    """
    known = sections()
    for name in tables:
        _refuse_unknown(name, known)
    read = {name: known[name].read(name, given) for name, given in tables.items()}
    studies = {name: read.pop(name) for name in [*read] if name not in _CORE}
    return RunSpec.model_validate({**read, "studies": studies})


def find_study_of_option(name: str) -> str:
    """The name of the study that has an option.

    Raises:
        InputError: none has.
    """
    known = {each: study.key for study in studies_of_runs() for each in study.options.model_fields}
    _refuse_unknown(name, known)
    return known[name]


def _refuse_unknown(name: str, known: Collection[str]) -> None:
    if name not in known:
        raise InputError(f"{name}: unknown{did_you_mean(name, known)} (there are {', '.join(known)})")


def list_defaults() -> dict[str, str]:
    """The value of each option without a choice, empty where there is none, by section and name."""
    return {
        f"{section}.{name}": options.default_of(name)
        for section, options in sections().items()
        for name in options.model_fields
    }
