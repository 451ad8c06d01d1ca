"""Reasons for rejecting a task, each shown by a task in the world of lamps with no other objection."""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import replace

import pytest

import eai.logic.formula as f
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.generator.generator import TaskGenerator, _TaskRejectionReasonFinder
from eai.benchmarks.generator.spec import SeedRejectionReason, TaskSpecification
from eai.benchmarks.generator.words import InstructionWriter
from eai.tasks.source import Source
from eai.tasks.task import Task, goal
from eai.world.action import Action
from eai.world.state import Fact

SPEC = TaskSpecification("lamps:lamps", "")
WAY = "GO lamp_1; PRESS lamp_1; GO box; OPEN box"


def steps(task: Task, way: str) -> tuple[Action, ...]:
    words = (step.split() for step in way.split("; "))
    return tuple([Action(name, (task.scene.index[about],)) for name, about in words])


def of(name: str, *about: str) -> f.Formula:
    return f.Atom(name, tuple(map(f.Constant, about)))


LIT, OPEN = of("lit", "lamp_1"), of("is_open", "box")


def made(lamps: Benchmark, *goals: f.Formula, way: str = WAY, facts: tuple[Fact, ...] = ()) -> Task:
    task = lamps.tasks(Source())["light"]
    initial = task.scene.state(facts)
    instruction = InstructionWriter.make_writer_for_benchmark(lamps, initial).make_instruction(
        goals, random.Random(0)
    )
    asked = replace(task, initial=initial, goals=tuple(map(goal, goals)), instruction=instruction)
    return replace(asked, script=steps(task, way))


Change = Callable[[Task], Task]


@pytest.mark.parametrize(
    ("change", "least", "most", "reason"),
    [
        (lambda task: task, 4, 4, None),
        (lambda task: task, 5, 9, SeedRejectionReason.TOO_SHORT),
        (lambda task: task, 3, 3, SeedRejectionReason.TOO_LONG),
        (lambda task: replace(task, script=task.script[:3]), 3, 3, SeedRejectionReason.NO_CERTIFICATE),
        (
            lambda task: replace(task, initial=task.scene.state([Fact("is_open", (4,))])),
            4,
            4,
            SeedRejectionReason.HOLDS_ALREADY,
        ),
        (lambda task: replace(task, instruction="Light it."), 4, 4, SeedRejectionReason.AMBIGUOUS),
        (lambda task: replace(task, goals=task.goals[:1]), 4, 4, SeedRejectionReason.AMBIGUOUS),
        (lambda task: replace(task, goals=task.goals[::-1]), 4, 4, SeedRejectionReason.AMBIGUOUS),
    ],
)
def test_a_task_is_rejected_for_one_reason(
    lamps: Benchmark, change: Change, least: int, most: int, reason: SeedRejectionReason | None
) -> None:
    task = change(made(lamps, LIT, OPEN))
    objections = _TaskRejectionReasonFinder(lamps.domain, (), SPEC)
    assert (
        objections.find_rejection_reason(
            task, InstructionWriter.make_writer_for_benchmark(lamps, task.initial), least, most
        )
        is reason
    )


def test_a_public_task_or_one_solved_by_a_public_plan_is_rejected(lamps: Benchmark) -> None:
    public = made(lamps, LIT, OPEN)
    objections = _TaskRejectionReasonFinder(lamps.domain, [public], SPEC)

    def reason(task: Task) -> SeedRejectionReason | None:
        task = replace(task, id="new")
        return objections.find_rejection_reason(
            task, InstructionWriter.make_writer_for_benchmark(lamps, task.initial), 0, 9
        )

    assert reason(public) is SeedRejectionReason.PUBLIC
    assert (
        reason(made(lamps, of("lit", "lamp_2"), OPEN, way=WAY.replace("_1", "_2")))
        is SeedRejectionReason.PUBLIC
    )
    assert reason(made(lamps, LIT, way="GO lamp_1; PRESS lamp_1")) is SeedRejectionReason.PUBLIC_PLAN
    assert reason(made(lamps, of("at", "robot", "ball"), way="GO ball")) is None


def test_a_public_goal_with_another_start_is_new_if_only_starts_are_held_out(lamps: Benchmark) -> None:
    public = made(lamps, LIT, OPEN)
    dark = replace(made(lamps, LIT, OPEN, facts=(Fact("lit", (2,)),)), id="dark")
    words = InstructionWriter.make_writer_for_benchmark(lamps, public.initial)
    by_goals = _TaskRejectionReasonFinder(lamps.domain, [public], SPEC)
    by_starts = _TaskRejectionReasonFinder(lamps.domain, [public], replace(SPEC, held_out="starts"))
    assert by_goals.find_rejection_reason(dark, words, 0, 9) is SeedRejectionReason.PUBLIC
    assert by_starts.find_rejection_reason(dark, words, 0, 9) is SeedRejectionReason.PUBLIC_PLAN
    assert by_starts.find_rejection_reason(public, words, 0, 9) is SeedRejectionReason.PUBLIC


def test_without_names_an_object_needs_a_description_by_place(lamps: Benchmark) -> None:
    task = made(lamps, LIT, way="GO lamp_1; PRESS lamp_1")
    words = InstructionWriter.make_writer_for_benchmark(
        lamps, task.initial, distinguishes_objects_by_place=True
    )
    by_place = _TaskRejectionReasonFinder(lamps.domain, (), replace(SPEC, by_place=True))
    assert by_place.find_rejection_reason(task, words, 0, 9) is SeedRejectionReason.NAMELESS
    assert _TaskRejectionReasonFinder(lamps.domain, (), SPEC).find_rejection_reason(task, words, 0, 9) is None
    alone = made(lamps, OPEN, way="GO box; OPEN box")
    assert by_place.find_rejection_reason(alone, words, 0, 9) is None


@pytest.mark.parametrize(("where", "is_seen"), [("box", True), ("lamp_1", False)])
def test_objects_of_goals_must_become_visible(lamps: Benchmark, where: str, is_seen: bool) -> None:
    """A box can be opened, and a lamp cannot."""
    x, y = map(f.Variable, "xy")
    hidden = f.Exists(y, f.And((f.Atom("inside", (x, y)), f.Not(f.Atom("is_open", (y,))))))
    world = replace(lamps, domain=replace(lamps.domain, visible=f.Not(hidden)))
    generator = TaskGenerator(world, TaskSpecification("lamps", ""), Source())
    index = made(lamps, LIT).scene.index
    put_away = (Fact("inside", (index["ball"], index[where])),)
    assert (
        generator._can_goal_objects_be_seen(made(lamps, of("at", "robot", "ball"), facts=put_away)) is is_seen
    )
    assert generator._can_goal_objects_be_seen(made(lamps, LIT, facts=put_away))
    assert TaskGenerator(lamps, TaskSpecification("lamps", ""), Source())._can_goal_objects_be_seen(
        made(lamps, LIT, facts=put_away)
    )
