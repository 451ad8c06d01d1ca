"""Recorded tasks of some seeds, for all kinds of specifications.

If a change of the generator changes these tasks on purpose, it needs a new version of the generator.
"""

from __future__ import annotations

import hashlib
import random
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from itertools import islice, pairwise, product
from pathlib import Path
from typing import get_args

import pytest

from benchmarks.generator.worlds import HOUSEHOLDS
from eai.base.store import DataPackStore
from eai.benchmarks.generator.census import learn_usual_goals_from_tasks
from eai.benchmarks.generator.generator import TaskGenerator
from eai.benchmarks.generator.goals import GoalSampler
from eai.benchmarks.generator.measures import TaskMeasure
from eai.benchmarks.generator.scene import (
    add_objects_of_other_tasks,
    add_portable_objects_similar_to_existing,
    make_function_listing_ways_to_hide_objects,
    make_state_with_subset_of_objects,
)
from eai.benchmarks.generator.sets import make_seeds
from eai.benchmarks.generator.spec import (
    GeneratedTask,
    GoalFormFrequency,
    PlanLengthTier,
    SeedRejectionReason,
    TaskKind,
    TaskSpecification,
)
from eai.benchmarks.generator.usual_goals import do_goals_clash, is_goal_pointless_without_missing_goal
from eai.benchmarks.registry import find_benchmark
from eai.tasks.source import Source
from eai.tasks.task_lines import write_task_line
from golden_files import assert_golden

SPECS = {
    "data": {},
    "all forms": {"forms": "all", "tier": PlanLengthTier.M},
    "actions, over time": {"actions": True, "kind": TaskKind.ORDER},
    "by place": {"by_place": True, "forms": "all"},
    "hidden": {"at_least": ((TaskMeasure.HIDDEN, 1),)},
    "little": {"tier": PlanLengthTier.S, "disturbances": 0, "most_objects": 8, "depth": 2},
}
SEEDS, TASKS = 40, 4
"""Maximum number of seeds for each specification, and number of tasks after which it is done."""


@pytest.mark.parametrize("like", HOUSEHOLDS)
def test_equal_seeds_give_the_recorded_tasks(like: str, data_store: DataPackStore) -> None:
    benchmark, source = find_benchmark(like), Source()
    lines = []
    for name, options in SPECS.items():
        made = TaskGenerator(
            benchmark, TaskSpecification(like, benchmark.tasks(source).sha256, **options), source
        )  # type: ignore[arg-type]
        tasks = 0
        for seed in islice(make_seeds("golden", 0), SEEDS):
            if tasks == TASKS:
                break
            outcome = made.generate_task(seed)
            tasks += isinstance(outcome, GeneratedTask)
            if isinstance(outcome, SeedRejectionReason):
                lines.append(f"{name} {seed}: {outcome.value}")
                continue
            line = write_task_line(outcome.task, like, benchmark.domain, outcome.about)
            digest = hashlib.sha256(line.encode()).hexdigest()[:12]
            lines.append(f"{name} {seed}: {len(outcome.task.script)} steps, {digest}")
    assert_golden(Path(__file__).with_name(f"golden_{like}.txt"), lines)


def digest(what: object) -> str:
    return hashlib.sha256(repr(what).encode()).hexdigest()[:12]


def plain(value: object) -> object:
    """Return a value whose text does not depend on the order of sets."""
    if isinstance(value, frozenset):
        return sorted(map(repr, value))
    if isinstance(value, Mapping):
        return [(key, plain(part)) for key, part in value.items()]
    return [plain(getattr(value, each.name)) for each in fields(value)] if is_dataclass(value) else value


@pytest.mark.parametrize("like", HOUSEHOLDS)
def test_the_prior_equals_the_recorded_prior(like: str, data_store: DataPackStore) -> None:
    benchmark = find_benchmark(like)
    prior = learn_usual_goals_from_tasks(benchmark, benchmark.tasks(Source()).values())
    lines = [f"{each.name}: {digest(plain(getattr(prior, each.name)))}" for each in fields(prior)]
    assert_golden(Path(__file__).with_name(f"golden_prior_{like}.txt"), lines)


@pytest.mark.parametrize("like", HOUSEHOLDS)
def test_equal_random_numbers_give_the_recorded_scenes_and_proposals(
    like: str, data_store: DataPackStore
) -> None:
    """The records have closed scenes of some public tasks, plain and rich, and goals proposed for them."""
    benchmark = find_benchmark(like)
    tasks = list(benchmark.tasks(Source()).values())
    prior, lines = learn_usual_goals_from_tasks(benchmark, tasks), []
    hiding = make_function_listing_ways_to_hide_objects(benchmark.domain, prior)
    for number, task in enumerate(tasks[:: len(tasks) // 12]):
        rng, theme = random.Random(number), prior.themes[task.title]
        scene = make_state_with_subset_of_objects(
            task, prior, rng, 30, leaves_room_for_other_tasks=number % 2 > 0
        )
        kinds = {thing.category for thing in scene.scene.objects}
        scene = add_portable_objects_similar_to_existing(scene, prior, rng, 34, kinds)
        scene = add_objects_of_other_tasks(scene, tasks, prior, rng, 40)
        names = [f"{thing.name} {thing.category}" for thing in scene.scene.objects]
        lines.append(f"{task.id}: {len(names)} objects, {digest((names, sorted(scene.facts())))}")
        lines.append(f"{task.id}: hidden {digest(hiding(task))}")
        for forms, about in product(get_args(GoalFormFrequency), (None, theme)):
            known = GoalSampler.make_goal_sampler_for_scene(
                scene.scene, prior, forms, actions=number % 3 > 0, theme=about
            )
            told = [known.draw_goal(rng) for _ in range(60)] if known.patterns else []
            told += [known.draw_literal(rng) for _ in range(10)] + [
                known.draw_literal(rng, 0.5) for _ in range(10)
            ]
            told += known.draw_goals_about_agent(theme, rng)
            told += (
                [known.restrict_first_object_to_categories(kinds)._draw_pattern(rng)]
                if known.patterns
                else []
            )
            pairs = list(pairwise([goal for goal in told[:60] if goal is not None]))
            clashes = [do_goals_clash(*pair, scene.scene, prior) for pair in pairs]
            idle = [
                is_goal_pointless_without_missing_goal(one, [other], scene.scene, prior)
                for one, other in pairs
            ]
            lines.append(
                f"{task.id}: {sum(clashes)} clash, {sum(idle)} idle, {digest((told, clashes, idle))}"
            )
    assert_golden(Path(__file__).with_name(f"golden_proposals_{like}.txt"), lines)
