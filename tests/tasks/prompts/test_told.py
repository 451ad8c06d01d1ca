"""Prompts state all visible facts: if a fact, a condition or an effect differs, the prompts differ."""

from __future__ import annotations

import random
from collections.abc import Iterator
from dataclasses import replace
from itertools import islice, product

import pytest

from by_path import TESTS
from eai.abilities.notation.notation import Notation
from eai.abilities.protocol import PAPER_ABILITIES, Ability
from eai.agents.game import Game
from eai.agents.reference import make_setup
from eai.agents.rules import TRAINING
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.prompt_library import PromptLibrary
from eai.benchmarks.registry import find_benchmark
from eai.tasks.english import EnglishWords
from eai.tasks.problem_world import open_pddl
from eai.tasks.prompts.own import PromptTemplateValues, render_prompts
from eai.tasks.prompts.template import PromptTemplates
from eai.tasks.source import Source, use_tasks
from eai.tasks.task import Task
from eai.tasks.wording import PromptAndAnswerWording
from eai.world.domain import Domain
from eai.world.operator import Operator
from eai.world.state import Fact, Scene
from eai.world.vocabulary import Vocabulary
from world import toy

FOLDER = TESTS / "pddl" / "domains"
NAMES = sorted(path.name for path in FOLDER.iterdir())
ABOUT_STATES = (Ability.ACTION_SEQUENCING, Ability.SUBGOAL_DECOMPOSITION, Ability.GOAL_INTERPRETATION)
ABOUT_ACTIONS = ABOUT_STATES[:2]
MOST = 12
"""How many facts of a predicate are tried."""


def world(name: str) -> tuple[Domain, Task]:
    """A domain with its first task."""
    if name == "toy":
        initial = toy.initial()
        everything = tuple(range(len(initial.scene.objects)))
        return toy.DOMAIN, Task("toy", "Toy", "", initial, (), everything)
    domain, tasks = open_pddl(FOLDER / name / "domain.pddl", FOLDER / name)
    return domain, tasks[next(iter(tasks))]


def told(ability: Ability, domain: Domain, task: Task) -> str:
    """The question about a task that stands alone."""
    wording = PromptAndAnswerWording.from_domain(domain)
    questions = PromptTemplateValues(
        ability.value, wording, "an agent", {task.id: task}, "", lambda task_id: ""
    )
    return render_prompts(questions, PromptTemplates())[task.id].user


def observed(domain: Domain, task: Task) -> str:
    """Return everything that an agent reads before its first action."""
    benchmark = Benchmark(domain.name, domain, use_tasks(task))
    return Game(
        make_setup(replace(task, goals=task.goals or ()), benchmark, TRAINING)
    ).write_manual_and_first_observation()


def with_other_facts(domain: Domain, task: Task) -> Iterator[tuple[Fact, Task]]:
    """The task with a fact more or less: with each visible predicate some."""
    scene, facts, rng = task.scene, {*task.initial.facts()}, random.Random(task.id)
    for predicate in domain.vocabulary.predicates:
        every = list(product(range(len(scene.objects)), repeat=predicate.arity))
        for arguments in rng.sample(every, min(MOST, len(every))):
            fact = Fact(predicate.name, arguments)
            yield fact, replace(task, initial=scene.state(facts ^ {fact}))


def with_other_rules(domain: Domain) -> Iterator[tuple[str, Domain]]:
    """The domain with an operator that lacks a check, or an effect."""
    for operator in domain.operators:
        for i in range(len(operator.checks)):
            yield f"{operator.name}, check {i}", domain.replace_operators(without_check(operator, i))
        for i in range(len(operator.effects)):
            effects = operator.effects[:i] + operator.effects[i + 1 :]
            yield f"{operator.name}, effect {i}", domain.replace_operators(replace(operator, effects=effects))


def without_check(operator: Operator, place: int) -> Operator:
    return replace(operator, checks=operator.checks[:place] + operator.checks[place + 1 :])


@pytest.mark.parametrize("name", ["toy", *NAMES])
def test_every_visible_fact_is_told(name: str) -> None:
    domain, task = world(name)
    plain = {ability: told(ability, domain, task) for ability in ABOUT_STATES}
    seen = observed(domain, task) if task.goals else ""
    for fact, other in with_other_facts(domain, task):
        for ability, prompt in plain.items():
            assert told(ability, domain, other) != prompt, (ability, fact)
        assert not seen or observed(domain, other) != seen, fact


@pytest.mark.parametrize("name", ["toy", *NAMES])
def test_every_condition_and_every_effect_is_told(name: str) -> None:
    domain, task = world(name)
    plain = {ability: told(ability, domain, task) for ability in ABOUT_ACTIONS}
    seen = observed(domain, task) if task.goals else ""
    for what, other in with_other_rules(domain):
        for ability, prompt in plain.items():
            assert told(ability, other, task) != prompt, (ability, what)
        assert not seen or observed(other, task) != seen, what


@pytest.mark.parametrize("name", NAMES)
def test_problems_of_transition_modeling_have_every_fact(name: str) -> None:
    domain, task = world(name)
    benchmark = Benchmark(domain.name, domain, use_tasks(task))
    (plain,) = benchmark.operator_tasks(Source()).values()
    facts = {*task.initial.facts()}
    for fact in islice(sorted(facts), MOST):
        fewer = replace(task, initial=task.scene.state(facts - {fact}))
        (other,) = replace(benchmark, open_tasks=use_tasks(fewer)).operator_tasks(Source()).values()
        assert len(other.problem_text) < len(plain.problem_text), fact


def test_predicates_that_only_the_engine_sees_are_not_told() -> None:
    hidden = [replace(each, visible=False) for each in toy.VOCABULARY.predicates if each.name == "holding"]
    shown = [each for each in toy.VOCABULARY.predicates if each.name != "holding"]
    domain = replace(toy.DOMAIN, vocabulary=Vocabulary((*shown, *hidden), toy.VOCABULARY.derived))
    _, task = world("toy")
    scene = Scene(domain.vocabulary, task.scene.objects, task.scene.agent)
    for ability in ABOUT_STATES:
        text = told(ability, domain, replace(task, initial=scene.state(task.initial.facts())))
        assert "holding" not in text.replace("the hand is full", "")


@pytest.mark.parametrize("ability", PAPER_ABILITIES)
def test_prompts_speak_of_the_domain_at_hand_alone(ability: Ability) -> None:
    folder = FOLDER / "courier"
    benchmark = find_benchmark(f"pddl:{folder / 'domain.pddl'},{folder}")
    dispatcher = "the dispatcher of a courier"
    robot = replace(benchmark, notation=Notation(english=EnglishWords(role=dispatcher)))
    for found, role in ((benchmark, "an agent"), (robot, dispatcher)):
        for prompt in PromptLibrary("eai").open(found, ability).values():
            assert ability is Ability.TRANSITION_MODELING or f" {role}" in prompt.user
            for strange in (
                "household",
                "jar",
                "OPEN",
                "TOUCH",
                "rag",
                "forall x",
                "pairs",
                "name of an action",
            ):
                assert strange not in prompt.user


def test_conventions_and_who_the_agent_is_are_both_told() -> None:
    domain, task = world("toy")
    wording = replace(
        PromptAndAnswerWording.from_domain(domain), conventions=lambda task: "A lamp that is on is warm."
    )
    assert wording.describe_objects(task).split("\n\n")[1:] == [
        "A lamp that is on is warm.",
        "The agent is robot.",
    ]
