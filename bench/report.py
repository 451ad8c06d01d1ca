"""Measure processor time and memory of `eai report` for many models, and the explorer's size.

    python -m bench report RECORDS [--models 18]

RECORDS is a folder with the records of one model, preferably of all eight suites, with explanations. Each
run is copied under as many names as there are models; then `eai report --paper` runs on the copies.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

from bench.record import add_write_option, write_figures
from eai.results.records import RECORDS
from eai.results.runs import find_record_files


def main() -> None:
    """Copy the records, make the report, and print its cost."""
    options = read_report_options(__doc__)
    with tempfile.TemporaryDirectory() as folder:
        runs, out = Path(folder, "runs"), Path(folder, "out")
        count = sum(copy_records_for_models(file, runs / str(i), options.models)
                    for i, file in enumerate(find_record_files([options.records])))  # fmt: skip
        command = [sys.executable, "-c", "from eai.cli import main; main()"]
        subprocess.run([*command, "report", str(runs), "--out", str(out), "--paper"], check=True)
        used = resource.getrusage(resource.RUSAGE_CHILDREN)
        size = (out / "explorer.html").stat().st_size
    seconds, memory = used.ru_utime + used.ru_stime, used.ru_maxrss / 1024
    print(f"{count} answers: {seconds:.1f} CPU s, {memory:.0f} MB, explorer {size / 1e6:.1f} MB")
    if options.write:
        cost = f"{seconds:.1f} s, {memory:.0f} MB, {count:,} answers"
        write_figures("report", {"CPU time, memory and answers of one report": cost})


def read_report_options(docstring: str) -> argparse.Namespace:
    """Return the options RECORDS, `--models` and `--write` of a program, given its docstring."""
    arguments = argparse.ArgumentParser(description=docstring.split("\n")[0])
    arguments.add_argument("records", type=Path)
    arguments.add_argument("--models", type=int, default=18)
    add_write_option(arguments)
    return arguments.parse_args()


def copy_records_for_models(file: Path, folder: Path, models: int) -> int:
    """Write the records of a file under many model names, and return the number of records written."""
    records = [json.loads(line) for line in file.read_text(encoding="utf-8").splitlines()]
    for number in range(models):
        place = folder / f"model-{number:02}"
        place.mkdir(parents=True)
        lines = (json.dumps({**record, "model": place.name}) for record in records)
        (place / RECORDS).write_text("\n".join(lines) + "\n", encoding="utf-8")
    return models * len(records)
