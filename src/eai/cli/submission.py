"""``eai submission``: the challenge's files, the answers to eight suites in a zip."""

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

app = typer.Typer(help="The challenge's files: build them from a run, check them.", no_args_is_help=True)


@app.command()
def build(
    run: Annotated[Path, typer.Argument(help="The folder of a run, as eai run writes it.")],
    out: Annotated[Path, typer.Option(metavar="FILE", help="The zip to write.")],
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
    """Put a model's answers to all suites into a zip, and check it.

    Example: eai submission build runs --out submission.zip
    """
    build_submission(run, out, store(data), model=model, folder=folder, prompts=prompts)
    if not as_json:
        say(f"written to {out}")
    tell_findings(check_submission(out, store(data), prompts), COMPLETE, as_json=as_json)


@app.command()
def check(
    path: Annotated[Path, typer.Argument(help="The zip.", metavar="ZIP")],
    prompts: Phase = None,
    as_json: AsJson = False,
    data: DataFolder = None,
) -> None:
    """Name every missing, repeated, unknown or empty row of a submission; exit status 2 if there is one.

    Example: eai submission check submission.zip
    """
    tell_findings(check_submission(path, store(data), prompts), COMPLETE, as_json=as_json)
