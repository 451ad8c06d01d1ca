"""State formulas compiled to functions of a state and a binding.

A formula is compiled once per domain and evaluated millions of times. Two readings exist: its *truth* under a
binding of all its free variables, and its *extension* in one free variable, that is, the mask of all objects
that make it true. Quantifiers are questions about extensions, so most of them cost a few integer operations.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TypeAlias

from typing_extensions import assert_never

from eai.errors import DomainError
from eai.logic.formula import (
    And,
    Atom,
    Constant,
    Equals,
    Exactly,
    Exists,
    ForAll,
    Formula,
    ForPairs,
    Implies,
    Not,
    Or,
    Term,
    Variable,
)
from eai.logic.matching import maximum_matching
from eai.world.relation import bits
from eai.world.state import Scene, State
from eai.world.vocabulary import Computed, Defined, Derived, Lookup, Vocabulary

Binding: TypeAlias = list[int]
"""Object indices by slot; slot 0 is the agent."""

Truth: TypeAlias = Callable[[State, Binding], bool]
Extension: TypeAlias = Callable[[State, Binding], int]

AGENT = Constant("agent")
"""The acting object, in any formula of a domain."""

UNBOUND = -1
"""What a slot holds whose variable has no value."""


class Frame:
    """The slots of one binding: the agent, the parameters, then every other variable and constant in use."""

    def __init__(self, parameters: Sequence[Variable] = ()) -> None:
        self._size = 1 + len(parameters)
        self._constants: dict[str, int] = {}
        self.scope: dict[str, int] = {v.name: i + 1 for i, v in enumerate(parameters)}

    def new_slot(self) -> int:
        """A slot that nothing else uses."""
        self._size += 1
        return self._size - 1

    def slot_of(self, term: Term, scope: Mapping[str, int]) -> int:
        """The slot of a term.

        Raises:
            DomainError: the variable is bound nowhere.
        """
        if isinstance(term, Constant):
            if term == AGENT:
                return 0
            if term.name not in self._constants:
                self._constants[term.name] = self.new_slot()
            return self._constants[term.name]
        if term.name not in scope:
            raise DomainError(f"variable {term.name} is not bound")
        return scope[term.name]

    def bind(self, scene: Scene, arguments: Sequence[int]) -> Binding:
        """A binding for these arguments, with constants filled in and all other slots unbound."""
        binding = [UNBOUND if scene.agent is None else scene.agent, *arguments]
        binding += [UNBOUND] * (self._size - len(binding))
        for name, slot in self._constants.items():
            binding[slot] = scene.index[name]
        return binding


class Conditions:
    """A compiler of state formulas over one vocabulary into functions that share one frame.

    Raises:
        DomainError: from its methods, for a predicate that is not declared, a wrong number of arguments, an
            unbound variable, or a temporal operator.
    """

    def __init__(self, vocabulary: Vocabulary, frame: Frame) -> None:
        self._vocabulary = vocabulary
        self._frame = frame

    def truth(self, formula: Formula, scope: Mapping[str, int] | None = None) -> Truth:
        """Whether the formula holds in a state under a binding."""
        scope = self._frame.scope if scope is None else scope
        match formula:
            case Atom():
                return self._atom_truth(formula, scope)
            case Equals(left, right):
                a, b = self._frame.slot_of(left, scope), self._frame.slot_of(right, scope)
                return lambda state, binding: binding[a] == binding[b]
            case Not(operand):
                inner = self.truth(operand, scope)
                return lambda state, binding: not inner(state, binding)
            case And(operands):
                return _all([self.truth(f, scope) for f in operands])
            case Or(operands):
                return _any([self.truth(f, scope) for f in operands])
            case Implies(premise, conclusion):
                return self.truth(Or((Not(premise), conclusion)), scope)
            case Exists(variable, body):
                matching = self._values(variable, body, scope)
                return lambda state, binding: matching(state, binding) != 0
            case ForAll(variable, body):
                failing = self._values(variable, Not(body), scope)
                return lambda state, binding: failing(state, binding) == 0
            case Exactly(count, variable, body):
                matching = self._values(variable, body, scope)
                return lambda state, binding: matching(state, binding).bit_count() == count
            case ForPairs():
                return self._pairs_truth(formula, scope)
            case _:
                raise DomainError(f"{type(formula).__name__} is not a condition on one state")

    def extension(self, formula: Formula, slot: int, scope: Mapping[str, int]) -> Extension:
        """The mask of all objects that make the formula true when put in ``slot``."""
        match formula:
            case Atom():
                return self._atom_extension(formula, slot, scope)
            case Equals(left, right):
                slots = {self._frame.slot_of(left, scope), self._frame.slot_of(right, scope)}
                if slot in slots and len(slots) == 2:
                    other = (slots - {slot}).pop()
                    return lambda state, binding: 1 << binding[other]
                return self._by_trial(formula, slot, scope)
            case Not(operand):
                inner = self.extension(operand, slot, scope)
                return lambda state, binding: state.scene.everything & ~inner(state, binding)
            case And(operands):
                inside = [self.extension(f, slot, scope) for f in operands if not isinstance(f, Not)]
                outside = [self.extension(f.operand, slot, scope) for f in operands if isinstance(f, Not)]
                return _intersection(inside, outside)
            case Or(operands):
                return _union([self.extension(f, slot, scope) for f in operands])
            case Implies(premise, conclusion):
                return self.extension(Or((Not(premise), conclusion)), slot, scope)
            case _:
                return self._by_trial(formula, slot, scope)

    def _values(self, variable: Variable, body: Formula, scope: Mapping[str, int]) -> Extension:
        """The mask of the values of a quantified variable for which the body holds."""
        slot = self._frame.new_slot()
        inner = self.extension(body, slot, {**scope, variable.name: slot})
        category = variable.category
        if category is None:
            return inner
        return lambda state, binding: inner(state, binding) & state.scene.category(category)

    def _by_trial(self, formula: Formula, slot: int, scope: Mapping[str, int]) -> Extension:
        """The extension of any formula: put every object into the slot and look."""
        truth = self.truth(formula, scope)

        def extension(state: State, binding: Binding) -> int:
            mask = 0
            for i in range(len(state.scene.objects)):
                binding[slot] = i
                if truth(state, binding):
                    mask |= 1 << i
            binding[slot] = UNBOUND
            return mask

        return extension

    def _pairs_truth(self, formula: ForPairs, scope: Mapping[str, int]) -> Truth:
        """A pairing exists iff a maximum matching is large enough."""
        first, second, count = formula.first, formula.second, formula.count
        slot = self._frame.new_slot()
        partners = self._values(second, formula.body, {**scope, first.name: slot})

        def truth(state: State, binding: Binding) -> bool:
            left = list(bits(state.scene.category(first.category)))
            right = {y: j for j, y in enumerate(bits(state.scene.category(second.category)))}
            adjacency = []
            for x in left:
                binding[slot] = x
                adjacency.append([right[y] for y in bits(partners(state, binding)) if y != x])
            needed = min(len(left), len(right)) if count is None else count
            return sum(j is not None for j in maximum_matching(adjacency)) >= needed

        return truth

    def _atom_truth(self, atom: Atom, scope: Mapping[str, int]) -> Truth:
        slots = self._slots(atom, scope)
        derived = self._derived(atom)
        match derived:
            case None:
                return _stored_truth(self._vocabulary, atom.predicate, slots)
            case Defined(_, parameters, definition):
                inner = {p.name: s for p, s in zip(parameters, slots, strict=True)}
                return self.truth(definition, inner)
            case Computed(test=test):
                return lambda state, binding: test(state, tuple([binding[s] for s in slots]))
            case Lookup(values=values):
                *known, last = slots
                return lambda state, binding: bool(
                    values(state, tuple([binding[s] for s in known])) >> binding[last] & 1
                )
            case _:
                assert_never(derived)

    def _atom_extension(self, atom: Atom, slot: int, scope: Mapping[str, int]) -> Extension:
        slots = self._slots(atom, scope)
        derived = self._derived(atom)
        if slots.count(slot) == 0:
            truth = self._atom_truth(atom, scope)
            return lambda state, binding: state.scene.everything if truth(state, binding) else 0
        if isinstance(derived, Defined):
            inner = {p.name: s for p, s in zip(derived.parameters, slots, strict=True)}
            return self.extension(derived.definition, slot, inner)
        if isinstance(derived, Lookup) and slots.index(slot) == len(slots) - 1:
            known, values = slots[:-1], derived.values
            return lambda state, binding: values(state, tuple([binding[s] for s in known]))
        if derived is not None or slots.count(slot) > 1:
            return self._by_trial(atom, slot, scope)
        return _stored_extension(self._vocabulary, atom.predicate, slots, slot)

    def _derived(self, atom: Atom) -> Derived | None:
        """The derived predicate of an atom in the form that is evaluated, or None if it is stored."""
        derived = self._vocabulary.derived_by_name.get(atom.predicate)
        if isinstance(derived, Defined) and derived.values is not None:
            return Lookup(derived.name, derived.arity, derived.values, ())
        return derived

    def _slots(self, atom: Atom, scope: Mapping[str, int]) -> tuple[int, ...]:
        arity = self._vocabulary.arity(atom.predicate)
        if arity is None:
            raise DomainError(f"predicate {atom.predicate} is not declared")
        if arity != len(atom.arguments):
            raise DomainError(f"{atom.predicate} takes {arity} arguments, not {len(atom.arguments)}")
        return tuple(self._frame.slot_of(term, scope) for term in atom.arguments)


def _stored_truth(vocabulary: Vocabulary, predicate: str, slots: tuple[int, ...]) -> Truth:
    if len(slots) == 2:
        relation = vocabulary.binary_slots[predicate]
        source, target = slots
        return lambda state, binding: state.binary[relation].has(binding[source], binding[target])
    mask = vocabulary.unary_slots[predicate]
    if not slots:
        return lambda state, binding: bool(state.unary[mask])
    argument = slots[0]
    return lambda state, binding: bool(state.unary[mask] >> binding[argument] & 1)


def _stored_extension(vocabulary: Vocabulary, predicate: str, slots: tuple[int, ...], slot: int) -> Extension:
    if len(slots) == 1:
        mask = vocabulary.unary_slots[predicate]
        return lambda state, binding: state.unary[mask]
    relation = vocabulary.binary_slots[predicate]
    source, target = slots
    if slot == target:
        return lambda state, binding: state.binary[relation].row(binding[source])
    return lambda state, binding: state.binary[relation].column(binding[target])


def _all(parts: list[Truth]) -> Truth:
    if len(parts) == 2:
        first, second = parts
        return lambda state, binding: first(state, binding) and second(state, binding)

    def truth(state: State, binding: Binding) -> bool:
        for part in parts:  # noqa: SIM110 - a loop is three times as fast as all() over a generator
            if not part(state, binding):
                return False
        return True

    return truth


def _any(parts: list[Truth]) -> Truth:
    if len(parts) == 2:
        first, second = parts
        return lambda state, binding: first(state, binding) or second(state, binding)

    def truth(state: State, binding: Binding) -> bool:
        for part in parts:  # noqa: SIM110 - a loop is three times as fast as any() over a generator
            if part(state, binding):
                return True
        return False

    return truth


def _intersection(inside: list[Extension], outside: list[Extension]) -> Extension:
    """The objects in all of the one masks and in none of the others."""
    if len(inside) == 2 and not outside:
        first, second = inside
        return lambda state, binding: (mask := first(state, binding)) and mask & second(state, binding)
    if len(inside) == 1 and len(outside) == 1:
        (included,), (excluded,) = inside, outside
        return lambda state, binding: included(state, binding) & ~excluded(state, binding)

    def extension(state: State, binding: Binding) -> int:
        mask = state.scene.everything
        for part in inside:
            mask &= part(state, binding)
        for part in outside:
            mask &= ~part(state, binding)
        return mask

    return extension


def _union(parts: list[Extension]) -> Extension:
    """The objects in any of the masks."""
    if len(parts) == 2:
        first, second = parts
        return lambda state, binding: first(state, binding) | second(state, binding)

    def extension(state: State, binding: Binding) -> int:
        mask = 0
        for part in parts:
            mask |= part(state, binding)
        return mask

    return extension
