"""Schemas of answers: good answers fit them, and are read in them as in free text."""

from __future__ import annotations

import importlib.util
import json
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from typing import get_args

import pytest

from by_path import ROOT
from eai.abilities.answer_schema import Schema, is_schema_accepted_by_providers
from eai.abilities.notation.notation import Notation
from eai.abilities.notation.plans import PlanNotation
from eai.abilities.protocol import PAPER_ABILITIES, Ability, Protocol
from eai.base.store import DataPackStore
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.gold_answers import open_gold_answers
from eai.benchmarks.prompt_library import PromptLibrary, make_answer_schema
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.suite import open_suite
from eai.tasks.prompts.prompt import Prompt, PromptSet
from eai.tasks.source import Source
from eai.tasks.special import AmbiguousTaskMark, PossiblyImpossibleTaskMark, SpecialTaskMark
from protocols import PROTOCOLS

jsonschema = pytest.importorskip("jsonschema")

FOLDER = ROOT / "examples" / "lamps"
SUITES = [(name, ability) for name in ("virtualhome", "behavior", "lamps") for ability in PAPER_ABILITIES]
SAMPLE_STEP = 30
"""Every task of this step is tested."""


@cache
def benchmark(name: str) -> Benchmark:
    if name != "lamps":
        return find_benchmark(name)
    spec = importlib.util.spec_from_file_location("lamps_of_answer_forms", FOLDER / "lamps.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    lamps: Benchmark = module.lamps
    return lamps


@cache
def open_questions(
    name: str, ability: Ability, store: DataPackStore, prompts: PromptSet
) -> Mapping[str, Prompt]:
    return PromptLibrary(prompts, None, Source(store)).open(benchmark(name), ability)


def make_forms(
    name: str, ability: Ability, store: DataPackStore, prompts: PromptSet = "eai", every: int = SAMPLE_STEP
) -> Mapping[str, Schema]:
    declared = benchmark(name)
    tasks, prompts_by_task = declared.tasks(Source(store)), open_questions(name, ability, store, prompts)
    chosen = {
        task_id: make_answer_schema(declared, ability, tasks.get(task_id), prompts_by_task[task_id])
        for task_id in [*prompts_by_task][::every]
    }
    return {task_id: form for task_id, form in chosen.items() if form is not None}


def list_words(schema: object) -> list[str]:
    """Return all words that a schema offers."""
    if isinstance(schema, Mapping):
        return [*schema.get("enum", ()), *[word for value in schema.values() for word in list_words(value)]]
    if isinstance(schema, list | tuple):
        return [word for value in schema for word in list_words(value)]
    return []


def write_in_form(name: str, ability: Ability, parts: tuple[str, ...], text: str) -> str:
    """Return a gold answer in the required form; only plans have another form by default."""
    if ability is not Ability.ACTION_SEQUENCING:
        return text
    if name == "virtualhome":
        steps = ", ".join(f"{{{part}}}" for part in parts)
        return f'{{"action commands": [{steps}]}}'
    return json.dumps({"plan": [json.loads(part) for part in parts]})


def has_only_listed_names(parts: tuple[str, ...], form: Schema) -> bool:
    """Whether a plan names only objects in its question; some plans of the data set name others."""
    steps = [json.loads(f"{{{part}}}") for part in parts if part.startswith('"')]
    return {word for step in steps for named in step.values() for word in named} <= {*list_words(form)}


@pytest.mark.parametrize(("name", "ability"), SUITES)
def test_gold_answers_fit_the_schema_and_score_alike_in_it(
    name: str, ability: Ability, data_store: DataPackStore
) -> None:
    declared, source = benchmark(name), Source(data_store)
    book = open_gold_answers(declared, ability, source)
    protocols = PROTOCOLS if name in ("virtualhome", "behavior") else (Protocol.STRICT,)
    suites = [open_suite(declared, ability, protocol, source=source) for protocol in protocols]
    for task_id, form in make_forms(name, ability, data_store).items():
        gold = book[task_id]
        written = write_in_form(name, ability, gold.parts, gold.text)
        if name != "virtualhome" or has_only_listed_names(gold.parts, form):
            jsonschema.validate(json.loads(written), form)
        for suite in suites:
            if ability is Ability.ACTION_SEQUENCING and task_id in suite.task_ids:
                assert suite.score(task_id, written) == suite.score(task_id, gold.text), task_id


@pytest.mark.parametrize("prompts", get_args(PromptSet))
@pytest.mark.parametrize(("name", "ability"), SUITES)
def test_a_schema_has_only_words_of_the_question_and_not_too_many(
    name: str, ability: Ability, prompts: PromptSet, data_store: DataPackStore
) -> None:
    prompts_by_task = open_questions(name, ability, data_store, prompts)
    declared = {operator.name for operator in benchmark(name).domain.operators}
    declared |= {
        spelling
        for spelling, _ in benchmark(name).notation.goals.map_spellings_to_predicate_names(
            benchmark(name).domain
        )
    }
    for task_id, form in make_forms(name, ability, data_store, prompts).items():
        assert is_schema_accepted_by_providers(form)
        question = f"{prompts_by_task[task_id].system}{prompts_by_task[task_id].user}"
        for word in list_words(form):
            assert word in question or word in declared or word in ("not", "yes", "no", ""), word


def test_a_plan_with_an_unknown_object_does_not_fit_the_schema(data_store: DataPackStore) -> None:
    form = make_forms("virtualhome", Ability.ACTION_SEQUENCING, data_store)["27_2"]
    good = {"action commands": [{"WALK": ["soap", "1002"]}, {"STANDUP": []}, {"WALK": ["soap"]}]}
    jsonschema.validate(good, form)
    for steps in ([{"WALK": ["unicorn"]}], [{"FLY": ["soap"]}], [{"WALK": ["soap"], "GRAB": ["soap"]}]):
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate({"action commands": steps}, form)


@pytest.mark.parametrize(
    ("objects", "is_good"),
    [("ball,box", True), ("ball, box", True), ("box", False), ("ball,box,box", False), ("ball,sky", False)],
)
def test_a_schema_lists_pairs_of_objects_as_one_text(
    objects: str, is_good: bool, data_store: DataPackStore
) -> None:
    form = make_forms("lamps", Ability.ACTION_SEQUENCING, data_store, every=1)["pack"]
    answer = {"plan": [{"action": "PUT", "object": objects}]}
    assert jsonschema.Draft202012Validator(form).is_valid(answer) == is_good


@pytest.mark.parametrize(("name", "open_ones"), [("virtualhome", 30), ("behavior", 0)])
def test_a_schema_with_too_many_words_accepts_any_object_name(
    name: str, open_ones: int, data_store: DataPackStore
) -> None:
    tasks = benchmark(name).tasks(Source(data_store))
    forms = make_forms(name, Ability.ACTION_SEQUENCING, data_store, every=1)
    named = [
        set(benchmark(name).notation.plans.list_words_that_name_objects(tasks[i])) <= set(list_words(form))
        for i, form in forms.items()
    ]
    assert named.count(False) == open_ones


def test_a_schema_reveals_no_objects_that_the_question_omits(data_store: DataPackStore) -> None:
    lamps = benchmark("lamps")
    task = lamps.tasks(Source(data_store))["light"]
    listing = Prompt("robot lamp_1 lamp_2 ball box")
    for prompt, about in ((Prompt("robot lamp_1 lamp_20 ball box"), task), (listing, None)):
        form = make_answer_schema(lamps, Ability.ACTION_SEQUENCING, about, prompt)
        assert not {"lamp_1", "ball"} & set(list_words(form))
    assert "ball" in list_words(make_answer_schema(lamps, Ability.ACTION_SEQUENCING, task, listing))


@pytest.mark.parametrize("special", [PossiblyImpossibleTaskMark(()), AmbiguousTaskMark(("lamp_1",))])
def test_an_answer_that_may_decline_a_task_may_have_any_form(
    special: SpecialTaskMark, data_store: DataPackStore
) -> None:
    lamps = benchmark("lamps")
    task, prompt = lamps.tasks(Source(data_store))["light"], Prompt("robot lamp_1 lamp_2 ball box")
    assert make_answer_schema(lamps, Ability.ACTION_SEQUENCING, task, prompt) is not None
    special_task = replace(task, special=special)
    assert make_answer_schema(lamps, Ability.ACTION_SEQUENCING, special_task, prompt) is None


def test_a_notation_without_a_schema_requires_none(data_store: DataPackStore) -> None:
    class Terse(type(benchmark("lamps").notation.plans)):  # type: ignore[misc]
        make_json_schema_of_answer = PlanNotation.make_json_schema_of_answer

    terse = replace(benchmark("lamps"), notation=Notation(Terse()))
    task = terse.tasks(Source(data_store))["light"]
    assert make_answer_schema(terse, Ability.ACTION_SEQUENCING, task, Prompt("lamp_1")) is None
