"""What ``eai run`` does once the model has answered; whole runs are in `test_run`."""

from __future__ import annotations

import pytest

from eai.cli.console import counted, dollars


@pytest.mark.parametrize(
    ("number", "text"), [(0, "0 tasks"), (1, "1 task"), (2, "2 tasks"), (1000, "1,000 tasks")]
)
def test_things_are_counted_in_english(number: int, text: str) -> None:
    assert counted(number, "task") == text


@pytest.mark.parametrize(("amount", "text"), [(0, "$0.0000"), (0.0012, "$0.0012"), (12.345, "$12.35")])
def test_small_amounts_are_not_nothing(amount: float, text: str) -> None:
    assert dollars(amount) == text
