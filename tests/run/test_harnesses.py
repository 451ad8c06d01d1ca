"""Other harnesses: tasks that Inspect finds in source files, and tasks of the LM Evaluation Harness."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from typing import Any

import pytest
from inspect_ai import list_tasks

import eai
from by_path import ROOT
from eai.abilities.declaration import get_declaration
from eai.abilities.protocol import PAPER_ABILITIES
from eai.base.store import DataPackStore
from eai.benchmarks.gold_answers import open_gold_answers
from eai.benchmarks.registry import list_paper_benchmarks
from eai.run.registry import TASKS

EXAMPLE = ROOT / "examples/lm_eval"
OF_HOUSEHOLDS = {
    f"{name}_{ability.value}" for name in list_paper_benchmarks() for ability in PAPER_ABILITIES
} & set(TASKS)
"""The examples have the four abilities of the paper's households: no file of questions, and no pictures."""


def test_every_suite_is_an_inspect_task_found_in_the_source_file() -> None:
    found = list_tasks("examples/inspect", root_dir=ROOT)
    assert {task.name for task in found} == OF_HOUSEHOLDS


def test_every_suite_is_a_task_of_the_lm_evaluation_harness() -> None:
    for path in EXAMPLE.glob("eai_*.yaml"):
        assert f"task: {path.stem}\n" in path.read_text(encoding="utf-8")
        ability = next(each for each in PAPER_ABILITIES if path.stem.endswith(each.value))
        assert path.read_text(encoding="utf-8").count("metric: ") == len(
            get_declaration(ability).overview_headings
        )
    assert {path.stem for path in EXAMPLE.glob("eai_*.yaml")} == {f"eai_{name}" for name in OF_HOUSEHOLDS}


@pytest.fixture
def suites(monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    pytest.importorskip("lm_eval", reason="no LM Evaluation Harness: pip install lm_eval")
    monkeypatch.syspath_prepend(EXAMPLE)
    import eai_suites

    yield eai_suites
    sys.modules.pop("eai_suites", None)


def test_right_answers_are_right_in_the_lm_evaluation_harness(data_store: DataPackStore, suites: Any) -> None:
    rows = suites.questions("behavior", "action_sequencing", version=1.0)["test"]
    suite = eai.open("behavior", "action_sequencing")
    book = open_gold_answers(suite.benchmark, suite.ability, suite.source)
    counted = [suites.shares(row, [book[row["task_id"]].text]) for row in rows.select(range(5))]
    assert suites.rate([each["task_success"] for each in counted]) == 1.0
    assert suites.rate([suites.shares(rows[0], ["lol"])["task_success"]]) == 0.0


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_the_harnesss_dummy_model_scores_zero(data_store: DataPackStore, suites: Any) -> None:
    import lm_eval
    from lm_eval.tasks import TaskManager

    manager = TaskManager(include_path=str(EXAMPLE))
    name = "eai_virtualhome_action_sequencing"
    results = lm_eval.simple_evaluate("dummy", tasks=[name], limit=3, task_manager=manager)["results"]
    assert results[name]["task_success,none"] == 0.0
