"""Our own prompts equal a golden file for a toy domain, and have the required parts for real suites."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest

from eai.abilities.protocol import PAPER_ABILITIES, Ability
from eai.base.store import DataPackStore
from eai.logic.formula import Constant, Exists, Occurs, Or, Variable
from eai.tasks.prompts.own import PromptTemplateValues, render_prompts
from eai.tasks.prompts.template import PromptTemplates
from eai.tasks.task import Goal, GoalKind, Task
from eai.tasks.wording import PromptAndAnswerWording
from suites import official_prompts, own_prompts
from world import toy

GOLDEN = Path(__file__).parent / "golden"


def toy_questions() -> PromptTemplateValues:
    """Two tasks of the toy domain; each lends its answer to the other."""
    state = toy.initial()
    goals = (
        Goal(GoalKind.STATE, toy.lit(Constant("lamp")) & ~toy.holding(Constant("red"))),
        Goal(GoalKind.RELATION, Exists(Variable("x", "box"), toy.at(Variable("x", "box"), Constant("shed")))),
        Goal(GoalKind.ACTION, Or((Occurs("LIFT"), Occurs("PRESS")))),
    )
    relevant = tuple(state.scene.index[name] for name in ("hall", "shed", "red", "lamp"))
    light = Task("1", "Light", "Make it light.", state, goals, relevant)
    carry = replace(light, id="2", title="Carry", instruction="Carry $5.", goals=goals[1:])
    answers = {"1": "GO(shed), PRESS(lamp)", "2": "LIFT(red), GO(shed)"}
    return PromptTemplateValues(
        Ability.ACTION_SEQUENCING.value,
        PromptAndAnswerWording.from_domain(toy.DOMAIN),
        "a robot",
        {"1": light, "2": carry},
        "The answer is a list of actions with their arguments.",
        answers.__getitem__,
    )


def test_any_declared_domain_has_prompts() -> None:
    prompts = render_prompts(toy_questions(), PromptTemplates())
    assert prompts["1"].user == (GOLDEN / "toy_action_sequencing.txt").read_text()
    assert list(prompts) == ["1", "2"]
    assert prompts["2"].user != prompts["1"].user


def test_the_example_is_another_task() -> None:
    questions = toy_questions()
    for task_id, prompt in render_prompts(questions, PromptTemplates()).items():
        assert questions.example(task_id) not in prompt.user
        assert all(questions.example(other) in prompt.user for other in {"1", "2"} - {task_id})


def test_without_another_task_there_is_no_example() -> None:
    questions = toy_questions()
    alone = replace(questions, tasks={"1": questions.tasks["1"]})
    assert "example" not in render_prompts(alone, PromptTemplates())["1"].user


SUITES = [(domain, ability) for domain in ("virtualhome", "behavior") for ability in PAPER_ABILITIES]


@pytest.mark.parametrize(("domain", "ability"), SUITES, ids=str)
def test_every_official_task_has_a_prompt_with_the_answer_to_another(
    data_store: DataPackStore, domain: str, ability: Ability
) -> None:
    prompts = own_prompts(domain, ability, data_store)
    assert prompts.keys() == official_prompts(domain, ability, data_store).keys()
    for task_id, prompt in prompts.items():
        example, _, question = prompt.user.partition("Your task")
        assert "An example of another task" in example
        assert len(example.partition("Answer:")[2]) > 10
        shown = example.partition("An example of another task")[2].partition("Answer:")[0].strip()
        assert shown not in question, task_id


def test_transition_modeling_shows_no_operator_that_it_asks_for(data_store: DataPackStore) -> None:
    suite = ("virtualhome", Ability.TRANSITION_MODELING)
    prompts = own_prompts(*suite, data_store)
    for prompt in prompts.values():
        example, _, question = prompt.user.partition("Your task")
        shown = set(re.findall(r"\(:action (\S+) ", example.partition("Answer:")[2]))
        asked = set(re.findall(r"\(:action (\S+)\n", question))
        assert shown
        assert asked
        assert not shown & asked


def test_goal_interpretation_does_not_show_the_goals(data_store: DataPackStore) -> None:
    suite = ("virtualhome", Ability.GOAL_INTERPRETATION)
    prompt = own_prompts(*suite, data_store)["27_2"].user
    question = prompt.partition("Your task")[2]
    assert "Turn on the washing machine" in question
    assert "ON(washing_machine)" not in question
    assert "ON(x, y)" in prompt  # the relation, as answers name it
    assert "ONTOP" not in prompt
