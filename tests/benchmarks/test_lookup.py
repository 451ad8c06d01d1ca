"""The lookup table: its answer for a similar task, and its success on public tasks."""

from __future__ import annotations

from collections import Counter

import pytest

from benchmarks.generator.worlds import HOUSEHOLDS, tasks
from eai import make_task
from eai.abilities.protocol import Ability
from eai.abilities.verdict import PlanVerdict
from eai.base.store import DataPackStore
from eai.benchmarks.copied_answers import SimilarTaskTable, open_answers_of_similar_tasks
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.suite import open_suite
from eai.results.summary import compute_metric_rates
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


def make_atom(predicate: str, name: str) -> Formula:
    return Atom(predicate, (Constant(name),))


LAMP = task("lamp", {"l1": "lamp", "o1": "oven"}, (("LIGHT", "l1"),), make_atom("lit", "l1"))
BOTH = task(
    "both",
    {"l1": "lamp", "l2": "lamp", "o1": "oven"},
    (("LIGHT", "l2"), ("HEAT", "o1")),
    make_atom("lit", "l2"),
    make_atom("warm", "o1"),
)
TABLE = SimilarTaskTable([LAMP, BOTH], DOMAIN)


def look_up(new_task: Task) -> list[tuple[str, str]]:
    return [
        (a.operator, new_task.scene.objects[a.arguments[0]].name)
        for a in TABLE.adapt_plan_of_most_similar_task(new_task)
    ]


def test_the_plan_of_the_most_similar_goals_is_adapted_to_the_tasks_objects() -> None:
    new_task = task(
        "new", {"a": "lamp", "b": "lamp", "c": "oven"}, (), make_atom("warm", "c"), make_atom("lit", "b")
    )
    assert look_up(new_task) == [("LIGHT", "b"), ("HEAT", "c")]


def test_steps_about_missing_objects_are_left_out() -> None:
    new_task = task("new", {"a": "lamp"}, (), make_atom("lit", "a"), make_atom("warm", "a"))
    assert look_up(new_task) == [("LIGHT", "a")]
    assert SimilarTaskTable([], DOMAIN).adapt_plan_of_most_similar_task(new_task) == ()


def test_a_task_is_not_looked_up_by_itself() -> None:
    assert look_up(BOTH) == [("LIGHT", "l2")]


@pytest.mark.usefixtures("data_store")
@pytest.mark.parametrize("name", ["virtualhome", "behavior"])
def test_goals_of_the_most_similar_instruction_are_partly_right(name: str) -> None:
    benchmark = find_benchmark(name)
    book = open_answers_of_similar_tasks(benchmark, Ability.GOAL_INTERPRETATION)
    suite = open_suite(benchmark, Ability.GOAL_INTERPRETATION)
    verdicts = [suite.score(task_id, book[task_id].text) for task_id in suite.task_ids[::7]]
    assert not any(v.error and v.error.kind.value == "parsing" for v in verdicts)
    rates = compute_metric_rates(verdicts, suite.ability)
    assert rates["hallucination"].numerator == 0  # unknown names are left out
    assert rates["overall.f1"].numerator > 0


@pytest.mark.usefixtures("data_store")
def test_looked_up_subgoals_name_the_tasks_objects() -> None:
    benchmark = find_benchmark("virtualhome")
    book = open_answers_of_similar_tasks(benchmark, Ability.SUBGOAL_DECOMPOSITION)
    suite = open_suite(benchmark, Ability.SUBGOAL_DECOMPOSITION)
    verdicts = [suite.score(task_id, book[task_id].text) for task_id in suite.task_ids[::12]]
    assert not any(v.error and v.error.kind.value in ("parsing", "hallucination") for v in verdicts)
    assert compute_metric_rates(verdicts, suite.ability)["task_success"].numerator > len(verdicts) / 3


def test_operators_are_looked_up_if_another_task_needs_them(data_store: DataPackStore) -> None:
    source = Source(data_store)
    benchmark = find_benchmark("behavior")
    book = open_answers_of_similar_tasks(benchmark, Ability.TRANSITION_MODELING, source)
    tasks = benchmark.operator_tasks(source)
    uses = Counter(name for task in tasks.values() for name in task.operators)
    for task_id, task in tasks.items():
        expected = [name for name in task.operators if uses[name] > 1]
        assert [text.split()[1] for text in book[task_id].parts] == expected
    assert 1 in uses.values()


def test_the_lookup_table_solves_most_public_tasks(data_store: DataPackStore) -> None:
    suite = open_suite(find_benchmark("virtualhome"), Ability.ACTION_SEQUENCING, source=Source(data_store))
    book = open_answers_of_similar_tasks(suite.benchmark, suite.ability, suite.source)
    verdicts = [suite.score(task_id, book[task_id].text) for task_id in suite.task_ids]
    scored = [v for v in verdicts if isinstance(v, PlanVerdict) and v.excluded is None]
    assert (sum(v.success for v in scored), len(scored)) == (239, 337)


@pytest.mark.usefixtures("data_store")
@pytest.mark.parametrize("like", HOUSEHOLDS)
def test_the_lookup_table_solves_no_generated_task(like: str) -> None:
    benchmark = find_benchmark(like)
    table = SimilarTaskTable(benchmark.tasks(Source()).values(), benchmark.domain)
    from eai.abilities.action_sequencing.scorer import ActionSequencingScorer

    for made in tasks(like):
        text = benchmark.notation.plans.join(
            benchmark.notation.plans.write(table.adapt_plan_of_most_similar_task(made.task), made.task.scene)
        )
        verdict = ActionSequencingScorer(
            made.task, domain=benchmark.domain, notation=benchmark.notation.plans
        ).score(text)
        assert not verdict.success, made.task.id
