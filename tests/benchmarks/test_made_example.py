"""Prompts of own domains state the instruction, and show a made example instead of another task's plan."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

import eai
from eai.abilities.protocol import PAPER_ABILITIES, Ability
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.gold_answers import open_gold_answers
from eai.benchmarks.made_example import make_example_task_for_prompts
from eai.benchmarks.prompt_library import PromptLibrary
from eai.benchmarks.registry import find_benchmark
from eai.tasks.goal_test import solves_task
from eai.tasks.prompts.prompt import PromptSet
from eai.tasks.source import USUAL_SOURCE
from eai.world import Predicate, Vocabulary
from world import toy

DOMAIN = """(define (domain taxi) (:requirements :strips :typing) (:types street garage - place taxi)
(:predicates (in ?t - taxi ?p - place) (road ?a ?b - place))
(:action drive :parameters (?t - taxi ?a ?b - place) :precondition (and (in ?t ?a) (road ?a ?b))
  :effect (and (in ?t ?b) (not (in ?t ?a)))))"""
PROBLEM = """(define (problem {name}) (:domain taxi) (:objects x y z w - street g - garage t - taxi)
(:init (in t x) (road x y) (road y z) (road z g) (road x w)) (:goal (in t {goal})))"""
PROMPTED = [each for each in PAPER_ABILITIES if each is not Ability.TRANSITION_MODELING]


@pytest.fixture
def taxis(tmp_path: Path) -> Benchmark:
    (tmp_path / "domain.pddl").write_text(DOMAIN)
    (tmp_path / "problems").mkdir()
    for name, goal in (("near", "y"), ("far", "z"), ("aside", "w")):
        (tmp_path / "problems" / f"{name}.pddl").write_text(PROBLEM.format(name=name, goal=goal))
    return find_benchmark(f"pddl:{tmp_path / 'domain.pddl'},{tmp_path / 'problems'}/")


def toys() -> Benchmark:
    start = toy.initial()
    tasks = (
        eai.make_task("light", "Make it light in the hall.", start, "lit(lamp)"),
        eai.make_task("carry", "Carry the red box to the shed.", start, "at(red, shed)"),
    )
    return eai.Benchmark("toys", toy.DOMAIN, eai.use_tasks(*tasks))


@pytest.mark.parametrize("prompt_set", ["eai", "eai-brief", "eai-careful"])
@pytest.mark.parametrize("ability", PROMPTED, ids=str)
def test_a_prompt_states_the_instruction_and_no_answer_to_another_task(
    taxis: Benchmark, ability: Ability, prompt_set: PromptSet
) -> None:
    two = taxis.tasks(USUAL_SOURCE)
    for benchmark in (toys(), replace(taxis, open_tasks=eai.use_tasks(two["near"], two["far"]))):
        prompts = PromptLibrary(prompt_set).open(benchmark, ability)
        tasks, book = benchmark.tasks(USUAL_SOURCE), open_gold_answers(benchmark, ability)
        for task_id, prompt in prompts.items():
            question = prompt.user.partition("Your task\n")[2]
            assert f"Instruction: {tasks[task_id].instruction}\n" in question
            assert prompt.user.count("\nInstruction: ") == (1 if prompt_set == "eai-brief" else 2)
            assert not [other for other in book if book[other].text in prompt.user]


def test_operators_of_other_tasks_are_not_shown() -> None:
    for prompt in PromptLibrary("eai").open(toys(), Ability.TRANSITION_MODELING).values():
        assert "An example of another task" not in prompt.user
        assert ":precondition (" not in prompt.user.replace(":precondition ()", "")


def test_the_plan_of_an_example_reaches_its_goal_and_solves_no_task() -> None:
    benchmark = toys()
    tasks = [*benchmark.tasks(USUAL_SOURCE).values()]
    example = make_example_task_for_prompts(
        benchmark.domain, tasks, benchmark.wording(PROMPTED[0]).predicates
    )
    assert example is not None
    assert len(example.script) == 2
    assert solves_task(benchmark.domain, example, example.script)
    assert not any(solves_task(benchmark.domain, task, example.script) for task in tasks)
    assert example.title not in {task.title for task in tasks}


def test_without_a_plan_that_solves_no_task_there_is_no_example(taxis: Benchmark) -> None:
    """Each plan of at most two drives is the plan of a task, until one of the tasks is missing."""
    tasks = [*taxis.tasks(USUAL_SOURCE).values()]
    assert make_example_task_for_prompts(taxis.domain, tasks, ["in"]) is None
    for task in tasks:
        example = make_example_task_for_prompts(
            taxis.domain, [other for other in tasks if other is not task], ["in"]
        )
        assert example is not None
        assert example.goals == task.goals
    assert make_example_task_for_prompts(taxis.domain, [replace(tasks[0], relevant=())], ["in"]) is None


def test_objects_are_listed_once_with_all_their_kinds(taxis: Benchmark) -> None:
    question = (
        PromptLibrary("eai").open(taxis, Ability.ACTION_SEQUENCING)["far"].user.partition("Your task\n")[2]
    )
    assert (
        "\nx [street, place]: -\ny [street, place]: -\nz [street, place]: -\nw [street, place]: -\n"
        in question
    )
    assert "\ng [garage, place]: -\nt [taxi]: -\n" in question
    assert question.count("t [taxi]") == 1


def test_a_public_benchmark_keeps_the_examples_of_its_data_set() -> None:
    assert find_benchmark("virtualhome").uses_declared_names_in_prompts is False
    assert toys().uses_declared_names_in_prompts


def test_a_vocabulary_without_predicates_has_no_example() -> None:
    vocabulary = Vocabulary((Predicate("p", 0),))
    empty = eai.make_task("t", "Do nothing.", eai.world.Scene(vocabulary, {}).state([]), "p()")
    assert make_example_task_for_prompts(eai.world.Domain("d", vocabulary, ()), [empty], ["p"]) is None
