from __future__ import annotations

import json
import sys
from dataclasses import fields, replace
from pathlib import Path

import pytest

from by_path import ROOT
from eai.base.errors import EaiError, InputError
from eai.results.certainty import TaskRateContribution
from eai.results.lines import ALL_MODELS, MODEL, SUITE, TABLES, PlanStepTableLine
from eai.results.table import Estimate, Table, TextCell
from eai.results.table_files import format_lines_as_csv, write_parquet, write_tables
from eai.tasks.share import Share
from studies.published import GPT_4O

RATE = Estimate.from_task_rate_contributions(
    [TaskRateContribution(str(i), str(i), Share(i % 2, 1)) for i in range(10)]
)
TABLE = Table(
    "sizes", "Sizes", "How big.", ("what", "size", "known"), (("a | b", RATE, True), ("c", None, None))
)
STEP = PlanStepTableLine(
    protocol="strict",
    domain="lamps",
    ability="action_sequencing",
    model=GPT_4O,
    task="1",
    name="Lamps",
    step=0,
    operator="GO",
    objects="lamp_1",
    outcome="executed",
    reason="",
)


def test_an_estimate_shows_its_numerator_and_denominator() -> None:
    assert (RATE.value, RATE.numerator, RATE.denominator) == (50.0, 5, 10)
    assert str(RATE) == "50 (5/10) [23.7, 76.3]"
    assert str(Estimate(-0.456, -1.0, 0.25)) == "-0.46 [-1, 0.25]"
    assert str(Estimate(None)) == ""


def test_tables_are_written_in_three_forms(tmp_path: Path) -> None:
    written = write_tables(tmp_path, "things", [TABLE], ["Mind."])
    assert [path.name for path in written] == ["sizes.csv", "things.json", "things.md"]
    csv_file, json_file, markdown = (path.read_text(encoding="utf-8") for path in written)
    assert csv_file.splitlines()[0] == "what,size,size_low,size_high,size_numerator,size_denominator,known"
    assert csv_file.splitlines()[2] == "c,,,,,,"
    assert csv_file.splitlines()[1].endswith("5,10,true")
    found = json.loads(json_file)
    assert found["remarks"] == ["Mind."]
    assert found["tables"]["sizes"]["definition"] == "How big."
    assert found["tables"]["sizes"]["rows"][0]["size"]["numerator"] == 5
    assert "| a \\| b | 50 (5/10) [23.7, 76.3] | yes |" in markdown


def test_each_line_becomes_one_line_of_csv() -> None:
    columns, values = format_lines_as_csv(PlanStepTableLine, [STEP]).splitlines()
    beginning = "protocol,domain,ability,model,harness,effort,experiment,task,name"
    assert columns == f"{beginning},step,operator,objects,outcome,reason"
    assert values == f"strict,lamps,action_sequencing,{GPT_4O},,,,1,Lamps,0,GO,lamp_1,executed,"


def test_parquet_keeps_types(tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    for name, kind in TABLES.items():
        write_parquet(tmp_path / f"{name}.parquet", kind, [STEP] if kind is PlanStepTableLine else [])
    read = parquet.read_table(tmp_path / "steps.parquet")
    assert (str(read.schema.field("step").type), read.num_rows) == ("int64", 1)
    answers = parquet.read_table(tmp_path / "answers.parquet").schema
    assert [str(answers.field(name).type) for name in ("success", "cost", "goals")] == [
        "bool",
        "double",
        "int64",
    ]


def test_parquet_has_escapes_for_lone_surrogates(tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    file = tmp_path / "new" / "steps.parquet"
    write_parquet(file, PlanStepTableLine, [replace(STEP, reason="cut \ud83d")])
    assert parquet.read_table(file)["reason"].to_pylist() == ["cut \\ud83d"]


def test_a_parquet_file_is_replaced_as_a_whole(tmp_path: Path) -> None:
    pytest.importorskip("pyarrow.parquet")
    file = tmp_path / "steps.parquet"
    write_parquet(file, PlanStepTableLine, [STEP])
    before = file.read_bytes()
    with file.open("rb") as reader:
        write_parquet(file, PlanStepTableLine, [STEP, STEP])
        assert reader.read() == before
    assert file.read_bytes() != before
    with pytest.raises(InputError, match="cannot be written"):
        write_parquet(file / "below.parquet", PlanStepTableLine, [STEP])


def test_markdown_shows_every_suite_even_if_another_has_rows_of_all_models(tmp_path: Path) -> None:
    rows = [
        ("strict", "lamps", "acting", "a", 1),
        ("strict", "lamps", "acting", ALL_MODELS, 2),
        ("strict", "switches", "acting", "a", 3),
    ]
    write_tables(tmp_path, "things", [Table("sizes", "Sizes", "", (*SUITE, MODEL, "size"), tuple(rows))])
    markdown = (tmp_path / "things.md").read_text()
    assert [line for line in markdown.splitlines() if line in ("| 1 |", "| 2 |", "| 3 |")] == [
        "| 2 |",
        "| 3 |",
    ]


def test_a_text_in_a_csv_column_of_estimates_takes_the_place_of_the_number() -> None:
    rows = ((RATE, "a"), (TextCell("none"), "b"), ("text", "c"), (3, "d"), (None, "e"))
    table = Table("sizes", "Sizes", "", ("size", "what"), rows)
    assert {len(row) for row in table.csv_rows()} == {len(table.csv_column_names())}
    assert [row[0] for row in table.csv_rows()] == [RATE.value, "none", "text", 3, None]
    assert {tuple(row[1:-1]) for row in [*table.csv_rows()][1:]} == {(None,) * 4}


def test_a_missing_extra_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    monkeypatch.delitem(sys.modules, "pyarrow.parquet", raising=False)
    with pytest.raises(EaiError, match=r"Parquet needs pyarrow: pip install 'eai-bench\[analysis\]'"):
        write_parquet(tmp_path / "steps.parquet", PlanStepTableLine, [STEP])


def test_the_documentation_has_every_column() -> None:
    page = (ROOT / "docs" / "tidy-tables.md").read_text(encoding="utf-8")
    columns = {column.name for kind in TABLES.values() for column in fields(kind)}
    assert [name for name in sorted(columns) if f"\n| `{name}` | " not in page] == []
