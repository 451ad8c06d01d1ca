from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from eai.data.store import Store

FUZZ = Path(__file__).resolve().parents[2] / "bench" / "fuzz.py"


def test_every_hostile_answer_has_one_verdict(data_store: Store) -> None:
    run = subprocess.run(
        [sys.executable, FUZZ, "--rows", "25", "--seed", "5"], capture_output=True, text=True
    )
    assert run.returncode == 0, run.stdout + run.stderr
    assert run.stdout.count("25 answers, 0 wrong") == 16
