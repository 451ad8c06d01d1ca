"""A pytest plugin that comes to a failure soon: quick tests first, and first of all what has failed before.

What tests have taken and how often they failed is kept in the file that ``QUICK_FIRST`` names. Of all tests
so many run as fit into the CPU seconds of ``QUICK_SECONDS``, where that is set.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

UNKNOWN, LEAST = 0.5, 0.02
"""CPU seconds that are expected of a test that never ran, and added to those of each."""

FAILURE = 20
"""How much earlier a test comes for every time that it failed."""


class QuickFirst:
    """The order of tests, and what becomes of them.

    Attributes:
        file: where it is kept.
        seconds: CPU seconds for all.
        first: the beginnings of the names of tests that come first where others are as quick.
    """

    def __init__(self, file: Path, seconds: float | None, first: tuple[str, ...]) -> None:
        self.file, self.seconds, self.first = file, seconds, first
        kept = json.loads(file.read_text(encoding="utf-8")) if file.exists() else {}
        self.took: dict[str, float] = kept.get("took", {})
        self.failed: dict[str, int] = kept.get("failed", {})

    def expected(self, name: str) -> float:
        """The CPU seconds that a test takes, as far as is known."""
        return self.took.get(name, UNKNOWN)

    def price(self, name: str) -> float:
        """What decides the order: a test's time, less where it is likely to fail."""
        near = 2 if name.startswith(self.first) else 1
        return (self.expected(name) + LEAST) / (near * (1 + FAILURE * self.failed.get(name, 0)))

    def chosen(self, names: list[str]) -> list[str]:
        """The tests that run, in order."""
        total, found = 0.0, []
        for name in sorted(names, key=self.price):
            total += self.expected(name)
            if self.seconds is None or not found or total <= self.seconds:
                found.append(name)
        return found

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        by_name = {item.nodeid: item for item in items}
        items[:] = [by_name[name] for name in self.chosen(list(by_name))]

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Iterator[Any]:
        before, failures = _spent(), self.failed.get(item.nodeid)
        done = yield
        if self.failed.get(item.nodeid) == failures:  # the first one to run pays for what all share
            took = round(_spent() - before, 3)
            self.took[item.nodeid] = min(took, self.took.get(item.nodeid, took))
        return done

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.failed:
            self.failed[report.nodeid] = self.failed.get(report.nodeid, 0) + 1

    def pytest_sessionfinish(self) -> None:
        self.file.write_text(json.dumps({"took": self.took, "failed": self.failed}), encoding="utf-8")


def _spent() -> float:
    """CPU seconds of this process and of those that it waited for."""
    spent = os.times()
    return spent.user + spent.system + spent.children_user + spent.children_system


def pytest_configure(config: pytest.Config) -> None:
    """Take part where the environment says how."""
    if "QUICK_FIRST" in os.environ:
        seconds = os.environ.get("QUICK_SECONDS")
        first = tuple(filter(None, os.environ.get("QUICK_NEAR", "").split(os.pathsep)))
        order = QuickFirst(Path(os.environ["QUICK_FIRST"]), float(seconds) if seconds else None, first)
        config.pluginmanager.register(order)
