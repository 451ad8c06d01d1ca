from __future__ import annotations

import json
from pathlib import Path

import pytest

from command_line import Command
from eai.base.errors import InputError
from eai.extensions.annotation.study import count_ratings_by_score, read_ratings, summarize_ratings
from studies.told import read_table

HEADER = "task,rater,attribute,score\n"
GOOD = """\
Attribute,rater,task,score,remark
accuracy,ann,t1,1,too short
accuracy,bob,t1,3,
accuracy,ann,t2,5,

coverage,ann,t1,4,
"""


def written(folder: Path, text: str) -> Path:
    path = folder / "ratings.csv"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_task_rated_once_adds_to_the_mean_only(tmp_path: Path) -> None:
    ratings = read_ratings(written(tmp_path, GOOD))
    accuracy, coverage = summarize_ratings(ratings).rows
    assert accuracy[:6] == ("accuracy", 3, 2, 2, 1, 3.0)
    assert accuracy[6] == 1.0
    assert coverage[5:] == (4.0, None, None, None)
    assert [row[2] for row in count_ratings_by_score(ratings).rows if row[0] == "accuracy"] == [1, 0, 1, 0, 1]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "line 1: expected the columns task, rater, attribute, score"),
        ("task,rater,score\nt,a,1\n", "line 1: expected the columns"),
        (HEADER, "line 2: expected ratings"),
        (HEADER + "t,a,x,6\n", "line 2, column score: expected 1 to 5, found '6'"),
        (HEADER + "t,a,x,4.5\n", "line 2, column score"),
        (HEADER + "t,a,x,4\nt,,x,4\n", "line 3, column rater: expected a value"),
        ("task,note,rater,attribute,score\nt,'two\nlines',a,x,6\n".replace("'", '"'), "line 3, column score"),
        (
            "task,rater,attribute,score,note\nt,a,x,4,'open\nu,a,x,5,\n".replace("'", '"'),
            "line 3: unexpected end",
        ),
        (HEADER + f"{'t' * 200_000},a,x,4\n", "line 2: field larger than field limit"),
        (HEADER + "t,a,x\n", "line 2: expected 4 columns, found 3"),
        (
            HEADER + "t,a,x,4\n\nt,a,x,5\n",
            "line 4 rates task 't', attribute 'x', by rater 'a', as line 2 does",
        ),
    ],
)
def test_errors_in_ratings_name_line_and_column(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(InputError) as caught:
        read_ratings(written(tmp_path, text))
    assert message in str(caught.value)


def test_other_files_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be read"):
        read_ratings(tmp_path / "none.csv")
    (tmp_path / "ratings.csv").write_bytes(b"task\xff")
    with pytest.raises(InputError, match="UTF-8"):
        read_ratings(tmp_path / "ratings.csv")


def test_the_command_writes_tables_and_plots(eai: Command, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    outcome = eai("analyze", "annotations", written(tmp_path, GOOD), "--out", tmp_path / "out")
    assert outcome.status == 0
    assert "Ratings of annotations by attribute" in outcome.out
    assert {path.name for path in (tmp_path / "out").iterdir()} == {
        "annotations.csv",
        "annotation_scores.csv",
        "annotations.json",
        "annotations.md",
        "annotations.svg",
    }
    rows = json.loads((tmp_path / "out" / "annotations.json").read_text())["tables"]["annotations"]["rows"]
    assert [row["weighted_mse"] for row in rows] == [1.0, None]


def test_the_figures_are_printed_as_json(eai: Command, tmp_path: Path) -> None:
    ratings, out = written(tmp_path, GOOD), tmp_path / "out"
    (told,) = json.loads(eai("analyze", "annotations", ratings, "--no-plots", "--json", "--out", out).out)
    rows = read_table(Path(told["folder"]) / "annotations.csv")
    assert told["attributes"][0]["mean"] == 3.0
    assert [(each["attribute"], each["mean"], each["ratings"]) for each in told["attributes"]] == [
        (row["attribute"], float(row["mean"]), int(row["ratings"])) for row in rows
    ]
