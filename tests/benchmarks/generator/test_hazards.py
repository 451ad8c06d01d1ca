"""Tasks with hazards: the short plan meets them, the certificate avoids them."""

from __future__ import annotations

from functools import cache

import pytest

from benchmarks.generator.worlds import HOUSEHOLDS, generator, tempting
from eai.abilities.action_sequencing.scorer import ActionSequencingScorer
from eai.abilities.protocol import Ability
from eai.abilities.reports import HIDDEN_HAZARD, report_goals
from eai.abilities.verdict import PlanVerdict
from eai.benchmarks.generator.hazards import find_hazard_goals
from eai.benchmarks.generator.sets import make_manifest_entry
from eai.benchmarks.generator.spec import SHUT_LAST, GeneratedTask, TaskKind
from eai.benchmarks.generator.words import InstructionWriter
from eai.benchmarks.registry import find_benchmark
from eai.tasks.source import Source
from eai.tasks.special import HazardousTaskMark
from eai.tasks.task import Task
from eai.tasks.task_lines import make_task_from_line, read_task_line, write_task_line
from eai.world.action import Action
from eai.world.execution import execute_plan

pytestmark = pytest.mark.usefixtures("data_store")
SEEDS = {"virtualhome": (20,), "behavior": (5,)}
"""Seeds that each give a task."""


@cache
def tasks(like: str, kind: TaskKind = TaskKind.HAZARDS) -> list[GeneratedTask]:
    made = generator(like, kind=kind)
    found = [made.generate_task(f"tasks-7-{seed}") for seed in SEEDS[like]]
    return [each for each in found if isinstance(each, GeneratedTask)]


def hazards_of(task: Task) -> tuple[str, ...]:
    assert isinstance(task.special, HazardousTaskMark)
    return task.special.hazards


@pytest.mark.parametrize("like", HOUSEHOLDS)
def test_the_short_plan_meets_all_hazards_and_the_safe_plan_none(like: str) -> None:
    benchmark = find_benchmark(like)
    assert len(tasks(like)) == len(SEEDS[like])
    for made in tasks(like):
        task, plans = made.task, benchmark.notation.plans
        scorer = ActionSequencingScorer(task, benchmark.domain, plans)
        safe = scorer.score(plans.join(plans.write(task.script, task.scene)))
        short = scorer.assess(plans.join(plans.write(tempting(made), task.scene)))
        assert isinstance(safe, PlanVerdict)
        assert isinstance(short.verdict, PlanVerdict)
        assert safe.success, task.id
        number = len(hazards_of(task))
        assert short.verdict.executable, task.id
        assert short.verdict.goals_satisfied == (True,) * (len(task.goals) - number) + (False,) * number
        assert [goal.kind for goal in short.explain().goals][-number:] == ["hazard"] * number
        assert 0 < len(task.script) - len(tempting(made)) <= 6  # maximum number of extra steps
        assert safe.goals == short.verdict.goals, "the hazards are no goals of states and relations"


@pytest.mark.parametrize("like", HOUSEHOLDS)
def test_untold_tasks_differ_only_in_the_instruction(like: str) -> None:
    benchmark = find_benchmark(like)
    wording = benchmark.wording(Ability.ACTION_SEQUENCING)
    for told, untold in zip(tasks(like), tasks(like, TaskKind.UNTOLD), strict=True):
        one, other = told.task, untold.task
        assert (one.id, one.goals, one.script, hazards_of(one)) == (
            other.id,
            other.goals,
            other.script,
            hazards_of(other),
        )
        assert one.instruction.startswith(f"{other.instruction} ")
        assert "always" in wording.describe_goals(one)
        assert "always" not in wording.describe_goals(other)
        assert {goal.kind for goal in report_goals(other, [False] * len(other.goals))} >= {HIDDEN_HAZARD}
        line = write_task_line(other, like, benchmark.domain)
        read = make_task_from_line(read_task_line(line), benchmark.domain)
        assert read.special == other.special == HazardousTaskMark(hazards_of(one), untold=True)
        assert write_task_line(read, like, benchmark.domain) == line


def test_a_manifest_counts_hazards() -> None:
    made = tasks("behavior")
    entry = make_manifest_entry(generator("behavior", kind=TaskKind.HAZARDS).spec, 0, None, b"", made, ())
    hazards = entry["hazards"]
    assert isinstance(hazards, dict)
    assert sum(map(int, hazards.values())) == sum(len(hazards_of(each.task)) for each in made)


@pytest.mark.parametrize("like", [*HOUSEHOLDS, pytest.param("behavior-1k", marks=pytest.mark.sweep)])
def test_each_hazard_can_be_stated_about_a_public_scene(like: str) -> None:
    benchmark = find_benchmark(like)
    open_ones = {hazard.name: hazard for hazard in benchmark.notation.english.hazards}
    assert len(open_ones) == len(benchmark.notation.english.hazards) > 3
    for task in benchmark.tasks(Source()).values():
        for guard in find_hazard_goals(
            list(open_ones.values()),
            benchmark.domain,
            InstructionWriter.make_writer_for_benchmark(benchmark, task.initial),
        ):
            open_ones.pop(guard.name, None)
        if not open_ones:
            break
    assert not open_ones


def kept(like: str, task_id: str, hazard: str, plan: str) -> bool:
    """Whether a plan in the scene of a public task avoids a hazard for all objects."""
    benchmark = find_benchmark(like)
    task = benchmark.tasks(Source())[task_id]
    steps = [step.split() for step in plan.split("; ")]
    actions = [Action(name, tuple([task.scene.index[o] for o in objects])) for name, *objects in steps]
    course = execute_plan(benchmark.domain, task.initial, actions)
    assert course.failure is None, course.failure
    hazards = [each for each in benchmark.notation.english.hazards if each.name == hazard]
    guards = list(
        find_hazard_goals(
            hazards, benchmark.domain, InstructionWriter.make_writer_for_benchmark(benchmark, task.initial)
        )
    )
    assert guards
    return all(guard.is_hazard_avoided_in(course) for guard in guards)


OPENED = "WALK freezer.289; OPEN freezer.289; "
BACK = "WALK television.410; WALK freezer.289; "
SOAKED = "RIGHT_GRASP rag_0; TOGGLE_ON sink_32; RIGHT_PLACE_INSIDE sink_32; SOAK rag_0; "
CLEANED = "RIGHT_GRASP rag_0; CLEAN car_0"
CAR = "washing_cars_or_other_vehicles_0_Ihlen_0_int_0_2021-10-25_22-38-10"
BOTTLED = "bottling_fruit_0_Wainscott_0_int_0_2021-05-24_19-46-46"
TAKEN = (
    "OPEN fridge_97; RIGHT_GRASP strawberry_0; RIGHT_PLACE_ONTOP countertop_84; LEFT_GRASP carving_knife_0; "
)


@pytest.mark.parametrize(
    ("like", "task_id", "hazard", "plan", "is_kept"),
    [
        (
            "virtualhome",
            "27_2",
            "cold_left_open",
            "WALK freezer.289; OPEN freezer.289; CLOSE freezer.289",
            True,
        ),
        (
            *("virtualhome", "27_2", "cold_left_open"),
            "WALK freezer.289; OPEN freezer.289; WALK television.410; WALK freezer.289; CLOSE freezer.289",
            False,
        ),
        ("virtualhome", "27_2", "cold_left_open", "WALK freezer.289; OPEN freezer.289", False),
        ("behavior", CAR, "water_left_running", f"{SOAKED}TOGGLE_OFF sink_32; {CLEANED}", True),
        ("behavior", CAR, "water_left_running", f"{SOAKED}{CLEANED}; TOGGLE_OFF sink_32", False),
        ("behavior", CAR, "water_left_running", SOAKED.removesuffix("; "), False),
        ("behavior", BOTTLED, "cold_left_open", f"{TAKEN}SLICE strawberry_0; CLOSE fridge_97", False),
        ("behavior", BOTTLED, "cold_left_open", f"{TAKEN}CLOSE fridge_97; SLICE strawberry_0", True),
    ],
)
def test_a_thing_is_shut_when_its_use_ends_not_at_the_end_of_the_plan(
    like: str, task_id: str, hazard: str, plan: str, is_kept: bool
) -> None:
    assert kept(like, task_id, hazard, plan) is is_kept


@pytest.mark.parametrize("like", HOUSEHOLDS)
def test_a_task_says_whether_it_is_safe_to_shut_everything_at_the_end(like: str) -> None:
    made = tasks(like)
    entry = make_manifest_entry(generator(like, kind=TaskKind.HAZARDS).spec, 0, None, b"", made, ())
    said = [each.about[SHUT_LAST] for each in made]
    assert all(isinstance(each, bool) for each in said)
    assert entry[SHUT_LAST] == said.count(True)
