from __future__ import annotations

import pytest

from cli.test_score import folder, test_a_task_without_an_answer_counts_as_failed_and_is_told

SHARED = (folder, test_a_task_without_an_answer_counts_as_failed_and_is_told)
"""A test of `strict`, with its fixture of a folder, that is run again with the fixtures below."""


@pytest.fixture
def protocol() -> str:
    return "eai-1.0.5"


@pytest.fixture
def in_statistics() -> int:
    return 305
