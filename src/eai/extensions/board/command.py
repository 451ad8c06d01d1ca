"""Commands that publish results and tasks: leaderboards, submissions to a challenge, metadata files."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from eai.base.errors import InputError
from eai.base.files import raise_write_errors_as_input_errors, write_files_atomically
from eai.base.json_value import Json
from eai.benchmarks.registry import find_benchmark, list_paper_benchmarks
from eai.cli import options
from eai.cli.console import (
    DOMAIN_HELP,
    format_count,
    print_findings_and_exit,
    print_note,
    print_result,
    print_result_line,
)
from eai.cli.options import RECORDS, AsJson, DataFolder, make_flag, open_data_source
from eai.extensions.board.submission import build_submission, check_submission

BOARD_FILE = "index.html"
"""Name of the file with the page of a leaderboard."""


def submission(
    run: Path,
    out: Annotated[Path, make_flag(metavar="FILE")] = Path("submission.zip"),
    model: str | None = None,
    folder: Annotated[str | None, make_flag(metavar="NAME")] = None,
    prompts: Path | None = None,
    as_json: AsJson = False,
    data: DataFolder = None,
) -> None:
    """Put a model's answers to all suites into the zip of the challenge, and check it.

    Every missing, repeated, unknown or empty row is reported; exit status 2 if there is one.

    Example: eai export submission runs --out submission.zip

    Options:
        run: The folder of a run, as eai run writes it; or a zip, which is only checked.
        out: The zip to write.
        model: The model's folder in the run, if there are several.
        folder: A folder for the files in the zip.
        prompts: Folder with a challenge phase's prompts (llm_prompts/ of the starter kit); default: the data
            set's.
    """
    path = run
    if run.is_dir():
        build_submission(run, out, options.open_store(data), model=model, folder=folder, prompts=prompts)
        path = out
        if not as_json:
            print_result_line(f"written to {out}")
    print_findings_and_exit(
        check_submission(path, options.open_store(data), prompts),
        "the submission is complete",
        as_json=as_json,
    )


def board(
    submissions: Annotated[list[Path], typer.Argument(metavar="SUBMISSIONS")],
    out: Annotated[Path, make_flag(metavar="DIR")],
    as_json: AsJson = False,
    data: DataFolder = None,
) -> None:
    """Score submissions, and write a page that ranks them.

    A season is a folder of generated tasks that submissions may answer too. Numbers in a submission are
    ignored (docs/extensions/board).

    Example: eai board submissions --out site

    Options:
        submissions: Folders or zips of submissions, folders of seasons, or folders that contain these.
        out: The folder of the page.
    """
    from eai.extensions.board.page import build_page_and_count_submissions

    with open_data_source(data) as source:
        page, number = build_page_and_count_submissions(
            submissions, source, report_submission=lambda name: print_note(f"scoring {name}")
        )
    with raise_write_errors_as_input_errors(out):
        write_files_atomically({out / BOARD_FILE: page})
    made: Json = {"folder": str(out), "submissions": number}
    print_result(f"{format_count(number, 'submission')} in {out / BOARD_FILE}", value=made, as_json=as_json)


def results(
    records: Annotated[list[Path], typer.Argument(help=RECORDS)],
    about: Annotated[Path, make_flag(metavar="FILE")],
    out: Path = Path("published"),
    as_json: AsJson = False,
) -> None:
    """Write results of runs for Every Eval Ever and Hugging Face.

    Only results of the named models for whole suites are written.

    Example: eai export results runs --about publish.toml

    Options:
        about: TOML file that names the models and the publisher of their results.
        out: The folder to write to.
    """
    from eai.extensions.board.publication import make_files_to_publish
    from eai.results.runs import read_runs
    from eai.studies.report.run_summary import summarize_run

    summaries = sorted(map(summarize_run, read_runs(records)), key=lambda summary: summary.key.sort_key)
    files = make_files_to_publish(about, summaries)
    if not files:
        raise InputError(
            f"{about}: no model named in this file answered all tasks of a suite in the given records; "
            "give records of complete runs, or name the models of these records in this file"
        )
    with raise_write_errors_as_input_errors(out):
        write_files_atomically({out / name: content for name, content in files.items()})
    made: Json = {"folder": str(out), "files": [*files]}
    print_result(f"{format_count(len(files), 'file')} written to {out}", value=made, as_json=as_json)


def croissant(
    out: Path = Path("croissant"),
    domain: Annotated[
        list[str] | None, make_flag(help=f"{DOMAIN_HELP} The paper's two if not given.")
    ] = None,
    as_json: AsJson = False,
    data: DataFolder = None,
) -> None:
    """Write tasks and gold operators with Croissant metadata (extra 'croissant').

    Example: eai export croissant --domain behavior

    Options:
        out: The folder to write to.
    """
    from eai.extensions.board.croissant import write_croissant_files

    with open_data_source(data) as source:
        files = write_croissant_files(
            [find_benchmark(name) for name in domain or list_paper_benchmarks()], source, out
        )
    made: Json = {"folder": str(out), "files": [*map(str, files)]}
    print_result(f"{format_count(len(files), 'file')} written to {out}", value=made, as_json=as_json)
