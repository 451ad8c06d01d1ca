"""Generated tasks work like any benchmark: in all abilities, prompts, the planner and the environment."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.generator.worlds import HOUSEHOLDS, tasks
from eai.abilities.protocol import PAPER_ABILITIES, Ability
from eai.abilities.transition_modeling.verdict import OperatorVerdict
from eai.agents.environment import make
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.gold_answers import open_answers_of_planner, open_gold_answers
from eai.benchmarks.prompt_library import PromptLibrary
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.suite import open_suite
from eai.pddl.planning import PlannerChoice
from eai.tasks.source import Source
from eai.tasks.task_files import write_task_file
from eai.tasks.task_lines import write_task_line

pytestmark = pytest.mark.usefixtures("data_store")
SOURCE = Source(planner=PlannerChoice.NONE)


def made(like: str, folder: Path) -> Benchmark:
    domain, file = find_benchmark(like).domain, folder / f"made_{like}.jsonl"
    write_task_file(file, [write_task_line(each.task, like, domain, each.about) for each in tasks(like)[:6]])
    return find_benchmark(str(file))


@pytest.mark.parametrize("ability", PAPER_ABILITIES)
@pytest.mark.parametrize("like", HOUSEHOLDS)
def test_gold_answers_to_generated_tasks_are_right(like: str, ability: Ability, tmp_path: Path) -> None:
    benchmark = made(like, tmp_path)
    suite = open_suite(benchmark, ability, source=SOURCE)
    book = open_gold_answers(benchmark, ability, SOURCE)
    assert len(suite.task_ids) == 6
    for task_id in suite.task_ids:
        verdict = suite.score(task_id, book[task_id].text)
        if isinstance(verdict, OperatorVerdict):
            sides = [side for each in verdict.operators for side in (each.precondition, each.effect)]
            assert not any(side.additional or side.missing for side in sides)
        else:
            assert getattr(verdict, "success", True), verdict


@pytest.mark.parametrize("like", HOUSEHOLDS)
def test_prompts_say_the_instruction_and_show_all_there_is(like: str, tmp_path: Path) -> None:
    benchmark = made(like, tmp_path)
    prompts = PromptLibrary("eai", source=SOURCE).open(benchmark, Ability.GOAL_INTERPRETATION)
    plans = PromptLibrary("eai", source=SOURCE).open(benchmark, Ability.ACTION_SEQUENCING)
    for task_id, task in benchmark.tasks(SOURCE).items():
        assert task.instruction in prompts[task_id].user
        assert all(thing.name in plans[task_id].user for thing in task.scene.objects)


@pytest.mark.parametrize("like", HOUSEHOLDS)
def test_the_planner_solves_generated_tasks(like: str, tmp_path: Path) -> None:
    benchmark = made(like, tmp_path)
    book = open_answers_of_planner(benchmark, Ability.ACTION_SEQUENCING, SOURCE)
    suite = open_suite(benchmark, Ability.ACTION_SEQUENCING, source=SOURCE)
    assert all(suite.score(i, book[i].text).success for i in suite.task_ids)  # type: ignore[union-attr]


@pytest.mark.parametrize("like", HOUSEHOLDS)
def test_certificates_win_in_the_environment(like: str, tmp_path: Path) -> None:
    benchmark = made(like, tmp_path)
    for task_id, task in list(benchmark.tasks(SOURCE).items())[:3]:
        environment = make(benchmark, task_id, source=SOURCE)
        environment.reset()
        ended = False
        for action in task.script:
            names = ", ".join(task.scene.objects[i].name for i in action.arguments)
            _, _, ended, _, _ = environment.step(f"{action.operator}({names})")
        assert ended, task_id
