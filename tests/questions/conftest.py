from __future__ import annotations

from pathlib import Path

import pytest

from eai.benchmark.benchmark import Benchmark
from eai.benchmark.registry import find_benchmark

LAMPS = Path(__file__).parents[2] / "examples" / "lamps"


@pytest.fixture
def lamps(monkeypatch: pytest.MonkeyPatch) -> Benchmark:
    """The example of a world of one's own."""
    monkeypatch.chdir(LAMPS)
    return find_benchmark("lamps:lamps")
