from __future__ import annotations

from pathlib import Path

import pytest

from eai.benchmark.benchmark import Benchmark
from eai.benchmark.registry import find_benchmark


@pytest.fixture
def lamps(monkeypatch: pytest.MonkeyPatch) -> Benchmark:
    """The benchmark of the examples: a declaration and two tasks."""
    monkeypatch.syspath_prepend(Path(__file__).parents[2] / "examples" / "lamps")
    return find_benchmark("lamps:lamps")
