from __future__ import annotations

from eai.results.latex import format_latex_table
from eai.results.markdown import format_markdown_table
from eai.results.table import NO_NUMBER, Column, Estimate, Table, TextCell

TABLE = Table(
    "t",
    "Title",
    "Percent",
    (
        Column("rank", "#", is_number=True),
        Column("model", "Model", heading_without_group="model"),
        Column("task", "Task", "Success", heading_without_group="success: task", digits=1, notes=(1,)),
        Column("run", "Run", "Success", digits=1),
    ),
    (
        (1, TextCell("a_b", notes=(2,)), Estimate(50.0, 40.0, 60.04, best=True), Estimate(1.25)),
        (None, TextCell("c", origin="paper"), NO_NUMBER, Estimate(2.0, notes=(1, 2))),
    ),
    notes=("one", "two"),
)


def test_a_table_in_markdown_has_intervals_below_and_footnotes() -> None:
    assert format_markdown_table(TABLE).splitlines() == [
        "| # | model | success: task¹ | Run |",
        "| --: | --- | --: | --: |",
        "| 1 | a\\_b² | **50.0** | 1.2 |",
        "|  | *95 %* | 40.0–60.0 |  |",
        "|  | c *(paper)* | – | 2.0¹˒² |",
        "",
        "¹ one  ",
        "² two  ",
    ]


def test_a_table_in_latex_has_groups_of_columns() -> None:
    lines = format_latex_table(TABLE, label="x").splitlines()
    assert r"\caption{Percent; below each run its 95\,\% intervals.}" in lines
    assert r"\begin{tabular}{rlrr}" in lines
    start = lines.index(r"\toprule") + 1
    assert lines[start : start + 8] == [
        r" &  & \multicolumn{2}{c}{Success} \\",
        r"\cmidrule(lr){3-4}",
        r"\# & Model & Task\textsuperscript{1} & Run \\",
        r"\midrule",
        r"1 & a\_b\textsuperscript{2} & \textbf{50.0} & 1.2 \\",
        r" &  & {\scriptsize 40.0--60.0} & {\scriptsize } \\",
        r" & \emph{c} (paper) & -- & 2.0\textsuperscript{1,2} \\",
        r"\bottomrule",
    ]
    assert r"\textsuperscript{2} two\par" in lines


def test_latex_without_groups_has_one_line_of_headings() -> None:
    columns = (Column("model", "Model"), Column("run", "Run", digits=1))
    lines = format_latex_table(Table("t", "Title", "Percent", columns, (("a", 1.0),)), label="x").splitlines()
    assert lines[lines.index(r"\toprule") + 1 : lines.index(r"\midrule")] == [r"Model & Run \\"]


def test_latex_without_intervals_does_not_mention_them() -> None:
    assert "intervals" not in format_latex_table(TABLE, label="x", intervals=False)
    assert "scriptsize" not in format_latex_table(TABLE, label="x", intervals=False)
