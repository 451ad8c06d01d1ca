"""``eai export submission``: write and check files of the challenge."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from eai.cli import options
from eai.cli.console import say, tell_findings
from eai.cli.options import AsJson, DataFolder, flag
from eai.extensions.board.submission import build_submission, check_submission


def submission(
    run: Path,
    out: Annotated[Path, flag(metavar="FILE")] = Path("submission.zip"),
    model: str | None = None,
    folder: Annotated[str | None, flag(metavar="NAME")] = None,
    prompts: Path | None = None,
    as_json: AsJson = False,
    data: DataFolder = None,
) -> None:
    """Put a model's answers to all suites into the zip of the challenge, and check it.

    Every missing, repeated, unknown or empty row is named; exit status 2 if there is one.

    Example: eai export submission runs --out submission.zip

    Options:
        run: The folder of a run, as eai run writes it; or a zip, which is only checked.
        out: The zip to write.
        model: The model's folder in the run, where there are several.
        folder: A folder for the files in the zip.
        prompts: The prompts of a phase (llm_prompts/ of its starter kit), instead of the data set's.
    """
    path = run
    if run.is_dir():
        build_submission(run, out, options.store(data), model=model, folder=folder, prompts=prompts)
        path = out
        if not as_json:
            say(f"written to {out}")
    tell_findings(
        check_submission(path, options.store(data), prompts), "the submission is complete", as_json=as_json
    )
