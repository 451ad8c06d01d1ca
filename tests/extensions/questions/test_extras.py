from __future__ import annotations

from pathlib import Path

from cli.test_extras import must_name_the_extra


def test_a_missing_extra_is_one_line_that_names_it(tmp_path: Path) -> None:
    (tmp_path / "questions.jsonl").write_text("{}")
    command = "run --ability world_model --domain questions.jsonl --model eai/oracle --out answers"
    must_name_the_extra(command, "run", tmp_path)
