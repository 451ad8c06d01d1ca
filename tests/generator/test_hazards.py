"""Tasks with hazards: the short way meets them, the certificate does not, and telling is all that differs."""

from __future__ import annotations

from functools import cache

import pytest

from eai.abilities.action_sequencing.scorer import ActionSequencing
from eai.abilities.protocol import Ability
from eai.abilities.reports import UNTOLD, goal_reports
from eai.abilities.verdict import PlanVerdict
from eai.benchmark.registry import find_benchmark
from eai.generator.hazards import guards_of
from eai.generator.sets import manifest_entry
from eai.generator.spec import Generated, TaskKind
from eai.generator.words import Words
from eai.tasks.source import Source
from eai.tasks.task_lines import read_line, task_of, written
from generator.worlds import HOUSEHOLDS, generator, tempting

pytestmark = pytest.mark.usefixtures("data_store")
SEEDS = {"virtualhome": (13,), "behavior": (4,)}
"""Of which each gives a task."""


@cache
def tasks(like: str, kind: TaskKind = TaskKind.HAZARDS) -> list[Generated]:
    made = generator(like, kind=kind)
    found = [made.task(f"tasks-7-{seed}") for seed in SEEDS[like]]
    return [each for each in found if isinstance(each, Generated)]


@pytest.mark.parametrize("like", HOUSEHOLDS)
def test_the_short_way_meets_them_all_and_the_safe_one_none(like: str) -> None:
    benchmark = find_benchmark(like)
    assert len(tasks(like)) == len(SEEDS[like])
    for made in tasks(like):
        task, plans = made.task, benchmark.plans
        scorer = ActionSequencing(task, benchmark.domain, plans)
        safe = scorer.score(plans.join(plans.write(task.script, task.scene)))
        short = scorer.assess(plans.join(plans.write(tempting(made), task.scene)))
        assert isinstance(safe, PlanVerdict)
        assert isinstance(short.verdict, PlanVerdict)
        assert safe.success, task.id
        number = len(task.hazards)
        assert short.verdict.executable, task.id
        assert short.verdict.goals_satisfied == (True,) * (len(task.goals) - number) + (False,) * number
        assert [goal.kind for goal in short.explain().goals][-number:] == ["hazard"] * number
        assert 0 < len(task.script) - len(tempting(made)) <= 6  # as much as safety may cost
        assert safe.goals == short.verdict.goals, "the hazards are no goals of states and relations"


@pytest.mark.parametrize("like", HOUSEHOLDS)
def test_untold_tasks_are_the_same_and_say_nothing(like: str) -> None:
    benchmark = find_benchmark(like)
    wording = benchmark.wording(Ability.ACTION_SEQUENCING)
    for told, untold in zip(tasks(like), tasks(like, TaskKind.UNTOLD), strict=True):
        one, other = told.task, untold.task
        assert (one.id, one.goals, one.script, one.hazards) == (
            other.id,
            other.goals,
            other.script,
            other.hazards,
        )
        assert one.instruction.startswith(f"{other.instruction} ")
        assert "always" in wording.goals(one)
        assert "always" not in wording.goals(other)
        assert {goal.kind for goal in goal_reports(other, [False] * len(other.goals))} >= {UNTOLD}
        line = written(other, like, benchmark.domain)
        read = task_of(read_line(line), benchmark.domain)
        assert (read.hazards, read.untold) == (other.hazards, True)
        assert written(read, like, benchmark.domain) == line


def test_a_manifest_counts_them() -> None:
    made = tasks("behavior")
    entry = manifest_entry(generator("behavior", kind=TaskKind.HAZARDS).spec, 0, None, b"", made, ())
    hazards = entry["hazards"]
    assert isinstance(hazards, dict)
    assert sum(map(int, hazards.values())) == sum(len(each.task.hazards) for each in made)


@pytest.mark.parametrize("like", [*HOUSEHOLDS, pytest.param("behavior-1k", marks=pytest.mark.sweep)])
def test_each_can_be_said_of_a_public_scene(like: str) -> None:
    benchmark = find_benchmark(like)
    open_ones = {hazard.name: hazard for hazard in benchmark.english.hazards}
    assert len(open_ones) == len(benchmark.english.hazards) > 3
    for task in benchmark.tasks(Source()).values():
        for guard in guards_of(list(open_ones.values()), benchmark.domain, Words.of(benchmark, task.initial)):
            open_ones.pop(guard.name, None)
        if not open_ones:
            break
    assert not open_ones
