"""Goals proved unreachable by the delete relaxation are never reached, and simple cases are proved."""

from __future__ import annotations

import random

import pytest

import eai.logic.formula as f
from benchmarks.generator.worlds import generator
from by_path import ROOT
from eai.abilities.protocol import Ability
from eai.base.store import DataPackStore
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.generator.spec import GeneratedTask
from eai.benchmarks.random_answers import random_walk
from eai.benchmarks.registry import find_benchmark
from eai.planning.possible import PossibleFacts, find_unreachable_goals
from eai.tasks.source import Source
from eai.world.state import Fact
from sweeps import swept

INSIDE, LIT = f.Atom("inside", (f.Constant("ball"), f.Constant("box"))), f.Atom("lit", (f.Constant("box"),))


@pytest.fixture
def lamps(monkeypatch: pytest.MonkeyPatch) -> Benchmark:
    """Return the world of the example in the documentation."""
    monkeypatch.chdir(ROOT / "examples" / "lamps")
    return find_benchmark("lamps:lamps")


def proved(lamps: Benchmark, *goals: f.Formula) -> list[f.Formula]:
    task = lamps.tasks(Source())["pack"]
    return find_unreachable_goals(lamps.domain, task.initial, task.relevant, goals)


def test_a_box_never_shines(lamps: Benchmark) -> None:
    assert proved(lamps, INSIDE, LIT) == [LIT]
    assert proved(lamps, f.Or((INSIDE, LIT)), f.Not(LIT), f.Exists(f.Variable("x"), INSIDE)) == []
    shut = f.Not(f.Atom("is_open", (f.Constant("box"),)))
    assert proved(lamps, f.And((INSIDE, shut))) == [], "that both are never so at once is not looked at"


@pytest.mark.parametrize(
    ("count", "is_possible"), [(None, False), (0, True), (1, False), (999_999_999, False)]
)
def test_no_more_pairs_are_possible_than_there_are_things(
    lamps: Benchmark, count: int | None, is_possible: bool
) -> None:
    x, y = f.Variable("x"), f.Variable("y")
    pairs = f.ForPairs(x, y, f.And((LIT, f.Atom("inside", (x, y)))), count)
    assert proved(lamps, pairs) == ([] if is_possible else [pairs])


def test_a_goal_without_the_needed_objects_is_proved_unreachable(lamps: Benchmark) -> None:
    task = lamps.tasks(Source())["pack"]
    robot, ball, box = (task.scene.index[name] for name in ("robot", "ball", "box"))
    assert find_unreachable_goals(lamps.domain, task.initial, (robot, ball), [INSIDE]) == [INSIDE]
    held = task.scene.state([Fact("holds", (robot, ball)), Fact("is_open", (box,)), Fact("at", (robot, box))])
    assert find_unreachable_goals(lamps.domain, held, (ball, box), [INSIDE]) == []


@pytest.mark.parametrize(
    ("like", "seed"), [("virtualhome", "golden-0-0"), *swept(("behavior", "golden-0-0"))]
)
def test_every_fact_of_a_reachable_state_is_possible(like: str, seed: str, data_store: DataPackStore) -> None:
    benchmark = find_benchmark(like)
    made = generator(like).generate_task(seed)
    assert isinstance(made, GeneratedTask)
    task, domain, rng = made.task, benchmark.domain, random.Random(seed)
    possible = PossibleFacts(domain, task.initial, task.relevant)
    seen = set[Fact]()
    for _ in range(4):
        for _, state in random_walk(domain, task.initial, task.relevant, rng, 12):
            for each in benchmark.wording(Ability.ACTION_SEQUENCING).fact_listers_of_goal_predicates:
                seen.update(each.list_facts(state, task.relevant))
    assert len(seen) > 30
    assert [fact for fact in sorted(seen) if not possible.may_hold(*_said(fact))] == []


def _said(fact: Fact) -> tuple[f.Formula, dict[str, int]]:
    names = [f"x{i}" for i in range(len(fact.arguments))]
    scope = dict(zip(names, fact.arguments, strict=True))
    return f.Atom(fact.predicate, tuple(map(f.Variable, names))), scope
