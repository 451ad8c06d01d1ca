from __future__ import annotations

import hashlib
import json
import re
from collections import Counter
from typing import get_args

import pytest

from eai.abilities.protocol import PAPER_ABILITIES, Ability
from eai.abilities.transition_modeling.scorer import TransitionModeling
from eai.base.store import Store
from eai.benchmarks.packs import open_pack
from eai.benchmarks.prompt_library import Library
from eai.benchmarks.published import TransitionTasks, open_behavior, open_virtualhome
from eai.benchmarks.reference_wheel import PROMPTS, SCENE_PREFIX
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.suite import open_suite
from eai.pddl.planning import PlannerChoice
from eai.tasks.prompts.prompt import PromptSet
from eai.tasks.source import ErrataChoice, Source
from eai.tasks.task import Category
from suites import SUITES, official_files, official_prompts


def sizes(tasks: TransitionTasks) -> dict[str, int]:
    found = Counter(category.value for task in tasks.values() for category in task.categories)
    return dict(found)


def test_virtualhome_is_categorised_as_the_data_set_has_it(data_store: Store) -> None:
    assert sizes(open_virtualhome(Source(data_store))) == {
        "object_states": 178,
        "object_affordance": 167,
        "object_orientation": 28,
        "spatial_relations": 145,
        "non_spatial_relations": 74,
    }


def test_behavior_is_categorised_as_the_data_set_has_it(data_store: Store) -> None:
    assert sizes(open_behavior(Source(data_store))) == {
        "object_states": 45,
        "spatial_relations": 94,
        "non_spatial_relations": 61,
    }


def test_tools_are_no_category_of_tasks(data_store: Store) -> None:
    tasks = open_virtualhome(Source(data_store))
    assert Category.OBJECT_TOOLS in next(iter(tasks.values())).domain.categories.values()
    assert all(Category.OBJECT_TOOLS not in task.categories for task in tasks.values())


GOAL_INTERPRETATION = ("virtualhome", Ability.GOAL_INTERPRETATION)
OPERATORS = ("behavior", Ability.TRANSITION_MODELING)
COUNTS = {
    ("virtualhome", Ability.GOAL_INTERPRETATION): 342,
    ("virtualhome", Ability.SUBGOAL_DECOMPOSITION): 338,
    ("virtualhome", Ability.ACTION_SEQUENCING): 342,
    ("virtualhome", Ability.TRANSITION_MODELING): 296,
    **{("behavior", ability): 100 for ability in PAPER_ABILITIES},
}
SYSTEM = {
    ("virtualhome", Ability.SUBGOAL_DECOMPOSITION),
    ("behavior", Ability.GOAL_INTERPRETATION),
    ("behavior", Ability.SUBGOAL_DECOMPOSITION),
}


@pytest.mark.parametrize(("suite", "count"), COUNTS.items())
def test_every_task_has_a_prompt(data_store: Store, suite: tuple[str, Ability], count: int) -> None:
    prompts = official_prompts(*suite, data_store)
    assert len(prompts) == count
    assert not any(task_id.startswith(SCENE_PREFIX) for task_id in prompts)
    assert len({prompt.sha256 for prompt in prompts.values()}) > count // 2
    assert all((p.system is not None) == (suite in SYSTEM) for p in prompts.values())
    assert all(p.stop == (("}",) if suite in SYSTEM else ()) for p in prompts.values())


@pytest.mark.parametrize("suite", COUNTS.keys() - {GOAL_INTERPRETATION})
def test_shipped_prompts_are_given_byte_for_byte(data_store: Store, suite: tuple[str, Ability]) -> None:
    domain, ability = suite
    pack = open_pack(PROMPTS, Source(data_store))
    files = official_files(domain, ability, data_store, ErrataChoice.NONE)
    assert files.prompts == pack.read(f"{domain}/{ability.value}.json")
    if suite in SYSTEM:
        assert files.system == pack.read(f"{domain}/{ability.value}_system.json")
    texts = [row["llm_prompt"] for row in json.loads(files.prompts)]
    published = official_prompts(domain, ability, data_store, ErrataChoice.NONE)
    assert [prompt.user for prompt in published.values()] == texts
    asked = official_prompts(domain, ability, data_store)
    changed = {task_id for task_id, prompt in asked.items() if prompt != published[task_id]}
    assert changed == find_benchmark(domain).errata.questioned(ability)


def operators_asked_for(question: str) -> dict[str, str]:
    """Name -> parameters of the operators behind the last goal of a question, which is the task's own."""
    heads = question[question.rindex("(:goal") :]
    found = re.findall(r"\(:action\s+([^\s()]+)\)?\s*:parameters\s*(\([^()]*\))", heads)
    assert len(dict(found)) == len(found) == heads.count("(:action")
    return {name: " ".join(parameters.split()) for name, parameters in found}


@pytest.mark.parametrize("prompts", get_args(PromptSet))
@pytest.mark.parametrize("name", ["virtualhome", "behavior"])
def test_the_operators_that_are_asked_for_are_those_that_are_scored(
    data_store: Store, name: str, prompts: PromptSet
) -> None:
    ability = Ability.TRANSITION_MODELING
    source = Source(data_store, planner=PlannerChoice.NONE)
    questions = Library(prompts, None, source).open(find_benchmark(name), ability)
    suite = open_suite(name, ability, source=source)
    assert len(questions) == COUNTS[name, ability]
    for task_id, question in questions.items():
        scorer = suite.scorer(task_id)
        assert isinstance(scorer, TransitionModeling)
        library = scorer.task.domain.operators
        expected = {each: " ".join(library[each].parameters.split()) for each in scorer.task.operators}
        assert operators_asked_for(question.user) == expected, task_id


def test_questions_about_operators_are_corrected_where_they_ask_for_others_and_nowhere_else(
    data_store: Store,
) -> None:
    shipped = open_pack(PROMPTS, Source(data_store)).read_json("behavior/transition_modeling.json")
    rows = json.loads(official_files(*OPERATORS, data_store).prompts)
    changed = 0
    for old, new in zip(shipped, rows, strict=True):
        assert old.keys() == new.keys()
        assert old["identifier"] == new["identifier"]
        before, after = old["llm_prompt"], new["llm_prompt"]
        place = before.rindex("Action to be finished:")
        assert (before[:place], before[-10:]) == (after[:place], after[-10:])
        assert (operators_asked_for(before) == operators_asked_for(after)) is (before == after)
        changed += before != after
    assert changed == 25


@pytest.mark.parametrize("suite", SUITES)
def test_prompts_name_the_tasks_that_are_scored(data_store: Store, suite: tuple[str, Ability]) -> None:
    task_ids = open_suite(*suite, source=Source(data_store, planner=PlannerChoice.NONE)).task_ids
    assert sorted(official_prompts(*suite, data_store)) == sorted(task_ids)


def test_rendered_goal_interpretation_is_as_it_was_compared(data_store: Store) -> None:
    """The digest is of prompts compared with the reference's own output, line for line and all 342 tasks.

    They differed in nothing but the order of what the reference prints from sets.
    """
    digest = hashlib.sha256(official_files(*GOAL_INTERPRETATION, data_store).prompts).hexdigest()
    assert digest == "fbe2362d1979919f45e9b603db85814f7885a989a2643b6ba57a9b31b6cf4a1f"
