"""The null models `eai/copy` and `eai/empty`: their answers do not use the right answer of a task."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace

import pytest

from eai import make_task
from eai.abilities.protocol import PAPER_ABILITIES, Ability
from eai.base.store import DataPackStore
from eai.benchmarks.behavior.tasks import BehaviorTask
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.copied_answers import (
    find_mentions,
    open_answers_copied_from_questions,
    open_answers_of_similar_tasks,
    open_empty_answers,
)
from eai.benchmarks.random_answers import open_random_answers
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.suite import open_suite
from eai.logic.formula import Occurs
from eai.pddl.model import OperatorText
from eai.tasks.operator_task import OperatorLibrary, TransitionTask
from eai.tasks.source import Source, TaskSet, use_tasks
from eai.tasks.task import Task
from eai.world import (
    Add,
    Constant,
    Delete,
    Domain,
    Formula,
    Not,
    Operator,
    Predicate,
    Scene,
    Variable,
    Vocabulary,
    WorldObject,
)

X = Variable("x")
lit, warm = Predicate("lit", 1), Predicate("warm", 1)
DOMAIN = Domain(
    "toy",
    Vocabulary((lit, warm)),
    (
        Operator("LIGHT", (X,), (), (Add(lit(X)),)),
        Operator("DARKEN", (X,), (), (Delete(lit(X)),)),
        Operator("HEAT", (X,), (), (Add(warm(X)),)),
        Operator("WAIT", (), (), ()),
    ),
)
SCENE = Scene(DOMAIN.vocabulary, [WorldObject("lamp", "lamp"), WorldObject("big_oven", "oven")])
LAMP, OVEN = Constant("lamp"), Constant("big_oven")


def toy(*goals: Formula, instruction: str = "") -> Benchmark:
    return Benchmark("toy", DOMAIN, use_tasks(make_task("1", instruction, SCENE.state([]), *goals)))


def copy(benchmark: Benchmark, ability: Ability) -> object:
    return json.loads(open_answers_copied_from_questions(benchmark, ability)["1"].text)


def test_names_are_found_with_other_endings_and_in_several_words() -> None:
    words = ["slice", "the", "tomatoes", "and", "put", "them", "next", "to", "big", "ovens"]
    assert find_mentions(words, "sliced") == [0]
    assert find_mentions(words, "tomato.n.01_1") == [2]
    assert find_mentions(words, "nextto") == find_mentions(words, "NEXT_TO") == [6]
    assert find_mentions(words, "big_oven") == [8]
    assert find_mentions(words, "oven") == [9]
    assert find_mentions(words, "on") == find_mentions(words, "7") == []


def test_copied_goals_are_all_goals_that_the_instruction_can_state() -> None:
    benchmark = toy(lit(OVEN), instruction="Have the lamp lit and wait")
    assert copy(benchmark, Ability.GOAL_INTERPRETATION) == {
        "node goals": [["lit", "lamp"]],
        "edge goals": [],
        "action goals": ["WAIT"],
    }


def test_the_copied_subgoals_are_the_parts_of_the_goal_with_actions_first() -> None:
    benchmark = toy(Not(warm(OVEN)), Occurs("HEAT"), Occurs("WAIT"), warm(LAMP))
    assert copy(benchmark, Ability.SUBGOAL_DECOMPOSITION) == {
        "output": ["exists x0. (HEAT(x0))", "WAIT()", "not warm(big_oven)", "warm(lamp)"]
    }
    assert copy(toy(), Ability.SUBGOAL_DECOMPOSITION) == {"output": []}


def test_the_copied_plan_has_an_action_for_each_part_of_the_goal() -> None:
    benchmark = toy(Not(lit(OVEN)), warm(LAMP), Occurs("LIGHT"))
    plan = copy(benchmark, Ability.ACTION_SEQUENCING)
    assert isinstance(plan, list)
    assert [tuple(step.values()) for step in plan] == [
        ("DARKEN", "big_oven"),
        ("HEAT", "lamp"),
        ("LIGHT", "lamp"),
    ]


def test_the_copied_plan_uses_the_relevant_object_even_if_it_is_listed_twice() -> None:
    benchmark = toy(Occurs("LIGHT")).with_changed_tasks(lambda task: replace(task, relevant=(0, 0)))
    assert copy(benchmark, Ability.ACTION_SEQUENCING) == [{"action": "LIGHT", "object": "lamp"}]


def test_copied_operators_apply_the_goal_to_their_parameters() -> None:
    benchmark = toy(lit(LAMP), Not(warm(OVEN)))
    written = copy(benchmark, Ability.TRANSITION_MODELING)
    assert isinstance(written, dict)
    text = " ".join(str(written["output"]).split())
    assert text == (
        "(:action light :parameters (?x - object) :precondition (and) :effect (and (lit ?x) (not (warm ?x))))"
    )


@pytest.mark.parametrize("ability", PAPER_ABILITIES)
def test_an_empty_answer_has_the_required_form(ability: Ability) -> None:
    benchmark = toy(lit(LAMP))
    text = open_empty_answers(benchmark, ability)["1"].text
    assert not any(json.loads(text).values()) if ability is not Ability.ACTION_SEQUENCING else text == "[]"
    assert not getattr(open_suite(benchmark, ability).score("1", text), "success", False)


Answers = Callable[[Benchmark, Ability], Callable[[str], str]]


def answer_by_copy(benchmark: Benchmark, ability: Ability) -> Callable[[str], str]:
    book = open_answers_copied_from_questions(benchmark, ability)
    return lambda task_id: book[task_id].text


def answer_by_lookup(benchmark: Benchmark, ability: Ability) -> Callable[[str], str]:
    book = open_answers_of_similar_tasks(benchmark, ability)
    return lambda task_id: book[task_id].text


def answer_by_chance(benchmark: Benchmark, ability: Ability) -> Callable[[str], str]:
    draw = open_random_answers(benchmark, ability)
    return lambda task_id: draw(task_id, "0 1 1", ()).text


def remove_answer(task: Task, ability: Ability) -> Task:
    """Return a task with only the content of its question; goal interpretation also hides the goals."""
    question = replace(task, script=(), annotated_final=None)
    if ability is Ability.GOAL_INTERPRETATION:
        question = replace(question, goals=())
        question = (
            replace(question, record=replace(question.record, goal_options=()))
            if isinstance(question, BehaviorTask)
            else question
        )
    return question


@pytest.mark.usefixtures("data_store")
@pytest.mark.parametrize("answers", [answer_by_copy, answer_by_lookup, answer_by_chance])
@pytest.mark.parametrize(
    "ability", [ability for ability in PAPER_ABILITIES if ability is not Ability.TRANSITION_MODELING]
)
@pytest.mark.parametrize("name", ["virtualhome", "behavior"])
def test_null_models_do_not_use_the_right_answer(answers: Answers, ability: Ability, name: str) -> None:
    benchmark = find_benchmark(name)
    tasks = benchmark.open_tasks(Source())
    blind = TaskSet(tasks, lambda task_id: remove_answer(tasks[task_id], ability), "")
    public = replace(benchmark, data=replace(benchmark.data, open_public=benchmark.open_tasks))
    stripped = replace(public, open_tasks=lambda source: blind)
    seeing, unseeing = answers(public, ability), answers(stripped, ability)
    for task_id in list(benchmark.tasks_for(ability, Source()))[3:60:14]:
        assert seeing(task_id) == unseeing(task_id)


@pytest.mark.usefixtures("data_store")
@pytest.mark.parametrize("name", ["virtualhome", "behavior"])
def test_the_copying_model_does_not_use_gold_operators(name: str) -> None:
    benchmark = find_benchmark(name)
    tasks = benchmark.operator_tasks(Source())

    def remove_answer(task_id: str) -> TransitionTask:
        task = tasks[task_id]
        blank = {n: OperatorText(n, o.parameters, "()", "()") for n, o in task.domain.operators.items()}
        library = OperatorLibrary(task.domain.header, blank, task.domain.categories)
        return TransitionTask(task.id, library, task.operators, task.categories, task.problem_text)

    blind = TaskSet(tasks, remove_answer, "")
    ability = Ability.TRANSITION_MODELING
    stripped = replace(benchmark, data=replace(benchmark.data, own_tasks={ability: lambda source: blind}))
    seeing, unseeing = (answer_by_copy(variant, ability) for variant in (benchmark, stripped))
    for task_id in list(tasks)[3:60:14]:
        assert seeing(task_id) == unseeing(task_id)


def test_the_copied_subgoals_are_stated_in_the_question(data_store: DataPackStore) -> None:
    book = open_answers_copied_from_questions(
        find_benchmark("virtualhome"), Ability.SUBGOAL_DECOMPOSITION, Source(data_store)
    )
    assert json.loads(book["481_2"].text)["output"] == [
        "exists x0. (TYPE(x0))",
        "exists x0. (SWITCHOFF(x0))",
    ]
    assert json.loads(book["298_2"].text)["output"] == [
        "OPEN(freezer.289)",
        "PLUGGED_IN(freezer.289)",
        "INSIDE(food_food.1000, freezer.289)",
    ]
