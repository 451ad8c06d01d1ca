from __future__ import annotations

import pytest

from by_path import ROOT
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.registry import find_benchmark


@pytest.fixture
def lamps(monkeypatch: pytest.MonkeyPatch) -> Benchmark:
    """The benchmark of the examples: a declaration and two tasks."""
    monkeypatch.syspath_prepend(ROOT / "examples" / "lamps")
    return find_benchmark("lamps:lamps")
