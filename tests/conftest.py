"""Fixtures and hooks for all tests: the real data sets, public verdicts, a browser, memory limits."""

from __future__ import annotations

import gc
import os
import signal
import tempfile
from collections import Counter
from collections.abc import Generator, Iterator, Mapping
from typing import TYPE_CHECKING, Any

import pytest
from hypothesis import settings

from benchmarks.published import index, packs, store, wheel
from browsing import quiet_page, started_browser
from command_line import eai
from eai.base.errors import DataError
from eai.base.store import FOLDER_VARIABLE, DataPackStore
from eai.benchmarks.packs import fetch_packs, find_packs
from eai.benchmarks.registry import list_paper_benchmarks
from eai.results.collector import reduce_garbage_collection
from eai.tasks.source import Source
from memory_limits import (
    free_memory,
    is_memory_to_be_freed,
    limit_writable_memory,
    pytest_runtest_call,
    pytest_runtest_setup,
)
from oracle import DETAIL, Oracle, read_oracle
from sweeps import FEW, THOROUGH

if TYPE_CHECKING:
    from eai.benchmarks.behavior.tasks import BehaviorTasks
    from eai.benchmarks.virtualhome.tasks import VirtualHomeTasks

__all__ = ["eai", "index", "packs", "pytest_runtest_call", "pytest_runtest_setup", "store", "wheel"]
"""The command line, the fixtures of the made-up data set, and the hooks that measure each test's memory."""

settings.register_profile("few", deadline=None, derandomize=True, max_examples=FEW)
settings.register_profile("thorough", deadline=None, derandomize=True, max_examples=THOROUGH)
settings.load_profile("few")  # the option --hypothesis-profile is applied later and overrides this


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the option that shows whether a test needs data which another test has fetched."""
    parser.addoption(
        "--empty-store", action="store_true", help="give each worker an empty data store of its own"
    )


def pytest_configure(config: pytest.Config) -> None:
    """Prepare this process, and so all that the tests start: interrupts, memory, the data store."""
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # in background jobs of a shell
        signal.signal(signal.SIGINT, signal.default_int_handler)
    limit_writable_memory()
    if config.getoption("--empty-store"):
        empty = tempfile.TemporaryDirectory(prefix="eai-store-")
        config.add_cleanup(empty.cleanup)
        os.environ[FOLDER_VARIABLE] = empty.name


_PAPER = "of the paper"
"""Name of the paper's data set in the reason of a test that is skipped without it."""

_BEHAVIOR_1K = "behavior_1k"
"""Name of BEHAVIOR-1K's data set in the reason of a test that is skipped without it."""


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """Switch garbage collection off during collection: modules and tests live as long as the process."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.enable()
        reduce_garbage_collection()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_teardown(
    item: pytest.Item, nextitem: pytest.Item | None
) -> Generator[None, object, object]:
    """Collect garbage after each module, and free the memory of a large process when it has grown.

    Collect it also after a test that ignores warnings: then warnings of unclosed files are not attributed to
    the next test.
    """
    outcome = yield
    is_last_of_module = nextitem is None or nextitem.path != item.path
    if is_memory_to_be_freed():
        free_memory()
    elif is_last_of_module or any("ignore" in mark.args for mark in item.iter_markers("filterwarnings")):
        gc.collect()
    return outcome


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Write how many tests were skipped for each reason at the very end of the output, where it is seen."""
    places = (report.longrepr for report in terminalreporter.getreports("skipped"))
    reasons = Counter(
        str(place[2]).removeprefix("Skipped: ").partition(DETAIL)[0]
        for place in places
        if isinstance(place, tuple)
    )
    if reasons:
        terminalreporter.section("NOT TESTED", yellow=True, bold=True)
    for reason, times in reasons.most_common():
        terminalreporter.write_line(f"{times:5} {reason}")


@pytest.fixture(scope="session", autouse=True)
def fetch_errors() -> Mapping[str, DataError]:
    """Fetch all data into the user's default folder, if it is not there; return the errors by data set.

    This comes before the first test, so that no test finds only the data that another one needed.
    """
    errors = {}
    for name, wanted in ((_PAPER, find_packs(list_paper_benchmarks())), (_BEHAVIOR_1K, find_packs())):
        try:
            fetch_packs(packs=wanted)
        except DataError as error:
            errors[name] = error
    return errors


@pytest.fixture(scope="session")
def data_store(fetch_errors: Mapping[str, DataError]) -> DataPackStore:
    """Return the user's default folder with the paper's data set."""
    return _store_with(_PAPER, fetch_errors)


@pytest.fixture(scope="session")
def activity_store(fetch_errors: Mapping[str, DataError]) -> DataPackStore:
    """Return the user's default folder with BEHAVIOR-1K's activities."""
    return _store_with(_BEHAVIOR_1K, fetch_errors)


def _store_with(name: str, fetch_errors: Mapping[str, DataError]) -> DataPackStore:
    if name in fetch_errors:
        pytest.skip(f"the data set {name} cannot be had: {fetch_errors[name]}")
    return DataPackStore()


@pytest.fixture(scope="session")
def virtualhome_tasks(data_store: DataPackStore) -> VirtualHomeTasks:
    """Return the real VirtualHome tasks."""
    from eai.benchmarks.virtualhome.tasks import open_tasks

    return open_tasks(Source(data_store))


@pytest.fixture(scope="session")
def behavior_tasks(data_store: DataPackStore) -> BehaviorTasks:
    """Return the real BEHAVIOR tasks."""
    from eai.benchmarks.behavior.tasks import open_tasks

    return open_tasks(Source(data_store))


@pytest.fixture(scope="session")
def oracle() -> Oracle:
    """Return a function that reads a file of the reference package's verdicts, or skips the test."""
    return read_oracle


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    """Yield a real browser for the tests of a module."""
    with started_browser() as started:
        yield started


@pytest.fixture
def page(browser: Any) -> Iterator[Any]:
    """Yield a page of the browser that fails the test on any error."""
    with quiet_page(browser) as opened:
        yield opened
