"""The flags of ``eai run``: short names of options of a run's specification, and ``--with`` for all options.

This module also checks the models that these flags name.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import typer

from eai.abilities.protocol import SCENE_GRAPH, Ability
from eai.base.errors import InputError, did_you_mean
from eai.base.files import read_toml, to_file_name
from eai.base.json_value import Json
from eai.benchmarks.suite import Suite
from eai.cli import options
from eai.cli.options import SETTING, split_name_and_value
from eai.results.answer_files import find_response_file_of_suite
from eai.run.job import CAPTIONER, PROVIDER, can_model_answer, check_model_name
from eai.run.spec import RunSpec, get_default_text_by_option, get_options_by_section, read_spec
from eai.studies.registry import list_studies_with_run_options
from eai.studies.variation import ModelEndpoint

FLAGS = {
    "model": "model.name",
    "model_base_url": "model.base_url",
    "temperature": "generation.temperature",
    "max_tokens": "generation.max_tokens",
    "seed": "generation.seed",
    "domain": "tasks.domain",
    "ability": "tasks.ability",
    "tasks": "tasks.ids",
    "limit": "tasks.limit",
    "adaptive": "tasks.adaptive",
    "epochs": "tasks.epochs",
    "prompt_set": "prompts.set",
    "prompts": "prompts.folder",
    "max_connections": "requests.max_connections",
    "protocol": "scoring.protocol",
    "errata": "scoring.errata",
    "planner": "scoring.planner",
    "workers": "scoring.workers",
}
"""Parameters of ``eai run`` that are options of a run's specification."""

REPLAY = "eai/replay"

HELP = "help"
"""Value of ``--with`` that lists all options."""


def make_run_flag(parameter: str, panel: str, *names: str, **more: Any) -> Any:
    """Return the flag for a parameter of ``eai run``."""
    section, _, option = FLAGS[parameter].partition(".")
    chosen = type(RunSpec.model_fields[section].default)
    default = chosen.format_default(option)
    return options.make_option_flag(chosen, option, panel, *names, show_default=default or False, **more)


def read_run_specification(
    command: typer.Context, file: Path | None, model_args: Sequence[str], settings: Sequence[str]
) -> RunSpec:
    """Return the specification of a run from a file, flags and settings.

    Flags override the file, and settings override flags.

    Raises:
        InputError: The file cannot be read, or an option or its value is unknown.
    """
    tables = {} if file is None else read_toml(file)
    for parameter, key in FLAGS.items():
        value = command.params.get(parameter)
        if value not in (None, [], ()):
            _put_nested_value(tables, key.split("."), value)
    for argument in model_args:
        name, text = split_name_and_value(argument, "-M", "NAME=VALUE")
        _put_nested_value(tables, ["model", "args", name], _parse_json_or_text(text))
    for given in settings:
        key, separator, text = given.partition("=")
        places = key.split(".", 2)
        if not separator or len(places) == 1:
            known = get_default_text_by_option()
            short = [name for name in known if name.endswith(f".{key}")]
            hint = f"; did you mean {short[0]}?" if short else did_you_mean(key, known)
            raise InputError(f"{SETTING} {given}: expected SECTION.OPTION=VALUE{hint}")
        _put_nested_value(tables, places, text if len(places) == 2 else _parse_json_or_text(text))
    try:
        return read_spec(tables)
    except InputError as error:
        if file is not None and str(error) == _describe_mistake_in_spec_file(file):
            raise InputError(f"{file}: {error}") from error
        raise


def _describe_mistake_in_spec_file(file: Path) -> str:
    try:
        read_spec(read_toml(file))
    except InputError as error:
        return str(error)
    return ""


def _put_nested_value(table: dict[str, Any], places: Sequence[str], value: object) -> None:
    *outer, last = places
    for depth, place in enumerate(outer, 1):
        table = table.setdefault(place, {})
        if not isinstance(table, dict):
            option = ".".join(places[:depth])
            raise InputError(
                f"{'.'.join(places)}: {option} has a value, so it cannot contain options; drop one of the two"
            )
    table[last] = value


def _parse_json_or_text(text: str) -> Json:
    """Return the JSON value of a text, or the text itself if it is not JSON."""
    try:
        value: Json = json.loads(text)
    except json.JSONDecodeError:
        return text
    return value


def list_run_options() -> Iterator[str]:
    """Return a table of all options in Markdown."""
    yield "| option | if not given | meaning |"
    yield "|---|---|---|"
    titles = {study.name: study.title for study in list_studies_with_run_options()}
    for section, chosen in get_options_by_section().items():
        title = titles.get(section) or (chosen.__doc__ or "").splitlines()[0]
        yield f"| **{section}** | | {title} |"
        yield from options.format_option_rows(chosen, f"{section}.")


def check_model_names(models: Sequence[str], abilities: Sequence[Ability]) -> None:
    """Raise if a model does not exist, or if two models would write to the same folder."""
    named: dict[str, str] = {}
    for model in models:
        check_model_name(model)
        if model == f"{PROVIDER}/{CAPTIONER}" and {*abilities} != {SCENE_GRAPH}:
            raise InputError(
                f"--model {model}: this model only lists scenes, so give --ability {SCENE_GRAPH}. To let it "
                "perceive scenes for another --model, give --with perception.scene=predicted "
                f"--with perception.scene_model={model}"
            )
        twin = named.setdefault(to_file_name(model), model)
        if twin != model:
            raise InputError(
                f"--model {model}: its results would overwrite those of {twin}, because both names give one "
                "folder; run it by itself, with another --out"
            )


def describe_unsupported_abilities_of_models(
    models: Sequence[str], abilities: Sequence[Ability]
) -> list[str]:
    """Return a remark on each built-in model that has no answers to some abilities.

    Raises:
        InputError: No model answers any of the abilities.
    """
    lacking = {
        model: dict.fromkeys(each.value for each in abilities if not can_model_answer(model, each))
        for model in models
    }
    lines = [f"{model} has no answer to {', '.join(names)}" for model, names in lacking.items() if names]
    if abilities and not any(can_model_answer(model, each) for model in models for each in abilities):
        raise InputError("; ".join(lines))
    return [f"{line}: skipped" for line in lines]


def check_captioning_model(model: str) -> None:
    """Raise if the captioning model does not exist or takes no pictures."""
    check_model_name(model)
    provider, _, name = model.partition("/")
    if provider == PROVIDER and name != CAPTIONER:
        expected = f"expected {PROVIDER}/{CAPTIONER} or another provider"
        raise InputError(f"perception.scene_model {model}: {expected}")


def check_replayed_files_match_suites(endpoints: Sequence[ModelEndpoint], suites: Sequence[Suite]) -> None:
    """Raise if answers are replayed from files, and a suite lacks a file of its own.

    A suite is an ability in a benchmark.
    """
    for endpoint in endpoints:
        path = endpoint.arguments.get("path")
        if endpoint.model != REPLAY or path is None:
            continue
        files = [
            find_response_file_of_suite(Path(str(path)), suite.domain, suite.ability) for suite in suites
        ]
        if len(set(files)) < len(files):
            hint = "name its suite with --domain and --ability, or give a folder"
            raise InputError(f"-M path={path}: one file cannot answer {len(files)} suites; {hint}")
