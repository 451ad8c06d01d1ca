"""Convert the ordered effects of a declared operator to effects of PDDL, which all take place at once.

The engine makes changes one after the other, and a later change overrides an earlier one. In PDDL an addition
wins over a deletion. So a converted addition takes place only if no later deletion of its atom takes place.
Nothing else depends on the order. Both formalisms evaluate conditions in the state before all effects.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

from typing_extensions import assert_never

import eai.logic.formula as f
import eai.pddl.model as m
from eai.base.errors import DomainError
from eai.logic.traversal import wrap_in_quantifiers
from eai.pddl import glossary as g
from eai.world.derived import DefinedPredicate
from eai.world.effect import ANYTHING, Add, Delete, Effect, ForEach, Let, When
from eai.world.operator import Operator
from eai.world.vocabulary import Predicate, Vocabulary

_EffectPosition: TypeAlias = "tuple[int | f.Variable, ...]"
"""Position of an addition or deletion in the order of an operator's effects.

It has an index for each enclosing sequence, and a variable for each enclosing loop over objects.
"""


@dataclass(frozen=True, slots=True)
class _AtomChange:
    """One addition or deletion, with PDDL names.

    Attributes:
        adds: whether the atom becomes true.
        atom: the atom.
        variables: the change happens for all values of these variables that satisfy the condition.
        condition: the condition of the change.
        position: the position of the change in the order of effects.
    """

    adds: bool
    atom: f.Atom
    variables: tuple[f.Variable, ...]
    condition: f.Formula
    position: _EffectPosition


@dataclass(frozen=True, slots=True)
class _NestedEffectContext:
    """The context of an effect: the terms that replace variables, and the conditions of enclosing effects."""

    scope: g.TermScope
    variables: tuple[f.Variable, ...] = ()
    condition: f.Formula = f.TRUE
    position: _EffectPosition = ()

    def add_condition(self, condition: f.Formula) -> _NestedEffectContext:
        return replace(self, condition=g.conjoin((self.condition, condition)))

    def extend_effect_position(self, *index_or_variable: int | f.Variable) -> _NestedEffectContext:
        return replace(self, position=(*self.position, *index_or_variable))


def convert_to_simultaneous_effect(
    operator: Operator, conditions: g.ConditionWriter, scope: g.TermScope, hidden: frozenset[str]
) -> m.PddlEffect:
    """Return the ordered effects of an operator and its alternatives as one simultaneous effect of PDDL.

    Args:
        operator: the operator.
        conditions: the writer of the operator's conditions.
        scope: mapping from the operator's parameters to their PDDL variables.
        hidden: predicates that the export leaves out.
    """
    return _OrderedToSimultaneousEffectsConverter(conditions, scope, hidden).convert_effects(operator)


class _OrderedToSimultaneousEffectsConverter:
    """Converts the ordered effects of one operator to an equivalent simultaneous effect of PDDL."""

    def __init__(self, conditions: g.ConditionWriter, scope: g.TermScope, hidden: frozenset[str]) -> None:
        self._conditions = conditions
        self._vocabulary = conditions.glossary.vocabulary
        self._scope = scope
        self._hidden = hidden

    def convert_effects(self, operator: Operator) -> m.PddlEffect:
        start = _NestedEffectContext(self._scope)
        changes: list[_AtomChange] = []
        for number, attempt in enumerate(operator.alternatives):
            inside = start.add_condition(
                self._convert_effect_condition_to_pddl(f.And(attempt.conditions), start)
            ).extend_effect_position(number)
            changes += self._convert_sequence(attempt.effects, inside)
        changes += self._convert_sequence(
            operator.effects, start.extend_effect_position(len(operator.alternatives))
        )
        parts = [part for change in changes for part in self._write_change_unless_overridden(change, changes)]
        return parts[0] if len(parts) == 1 else m.AndEffect(tuple(parts))

    def _convert_sequence(
        self, effects: Iterable[Effect], context: _NestedEffectContext
    ) -> Iterator[_AtomChange]:
        for number, effect in enumerate(effects):
            yield from self._convert_effect(effect, context.extend_effect_position(number))

    def _convert_effect(self, effect: Effect, context: _NestedEffectContext) -> Iterator[_AtomChange]:
        match effect:
            case Add(atom) | Delete(atom):
                if atom.predicate not in self._hidden:
                    yield self._make_atom_change(atom, context, adds=isinstance(effect, Add))
            case When(condition, effects, otherwise):
                read = self._convert_effect_condition_to_pddl(condition, context)
                yield from self._convert_sequence(
                    effects, context.add_condition(read).extend_effect_position(0)
                )
                yield from self._convert_sequence(
                    otherwise, context.add_condition(g.negate(read)).extend_effect_position(1)
                )
            case ForEach(variable, condition, effects):
                bound, inside = self._bind_variable(variable, context)
                matched = inside.add_condition(self._convert_effect_condition_to_pddl(condition, inside))
                for number, each in enumerate(effects):
                    yield from self._convert_effect(each, matched.extend_effect_position(number, bound))
            case Let(variable, condition, effects):
                bound, inside = self._bind_variable(variable, context)
                first = self._make_condition_that_object_is_first_match(variable, condition, bound, inside)
                yield from self._convert_sequence(effects, inside.add_condition(first))
            case _:
                assert_never(effect)

    def _bind_variable(
        self, variable: f.Variable, context: _NestedEffectContext
    ) -> tuple[f.Variable, _NestedEffectContext]:
        bound = self._conditions.make_unused_variable(variable.name)
        scope = {**context.scope, variable.name: bound}
        return bound, replace(context, scope=scope, variables=(*context.variables, bound))

    def _convert_effect_condition_to_pddl(
        self, condition: f.Formula, context: _NestedEffectContext
    ) -> f.Formula:
        """Return the PDDL condition of an effect; literals that the export leaves out count as false."""
        return self._conditions.convert_formula_to_pddl(
            g.remove_hidden_predicates(condition, self._hidden, weaken=False), context.scope
        )

    def _make_condition_that_object_is_first_match(
        self,
        variable: f.Variable,
        condition: f.Formula,
        pddl_variable: f.Variable,
        context: _NestedEffectContext,
    ) -> f.Formula:
        """Return the condition that ``condition`` holds for a variable, but for no object of lower index."""
        meets = self._convert_effect_condition_to_pddl(condition, context)
        if holds_for_at_most_one_value(condition, variable, self._vocabulary):
            return meets
        other = self._conditions.make_unused_variable(variable.name)
        as_well = self._convert_effect_condition_to_pddl(
            condition, replace(context, scope={**context.scope, variable.name: other})
        )
        earlier = g.conjoin((self._conditions.glossary.make_precedes_atom(other, pddl_variable), as_well))
        return g.conjoin((meets, g.negate(f.Exists(other, earlier))))

    def _make_atom_change(self, atom: f.Atom, context: _NestedEffectContext, *, adds: bool) -> _AtomChange:
        """Return the change that an effect makes to an atom. The argument `ANYTHING` means all objects."""
        stored = self._vocabulary.find_stored_predicate(atom.predicate)
        if stored is None:
            raise DomainError(
                f"an effect changes {atom.predicate}, which is not a stored predicate: declare it, or change "
                "the predicates that define it"
            )
        variables = list(context.variables)
        terms: list[f.Term] = []
        for term in atom.arguments:
            if term == ANYTHING:
                variables.append(self._conditions.make_unused_variable("other"))
                terms.append(variables[-1])
            else:
                terms.append(self._conditions.convert_term_to_pddl(term, context.scope))
        written = f.Atom(self._conditions.glossary.register_predicate(atom.predicate), tuple(terms))
        return _AtomChange(adds, written, tuple(variables), context.condition, context.position)

    def _write_change_unless_overridden(
        self, change: _AtomChange, all_changes: Sequence[_AtomChange]
    ) -> Iterator[m.PddlEffect]:
        condition = change.condition
        if change.adds:
            undone = [
                self._make_condition_that_deletion_undoes_addition(change, other)
                for other in all_changes
                if not other.adds
            ]
            condition = g.conjoin((condition, *map(g.negate, undone)))
        if condition == f.FALSE:
            return
        effect: m.PddlEffect = m.Add(change.atom) if change.adds else m.Delete(change.atom)
        if condition != f.TRUE:
            effect = m.WhenEffect(condition, effect)
        yield wrap_in_quantifiers(m.ForAllEffect, change.variables, effect)

    def _make_condition_that_deletion_undoes_addition(
        self, addition: _AtomChange, deletion: _AtomChange
    ) -> f.Formula:
        """Return the condition under which a later deletion removes an added atom."""
        if addition.atom.predicate != deletion.atom.predicate:
            return f.FALSE
        terms: dict[str, f.Term] = {}
        own = {variable.name for variable in deletion.variables}
        same: list[f.Formula] = []
        for added, deleted in zip(addition.atom.arguments, deletion.atom.arguments, strict=True):
            if isinstance(deleted, f.Variable) and deleted.name in own and deleted.name not in terms:
                terms[deleted.name] = added
            else:
                same.append(g.make_equality(g.replace_variable(deleted, terms), added))
        rest = [variable.name for variable in deletion.variables if variable.name not in terms]
        still_open = {name: self._conditions.make_unused_variable(name) for name in rest}
        terms |= still_open
        later = self._make_condition_that_deletion_is_later(addition.position, deletion.position, terms)
        undoing = g.conjoin((*same, later, g.replace_variables(deletion.condition, terms)))
        if g.conjoin((addition.condition, undoing)) == f.FALSE:  # their conditions exclude each other
            return f.FALSE
        for variable in reversed(still_open.values()):
            undoing = undoing if undoing in (f.TRUE, f.FALSE) else f.Exists(variable, undoing)
        return undoing

    def _make_condition_that_deletion_is_later(
        self, addition: _EffectPosition, deletion: _EffectPosition, terms: g.TermScope
    ) -> f.Formula:
        """Return the condition under which a deletion comes after an addition in the order of effects.

        `terms` replace the variables of the deletion.
        """
        for depth, (mine, other) in enumerate(zip(addition, deletion, strict=False)):
            if isinstance(mine, f.Variable) and isinstance(other, f.Variable):
                theirs = terms.get(other.name, other)
                rest = self._make_condition_that_deletion_is_later(
                    addition[depth + 1 :], deletion[depth + 1 :], terms
                )
                if theirs == mine:
                    return rest
                precedes = self._conditions.glossary.make_precedes_atom(mine, theirs)
                return g.disjoin((precedes, g.conjoin((f.Equals(mine, theirs), rest))))
            if isinstance(mine, int) and isinstance(other, int) and mine != other:
                return f.TRUE if mine < other else f.FALSE
        return f.FALSE


def holds_for_at_most_one_value(condition: f.Formula, variable: f.Variable, vocabulary: Vocabulary) -> bool:
    """Whether at most one value of a variable can satisfy a condition, because of the condition's form."""
    match condition:
        case f.And(operands):
            return any(holds_for_at_most_one_value(operand, variable, vocabulary) for operand in operands)
        case f.Equals(left, right):
            return (left == f.Variable(variable.name)) != (right == f.Variable(variable.name))
        case f.Atom(predicate, (*others, last)) if last == f.Variable(variable.name) and last not in others:
            declared = vocabulary.find_stored_predicate(predicate) or vocabulary.derived_by_name.get(
                predicate
            )
            match declared:
                case DefinedPredicate(parameters=parameters, definition=definition):
                    return holds_for_at_most_one_value(definition, parameters[-1], vocabulary)
                case Predicate(single=single):
                    return single
                case _:
                    return getattr(declared, "single", False)
        case _:
            return False
