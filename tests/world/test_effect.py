from __future__ import annotations

import random

import pytest

from eai.base.errors import DomainError
from eai.benchmarks.virtualhome import domain as virtualhome
from eai.benchmarks.virtualhome.tasks import VirtualHomeTasks
from eai.logic.formula import Variable
from eai.world.action import Action, Fault
from eai.world.domain import Domain
from eai.world.effect import ANYTHING, Add, Delete, EffectCompiler
from eai.world.execution import attempt_action
from eai.world.frame import AGENT, SlotAllocator
from eai.world.history import History
from eai.world.operator import Operator
from eai.world.state import Fact, Scene, State
from eai.world.vocabulary import Predicate, Vocabulary
from world import plain_sets, toy


def random_walk(
    domain: Domain, initial: State, nameable: range | tuple[int, ...], seed: int, steps: int
) -> int:
    """Execute random actions in the engine and on plain sets, and compare all facts after each."""
    rng = random.Random(seed)
    state = initial
    facts = frozenset(state.facts())
    executed = 0
    for _ in range(steps):
        operator = rng.choice(domain.operators)
        arguments = tuple(rng.choice(nameable) for _ in operator.parameters)
        bound = {p.name: i for p, i in zip(operator.parameters, arguments, strict=True)}
        expected = all(plain_sets.holds(state, facts, c.condition, bound) for c in operator.checks)
        outcome = attempt_action(domain, History(state), Action(operator.name, arguments))
        assert isinstance(outcome, State) == expected, operator.name
        if isinstance(outcome, Fault):
            continue
        before = facts
        for effect in operator.effects:
            facts = plain_sets.apply(state, before, facts, effect, bound)
        state, executed = outcome, executed + 1
        assert frozenset(state.facts()) == facts, operator.name
    return executed


@pytest.mark.parametrize("seed", range(20))
def test_the_engine_equals_plain_sets_in_the_toy_domain(seed: int) -> None:
    initial = toy.initial()
    assert random_walk(toy.DOMAIN, initial, range(len(initial.scene.objects)), seed, 100) > 0


@pytest.fixture
def domain() -> Domain:
    """Return the domain by the paper's rules. Tests of other rules override this fixture."""
    return virtualhome.make_domain_with_checks_in_paper_order()


@pytest.mark.parametrize("task_id", ["27_2", "1003_2", "417_1"])
def test_the_engine_equals_plain_sets_in_virtualhome(
    virtualhome_tasks: VirtualHomeTasks, domain: Domain, task_id: str
) -> None:
    task = virtualhome_tasks[task_id]
    scene = Scene(domain.vocabulary, task.scene.objects, task.scene.agent)
    initial = scene.state(task.initial.facts())
    assert random_walk(domain, initial, task.relevant, seed=1, steps=60) > 10


def test_states_are_equal_exactly_if_their_facts_are() -> None:
    rng = random.Random(0)
    initial = toy.initial()
    seen: dict[frozenset[Fact], State] = {}
    state = initial
    for _ in range(300):
        action = Action(rng.choice(("GO", "LIFT", "DROP", "PRESS")), (rng.randrange(6),))
        outcome = attempt_action(toy.DOMAIN, History(state), action)
        state = outcome if isinstance(outcome, State) else state
        equal_state = seen.setdefault(frozenset(state.facts()), state)
        assert (equal_state, hash(equal_state)) == (state, hash(state))
    assert len(set(seen.values())) == len(seen)


STATIC = Predicate("STATIC", 1, static=True)
PAIR = Predicate("PAIR", 2)
X = Variable("x")


@pytest.mark.parametrize(
    ("effect", "message"),
    [
        (Add(STATIC(X)), "STATIC, which is declared static"),
        (Add(Predicate("OTHER", 1)(X)), "predicate OTHER is not declared"),
        (Add(Predicate("PAIR", 1)(X)), "PAIR takes 2 arguments, not 1"),
        (Add(PAIR(X, ANYTHING)), "an effect adds PAIR with ANYTHING"),
        (Delete(PAIR(Variable("y"), AGENT)), "variable y is not bound"),
    ],
)
def test_an_impossible_effect_is_a_domain_error(effect: Add | Delete, message: str) -> None:
    with pytest.raises(DomainError, match=message):
        EffectCompiler(Vocabulary((STATIC, PAIR)), SlotAllocator((X,))).compile_sequence([effect])


def test_a_deletion_of_anything_and_anything_clears_a_relation() -> None:
    domain = Domain(
        "d", Vocabulary((PAIR,)), (Operator("CLEAR", (), (), (Delete(PAIR(ANYTHING, ANYTHING)),)),)
    )
    scene = Scene(domain.vocabulary, {"a": "t", "b": "t"})
    start = scene.state(["PAIR(a, b)", "PAIR(b, b)", "PAIR(b, a)"])
    assert [*domain.apply(start, Action("CLEAR", ())).facts()] == []
    assert len(start.relation("PAIR")) == 3
