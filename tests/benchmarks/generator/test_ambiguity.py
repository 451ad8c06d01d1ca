"""Pairs of a clear and an ambiguous task with the same instruction; a guess is right half of the time."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import pytest

import eai
from benchmarks.generator.worlds import HOUSEHOLDS, generator
from eai import Benchmark, use_tasks
from eai.abilities.declining import QUESTION, write_refusal_answer
from eai.abilities.protocol import Ability
from eai.abilities.verdict import PlanVerdict
from eai.agents.game import Game
from eai.agents.play import make_game_rules
from eai.agents.reference import make_setup
from eai.agents.rules import TRAINING
from eai.agents.setting import STANDARD
from eai.benchmarks.generator.spec import GeneratedTask, TaskKind
from eai.benchmarks.prompt_library import PromptLibrary
from eai.benchmarks.registry import find_benchmark
from eai.tasks.goal_test import solves_task
from eai.tasks.source import Source
from eai.tasks.special import AmbiguousTaskMark
from eai.tasks.task import Task
from eai.tasks.task_files import find_mistakes_in_task
from eai.tasks.task_lines import make_task_from_line, read_task_line, write_task_line
from eai.world.action import Action

pytestmark = pytest.mark.usefixtures("data_store")
SEEDS = {"virtualhome": (0, 1), "behavior": (0, 1)}
"""Seeds that each give a pair."""


@cache
def pairs(like: str) -> list[tuple[Task, Task]]:
    """Return pairs of a clear and an ambiguous task."""
    made = generator(like, kind=TaskKind.AMBIGUOUS)
    found = [made.generate_task(f"tasks-7-{seed}") for seed in SEEDS[like]]
    return [
        (each.task, each.paired.task) for each in found if isinstance(each, GeneratedTask) and each.paired
    ]


def fits(task: Task) -> tuple[str, ...]:
    """Return the names of the objects that an instruction may mean."""
    assert isinstance(task.special, AmbiguousTaskMark)
    return task.special.fits


def of_the_other(task: Task, plan: tuple[Action, ...]) -> list[Action]:
    """Return a plan with the two objects exchanged."""
    one, other = (task.scene.index[name] for name in fits(task))
    swapped = {one: other, other: one}
    return [Action(step.operator, tuple([swapped.get(i, i) for i in step.arguments])) for step in plan]


@pytest.mark.parametrize("like", HOUSEHOLDS)
def test_the_tasks_of_a_pair_differ_in_the_place_of_the_second_object(like: str) -> None:
    domain = find_benchmark(like).domain
    assert len(pairs(like)) == len(SEEDS[like])
    for clear, unclear in pairs(like):
        assert (clear.instruction, clear.goals, clear.script, clear.title) == (
            unclear.instruction,
            unclear.goals,
            unclear.script,
            unclear.title,
        )
        assert fits(clear) == fits(unclear)[:1]
        second = unclear.scene.index[fits(unclear)[1]]
        changed = set(clear.initial.facts()) ^ set(unclear.initial.facts())
        assert changed
        assert all(second in fact.arguments for fact in changed)
        for task in (clear, unclear):
            assert solves_task(domain, task, task.script)
            assert list(find_mistakes_in_task(task, domain)) == []
            line = write_task_line(task, like, domain)
            assert write_task_line(make_task_from_line(read_task_line(line), domain), like, domain) == line


@pytest.mark.parametrize("like", HOUSEHOLDS)
def test_two_objects_of_a_pair_differ_only_in_their_names(like: str) -> None:
    for _, unclear in pairs(like):
        one, other = (unclear.scene.index[name] for name in fits(unclear))
        swapped, facts = {one: other, other: one}, set(unclear.initial.facts())
        assert {(name, tuple([swapped.get(i, i) for i in arguments])) for name, arguments in facts} == facts


@pytest.mark.parametrize("like", HOUSEHOLDS)
def test_a_plan_with_the_other_object_or_both_fails(like: str) -> None:
    domain = find_benchmark(like).domain
    for _, unclear in pairs(like):
        other = of_the_other(unclear, unclear.script)
        assert solves_task(domain, replace(unclear, goals=unclear.goals[:-1]), unclear.script)
        assert not solves_task(domain, unclear, other)
        assert not solves_task(domain, unclear, [*unclear.script, *other])


@pytest.mark.parametrize("like", HOUSEHOLDS)
def test_prompts_give_only_the_instruction_and_allow_a_question(like: str) -> None:
    benchmark = find_benchmark(like)
    for pair in pairs(like):
        alone = Benchmark("pair", benchmark.domain, use_tasks(*pair))
        suite = eai.open(alone, Ability.ACTION_SEQUENCING)
        prompts = PromptLibrary("eai").open(alone, Ability.ACTION_SEQUENCING)
        for task in pair:
            told = prompts[task.id].user
            assert told.count(task.instruction) == 1
            assert '{"ask"' in told
            assert '"impossible"' not in told
            asked = suite.score(task.id, write_refusal_answer("Which one?", QUESTION))
            assert isinstance(asked, PlanVerdict)
            assert (asked.success, asked.refused) == (len(fits(task)) > 1, "Which one?")


@pytest.mark.parametrize("like", HOUSEHOLDS)
def test_the_budget_does_not_reveal_ambiguity(like: str) -> None:
    rules = make_game_rules(STANDARD)
    setups = [make_setup(task, find_benchmark(like), rules) for pair in pairs(like) for task in pair]
    assert {setup.action_limit for setup in setups} == {50}
    assert all(len(setup.reference.commands or ()) < 50 for setup in setups)


def test_an_acting_agent_learns_the_meant_object_for_an_action() -> None:
    benchmark = find_benchmark("behavior")
    rules = TRAINING.model_copy(update={"until": "done", "feedback": "changes", "max_steps": 2})
    for task in pairs("behavior")[0]:
        setup = make_setup(task, benchmark, rules)
        assert "ASK(your question)" in setup.opening
        assert setup.opening.count(task.instruction) == 1
        game = Game(setup)
        told = [game.act("ASK(which one, please?)").observation for _ in range(3)]
        assert told[0].startswith(f"{fits(task)[0]} is meant.")
        assert (told[1], game.tried_action_count) == (told[0], 2)
        assert told[2].startswith("No actions are left.")
        assert game.ended == "steps"


def test_questions_are_refused_in_other_tasks() -> None:
    task = replace(pairs("behavior")[0][1], special=None)
    game = Game(make_setup(task, find_benchmark("behavior"), TRAINING))
    assert game.act("ASK(which one?)").info["fault"] == "hallucination"


def test_ambiguous_tasks_have_no_questions_about_goals_or_subgoals(
    tmp_path: Path,
) -> None:
    domain = find_benchmark("behavior").domain
    (clear, unclear), *_ = pairs("behavior")
    plain = replace(clear, id="plain", special=None)
    lines = [write_task_line(task, "behavior", domain) for task in (clear, unclear, plain)]
    (tmp_path / "tasks.jsonl").write_text("\n".join(lines), encoding="utf-8")
    benchmark = find_benchmark(f"{tmp_path}/")
    for ability in (Ability.GOAL_INTERPRETATION, Ability.SUBGOAL_DECOMPOSITION):
        assert list(benchmark.tasks_for(ability, Source())) == ["plain"]
    assert len(benchmark.tasks_for(Ability.ACTION_SEQUENCING, Source())) == 3
