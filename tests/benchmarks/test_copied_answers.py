"""The null models `eai/copy` and `eai/empty`: what they answer; and none sees the right answer of a task."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace

import pytest

from eai import make_task
from eai.abilities.protocol import PAPER_ABILITIES, Ability
from eai.base.store import Store
from eai.benchmarks.behavior.tasks import BehaviorTask
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.copied_answers import mentions, open_copy_book, open_empty_book, open_lookup_book
from eai.benchmarks.random_answers import open_random_answers
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.suite import open_suite
from eai.logic.formula import Occurs
from eai.pddl.model import OperatorText
from eai.tasks.operator_task import OperatorLibrary, TransitionTask
from eai.tasks.source import Source, TaskSet, given
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
    return Benchmark("toy", DOMAIN, given(make_task("1", instruction, SCENE.state([]), *goals)))


def copied(benchmark: Benchmark, ability: Ability) -> object:
    return json.loads(open_copy_book(benchmark, ability)["1"].text)


def test_a_name_is_found_with_other_endings_and_in_several_words() -> None:
    words = ["slice", "the", "tomatoes", "and", "put", "them", "next", "to", "big", "ovens"]
    assert mentions(words, "sliced") == [0]
    assert mentions(words, "tomato.n.01_1") == [2]
    assert mentions(words, "nextto") == mentions(words, "NEXT_TO") == [6]
    assert mentions(words, "big_oven") == [8]
    assert mentions(words, "oven") == [9]
    assert mentions(words, "on") == mentions(words, "7") == []


def test_goals_are_what_the_instruction_can_state() -> None:
    benchmark = toy(lit(OVEN), instruction="Have the lamp lit and wait")
    assert copied(benchmark, Ability.GOAL_INTERPRETATION) == {
        "node goals": [["lit", "lamp"]],
        "edge goals": [],
        "action goals": ["WAIT"],
    }


def test_the_subgoal_is_the_goal_with_its_actions_first() -> None:
    benchmark = toy(Not(warm(OVEN)), Occurs("HEAT"), Occurs("WAIT"), warm(LAMP))
    assert copied(benchmark, Ability.SUBGOAL_DECOMPOSITION) == {
        "output": ["exists x0. (HEAT(x0)) then WAIT() then not warm(big_oven) and warm(lamp)"]
    }
    assert copied(toy(), Ability.SUBGOAL_DECOMPOSITION) == {"output": []}


def test_the_plan_has_an_action_for_each_part_of_the_goal() -> None:
    benchmark = toy(Not(lit(OVEN)), warm(LAMP), Occurs("LIGHT"))
    plan = copied(benchmark, Ability.ACTION_SEQUENCING)
    assert isinstance(plan, list)
    assert [tuple(step.values()) for step in plan] == [
        ("DARKEN", "big_oven"),
        ("HEAT", "lamp"),
        ("LIGHT", "lamp"),
    ]


def test_operators_assert_what_the_goal_names_of_everything() -> None:
    benchmark = toy(lit(LAMP), Not(warm(OVEN)))
    written = copied(benchmark, Ability.TRANSITION_MODELING)
    assert isinstance(written, dict)
    text = " ".join(str(written["output"]).split())
    assert text == (
        "(:action light :parameters (?x - object) :precondition (and) :effect "
        "(and (forall (?x - object) (lit ?x)) (forall (?x - object) (not (warm ?x)))))"
    )


@pytest.mark.parametrize("ability", PAPER_ABILITIES)
def test_the_empty_answer_has_the_form_and_nothing_in_it(ability: Ability) -> None:
    benchmark = toy(lit(LAMP))
    text = open_empty_book(benchmark, ability)["1"].text
    assert not any(json.loads(text).values()) if ability is not Ability.ACTION_SEQUENCING else text == "[]"
    assert not getattr(open_suite(benchmark, ability).score("1", text), "success", False)


Answers = Callable[[Benchmark, Ability], Callable[[str], str]]


def by_copy(benchmark: Benchmark, ability: Ability) -> Callable[[str], str]:
    book = open_copy_book(benchmark, ability)
    return lambda task_id: book[task_id].text


def by_lookup(benchmark: Benchmark, ability: Ability) -> Callable[[str], str]:
    book = open_lookup_book(benchmark, ability)
    return lambda task_id: book[task_id].text


def by_chance(benchmark: Benchmark, ability: Ability) -> Callable[[str], str]:
    draw = open_random_answers(benchmark, ability)
    return lambda task_id: draw(task_id, "0 1 1", ()).text


def without_answer(task: Task, ability: Ability) -> Task:
    """A task as its question tells it; that of goal interpretation does not tell the goals."""
    asked = replace(task, script=(), annotated_final=None)
    if ability is Ability.GOAL_INTERPRETATION:
        asked = replace(asked, goals=())
        asked = (
            replace(asked, record=replace(asked.record, goal_options=()))
            if isinstance(asked, BehaviorTask)
            else asked
        )
    return asked


@pytest.mark.usefixtures("data_store")
@pytest.mark.parametrize("answers", [by_copy, by_lookup, by_chance])
@pytest.mark.parametrize(
    "ability", [each for each in PAPER_ABILITIES if each is not Ability.TRANSITION_MODELING]
)
@pytest.mark.parametrize("name", ["virtualhome", "behavior"])
def test_null_models_do_not_see_the_answer_of_a_task(answers: Answers, ability: Ability, name: str) -> None:
    benchmark = find_benchmark(name)
    tasks = benchmark.open_tasks(Source())
    blind = TaskSet(tasks, lambda task_id: without_answer(tasks[task_id], ability), "")
    known = replace(benchmark, data=replace(benchmark.data, open_public=benchmark.open_tasks))
    asked = replace(known, open_tasks=lambda source: blind)
    seeing, unseeing = answers(known, ability), answers(asked, ability)
    for task_id in list(benchmark.tasks_for(ability, Source()))[3:60:14]:
        assert seeing(task_id) == unseeing(task_id)


@pytest.mark.usefixtures("data_store")
@pytest.mark.parametrize("name", ["virtualhome", "behavior"])
def test_the_copy_does_not_see_gold_operators(name: str) -> None:
    benchmark = find_benchmark(name)
    tasks = benchmark.operators(Source())

    def without_answer(task_id: str) -> TransitionTask:
        task = tasks[task_id]
        blank = {n: OperatorText(n, o.parameters, "()", "()") for n, o in task.domain.operators.items()}
        library = OperatorLibrary(task.domain.header, blank, task.domain.categories)
        return TransitionTask(task.id, library, task.operators, task.categories, task.problem_text)

    blind = TaskSet(tasks, without_answer, "")
    ability = Ability.TRANSITION_MODELING
    asked = replace(benchmark, data=replace(benchmark.data, own_tasks={ability: lambda source: blind}))
    seeing, unseeing = (by_copy(each, ability) for each in (benchmark, asked))
    for task_id in list(tasks)[3:60:14]:
        assert seeing(task_id) == unseeing(task_id)


def test_the_copied_subgoal_is_one_that_the_question_states(data_store: Store) -> None:
    book = open_copy_book(find_benchmark("virtualhome"), Ability.SUBGOAL_DECOMPOSITION, Source(data_store))
    assert json.loads(book["481_2"].text)["output"] == [
        "exists x0. (TYPE(x0)) then exists x0. (SWITCHOFF(x0))"
    ]
    assert json.loads(book["298_2"].text)["output"] == [
        "OPEN(freezer.289) and PLUGGED_IN(freezer.289) and INSIDE(food_food.1000, freezer.289)"
    ]
