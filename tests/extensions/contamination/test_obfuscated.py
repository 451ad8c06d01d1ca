"""Obfuscated twins: other words, the same world, the same verdicts."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from functools import cache
from pathlib import Path

import pytest

from by_path import ROOT
from command_line import Command
from eai.abilities.protocol import Ability
from eai.base.store import DataPackStore
from eai.benchmarks.gold_answers import make_noisy_answer, open_gold_answers
from eai.benchmarks.prompt_library import PromptLibrary
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.suite import open_suite
from eai.extensions.contamination.obfuscated import _make_word_cipher, _replace_words, _restore_words
from eai.tasks.source import Source
from eai.tasks.wording import is_unchanging_object_property
from sweeps import swept

PLANNED = (Ability.ACTION_SEQUENCING, Ability.SUBGOAL_DECOMPOSITION)


@pytest.fixture(params=["lamps:lamps", "virtualhome", "behavior"])
def name(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch, data_store: DataPackStore) -> str:
    monkeypatch.syspath_prepend(ROOT / "examples" / "lamps")
    return str(request.param)


@cache
def cipher(name: str) -> Mapping[str, str]:
    return _make_word_cipher(find_benchmark(name), find_benchmark(name).tasks(Source()).values())


@pytest.mark.parametrize("ability", PLANNED)
def test_verdicts_are_those_of_the_plain_answers(name: str, ability: Ability) -> None:
    plain, twin = open_suite(name, ability), open_suite(f"obfuscated:{name}", ability)
    book, words = open_gold_answers(plain.benchmark, ability), cipher(name)
    assert twin.task_ids == plain.task_ids
    for task_id in plain.task_ids[:: max(1, len(plain.task_ids) // 12)]:
        for rate in (0.0, 0.4):
            text = make_noisy_answer(book, task_id, rate, "1").text
            assert _restore_words(words, _replace_words(words, text)) == text
            assert twin.score(task_id, _replace_words(words, text)) == plain.score(task_id, text)


def test_names_of_actions_in_lower_case_are_the_twins_too(name: str) -> None:
    plain, twin = open_suite(name, PLANNED[0]), open_suite(f"obfuscated:{name}", PLANNED[0])
    book = open_gold_answers(plain.benchmark, PLANNED[0])
    for task_id in plain.task_ids[:: max(1, len(plain.task_ids) // 12)]:
        text = book[task_id].text
        answers = (text, _replace_words(cipher(name), text))
        in_lower_case = [re.sub(r'"[A-Z_]{2,}"', lambda word: word[0].lower(), answer) for answer in answers]
        assert in_lower_case[0] != text
        assert plain.score(task_id, in_lower_case[0]) == twin.score(task_id, in_lower_case[1])


def test_words_change_among_those_that_are_used_alike(name: str) -> None:
    benchmark, words = find_benchmark(name), cipher(name)
    assert sorted(words) == sorted(words.values())
    said = benchmark.wording(PLANNED[0]).predicates
    arities, arity = benchmark.domain.operator_arities, benchmark.domain.vocabulary.find_arity
    for old, new in words.items():
        assert (old in arities) == (new in arities)
        assert arities.get(old) == arities.get(new)
        assert old not in said or (new in said and arity(old) == arity(new))
    operators = [old for old in words if old in arities]
    assert sum(words[old] != old for old in operators) >= len(operators) // 2


def test_prompts_and_right_answers_are_in_the_twins_words(name: str) -> None:
    twin, words = find_benchmark(f"obfuscated:{name}"), cipher(name)
    prompts = PromptLibrary("eai", source=Source()).open(twin, PLANNED[0])
    book, plain = open_gold_answers(twin, PLANNED[0]), open_gold_answers(find_benchmark(name), PLANNED[0])
    task_id = next(iter(prompts))
    task = twin.tasks(Source())[task_id]
    assert book[task_id].text == _replace_words(words, plain[task_id].text)
    told = prompts[task_id].user
    assert all(_replace_words(words, task.scene.objects[i].name) in told for i in task.relevant)
    assert open_suite(twin, PLANNED[0]).score(task_id, book[task_id].text).success  # type: ignore[attr-defined]


@pytest.mark.parametrize("ability", PLANNED)
def test_the_same_prompts_in_true_words_differ_in_words_alone(name: str, ability: Ability) -> None:
    """All that a model could use beside the words is the same, so a difference is theirs."""
    told, twin = f"rules:{name}", f"obfuscated:{name}"
    prompts, others = (
        PromptLibrary("eai", source=Source()).open(find_benchmark(each), ability) for each in (told, twin)
    )
    assert list(prompts) == list(others)
    for task_id in list(prompts)[:: max(1, len(prompts) // 6)]:
        assert "  requires: " in prompts[task_id].user
        assert len(prompts[task_id].user.splitlines()) == len(others[task_id].user.splitlines())
    (_, *ours), (_, *theirs) = (
        find_benchmark(each).wording(ability).describe_operators().splitlines() for each in (told, twin)
    )
    assert ours != theirs
    assert [_replace_words(cipher(name), line) for line in ours] == theirs
    plain, suite = open_suite(name, ability), open_suite(told, ability)
    book = open_gold_answers(plain.benchmark, ability)
    for task_id in plain.task_ids[:: max(1, len(plain.task_ids) // 6)]:
        text = make_noisy_answer(book, task_id, 0.4, "1").text
        assert suite.score(task_id, text) == plain.score(task_id, text)


def test_the_arms_are_compared(eai: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT / "examples" / "lamps")
    for arm in ("rules", "obfuscated"):
        answers = tmp_path / arm / "me_outputs.json"
        answers.parent.mkdir()
        answers.write_text('[{"identifier": "light", "llm_output": "[]"}]')
        about = ("--domain", f"{arm}:lamps:lamps", "--ability", "action_sequencing")
        assert eai("score", answers, *about, "--out", tmp_path / arm / "scores").status == 0
    told = eai("compare", tmp_path / "rules" / "scores", tmp_path / "obfuscated" / "scores", "--json")
    (found,) = json.loads(told.out)
    assert found["tasks"] == 2


def test_prompts_say_exactly_what_actions_need_and_do(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(ROOT / "examples" / "lamps")
    told = find_benchmark("obfuscated:lamps:lamps").wording(PLANNED[0]).describe_operators()
    assert (
        "GO(x)\n"
        "  requires: is_a(x, lamp); holds(agent, x); not exists y. (inside(agent, y))\n"
        "  needed only if: not lit(x)\n"
        "  becomes true: lit(x)\n"
    ) in told
    assert "  becomes false: inside(agent, x)\n  becomes true: at(x, y)" in told
    assert "GO" in cipher("lamps:lamps").values()
    for ability in PLANNED:
        twin = find_benchmark("obfuscated:lamps:lamps")
        prompt = next(iter(PromptLibrary("eai", source=Source()).open(twin, ability).values()))
        assert re.search(
            r"with what each( action)? requires and changes:\nAn action is possible", prompt.user
        )
        assert "reasons" not in prompt.user


@pytest.mark.usefixtures("data_store")
@pytest.mark.parametrize("name", ["virtualhome", "behavior"])
def test_every_action_has_its_needs_and_effects(name: str) -> None:
    """Also what reads hidden memory, or tries several things; of none there is a word in English."""
    domain = find_benchmark(name).domain
    told = find_benchmark(f"obfuscated:{name}").wording(PLANNED[0]).describe_operators()
    heads = re.split(r"^(?=\w+\([^)]*\)$)", told, flags=re.MULTILINE)[1:]
    assert len(heads) == len(domain.operators)
    for text, operator in zip(heads, domain.operators, strict=True):
        head, *lines = text.splitlines()
        names = ", ".join([parameter.name for parameter in operator.parameters])
        assert head == f"{_replace_words(cipher(name), operator.name)}({names})"
        assert ("  changes nothing" in lines) == (not operator.effects and not operator.alternatives)
        assert operator.checks == () or re.search("^  (requires|needed only if): ", text, re.MULTILINE)


@pytest.mark.usefixtures("data_store")
@pytest.mark.parametrize("name", ["behavior", *swept("virtualhome")])
def test_properties_that_actions_ask_for_are_told(name: str) -> None:
    wording = find_benchmark(f"obfuscated:{name}").wording(PLANNED[0])
    domain = find_benchmark(name).domain
    properties = {
        _replace_words(cipher(name), p.name)
        for p in domain.vocabulary.predicates
        if is_unchanging_object_property(p)
    }
    asked = properties & set(re.findall(r"[\w.-]*\w", wording.describe_operators()))
    told, words = set(), cipher(name)
    for task in list(find_benchmark(name).tasks(Source()).values())[::10]:
        for index in range(len(task.scene.objects)):
            told |= set(wording.describe_object(task, index).rpartition(": ")[2].split(", "))
            having = {each for each in asked if task.initial.has(_restore_words(words, each), index)}
            assert having <= set(wording.describe_object(task, index).rpartition(": ")[2].split(", "))
    assert len(asked & told) > len(asked) // 2
