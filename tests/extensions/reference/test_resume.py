from __future__ import annotations

import json
from pathlib import Path

import pytest
from inspect_ai.log import read_eval_log

from eai.base.store import DataPackStore
from processes import eai
from sweeps import sweep


@sweep
def test_scores_under_another_protocol_replace_those_in_the_log(
    data_store: DataPackStore, tmp_path: Path
) -> None:
    arguments = "run --model eai/noisy -M rate=0.5 --domain virtualhome --ability action_sequencing --json"
    numbers = []
    for protocol in ("strict", "eai-1.0.5"):
        done = eai(*arguments.split(), "--limit", 6, "--protocol", protocol, "--out", tmp_path)
        assert done.status == 0, done.err
        (path,) = (tmp_path / "logs").glob("*.eval")
        log = read_eval_log(path)
        assert log.results is not None
        assert log.eval.scorers is not None
        assert (log.eval.scorers[0].options or {})["protocol"] == protocol
        metrics = json.loads(done.out)[0]["metrics"]
        number = log.results.scores[-1].metrics["task_success"].value
        assert 100 * number == pytest.approx(metrics["task_success"]["value"])
        numbers.append((number, log.results.scores[-1].scored_samples))
    assert numbers[0] != numbers[1]
