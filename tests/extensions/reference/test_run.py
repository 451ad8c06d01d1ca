from __future__ import annotations

import json
from concurrent.futures import Executor
from pathlib import Path

import pytest
from inspect_ai.log import read_eval_log

from eai.abilities.protocol import Protocol
from eai.base.store import DataPackStore
from eai.results.summary import compute_metric_rates
from run.child import (
    Whom,
    evaluate_in_child,
    run_in_child,
)
from run.test_scorer import PLANS, paper, process, shares, some_tasks

SHARED = (process,)


def test_answers_are_read_together_where_their_form_decides(
    data_store: DataPackStore, process: Executor, tmp_path: Path
) -> None:
    """Under `eai-1.0.5` most of the answers say whether objects have ids, as the reference's revisions do."""
    suite, asked = some_tasks(*PLANS, Protocol("eai-1.0.5"))
    scored = [task_id for task_id in asked.task_ids if suite.score(task_id, "").excluded is None][:7]
    texts = {
        task_id: '{"WALK": ["bed", "1"]}' if scored.index(task_id) < 4 else '{"WALK": ["bed"]}'
        for task_id in scored
    }
    file = tmp_path / "mixed_outputs.json"
    file.write_text(json.dumps([{"identifier": i, "llm_output": text} for i, text in texts.items()]))
    asked, replay = asked._replace(task_ids=scored), Whom("eai/replay", {"path": str(file)})
    ran = process.submit(run_in_child, asked, replay, tmp_path).result()
    one_by_one = compute_metric_rates([suite.score(*each) for each in texts.items()], suite.ability)
    assert ran.rates != one_by_one
    assert paper(read_eval_log(ran.log)) == pytest.approx(shares(ran.rates))
    evaluated = process.submit(evaluate_in_child, asked, replay, tmp_path).result()
    assert paper(read_eval_log(evaluated)) == pytest.approx(shares(ran.rates))
