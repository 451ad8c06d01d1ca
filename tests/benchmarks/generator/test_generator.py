"""Generated tasks: certificates checked by the engine, by plain sets and by VAL, and rejections."""

from __future__ import annotations

import random
import subprocess
import sys
from dataclasses import replace
from fnmatch import fnmatchcase
from itertools import pairwise, product
from pathlib import Path

import pytest

import eai.logic.formula as f
from benchmarks.generator.worlds import HOUSEHOLDS, generate_from_seeds, generator, outcomes, tasks
from eai import make_task, use_tasks
from eai.base.errors import DataError
from eai.base.store import DataPackStore
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.generator.goals import GoalSampler
from eai.benchmarks.generator.growing_plan import GoalByGoalPlan, find_min_plan_length
from eai.benchmarks.generator.sets import fingerprint_task, make_seeds
from eai.benchmarks.generator.spec import LENGTHS, GeneratedTask, PlanLengthTier, SeedRejectionReason
from eai.benchmarks.generator.usual_goals import LiteralPattern, find_categories_used_as_arguments
from eai.benchmarks.registry import find_benchmark
from eai.cli.generate import validate_with_val
from eai.logic.traversal import walk_subformulas
from eai.pddl.val import VALID, find_val_program
from eai.planning.planner import Planner
from eai.tasks.goal_test import GoalTest
from eai.tasks.source import Source
from eai.tasks.task import Task
from eai.tasks.task_lines import make_task_from_line, read_task_line, write_task_line
from eai.world.action import Action
from eai.world.domain import Domain
from eai.world.execution import execute_plan
from eai.world.operator import Operator
from eai.world.state import Fact, Scene, State, WorldObject
from sweeps import sweep, swept
from world import plain_sets

pytestmark = pytest.mark.usefixtures("data_store")


def solves(domain: Domain, task: Task, plan: tuple[Action, ...]) -> bool:
    trajectory = execute_plan(domain, task.initial, plan)
    reached = GoalTest(task).evaluate_each_goal(
        trajectory.final_state, [action.operator for action in trajectory.executed_actions]
    )
    return trajectory.failure is None and all(reached)


@pytest.mark.parametrize("like", HOUSEHOLDS)
def test_a_task_is_a_function_of_its_seed_alone(like: str) -> None:
    made = tasks(like)[-1]
    again = generator.__wrapped__(like).generate_task(str(made.about["seed"]))  # type: ignore[attr-defined]
    domain = find_benchmark(like).domain
    assert isinstance(again, GeneratedTask)
    assert write_task_line(again.task, like, domain, again.about) == write_task_line(
        made.task, like, domain, made.about
    )


@sweep
def test_the_order_of_hash_tables_plays_no_part() -> None:
    code = (
        "import hashlib; from benchmarks.generator.worlds import tasks;"
        "from eai.tasks.task_lines import write_task_line;"
        "from eai.benchmarks.registry import find_benchmark as find;"
        "lines = [write_task_line(t.task, n, find(n).domain, t.about)"
        " for n in ('virtualhome', 'behavior') for t in tasks(n, 6)];"
        "print(hashlib.sha256(''.join(lines).encode()).hexdigest())"
    )
    places = {"PYTHONPATH": ":".join(sys.path), "HOME": str(Path.home())}
    digests = {
        subprocess.run(
            [sys.executable, "-c", code],
            env={**places, "PYTHONHASHSEED": seed},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for seed in ("1", "2")
    }
    assert len(digests) == 1


@pytest.mark.parametrize("like", HOUSEHOLDS)
def test_certificates_solve_and_need_every_step(like: str) -> None:
    domain = find_benchmark(like).domain
    assert len(tasks(like)) > 10
    for made in tasks(like):
        task, plan = made.task, made.task.script
        assert not any(GoalTest(task).evaluate_each_goal(task.initial, ())), task.id
        assert solves(domain, task, plan), task.id
        assert execute_plan(domain, task.initial, plan).needless_step_count == 0
        assert not any(solves(domain, task, (*plan[:i], *plan[i + 1 :])) for i in range(len(plan))), task.id
        assert find_min_plan_length(task, domain, 1) == made.about["lower_bound"] == 2, task.id


@pytest.mark.parametrize("like", HOUSEHOLDS)
def test_certificates_solve_by_a_naive_engine_too(like: str) -> None:
    """The naive engine uses plain sets of facts. Functions of the domain get an equal state of the engine."""
    domain = find_benchmark(like).domain
    for made in tasks(like)[:8]:
        state = made.task.initial
        facts = frozenset(state.facts())
        for action in made.task.script:
            operator = domain.find_operator(action.operator)
            assert operator is not None
            bound = {p.name: i for p, i in zip(operator.parameters, action.arguments, strict=True)}
            facts = naively(state, facts, operator, bound)
            state = made.task.scene.state(facts)
        assert all(domain.holds(goal.formula, state) for goal in made.task.goals), made.task.id


def naively(
    state: State, facts: frozenset[Fact], operator: Operator, bound: dict[str, int]
) -> frozenset[Fact]:
    """Return the facts after an action, all of whose checks must hold."""
    assert all(plain_sets.holds(state, facts, check.condition, bound) for check in operator.checks)
    after = facts
    attempted = [t for t in operator.alternatives if plain_sets.holds(state, facts, t.condition, bound)]
    made = [t for t in attempted if all(plain_sets.holds(state, facts, c.condition, bound) for c in t.checks)]
    assert made or not attempted
    for effect in (*(effect for each in made for effect in each.effects), *operator.effects):
        after = plain_sets.apply(state, facts, after, effect, bound)
    return after


@pytest.mark.parametrize("like", ["behavior", *swept("virtualhome")])
def test_certificates_are_valid_by_val(like: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("eai.pddl.val._MAX_CPU_SECONDS", 1200)
    try:
        val = find_val_program()
    except DataError as error:
        pytest.skip(str(error))
    domain = find_benchmark(like).domain
    for task in (made.task for made in tasks(like)[:2]):
        assert validate_with_val(val, domain, task, task.script) == VALID, task.id
        assert validate_with_val(val, domain, task, task.script[:-1]) == "not valid", task.id


@pytest.mark.parametrize("like", HOUSEHOLDS)
def test_scenes_are_closed(like: str) -> None:
    made = generator(like)
    for each in tasks(like):
        task = each.task
        assert len(task.scene.objects) <= 30
        assert task.relevant == tuple(range(len(task.scene.objects)))
        kinds = {
            kind for action in task.script for kind in find_categories_used_as_arguments(action, task.scene)
        }
        assert kinds <= made.usual_goals.uses  # every use of a category occurs in a plan of the data set


@pytest.mark.parametrize("like", HOUSEHOLDS)
def test_goals_are_about_what_belongs_together_and_none_is_odd(like: str) -> None:
    usual_goals, english = generator(like).usual_goals, find_benchmark(like).notation.english
    together = [theme.categories for theme in usual_goals.themes.values()]
    usual = [pattern for known in usual_goals.patterns.values() for pattern in known if pattern.truth]
    assert any(
        english.is_goal_nobody_would_request(pattern.predicate, pattern.categories) for pattern in usual
    )
    for made in tasks(like):
        scene = made.task.scene
        for each in made.task.goals:
            for part in walk_subformulas(each.formula):
                if isinstance(part, f.Atom) and all(isinstance(t, f.Constant) for t in part.arguments):
                    categories = [scene.objects[scene.index[t.name]].category for t in part.arguments]
                    assert any(theme.issuperset(categories) for theme in together)
                    if not isinstance(each.formula, f.Not):
                        assert not english.is_goal_nobody_would_request(part.predicate, categories), (
                            made.task.id,
                            part,
                        )


@pytest.mark.parametrize("like", HOUSEHOLDS)
def test_every_line_of_the_odd_lists_matches_a_literal(like: str) -> None:
    """A line with a misspelled name would match no literal."""
    usual_goals, english = generator(like).usual_goals, find_benchmark(like).notation.english
    known = [p for patterns in usual_goals.patterns.values() for p in patterns]
    told = [" ".join((pattern.predicate, *pattern.categories)) for pattern in known if pattern.truth]
    for line in english.odd:
        assert any(fnmatchcase(each, line) for each in told), line
    for line in english.sound:
        assert any(fnmatchcase(each, line) for each in told), line


@pytest.mark.parametrize("like", HOUSEHOLDS)
def test_no_task_is_public_and_none_twice(like: str, data_store: DataPackStore) -> None:
    public = {
        fingerprint_task(task)[0] for task in find_benchmark(like).tasks(generator(like).source).values()
    }
    known: set[tuple[str, str]] = set()
    made = [
        each
        for each in generate_from_seeds(generator(like), make_seeds("test", 1), 15, known)
        if isinstance(each, GeneratedTask)
    ]
    prints = [fingerprint_task(each.task) for each in made]
    assert public.isdisjoint(of_goals for of_goals, _ in prints)
    assert len(set(prints)) == 15
    repeated = next(generate_from_seeds(generator(like), iter([str(made[0].about["seed"])]), 1, known))
    assert repeated == SeedRejectionReason.COPY


def test_fingerprints_know_objects_by_category() -> None:
    made = tasks("behavior")[0].task
    line = write_task_line(made, "behavior", find_benchmark("behavior").domain)
    for name in line_names(made):
        line = line.replace(f'"{name}"', f'"other_{name}"').replace(f"({name}", f"(other_{name}")
        line = line.replace(f", {name}", f", other_{name}")
    renamed = make_task_from_line(read_task_line(line), find_benchmark("behavior").domain)
    assert fingerprint_task(renamed) == fingerprint_task(made)
    without = replace(made, goals=made.goals[1:])
    assert fingerprint_task(without)[0] != fingerprint_task(made)[0]


def line_names(task: Task) -> list[str]:
    """Return names for a scene such that no name contains another name."""
    names = [thing.name for thing in task.scene.objects]
    if any("-" in name for name in names):
        pytest.skip("formulas spell names with hyphens otherwise")
    return names


def test_the_lower_bound_is_exact_for_short_plans(lamps: Benchmark) -> None:
    light, pack = lamps.tasks(Source()).values()
    assert [find_min_plan_length(pack, lamps.domain, depth) for depth in (1, 3, 6)] == [2, 4, 6]
    assert [find_min_plan_length(light, lamps.domain, depth) for depth in (1, 4, 5)] == [2, 4, 4]


TIERS = (PlanLengthTier.S, PlanLengthTier.M, PlanLengthTier.L, PlanLengthTier.XL)
SHORT = [
    ("virtualhome", PlanLengthTier.S),
    ("virtualhome", PlanLengthTier.M),
    ("virtualhome", PlanLengthTier.L),
    ("behavior", PlanLengthTier.S),
]


@pytest.mark.parametrize(
    ("like", "tier"), [*SHORT, *swept(*(each for each in product(HOUSEHOLDS, TIERS) if each not in SHORT))]
)
def test_tiers_are_lengths_of_certificates(like: str, tier: PlanLengthTier) -> None:
    made = generator(like, tier)
    sound = (each for each in map(made.generate_task, map(str, range(60))) if isinstance(each, GeneratedTask))
    found = next(sound)
    least, most = LENGTHS[tier]
    assert least <= len(found.task.script) <= most
    assert found.about["tier"] == tier.value


def test_all_shapes_of_goals_are_made() -> None:
    paired = generator("behavior", forms="all").generate_task("test-1-109")
    assert isinstance(paired, GeneratedTask)
    made = [*tasks("behavior", 60, "all"), paired]
    shapes = {type(goal.formula).__name__ for each in made for goal in each.task.goals}
    assert {"Atom", "Not", "Or", "ForAll", "Exists", "Exactly", "ForPairs"} <= shapes


def test_goals_ask_for_actions_if_the_specification_does() -> None:
    made = generator("virtualhome", actions=True)
    found = [each for each in map(made.generate_task, map(str, range(20))) if isinstance(each, GeneratedTask)]
    asked = [each for each in found if "has been taken" in each.task.instruction]
    assert asked
    assert all(solves(made.benchmark.domain, each.task, each.task.script) for each in asked)


def test_rejections_have_reasons() -> None:
    reasons = {
        each for like in HOUSEHOLDS for each in outcomes(like) if isinstance(each, SeedRejectionReason)
    }
    assert SeedRejectionReason.TOO_SHORT in reasons
    assert SeedRejectionReason.NO_CERTIFICATE not in reasons
    assert SeedRejectionReason.AMBIGUOUS not in reasons


def test_a_task_with_objects_that_can_never_be_seen_is_rejected(monkeypatch: pytest.MonkeyPatch) -> None:
    """The sink is in a closed counter that cannot be opened, so an agent with a partial view cannot win."""
    from eai.agents.reference import make_setup
    from eai.agents.rules import STANDARD

    made = generator("virtualhome")
    assert made.generate_task("tasks-7-6") is SeedRejectionReason.NEVER_SEEN
    monkeypatch.setattr(made, "_can_goal_objects_be_seen", lambda task: True)
    kept = made.generate_task("tasks-7-6")
    assert isinstance(kept, GeneratedTask)
    assert make_setup(kept.task, made.benchmark, STANDARD).reference.commands is None


def test_generation_uses_only_declarations_of_the_benchmark(lamps: Benchmark) -> None:
    from eai.benchmarks.generator.generator import TaskGenerator
    from eai.benchmarks.generator.spec import TaskSpecification

    source = Source()
    made = TaskGenerator(lamps, TaskSpecification("lamps:lamps", lamps.tasks(source).sha256), source)
    found = [
        each
        for each in generate_from_seeds(made, make_seeds("test", 0), 5, set())
        if isinstance(each, GeneratedTask)
    ]
    assert all(solves(lamps.domain, each.task, each.task.script) for each in found)


@pytest.mark.parametrize(
    ("goal", "plan"), [("forall l: lamp. (lit(l))", (("GO", 1), ("PRESS", 1))), ("PRESS()", ())]
)
def test_a_scene_that_fits_no_usual_shape_of_goals_gives_no_task(
    goal: str, plan: tuple[tuple[str, int], ...], lamps: Benchmark
) -> None:
    """Quantifiers need several lamps, and the specification asks for no goals about actions."""
    from eai.benchmarks.generator.generator import TaskGenerator
    from eai.benchmarks.generator.spec import TaskSpecification

    scene = Scene(lamps.domain.vocabulary, {"robot": "robot", "lamp": "lamp"}, agent="robot")
    only = replace(
        make_task("only", "Play.", scene.state([]), goal, domain=lamps.domain),
        script=tuple([Action(name, (thing,)) for name, thing in plan]),
    )
    made = TaskGenerator(
        replace(lamps, open_tasks=use_tasks(only)), TaskSpecification("lamps:lamps", ""), Source()
    )
    assert made.generate_task("0") is SeedRejectionReason.NO_GOALS


def test_planners_are_replaced_after_a_fixed_number_of_tasks(
    lamps: Benchmark, monkeypatch: pytest.MonkeyPatch
) -> None:
    from eai.benchmarks.generator import generator as module
    from eai.benchmarks.generator.spec import TaskSpecification

    monkeypatch.setattr(module, "_TASKS_PER_PLANNER", 4)
    source = Source()
    made = module.TaskGenerator(lamps, TaskSpecification("lamps:lamps", lamps.tasks(source).sha256), source)
    planners = []
    for seed in range(9):
        made.generate_task(str(seed))
        planners.append(made._planner)
    anew = [one is not other for one, other in pairwise(planners)]
    assert anew == [False, False, True, False, False, False, True, False]


@pytest.mark.parametrize(("wanted", "tried"), [(3, 5), (15, 5), (18, 6), (24, 8)])
def test_no_more_goals_are_proposed_after_failures_in_a_row(
    lamps: Benchmark, monkeypatch: pytest.MonkeyPatch, wanted: int, tried: int
) -> None:
    """The limit is five failures in a row, or a third of the wanted steps if that is more."""
    from eai.benchmarks.generator.generator import TaskGenerator
    from eai.benchmarks.generator.spec import TaskSpecification

    source = Source()
    made = TaskGenerator(lamps, TaskSpecification("lamps:lamps", lamps.tasks(source).sha256), source)
    things = [WorldObject(f"lamp_{n}", "lamp") for n in range(30)]
    start = Scene(lamps.domain.vocabulary, [WorldObject("robot", "robot"), *things], 0).state([])
    lit = {("lit", True): {LiteralPattern("lit", ("lamp",), True): 1.0}}
    proposals = GoalSampler(made.usual_goals, start.scene, {"Atom": 1}, lit)
    walk, asked = GoalByGoalPlan(Planner(lamps.domain), start), []
    monkeypatch.setattr(GoalByGoalPlan, "reach_goal", lambda self, goal: bool(asked.append(goal)))
    made._extend_action_sequence(walk, proposals, (), random.Random(0), wanted, frozenset())
    assert len(asked) == len(set(asked)) == tried


@pytest.mark.parametrize("like", ["behavior", *swept("virtualhome")])
def test_scenes_differ_from_public_scenes_by_earlier_actions(like: str) -> None:
    """Some objects are in places that no public scene has, and no hand holds a further object.

    VirtualHome also stores the last place of an object that was taken and put down.
    """
    made = generator(like)
    public = {
        (fact.predicate, *(task.scene.objects[i].name for i in fact.arguments))
        for task in find_benchmark(like).tasks(made.source).values()
        for fact in task.initial.facts()
    }
    moved = 0
    for each in tasks(like):
        state = each.task.initial
        facts = [(f.predicate, *(state.scene.objects[i].name for i in f.arguments)) for f in state.facts()]
        moved += any(fact not in public for fact in facts if fact[0] in made.usual_goals.place_relations)
        agent = None if state.scene.agent is None else state.scene.objects[state.scene.agent].name
        held = {
            fact
            for fact in facts
            if fact[0] in made.usual_goals.holding_predicate_names and agent in (None, fact[1])
        }
        assert held <= public, each.task.id
    assert moved > len(tasks(like)) // 10
