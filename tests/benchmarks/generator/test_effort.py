"""The effort for a task: number of proposed goals, and number of failures before the generator gives up."""

from __future__ import annotations

import random
from collections import Counter
from itertools import count, islice

import pytest

import eai.logic.formula as f
from eai.base.errors import InputError
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.generator import sets
from eai.benchmarks.generator.generator import TaskGenerator, generate_from_seeds
from eai.benchmarks.generator.goals import GoalSampler
from eai.benchmarks.generator.growing_plan import GoalByGoalPlan
from eai.benchmarks.generator.seeds import TaskSeedOutcome, select_tasks
from eai.benchmarks.generator.sets import fingerprint_task, make_seeds
from eai.benchmarks.generator.spec import (
    GeneratedTask,
    HeldOut,
    PlanLengthTier,
    SeedRejectionReason,
    TaskSpecification,
    TaskSplit,
)
from eai.tasks.source import Source

TITLES = 2
"""Titles in the world of lamps, each of which is tried if no goal is reached."""


def made(lamps: Benchmark, tier: PlanLengthTier, **options: object) -> TaskGenerator:
    spec = TaskSpecification("lamps:lamps", lamps.tasks(Source()).sha256, tier, disturbances=0, **options)  # type: ignore[arg-type]
    return TaskGenerator(lamps, spec, Source())


def proposed(monkeypatch: pytest.MonkeyPatch, wishes: list[f.Formula | None]) -> list[f.Formula | None]:
    """Replace the proposals by these goals, then none; returns the list of requested proposals."""
    asked: list[f.Formula | None] = []

    def goal(self: GoalSampler, rng: object) -> f.Formula | None:
        asked.append(wishes[len(asked)] if len(asked) < len(wishes) else None)
        return asked[-1]

    monkeypatch.setattr(GoalSampler, "draw_goal", goal)
    return asked


@pytest.mark.parametrize(
    ("tier", "numbers"),
    [
        (PlanLengthTier.DATA, {24}),  # twelve for each of two goals, of which a plan of 5 to 7 steps is long
        (PlanLengthTier.S, {24}),
        (PlanLengthTier.M, {36, 48}),  # of three steps each
        (PlanLengthTier.L, {720, 840, 960}),  # ten times as many
        (PlanLengthTier.XL, {120 * wanted for wanted in range(12, 17)}),
    ],
)
def test_the_number_of_proposed_goals_depends_on_the_tier(
    lamps: Benchmark, monkeypatch: pytest.MonkeyPatch, tier: PlanLengthTier, numbers: set[int]
) -> None:
    generator, found = made(lamps, tier), set()
    for seed in range(12):
        asked = proposed(monkeypatch, [])
        assert generator.generate_task(str(seed)) == SeedRejectionReason.NO_GOALS
        assert len(asked) % TITLES == 0
        found.add(len(asked) // TITLES)
    assert found <= numbers
    assert len(found) > len(numbers) // 2


@pytest.mark.parametrize(
    ("tier", "failures"),
    [(PlanLengthTier.DATA, {5}), (PlanLengthTier.M, {5}), (PlanLengthTier.XL, set(range(12, 17)))],
)
def test_proposals_stop_after_several_failures_in_a_row(
    lamps: Benchmark, monkeypatch: pytest.MonkeyPatch, tier: PlanLengthTier, failures: set[int]
) -> None:
    generator, found = made(lamps, tier), set()
    for seed in range(8):
        lamp = f.Variable("x", "lamp")
        wishes = [f.Exactly(n, lamp, f.Atom("lit", (f.Variable("x"),))) for n in range(3, 200)]
        proposed(monkeypatch, list(wishes))
        reached: list[f.Formula] = []
        monkeypatch.setattr(
            GoalByGoalPlan, "reach_goal", lambda self, wish, reached=reached: reached.append(wish)
        )
        assert generator.generate_task(str(seed)) == SeedRejectionReason.NO_GOALS
        assert len(reached) == len(set(reached))
        found.add(len(reached) // TITLES)
    assert found <= failures


def test_titles_with_many_usual_goals_come_early_after_the_first(lamps: Benchmark) -> None:
    generator = made(lamps, PlanLengthTier.DATA)
    generator._title_weights = {"light": 1, "pack": 1, "many": 9}
    orders = [
        tuple(generator._draw_order_of_task_titles("light", random.Random(seed))) for seed in range(200)
    ]
    counts = Counter(orders)
    assert counts.keys() == {("light", "many", "pack"), ("light", "pack", "many")}
    assert 160 < counts["light", "many", "pack"] < 200  # 180 are expected


@pytest.mark.parametrize(
    ("split", "limit"), [(TaskSplit.ALL, 300), (TaskSplit.TRAIN, 1500), (TaskSplit.TEST, 1500)]
)
def test_generation_fails_after_many_rejected_seeds(
    lamps: Benchmark, monkeypatch: pytest.MonkeyPatch, split: TaskSplit, limit: int
) -> None:
    tried: list[str] = []
    monkeypatch.setattr(
        TaskGenerator,
        "make_task_from_seed",
        lambda self, seed, known: tried.append(seed) or TaskSeedOutcome(SeedRejectionReason.COPY),
    )
    monkeypatch.setattr(sets, "select_public_tasks_of_split", lambda tasks, split, held_out: tasks)
    generator = made(lamps, PlanLengthTier.DATA, split=split)
    with pytest.raises(
        InputError, match=f"only 0 of 1 tasks generated; the last {limit} seeds gave no task: "
    ):
        list(generate_from_seeds(generator, make_seeds("train", 0), 1, set()))
    assert len(tried) == limit


def test_seeds_in_a_row_are_counted_from_the_last_task_on(
    lamps: Benchmark, monkeypatch: pytest.MonkeyPatch
) -> None:
    generator = made(lamps, PlanLengthTier.DATA)
    *_, task = generate_from_seeds(generator, make_seeds("train", 0), 1, set())
    outcomes = iter([SeedRejectionReason.COPY, task])
    monkeypatch.setattr(
        TaskGenerator,
        "make_task_from_seed",
        lambda self, seed, known: TaskSeedOutcome(next(outcomes, SeedRejectionReason.COPY)),
    )
    tried = generate_from_seeds(generator, make_seeds("train", 0), 2, set())
    assert [next(tried), next(tried)] == [SeedRejectionReason.COPY, task]
    assert list(islice(tried, 300)) == [SeedRejectionReason.COPY] * 300
    with pytest.raises(InputError, match="only 1 of 2 tasks generated; the last 300 seeds gave no task: "):
        next(tried)


def test_generation_ends_with_the_last_seed() -> None:
    spec = TaskSpecification("lamps:lamps", "")
    judged = [TaskSeedOutcome(SeedRejectionReason.COPY)] * 2
    assert list(select_tasks(judged, spec, 1, set())) == [SeedRejectionReason.COPY] * 2


@pytest.mark.parametrize(
    ("goals", "held_out", "limit"),
    [(10, "goals", 100), (11, "goals", 1500), (10, "starts", 1500), (None, "goals", 1500)],
)
def test_a_world_with_few_goals_says_so_early(goals: int | None, held_out: HeldOut, limit: int) -> None:
    spec = TaskSpecification("lamps:lamps", "", split=TaskSplit.TEST, held_out=held_out)
    fingerprints = (None if goals is None else (str(n % goals), str(n)) for n in count())
    judged = (TaskSeedOutcome(SeedRejectionReason.OTHER_SPLIT, each) for each in fingerprints)
    with pytest.raises(InputError, match=f"the last {limit} seeds gave no task: ") as raised:
        list(select_tasks(judged, spec, 1, {("0", "0")}))
    advice = "all seeds have only 10 different lists of goals: try --held-out starts"
    assert str(raised.value).endswith(advice) == (limit == 100)
    assert "another generated task" not in str(raised.value)


def test_tasks_and_copies_are_captured_in_order(lamps: Benchmark) -> None:
    *_, task = generate_from_seeds(made(lamps, PlanLengthTier.DATA), make_seeds("train", 0), 1, set())
    assert isinstance(task, GeneratedTask)
    fingerprint = fingerprint_task(task.task)
    known, fingerprint_log = ("known", "known"), list[tuple[str, str]]()
    judged = [
        TaskSeedOutcome(SeedRejectionReason.TOO_LONG, known),
        TaskSeedOutcome(task, known),
        TaskSeedOutcome(SeedRejectionReason.TOO_LONG, ("other", "other")),
        TaskSeedOutcome(task, fingerprint),
    ]
    spec = TaskSpecification("lamps:lamps", "")
    outcomes = list(select_tasks(judged, spec, 1, {known}, fingerprint_log))
    assert outcomes == [SeedRejectionReason.COPY] * 2 + [SeedRejectionReason.TOO_LONG, task]
    assert fingerprint_log == [known, known, fingerprint]


def test_planners_are_replaced_after_two_hundred_tasks(
    lamps: Benchmark, monkeypatch: pytest.MonkeyPatch
) -> None:
    proposed(monkeypatch, [])
    generator, planners = made(lamps, PlanLengthTier.DATA), []
    for number in range(401):
        generator.generate_task(str(number))
        planners.append(generator._planner)
    assert [n for n in range(1, 401) if planners[n] is not planners[n - 1]] == [199, 399]
