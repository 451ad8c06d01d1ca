"""``eai human``: people answer the questions that models get."""

from __future__ import annotations

from pathlib import Path
from random import Random
from typing import Annotated

import typer

from eai.abilities.verdict import Json
from eai.benchmark.prompt_library import Library
from eai.benchmark.registry import find_benchmark
from eai.cli.console import DOMAIN_HELP, counted, data_progress, tell
from eai.cli.options import AsJson, OfAbility, listed
from eai.cli.store import DataFolder, store
from eai.data.files import write_whole
from eai.errors import InputError
from eai.prompts.prompt import PromptSet
from eai.report.answer_form import form_html
from eai.tasks.source import Source

app = typer.Typer(no_args_is_help=True, help="People who answer the questions that models get.")


@app.callback()
def human() -> None:
    """People who answer the questions that models get."""


@app.command(no_args_is_help=True)
def form(
    domain: Annotated[str, typer.Option(help=DOMAIN_HELP)],
    ability: OfAbility,
    out: Annotated[Path, typer.Option(metavar="FILE", help="The page to write.")],
    tasks: Annotated[
        str, typer.Option(help="Only these tasks, in this order: ids separated by commas.")
    ] = "",
    sample: Annotated[int | None, typer.Option(min=1, help="So many of them, drawn at random.")] = None,
    seed: Annotated[int, typer.Option(help="Which ones --sample draws.")] = 0,
    prompt_set: Annotated[PromptSet, typer.Option("--set", help="Which prompts.")] = PromptSet.OFFICIAL,
    prompts: Annotated[Path | None, typer.Option(help="A folder with prompts of your own.")] = None,
    as_json: AsJson = False,
    data: DataFolder = None,
) -> None:
    """Write a page on which a person answers questions exactly as models get them; it sends nothing.

    The person saves a response file, which eai score takes like a model's (with --allow-missing, because the
    other tasks were not asked), and eai compare sets beside a model's records on the same tasks.

    Example: eai human form --domain mybench:toy --ability action_sequencing --sample 10 --out form.html
    """
    with data_progress() as report:
        benchmark, source = find_benchmark(domain), Source(store(data), report)
        asked = Library(prompt_set, prompts, source).open(benchmark, ability)
    named = listed(tasks) or list(asked)
    for task_id in named:
        if task_id not in asked:
            raise InputError(f"--tasks: {task_id!r} is not a task of {benchmark.name} {ability.value}")
    draw = Random(seed)  # noqa: S311 - a sample, not a secret
    drawn = set(named if sample is None else draw.sample(named, min(sample, len(named))))
    chosen = {task_id: asked[task_id] for task_id in dict.fromkeys(named) if task_id in drawn}
    page = form_html(benchmark, ability, chosen, source)
    write_whole({out: page})
    made: Json = {"file": str(out), "questions": len(chosen)}
    tell(f"{counted(len(chosen), 'question')}; written to {out}", value=made, as_json=as_json)
