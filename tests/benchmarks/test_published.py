from __future__ import annotations

import hashlib
import json
import re
from collections import Counter
from typing import get_args

import pytest

from eai.abilities.protocol import PAPER_ABILITIES, Ability
from eai.abilities.transition_modeling.scorer import TransitionModelingScorer
from eai.base.store import DataPackStore
from eai.benchmarks.packs import open_pack
from eai.benchmarks.prompt_library import PromptLibrary
from eai.benchmarks.published import (
    TransitionTasks,
    open_behavior_transition_tasks,
    open_virtualhome_transition_tasks,
)
from eai.benchmarks.reference_wheel import PROMPTS, SCENE_PREFIX
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.suite import open_suite
from eai.pddl.planning import PlannerChoice
from eai.tasks.prompts.prompt import PromptSet
from eai.tasks.source import ErrataChoice, Source
from eai.tasks.task import PredicateCategory
from suites import SUITES, official_files, official_prompts


def count_categories(tasks: TransitionTasks) -> dict[str, int]:
    counts = Counter(category.value for task in tasks.values() for category in task.categories)
    return dict(counts)


def test_virtualhome_tasks_have_the_categories_of_the_data_set(data_store: DataPackStore) -> None:
    assert count_categories(open_virtualhome_transition_tasks(Source(data_store))) == {
        "object_states": 178,
        "object_affordance": 167,
        "object_orientation": 28,
        "spatial_relations": 145,
        "non_spatial_relations": 74,
    }


def test_behavior_tasks_have_the_categories_of_the_data_set(data_store: DataPackStore) -> None:
    assert count_categories(open_behavior_transition_tasks(Source(data_store))) == {
        "object_states": 45,
        "spatial_relations": 94,
        "non_spatial_relations": 61,
    }


def test_no_task_has_the_category_of_tools(data_store: DataPackStore) -> None:
    tasks = open_virtualhome_transition_tasks(Source(data_store))
    assert PredicateCategory.OBJECT_TOOLS in next(iter(tasks.values())).domain.categories.values()
    assert all(PredicateCategory.OBJECT_TOOLS not in task.categories for task in tasks.values())


GOAL_INTERPRETATION = ("virtualhome", Ability.GOAL_INTERPRETATION)
OPERATORS = ("behavior", Ability.TRANSITION_MODELING)
COUNTS = {
    ("virtualhome", Ability.GOAL_INTERPRETATION): 342,
    ("virtualhome", Ability.SUBGOAL_DECOMPOSITION): 338,
    ("virtualhome", Ability.ACTION_SEQUENCING): 342,
    ("virtualhome", Ability.TRANSITION_MODELING): 296,
    **{("behavior", ability): 100 for ability in PAPER_ABILITIES},
}
WITH_SYSTEM_MESSAGE = {
    ("virtualhome", Ability.SUBGOAL_DECOMPOSITION),
    ("behavior", Ability.GOAL_INTERPRETATION),
    ("behavior", Ability.SUBGOAL_DECOMPOSITION),
}


@pytest.mark.parametrize(("suite", "count"), COUNTS.items())
def test_every_task_has_a_prompt(data_store: DataPackStore, suite: tuple[str, Ability], count: int) -> None:
    prompts = official_prompts(*suite, data_store)
    assert len(prompts) == count
    assert not any(task_id.startswith(SCENE_PREFIX) for task_id in prompts)
    assert len({prompt.sha256 for prompt in prompts.values()}) > count // 2
    assert all((p.system is not None) == (suite in WITH_SYSTEM_MESSAGE) for p in prompts.values())
    assert all(p.stop == (("}",) if suite in WITH_SYSTEM_MESSAGE else ()) for p in prompts.values())


@pytest.mark.parametrize("suite", sorted(COUNTS.keys() - {GOAL_INTERPRETATION}))
def test_published_prompts_are_unchanged_except_for_errata(
    data_store: DataPackStore, suite: tuple[str, Ability]
) -> None:
    domain, ability = suite
    pack = open_pack(PROMPTS, Source(data_store))
    files = official_files(domain, ability, data_store, ErrataChoice.NONE)
    assert files.prompts == pack.read_member(f"{domain}/{ability.value}.json")
    if suite in WITH_SYSTEM_MESSAGE:
        assert files.system == pack.read_member(f"{domain}/{ability.value}_system.json")
    texts = [row["llm_prompt"] for row in json.loads(files.prompts)]
    published = official_prompts(domain, ability, data_store, ErrataChoice.NONE)
    assert [prompt.user for prompt in published.values()] == texts
    corrected = official_prompts(domain, ability, data_store)
    changed = {task_id for task_id, prompt in corrected.items() if prompt != published[task_id]}
    assert changed == find_benchmark(domain).data.errata.find_corrected_tasks(ability)


def read_requested_operators(question: str) -> dict[str, str]:
    """Return the parameters of each operator that a question requests after its own goal."""
    heads = question[question.rindex("(:goal") :]
    operators = re.findall(r"\(:action\s+([^\s()]+)\)?\s*:parameters\s*(\([^()]*\))", heads)
    assert len(dict(operators)) == len(operators) == heads.count("(:action")
    return {name: " ".join(parameters.split()) for name, parameters in operators}


@pytest.mark.parametrize("prompts", get_args(PromptSet))
@pytest.mark.parametrize("name", ["virtualhome", "behavior"])
def test_questions_request_the_scored_operators(
    data_store: DataPackStore, name: str, prompts: PromptSet
) -> None:
    ability = Ability.TRANSITION_MODELING
    source = Source(data_store, planner=PlannerChoice.NONE)
    questions = PromptLibrary(prompts, None, source).open(find_benchmark(name), ability)
    suite = open_suite(name, ability, source=source)
    assert len(questions) == COUNTS[name, ability]
    for task_id, question in questions.items():
        scorer = suite.scorer(task_id)
        assert isinstance(scorer, TransitionModelingScorer)
        library = scorer.task.domain.operators
        expected = {
            operator: " ".join(library[operator].parameters.split()) for operator in scorer.task.operators
        }
        assert read_requested_operators(question.user) == expected, task_id


def test_questions_are_corrected_only_if_they_request_other_operators(
    data_store: DataPackStore,
) -> None:
    shipped = open_pack(PROMPTS, Source(data_store)).read_json("behavior/transition_modeling.json")
    rows = json.loads(official_files(*OPERATORS, data_store).prompts)
    changed = 0
    for old, new in zip(shipped, rows, strict=True):
        assert old.keys() == new.keys()
        assert old["identifier"] == new["identifier"]
        before, after = old["llm_prompt"], new["llm_prompt"]
        position = before.rindex("Action to be finished:")
        assert (before[:position], before[-10:]) == (after[:position], after[-10:])
        assert (read_requested_operators(before) == read_requested_operators(after)) is (before == after)
        changed += before != after
    assert changed == 25


@pytest.mark.parametrize("suite", SUITES)
def test_prompts_exist_for_exactly_the_scored_tasks(
    data_store: DataPackStore, suite: tuple[str, Ability]
) -> None:
    task_ids = open_suite(*suite, source=Source(data_store, planner=PlannerChoice.NONE)).task_ids
    assert sorted(official_prompts(*suite, data_store)) == sorted(task_ids)


def test_rendered_goal_interpretation_prompts_equal_the_compared_ones(data_store: DataPackStore) -> None:
    """All 342 prompts were compared with the reference's own output line by line.

    They differed only in the order of printed sets.
    """
    digest = hashlib.sha256(official_files(*GOAL_INTERPRETATION, data_store).prompts).hexdigest()
    assert digest == "fbe2362d1979919f45e9b603db85814f7885a989a2643b6ba57a9b31b6cf4a1f"
