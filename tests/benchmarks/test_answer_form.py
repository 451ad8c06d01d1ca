"""The form in which answers are asked for: good answers have it, and are read in it as they are without."""

from __future__ import annotations

import importlib.util
import json
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from typing import get_args

import pytest

from by_path import ROOT
from eai.abilities.answer_schema import Schema, is_accepted
from eai.abilities.notation.notation import Notation
from eai.abilities.notation.plans import PlanNotation
from eai.abilities.protocol import PAPER_ABILITIES, Ability, Protocol
from eai.base.store import Store
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.gold_answers import open_answer_book
from eai.benchmarks.prompt_library import Library, answer_form
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.suite import open_suite
from eai.tasks.prompts.prompt import Prompt, PromptSet
from eai.tasks.source import Source
from protocols import PROTOCOLS

jsonschema = pytest.importorskip("jsonschema")

FOLDER = ROOT / "examples" / "lamps"
SUITES = [(name, ability) for name in ("virtualhome", "behavior", "lamps") for ability in PAPER_ABILITIES]
EVERY = 30
"""Of how many tasks one is looked at."""


@cache
def benchmark(name: str) -> Benchmark:
    if name != "lamps":
        return find_benchmark(name)
    spec = importlib.util.spec_from_file_location("lamps_of_answer_forms", FOLDER / "lamps.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    found: Benchmark = module.lamps
    return found


@cache
def questions(name: str, ability: Ability, store: Store, prompts: PromptSet) -> Mapping[str, Prompt]:
    return Library(prompts, None, Source(store)).open(benchmark(name), ability)


def forms(
    name: str, ability: Ability, store: Store, prompts: PromptSet = "eai", every: int = EVERY
) -> Mapping[str, Schema]:
    found = benchmark(name)
    tasks, asked = found.tasks(Source(store)), questions(name, ability, store, prompts)
    chosen = {
        task_id: answer_form(found, ability, tasks.get(task_id), asked[task_id])
        for task_id in [*asked][::every]
    }
    return {task_id: form for task_id, form in chosen.items() if form is not None}


def words(part: object) -> list[str]:
    """All words that a schema offers."""
    if isinstance(part, Mapping):
        return [*part.get("enum", ()), *[word for each in part.values() for word in words(each)]]
    return [word for each in part for word in words(each)] if isinstance(part, list | tuple) else []


def in_form(name: str, ability: Ability, parts: tuple[str, ...], text: str) -> str:
    """A good answer in the form that is asked for, which only plans do not have by themselves."""
    if ability is not Ability.ACTION_SEQUENCING:
        return text
    if name == "virtualhome":
        steps = ", ".join(f"{{{part}}}" for part in parts)
        return f'{{"action commands": [{steps}]}}'
    return json.dumps({"plan": [json.loads(part) for part in parts]})


def names_listed_alone(parts: tuple[str, ...], form: Schema) -> bool:
    """Whether a plan names only objects that its question lists: some of the data set's name others."""
    steps = [json.loads(f"{{{part}}}") for part in parts if part.startswith('"')]
    return {word for step in steps for named in step.values() for word in named} <= {*words(form)}


@pytest.mark.parametrize(("name", "ability"), SUITES)
def test_good_answers_have_the_form_and_are_read_alike(
    name: str, ability: Ability, data_store: Store
) -> None:
    found, source = benchmark(name), Source(data_store)
    book = open_answer_book(found, ability, source)
    protocols = PROTOCOLS if name in ("virtualhome", "behavior") else (Protocol.STRICT,)
    suites = [open_suite(found, ability, each, source=source) for each in protocols]
    for task_id, form in forms(name, ability, data_store).items():
        gold = book[task_id]
        written = in_form(name, ability, gold.parts, gold.text)
        if name != "virtualhome" or names_listed_alone(gold.parts, form):
            jsonschema.validate(json.loads(written), form)
        for suite in suites:
            if ability is Ability.ACTION_SEQUENCING and task_id in suite.task_ids:
                assert suite.score(task_id, written) == suite.score(task_id, gold.text), task_id


@pytest.mark.parametrize("prompts", get_args(PromptSet))
@pytest.mark.parametrize(("name", "ability"), SUITES)
def test_a_form_has_only_words_that_are_asked_with_and_no_more_than_providers_take(
    name: str, ability: Ability, prompts: PromptSet, data_store: Store
) -> None:
    asked = questions(name, ability, data_store, prompts)
    declared = {operator.name for operator in benchmark(name).domain.operators}
    declared |= {spelling for spelling, _ in benchmark(name).notation.goals.words(benchmark(name).domain)}
    for task_id, form in forms(name, ability, data_store, prompts).items():
        assert is_accepted(form)
        question = f"{asked[task_id].system}{asked[task_id].user}"
        for word in words(form):
            assert word in question or word in declared or word in ("not", "yes", "no", ""), word


def test_an_object_that_is_not_there_has_not_the_form(data_store: Store) -> None:
    form = forms("virtualhome", Ability.ACTION_SEQUENCING, data_store)["27_2"]
    good = {"action commands": [{"WALK": ["soap", "1002"]}, {"STANDUP": []}, {"WALK": ["soap"]}]}
    jsonschema.validate(good, form)
    for steps in ([{"WALK": ["unicorn"]}], [{"FLY": ["soap"]}], [{"WALK": ["soap"], "GRAB": ["soap"]}]):
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate({"action commands": steps}, form)


@pytest.mark.parametrize(
    ("objects", "is_good"),
    [("ball,box", True), ("ball, box", True), ("box", False), ("ball,box,box", False), ("ball,sky", False)],
)
def test_two_objects_are_one_text(objects: str, is_good: bool, data_store: Store) -> None:
    form = forms("lamps", Ability.ACTION_SEQUENCING, data_store, every=1)["pack"]
    answer = {"plan": [{"action": "PUT", "object": objects}]}
    assert jsonschema.Draft202012Validator(form).is_valid(answer) == is_good


@pytest.mark.parametrize(("name", "open_ones"), [("virtualhome", 30), ("behavior", 0)])
def test_where_there_are_too_many_words_objects_may_have_any_name(
    name: str, open_ones: int, data_store: Store
) -> None:
    tasks = benchmark(name).tasks(Source(data_store))
    found = forms(name, Ability.ACTION_SEQUENCING, data_store, every=1)
    named = [
        set(benchmark(name).notation.plans.words(tasks[i])) <= set(words(form)) for i, form in found.items()
    ]
    assert named.count(False) == open_ones


def test_a_form_tells_nothing_that_the_question_does_not(data_store: Store) -> None:
    lamps = benchmark("lamps")
    task = lamps.tasks(Source(data_store))["light"]
    listing = Prompt("robot lamp_1 lamp_2 ball box")
    for prompt, about in ((Prompt("robot lamp_1 lamp_20 ball box"), task), (listing, None)):
        form = answer_form(lamps, Ability.ACTION_SEQUENCING, about, prompt)
        assert not {"lamp_1", "ball"} & set(words(form))
    assert "ball" in words(answer_form(lamps, Ability.ACTION_SEQUENCING, task, listing))


def test_a_notation_that_says_nothing_of_its_form_is_asked_for_none(data_store: Store) -> None:
    class Terse(type(benchmark("lamps").notation.plans)):  # type: ignore[misc]
        schema = PlanNotation.schema

    terse = replace(benchmark("lamps"), notation=Notation(Terse()))
    task = terse.tasks(Source(data_store))["light"]
    assert answer_form(terse, Ability.ACTION_SEQUENCING, task, Prompt("lamp_1")) is None
