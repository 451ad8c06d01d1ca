"""Generators and some of their tasks, made once for all tests."""

from __future__ import annotations

from functools import cache
from itertools import islice

from eai.benchmarks.generator.generator import TaskGenerator, generate_from_seeds
from eai.benchmarks.generator.sets import make_seeds
from eai.benchmarks.generator.spec import (
    GeneratedTask,
    GenerationOutcome,
    GoalFormFrequency,
    PlanLengthTier,
    TaskKind,
    TaskSpecification,
)
from eai.benchmarks.generator.usual_goals import UsualGoalsOfDataSet
from eai.benchmarks.registry import find_benchmark
from eai.tasks.source import Source
from eai.world.action import Action

NOTHING_IS_USUAL = UsualGoalsOfDataSet(
    patterns={},
    goal_counts={},
    themes={},
    shape_counts={},
    pair_patterns=frozenset(),
    nestings=frozenset(),
    combinations=frozenset(),
    dependent_states=frozenset(),
    action_counts={},
    operators=frozenset(),
    uses=frozenset(),
    place_relations=(),
    taken_categories=frozenset(),
    used_categories=frozenset(),
    part_relations=(),
    countable_categories=frozenset(),
    part_categories=frozenset(),
    holding_predicate_names=(),
    unique_states=frozenset(),
)
"""An empty prior, which tests of small worlds change."""

HOUSEHOLDS = ("virtualhome", "behavior")


@cache
def generator(
    like: str,
    tier: PlanLengthTier = PlanLengthTier.DATA,
    forms: GoalFormFrequency = "data",
    *,
    actions: bool = False,
    kind: TaskKind = TaskKind.PLAIN,
) -> TaskGenerator:
    benchmark, source = find_benchmark(like), Source()
    spec = TaskSpecification(like, benchmark.tasks(source).sha256, tier, forms, actions=actions, kind=kind)
    return TaskGenerator(benchmark, spec, source)


PAIR_SEEDS = {"virtualhome": (0,), "behavior": (3,)}
"""Seeds that give a pair, if the generator has made no pair before."""


@cache
def pairs(like: str) -> list[GeneratedTask]:
    """Return the pairs of these seeds; one task of each has no plan."""
    made = generator(like, kind=TaskKind.PAIRS)
    outcomes = [made.generate_task(f"tasks-7-{seed}") for seed in PAIR_SEEDS[like]]
    return [outcome for outcome in outcomes if isinstance(outcome, GeneratedTask)]


@cache
def outcomes(like: str, number: int = 40, forms: GoalFormFrequency = "data") -> tuple[GenerationOutcome, ...]:
    made = generator(like, forms=forms)
    return tuple([made.generate_task(seed) for seed in islice(make_seeds("test", 1), number)])


def tasks(like: str, number: int = 40, forms: GoalFormFrequency = "data") -> list[GeneratedTask]:
    return [each for each in outcomes(like, number, forms) if isinstance(each, GeneratedTask)]


__all__ = ["HOUSEHOLDS", "NOTHING_IS_USUAL", "generate_from_seeds", "generator", "outcomes", "tasks"]


def tempting(made: GeneratedTask) -> tuple[Action, ...]:
    """Return the temptation of a generated task as a plan."""
    index, steps = made.task.scene.index, made.about["temptation"]
    assert isinstance(steps, list)
    return tuple([Action(operator, tuple([index[name] for name in names])) for operator, *names in steps])
