"""The abilities that built-in models answer."""

from __future__ import annotations

from contextlib import nullcontext
from typing import Any

import pytest

from eai.abilities.protocol import PAPER_ABILITIES, Ability, find_ability_entry_points
from eai.agents.setting import ACTING
from eai.base.errors import InputError
from eai.benchmarks.copied_answers import (
    open_answers_copied_from_questions,
    open_answers_of_similar_tasks,
    open_empty_answers,
)
from eai.benchmarks.gold_answers import open_answers_of_planner
from eai.benchmarks.random_answers import open_random_answers
from eai.run.job import EXPLORERS, MODELS, can_model_answer, check_model_name
from worlds.warehouse import warehouse

OPENED: dict[str, Any] = {
    "planner": open_answers_of_planner,
    "lookup": open_answers_of_similar_tasks,
    "copy": open_answers_copied_from_questions,
    "empty": open_empty_answers,
    "random": open_random_answers,
}


@pytest.mark.parametrize("ability", [each for each in find_ability_entry_points() if each != ACTING], ids=str)
@pytest.mark.parametrize("model", OPENED)
def test_built_in_models_answer_only_their_abilities(model: str, ability: Ability) -> None:
    expected = nullcontext() if can_model_answer(f"eai/{model}", ability) else pytest.raises(InputError)
    with expected:
        OPENED[model](warehouse, ability)


def test_explorers_only_act_and_other_models_answer_all() -> None:
    for model in EXPLORERS:
        assert [each for each in (*PAPER_ABILITIES, ACTING) if can_model_answer(f"eai/{model}", each)] == [
            ACTING
        ]
    assert all(
        can_model_answer(model, each)
        for model in ("eai/oracle", "openai/planner")
        for each in (*PAPER_ABILITIES, ACTING)
    )


@pytest.mark.parametrize("name", ["gpt-4o", "llama3", "m"])
def test_a_name_without_a_provider_does_not_suggest_a_built_in_model(name: str) -> None:
    with pytest.raises(InputError, match=r"expected PROVIDER/NAME, such as openai/gpt-4o or eai/oracle$"):
        check_model_name(name)


@pytest.mark.parametrize(("name", "model"), [*((model, model) for model in MODELS), ("orcale", "oracle")])
def test_a_built_in_model_without_its_provider_is_suggested(name: str, model: str) -> None:
    with pytest.raises(InputError, match=rf"did you mean eai/{model}\?$"):
        check_model_name(name)
