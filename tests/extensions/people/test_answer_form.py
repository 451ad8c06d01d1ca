from __future__ import annotations

import json
import re

import pytest

from eai.abilities.protocol import Ability
from eai.base.store import DataPackStore
from eai.benchmarks.registry import find_benchmark
from eai.extensions.people.answer_form import (
    FIRST,
    PREDICATE,
    SECOND,
    build_answer_form,
    make_goal_answer_template,
)
from eai.tasks.source import Source
from suites import official_prompts


def content_of(page: str) -> dict[str, object]:
    (found,) = re.findall('<script type="application/json" id="data">(.*?)</script>', page, re.DOTALL)
    return dict(json.loads(found))


def test_the_page_has_the_prompts_as_they_are_and_reaches_for_nothing(data_store: DataPackStore) -> None:
    prompts = official_prompts("behavior", Ability.SUBGOAL_DECOMPOSITION, data_store)
    chosen = dict(list(prompts.items())[3:5])
    page = build_answer_form(find_benchmark("behavior"), Ability.SUBGOAL_DECOMPOSITION, chosen)
    assert content_of(page)["questions"] == [
        {"task": task_id, "system": prompt.system, "user": prompt.user, "sha256": prompt.sha256}
        for task_id, prompt in chosen.items()
    ]
    assert "default-src 'none'" in page
    assert not re.search(r"(?:src|href)=|https?://|url\(", page.partition('id="data"')[0])
    assert page == build_answer_form(find_benchmark("behavior"), Ability.SUBGOAL_DECOMPOSITION, chosen)


def test_the_pattern_of_goals_is_that_of_the_notation(data_store: DataPackStore) -> None:
    assert make_goal_answer_template(find_benchmark("behavior"), Source(data_store)) == {
        "node goals": [[PREDICATE, FIRST]],
        "edge goals": [[PREDICATE, FIRST, SECOND]],
    }
    assert make_goal_answer_template(find_benchmark("virtualhome"), Source(data_store)) == {
        "node goals": [{"name": FIRST, "state": PREDICATE}],
        "edge goals": [{"from_name": FIRST, "relation": PREDICATE, "to_name": SECOND}],
        "action goals": [{"action": PREDICATE, "description": PREDICATE}],
    }


@pytest.mark.parametrize("domain", ["virtualhome", "behavior"])
def test_the_table_of_operators_tells_no_more_than_the_question(
    data_store: DataPackStore, domain: str
) -> None:
    prompts = official_prompts(domain, Ability.TRANSITION_MODELING, data_store)
    page = build_answer_form(find_benchmark(domain), Ability.TRANSITION_MODELING, prompts, Source(data_store))
    operators = content_of(page)["operators"]
    assert isinstance(operators, dict)
    assert list(operators) == list(prompts)
    for task_id, prompt in prompts.items():
        question = "".join(prompt.user.replace(")", "").split())
        for each in operators[task_id]:
            said = f"(:action {each['name']} :parameters {each['parameters']}".replace(")", "")
            assert "".join(said.split()) in question
