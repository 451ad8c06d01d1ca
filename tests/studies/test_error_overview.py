"""The flow of all answers to outcomes: no answer is lost, and figures are inspected, not rendered."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from eai.base.store import DataPackStore
from eai.results.lines import AnswerTableLine
from eai.results.tidy import TidyTables
from eai.studies.errors.overview import draw_sankey_diagrams_of_outcomes, make_outcome_counts_table
from eai.tasks.source import Source
from studies.report.samples import action_run, goal_run


def answers(tmp_path: Path) -> list[AnswerTableLine]:
    made = TidyTables(Source(DataPackStore(tmp_path)), features=False)
    made.add_records(action_run())
    made.add_records(goal_run())
    return made.answers


def test_each_counted_answer_has_one_outcome_in_the_flow(tmp_path: Path) -> None:
    given = answers(tmp_path)
    given.append(replace(given[0], task="another", outcome="excluded"))
    rows = make_outcome_counts_table(given).row_dicts()
    counted = [each for each in given if each.outcome != "excluded"]
    assert sum(int(str(row["answers"])) for row in rows) == len(counted)
    needless = sum(bool(each.additional_steps) for each in counted)
    assert sum(int(str(row["with_additional_steps"])) for row in rows) == needless


def test_the_figure_names_worlds_abilities_outcomes_and_additional_steps(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    given = answers(tmp_path)
    given.append(replace(given[0], task="another", outcome="success", additional_steps=2))
    ((name, figure),) = draw_sankey_diagrams_of_outcomes(make_outcome_counts_table(given))
    assert name == "flow-all-strict"
    assert figure is not None
    texts = [text.get_text() for text in figure.axes[0].texts]
    assert any("action sequencing" in text for text in texts)
    assert any("goal interpretation" in text for text in texts)
    assert any(text.endswith("with additional steps") for text in texts)


def test_a_single_suite_has_no_flow_figure(tmp_path: Path) -> None:
    plans = [each for each in answers(tmp_path) if each.ability == "action_sequencing"]
    assert list(draw_sankey_diagrams_of_outcomes(make_outcome_counts_table(plans))) == []
