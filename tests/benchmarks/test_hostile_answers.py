from __future__ import annotations

import subprocess
import sys

import pytest

from by_path import ROOT
from eai.abilities.protocol import PAPER_ABILITIES
from eai.base.store import DataPackStore
from protocols import PROTOCOLS
from sweeps import swept


@pytest.mark.parametrize("rows", [8, *swept(25)])
def test_every_hostile_answer_has_one_verdict(data_store: DataPackStore, rows: int) -> None:
    command = [sys.executable, "-m", "bench", "fuzz", "--rows", str(rows), "--seed", "5"]
    run = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert run.returncode == 0, run.stdout + run.stderr
    assert run.stdout.count(f"{rows} answers, 0 wrong") == 2 * len(PROTOCOLS) * len(PAPER_ABILITIES)
