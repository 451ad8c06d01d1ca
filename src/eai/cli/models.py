"""The models that a command names: their arguments, and what is wrong with them."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

from eai.abilities.protocol import Ability
from eai.abilities.responses import file_name
from eai.abilities.verdict import Json
from eai.benchmark.answer_files import recorded_file
from eai.benchmark.suite import Suite
from eai.errors import InputError
from eai.run.job import CAPTIONER, PROVIDER, Endpoint, check_model
from eai.studies.perception.scenes import SCENE_GRAPH

REPLAY = "eai/replay"


def check_models(models: Sequence[str], abilities: Sequence[Ability] = ()) -> None:
    """Raise if there is no such model, or two are one folder's name: one would overwrite the other."""
    named: dict[str, str] = {}
    for model in models:
        check_model(model)
        if model == f"{PROVIDER}/{CAPTIONER}" and {*abilities} != {SCENE_GRAPH}:
            raise InputError(
                f"--model {model}: it only lists scenes (--ability {SCENE_GRAPH}); for another model name it "
                "as perception.scene_model, with perception.scene predicted"
            )
        twin = named.setdefault(file_name(model), model)
        if twin != model:
            raise InputError(
                f"--model {model}: its results would overwrite those of {twin}; run it by itself"
            )


def check_replay(endpoints: Sequence[Endpoint], suites: Sequence[Suite]) -> None:
    """Raise if recorded answers are to be replayed, and a suite has none or another suite's."""
    for endpoint in endpoints:
        path = endpoint.arguments.get("path")
        if endpoint.model != REPLAY or path is None:
            continue
        files = [recorded_file(Path(str(path)), suite.domain, suite.ability) for suite in suites]
        if len(set(files)) < len(files):
            hint = "name its suite with --domain and --ability, or give a folder"
            raise InputError(f"-M path={path}: one file cannot answer {len(files)} suites; {hint}")


def pair(text: str) -> tuple[str, Json]:
    """An argument of a model."""
    name, separator, value = text.partition("=")
    if not separator:
        raise InputError(f"-M {text}: expected NAME=VALUE")
    return name, json_or_text(value)


def json_or_text(text: str) -> Json:
    """The JSON value that a text is, or else the text."""
    try:
        value: Json = json.loads(text)
    except json.JSONDecodeError:
        return text
    return value
