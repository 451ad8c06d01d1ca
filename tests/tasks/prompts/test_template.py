from __future__ import annotations

from pathlib import Path

import pytest

from eai.base.errors import InputError
from eai.tasks.prompts.template import PromptTemplates


def test_braces_and_percent_signs_mean_themselves(tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text('{"a": ["$task"]} 100% {task} $$\n')
    assert (
        PromptTemplates(tmp_path).fill_template("mine.txt", {"task": "{x}"}) == '{"a": ["{x}"]} 100% {task} $'
    )


def test_files_of_the_user_replace_single_ones(tmp_path: Path) -> None:
    ours = PromptTemplates().read("example.txt")
    (tmp_path / "example.txt").write_text("mine $task")
    assert PromptTemplates(tmp_path).read("example.txt") == "mine $task" != ours
    assert PromptTemplates(tmp_path).read("action_sequencing.txt") == PromptTemplates().read(
        "action_sequencing.txt"
    )


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"$tusk", r"mine\.txt: unknown placeholder \$tusk: expected one of \$task"),
        (b"5 $ each", r"mine\.txt: Invalid placeholder .*written as"),
        (b"\xff", r"mine\.txt: expected a text in UTF-8"),
    ],
)
def test_a_template_that_cannot_be_filled_is_refused(tmp_path: Path, content: bytes, message: str) -> None:
    (tmp_path / "mine.txt").write_bytes(content)
    with pytest.raises(InputError, match=message):
        PromptTemplates(tmp_path).fill_template("mine.txt", {"task": "t"})
