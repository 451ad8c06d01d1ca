"""Compiled domains are used from many threads, each with its own bindings."""

from __future__ import annotations

import random
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

import pytest

from eai.logic.formula import Atom, Equals, Exactly, Exists, ForAll, ForPairs, Variable
from eai.world.action import Action
from eai.world.condition import FormulaEvaluator
from eai.world.domain import Domain
from eai.world.execution import execute_plan
from eai.world.operator import Operator, missing_step
from eai.world.state import State
from world import toy

X, Y, Z = (Variable(name) for name in "xyz")
BOX, PLACE = Variable("y", "box"), Variable("z", "place")
CONDITIONS = (
    Exists(Y, toy.at(X, Y) & Exactly(1, Z, toy.at(Z, Y) & ~Equals(Z, X))),
    ForAll(BOX, Exists(PLACE, toy.at(Y, Z)) | toy.holding(Y)),
    ForPairs(BOX, PLACE, toy.at(Y, Z), 1),
    Exactly(2, BOX, ~Equals(Y, X)),
)
"""Quantifiers that put objects into the binding, one after the other."""

WAIT = Operator("WAIT", (X,), tuple(missing_step(condition, "not yet") for condition in CONDITIONS), ())


@pytest.fixture
def restless() -> Iterator[None]:
    """Let threads take turns as often as possible."""
    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-5)
    yield
    sys.setswitchinterval(interval)


def plans(seed: int) -> list[list[Action]]:
    rng = random.Random(seed)
    names = ("GO", "LIFT", "DROP", "PRESS", "WAIT")
    return [[Action(rng.choice(names), (rng.randrange(6),)) for _ in range(20)] for _ in range(60)]


def outcomes(domain: Domain, readings: FormulaEvaluator, initial: State, seed: int) -> list[object]:
    """Return the outcomes of some plans, and readings of their last states, as comparable values."""
    found: list[object] = []
    for plan in plans(seed):
        trajectory = execute_plan(domain, initial, plan)
        found.append(trajectory.steps)
        final = trajectory.final_state
        found += [readings.holds(c, {"x": i}, final) for c in CONDITIONS for i in range(6)]
        found += [tuple(readings.find_witnesses(Y, Atom("at", (X, Y)), {"x": i}, final)) for i in range(6)]
    return found


@pytest.mark.usefixtures("restless")
def test_a_domain_may_be_used_from_any_number_of_threads() -> None:
    fresh = toy.DOMAIN.replace_operators(WAIT)  # the first thread compiles it
    readings, initial = FormulaEvaluator(fresh.vocabulary), toy.initial()
    with ThreadPoolExecutor(8) as pool:
        together = list(pool.map(lambda seed: outcomes(fresh, readings, initial, seed), range(16)))
    again = toy.DOMAIN.replace_operators(WAIT)
    assert together == [
        outcomes(again, FormulaEvaluator(again.vocabulary), toy.initial(), seed) for seed in range(16)
    ]
