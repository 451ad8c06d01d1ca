from __future__ import annotations

from itertools import combinations

import pytest

from eai.logic.formula import Formula
from eai.planning.exclusion import MutualExclusionRules
from eai.planning.subgoal import GroundAtom
from eai.world.action import Action
from eai.world.derived import is_a
from eai.world.domain import Domain
from eai.world.effect import Add, Delete, ForEach, Let
from eai.world.execution import attempt_action
from eai.world.history import History
from eai.world.operator import Operator, OperatorAlternative, missing_step
from eai.world.state import Fact, Scene, State, WorldObject
from eai.world.vocabulary import Predicate, Vocabulary
from world import toy
from world.toy import X

INITIAL = toy.initial()
INDEX = INITIAL.scene.index


def literal(text: str) -> GroundAtom:
    words = text.removeprefix("not ").split()
    return GroundAtom(words[0], tuple([INDEX[name] for name in words[1:]]), not text.startswith("not "))


@pytest.mark.parametrize(
    ("literals", "excluded"),
    [
        (["at robot hall", "at robot shed"], True),
        (["holding red", "holding blue"], True),
        (["lit lamp", "not lit lamp"], True),
        (["at robot hall", "at robot shed", "lit lamp"], True),
        (["at red hall", "at blue hall"], False),
        (["holding red", "at red hall"], False),
        (["lit lamp"], False),
    ],
)
def test_literals_that_no_state_meets_are_excluded(literals: list[str], excluded: bool) -> None:
    assert (
        MutualExclusionRules(toy.DOMAIN)
        .make_mutual_exclusion_prover(INITIAL)
        .are_exclusive(map(literal, literals))
        is excluded
    )


def test_literals_of_the_initial_state_or_of_other_actions_are_not_excluded() -> None:
    both = [literal("holding red"), literal("holding blue")]
    held = [Fact(each.predicate, each.arguments) for each in both]
    started = INITIAL.scene.state([*INITIAL.facts(), *held])
    rules = MutualExclusionRules(toy.DOMAIN)
    assert rules.make_mutual_exclusion_prover(INITIAL).are_exclusive(both)
    assert not rules.make_mutual_exclusion_prover(started).are_exclusive(both)
    snatch = Operator("SNATCH", (toy.X,), (), (Add(toy.holding(toy.X)),))
    assert (
        not MutualExclusionRules(toy.DOMAIN.replace_operators(snatch))
        .make_mutual_exclusion_prover(INITIAL)
        .are_exclusive(both)
    )


def test_a_pair_is_proved_once_for_all_episodes_and_objects() -> None:
    rules = MutualExclusionRules(toy.DOMAIN)
    at = [literal(f"at {words}") for words in ("robot hall", "robot shed")]
    assert rules.make_mutual_exclusion_prover(INITIAL).are_exclusive(at)
    proofs = sum(map(len, rules.cached_proofs.values()))
    for places in ("lamp", "shed"), ("red", "lamp"):
        start = INITIAL.scene.state([("at", (INDEX["robot"], INDEX[places[0]]))])
        elsewhere = [literal(f"at robot {place}") for place in places]
        assert rules.make_mutual_exclusion_prover(start).are_exclusive(elsewhere)
    assert sum(map(len, rules.cached_proofs.values())) == proofs > 0


wet, dry, sponge = Predicate("wet", 1), Predicate("dry", 1), Predicate("sponge", 1, static=True)


@pytest.mark.parametrize("absorbs", [sponge(X), ~is_a(X, "rag")], ids=["fact", "category"])
def test_a_proof_is_reused_only_for_objects_with_the_properties_that_it_used(absorbs: Formula) -> None:
    soak = Operator("SOAK", (X,), (missing_step(absorbs | ~dry(X), "{x} is dry"),), (Add(wet(X)),))
    airing = Operator("AIR", (X,), (), (Add(dry(X)), Delete(wet(X))))
    vocabulary = Vocabulary((wet, dry, sponge))
    kinds = {"cloth": "rag", "towel": "rag", "foam": "sponge"}
    scene = Scene(vocabulary, [WorldObject(name, kind) for name, kind in kinds.items()])
    rules = MutualExclusionRules(Domain("wash", vocabulary, (soak, airing)))
    prover = rules.make_mutual_exclusion_prover(scene.state([("sponge", (scene.index["foam"],))]))
    excluded = {
        name: prover.are_exclusive([GroundAtom(each, (scene.index[name],), True) for each in ("wet", "dry")])
        for name in ("cloth", "foam", "towel", "foam")
    }
    assert excluded == {"cloth": True, "foam": False, "towel": True}
    assert [*map(len, rules.cached_proofs.values())] == [2]


def test_a_deletion_by_another_alternative_or_for_one_object_only_is_no_proof() -> None:
    vocabulary = Vocabulary((wet, dry, sponge))
    scene = Scene(vocabulary, {"cloth": "rag", "towel": "rag"})
    apart = (
        OperatorAlternative(dry(X), (), (Add(wet(X)),)),
        OperatorAlternative(sponge(X), (), (Delete(dry(X)),)),
    )
    each, first = ForEach(X, dry(X), (Add(wet(X)),)), Let(X, dry(X), (Delete(dry(X)),))
    start = scene.state([("dry", ("cloth",)), ("dry", ("towel",))])
    both = [GroundAtom(name, (1,), True) for name in ("wet", "dry")]
    for operator in (
        Operator("WET", (X,), (), (), alternatives=apart),
        Operator("WET_ALL", (), (), (each, first)),
    ):
        domain = Domain("wash", vocabulary, (operator,))
        after = domain.apply(start, Action(operator.name, (1,) * operator.arity))
        assert after.has("wet", 1)
        assert after.has("dry", 1)
        assert not MutualExclusionRules(domain).make_mutual_exclusion_prover(start).are_exclusive(both)


def reachable(domain: Domain) -> set[State]:
    """Return all reachable states of the toy world."""
    actions = [Action(o.name, (i,)) for o in domain.operators for i in INDEX.values()]
    found, pending = {INITIAL}, [INITIAL]
    while pending:
        state = pending.pop()
        after = {
            each for a in actions if isinstance(each := attempt_action(domain, History(state), a), State)
        }
        pending += after - found
        found |= after
    return found


def test_no_reachable_state_meets_excluded_literals() -> None:
    exclusion = MutualExclusionRules(toy.DOMAIN).make_mutual_exclusion_prover(INITIAL)
    states = reachable(toy.DOMAIN)
    facts = sorted({fact for state in states for fact in state.facts()})
    literals = [GroundAtom(*fact, truth) for fact in facts for truth in (True, False)]
    excluded = [pair for pair in combinations(literals, 2) if exclusion.are_exclusive(pair)]
    for state in states:
        for pair in excluded:
            assert not all(state.has(p, *arguments) is truth for p, arguments, truth in pair)
    together = {pair for state in states for pair in combinations(sorted(state.facts()), 2)}
    apart = len([*combinations(facts, 2)]) - len(together)
    shown = sum(one.truth and other.truth for one, other in excluded)
    assert (apart, shown) == (apart, apart)
