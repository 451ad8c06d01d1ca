"""The BEHAVIOR domain as eai-eval 1.0.5 has it: where its simulator deviates from what it is meant to do.

Each quirk is a function that replaces checks or effects of the declaration, and says where the reference has
it; together they turn the declared domain into that of `eai-1.0.5`. The engine knows nothing of them.

A goal holds if one of the ground options does that bddl keeps, where a thing is inside its direct container
only (``evolving_graph.py`` get_state_dict).

bddl looks at some of all options, by two caps deep inside (``bddl/utils.py``,
``bddl/condition_evaluation.py``): where quantifiers multiply options, only the first 20 index vectors in
order of their sum are tried, counting also those that do not exist; a pairing keeps one side in its order
(the generator of the other side's orders is used up after that) and tries the first 10 orders of the other.
So options are missing, and plans that reach one of them are judged to fail.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache, reduce, wraps
from itertools import chain, combinations, islice, permutations, product
from typing import TypeAlias

from typing_extensions import assert_never

import eai.logic.formula as f
from eai.base.errors import InputError
from eai.benchmarks.behavior import operators as o
from eai.benchmarks.behavior import predicates as p
from eai.benchmarks.behavior.domain import domain_in_reference_order
from eai.benchmarks.behavior.predicates import X, Y
from eai.logic.choice import ObjectsByCategory, Option, value_of
from eai.logic.formula import FALSE, Exists
from eai.logic.rewriting import map_leaves
from eai.tasks.goal_test import GoalTest
from eai.tasks.task import Task
from eai.world.action import Action
from eai.world.domain import Domain
from eai.world.effect import Add, Delete, Effect, ForEach, Let, When
from eai.world.fault import FaultKind
from eai.world.operator import Check, Operator
from eai.world.state import Scene, State

SUBGOAL_PRECEDENCE = (
    FaultKind.UNCATEGORISED,
    FaultKind.ADDITIONAL_STEP,
    FaultKind.WRONG_ORDER,
    FaultKind.MISSING_STEP,
    FaultKind.AFFORDANCE,
)
"""Which kind counts in the reference's subgoal decomposition (``checkers.py`` handle_compound_errors)."""


@cache
def as_in_reference() -> Domain:
    """The reference's order of checks and all of its quirks."""
    return reduce(lambda domain, quirk: quirk(domain), QUIRKS, domain_in_reference_order())


@cache
def as_in_reference_subgoals() -> Domain:
    """The same for subgoal decomposition, where the reference ranks kinds of error differently."""
    return replace(as_in_reference(), precedence=SUBGOAL_PRECEDENCE)


def half_done(state: State, action: Action) -> State:
    """Return the state that the reference leaves when it aborts in an action (quirk `transfer_aborts`)."""
    halves = _half_done()
    return halves.apply(state, action) if action.operator in halves.compiled else state


@cache
def _half_done() -> Domain:
    return replace(domain_in_reference_order(), operators=tuple(half_done_transfers()))


def _of_operators(change: Callable[[Operator], Operator]) -> Callable[[Domain], Domain]:
    """The change of a domain that changes each single operator."""

    @wraps(change)
    def apply(domain: Domain) -> Domain:
        return domain.replace_operators(*map(change, domain.operators))

    return apply


@_of_operators
def other_hand_is_additional(operator: Operator) -> Operator:
    """Grasping what the other hand holds is an additional step, not a missing one.

    See ``evolving_graph.py``, ``grasp``.
    """
    strict = [o.require_not_in_other_hand(hand) for hand in o.HANDS]

    def check(each: Check) -> Check:
        return replace(each, fault=FaultKind.ADDITIONAL_STEP) if each in strict else each

    return replace(operator, checks=tuple(map(check, operator.checks)))


def navigation_aborts(domain: Domain) -> Domain:
    """NAVIGATE_TO and BURN are accepted, but executing them is an error of no kind.

    See ``eval_evolving_graph_env.py``, ``EvalGraphEnv``.
    """
    undefined = Check(FALSE, FaultKind.UNCATEGORISED, "the reference cannot execute this action")
    return domain.replace_operators(
        *(Operator(name, (X,), (undefined,), ()) for name in ("NAVIGATE_TO", "BURN"))
    )


@_of_operators
def released_in_mid_air(operator: Operator) -> Operator:
    """A released object stands on nothing (``evolving_graph.py``, ``release``)."""
    if not operator.name.endswith("RELEASE"):
        return operator
    return replace(operator, effects=tuple(e for e in operator.effects if isinstance(e, Delete)))


@_of_operators
def inside_a_floor_aborts(operator: Operator) -> Operator:
    """Placing something inside a floor is an error of no kind (``evolving_graph.py``, ``place_inside``)."""
    if o.NO_INSIDE not in operator.checks:
        return operator
    aborts = replace(o.NO_INSIDE, fault=FaultKind.UNCATEGORISED, history_conditions=(FALSE,))
    kept = tuple(check for check in operator.checks if check != o.NO_INSIDE)
    return replace(operator, checks=(*kept, aborts) if "PLACE" in operator.name else kept)


@_of_operators
def transfer_aborts(operator: Operator) -> Operator:
    """Transferring contents is an error of no kind, except for an empty container, where it does nothing.

    See ``evolving_graph.py``, ``pour_inside`` and ``pour_onto``.
    """
    hand = next((hand for hand in o.HANDS if operator.name.startswith(f"{hand.name}_TRANSFER")), None)
    if hand is None:
        return operator
    contents = Exists(o.H, hand.holds(o.H) & Exists(o.C, p.carries(o.H, o.C)))
    aborts = Check(~contents, FaultKind.UNCATEGORISED, "the reference cannot move contents", (FALSE,))
    return replace(operator, checks=(*operator.checks, aborts), effects=())


def half_done_transfers() -> Iterator[Operator]:
    """The effects of an aborted transfer of contents: the first of them is moved already."""
    for hand, (name, place) in product(o.HANDS, (("INSIDE", p.lies_in), ("ONTOP", p.lies_on))):
        first = Exists(o.H, hand.holds(o.H) & p.carries(o.H, o.C))
        moved = Let(o.C, first & ~p.floor(X), (*o.clear_support(o.C), Add(place(o.C, X))))
        lost = Let(o.C, first & p.floor(X), o.clear_support(o.C))
        yield Operator(f"{hand.name}_TRANSFER_CONTENTS_{name}", (X,), (), (moved, lost))


@_of_operators
def parts_before_slicing(operator: Operator) -> Operator:
    """The parts of an object can be handled before it is sliced (``interactivity_precond``)."""
    unwanted = (o.require_cut_off(X), o.require_cut_off(Y))

    def kept(checks: tuple[Check, ...]) -> tuple[Check, ...]:
        return tuple(check for check in checks if check not in unwanted)

    tries = tuple(replace(each, checks=kept(each.checks)) for each in operator.tries)
    return replace(operator, checks=kept(operator.checks), tries=tries)


@_of_operators
def placing_never_in_wrong_order(operator: Operator) -> Operator:
    """There is no order test for placing, transferring, and cleaning what is not dirty.

    See ``evolving_graph.py``, ``check_precondition``.
    """
    if not any(word in operator.name for word in ("PLACE", "TRANSFER", "CLEAN")):
        return operator
    return replace(
        operator, checks=tuple(replace(check, history_conditions=(FALSE,)) for check in operator.checks)
    )


@_of_operators
def one_label_per_pair(operator: Operator) -> Operator:
    """Of onfloor, under and nextto only the last that was established holds of a pair (``build_graph``)."""
    return replace(operator, effects=_all_overwriting(operator.effects))


def _overwriting(effect: Effect) -> tuple[Effect, ...]:
    """The effect, with which a label replaces all others of the same ordered pair."""
    match effect:
        case Add(atom):
            labels = [label.name for label in p.LOOSE_RELATIONS]
            others = labels if atom.predicate in labels else []
            deletions = (Delete(replace(atom, predicate=name)) for name in others if name != atom.predicate)
            return (*deletions, effect)
        case Delete():
            return (effect,)
        case When(condition, effects, otherwise):
            return (When(condition, _all_overwriting(effects), _all_overwriting(otherwise)),)
        case ForEach() | Let():
            return (replace(effect, effects=_all_overwriting(effect.effects)),)
        case _:
            assert_never(effect)


def _all_overwriting(effects: tuple[Effect, ...]) -> tuple[Effect, ...]:
    return tuple(x for effect in effects for x in _overwriting(effect))


@_of_operators
def freezes_anywhere(operator: Operator) -> Operator:
    """Freezing needs no fridge (``evolving_graph.py``, ``freeze_unfreeze``)."""
    return replace(operator, checks=operator.checks[:-1]) if operator.name == "FREEZE" else operator


QUIRKS: tuple[Callable[[Domain], Domain], ...] = (
    other_hand_is_additional,
    navigation_aborts,
    released_in_mid_air,
    inside_a_floor_aborts,
    transfer_aborts,
    parts_before_slicing,
    placing_never_in_wrong_order,
    one_label_per_pair,
    freezes_anywhere,
)
"""The quirks in the order in which they act."""


MAX_VECTORS = 20
MAX_PERMUTATIONS = 10

_Binding: TypeAlias = Mapping[str, str]


def truncated_options(formula: f.Formula, objects: ObjectsByCategory) -> list[Option]:
    """The options of a closed BDDL condition in the reference's order, with its omissions.

    Raises:
        InputError: a variable is not bound, or the formula is not one of BDDL's.
    """
    return _Truncation(objects).options(formula, {})


class _Truncation:
    def __init__(self, objects: ObjectsByCategory) -> None:
        self._objects = objects

    def options(self, formula: f.Formula, binding: _Binding) -> list[Option]:
        match formula:
            case f.Atom(predicate, arguments):
                return [(f.Atom(predicate, tuple(value_of(term, binding) for term in arguments)),)]
            case f.And(operands):
                return _joined(product(*[self.options(operand, binding) for operand in operands]))
            case f.Or(operands):
                return [option for operand in operands for option in self.options(operand, binding)]
            case f.Not(operand):
                return _negated(self.options(operand, binding))
            case f.Implies(premise, conclusion):
                return _negated(self.options(premise, binding)) + self.options(conclusion, binding)
            case f.ForAll(variable, body):
                return _joined(_first_vectors(self._instances(variable, body, binding)))
            case f.Exists(variable, body):
                return list(chain.from_iterable(self._instances(variable, body, binding)))
            case f.Exactly(count, variable, body):
                vectors = _first_vectors(self._instances(variable, body, binding))
                chosen = (combinations(vector, count) for vector in vectors if count <= len(vector))
                return _joined(chain.from_iterable(chosen))
            case f.ForPairs():
                return self._pairs(formula, binding)
            case _:
                raise InputError(f"BDDL has no {type(formula).__name__}")

    def _instances(self, variable: f.Variable, body: f.Formula, binding: _Binding) -> list[list[Option]]:
        values = self._objects(variable.category)
        return [self.options(body, {**binding, variable.name: value}) for value in values]

    def _pairs(self, formula: f.ForPairs, binding: _Binding) -> list[Option]:
        first, second, body = formula.first, formula.second, formula.body
        rows, columns = self._objects(first.category), self._objects(second.category)
        cells = [
            [self.options(body, {**binding, first.name: x, second.name: y}) for y in columns if x != y]
            for x in rows
        ]
        height, width = len(cells), len(cells[0]) if cells else 0
        small, large = sorted((height, width))
        count = small if formula.count is None else formula.count
        if count > small:
            return []
        fixed = tuple(range(count))
        if formula.count is not None or height < width:
            orders = [(fixed, order) for order in _first_orders(width, count)]
        else:
            orders = [(order, fixed) for order in _first_orders(large, count)]
        return [
            option
            for down, across in orders
            for option in _joined(_first_vectors([cells[i][j] for i, j in zip(down, across, strict=True)]))
        ]


def _joined(vectors: Iterable[Sequence[Option]]) -> list[Option]:
    return [tuple(chain.from_iterable(vector)) for vector in vectors]


def _negated(found: Sequence[Option]) -> list[Option]:
    """One negated condition of each option, in all combinations."""
    return [
        tuple(choice) for choice in product(*[[f.Not(condition) for condition in option] for option in found])
    ]


def _first_orders(size: int, length: int) -> Iterator[tuple[int, ...]]:
    return islice(permutations(range(size), length), MAX_PERMUTATIONS)


def _first_vectors(sequences: Sequence[Sequence[Option]]) -> Iterator[tuple[Option, ...]]:
    """The product of the sequences, as far as the first `MAX_VECTORS` index vectors go.

    Vectors come by their sum, then lexicographically; the last one of all comes last if the cap allows, and
    others of that sum never do. A vector that points outside a sequence uses up one of the cap.
    """
    highest = [len(sequence) - 1 for sequence in sequences]
    if any(last < 0 for last in highest):
        return
    by_sum = chain.from_iterable(_vectors(total, len(sequences)) for total in range(sum(highest)))
    tried = list(islice(by_sum, MAX_VECTORS))
    if len(tried) < MAX_VECTORS:
        tried.append(tuple(highest))
    for vector in tried:
        if all(index <= last for index, last in zip(vector, highest, strict=True)):
            yield tuple(sequence[index] for sequence, index in zip(sequences, vector, strict=True))


def _vectors(total: int, length: int) -> Iterator[tuple[int, ...]]:
    """All vectors of natural numbers with this sum, in lexicographic order."""
    if length == 1:
        yield (total,)
        return
    for head in range(total + 1):
        for tail in _vectors(total - head, length - 1):
            yield (head, *tail)


def behavior_goal_test(task: Task) -> GoalTest:
    """The reference's test of a task's goals; they count by the kinds of their own formulas."""
    return GoalTest(task, [_as_truncated(goal.formula, task.scene) for goal in task.goals])


def _as_truncated(formula: f.Formula, scene: Scene) -> f.Formula:
    """The condition that the reference tests for a goal: all literals of a truncated option hold."""
    return map_leaves(f.Or(tuple(map(f.And, truncated_options(formula, scene.names_of_category)))), _directly)


def _directly(leaf: f.Leaf) -> f.Formula:
    """The leaf where a thing is inside its direct container only."""
    if isinstance(leaf, f.Atom) and leaf.predicate == "inside":
        return replace(leaf, predicate=p.directly_inside.name)
    return leaf
