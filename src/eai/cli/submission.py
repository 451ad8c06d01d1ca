"""``eai export submission``: the challenge's files, the answers to eight suites in a zip."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from eai.cli.console import say, tell_findings
from eai.cli.options import AsJson
from eai.cli.store import DataFolder, store
from eai.households.submission import build_submission, check_submission

Phase = Annotated[
    Path | None,
    typer.Option(
        "--prompts",
        help="The prompts of a phase (llm_prompts/ of its starter kit), instead of the data set's.",
    ),
]

COMPLETE = "the submission is complete"
"""What there is to say of one in which nothing is wrong."""


def submission(
    run: Annotated[
        Path,
        typer.Argument(help="The folder of a run, as eai run writes it; or a zip, which is only checked."),
    ],
    out: Annotated[Path, typer.Option(metavar="FILE", help="The zip to write.")] = Path("submission.zip"),
    model: Annotated[
        str | None, typer.Option(help="The model's folder in the run, where there are several.")
    ] = None,
    folder: Annotated[
        str | None, typer.Option(metavar="NAME", help="A folder for the files in the zip.")
    ] = None,
    prompts: Phase = None,
    as_json: AsJson = False,
    data: DataFolder = None,
) -> None:
    """Put a model's answers to all suites into the zip of the challenge, and check it.

    Every missing, repeated, unknown or empty row is named; exit status 2 if there is one.

    Example: eai export submission runs --out submission.zip
    """
    path = run
    if run.is_dir():
        build_submission(run, out, store(data), model=model, folder=folder, prompts=prompts)
        path = out
        if not as_json:
            say(f"written to {out}")
    tell_findings(check_submission(path, store(data), prompts), COMPLETE, as_json=as_json)
