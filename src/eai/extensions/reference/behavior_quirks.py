"""The BEHAVIOR domain of eai-eval 1.0.5: defects (quirks) of its simulator, one function for each.

Each function replaces checks or effects of the declared domain and names the place in eai-eval. Together
they turn the declared domain into the domain of `eai-1.0.5`. The engine knows nothing of them. An action
that aborts in eai-eval fails here with the kind of fault `UNCATEGORISED`.

The library bddl makes options from a goal: sets of ground conditions. The goal holds if all conditions of one
option hold. For goals, an object is only inside its direct container (``evolving_graph.py`` get_state_dict).

bddl tries only some of all options, because it has two limits (``bddl/utils.py``,
``bddl/condition_evaluation.py``):

* A quantifier combines the options of its instances. A combination is a vector of option indices. bddl tries
  only the first 20 vectors in order of their sum. Vectors that point to no option count, too.
* If a goal pairs objects of two categories, bddl keeps the order of one category and tries the first 10
  orders of the other category, because a generator is empty after the first pass.

So options are missing, and a plan that meets only a missing option fails.
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
from eai.benchmarks.behavior.domain import make_domain_with_checks_in_reference_order
from eai.benchmarks.behavior.predicates import X, Y
from eai.logic.choice import DnfTerm, ObjectsByCategory, resolve_term
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
"""Kinds of error in the order of their rank in eai-eval's subgoal decomposition.

If an action has several errors, the first kind in this order counts. See ``checkers.py``,
``handle_compound_errors``.
"""


@cache
def make_domain_with_all_quirks() -> Domain:
    """Return the BEHAVIOR domain with the order of checks and all quirks (defects) of eai-eval."""
    return reduce(lambda domain, quirk: quirk(domain), QUIRKS, make_domain_with_checks_in_reference_order())


@cache
def make_subgoal_domain_with_all_quirks() -> Domain:
    """Return the domain in which eai-eval (the paper's package) executes subgoals, with all of its defects.

    If an action has several errors, the first kind in `SUBGOAL_PRECEDENCE` counts.
    """
    return replace(make_domain_with_all_quirks(), precedence=SUBGOAL_PRECEDENCE)


def find_state_left_by_aborted_action(state: State, action: Action) -> State:
    """Return the state in which eai-eval (the paper's package) aborts an action.

    Before it aborts, only one kind of action changes the state: moving the contents of a container into or
    onto an object. See `make_transfer_of_contents_fail`.
    """
    halves = _make_domain_that_transfers_one_object()
    return halves.apply(state, action) if action.operator in halves.compiled_operators else state


@cache
def _make_domain_that_transfers_one_object() -> Domain:
    return replace(
        make_domain_with_checks_in_reference_order(),
        operators=tuple(make_operators_that_transfer_one_object()),
    )


def _apply_to_all_operators(change: Callable[[Operator], Operator]) -> Callable[[Domain], Domain]:
    """Turn a function that changes an operator into a function that changes all operators of a domain."""

    @wraps(change)
    def apply_quirk_to_all_operators(domain: Domain) -> Domain:
        return domain.replace_operators(*map(change, domain.operators))

    return apply_quirk_to_all_operators


@_apply_to_all_operators
def report_grasp_from_other_hand_as_additional_step(operator: Operator) -> Operator:
    """Make a grasp of an object in the other hand an additional step, not a missing step.

    See ``evolving_graph.py``, ``grasp``.
    """
    strict = [o.require_not_in_other_hand(hand) for hand in o.HANDS]

    def relabel_failure_as_additional_step(check: Check) -> Check:
        return replace(check, fault=FaultKind.ADDITIONAL_STEP) if check in strict else check

    return replace(operator, checks=tuple(map(relabel_failure_as_additional_step, operator.checks)))


def add_failing_actions_navigate_to_and_burn(domain: Domain) -> Domain:
    """Add the actions NAVIGATE_TO and BURN, which always fail.

    The package eai-eval accepts them in plans, but aborts when it executes them. See
    ``eval_evolving_graph_env.py``, ``EvalGraphEnv``.
    """
    undefined = Check(FALSE, FaultKind.UNCATEGORISED, "the reference cannot execute this action")
    return domain.replace_operators(
        *(Operator(name, (X,), (undefined,), ()) for name in ("NAVIGATE_TO", "BURN"))
    )


@_apply_to_all_operators
def leave_released_objects_in_mid_air(operator: Operator) -> Operator:
    """Leave a released object in the air, on no support (``evolving_graph.py``, ``release``)."""
    if not operator.name.endswith("RELEASE"):
        return operator
    return replace(operator, effects=tuple(e for e in operator.effects if isinstance(e, Delete)))


@_apply_to_all_operators
def make_placing_inside_floor_fail(operator: Operator) -> Operator:
    """Make placing an object inside a floor fail with an uncategorised error, because eai-eval aborts there.

    The check for a floor is removed from all other actions, which transfer contents into an object. See
    ``evolving_graph.py``, ``place_inside``.
    """
    if o.NO_INSIDE not in operator.checks:
        return operator
    aborts = replace(o.NO_INSIDE, fault=FaultKind.UNCATEGORISED, history_conditions=(FALSE,))
    kept = tuple(check for check in operator.checks if check != o.NO_INSIDE)
    return replace(operator, checks=(*kept, aborts) if "PLACE" in operator.name else kept)


@_apply_to_all_operators
def make_transfer_of_contents_fail(operator: Operator) -> Operator:
    """Make the transfer of a container's contents fail, because eai-eval aborts there.

    For an empty container, the action succeeds and does nothing. See ``evolving_graph.py``, ``pour_inside``
    and ``pour_onto``.
    """
    hand = next((hand for hand in o.HANDS if operator.name.startswith(f"{hand.name}_TRANSFER")), None)
    if hand is None:
        return operator
    contents = Exists(o.H, hand.holds(o.H) & Exists(o.C, p.carries(o.H, o.C)))
    aborts = Check(~contents, FaultKind.UNCATEGORISED, "the reference cannot move contents", (FALSE,))
    return replace(operator, checks=(*operator.checks, aborts), effects=())


def make_operators_that_transfer_one_object() -> Iterator[Operator]:
    """Yield operators that move only the first object out of a held container, because eai-eval aborts then.

    They compute the state in which eai-eval leaves the world (`find_state_left_by_aborted_action`).
    """
    for hand, (name, place) in product(o.HANDS, (("INSIDE", p.lies_in), ("ONTOP", p.lies_on))):
        first = Exists(o.H, hand.holds(o.H) & p.carries(o.H, o.C))
        moved = Let(o.C, first & ~p.floor(X), (*o.make_effects_of_leaving_support(o.C), Add(place(o.C, X))))
        lost = Let(o.C, first & p.floor(X), o.make_effects_of_leaving_support(o.C))
        yield Operator(f"{hand.name}_TRANSFER_CONTENTS_{name}", (X,), (), (moved, lost))


@_apply_to_all_operators
def allow_handling_halves_of_unsliced_object(operator: Operator) -> Operator:
    """Let the robot handle the parts of an object before the object is sliced (``interactivity_precond``)."""
    unwanted = (o.forbid_half_of_unsliced_object(X), o.forbid_half_of_unsliced_object(Y))

    def remove_checks_that_object_is_sliced(checks: tuple[Check, ...]) -> tuple[Check, ...]:
        return tuple(check for check in checks if check not in unwanted)

    tries = tuple(
        replace(attempt, checks=remove_checks_that_object_is_sliced(attempt.checks))
        for attempt in operator.alternatives
    )
    return replace(operator, checks=remove_checks_that_object_is_sliced(operator.checks), alternatives=tries)


@_apply_to_all_operators
def never_report_placing_as_wrong_order(operator: Operator) -> Operator:
    """Report failures to place, transfer or clean an object by another kind of error than wrong order.

    See ``evolving_graph.py``, ``check_precondition``.
    """
    if not any(word in operator.name for word in ("PLACE", "TRANSFER", "CLEAN")):
        return operator
    return replace(
        operator, checks=tuple(replace(check, history_conditions=(FALSE,)) for check in operator.checks)
    )


@_apply_to_all_operators
def keep_only_latest_of_onfloor_under_nextto(operator: Operator) -> Operator:
    """Keep only the latest of the labels onfloor, under and nextto of a pair of objects (``build_graph``)."""
    return replace(operator, effects=_let_new_relations_replace_old(operator.effects))


def _let_new_relation_replace_old(effect: Effect) -> tuple[Effect, ...]:
    """Return effects that keep one label (onfloor, under or nextto) for each ordered pair of objects.

    A new label deletes older labels.
    """
    match effect:
        case Add(atom):
            labels = [label.name for label in p.LOOSE_RELATIONS]
            others = labels if atom.predicate in labels else []
            deletions = (Delete(replace(atom, predicate=name)) for name in others if name != atom.predicate)
            return (*deletions, effect)
        case Delete():
            return (effect,)
        case When(condition, effects, otherwise):
            return (
                When(
                    condition,
                    _let_new_relations_replace_old(effects),
                    _let_new_relations_replace_old(otherwise),
                ),
            )
        case ForEach() | Let():
            return (replace(effect, effects=_let_new_relations_replace_old(effect.effects)),)
        case _:
            assert_never(effect)


def _let_new_relations_replace_old(effects: tuple[Effect, ...]) -> tuple[Effect, ...]:
    return tuple(x for effect in effects for x in _let_new_relation_replace_old(effect))


@_apply_to_all_operators
def allow_freezing_without_fridge(operator: Operator) -> Operator:
    """Let an object be frozen without a fridge (``evolving_graph.py``, ``freeze_unfreeze``)."""
    return replace(operator, checks=operator.checks[:-1]) if operator.name == "FREEZE" else operator


QUIRKS: tuple[Callable[[Domain], Domain], ...] = (
    report_grasp_from_other_hand_as_additional_step,
    add_failing_actions_navigate_to_and_burn,
    leave_released_objects_in_mid_air,
    make_placing_inside_floor_fail,
    make_transfer_of_contents_fail,
    allow_handling_halves_of_unsliced_object,
    never_report_placing_as_wrong_order,
    keep_only_latest_of_onfloor_under_nextto,
    allow_freezing_without_fridge,
)
"""All quirks (functions that give the domain a defect of eai-eval), in the order of their application."""


MAX_VECTORS = 20
MAX_PERMUTATIONS = 10

_NamesOfVariables: TypeAlias = Mapping[str, str]


def list_dnf_terms_that_eai_eval_tries(formula: f.Formula, objects: ObjectsByCategory) -> list[DnfTerm]:
    """Return the options of a closed BDDL condition, in eai-eval's order, as far as eai-eval tries them.

    An option is a list of ground conditions that together make the condition true.

    Raises:
        InputError: a variable is not bound, or BDDL has no such formula.
    """
    return _DnfConverterWithEaiEvalLimits(objects).list_dnf_terms(formula, {})


class _DnfConverterWithEaiEvalLimits:
    """Converts conditions to disjunctive normal form, with only those terms that eai-eval tries."""

    def __init__(self, objects: ObjectsByCategory) -> None:
        self._objects = objects

    def list_dnf_terms(self, formula: f.Formula, binding: _NamesOfVariables) -> list[DnfTerm]:
        match formula:
            case f.Atom(predicate, arguments):
                return [(f.Atom(predicate, tuple(resolve_term(term, binding) for term in arguments)),)]
            case f.And(operands):
                return _conjoin_each_combination(
                    product(*[self.list_dnf_terms(operand, binding) for operand in operands])
                )
            case f.Or(operands):
                return [option for operand in operands for option in self.list_dnf_terms(operand, binding)]
            case f.Not(operand):
                return _negate_dnf_terms(self.list_dnf_terms(operand, binding))
            case f.Implies(premise, conclusion):
                return _negate_dnf_terms(self.list_dnf_terms(premise, binding)) + self.list_dnf_terms(
                    conclusion, binding
                )
            case f.ForAll(variable, body):
                return _conjoin_each_combination(
                    _generate_combinations_up_to_limit(
                        self._list_dnf_terms_for_each_bound_object(variable, body, binding)
                    )
                )
            case f.Exists(variable, body):
                return list(
                    chain.from_iterable(self._list_dnf_terms_for_each_bound_object(variable, body, binding))
                )
            case f.Exactly(count, variable, body):
                vectors = _generate_combinations_up_to_limit(
                    self._list_dnf_terms_for_each_bound_object(variable, body, binding)
                )
                chosen = (combinations(vector, count) for vector in vectors if count <= len(vector))
                return _conjoin_each_combination(chain.from_iterable(chosen))
            case f.ForPairs():
                return self._list_dnf_terms_of_forpairs_formula(formula, binding)
            case _:
                raise InputError(f"BDDL has no formula of type {type(formula).__name__}; rewrite the goal")

    def _list_dnf_terms_for_each_bound_object(
        self, variable: f.Variable, body: f.Formula, binding: _NamesOfVariables
    ) -> list[list[DnfTerm]]:
        values = self._objects(variable.category)
        return [self.list_dnf_terms(body, {**binding, variable.name: value}) for value in values]

    def _list_dnf_terms_of_forpairs_formula(
        self, formula: f.ForPairs, binding: _NamesOfVariables
    ) -> list[DnfTerm]:
        first, second, body = formula.first, formula.second, formula.body
        rows, columns = self._objects(first.category), self._objects(second.category)
        cells = [
            [self.list_dnf_terms(body, {**binding, first.name: x, second.name: y}) for y in columns if x != y]
            for x in rows
        ]
        height, width = len(cells), len(cells[0]) if cells else 0
        small, large = sorted((height, width))
        count = small if formula.count is None else formula.count
        if count > small:
            return []
        fixed = tuple(range(count))
        if formula.count is not None or height < width:
            orders = [(fixed, order) for order in _generate_permutations_up_to_limit(width, count)]
        else:
            orders = [(order, fixed) for order in _generate_permutations_up_to_limit(large, count)]
        return [
            option
            for down, across in orders
            for option in _conjoin_each_combination(
                _generate_combinations_up_to_limit([cells[i][j] for i, j in zip(down, across, strict=True)])
            )
        ]


def _conjoin_each_combination(combinations: Iterable[Sequence[DnfTerm]]) -> list[DnfTerm]:
    return [tuple(chain.from_iterable(vector)) for vector in combinations]


def _negate_dnf_terms(options: Sequence[DnfTerm]) -> list[DnfTerm]:
    """Return the negation of a disjunction of terms (conjunctions), again as a list of terms.

    Each result negates one condition of every given term.
    """
    return [
        tuple(choice)
        for choice in product(*[[f.Not(condition) for condition in option] for option in options])
    ]


def _generate_permutations_up_to_limit(size: int, length: int) -> Iterator[tuple[int, ...]]:
    return islice(permutations(range(size), length), MAX_PERMUTATIONS)


def _generate_combinations_up_to_limit(
    sequences: Sequence[Sequence[DnfTerm]],
) -> Iterator[tuple[DnfTerm, ...]]:
    """Yield combinations of one element of each sequence, for the first `MAX_VECTORS` index vectors.

    An index vector has an index into each sequence. Vectors are ordered by their sum, then lexicographically.
    The vector of all last indexes comes at the end if the limit allows it. Vectors that point outside a
    sequence count towards the limit.
    """
    highest = [len(sequence) - 1 for sequence in sequences]
    if any(last < 0 for last in highest):
        return
    by_sum = chain.from_iterable(
        _list_index_vectors_of_sum(total, len(sequences)) for total in range(sum(highest))
    )
    tried = list(islice(by_sum, MAX_VECTORS))
    if len(tried) < MAX_VECTORS:
        tried.append(tuple(highest))
    for vector in tried:
        if all(index <= last for index, last in zip(vector, highest, strict=True)):
            yield tuple(sequence[index] for sequence, index in zip(sequences, vector, strict=True))


def _list_index_vectors_of_sum(total: int, length: int) -> Iterator[tuple[int, ...]]:
    if length == 1:
        yield (total,)
        return
    for head in range(total + 1):
        for tail in _list_index_vectors_of_sum(total - head, length - 1):
            yield (head, *tail)


def make_behavior_goal_test(task: Task) -> GoalTest:
    """Return eai-eval's test of a task's goals.

    An alternative is a term of the goal's disjunctive normal form. eai-eval tests only the first alternatives
    (`_reduce_to_first_dnf_terms`), and the goal counts as reached if one of them is true. Each goal keeps the
    kind that the task declares: states, relations or actions.
    """
    return GoalTest(task, [_reduce_to_first_dnf_terms(goal.formula, task.scene) for goal in task.goals])


def _reduce_to_first_dnf_terms(formula: f.Formula, scene: Scene) -> f.Formula:
    """Return the formula that eai-eval (the paper's package) tests for a goal.

    It is true if at least one of the first options of the goal is true. An option is a list of ground
    conditions that together make the goal true. The package bddl tries only the first options.
    """
    return map_leaves(
        f.Or(tuple(map(f.And, list_dnf_terms_that_eai_eval_tries(formula, scene.names_of_category)))),
        _replace_inside_by_directly_inside,
    )


def _replace_inside_by_directly_inside(leaf: f.Leaf) -> f.Formula:
    if isinstance(leaf, f.Atom) and leaf.predicate == "inside":
        return replace(leaf, predicate=p.directly_inside.name)
    return leaf
