"""Answers to the tasks of a suite, made for tests that need many answers of many kinds."""

from __future__ import annotations

from eai.abilities.protocol import Ability
from eai.base.store import DataPackStore
from eai.benchmarks.gold_answers import make_noisy_answer, make_random_generator
from eai.benchmarks.random_answers import open_random_answers
from eai.benchmarks.registry import find_benchmark
from eai.tasks.source import Source
from suites import answer_book

_NOISE = 0.3
"""Share of the parts of a noisy answer that are corrupted."""


def made_answers(
    name: str, ability: Ability, store: DataPackStore, seed: str = "made"
) -> list[tuple[str, str]]:
    """Return (task id, text) for each task in order: in turn a gold, noisy, random and cut-off answer."""
    book = answer_book(name, ability, store)
    random_answer = open_random_answers(find_benchmark(name), ability, Source(store))
    answers = []
    for number, task_id in enumerate(book):
        match number % 4:
            case 0:
                text = book[task_id].text
            case 1:
                text = make_noisy_answer(book, task_id, _NOISE, seed).text
            case 2:
                text = random_answer(task_id, seed).text
            case _:
                gold = book[task_id].text
                text = gold[: make_random_generator(seed, task_id).randrange(len(gold))]
        answers.append((task_id, text))
    return answers
