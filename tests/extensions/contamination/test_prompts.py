"""Prompts in other words, or with exact rules, state all that gold plans need."""

from __future__ import annotations

import pytest

from eai.abilities.protocol import Ability
from eai.benchmarks.registry import find_benchmark
from eai.tasks.source import Source
from sweeps import every, swept
from tasks.prompts.test_sufficiency import PLANS, chosen, fetched, insufficient, own_prompt

SHARED = (fetched,)
"""The fixture of a source with all data."""


@every(25)
@pytest.mark.parametrize("ability", PLANS)
@pytest.mark.parametrize(
    "name",
    swept("rules:behavior-1k", "obfuscated:virtualhome", "obfuscated:behavior", "obfuscated:behavior-1k"),
)
def test_gold_plans_work_in_the_worlds_of_prompts_in_other_words(
    fetched: Source, name: str, ability: Ability, every: int
) -> None:
    benchmark = find_benchmark(name)
    tasks = chosen(benchmark, ability, fetched, every)
    assert insufficient(benchmark, ability, tasks, own_prompt(ability, fetched)) == {}
