from __future__ import annotations

import subprocess
import sys
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from eai.abilities.protocol import Ability
from eai.base.store import DataPackStore
from eai.results.table import Table
from eai.results.tidy import TidyTables
from eai.studies.errors.study import _ErrorCategory, find_error_category, make_error_tables
from eai.tasks.source import Source
from oracle import MODELS
from record_files import write_records
from studies.published import tables
from studies.report.samples import action_run, goal_run, operator_run, subgoal_run


def rows(table: Table) -> list[dict[str, Any]]:
    return table.row_dicts()


@pytest.mark.parametrize(
    ("changes", "leaf"),
    [
        ({"outcome": "success"}, _ErrorCategory("success")),
        ({"outcome": "not_answered"}, _ErrorCategory("not_answered")),
        ({"outcome": "parsing"}, _ErrorCategory("grammar", "parsing")),
        ({"outcome": "parsing", "error_check": "loop"}, _ErrorCategory("grammar", "parsing", "loop")),
        (
            {"outcome": "hallucination", "error_check": "unknown_object"},
            _ErrorCategory("grammar", "hallucination", "object"),
        ),
        ({"outcome": "wrong_order"}, _ErrorCategory("runtime", "wrong_order")),
        (
            {"outcome": "goal_missed", "executable": True, "state_met": 0.5, "state_total": 1.0},
            _ErrorCategory("goal", "goal_missed", "state"),
        ),
        ({"outcome": "goal_missed", "executable": None}, _ErrorCategory("goal_missed")),
    ],
)
def test_each_answer_has_one_leaf_of_the_taxonomy(changes: dict[str, Any], leaf: _ErrorCategory) -> None:
    made = TidyTables(Source(DataPackStore()))
    made.add_records(action_run())
    answer = replace(made.answers[0], relation_met=None, error_check=None)
    assert find_error_category(replace(answer, **changes)) == leaf


def test_leaves_add_up_to_the_outcomes_of_reports() -> None:
    made = TidyTables(Source(DataPackStore()))
    for records in (action_run(), goal_run(), subgoal_run(), operator_run()):
        made.add_records(records)
    found = {
        table.name: table
        for table in make_error_tables(made.answers, made.clauses, examples=3, explorer=None)
    }
    outcomes = Counter(a.outcome for a in made.answers if a.outcome != "excluded")
    leaves: Counter[str] = Counter()
    for row in rows(found["leaves"]):
        leaves[row["kind"] or row["stage"]] += row["answers"].numerator
    assert leaves == outcomes
    assert {row["predicate"] for row in rows(found["predicates"])} == {"near", "can_open"}


def test_closed_containers_are_the_most_overlooked_precondition() -> None:
    """The paper gives no number; nine models make 219 of 410 such errors."""
    found = tables("behavior", Ability.ACTION_SEQUENCING, MODELS)
    why = make_error_tables(found.answers, found.clauses, examples=3, explorer=None)[1]
    together = {row["check"]: row["share"].numerator for row in rows(why) if row["model"] == "all models"}
    first = ["is_closed", "is_inside_something_that_is_closed"]
    assert list(together)[:2] == first
    assert (sum(together[check] for check in first), sum(together.values())) == (219, 410)


COUNTED = """
import sys

from eai.__main__ import main

try:
    main()
finally:
    print(len([name for name in sys.modules if name.partition(".")[0] == "eai"]))
"""


def test_the_analysis_of_errors_loads_no_engine_of_benchmarks(tmp_path: Path) -> None:
    write_records(tmp_path / "records.jsonl", action_run())
    arguments = ["analyze", "errors", str(tmp_path), "--out", str(tmp_path / "out")]
    command = [sys.executable, "-c", COUNTED, *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert int(done.stdout.splitlines()[-1]) <= 78
