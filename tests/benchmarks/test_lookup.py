"""The lookup table: what it answers to a task that is like another, and how far it comes on public tasks."""

from __future__ import annotations

from collections import Counter

import pytest

from benchmarks.generator.worlds import HOUSEHOLDS, tasks
from eai import make_task
from eai.abilities.protocol import Ability
from eai.abilities.verdict import PlanVerdict
from eai.base.store import Store
from eai.benchmarks.copied_answers import LookupTable, open_lookup_book
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.suite import open_suite
from eai.results.summary import summarise
from eai.tasks.source import Source
from eai.tasks.task import Task
from eai.world import (
    Add,
    Atom,
    Constant,
    Domain,
    Formula,
    Operator,
    Predicate,
    Scene,
    Variable,
    Vocabulary,
    WorldObject,
)
from eai.world.action import Action

X = Variable("x")
lit, warm = Predicate("lit", 1), Predicate("warm", 1)
DOMAIN = Domain(
    "toy",
    Vocabulary((lit, warm)),
    (Operator("LIGHT", (X,), (), (Add(lit(X)),)), Operator("HEAT", (X,), (), (Add(warm(X)),))),
)


def task(task_id: str, names: dict[str, str], plan: tuple[tuple[str, str], ...], *goals: Formula) -> Task:
    from dataclasses import replace

    scene = Scene(DOMAIN.vocabulary, [WorldObject(name, category) for name, category in names.items()])
    script = tuple(Action(operator, (scene.index[name],)) for operator, name in plan)
    return replace(make_task(task_id, "", scene.state([]), *goals), script=script)


def of(predicate: str, name: str) -> Formula:
    return Atom(predicate, (Constant(name),))


LAMP = task("lamp", {"l1": "lamp", "o1": "oven"}, (("LIGHT", "l1"),), of("lit", "l1"))
BOTH = task(
    "both",
    {"l1": "lamp", "l2": "lamp", "o1": "oven"},
    (("LIGHT", "l2"), ("HEAT", "o1")),
    of("lit", "l2"),
    of("warm", "o1"),
)
TABLE = LookupTable([LAMP, BOTH], DOMAIN)


def named(asked: Task) -> list[tuple[str, str]]:
    return [(a.operator, asked.scene.objects[a.arguments[0]].name) for a in TABLE.plan(asked)]


def test_the_plan_is_that_of_the_most_similar_goals_about_the_own_objects() -> None:
    asked = task("new", {"a": "lamp", "b": "lamp", "c": "oven"}, (), of("warm", "c"), of("lit", "b"))
    assert named(asked) == [("LIGHT", "b"), ("HEAT", "c")]


def test_what_is_not_there_is_left_out() -> None:
    asked = task("new", {"a": "lamp"}, (), of("lit", "a"), of("warm", "a"))
    assert named(asked) == [("LIGHT", "a")]
    assert LookupTable([], DOMAIN).plan(asked) == ()


def test_the_task_itself_is_left_out() -> None:
    assert named(BOTH) == [("LIGHT", "l2")]


@pytest.mark.usefixtures("data_store")
@pytest.mark.parametrize("name", ["virtualhome", "behavior"])
def test_goals_are_those_of_the_most_similar_instruction(name: str) -> None:
    benchmark = find_benchmark(name)
    book = open_lookup_book(benchmark, Ability.GOAL_INTERPRETATION)
    suite = open_suite(benchmark, Ability.GOAL_INTERPRETATION)
    verdicts = [suite.score(task_id, book[task_id].text) for task_id in suite.task_ids[::7]]
    assert not any(v.error and v.error.kind.value == "parsing" for v in verdicts)
    rates = summarise(verdicts, suite.ability)
    assert rates["hallucination"].numerator == 0  # what does not exist here is left out
    assert rates["overall.f1"].numerator > 0


@pytest.mark.usefixtures("data_store")
def test_subgoals_are_about_the_own_objects() -> None:
    benchmark = find_benchmark("virtualhome")
    book = open_lookup_book(benchmark, Ability.SUBGOAL_DECOMPOSITION)
    suite = open_suite(benchmark, Ability.SUBGOAL_DECOMPOSITION)
    verdicts = [suite.score(task_id, book[task_id].text) for task_id in suite.task_ids[::12]]
    assert not any(v.error and v.error.kind.value in ("parsing", "hallucination") for v in verdicts)
    assert summarise(verdicts, suite.ability)["task_success"].numerator > len(verdicts) / 3


def test_operators_are_those_that_another_task_asks_for(data_store: Store) -> None:
    source = Source(data_store)
    benchmark = find_benchmark("behavior")
    book = open_lookup_book(benchmark, Ability.TRANSITION_MODELING, source)
    tasks = benchmark.operators(source)
    asked = Counter(name for task in tasks.values() for name in task.operators)
    for task_id, task in tasks.items():
        known = [name for name in task.operators if asked[name] > 1]
        assert [part.split()[1] for part in book[task_id].parts] == known
    assert 1 in asked.values()


def test_most_public_plans_are_in_the_table(data_store: Store) -> None:
    suite = open_suite(find_benchmark("virtualhome"), Ability.ACTION_SEQUENCING, source=Source(data_store))
    book = open_lookup_book(suite.benchmark, suite.ability, suite.source)
    verdicts = [suite.score(task_id, book[task_id].text) for task_id in suite.task_ids]
    scored = [v for v in verdicts if isinstance(v, PlanVerdict) and v.excluded is None]
    assert (sum(v.success for v in scored), len(scored)) == (239, 337)


@pytest.mark.usefixtures("data_store")
@pytest.mark.parametrize("like", HOUSEHOLDS)
def test_no_generated_task_is_solved_by_it(like: str) -> None:
    benchmark = find_benchmark(like)
    table = LookupTable(benchmark.tasks(Source()).values(), benchmark.domain)
    from eai.abilities.action_sequencing.scorer import ActionSequencing

    for made in tasks(like):
        text = benchmark.notation.plans.join(
            benchmark.notation.plans.write(table.plan(made.task), made.task.scene)
        )
        verdict = ActionSequencing(
            made.task, domain=benchmark.domain, notation=benchmark.notation.plans
        ).score(text)
        assert not verdict.success, made.task.id
