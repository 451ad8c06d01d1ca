"""Tests whether a domain and its simulator keep the rules of execution that this package assumes.

Run them on a domain of your own with a few of its initial states::

    from eai.world import check_domain
    for defect in check_domain(domain, states):
        print(defect)

The tests execute random actions from the states. One rule comes from the paper "Embodied Agent Interface": a
step is additional only if its intended effect already holds (appendix, "Action Sequencing: Trajectory Error
Detection"). The intended effect of an operator is its visible, unconditional additions and deletions. Effects
on every object that meets a condition, and conditional effects, are not intended effects. For example, an
agent that already sits on a sofa need not sit down again because it no longer faces an object.
"""

from __future__ import annotations

import random
from collections.abc import Collection, Iterable, Iterator, Sequence
from collections.abc import Set as AbstractSet
from typing import TypeAlias

from eai.logic.formula import And, Atom, Formula, Not, Or
from eai.logic.ltl_printer import format_ltl
from eai.world.action import Action, Fault
from eai.world.domain import Domain
from eai.world.effect import ANYTHING, Add, Delete, Effect, When
from eai.world.execution import attempt_action, describe_fault, map_parameters_to_object_indices
from eai.world.fault import FaultKind
from eai.world.history import History
from eai.world.operator import Operator
from eai.world.state import State, compare_states
from eai.world.vocabulary import Vocabulary

_Defect: TypeAlias = str
"""Text that says which rule an operator or the domain breaks when actions are executed."""


def check_domain(
    domain: Domain,
    states: Iterable[State],
    *,
    seed: int = 0,
    steps: int = 200,
    simulated_predicates: Collection[str] | None = None,
) -> tuple[str, ...]:
    """Return all defects of a domain and its simulator, each as a text that names the operator or the domain.

    Args:
        domain: the domain.
        states: the states in which the random walks begin.
        seed: seed of the random walks.
        steps: number of actions tried from each state.
        simulated_predicates: the stored predicates whose facts after an action are decided by the simulator;
            the facts of all other predicates must change as the domain declares. None if the simulator
            decides all facts.
    """
    rng = random.Random(seed)  # noqa: S311 - a walk, not a secret
    names = {predicate.name for predicate in domain.vocabulary.predicates}
    follow = frozenset() if simulated_predicates is None else names.difference(simulated_predicates)
    walks = (
        defect
        for state in states
        for defect in _find_defects_on_random_walk(domain, state, rng, steps, follow)
    )
    return tuple(dict.fromkeys(walks))


def _find_defects_on_random_walk(
    domain: Domain, initial: State, rng: random.Random, steps: int, declared_predicates: AbstractSet[str]
) -> Iterator[_Defect]:
    """Try random actions, and yield a text for each rule of execution that the domain breaks."""
    if initial.scene.vocabulary.predicates != domain.vocabulary.predicates:
        yield f"{domain.name}: a state belongs to another vocabulary"
        return
    simulator, second_simulator = domain.begin(initial), domain.begin(initial)
    if missing := set(initial.facts()).difference(simulator.state.facts()):
        yield f"{domain.name}: the simulator begins without {min(missing).predicate} of the initial state"
    history = History(simulator.state)
    operators = [o for o in domain.operators if initial.scene.objects or not o.parameters]
    for _ in range(steps if operators else 0):
        action = _draw_random_action(operators, initial, rng)
        before = _compute_facts_hash(history.state)
        outcome = attempt_action(domain, history, action)
        second_outcome = attempt_action(domain, history, action)
        if outcome != second_outcome:
            yield f"{action.operator}: the same action in the same state has two outcomes"
        if _compute_facts_hash(history.state) != before:
            yield f"{action.operator}: trying the action changed the state in which it was tried"
        if isinstance(outcome, Fault):
            yield from _find_defects_in_fault_diagnosis(domain, history, action, outcome)
            continue
        after = simulator.act(action, outcome)
        if second_simulator.act(action, outcome) != after:
            yield f"{action.operator}: two equal simulators give different outcomes of the action"
        if _compute_facts_hash(simulator.state) != (
            before if isinstance(after, Fault) else _compute_facts_hash(after)
        ):
            yield f"{action.operator}: the simulator's state differs from the outcome that it returned"
        if isinstance(after, State):
            yield from _find_defects_of_simulator(
                domain, history.state, action, outcome, after, declared_predicates
            )
            history = history.extend(after)


def _find_defects_of_simulator(
    domain: Domain,
    before: State,
    action: Action,
    state_after_declared_effects: State,
    simulated_state: State,
    declared_predicates: AbstractSet[str],
) -> Iterator[_Defect]:
    for effect in _find_effect_formulas_that_became_true(
        domain, before, action, state_after_declared_effects
    ):
        if not domain.holds(effect, simulated_state, map_parameters_to_object_indices(action, domain)):
            yield f"{action.operator}: executed without its intended effect {format_ltl(effect)}"
    for name in sorted(
        compare_states(state_after_declared_effects, simulated_state).predicates & declared_predicates
    ):
        yield f"{action.operator}: the simulator changes {name}, which must follow the declaration"


def _find_effect_formulas_that_became_true(
    domain: Domain, before: State, action: Action, after: State
) -> Iterator[Formula]:
    """Yield an action's intended effects (changes that it always makes) that hold only after the action."""
    arguments = map_parameters_to_object_indices(action, domain)
    for effect in _find_visible_effects_as_formulas(
        domain.compiled_operators[action.operator].operator.effects, domain.vocabulary
    ):
        if domain.holds(effect, after, arguments) and not domain.holds(effect, before, arguments):
            yield effect


def _compute_facts_hash(state: State) -> int:
    """Compute the hash of a state's facts anew. A different hash shows that the state changed in place."""
    return hash(State(state.scene, state.unary, state.binary, state.tuples))


def _find_defects_in_fault_diagnosis(
    domain: Domain, history: History, action: Action, fault: Fault
) -> Iterator[_Defect]:
    if not describe_fault(fault, domain, action, history.state.scene):
        yield f"{action.operator}: a fault has no description"
    if (fault.kind is FaultKind.WRONG_ORDER) != (fault.earlier is not None):
        yield f"{action.operator}: only a fault of kind wrong_order must have an earlier state"
    if fault.earlier is not None and not 0 <= fault.earlier <= history.number:
        yield f"{action.operator}: the history rule returned a state outside the trajectory"
    if fault.kind is FaultKind.ADDITIONAL_STEP:
        yield from _find_defects_in_additional_step_diagnosis(domain, history.state, action)


def _find_defects_in_additional_step_diagnosis(
    domain: Domain, before: State, action: Action
) -> Iterator[_Defect]:
    after = domain.apply(before, action)
    for effect in _find_effect_formulas_that_became_true(domain, before, action, after):
        yield f"{action.operator}: an additional step that would bring about {format_ltl(effect)}"


def _find_visible_effects_as_formulas(effects: Iterable[Effect], vocabulary: Vocabulary) -> Iterator[Formula]:
    """Yield formulas that hold after an action: the changes of visible predicates that it always makes.

    The formula of a conditional effect (`When`) is a disjunction: either its ``effects`` or its ``otherwise``
    took place.
    """

    def has_visible_predicate(atom: Atom) -> bool:
        predicate = vocabulary.find_stored_predicate(atom.predicate)
        return predicate is not None and predicate.visible

    for effect in effects:
        match effect:
            case Add(atom) if has_visible_predicate(atom):
                yield atom
            case Delete(atom) if has_visible_predicate(atom) and ANYTHING not in atom.arguments:
                yield Not(atom)
            case When(_, then, otherwise):
                yield Or(
                    tuple(
                        And(tuple(_find_visible_effects_as_formulas(branch, vocabulary)))
                        for branch in (then, otherwise)
                    )
                )
            case _:
                pass


def _draw_random_action(operators: Sequence[Operator], state: State, rng: random.Random) -> Action:
    operator = rng.choice(operators)
    count = len(state.scene.objects)
    return Action(operator.name, tuple(rng.randrange(count) for _ in operator.parameters))
