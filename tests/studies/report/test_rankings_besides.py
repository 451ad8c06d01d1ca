from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import pytest

from eai.abilities.protocol import Protocol
from eai.results.latex import format_latex_table
from eai.results.paper_tables import read_paper_protocol_and_tables, read_paper_table
from eai.results.record import Record
from eai.results.runs import Run, RunKey
from eai.studies.report.rankings import Ranking
from eai.studies.report.rankings import make_rankings_of_secondary_paper_tables as rankings_besides
from eai.studies.report.run_summary import RunSummary, summarize_run
from eai.studies.report.table_specs import find_paper_column
from eai.studies.report.writer import format_rankings_csv, format_rankings_json
from results.verdicts import whole
from studies.report.samples import action_run, cell_at, goal_run, operator_run

REFERENCE = Protocol("eai-1.0.5")


def summary(records: Sequence[Record], protocol: Protocol = REFERENCE) -> RunSummary:
    renamed = whole([replace(record, protocol=protocol) for record in records])
    first = renamed[0]
    return summarize_run(Run(RunKey(protocol, first.domain, first.ability, first.model), renamed))


def besides(*runs: RunSummary) -> dict[tuple[str, str], Ranking]:
    return {(table.name, table.domain): table for table in rankings_besides(runs)}


def runs_in(table: Ranking) -> list[str]:
    return [row.model for row in table.rows if row.source == "run"]


@pytest.mark.parametrize("name", read_paper_protocol_and_tables().others)
def test_each_figure_of_the_paper_appears_in_the_papers_order(name: str) -> None:
    paper = read_paper_table(name)
    tables = [table for (found, _), table in besides().items() if found == f"paper_{name}"]
    figures = {
        (row.model, find_paper_column(column, table.domain)): cell.value
        for table in tables
        for row in table.rows
        for column, cell in row.scores.items()
        if cell.value is not None
    }
    printed = {
        (model, column): paper.find_printed_number(model, column)
        for model in paper.rows
        for column in paper.columns
        if paper.find_printed_number(model, column) is not None
    }
    assert figures == printed
    for table in tables:
        assert table.title == paper.title
        assert [row.model for row in table.rows] == list(paper.rows)
        assert all(row.rank is None for row in table.rows)


def test_a_run_appears_only_in_tables_that_measure_the_same() -> None:
    found = besides(summary(action_run()), summary(goal_run()), summary(operator_run()))
    assert {key for key, table in found.items() if runs_in(table)} == {
        ("paper_replanning", "virtualhome"),
        ("paper_transition_modeling_summary", "virtualhome"),
    }
    run = found["paper_replanning", "virtualhome"].rows[0]
    assert run.model == "first"
    cell = cell_at(run, 0)
    assert cell.low is not None
    assert cell.denominator == 11
    assert "no run can be set beside" in " ".join(found["paper_human", "virtualhome"].notes)


def test_a_strict_run_is_left_out_and_a_note_says_so() -> None:
    found = besides(summary(action_run(), Protocol.STRICT))
    assert not any(runs_in(table) for table in found.values())
    noted = [key for key, table in found.items() if any("another protocol" in text for text in table.notes)]
    assert noted == [("paper_replanning", "virtualhome")]


def test_a_behavior_run_appears_with_the_modular_rows() -> None:
    run = summary(action_run())
    found = besides(replace(run, key=run.key._replace(domain="behavior")))
    assert [key for key, table in found.items() if runs_in(table)] == [
        ("paper_replanning_prose", "behavior"),
        ("paper_pipeline_action_sequencing", "behavior"),
    ]
    assert any("modular rows" in text for text in found["paper_pipeline_action_sequencing", "behavior"].notes)


def test_figures_that_the_paper_contradicts_itself_on_have_a_note() -> None:
    table = besides()["paper_replanning", "virtualhome"]
    alone = table.rows[0]
    assert (alone.model, cell_at(alone, 0).value) == ("GPT-4o", 65.2)
    assert any("prints 71.5" in note for note in cell_at(alone, 0).texts)


def test_every_note_is_marked_somewhere() -> None:
    for table in besides(summary(action_run()), summary(action_run(), Protocol.STRICT)).values():
        used = {n for row in table.rows for cell in row.scores.values() for n in cell.texts}
        used |= {n for notes in table.columns.values() for n in notes}
        assert used == set(table.notes)


def test_equal_runs_give_equal_files_in_each_format() -> None:
    one, other = (rankings_besides([summary(action_run()), summary(operator_run())]) for _ in range(2))
    assert format_rankings_json(one) == format_rankings_json(other)
    assert format_rankings_csv(one) == format_rankings_csv(other)
    assert [format_latex_table(table.make_table(), label="") for table in one] == [
        format_latex_table(table.make_table(), label="") for table in other
    ]


def test_latex_names_a_protocol_only_in_tables_with_runs() -> None:
    found = besides(summary(action_run()))
    assert "protocol eai-1.0.5" in format_latex_table(
        found["paper_replanning", "virtualhome"].make_table(), label=""
    )
    caption = (
        format_latex_table(found["paper_human", "virtualhome"].make_table(), label="")
        .split("caption")[1]
        .splitlines()[0]
    )
    assert "protocol" not in caption
