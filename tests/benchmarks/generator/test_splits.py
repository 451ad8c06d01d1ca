"""Splits: their shares of goals, rejected tasks that another split gives away, and overlaps."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from itertools import islice
from typing import get_args

import pytest

import eai.logic.formula as f
from benchmarks.generator.worlds import HOUSEHOLDS, generate_from_seeds, generator, tasks
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.generator.generator import TaskGenerator
from eai.benchmarks.generator.sets import (
    SHARES,
    _find_split_containing_position,
    _get_predicate_and_first_non_agent_category,
    choose_split,
    choose_split_of_goals,
    fingerprint_task,
    is_earlier_in_train_validation_test_order,
    make_seeds,
    make_shared_plan_detector,
    measure_overlap,
    select_public_tasks_of_split,
)
from eai.benchmarks.generator.spec import (
    GeneratedTask,
    HeldOut,
    SeedRejectionReason,
    TaskSpecification,
    TaskSplit,
)
from eai.benchmarks.generator.usual_goals import LiteralPattern, find_patterns
from eai.benchmarks.registry import find_benchmark
from eai.tasks.source import Source
from eai.world.state import Fact
from sweeps import swept

pytestmark = pytest.mark.usefixtures("data_store")

PARTS = tuple(SHARES)


def goals_of(made: GeneratedTask) -> list[f.Formula]:
    return [goal.formula for goal in made.task.goals]


def made_in(like: str, split: TaskSplit, number: int, held_out: HeldOut = "goals") -> list[GeneratedTask]:
    benchmark, source = find_benchmark(like), Source()
    spec = TaskSpecification(like, benchmark.tasks(source).sha256, split=split, held_out=held_out)
    found = generate_from_seeds(
        TaskGenerator(benchmark, spec, source), make_seeds(split.value, 5), number, set()
    )
    return [each for each in found if isinstance(each, GeneratedTask)]


def test_a_hash_gives_each_split_its_share() -> None:
    found = Counter(choose_split(f"goals {number}") for number in range(5000))
    assert list(SHARES) == [TaskSplit.TRAIN, TaskSplit.VALIDATION, TaskSplit.TEST]
    assert all(abs(found[split] / 5000 - share) < 0.03 for split, share in SHARES.items())


@pytest.mark.parametrize("like", ["behavior", *swept("virtualhome")])
def test_no_goals_are_in_two_splits(like: str) -> None:
    prints = {split: {fingerprint_task(each.task)[0] for each in made_in(like, split, 6)} for split in PARTS}
    assert not prints[TaskSplit.TRAIN] & prints[TaskSplit.TEST]
    assert not prints[TaskSplit.TRAIN] & prints[TaskSplit.VALIDATION]
    assert not prints[TaskSplit.VALIDATION] & prints[TaskSplit.TEST]
    for made in tasks(like):
        split = choose_split_of_goals(goals_of(made), made.task.initial, "goals")
        assert made.about["split"] == split.value


def test_names_of_objects_and_the_order_of_goals_do_not_decide() -> None:
    made = next(each for each in tasks("behavior") if len(each.task.goals) > 1)
    goals, initial = goals_of(made), made.task.initial
    for held_out in get_args(HeldOut):
        split = choose_split_of_goals(goals, initial, held_out)
        assert choose_split_of_goals(goals[::-1], initial, held_out) == split


@pytest.mark.parametrize("like", HOUSEHOLDS)
def test_a_later_split_asks_for_a_pair_that_no_earlier_one_has(like: str) -> None:
    def pairs(split: TaskSplit) -> list[set[tuple[str, ...]]]:
        found = []
        for made in made_in(like, split, 4, "pairs"):
            scene = made.task.scene
            agent = None if scene.agent is None else scene.objects[scene.agent].category
            literals = [pattern for goal in goals_of(made) for pattern in find_patterns(goal, scene)]
            found.append({(p.predicate, *[k for k in p.categories if k != agent][:1]) for p in literals})
        return found

    seen = set().union(*pairs(TaskSplit.TRAIN))
    assert seen
    assert all(each - seen for each in pairs(TaskSplit.TEST))


@pytest.mark.parametrize("held_out", ["titles", "scenes"])
@pytest.mark.parametrize("like", HOUSEHOLDS)
def test_every_public_task_is_the_base_of_one_split(like: str, held_out: HeldOut) -> None:
    public = list(find_benchmark(like).tasks(Source()).values())
    parts = [select_public_tasks_of_split(public, split, held_out) for split in PARTS]
    assert all(parts)
    assert (
        sum(map(len, parts))
        == len(public)
        == len(select_public_tasks_of_split(public, TaskSplit.ALL, held_out))
    )
    if held_out == "titles":
        titles = [{task.title for task in part} for part in parts]
        assert sum(map(len, titles)) == len({task.title for task in public})


@pytest.mark.parametrize("held_out", ["titles", "scenes"])
@pytest.mark.parametrize("number", [5, 10, 35])
def test_titles_and_scenes_are_split_as_close_to_the_shares_as_possible(
    lamps: Benchmark, number: int, held_out: HeldOut
) -> None:
    task = lamps.tasks(Source())["light"]
    public = [replace(task, id=f"{n}", title=f"t{n}") for n in range(number)]
    shared = [len(select_public_tasks_of_split(public, split, held_out)) for split in PARTS]
    assert shared == [pytest.approx(share * number) for share in SHARES.values()]


def test_a_task_solved_by_lookup_in_another_split_is_rejected() -> None:
    made = tasks("behavior")[0]
    domain = find_benchmark("behavior").domain
    copy = replace(made.task, id="copy")
    assert make_shared_plan_detector(domain, earlier_tasks=[copy])(made.task)
    assert make_shared_plan_detector(domain, later_tasks=[copy])(made.task)
    assert not make_shared_plan_detector(domain)(made.task)
    benchmark, source = find_benchmark("behavior"), Source()
    spec = TaskSpecification("behavior", benchmark.tasks(source).sha256)
    seed = str(made.about["seed"])
    again = TaskGenerator(
        benchmark, spec, source, make_shared_plan_detector(domain, earlier_tasks=[copy])
    ).generate_task(seed)
    assert again == SeedRejectionReason.KNOWN_PLAN


def test_splits_without_common_starts_may_have_common_goals(lamps: Benchmark) -> None:
    light = lamps.tasks(Source())["light"]
    scene = light.scene
    lit = [Fact("lit", (i,)) for i, thing in enumerate(scene.objects) if thing.category == "lamp"]
    starts = [scene.state(lit[:n]) for n in range(len(lit) + 1)]
    tasks = [replace(light, initial=start) for start in starts]
    goals = [goal.formula for goal in light.goals]
    splits = {choose_split_of_goals(goals, start, "starts") for start in starts}
    assert len({choose_split_of_goals(goals, start, "goals") for start in starts}) == 1 < len(splits)
    assert len({fingerprint_task(task, "starts") for task in tasks}) == len(tasks)
    same = [measure_overlap(tasks[:1], tasks[n : n + 1], lamps.domain, "starts")["same"] for n in (0, 1)]
    assert same == [1, 0]


def test_overlap_counts_equal_tasks_equal_goals_and_tasks_solved_by_lookup() -> None:
    domain = find_benchmark("behavior").domain
    first, *others = [replace(each.task, id=f"t{i}") for i, each in enumerate(islice(tasks("behavior"), 6))]
    elsewhere = replace(first, id="x", initial=first.scene.state(list(first.initial.facts())[:-1]))
    assert list(measure_overlap([replace(first, id="y")], [first, *others], domain).values()) == [1] * 4
    counted = measure_overlap([elsewhere], [first], domain)
    assert (counted["tasks"], counted["same_goals"]) == (1, 1)
    assert set(measure_overlap([], [first], domain).values()) == {0}


def test_a_split_is_earlier_than_the_splits_after_it() -> None:
    assert is_earlier_in_train_validation_test_order("train", "test")
    assert is_earlier_in_train_validation_test_order("validation", "test")
    assert not is_earlier_in_train_validation_test_order("test", "train")
    assert not is_earlier_in_train_validation_test_order("train", "train")
    assert not is_earlier_in_train_validation_test_order("tasks", "test")


def test_virtualhome_goals_are_counted_quantified_and_hidden_by_default() -> None:
    """The data set has only plain goals, most of them about visible objects."""
    made = tasks("virtualhome")
    quantified = [
        any(isinstance(goal, f.ForAll | f.Exists | f.Exactly) for goal in goals_of(each)) for each in made
    ]
    assert sum(quantified) > len(made) // 4
    assert sum(int(str(each.about["hidden"])) > 0 for each in made) > len(made) // 4
    assert sum(len(each.task.script) >= 7 for each in made) > len(made) // 3


def test_quantifiers_range_over_categories_with_several_objects_in_a_public_task() -> None:
    several = generator("virtualhome").usual_goals.countable_categories
    assert {"plate", "cup", "light"} <= several
    assert {"phone", "television", "soap"}.isdisjoint(several)
    assert not generator("behavior").usual_goals.countable_categories


@pytest.mark.parametrize(
    ("place", "split"),
    [
        *(
            (0.0, TaskSplit.TRAIN),
            (0.599, TaskSplit.TRAIN),
            (0.601, TaskSplit.VALIDATION),
            (0.799, TaskSplit.VALIDATION),
        ),
        *((0.801, TaskSplit.TEST), (0.999, TaskSplit.TEST), (1.0, TaskSplit.TEST)),
    ],
)
def test_sixty_percent_of_tasks_are_for_training_and_twenty_for_each_other_split(
    place: float, split: TaskSplit
) -> None:
    assert _find_split_containing_position(place) is split


@pytest.mark.parametrize(
    ("categories", "pair"),
    [
        (("robot", "lamp"), ("p", "lamp")),
        (("lamp", "robot"), ("p", "lamp")),
        (("ball", "box"), ("p", "ball")),
        (("robot",), ("p",)),
        ((), ("p",)),
    ],
)
def test_a_pair_has_a_predicate_and_the_first_category_other_than_the_agents(
    lamps: Benchmark, categories: tuple[str, ...], pair: tuple[str, ...]
) -> None:
    scene = lamps.tasks(Source())["light"].scene
    assert _get_predicate_and_first_non_agent_category(LiteralPattern("p", categories, True), scene) == pair


@pytest.mark.parametrize(
    ("one", "other", "expected"),
    [
        ("train", "validation", True),
        ("validation", "test", True),
        ("test", "train", False),
        ("train", "train", False),
        ("train", "mine", False),
        ("mine", "test", False),
    ],
)
def test_a_split_comes_before_later_ones(one: str, other: str, expected: bool) -> None:
    assert is_earlier_in_train_validation_test_order(one, other) is expected


def test_each_title_and_each_scene_is_of_one_split_and_the_shares_are_those_of_all(lamps: Benchmark) -> None:
    light, pack = lamps.tasks(Source()).values()
    for held_out in ("titles", "scenes"):
        public = [
            replace(task, id=f"{task.id}-{n}", title=f"title {n // 2}")
            for n in range(10)
            for task in (light, pack)
        ]
        parts = [select_public_tasks_of_split(public, split, held_out) for split in PARTS]
        keys = [{task.title if held_out == "titles" else task.id for task in part} for part in parts]
        number = 5 if held_out == "titles" else 20
        assert [len(key) for key in keys] == [3 * number // 5, number // 5, number // 5]
        assert sorted(task.id for part in parts for task in part) == sorted(task.id for task in public)
        assert select_public_tasks_of_split(public, TaskSplit.ALL, held_out) == public
    assert select_public_tasks_of_split(public, TaskSplit.TEST, "goals") == public
