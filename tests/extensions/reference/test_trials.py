from __future__ import annotations

from collections.abc import Mapping

import pytest

from benchmarks.test_trials import test_prompts_decide_whether_answers_are_read_with_ids
from eai.abilities.protocol import Protocol
from eai.tasks.prompts.prompt import PromptSet

SHARED = (test_prompts_decide_whether_answers_are_read_with_ids,)
"""A test of `strict` that is run again with the fixtures below."""


@pytest.fixture
def protocol() -> Protocol:
    return Protocol("eai-1.0.5")


@pytest.fixture
def with_ids() -> Mapping[PromptSet, bool]:
    return {"official": False, "eai": True}
