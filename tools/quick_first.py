"""A pytest plugin that finds a failure soon: tests that failed before and quick tests run first.

The environment variable ``QUICK_FIRST`` names the file that keeps times and failures of tests. If
``QUICK_SECONDS`` is set, only tests that fit into this number of CPU seconds run.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

DEFAULT_SECONDS = 0.5
"""Expected CPU seconds of a test that never ran."""

OVERHEAD_SECONDS = 0.02
"""CPU seconds that are added to the time of each test."""

FAILURE_WEIGHT = 20
"""Weight of one former failure in the order of tests."""


class QuickFirst:
    """Orders tests, and records their times and failures.

    Attributes:
        file: File that keeps times and failures.
        seconds: CPU seconds for all tests; None for no limit.
        first: Beginnings of test names. Such tests run before other tests that are as quick.
    """

    def __init__(self, file: Path, seconds: float | None, first: tuple[str, ...]) -> None:
        self.file, self.seconds, self.first = file, seconds, first
        history = json.loads(file.read_text(encoding="utf-8")) if file.exists() else {}
        self.took: dict[str, float] = history.get("took", {})
        self.failed: dict[str, int] = history.get("failed", {})

    def expect_seconds(self, name: str) -> float:
        """Return the CPU seconds that a test took, or the default if it never ran."""
        return self.took.get(name, DEFAULT_SECONDS)

    def price(self, name: str) -> float:
        """Return the sort key of a test: its time, divided by its weight if it failed before."""
        weight = 2 if name.startswith(self.first) else 1
        weight *= 1 + FAILURE_WEIGHT * self.failed.get(name, 0)
        return (self.expect_seconds(name) + OVERHEAD_SECONDS) / weight

    def choose(self, names: list[str]) -> list[str]:
        """Return the tests that run, in order: at least one, and the rest within the time limit."""
        total, tests = 0.0, list[str]()
        for name in sorted(names, key=self.price):
            total += self.expect_seconds(name)
            if self.seconds is None or not tests or total <= self.seconds:
                tests.append(name)
        return tests

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        by_name = {item.nodeid: item for item in items}
        items[:] = [by_name[name] for name in self.choose(list(by_name))]

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Iterator[Any]:
        before, failures = _read_cpu_seconds(), self.failed.get(item.nodeid)
        done = yield
        if self.failed.get(item.nodeid) == failures:  # the first test also pays for shared fixtures
            took = round(_read_cpu_seconds() - before, 3)
            self.took[item.nodeid] = min(took, self.took.get(item.nodeid, took))
        return done

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.failed:
            self.failed[report.nodeid] = self.failed.get(report.nodeid, 0) + 1

    def pytest_sessionfinish(self) -> None:
        self.file.write_text(json.dumps({"took": self.took, "failed": self.failed}), encoding="utf-8")


def _read_cpu_seconds() -> float:
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system


def pytest_configure(config: pytest.Config) -> None:
    """Register the plugin if the environment variable QUICK_FIRST is set."""
    if "QUICK_FIRST" in os.environ:
        seconds = os.environ.get("QUICK_SECONDS")
        first = tuple(filter(None, os.environ.get("QUICK_NEAR", "").split(os.pathsep)))
        order = QuickFirst(Path(os.environ["QUICK_FIRST"]), float(seconds) if seconds else None, first)
        config.pluginmanager.register(order)
