from __future__ import annotations

from pathlib import Path

from cli.test_extras import NO_PLOTS, bare


def test_ratings_are_analysed_without_plots(tmp_path: Path) -> None:
    (tmp_path / "ratings.csv").write_text("task,rater,attribute,score\n27_2,one,clear,5\n")
    outcome = bare("analyze annotations ratings.csv --out out", tmp_path)
    assert (outcome.status, outcome.err) == (0, NO_PLOTS)
