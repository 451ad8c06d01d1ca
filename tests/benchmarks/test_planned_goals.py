"""Plans for goals stated in answers succeed if these goals entail the task's goals."""

from __future__ import annotations

from dataclasses import replace

import pytest

from agents.switches import DOMAIN, initial
from eai import make_task, use_tasks
from eai.abilities.notation.goal_lexicon import read_stated_goals
from eai.abilities.protocol import Ability
from eai.abilities.verdict import PlanVerdict
from eai.base.store import DataPackStore
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.gold_answers import (
    make_noisy_answer,
    open_answers_of_planner,
    open_gold_answers,
    replace_goals_by_answers,
)
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.suite import open_suite
from eai.logic.choice import build_and_or_tree, generate_dnf_terms_of_tree
from eai.logic.formula import Formula
from eai.tasks.source import Source
from eai.tasks.special import HazardousTaskMark
from eai.tasks.task import GoalKind, Task
from sweeps import swept


def is_entailed(stated: set[Formula], task: Task) -> bool:
    """Whether the stated literals include an option of each goal of the task."""
    return all(
        any(
            set(option) <= stated
            for option in generate_dnf_terms_of_tree(
                build_and_or_tree(goal.formula, task.scene.names_of_category)
            )
        )
        for goal in task.goals
    )


def make_noisy_answers(benchmark: Benchmark, task_ids: list[str], source: Source) -> dict[str, str]:
    book = open_gold_answers(benchmark, Ability.GOAL_INTERPRETATION, source)
    return {task: make_noisy_answer(book, task, 0.2, "0").text for task in task_ids}


@pytest.mark.parametrize(
    ("name", "every", "counts"),
    [("behavior", 20, (5, 2, 0)), ("virtualhome", 12, (17, 10, 3)), *swept(("behavior", 8, (13, 6, 1)))],
)
def test_plans_succeed_if_the_stated_goals_entail_the_true_ones(
    name: str, every: int, counts: tuple[int, int, int], data_store: DataPackStore
) -> None:
    """Other plans succeed only if the missing goals hold initially or are reached on the way."""
    benchmark, source = find_benchmark(name), Source(data_store)
    suite = open_suite(benchmark, Ability.ACTION_SEQUENCING, source=source)
    ids = [i for i in suite.task_ids if not suite.tasks[i].get_goals_of_kind(GoalKind.ACTION)][::every]
    answers = make_noisy_answers(benchmark, ids, source)
    book = open_answers_of_planner(
        replace_goals_by_answers(benchmark, answers), Ability.ACTION_SEQUENCING, source
    )
    entailed, solved = set(), set()
    for task_id in ids:
        task, plan = suite.tasks[task_id], book[task_id]
        stated = {
            goal.formula
            for goal in read_stated_goals(
                answers[task_id], task, benchmark.domain, benchmark.notation.goals
            ).goals
        }
        verdict = suite.score(task_id, plan.text)
        assert isinstance(verdict, PlanVerdict)
        if plan.parts and is_entailed(stated, task):
            entailed.add(task_id)
        if verdict.success:
            solved.add(task_id)
    assert entailed <= solved
    assert (len(ids), len(entailed), len(solved - entailed)) == counts


@pytest.mark.parametrize("untold", [False, True])
def test_stated_goals_of_a_task_with_hazards_are_no_goals_about_hazards(untold: bool) -> None:
    hazardous = replace(
        make_task("one", "Light it.", initial(), "lit(lamp)", "always shut(box)", domain=DOMAIN),
        special=HazardousTaskMark(("box_opened",), untold),
    )
    benchmark = Benchmark("switches", DOMAIN, use_tasks(hazardous))
    answer = open_gold_answers(benchmark, Ability.GOAL_INTERPRETATION)["one"].text
    stated = replace_goals_by_answers(benchmark, {"one": answer}).tasks(Source())["one"]
    assert stated.goals == stated.goals_not_about_hazards == hazardous.goals[:1]
    assert stated.with_only_goals_stated_in_prompts.goals == hazardous.goals[:1]
