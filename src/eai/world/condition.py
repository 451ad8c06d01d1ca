"""State formulas compiled to functions of a state and a binding.

A formula is compiled once per domain and evaluated millions of times. Two readings exist: its *truth* under a
binding of all its free variables, and its *extension* in one free variable, that is, the mask of those of
some objects that make it true. Quantifiers are questions about extensions, so most of them cost a few integer
operations; where objects must be tried one by one, only those are that the rest of the formula leaves.
Connectives make truths and extensions of other ones, each by a loop over its parts.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TypeAlias

import eai.logic.formula as f
from eai.base.errors import DomainError
from eai.logic.matching import maximum_matching
from eai.logic.traversal import free_variables
from eai.world.derived import Computed, Defined, Lookup, to_evaluated_form
from eai.world.frame import UNBOUND, Extension, Frame, FrameBinding, Truth
from eai.world.relation import bits
from eai.world.state import State
from eai.world.vocabulary import DerivedPredicate, Vocabulary

Scope: TypeAlias = Mapping[str, int]
"""Object indices by the names of the variables that stand for them."""


def conjunction(parts: Sequence[Truth]) -> Truth:
    """Whether every part holds; they are asked in order."""

    def truth(state: State, binding: FrameBinding) -> bool:
        for part in parts:  # noqa: SIM110 - a loop is three times as fast as all() over a generator
            if not part(state, binding):
                return False
        return True

    return truth


def disjunction(parts: Sequence[Truth]) -> Truth:
    """Whether some part holds; they are asked in order."""

    def truth(state: State, binding: FrameBinding) -> bool:
        for part in parts:  # noqa: SIM110 - a loop is three times as fast as any() over a generator
            if part(state, binding):
                return True
        return False

    return truth


def negation(part: Truth) -> Truth:
    """Whether the part does not hold."""
    return lambda state, binding: not part(state, binding)


def complement(part: Extension) -> Extension:
    """The objects that are not in the part."""
    return lambda state, binding, among: among & ~part(state, binding, among)


def intersection(parts: Sequence[Extension]) -> Extension:
    """The objects in all of the parts; each is asked about what is in those before it."""

    def extension(state: State, binding: FrameBinding, among: int) -> int:
        for part in parts:
            among = part(state, binding, among)
            if not among:
                return 0
        return among

    return extension


def union(parts: Sequence[Extension]) -> Extension:
    """The objects in any of the parts; each is asked about what is in none before it."""

    def extension(state: State, binding: FrameBinding, among: int) -> int:
        mask = 0
        for part in parts:
            mask |= part(state, binding, among & ~mask)
        return mask

    return extension


_Values: TypeAlias = Callable[[State, FrameBinding], int]
"""The mask of all objects that something is true of."""


class ConditionCompiler:
    """A compiler of state formulas over one vocabulary into functions that share one frame.

    Raises:
        DomainError: from its methods, for a predicate that is not declared or is defined by itself, a wrong
            number of arguments, an unbound variable, or a temporal operator.
    """

    def __init__(self, vocabulary: Vocabulary, frame: Frame) -> None:
        self._vocabulary = vocabulary
        self._frame = frame
        self._unfolded: list[str] = []

    def truth(
        self, formula: f.Formula, scope: Mapping[str, int] | None = None, *, wanted: bool = True
    ) -> Truth:
        """Whether the formula holds in a state under a binding, or (not ``wanted``) whether it does not."""
        scope = self._frame.scope if scope is None else scope
        match formula:
            case f.Atom():
                return self._atom_truth(formula, scope, wanted)
            case f.Equals(left, right):
                a, b = self._frame.slot_of(left, scope), self._frame.slot_of(right, scope)
                return lambda state, binding: (binding[a] == binding[b]) is wanted
            case f.Not(operand):
                return self.truth(operand, scope, wanted=not wanted)
            case f.And(operands) | f.Or(operands):
                parts = [self.truth(operand, scope, wanted=wanted) for operand in operands]
                return conjunction(parts) if isinstance(formula, f.And) is wanted else disjunction(parts)
            case f.Implies(premise, conclusion):
                return self.truth(f.Or((f.Not(premise), conclusion)), scope, wanted=wanted)
            case f.Exists(variable, body):
                matching = self._values(variable, body, scope)
                return lambda state, binding: bool(matching(state, binding)) is wanted
            case f.ForAll(variable, body):
                return self.truth(f.Exists(variable, f.Not(body)), scope, wanted=not wanted)
            case f.Exactly(count, variable, body):
                matching = self._values(variable, body, scope)
                return lambda state, binding: (matching(state, binding).bit_count() == count) is wanted
            case f.ForPairs():
                paired = self._pairs_truth(formula, scope)
                return paired if wanted else negation(paired)
            case _:
                raise DomainError(f"{type(formula).__name__} is not a condition on one state")

    def extension(self, formula: f.Formula, slot: int, scope: Mapping[str, int]) -> Extension:
        """The mask of those of some objects that make the formula true when put in ``slot``."""
        match formula:
            case f.Atom():
                return self._atom_extension(formula, slot, scope)
            case f.Equals(left, right):
                slots = {self._frame.slot_of(left, scope), self._frame.slot_of(right, scope)}
                if slot in slots and len(slots) == 2:
                    other = (slots - {slot}).pop()
                    return lambda state, binding, among: among & 1 << binding[other]
                return self._by_trial(formula, slot, scope)
            case f.Not(operand):
                return complement(self.extension(operand, slot, scope))
            case f.And(operands) | f.Or(operands):
                parts = [self.extension(operand, slot, scope) for operand in operands]
                return intersection(parts) if isinstance(formula, f.And) else union(parts)
            case f.Implies(premise, conclusion):
                return self.extension(f.Or((f.Not(premise), conclusion)), slot, scope)
            case f.Exists(variable, body):
                return self._some_extension(variable, body, slot, scope)
            case _:
                return self._by_trial(formula, slot, scope)

    def _some_extension(
        self, variable: f.Variable, body: f.Formula, slot: int, scope: Mapping[str, int]
    ) -> Extension:
        """The extension of "there is some": for each object that is left by what is said of it alone."""
        names = {name for name, each in scope.items() if each == slot} - {variable.name}
        parts = f.operands(body, f.And)
        alone = tuple([part for part in parts if names.isdisjoint(free_variables(part))])
        if not alone:
            return self._by_trial(f.Exists(variable, body), slot, scope)
        inner = self._frame.new_slot()
        within = {**scope, variable.name: inner}
        left = self.extension(f.And(alone), inner, within)
        matching = self.extension(f.And(tuple([part for part in parts if part not in alone])), slot, within)

        def extension(state: State, binding: FrameBinding, among: int) -> int:
            mask = 0
            for i in bits(left(state, binding, state.scene.category(variable.category))):
                binding[inner] = i
                mask |= matching(state, binding, among & ~mask)
            binding[inner] = UNBOUND
            return mask

        return extension

    def _values(self, variable: f.Variable, body: f.Formula, scope: Mapping[str, int]) -> _Values:
        """The mask of the values of a quantified variable for which the body holds."""
        slot = self._frame.new_slot()
        matching = self.extension(body, slot, {**scope, variable.name: slot})
        category = variable.category
        if category is None:
            return lambda state, binding: matching(state, binding, state.scene.everything)
        return lambda state, binding: matching(state, binding, state.scene.category(category))

    def _by_trial(self, formula: f.Formula, slot: int, scope: Mapping[str, int]) -> Extension:
        """The extension of any formula: put every object into the slot and look."""
        truth = self.truth(formula, scope)

        def extension(state: State, binding: FrameBinding, among: int) -> int:
            mask = 0
            for i in bits(among):
                binding[slot] = i
                if truth(state, binding):
                    mask |= 1 << i
            binding[slot] = UNBOUND
            return mask

        return extension

    def _pairs_truth(self, formula: f.ForPairs, scope: Mapping[str, int]) -> Truth:
        """A pairing exists iff a maximum matching is large enough."""
        first, second, count = formula.first, formula.second, formula.count
        slot = self._frame.new_slot()
        partners = self._values(second, formula.body, {**scope, first.name: slot})

        def truth(state: State, binding: FrameBinding) -> bool:
            left = list(bits(state.scene.category(first.category)))
            right = {y: j for j, y in enumerate(bits(state.scene.category(second.category)))}
            adjacency = []
            for x in left:
                binding[slot] = x
                adjacency.append([right[y] for y in bits(partners(state, binding)) if y != x])
            needed = min(len(left), len(right)) if count is None else count
            return sum(j is not None for j in maximum_matching(adjacency)) >= needed

        return truth

    def _atom_truth(self, atom: f.Atom, scope: Mapping[str, int], wanted: bool) -> Truth:
        slots = self._slots(atom, scope)
        derived = self._evaluated(atom.predicate)
        match derived:
            case None:
                return _stored_truth(self._vocabulary, atom.predicate, slots, wanted)
            case Defined(definition=definition):
                with self._unfolding(derived):
                    return self.truth(definition, _inner_scope(derived, slots), wanted=wanted)
            case Computed(test=test):
                return lambda state, binding: bool(test(state, tuple([binding[s] for s in slots]))) is wanted
            case Lookup():
                found, last, bit = _looked_up(derived, slots[:-1]), slots[-1], int(wanted)
                return lambda state, binding: found(state, binding) >> binding[last] & 1 == bit
            case _:
                raise DomainError(f"derived predicate {atom.predicate} has no known form")

    def _atom_extension(self, atom: f.Atom, slot: int, scope: Mapping[str, int]) -> Extension:
        slots = self._slots(atom, scope)
        derived = self._evaluated(atom.predicate)
        if slots.count(slot) == 0:
            truth = self._atom_truth(atom, scope, wanted=True)
            return lambda state, binding, among: among if truth(state, binding) else 0
        if isinstance(derived, Defined):
            with self._unfolding(derived):
                return self.extension(derived.definition, slot, _inner_scope(derived, slots))
        if isinstance(derived, Lookup) and slots.index(slot) == len(slots) - 1:
            found = _looked_up(derived, slots[:-1])
            return lambda state, binding, among: found(state, binding) & among
        if isinstance(derived, Lookup) and derived.inverse is not None and slots.count(slot) == 1:
            of, other = derived.inverse, slots[1]
            return lambda state, binding, among: of(state, (binding[other],)) & among
        if derived is not None or slots.count(slot) > 1:
            return self._by_trial(atom, slot, scope)
        return _stored_extension(self._vocabulary, atom.predicate, slots, slot)

    def _evaluated(self, predicate: str) -> DerivedPredicate | None:
        """A derived predicate in the form in which it is evaluated; None if it is stored."""
        derived = self._vocabulary.derived_by_name.get(predicate)
        return None if derived is None else to_evaluated_form(derived)

    @contextmanager
    def _unfolding(self, derived: Defined) -> Iterator[None]:
        """The definition of a predicate is put in its place; none stands in its own."""
        if derived.name in self._unfolded:
            raise DomainError(f"derived predicate {derived.name} is defined by itself")
        self._unfolded.append(derived.name)
        try:
            yield
        finally:
            self._unfolded.pop()

    def _slots(self, atom: f.Atom, scope: Mapping[str, int]) -> tuple[int, ...]:
        self._vocabulary.require_arity(atom.predicate, len(atom.arguments))
        return tuple(self._frame.slot_of(term, scope) for term in atom.arguments)


def _inner_scope(derived: Defined, slots: tuple[int, ...]) -> Mapping[str, int]:
    """The slots of the parameters of a derived predicate that is applied to these."""
    return {p.name: s for p, s in zip(derived.parameters, slots, strict=True)}


def _looked_up(lookup: Lookup, known: Sequence[int]) -> _Values:
    values = lookup.values
    if len(known) == 1:  # the most frequent form by far: without it some suites take a tenth longer
        (only,) = known
        return lambda state, binding: values(state, (binding[only],))
    return lambda state, binding: values(state, tuple([binding[s] for s in known]))


def _stored_truth(vocabulary: Vocabulary, predicate: str, slots: tuple[int, ...], wanted: bool) -> Truth:
    if len(slots) > 2:
        place = vocabulary.tuple_slots[predicate]
        return lambda state, binding: (
            (tuple([binding[s] for s in slots]) in state.tuples[place].members) is wanted
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


def _stored_extension(vocabulary: Vocabulary, predicate: str, slots: tuple[int, ...], slot: int) -> Extension:
    if len(slots) == 1:
        mask = vocabulary.unary_slots[predicate]
        return lambda state, binding, among: state.unary[mask] & among
    if len(slots) > 2:
        kept, place = vocabulary.tuple_slots[predicate], slots.index(slot)
        others = slots[:place] + slots[place + 1 :]
        return lambda state, binding, among: (
            state.tuples[kept].find_completions(place, tuple([binding[s] for s in others])) & among
        )
    relation = vocabulary.binary_slots[predicate]
    source, target = slots
    if slot == target:
        return lambda state, binding, among: state.binary[relation].row(binding[source]) & among
    return lambda state, binding, among: state.binary[relation].column(binding[target]) & among


class FormulaEvaluator:
    """The compiled formulas of one vocabulary. They are distinguished by identity, so that none is hashed."""

    def __init__(self, vocabulary: Vocabulary) -> None:
        self._vocabulary = vocabulary
        self._truths: dict[int, tuple[f.Formula, tuple[str, ...], Frame, Truth]] = {}
        self._extensions: dict[tuple[int, str], tuple[f.Formula, tuple[str, ...], Frame, Extension]] = {}

    def names(self, formula: f.Formula) -> tuple[str, ...]:
        """The names of the free variables of a formula, in alphabetical order."""
        return self._read(formula)[1]

    def holds(self, formula: f.Formula, scope: Scope, state: State) -> bool:
        """Whether a formula holds in a state, its free variables standing for the objects in ``scope``."""
        _, names, frame, truth = self._truths.get(id(formula)) or self._read(formula)
        return truth(state, frame.bind(state.scene, [scope[name] for name in names]))

    def _read(self, formula: f.Formula) -> tuple[f.Formula, tuple[str, ...], Frame, Truth]:
        found = self._truths.get(id(formula))
        if found is None:
            names = tuple(sorted(free_variables(formula)))
            frame = Frame([f.Variable(name) for name in names])
            truth = ConditionCompiler(self._vocabulary, frame).truth(formula)
            found = self._truths[id(formula)] = (formula, names, frame, truth)
        return found

    def witnesses(self, variable: f.Variable, body: f.Formula, scope: Scope, state: State) -> Iterator[int]:
        """The values of a quantified variable for which the body of the quantifier holds."""
        key = (id(body), variable.name)
        found = self._extensions.get(key)
        if found is None:
            names = tuple(sorted(free_variables(body) - {variable.name}))
            frame = Frame([f.Variable(name) for name in (*names, variable.name)])
            conditions = ConditionCompiler(self._vocabulary, frame)
            extension = conditions.extension(body, len(names) + 1, frame.scope)
            found = self._extensions[key] = (body, names, frame, extension)
        _, names, frame, extension = found
        binding = frame.bind(state.scene, [*[scope[name] for name in names], UNBOUND])
        return bits(extension(state, binding, state.scene.category(variable.category)))
