from __future__ import annotations

import pytest

from by_path import ROOT
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.registry import find_benchmark

LAMPS = ROOT / "examples" / "lamps"


@pytest.fixture
def lamps(monkeypatch: pytest.MonkeyPatch) -> Benchmark:
    """Return the example benchmark of the documentation."""
    monkeypatch.chdir(LAMPS)
    return find_benchmark("lamps:lamps")
