"""``eai export harbor``: write tasks as folders for Harbor."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from eai.base.json_value import Json
from eai.benchmarks.prompt_library import PromptLibrary
from eai.benchmarks.suite import open_suite
from eai.cli import options
from eai.cli.console import format_count, print_result
from eai.cli.options import AsJson, DataFolder, make_flag, open_data_source
from eai.cli.prompts import OfSet, Sample, SampleSeed, TaskIds, select_entries_of_tasks


def harbor(
    domain: options.OfDomain,
    ability: options.OfAbility,
    out: Annotated[Path, make_flag(metavar="DIR")],
    tasks: TaskIds = "",
    sample: Sample = None,
    seed: SampleSeed = 0,
    wheel: Annotated[list[Path] | None, make_flag(metavar="FILE")] = None,
    verifier_image: Annotated[str | None, make_flag(metavar="REF")] = None,
    image: Annotated[str | None, make_flag(metavar="REF")] = None,
    shared: bool = False,
    prompt_set: OfSet = "official",
    as_json: AsJson = False,
    data: DataFolder = None,
) -> None:
    """Write tasks as folders for Harbor, and the folder of the image that scores answers.

    An agent writes its answer to a file. In acting, it calls tools or the command act. Before the first run:
    docker build -t eai-worlds:VERSION DIR/image. docs/extensions/harbor lists programs that
    read the folders.

    Example: eai export harbor --domain virtualhome --ability acting --sample 20 --out harbor

    Options:
        out: A new folder for the tasks.
        wheel: Install eai and the package of a benchmark from this file.
        verifier_image: The image built from DIR/image, for programs that build none.
        image: The image of the agent's container, for programs that build none.
        shared: Score in the agent's container, for programs without a second one.
    """
    # imported only here, because the module loads libraries of games
    from eai.extensions.harbor.folders import IMAGE, write_task_folders

    with open_data_source(data) as source:
        suite = open_suite(domain, ability, source=source)
        prompts = PromptLibrary(prompt_set, None, source).open(suite.benchmark, ability)
        asked = select_entries_of_tasks(prompts, tasks, sample, seed, f"{suite.domain} {ability}")
        written, left_out = write_task_folders(
            suite,
            asked,
            out,
            wheels=wheel or (),
            image=image,
            verifier_image=verifier_image,
            is_shared=shared,
        )
    lines = [f"left out: {format_count(n, 'task')} {why}" for why, n in left_out.items()]
    if not shared:
        lines.append(f"build the image that scores answers from {out / IMAGE}")
    made: dict[str, Json] = {"path": str(out), "tasks": written}
    made["left_out"] = {**left_out}
    print_result(f"{format_count(written, 'task')} written to {out}", *lines, value=made, as_json=as_json)
