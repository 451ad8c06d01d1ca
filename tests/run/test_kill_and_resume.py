from __future__ import annotations

import json
import subprocess
import sys

import pytest

from by_path import ROOT
from eai.base.store import DataPackStore
from sweeps import swept


@pytest.mark.skipif(sys.platform == "win32", reason="forks")
@pytest.mark.parametrize("kind", ["plain", *swept("replanning", "pipeline", "acting")])
def test_a_run_killed_again_and_again_gets_the_same_results(data_store: DataPackStore, kind: str) -> None:
    program = [sys.executable, "-m", "bench", "kill_and_resume"]
    options = ["--kills", "2", "--tasks", "6", "--kind", kind]
    done = subprocess.run([*program, *options], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert (found["kills"] >= 2, found["lost"], found["doubled"], found["differing"]) == (True, 0, 0, 0)
