"""The conformance suite for domains and their simulators: what the engine, the prompts and reports rely on.

Run it over a domain of your own with a few of its initial states::

    from eai.world import check
    for defect in check(domain, states):
        print(defect)

It takes random walks from the states and watches the laws of execution. One of them is the paper's: a step is
additional only if its intended effect is already there (appendix, "Action Sequencing: Trajectory Error
Detection"). The intended effect is what the operator does in any case and can be seen: its own additions and
deletions. What it does besides, for each object that happens to be there or only under a condition, is no
reason to do it again: who sits on a sofa already does not sit down because he has turned away from what it
faces.
"""

from __future__ import annotations

import random
from collections.abc import Collection, Iterable, Iterator, Sequence
from collections.abc import Set as AbstractSet

from eai.logic.formula import And, Atom, Formula, Not, Or
from eai.logic.ltl_printer import print_ltl
from eai.world.action import Action, Fault
from eai.world.domain import Domain
from eai.world.effect import ANYTHING, Add, Delete, Effect, When
from eai.world.execution import argument_indices, attempt, describe
from eai.world.fault import FaultKind
from eai.world.history import History
from eai.world.operator import Operator
from eai.world.state import State, compare_states
from eai.world.vocabulary import Vocabulary


def check(
    domain: Domain,
    states: Iterable[State],
    *,
    seed: int = 0,
    steps: int = 200,
    measured: Collection[str] | None = None,
) -> tuple[str, ...]:
    """All defects of a domain and its simulator, each in words behind its operator; none if they conform.

    Args:
        domain: the domain.
        states: initial states to walk from.
        seed: of the random walks.
        steps: how many actions to try from each state.
        measured: the stored predicates of which the simulator decides what holds; all others are to follow
            the declaration. None if it decides all.
    """
    rng = random.Random(seed)  # noqa: S311 - a walk, not a secret
    names = {each.name for each in domain.vocabulary.predicates}
    follow = frozenset() if measured is None else names.difference(measured)
    walks = (defect for state in states for defect in _walk(domain, state, rng, steps, follow))
    return tuple(dict.fromkeys(walks))


def _walk(
    domain: Domain, initial: State, rng: random.Random, steps: int, follow: AbstractSet[str]
) -> Iterator[str]:
    """Try random actions, keep those that are possible, and compare what happens with what must."""
    if initial.scene.vocabulary.predicates != domain.vocabulary.predicates:
        yield f"{domain.name}: a state belongs to another vocabulary"
        return
    simulator, twin = domain.begin(initial), domain.begin(initial)
    if lost := set(initial.facts()).difference(simulator.state.facts()):
        yield f"{domain.name}: the simulator begins without {min(lost).predicate} of the initial state"
    past = History(simulator.state)
    for _ in range(steps):
        action = _random_action(domain.operators, initial, rng)
        before = _fingerprint(past.state)
        outcome, again = attempt(domain, past, action), attempt(domain, past, action)
        if outcome != again:
            yield f"{action.operator}: the same action in the same state has two outcomes"
        if _fingerprint(past.state) != before:
            yield f"{action.operator}: trying the action changed the state in which it was tried"
        if isinstance(outcome, Fault):
            yield from _fault(domain, past, action, outcome)
            continue
        after = simulator.act(action, outcome)
        if twin.act(action, outcome) != after:
            yield f"{action.operator}: the simulator makes two outcomes of equal worlds and actions"
        if _fingerprint(simulator.state) != (before if isinstance(after, Fault) else _fingerprint(after)):
            yield f"{action.operator}: the simulator's state is not that which its outcome tells"
        if isinstance(after, State):
            yield from _simulated(domain, past.state, action, outcome, after, follow)
            past = past.extended(after)


def _simulated(
    domain: Domain, before: State, action: Action, declared: State, after: State, follow: AbstractSet[str]
) -> Iterator[str]:
    """The laws that a simulator has broken in carrying an action out."""
    for effect in _brought_about(domain, before, action, declared):
        if not domain.holds(effect, after, argument_indices(action, domain)):
            yield f"{action.operator}: carried out without bringing about {print_ltl(effect)}"
    for name in sorted(compare_states(declared, after).predicates & follow):
        yield f"{action.operator}: the simulator decides {name}, which is to follow the declaration"


def _brought_about(domain: Domain, before: State, action: Action, after: State) -> Iterator[Formula]:
    """The intended effects of an action that hold after it and did not before."""
    arguments = argument_indices(action, domain)
    for effect in _intended(domain.compiled[action.operator].operator.effects, domain.vocabulary):
        if domain.holds(effect, after, arguments) and not domain.holds(effect, before, arguments):
            yield effect


def _fingerprint(state: State) -> int:
    """A hash of what the state holds now, past any that it has stored."""
    return hash(State(state.scene, state.unary, state.binary, state.tuples))


def _fault(domain: Domain, past: History, action: Action, fault: Fault) -> Iterator[str]:
    if not describe(fault, domain, action, past.state.scene):
        yield f"{action.operator}: a failure has no reason"
    if (fault.kind is FaultKind.WRONG_ORDER) != (fault.earlier is not None):
        yield f"{action.operator}: a wrong order comes without the earlier state, or the other way round"
    if fault.earlier is not None and not 0 <= fault.earlier <= past.number:
        yield f"{action.operator}: the history rule points outside the trajectory"
    if fault.kind is FaultKind.ADDITIONAL_STEP:
        yield from _needed(domain, past.state, action)


def _needed(domain: Domain, before: State, action: Action) -> Iterator[str]:
    """The changes that an action which counts as an additional step would still make."""
    after = domain.apply(before, action)
    for effect in _brought_about(domain, before, action, after):
        yield f"{action.operator}: an additional step that would bring about {print_ltl(effect)}"


def _intended(effects: Iterable[Effect], vocabulary: Vocabulary) -> Iterator[Formula]:
    """The changes that effects make in any case and can be seen: of two alternatives, one or the other."""

    def can_be_seen(atom: Atom) -> bool:
        predicate = vocabulary.find_stored(atom.predicate)
        return predicate is not None and predicate.visible

    for effect in effects:
        match effect:
            case Add(atom) if can_be_seen(atom):
                yield atom
            case Delete(atom) if can_be_seen(atom) and ANYTHING not in atom.arguments:
                yield Not(atom)
            case When(_, then, otherwise):
                yield Or(tuple(And(tuple(_intended(each, vocabulary))) for each in (then, otherwise)))
            case _:
                pass


def _random_action(operators: Sequence[Operator], state: State, rng: random.Random) -> Action:
    operator = rng.choice(operators)
    count = len(state.scene.objects)
    return Action(operator.name, tuple(rng.randrange(count) for _ in operator.parameters))
