"""Measure the explorer of many models: its size, the memory to write it, and its opening in Chromium.

    python -m bench explorer RECORDS [--models 100]

RECORDS is a folder with the records of one or more models in the same suites, with explanations. The runs of
each suite are added in turn, under as many names as there are models.
"""

from __future__ import annotations

import json
import resource
import shutil
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from itertools import cycle, islice
from pathlib import Path
from statistics import median

from bench.record import write_rows
from bench.report import read_report_options
from eai.base.files import write_files_atomically
from eai.base.grouping import group_pairs
from eai.base.store import DataPackStore
from eai.cli.report import read_domain_data_for_explorer_page
from eai.results.runs import find_record_files, read_runs
from eai.studies.report.explorer import DomainDataOfExplorerPage, ExplorerPageData, build_explorer_page

_OPENINGS = 5
_WATCH_FOR_FIRST_ANSWER = """
const look = () => requestAnimationFrame(() => {
  const shown = document.querySelector('.row') && document.querySelector('.verdict-box');
  if (shown) window.opened = performance.now();
  else look();
});
look();
"""
"""Script that notes the time, in milliseconds, at which the page shows the list and the first answer."""


def main() -> None:
    """Write the explorer, open it, and print its cost."""
    options = read_report_options(__doc__)
    with tempfile.TemporaryDirectory() as folder:
        page = Path(folder, "explorer.html")
        background = partial(
            read_domain_data_for_explorer_page,
            DataPackStore(),
            {},
            Path(folder),
            prompts=True,
            pictures=False,
        )
        count = write_explorer(options.records, options.models, page, background)
        used = resource.getrusage(resource.RUSAGE_SELF)
        size = page.stat().st_size
        opened, opened_cpu = measure_opening(page)
    seconds, memory = used.ru_utime + used.ru_stime, used.ru_maxrss / 1024
    row = (
        *(str(options.models), round(size / 1e6, 1), round(size / count)),
        *(round(seconds), round(memory), round(opened_cpu, 1)),
    )
    print("models, MB, bytes/answer, CPU s, MB of memory, CPU s to open:", *row)
    print(f"{count:,} answers, opened in {opened:.1f} s")
    if options.write:
        write_rows("report", [row])


def write_explorer(
    records: Path, models: int, page: Path, background: Callable[[str], DomainDataOfExplorerPage]
) -> int:
    """Write the explorer of runs under new names, and return the number of answers."""
    data, count = ExplorerPageData(background), 0
    files = group_pairs((read_suite(file), file) for file in find_record_files([records]))
    for of_suite in files.values():
        for number, file in enumerate(islice(cycle(of_suite), models)):
            (run,) = read_runs([file])
            data.add_run(replace(run, key=run.key._replace(model=f"model-{number:03}")))
            count += len(run.records)
    write_files_atomically({page: build_explorer_page(data.format_data_as_base64_lines())})
    return count


def read_suite(file: Path) -> Sequence[str]:
    """Return protocol, domain and ability of a file's first record."""
    with file.open(encoding="utf-8") as lines:
        record = json.loads(next(lines))
    return record["protocol"], record["domain"], record["ability"]


def measure_opening(page: Path) -> tuple[float, float]:
    """Return the seconds until Chromium shows the first answer, and the processor seconds of the page.

    Both are medians.
    """
    from playwright.sync_api import sync_playwright

    times: list[tuple[float, float]] = []
    with sync_playwright() as driver:
        for _ in range(_OPENINGS):
            browser = driver.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
            opened = browser.new_page()
            opened.add_init_script(_WATCH_FOR_FIRST_ANSWER)
            opened.goto(page.as_uri())
            opened.locator(".verdict-box").wait_for()
            processes = browser.new_browser_cdp_session().send("SystemInfo.getProcessInfo")["processInfo"]
            used = max(process["cpuTime"] for process in processes if process["type"] == "renderer")
            opened.wait_for_timeout(200)
            times.append((opened.evaluate("window.opened") / 1000, used))
            browser.close()
    seconds, used_seconds = zip(*times, strict=True)
    return median(seconds), median(used_seconds)


if __name__ == "__main__":
    main()
