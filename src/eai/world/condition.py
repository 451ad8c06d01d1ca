"""Compiler of state formulas to functions of a state and a binding of variables.

A formula is compiled once per domain and evaluated millions of times. It becomes one of two kinds of
function. A *truth* function tests the formula under a binding of all free variables. A *filter*
leaves one free variable open: it takes objects (as a bit mask), and selects the objects that make the formula
true as value of this variable. Quantifiers are evaluated by filters, so most quantifiers cost a
few integer operations. If objects must be tried one by one, only objects that the rest of the formula allows
are tried. Connectives loop over the functions of their operands.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Generic, TypeAlias, TypeVar

import eai.logic.formula as f
from eai.base.errors import DomainError
from eai.logic.matching import find_maximum_matching
from eai.logic.traversal import find_free_variables
from eai.world.derived import (
    ComputedPredicate,
    DefinedPredicate,
    LookupPredicate,
    replace_formula_by_faster_function,
)
from eai.world.frame import UNBOUND, ConditionTest, ObjectBySlot, ObjectFilter, SlotAllocator, SlotByVariable
from eai.world.relation import ObjectMask, iterate_bits
from eai.world.state import State
from eai.world.vocabulary import DerivedPredicate, Vocabulary

Scope: TypeAlias = Mapping[str, int]
"""Mapping from the names of variables to the indices of their objects."""


def combine_tests_by_and(parts: Sequence[ConditionTest]) -> ConditionTest:
    """Return a function that tests whether all parts of a formula hold, in the order of the parts."""

    def do_all_tests_hold(state: State, binding: ObjectBySlot) -> bool:
        for part in parts:  # noqa: SIM110 - a loop is three times as fast as all() over a generator
            if not part(state, binding):
                return False
        return True

    return parts[0] if len(parts) == 1 else do_all_tests_hold


def combine_tests_by_or(parts: Sequence[ConditionTest]) -> ConditionTest:
    """Return a function that tests whether any part of a formula holds, in the order of the parts."""

    def does_any_test_hold(state: State, binding: ObjectBySlot) -> bool:
        for part in parts:  # noqa: SIM110 - a loop is three times as fast as any() over a generator
            if part(state, binding):
                return True
        return False

    return parts[0] if len(parts) == 1 else does_any_test_hold


def negate_test(part: ConditionTest) -> ConditionTest:
    """Return a function that tests whether a part of a formula does not hold."""
    return lambda state, binding: not part(state, binding)


def negate_filter(part: ObjectFilter) -> ObjectFilter:
    """Return a function that selects the objects for which a part of a formula does not hold."""
    return lambda state, binding, among: among & ~part(state, binding, among)


def combine_filters_by_and(parts: Sequence[ObjectFilter]) -> ObjectFilter:
    """Return a function that selects the objects that make all parts of a formula true.

    Each part tests only the objects that all earlier parts selected.
    """

    def filter_objects(state: State, binding: ObjectBySlot, among: ObjectMask) -> ObjectMask:
        for part in parts:
            among = part(state, binding, among)
            if not among:
                return 0
        return among

    return parts[0] if len(parts) == 1 else filter_objects


def combine_filters_by_or(parts: Sequence[ObjectFilter]) -> ObjectFilter:
    """Return a function that selects the objects that make any part of a formula true.

    Each part tests only the objects that no earlier part selected.
    """

    def filter_objects(state: State, binding: ObjectBySlot, among: ObjectMask) -> ObjectMask:
        mask = 0
        for part in parts:
            mask |= part(state, binding, among & ~mask)
        return mask

    return parts[0] if len(parts) == 1 else filter_objects


_ValueFinder: TypeAlias = Callable[[State, ObjectBySlot], ObjectMask]
"""Function that returns the bit mask of the values that one variable can have to make a formula true."""


class ConditionCompiler:
    """A compiler of state formulas over one vocabulary into functions of a state and a binding.

    All functions share one frame, which gives each variable a position in the binding.

    Raises:
        DomainError: raised by the methods if a predicate is not declared or is defined by itself, if a
            predicate has a wrong number of arguments, a variable is unbound, or a formula is temporal.
    """

    def __init__(self, vocabulary: Vocabulary, frame: SlotAllocator) -> None:
        self._vocabulary = vocabulary
        self._frame = frame
        self._unfolded: list[str] = []

    def compile_test(
        self, formula: f.Formula, scope: SlotByVariable | None = None, *, wanted: bool = True
    ) -> ConditionTest:
        """Compile a formula to a test that it holds, or (if not ``wanted``) a test that it does not hold."""
        scope = self._frame.scope if scope is None else scope
        match formula:
            case f.Atom():
                return self._compile_atom_truth(formula, scope, wanted)
            case f.Equals(left, right):
                a, b = self._frame.find_slot(left, scope), self._frame.find_slot(right, scope)
                return lambda state, binding: (binding[a] == binding[b]) is wanted
            case f.Not(operand):
                return self.compile_test(operand, scope, wanted=not wanted)
            case f.And(operands) | f.Or(operands):
                parts = [self.compile_test(operand, scope, wanted=wanted) for operand in operands]
                if isinstance(formula, f.And) is wanted:
                    return combine_tests_by_and(parts)
                return combine_tests_by_or(parts)
            case f.Implies(premise, conclusion):
                return self.compile_test(f.Or((f.Not(premise), conclusion)), scope, wanted=wanted)
            case f.Exists(variable, f.Equals(f.Variable(member), term)) if (
                member == variable.name and term != f.Variable(member)
            ):
                index, category, bit = self._frame.find_slot(term, scope), variable.category, int(wanted)
                return lambda state, binding: (
                    state.scene.get_category_mask(category) >> binding[index] & 1 == bit
                )
            case f.Exists(variable, body):
                matching = self._compile_value_finder(variable, body, scope)
                return lambda state, binding: bool(matching(state, binding)) is wanted
            case f.ForAll(variable, body):
                return self.compile_test(f.Exists(variable, f.Not(body)), scope, wanted=not wanted)
            case f.Exactly(count, variable, body):
                matching = self._compile_value_finder(variable, body, scope)
                return lambda state, binding: (matching(state, binding).bit_count() == count) is wanted
            case f.ForPairs():
                is_paired = self._compile_disjoint_pairs_test(formula, scope)
                return is_paired if wanted else negate_test(is_paired)
            case _:
                raise DomainError(
                    f"{type(formula).__name__} is not a condition on one state: write a formula without"
                    " temporal operators and actions"
                )

    def compile_filter(self, formula: f.Formula, slot: int, scope: SlotByVariable) -> ObjectFilter:
        """Compile a formula to a function that selects the objects that make the formula true.

        Each object is tried as value of the variable with number ``slot``.
        """
        match formula:
            case f.Atom():
                return self._compile_atom_filter(formula, slot, scope)
            case f.Equals(left, right):
                slots = {self._frame.find_slot(left, scope), self._frame.find_slot(right, scope)}
                if slot in slots and len(slots) == 2:
                    other = (slots - {slot}).pop()
                    return lambda state, binding, among: among & 1 << binding[other]
                return self._compile_filter_testing_each_object(formula, slot, scope)
            case f.Not(operand):
                return negate_filter(self.compile_filter(operand, slot, scope))
            case f.And(operands) | f.Or(operands):
                parts = [self.compile_filter(operand, slot, scope) for operand in operands]
                if isinstance(formula, f.And):
                    return combine_filters_by_and(parts)
                return combine_filters_by_or(parts)
            case f.Implies(premise, conclusion):
                return self.compile_filter(f.Or((f.Not(premise), conclusion)), slot, scope)
            case f.Exists(variable, f.Equals(f.Variable(member), f.Variable(name))) if (
                member == variable.name != name and scope.get(name) == slot
            ):
                category = variable.category
                return lambda state, binding, among: among & state.scene.get_category_mask(category)
            case f.Exists(variable, body):
                return self._compile_exists(variable, body, slot, scope)
            case _:
                return self._compile_filter_testing_each_object(formula, slot, scope)

    def _compile_exists(
        self, variable: f.Variable, body: f.Formula, slot: int, scope: SlotByVariable
    ) -> ObjectFilter:
        """Compile an existential formula.

        The parts of the body that do not depend on the quantified variable are tested first.
        """
        names = {name for name, index in scope.items() if index == slot} - {variable.name}
        parts = f.get_operands(body, f.And)
        independent = tuple([part for part in parts if names.isdisjoint(find_free_variables(part))])
        if not independent:
            return self._compile_filter_testing_each_object(f.Exists(variable, body), slot, scope)
        inner = self._frame.add_slot()
        within = {**scope, variable.name: inner}
        candidates = self.compile_filter(f.And(independent), inner, within)
        matching = self.compile_filter(
            f.And(tuple([part for part in parts if part not in independent])), slot, within
        )

        def filter_objects(state: State, binding: ObjectBySlot, among: ObjectMask) -> ObjectMask:
            mask = 0
            for i in iterate_bits(
                candidates(state, binding, state.scene.get_category_mask(variable.category))
            ):
                binding[inner] = i
                mask |= matching(state, binding, among & ~mask)
            binding[inner] = UNBOUND
            return mask

        return filter_objects

    def _compile_value_finder(
        self, variable: f.Variable, body: f.Formula, scope: SlotByVariable
    ) -> _ValueFinder:
        slot = self._frame.add_slot()
        matching = self.compile_filter(body, slot, {**scope, variable.name: slot})
        category = variable.category
        if category is None:
            return lambda state, binding: matching(state, binding, state.scene.everything)
        return lambda state, binding: matching(state, binding, state.scene.get_category_mask(category))

    def _compile_filter_testing_each_object(
        self, formula: f.Formula, slot: int, scope: SlotByVariable
    ) -> ObjectFilter:
        truth = self.compile_test(formula, scope)

        def filter_objects(state: State, binding: ObjectBySlot, among: ObjectMask) -> ObjectMask:
            mask = 0
            for i in iterate_bits(among):
                binding[slot] = i
                if truth(state, binding):
                    mask |= 1 << i
            binding[slot] = UNBOUND
            return mask

        return filter_objects

    def _compile_disjoint_pairs_test(self, formula: f.ForPairs, scope: SlotByVariable) -> ConditionTest:
        """Compile a `ForPairs` formula to a test whether a maximum matching of objects has enough pairs."""
        first, second, count = formula.first, formula.second, formula.count
        slot = self._frame.add_slot()
        partners = self._compile_value_finder(second, formula.body, {**scope, first.name: slot})

        def has_enough_disjoint_object_pairs(state: State, binding: ObjectBySlot) -> bool:
            sources = list(iterate_bits(state.scene.get_category_mask(first.category)))
            targets = {
                y: j for j, y in enumerate(iterate_bits(state.scene.get_category_mask(second.category)))
            }
            adjacency = []
            for x in sources:
                binding[slot] = x
                adjacency.append([targets[y] for y in iterate_bits(partners(state, binding)) if y != x])
            needed = min(len(sources), len(targets)) if count is None else count
            return sum(j is not None for j in find_maximum_matching(adjacency)) >= needed

        return has_enough_disjoint_object_pairs

    def _compile_atom_truth(self, atom: f.Atom, scope: SlotByVariable, wanted: bool) -> ConditionTest:
        slots = self._find_argument_slots(atom, scope)
        derived = self._find_derived_predicate(atom.predicate)
        match derived:
            case None:
                return _compile_test_of_stored_predicate(self._vocabulary, atom.predicate, slots, wanted)
            case DefinedPredicate(definition=definition):
                with self._forbid_recursion(derived):
                    return self.compile_test(
                        definition, _map_parameters_to_slots(derived, slots), wanted=wanted
                    )
            case ComputedPredicate(test=test):
                return lambda state, binding: bool(test(state, tuple([binding[s] for s in slots]))) is wanted
            case LookupPredicate():
                values, last, bit = _make_last_argument_finder(derived, slots[:-1]), slots[-1], int(wanted)
                return lambda state, binding: values(state, binding) >> binding[last] & 1 == bit
            case _:
                expected = "DefinedPredicate, ComputedPredicate or LookupPredicate"
                raise DomainError(
                    f"derived predicate {atom.predicate}: expected {expected}, found {type(derived).__name__}"
                )

    def _compile_atom_filter(self, atom: f.Atom, slot: int, scope: SlotByVariable) -> ObjectFilter:
        slots = self._find_argument_slots(atom, scope)
        derived = self._find_derived_predicate(atom.predicate)
        if slots.count(slot) == 0:
            truth = self._compile_atom_truth(atom, scope, wanted=True)
            return lambda state, binding, among: among if truth(state, binding) else 0
        if isinstance(derived, DefinedPredicate):
            with self._forbid_recursion(derived):
                return self.compile_filter(derived.definition, slot, _map_parameters_to_slots(derived, slots))
        if isinstance(derived, LookupPredicate) and slots.index(slot) == len(slots) - 1:
            values = _make_last_argument_finder(derived, slots[:-1])
            return lambda state, binding, among: values(state, binding) & among
        if isinstance(derived, LookupPredicate) and derived.inverse is not None and slots.count(slot) == 1:
            of, other = derived.inverse, slots[1]
            return lambda state, binding, among: of(state, (binding[other],)) & among
        if derived is not None or slots.count(slot) > 1:
            return self._compile_filter_testing_each_object(atom, slot, scope)
        return _compile_filter_by_stored_predicate(self._vocabulary, atom.predicate, slots, slot)

    def _find_derived_predicate(self, predicate: str) -> DerivedPredicate | None:
        """Return a derived predicate in its fastest form; None for a stored predicate."""
        derived = self._vocabulary.derived_by_name.get(predicate)
        return None if derived is None else replace_formula_by_faster_function(derived)

    @contextmanager
    def _forbid_recursion(self, derived: DefinedPredicate) -> Iterator[None]:
        """Raise DomainError if the definition compiled in this context uses its own predicate."""
        if derived.name in self._unfolded:
            raise DomainError(
                f"derived predicate {derived.name} is defined by itself: define it by other predicates, or"
                " by a function (LookupPredicate)"
            )
        self._unfolded.append(derived.name)
        try:
            yield
        finally:
            self._unfolded.pop()

    def _find_argument_slots(self, atom: f.Atom, scope: SlotByVariable) -> tuple[int, ...]:
        self._vocabulary.require_arity(atom.predicate, len(atom.arguments))
        return tuple(self._frame.find_slot(term, scope) for term in atom.arguments)


def _map_parameters_to_slots(derived: DefinedPredicate, slots: tuple[int, ...]) -> SlotByVariable:
    return {p.name: s for p, s in zip(derived.parameters, slots, strict=True)}


def _make_last_argument_finder(
    lookup_predicate: LookupPredicate, argument_slots: Sequence[int]
) -> _ValueFinder:
    values = lookup_predicate.values
    if len(argument_slots) == 1:  # a case without a loop makes scoring of some benchmarks a tenth faster
        (only,) = argument_slots
        return lambda state, binding: values(state, (binding[only],))
    return lambda state, binding: values(state, tuple([binding[s] for s in argument_slots]))


def _compile_test_of_stored_predicate(
    vocabulary: Vocabulary, predicate: str, slots: tuple[int, ...], wanted: bool
) -> ConditionTest:
    if len(slots) > 2:
        slot = vocabulary.tuple_slots[predicate]
        return lambda state, binding: (
            (tuple([binding[s] for s in slots]) in state.tuples[slot].members) is wanted
        )
    if len(slots) == 2:
        relation = vocabulary.binary_slots[predicate]
        source, target = slots
        return lambda state, binding: state.binary[relation].has(binding[source], binding[target]) is wanted
    mask, bit = vocabulary.unary_slots[predicate], int(wanted)
    if not slots:
        return lambda state, binding: state.unary[mask] == bit
    argument = slots[0]
    return lambda state, binding: state.unary[mask] >> binding[argument] & 1 == bit


def _compile_filter_by_stored_predicate(
    vocabulary: Vocabulary, predicate: str, argument_slots: tuple[int, ...], filtered_slot: int
) -> ObjectFilter:
    if len(argument_slots) == 1:
        mask = vocabulary.unary_slots[predicate]
        return lambda state, binding, among: state.unary[mask] & among
    if len(argument_slots) > 2:
        tuple_slot, position = vocabulary.tuple_slots[predicate], argument_slots.index(filtered_slot)
        others = argument_slots[:position] + argument_slots[position + 1 :]
        return lambda state, binding, among: (
            state.tuples[tuple_slot].find_objects_completing_tuple(
                position, tuple([binding[s] for s in others])
            )
            & among
        )
    relation = vocabulary.binary_slots[predicate]
    source, target = argument_slots
    if filtered_slot == target:
        return lambda state, binding, among: state.binary[relation].row(binding[source]) & among
    return lambda state, binding, among: state.binary[relation].column(binding[target]) & among


_MAX_CACHED_FORMULAS = 10_000
"""Maximum number of compiled tests, and of compiled filters, that a `FormulaEvaluator` caches."""

_CompiledFunction = TypeVar("_CompiledFunction", ConditionTest, ObjectFilter)


@dataclass(frozen=True, slots=True)
class _CompiledFormula(Generic[_CompiledFunction]):
    """A compiled formula: its test or filter, and the slots of its variables.

    The cache finds a formula by its id. Python gives the id of a deleted object to a new object, so the
    formula is kept.

    The slots after that of the agent hold the values of `variables`: the free variables in alphabetical
    order, without the open variable of a filter.
    """

    formula: f.Formula
    variables: tuple[str, ...]
    frame: SlotAllocator
    function: _CompiledFunction


class FormulaEvaluator:
    """Evaluates formulas over one vocabulary.

    Compiled formulas are cached by the identity of the formula object, because hashing a formula is slow.
    """

    def __init__(self, vocabulary: Vocabulary) -> None:
        self._vocabulary = vocabulary
        self._truths: dict[int, _CompiledFormula[ConditionTest]] = {}
        self._filters: dict[tuple[int, str], _CompiledFormula[ObjectFilter]] = {}

    def list_free_variables(self, formula: f.Formula) -> tuple[str, ...]:
        """Return the names of the free variables of a formula, in alphabetical order."""
        return self._get_compiled_test(formula).variables

    def holds(self, formula: f.Formula, scope: Scope, state: State) -> bool:
        """Whether a formula holds in a state; ``scope`` maps its free variables to object indices."""
        test = self._truths.get(id(formula)) or self._get_compiled_test(formula)
        arguments = [scope[name] for name in test.variables]
        return test.function(state, test.frame.bind_arguments(state.scene, arguments))

    def _get_compiled_test(self, formula: f.Formula) -> _CompiledFormula[ConditionTest]:
        test = self._truths.get(id(formula))
        if test is None:
            if len(self._truths) >= _MAX_CACHED_FORMULAS:
                self._truths = {}
            names = tuple(sorted(find_free_variables(formula)))
            frame = SlotAllocator([f.Variable(name) for name in names])
            function = ConditionCompiler(self._vocabulary, frame).compile_test(formula)
            test = self._truths[id(formula)] = _CompiledFormula(formula, names, frame, function)
        return test

    def find_witnesses(
        self, variable: f.Variable, body: f.Formula, scope: Scope, state: State
    ) -> Iterator[int]:
        """Yield the values of a quantified formula's variable for which the body holds in a state."""
        key = (id(body), variable.name)
        matching = self._filters.get(key)
        if matching is None:
            if len(self._filters) >= _MAX_CACHED_FORMULAS:
                self._filters = {}
            names = tuple(sorted(find_free_variables(body) - {variable.name}))
            frame = SlotAllocator([f.Variable(name) for name in (*names, variable.name)])
            conditions = ConditionCompiler(self._vocabulary, frame)
            function = conditions.compile_filter(body, len(names) + 1, frame.scope)
            matching = self._filters[key] = _CompiledFormula(body, names, frame, function)
        arguments = [*[scope[name] for name in matching.variables], UNBOUND]
        binding = matching.frame.bind_arguments(state.scene, arguments)
        among = state.scene.get_category_mask(variable.category)
        return iterate_bits(matching.function(state, binding, among))
