"""Obfuscated twins: other words, the same world, the same verdicts."""

from __future__ import annotations

from pathlib import Path

import pytest

from eai.abilities.protocol import Ability
from eai.benchmarks.gold_answers import open_answer_book
from eai.benchmarks.noisy_answers import Noise, noisy_answer
from eai.benchmarks.obfuscated import Cipher
from eai.benchmarks.prompt_library import Library
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.source import Source
from eai.benchmarks.suite import open_suite
from eai.data.store import Store
from eai.prompts.prompt import PromptSet

PLANNED = (Ability.ACTION_SEQUENCING, Ability.SUBGOAL_DECOMPOSITION)


@pytest.fixture(params=["lamps:lamps", "virtualhome", "behavior"])
def name(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch, data_store: Store) -> str:
    monkeypatch.syspath_prepend(Path(__file__).parents[2] / "examples" / "lamps")
    return str(request.param)


def cipher(name: str) -> Cipher:
    return Cipher.of(find_benchmark(name), find_benchmark(name).tasks(Source()).values())


@pytest.mark.parametrize("ability", PLANNED)
def test_verdicts_are_those_of_the_plain_answers(name: str, ability: Ability) -> None:
    plain, twin = open_suite(name, ability), open_suite(f"obfuscated:{name}", ability)
    book, words = open_answer_book(plain.benchmark, ability), cipher(name)
    assert twin.task_ids == plain.task_ids
    for task_id in plain.task_ids[:: max(1, len(plain.task_ids) // 12)]:
        for rate in (0.0, 0.4):
            text = noisy_answer(book, task_id, Noise(rate, "1")).text
            assert words.decode(words.encode(text)) == text
            assert twin.score(task_id, words.encode(text)) == plain.score(task_id, text)


def test_words_change_among_those_that_are_used_alike(name: str) -> None:
    benchmark, words = find_benchmark(name), cipher(name).words
    assert sorted(words) == sorted(words.values())
    said = benchmark.wording(PLANNED[0]).predicates
    arities, arity = benchmark.domain.arities, benchmark.domain.vocabulary.arity
    for old, new in words.items():
        assert (old in arities) == (new in arities)
        assert arities.get(old) == arities.get(new)
        assert old not in said or (new in said and arity(old) == arity(new))
    operators = [old for old in words if old in arities]
    assert sum(words[old] != old for old in operators) >= len(operators) // 2


def test_prompts_and_right_answers_are_in_the_twins_words(name: str) -> None:
    twin, words = find_benchmark(f"obfuscated:{name}"), cipher(name)
    prompts = Library(PromptSet.EAI, source=Source()).open(twin, PLANNED[0])
    book, plain = open_answer_book(twin, PLANNED[0]), open_answer_book(find_benchmark(name), PLANNED[0])
    task_id = next(iter(prompts))
    task = twin.tasks(Source())[task_id]
    assert book.gold(task_id).text == words.encode(plain.gold(task_id).text)
    told = prompts[task_id].user
    assert all(words.encode(task.scene.objects[i].name) in told for i in task.relevant)
    assert open_suite(twin, PLANNED[0]).score(task_id, book.gold(task_id).text).success  # type: ignore[attr-defined]
