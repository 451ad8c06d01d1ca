"""Shared by the tests of several packages: the real data set and the reference's verdicts."""

from __future__ import annotations

import gc
import signal
from collections import Counter
from collections.abc import Generator, Iterator
from typing import TYPE_CHECKING, Any

import pytest
from hypothesis import settings

from browsing import quiet_page, started_browser
from eai.data.dataset import fetch
from eai.data.store import Store
from eai.errors import DataError
from eai.households.packs import published_packs
from eai.scoring.collector import collect_seldom
from eai.tasks.source import Source
from households.published import index, packs, store, wheel
from oracle import Oracle, read_oracle
from sweeps import FEW, THOROUGH

if TYPE_CHECKING:
    from eai.households.behavior.tasks import BehaviorTasks
    from eai.households.virtualhome.tasks import VirtualHomeTasks

__all__ = ["index", "packs", "store", "wheel"]
"""The fixtures of the made-up data set."""

settings.register_profile("few", deadline=None, derandomize=True, max_examples=FEW)
settings.register_profile("thorough", deadline=None, derandomize=True, max_examples=THOROUGH)
settings.load_profile("few")  # --hypothesis-profile comes after


def pytest_configure() -> None:
    """What a shell starts in the background ignores interrupts, and so would all that the tests start."""
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """Modules and tests stay as long as the process does, and the collector need not look through them."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.enable()
        collect_seldom()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_teardown(item: pytest.Item) -> Generator[None, object, object]:
    """Where warnings are none of ours, what is left unclosed is collected now: no other test is to blame."""
    outcome = yield
    if any("ignore" in mark.args for mark in item.iter_markers("filterwarnings")):
        gc.collect()
    return outcome


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """What was not tested and why, at the very end, where nobody overlooks it."""
    told = (report.longrepr for report in terminalreporter.getreports("skipped"))
    reasons = Counter(str(each[2]).removeprefix("Skipped: ") for each in told if isinstance(each, tuple))
    if reasons:
        terminalreporter.section("NOT TESTED", yellow=True, bold=True)
    for reason, times in reasons.most_common():
        terminalreporter.write_line(f"{times:5} {reason}")


@pytest.fixture(scope="session")
def data_store() -> Store:
    """The real data set in the user's default folder, fetched once if it is not there."""
    store = Store()
    try:
        fetch(store, packs=published_packs())
    except DataError as error:
        pytest.skip(f"the data set cannot be had: {error}")
    return store


@pytest.fixture(scope="session")
def virtualhome_tasks(data_store: Store) -> VirtualHomeTasks:
    """The real VirtualHome tasks."""
    from eai.households.virtualhome.tasks import open_tasks

    return open_tasks(Source(data_store))


@pytest.fixture(scope="session")
def behavior_tasks(data_store: Store) -> BehaviorTasks:
    """The real BEHAVIOR tasks."""
    from eai.households.behavior.tasks import open_tasks

    return open_tasks(Source(data_store))


@pytest.fixture(scope="session")
def oracle() -> Oracle:
    """Reads one file of the reference's verdicts; skips where the file is not on this machine."""
    return read_oracle


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    """A real browser, for the tests of a module."""
    with started_browser() as started:
        yield started


@pytest.fixture
def page(browser: Any) -> Iterator[Any]:
    """A page of it on which nothing may go wrong."""
    with quiet_page(browser) as opened:
        yield opened
