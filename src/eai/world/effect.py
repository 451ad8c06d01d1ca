"""Effects of operators on states.

Effects are values of a few fixed types, without Python code of the domain. They are compiled once.

Conditions in effects are evaluated in the state *before* the action. Then the changes are made in the order
in which they are written.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Final, TypeAlias

from typing_extensions import assert_never

from eai.base.errors import DomainError
from eai.logic.formula import Atom, Formula, Variable
from eai.world.condition import ConditionCompiler
from eai.world.frame import UNBOUND, ObjectBySlot, SlotAllocator, SlotByVariable
from eai.world.relation import iterate_bits
from eai.world.state import State, StateDraft
from eai.world.vocabulary import Vocabulary

ANYTHING: Final = Variable("*")
"""Wildcard argument in a deletion: it stands for any object."""


@dataclass(frozen=True, slots=True)
class Add:
    """An effect that makes an atom true."""

    atom: Atom


@dataclass(frozen=True, slots=True)
class Delete:
    """An effect that makes an atom false. With `ANYTHING` as an argument, all matching atoms become false."""

    atom: Atom


@dataclass(frozen=True, slots=True)
class When:
    """Effects that take place if a condition held before the action; if not, ``otherwise`` takes place."""

    condition: Formula
    effects: tuple[Effect, ...]
    otherwise: tuple[Effect, ...] = ()


@dataclass(frozen=True, slots=True)
class ForEach:
    """Effects that take place, in order, for each object that met a condition before the action."""

    variable: Variable
    condition: Formula
    effects: tuple[Effect, ...]


@dataclass(frozen=True, slots=True)
class Let:
    """Effects that take place for the first object, by index, that met a condition before the action."""

    variable: Variable
    condition: Formula
    effects: tuple[Effect, ...]


Effect: TypeAlias = Add | Delete | When | ForEach | Let

Apply: TypeAlias = Callable[[State, StateDraft, ObjectBySlot], None]


def make_symmetric_effects(effect: type[Add] | type[Delete], atom: Atom) -> tuple[Effect, Effect]:
    """Return two effects of one type: on a binary atom, and on the atom with its arguments swapped."""
    left, right = atom.arguments
    return effect(atom), effect(Atom(atom.predicate, (right, left)))


class EffectCompiler:
    """A compiler of effects over one vocabulary into functions that change the draft of a state.

    It shares a frame (a numbering of the variables) with the compiler of the operator's conditions.

    Raises:
        DomainError: raised by the methods if an effect changes a predicate that is undeclared, derived or
            static.
    """

    def __init__(self, vocabulary: Vocabulary, frame: SlotAllocator) -> None:
        self._vocabulary = vocabulary
        self._frame = frame
        self._conditions = ConditionCompiler(vocabulary, frame)

    def compile_sequence(self, effects: Iterable[Effect], scope: SlotByVariable | None = None) -> Apply:
        """Compile effects to one function that makes their changes in a draft of the next state, in order."""
        scope = self._frame.scope if scope is None else scope
        steps = tuple([self._compile_effect(effect, scope) for effect in effects])

        def apply(before: State, draft: StateDraft, binding: ObjectBySlot) -> None:
            for step in steps:
                step(before, draft, binding)

        return steps[0] if len(steps) == 1 else apply

    def _compile_effect(self, effect: Effect, scope: SlotByVariable) -> Apply:
        match effect:
            case Add(atom) | Delete(atom):
                return self._compile_atom_change(atom, scope, adding=isinstance(effect, Add))
            case When():
                return self._compile_when(effect, scope)
            case ForEach():
                return self._compile_for_each(effect, scope)
            case Let():
                return self._compile_let(effect, scope)
            case _:
                assert_never(effect)

    def _compile_when(self, effect: When, scope: SlotByVariable) -> Apply:
        truth = self._conditions.compile_test(effect.condition, scope)
        then = self.compile_sequence(effect.effects, scope)
        otherwise = self.compile_sequence(effect.otherwise, scope) if effect.otherwise else None

        def apply(before: State, draft: StateDraft, binding: ObjectBySlot) -> None:
            if truth(before, binding):
                then(before, draft, binding)
            elif otherwise is not None:
                otherwise(before, draft, binding)

        return apply

    def _compile_let(self, effect: Let, scope: SlotByVariable) -> Apply:
        slot = self._frame.add_slot()
        inner = {**scope, effect.variable.name: slot}
        candidates = self._conditions.compile_filter(effect.condition, slot, inner)
        then = self.compile_sequence(effect.effects, inner)

        def apply(before: State, draft: StateDraft, binding: ObjectBySlot) -> None:
            mask = candidates(before, binding, before.scene.everything)
            if mask:
                binding[slot] = (mask & -mask).bit_length() - 1
                then(before, draft, binding)
                binding[slot] = UNBOUND

        return apply

    def _compile_for_each(self, effect: ForEach, scope: SlotByVariable) -> Apply:
        slot = self._frame.add_slot()
        inner = {**scope, effect.variable.name: slot}
        matching = self._conditions.compile_filter(effect.condition, slot, inner)
        steps = tuple([self._compile_effect(inner_effect, inner) for inner_effect in effect.effects])

        def apply(before: State, draft: StateDraft, binding: ObjectBySlot) -> None:
            mask = matching(before, binding, before.scene.everything)
            if mask:
                matched = list(iterate_bits(mask))
                for step in steps:
                    for binding[slot] in matched:
                        step(before, draft, binding)
                binding[slot] = UNBOUND

        return apply

    def _compile_atom_change(self, atom: Atom, scope: SlotByVariable, *, adding: bool) -> Apply:
        predicate_slot = self._find_predicate_slot(atom)
        if adding and ANYTHING in atom.arguments:
            raise DomainError(
                f"an effect adds {atom.predicate} with ANYTHING, which is for deletions only: name an object"
            )
        if len(atom.arguments) == 2:
            return self._compile_relation_change(atom, predicate_slot, scope, adding=adding)
        if len(atom.arguments) > 2:
            return self._compile_tuple_set_change(atom, predicate_slot, scope, adding=adding)
        if not atom.arguments or atom.arguments[0] == ANYTHING:
            return lambda before, draft, binding: draft.set_objects_of_unary_predicate(
                predicate_slot, int(adding)
            )
        slot = self._frame.find_slot(atom.arguments[0], scope)
        return lambda before, draft, binding: draft.set_unary_fact(predicate_slot, binding[slot], adding)

    def _compile_relation_change(
        self, atom: Atom, predicate_slot: int, scope: SlotByVariable, *, adding: bool
    ) -> Apply:
        left, right = atom.arguments
        if left == right == ANYTHING:
            return lambda before, draft, binding: draft.remove_all_pairs(predicate_slot)
        if left == ANYTHING:
            target = self._frame.find_slot(right, scope)
            return lambda before, draft, binding: draft.remove_pairs_with_target(
                predicate_slot, binding[target]
            )
        source = self._frame.find_slot(left, scope)
        if right == ANYTHING:
            return lambda before, draft, binding: draft.set_targets_in_relation(
                predicate_slot, binding[source], 0
            )
        target = self._frame.find_slot(right, scope)
        return lambda before, draft, binding: draft.set_binary_fact(
            predicate_slot, binding[source], binding[target], adding
        )

    def _compile_tuple_set_change(
        self, atom: Atom, predicate_slot: int, scope: SlotByVariable, *, adding: bool
    ) -> Apply:
        slots = [None if t == ANYTHING else self._frame.find_slot(t, scope) for t in atom.arguments]
        if adding:
            bound = [slot for slot in slots if slot is not None]
            return lambda before, draft, binding: draft.add_argument_tuple(
                predicate_slot, tuple([binding[s] for s in bound])
            )
        return lambda before, draft, binding: draft.remove_matching_tuples(
            predicate_slot, tuple([None if s is None else binding[s] for s in slots])
        )

    def _find_predicate_slot(self, atom: Atom) -> int:
        self._vocabulary.require_arity(atom.predicate, len(atom.arguments))
        predicate = self._vocabulary.find_stored_predicate(atom.predicate)
        if predicate is None:
            raise DomainError(
                f"an effect changes {atom.predicate}, which is derived: change the predicates that define it"
            )
        if predicate.static:
            raise DomainError(
                f"an effect changes {atom.predicate}, which is declared static: declare it with static=False"
            )
        return self._vocabulary.map_predicates_of_arity_to_state_slots(predicate.arity)[predicate.name]
