"""Who is asked, and how: the options of ``eai run`` about models, and what is wrong with them."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from eai.abilities.responses import file_name
from eai.abilities.verdict import Json
from eai.benchmark.answer_files import recorded_file
from eai.benchmark.suite import Suite
from eai.errors import InputError
from eai.run.job import EYES, PROVIDER, Effort, Endpoint, check_model

REPLAY = "eai/replay"
_PANEL = "Who is asked"

Models = Annotated[
    list[str],
    typer.Option(
        metavar="NAME",
        help="As Inspect names it, openai/gpt-4o say; built in, without key or network: eai/oracle (gold "
        "answers), eai/planner (finds plans), eai/noisy (spoilt gold answers), eai/replay (from files); the "
        "null models eai/copy (what the question says), eai/empty, eai/lookup (answers of similar public "
        "tasks), eai/random (random possible actions).",
        rich_help_panel=_PANEL,
    ),
]
ModelArguments = Annotated[
    list[str] | None,
    typer.Option("-M", metavar="KEY=VALUE", help="An argument of the model.", rich_help_panel=_PANEL),
]
ModelUrl = Annotated[
    str | None, typer.Option(metavar="URL", help="Where a local server listens.", rich_help_panel=_PANEL)
]
Temperature = Annotated[
    float, typer.Option(min=0.0, metavar="T", help="For sampling.", rich_help_panel=_PANEL)
]
MaxTokens = Annotated[int | None, typer.Option(min=1, help="The most of an answer.", rich_help_panel=_PANEL)]
TopP = Annotated[
    float | None,
    typer.Option(min=0.0, max=1.0, help="For sampling.", rich_help_panel=_PANEL),
]
Seed = Annotated[
    int | None,
    typer.Option(help="For sampling, where a provider takes one.", rich_help_panel=_PANEL),
]
ReasoningEffort = Annotated[
    Effort | None,
    typer.Option(metavar="HOW", help="none, minimal, low, medium, high, xhigh, max.", rich_help_panel=_PANEL),
]
ReasoningTokens = Annotated[
    int | None,
    typer.Option(min=1, help="The most of its reasoning.", rich_help_panel=_PANEL),
]
Stop = Annotated[bool, typer.Option(help="Stop sequences as in the paper's runs.", rich_help_panel=_PANEL)]
Structured = Annotated[
    bool,
    typer.Option(
        "--structured",
        help="Hold answers to the task's form and words, where a provider can.",
        rich_help_panel=_PANEL,
    ),
]
Epochs = Annotated[
    int,
    typer.Option(min=1, help="Answers a task; the majority counts.", rich_help_panel=_PANEL),
]


def sampling(
    top_p: float | None, seed: int | None, effort: Effort | None, reasoning_tokens: int | None
) -> dict[str, int | float | str]:
    """What of this is given, by its name in Inspect."""
    given = {
        "top_p": top_p,
        "seed": seed,
        "reasoning_effort": None if effort is None else effort.value,
        "reasoning_tokens": reasoning_tokens,
    }
    return {name: value for name, value in given.items() if value is not None}


def check_models(models: Sequence[str]) -> None:
    """Raise if there is no such model, or two are one folder's name: one would overwrite the other."""
    named: dict[str, str] = {}
    for model in models:
        check_model(model)
        if model == f"{PROVIDER}/{EYES}":
            raise InputError(
                f"--model {model}: it only looks; name it by --scene-model, with --scene predicted"
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


def eyes(
    model: str | None, arguments: Sequence[str] | None, base_url: str | None, prices: Path | None
) -> Endpoint | None:
    """The model that sees, if there is one.

    Raises:
        InputError: there is no such model, or it cannot see.
    """
    if model is None:
        if arguments or base_url is not None:
            raise InputError("--scene-arg, --scene-base-url: expected --scene-model, whom they are about")
        return None
    check_model(model)
    provider, _, name = model.partition("/")
    if provider == PROVIDER and name != EYES:
        raise InputError(f"--scene-model {model}: expected {PROVIDER}/{EYES} or another provider")
    return Endpoint(model, dict(pair(text, "--scene-arg") for text in arguments or ()), base_url, prices)


def pair(text: str, option: str = "-M") -> tuple[str, Json]:
    """An argument of a model; what is a JSON value is taken as one."""
    name, separator, value = text.partition("=")
    if not separator:
        raise InputError(f"{option} {text}: expected NAME=VALUE")
    try:
        return name, json.loads(value)
    except json.JSONDecodeError:
        return name, value
