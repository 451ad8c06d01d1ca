"""What the delete relaxation proves out of reach is never reached, and simple things are proved."""

from __future__ import annotations

import random
from dataclasses import replace
from pathlib import Path

import pytest

import eai
import eai.logic.formula as f
from eai import Task
from eai.abilities.protocol import Ability
from eai.benchmark.benchmark import Benchmark
from eai.benchmark.random_answers import random_walk
from eai.benchmark.registry import find_benchmark
from eai.data.store import Store
from eai.planning.possible import Possible, out_of_reach
from eai.tasks.source import Source
from eai.world.state import Fact
from generator.worlds import HOUSEHOLDS
from sweeps import examples

INSIDE, LIT = f.Atom("inside", (f.Constant("ball"), f.Constant("box"))), f.Atom("lit", (f.Constant("box"),))


@pytest.fixture
def lamps(monkeypatch: pytest.MonkeyPatch) -> Benchmark:
    """The example of a world of one's own."""
    monkeypatch.chdir(Path(__file__).parents[2] / "examples" / "lamps")
    return find_benchmark("lamps:lamps")


def proved(lamps: Benchmark, *goals: f.Formula) -> list[f.Formula]:
    task = lamps.tasks(Source())["pack"]
    return out_of_reach(lamps.domain, task.initial, task.relevant, goals)


def test_a_box_never_shines(lamps: Benchmark) -> None:
    assert proved(lamps, INSIDE, LIT) == [LIT]
    assert proved(lamps, f.Or((INSIDE, LIT)), f.Not(LIT), f.Exists(f.Variable("x"), INSIDE)) == []
    shut = f.Not(f.Atom("is_open", (f.Constant("box"),)))
    assert proved(lamps, f.And((INSIDE, shut))) == [], "that both are never so at once is not looked at"


def test_without_what_it_takes_nothing_is_reached(lamps: Benchmark) -> None:
    task = lamps.tasks(Source())["pack"]
    robot, ball, box = (task.scene.index[name] for name in ("robot", "ball", "box"))
    assert out_of_reach(lamps.domain, task.initial, (robot, ball), [INSIDE]) == [INSIDE]
    held = task.scene.state([Fact("holds", (robot, ball)), Fact("is_open", (box,)), Fact("at", (robot, box))])
    assert out_of_reach(lamps.domain, held, (ball, box), [INSIDE]) == []


@pytest.mark.parametrize("like", HOUSEHOLDS)
def test_what_is_ever_so_is_possible(like: str, data_store: Store) -> None:
    suite = eai.open(like, "action_sequencing")
    listings = suite.benchmark.wording(Ability.ACTION_SEQUENCING).listings
    seen = 0
    for task_id in random.Random(5).sample(suite.task_ids, examples(7)):
        task = _smaller(suite.tasks[task_id])
        possible = Possible(suite.benchmark.domain, task.initial, task.relevant)
        rng = random.Random(task_id)
        for _ in range(5):
            for _, state in random_walk(suite.benchmark.domain, task.initial, task.relevant, rng, 12):
                for each in listings:
                    for fact in each.facts(state, task.relevant):
                        seen += 1
                        assert possible.holds(*_said(fact)), fact
    assert seen > 100


def _smaller(task: Task) -> Task:
    """The task in a scene of what it is about alone."""
    keep = set(task.relevant) | {i for i in (task.scene.agent,) if i is not None}
    facts = [fact for fact in task.initial.facts() if keep.issuperset(fact.arguments)]
    return replace(task, initial=task.scene.state(facts))


def _said(fact: Fact) -> tuple[f.Formula, dict[str, int]]:
    names = [f"x{i}" for i in range(len(fact.arguments))]
    scope = dict(zip(names, fact.arguments, strict=True))
    return f.Atom(fact.predicate, tuple(map(f.Variable, names))), scope
