"""Shortcuts to the suites of the paper's households, by name."""

from __future__ import annotations

from collections.abc import Mapping

from eai.abilities.protocol import PAPER_ABILITIES, Ability
from eai.base.store import DataPackStore
from eai.benchmarks.gold_answers import AnswersByTask, open_answers_of_planner, open_gold_answers
from eai.benchmarks.prompt_library import PromptLibrary
from eai.benchmarks.registry import find_benchmark, list_paper_benchmarks
from eai.tasks.prompts.prompt import Prompt, PromptFiles
from eai.tasks.source import ErrataChoice, Source

SUITES = tuple((name, ability) for name in list_paper_benchmarks() for ability in PAPER_ABILITIES)
"""Suites of the paper: each household with each ability."""


def official_prompts(
    name: str,
    ability: Ability,
    store: DataPackStore | None = None,
    errata: ErrataChoice = ErrataChoice.CURRENT,
) -> Mapping[str, Prompt]:
    found = find_benchmark(name).official_prompts(ability, Source(store, errata=errata))
    assert found is not None
    return found


def official_files(
    name: str,
    ability: Ability,
    store: DataPackStore | None = None,
    errata: ErrataChoice = ErrataChoice.CURRENT,
) -> PromptFiles:
    found = find_benchmark(name).official_files(ability, Source(store, errata=errata))
    assert found is not None
    return found


def own_prompts(name: str, ability: Ability, store: DataPackStore) -> Mapping[str, Prompt]:
    return PromptLibrary("eai", None, Source(store)).open(find_benchmark(name), ability)


def answer_book(name: str, ability: Ability, store: DataPackStore | None = None) -> AnswersByTask:
    return open_gold_answers(find_benchmark(name), ability, Source(store))


def planned_book(name: str, ability: Ability, store: DataPackStore | None = None) -> AnswersByTask:
    return open_answers_of_planner(find_benchmark(name), ability, Source(store))
