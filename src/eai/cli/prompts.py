"""``eai prompts``: the prompts of a suite as a file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from eai.benchmark.prompt_library import Library
from eai.benchmark.registry import find_benchmark
from eai.cli.console import DOMAIN_HELP, data_progress, tell
from eai.cli.options import AsJson, Errata, OfAbility
from eai.cli.store import DataFolder, store
from eai.data.files import write_whole
from eai.prompts.prompt import PromptSet, prompt_file, system_file
from eai.studies.pipeline.stage_one import read_believed
from eai.tasks.source import ErrataChoice, Source


def prompts(
    domain: Annotated[str, typer.Option(help=DOMAIN_HELP)],
    ability: OfAbility,
    out: Annotated[Path, typer.Option(metavar="FILE", help="The file to write.")],
    prompt_set: Annotated[
        PromptSet, typer.Option("--set", help="The data set's prompts, or ours.")
    ] = PromptSet.OFFICIAL,
    folder: Annotated[
        Path | None, typer.Option("--prompts", help="A folder with prompts of your own.")
    ] = None,
    goals: Annotated[
        Path | None,
        typer.Option(help="Answers to goal interpretation, whose goals to state instead of the tasks' own."),
    ] = None,
    errata: Errata = ErrataChoice.CURRENT,
    as_json: AsJson = False,
    data: DataFolder = None,
) -> None:
    """Write prompts as a list of {"identifier", "llm_prompt"}; a system message goes to a file beside it.

    Official prompts are the data set's, byte for byte, but for those that ask for something else than is
    scored (docs/errata.md; --errata none leaves them as they are). The system message, where there is one, is
    in FILE with _system before its extension.

    With --goals there are prompts for the tasks that the answers, one model's, are about.

    Example: eai prompts --domain virtualhome --ability action_sequencing --out prompts.json
    """
    with data_progress() as report:
        benchmark, source = find_benchmark(domain), Source(store(data), report, errata=errata)
        whole = prompt_set is PromptSet.OFFICIAL and folder is None and goals is None
        files = benchmark.official_files(ability, source) if whole else None
        if goals is not None:
            believed = read_believed(goals, benchmark, ability, source)
            opened = Library(prompt_set, folder, source).open(benchmark, ability, believed.beliefs)
            opened = {task_id: prompt for task_id, prompt in opened.items() if task_id in believed.beliefs}
            content, system = prompt_file(opened), system_file(opened)
        elif files is not None:
            content, system = files.prompts, files.system
        else:
            opened = Library(prompt_set, folder, source).open(benchmark, ability)
            content, system = prompt_file(opened), system_file(opened)
    beside = out.with_name(f"{out.stem}_system{out.suffix}")
    written = {out: content} if system is None else {out: content, beside: system}
    write_whole(written)
    tell(*(f"written to {path}" for path in written), value={"files": [*map(str, written)]}, as_json=as_json)
