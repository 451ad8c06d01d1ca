"""Random answers: possible plans, fixed by task and seed, and their success on public tasks."""

from __future__ import annotations

import random
from collections import Counter
from dataclasses import replace

import pytest

from by_path import ROOT
from eai.abilities.goal_interpretation.verdict import GoalVerdict
from eai.abilities.protocol import PAPER_ABILITIES, Ability
from eai.abilities.verdict import PlanVerdict
from eai.base.store import DataPackStore
from eai.benchmarks.random_answers import open_random_answers, random_walk
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.suite import open_suite
from eai.pddl.check import check_domain
from eai.pddl.planning import PlannerChoice
from eai.pddl.reader import read_action
from eai.planning.successor_generator import generate_applicable_actions_of_operator
from eai.results.summary import compute_metric_rates
from eai.tasks.source import Source
from eai.world.execution import execute_plan
from sweeps import swept

PLANS = Ability.ACTION_SEQUENCING


@pytest.fixture
def lamps(monkeypatch: pytest.MonkeyPatch) -> str:
    """Return the reference of a benchmark for which the package has no code."""
    monkeypatch.syspath_prepend(ROOT / "examples" / "lamps")
    return "lamps:lamps"


def test_each_possible_action_is_drawn_about_equally_often(lamps: str) -> None:
    benchmark = find_benchmark(lamps)
    domain, task = benchmark.domain, next(iter(benchmark.tasks(Source()).values()))
    indices = range(len(task.scene.objects))
    possible = [
        action
        for operator in domain.operators
        for action in generate_applicable_actions_of_operator(domain, operator, task.initial, indices)
    ]
    rng, drawn = random.Random(0), Counter[object]()
    for _ in range(200 * len(possible)):
        drawn.update(action for action, _ in random_walk(domain, task.initial, indices, rng, 1))
    assert drawn.keys() == set(possible)
    assert 140 < min(drawn.values()) <= max(drawn.values()) < 260


def test_a_random_answer_about_no_objects_has_no_steps(lamps: str) -> None:
    benchmark = find_benchmark(lamps).with_changed_tasks(lambda task: replace(task, relevant=()))
    assert open_random_answers(benchmark, PLANS)("light", "1", ()).text == "[]"


@pytest.mark.parametrize(
    "ability", [ability for ability in PAPER_ABILITIES if ability is not Ability.TRANSITION_MODELING]
)
def test_random_answers_to_any_benchmark_can_be_read(lamps: str, ability: Ability) -> None:
    suite = open_suite(find_benchmark(lamps), ability)
    answer = open_random_answers(suite.benchmark, ability)
    for task_id in suite.task_ids:
        texts = {answer(task_id, str(seed), ()).text for seed in range(20)}
        assert len(texts) > 3
        assert answer(task_id, "1", ()).text == answer(task_id, "1", ()).text
        verdicts = [suite.score(task_id, text) for text in texts]
        assert not any(verdict.error and verdict.error.kind.value == "parsing" for verdict in verdicts)


@pytest.mark.parametrize("name", ["virtualhome", "behavior"])
def test_random_operators_are_valid_and_seldom_right(name: str, data_store: DataPackStore) -> None:
    source = Source(data_store, planner=PlannerChoice.NONE)
    suite = open_suite(find_benchmark(name), Ability.TRANSITION_MODELING, source=source)
    answer = open_random_answers(suite.benchmark, suite.ability, source)
    tasks = suite.benchmark.operator_tasks(source)
    verdicts = []
    for task_id in suite.task_ids[::10]:
        texts = [answer(task_id, str(seed), ()).text for seed in (0, 0, 1)]
        assert texts[0] == texts[1] != texts[2]
        verdicts.append(suite.score(task_id, texts[0]))
        actions = [read_action(text) for text in answer(task_id, "0", ()).parts]
        assert [action.name for action in actions] == list(tasks[task_id].operators)
        assert check_domain(replace(tasks[task_id].domain.header, actions=tuple(actions))) == ()
    assert 0 < (compute_metric_rates(verdicts, suite.ability)["overall.f1"].percent or 0) < 10


def test_a_random_plan_continues_after_executed_actions(data_store: DataPackStore) -> None:
    benchmark, source = find_benchmark("behavior"), Source(data_store)
    answer = open_random_answers(benchmark, PLANS, source)
    for task_id, task in list(benchmark.tasks(source).items())[:5]:
        done = task.script[:3]
        plan = benchmark.notation.plans.read(answer(task_id, "0", done).text)
        from eai.abilities.action_sequencing.scorer import ActionSequencingScorer

        actions = ActionSequencingScorer(task, benchmark.domain, benchmark.notation.plans).resolve_names(plan)  # type: ignore[arg-type]
        now = execute_plan(benchmark.domain, task.initial, done).final_state
        assert execute_plan(benchmark.domain, now, actions).failure is None  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("name", "every", "solved", "of"),
    [
        ("virtualhome", 7, 1, 49),
        ("behavior", 13, 1, 8),
        *swept(("virtualhome", 1, 22, 337), ("behavior", 1, 2, 100)),
    ],
)
def test_random_plans_are_executable_and_seldom_reach_the_goal(
    name: str, every: int, solved: int, of: int, data_store: DataPackStore
) -> None:
    suite = open_suite(find_benchmark(name), PLANS, source=Source(data_store))
    answer = open_random_answers(suite.benchmark, PLANS, suite.source)
    verdicts = [suite.score(task_id, answer(task_id, "0", ()).text) for task_id in suite.task_ids[::every]]
    scored = [v for v in verdicts if isinstance(v, PlanVerdict) and v.excluded is None]
    assert all(verdict.executable and not verdict.additional_steps for verdict in scored)
    assert (sum(bool(verdict.success) for verdict in scored), len(scored)) == (solved, of)


@pytest.mark.parametrize("name", ["virtualhome", "behavior"])
def test_random_goals_name_only_existing_things(name: str, data_store: DataPackStore) -> None:
    suite = open_suite(find_benchmark(name), Ability.GOAL_INTERPRETATION, source=Source(data_store))
    answer = open_random_answers(suite.benchmark, suite.ability, suite.source)
    for task_id in suite.task_ids[::10]:
        verdict = suite.score(task_id, answer(task_id, "0", ()).text)
        assert isinstance(verdict, GoalVerdict)
        assert (verdict.hallucinated, verdict.unknown_predicates, verdict.ill_formed) == ((), (), 0)
