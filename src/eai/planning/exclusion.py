"""Exclusion: proofs, from the declaration of a domain, that no state of an episode meets some literals.

Two facts exclude each other under two conditions. First, they do not both hold at the start. Second, every
action that adds one fact deletes the other, or needs a fact that excludes the other. Pairs of facts are
proved together, by induction over the actions of an episode: a pair is assumed to be exclusive until its
proof fails. If a proof fails, it is unknown whether the facts exclude each other.

A proof holds for all objects that have the same properties. So each pair is proved once a domain, with
variables for its objects. Later episodes look the result up: they compare only the properties that the
proof used.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import lru_cache
from typing import NamedTuple, TypeAlias

import eai.logic.formula as f
from eai.logic.traversal import find_object_names, find_predicates
from eai.planning.effect_schema import (
    EffectSchema,
    find_changed_predicates,
    find_predicates_with_incomplete_schemas,
    make_effect_schemas,
    match_atom,
)
from eai.planning.subgoal import GroundAtom, find_object
from eai.world.derived import find_definition, find_stored_dependencies
from eai.world.domain import Domain
from eai.world.effect import ANYTHING
from eai.world.state import State

_MAX_PAIRS = 64
"""Maximum number of pairs of facts in a proof of exclusion. Further pairs count as not exclusive."""

_MAX_CACHED_ANSWERS = 4096
"""Maximum number of cached answers to whether facts hold in the initial state of one episode."""

_MAX_CACHED_MUTUAL_EXCLUSION_PROOFS = 64
"""Maximum number of cached proofs of whether two facts exclude each other.

Pairs of facts that differ only in their objects have common proofs.
"""

_PASSES = 2
"""Number of passes over conditions that are tested for a contradiction.

The second pass uses the facts that followed from later conditions in the first pass.
"""

_FactArgument: TypeAlias = int | str | None
"""Argument of a fact: an object by index, an unknown object by a name, or None for any object."""

_ArgumentScope: TypeAlias = Mapping[str, _FactArgument]


class _FactPattern(NamedTuple):
    """A fact of a stored predicate; an argument that is None matches any object.

    If ``is_membership`` is true, the predicate is a category, and the fact is that an object belongs to it.
    """

    predicate: str
    arguments: tuple[_FactArgument, ...]
    is_membership: bool = False


_Facts: TypeAlias = tuple[_FactPattern, ...]
"""Facts that a proof examines together. Each argument is a known object, or None for any object."""


class _CachedMutualExclusionProof(NamedTuple):
    """The result of a proof of whether two facts exclude each other. Other episodes may use it.

    Attributes:
        answers: questions about the initial state that the proof asked, with their answers. A question is a
            tuple of facts: do all of them hold? Numbers stand for the objects. The result is valid in every
            episode in which the questions have the same answers.
        is_exclusive: whether it is proved that the facts exclude each other.
    """

    answers: tuple[tuple[_Facts, bool], ...]
    is_exclusive: bool


class _FormulaWithRequiredTruth(NamedTuple):
    """A formula that must be true, or must be false if ``truth`` is False.

    Attributes:
        unfolded: derived predicates whose definitions contain the formula; they are not replaced by their
            definitions again.
    """

    formula: f.Formula
    scope: _ArgumentScope
    truth: bool = True
    unfolded: frozenset[str] = frozenset()


class MutualExclusionRules:
    """The rules by which facts exclude each other in a domain, for any initial state."""

    def __init__(self, domain: Domain) -> None:
        self.vocabulary = domain.vocabulary
        self.effects = {o.name: tuple(make_effect_schemas(o)) for o in domain.operators}
        self.single = {p.name for p in domain.vocabulary.predicates if p.single}
        self.changed = {name for o in domain.operators for name in find_changed_predicates(o)}
        self.unread = {name for o in domain.operators for name in find_predicates_with_incomplete_schemas(o)}
        self.rivals = self._map_to_possibly_exclusive_predicates(domain)
        self.constants = self._find_constants(domain)
        self.cached_proofs: dict[tuple[_Facts, tuple[int, ...]], list[_CachedMutualExclusionProof]] = {}

    def make_mutual_exclusion_prover(self, initial: State) -> _MutualExclusionProver:
        """Return the object that proves which facts exclude each other in episodes from an initial state."""
        return _MutualExclusionProver(self, initial)

    def _map_to_possibly_exclusive_predicates(self, domain: Domain) -> dict[str, set[str]]:
        """Return, for each predicate, the predicates whose facts may exclude its facts.

        Two predicates are such a pair if an operator adds facts of one, and deletes or reads facts of the
        other.
        """
        rivals: dict[str, set[str]] = {}
        for operator in domain.operators:
            effects = self.effects[operator.name]
            formulas = [c.condition for c in operator.checks] + [g for e in effects for g in e.conditions]
            denied = {*find_stored_dependencies(find_predicates(*formulas), domain.vocabulary)}
            denied |= {effect.atom.predicate for effect in effects if not effect.adds}
            for added in {effect.atom.predicate for effect in effects if effect.adds}:
                for predicate in denied:
                    rivals.setdefault(added, set()).add(predicate)
                    rivals.setdefault(predicate, set()).add(added)
        return rivals

    def _find_constants(self, domain: Domain) -> list[f.Constant]:
        schemas = [schema for schemas in self.effects.values() for schema in schemas]
        definitions = [find_definition(derived) for derived in domain.vocabulary.derived]
        formulas = [
            *[check.condition for operator in domain.operators for check in operator.checks],
            *[formula for schema in schemas for formula in (schema.atom, *schema.conditions)],
            *[defined.definition for defined in definitions if defined is not None],
        ]
        names = dict.fromkeys([name for formula in formulas for name in find_object_names(formula)])
        return [f.Constant(name) for name in names]


class _MutualExclusionProver:
    """Proves that no state of one episode meets given literals.

    Args:
        rules: the rules by which facts exclude each other in the domain.
        initial: the initial state of the episode.
    """

    def __init__(self, rules: MutualExclusionRules, initial: State) -> None:
        self.rules = rules
        self.index = {constant: find_object(constant, initial.scene) for constant in rules.constants}
        self.are_true_at_start = lru_cache(_MAX_CACHED_ANSWERS)(self._are_true_at_start_uncached)
        self.is_exclusive = lru_cache(_MAX_CACHED_ANSWERS)(self._are_facts_exclusive)
        self._initial = initial

    def are_exclusive(self, literals: Iterable[GroundAtom]) -> bool:
        """Whether it is proved that some literals do not all hold in any reachable state."""
        conditions = []
        for predicate, arguments, truth in literals:
            atom = f.Atom(predicate, tuple([f.Variable(str(i)) for i in arguments]))
            conditions.append(_FormulaWithRequiredTruth(atom, {str(i): i for i in arguments}, truth))
        return not _HypotheticalState(self, self.are_true_at_start, self.is_exclusive).may_hold_together(
            conditions
        )

    def _are_facts_exclusive(self, pair: _Facts) -> bool:
        """Whether it is proved that the two facts of a pair exclude each other in this episode."""
        arguments = [i for fact in pair for i in fact.arguments if isinstance(i, int)]
        objects = [*dict.fromkeys([*self.index.values(), *arguments])]
        numbers = {index: number for number, index in enumerate(objects)}
        constants = tuple([numbers[index] for index in self.index.values()])
        cached_proofs = self.rules.cached_proofs.setdefault(
            (_replace_object_indices(pair, numbers), constants), []
        )
        for cached_proof in tuple(cached_proofs):
            if all(
                self.are_true_at_start(_replace_object_indices(facts, objects)) is answer
                for facts, answer in cached_proof.answers
            ):
                return cached_proof.is_exclusive
        proof = _InductiveMutualExclusionProof(self)
        result = proof.proves_exclusive(pair)
        answers = [
            (_replace_object_indices(facts, numbers), answer) for facts, answer in proof.answers.items()
        ]
        cached_proofs.append(_CachedMutualExclusionProof(tuple(answers), result))
        del cached_proofs[:-_MAX_CACHED_MUTUAL_EXCLUSION_PROOFS]
        return result

    def _are_true_at_start_uncached(self, facts: _Facts) -> bool:
        return all(map(self._holds_at_start, facts))

    def _holds_at_start(self, fact: _FactPattern) -> bool:
        match fact:
            case _FactPattern(category, (int(index),), True):
                return bool(self._initial.scene.get_category_mask(category) >> index & 1)
            case _FactPattern(predicate, (None,)):
                return bool(self._initial.mask(predicate))
            case _FactPattern(predicate, (int(source), None)):
                return bool(self._initial.relation(predicate).row(source))
            case _FactPattern(predicate, (None, int(target))):
                return bool(self._initial.relation(predicate).column(target))
            case _FactPattern(predicate, (None, None)):
                return len(self._initial.relation(predicate)) > 0
            case _FactPattern(predicate, arguments) if None in arguments:
                members = self._initial.get_tuple_set(predicate).members
                return any(_matches_pattern(_FactPattern(predicate, member), fact) for member in members)
            case _:
                return self._initial.has(fact.predicate, *[i for i in fact.arguments if isinstance(i, int)])

    def resolve_term(self, term: f.Term, scope: _ArgumentScope) -> _FactArgument:
        """Return the object of a term: its index, the name of an unknown object, or None for any object."""
        return scope.get(term.name) if isinstance(term, f.Variable) else self.index[term]


class _InductiveMutualExclusionProof:
    """A proof by induction that two facts never hold together (are exclusive).

    The proof may need other pairs of facts to be exclusive. It assumes so until the proof of a pair fails.
    These assumptions are not shared with other proofs. So no result depends on earlier proofs, and several
    threads may prove at once.

    Args:
        prover: the prover of the episode, which holds the rules and the initial facts.

    Attributes:
        answers: tuples of facts that the proof tested, each with whether all its facts hold at the start.
    """

    def __init__(self, prover: _MutualExclusionProver) -> None:
        self.answers: dict[_Facts, bool] = {}
        self._prover = prover
        self._failed: set[_Facts] = set()
        self._pending: dict[_Facts, None] = {}
        self._dependents: dict[_Facts, dict[_Facts, None]] = {}

    def proves_exclusive(self, pair: _Facts) -> bool:
        """Whether it is proved that no state of the episode has both facts.

        A pair of facts is assumed to be exclusive when it is first needed. If an action breaks the
        assumption, the assumption is given up, and all pairs whose proofs used the assumption are examined
        again.
        """
        self._judged = pair
        self._is_assumed_exclusive(pair)
        while self._pending and pair not in self._failed:
            self._judged = next(iter(self._pending))
            del self._pending[self._judged]
            if not self._is_exclusion_true_at_start_and_kept(*self._judged):
                self._failed.add(self._judged)
                dependents = self._dependents[self._judged]
                self._pending |= {other: None for other in dependents if other not in self._failed}
        return pair not in self._failed

    def _is_assumed_exclusive(self, pair: _Facts) -> bool:
        if pair not in self._dependents:
            if len(self._dependents) >= _MAX_PAIRS:
                return False
            self._dependents[pair] = {}
            self._pending[pair] = None
        self._dependents[pair][self._judged] = None
        return pair not in self._failed

    def _are_true_at_start(self, facts: _Facts) -> bool:
        if facts not in self.answers:
            self.answers[facts] = self._prover.are_true_at_start(facts)
        return self.answers[facts]

    def _is_exclusion_true_at_start_and_kept(self, one: _FactPattern, other: _FactPattern) -> bool:
        """Whether two facts do not both hold in the initial state, and no action makes both true."""
        rules = self._prover.rules
        if rules.unread & {one.predicate, other.predicate} or self._are_true_at_start((one, other)):
            return False
        return all(
            self._keeps_other_fact_false(schema, added, other_fact)
            for added, other_fact in ((one, other), (other, one))
            for schemas in rules.effects.values()
            for schema in schemas
            if schema.adds and schema.atom.predicate == added.predicate
        )

    def _keeps_other_fact_false(
        self, schema: EffectSchema, added_fact: _FactPattern, other_fact: _FactPattern
    ) -> bool:
        """Whether an effect that adds one fact guarantees that the other fact is false afterwards."""
        scope: dict[str, _FactArgument] | None = match_atom(
            schema.atom, added_fact.arguments, self._prover.index.__getitem__
        )
        if scope is None:
            return True
        full = {**{name: f"{name}?" for name in schema.variables}, **scope}
        terms = [f"{i}?" if argument is None else argument for i, argument in enumerate(other_fact.arguments)]
        instance = other_fact._replace(arguments=tuple(terms))
        effects = self._prover.rules.effects[schema.operator.name]
        is_deleted = any(
            self._deletes_fact_whenever_other_effect_happens(effect, schema, instance, full)
            for effect in effects
        )
        if not is_deleted and self._may_effects_happen_together([(schema, full)], instance):
            return False
        return not any(
            self._may_add_both_facts(schema, scope, effect, other_fact)
            for effect in effects
            if effect.adds and effect.atom.predicate == other_fact.predicate
        )

    def _may_add_both_facts(
        self,
        first: EffectSchema,
        first_scope: _ArgumentScope,
        second: EffectSchema,
        second_fact: _FactPattern,
    ) -> bool:
        parameters = [p.name for p in first.operator.parameters]
        bound = {name: first_scope[name] for name in parameters if name in first_scope}
        second_scope: dict[str, _FactArgument] | None = match_atom(
            second.atom, second_fact.arguments, self._prover.index.__getitem__, bound
        )
        if second_scope is None:
            return False
        shared = {name: second_scope.get(name, f"{name}?") for name in parameters}
        first_full = {**{name: f"{name}?" for name in first.variables}, **first_scope, **shared}
        second_full = {**{name: f"{name}??" for name in second.variables}, **second_scope, **shared}
        return self._may_effects_happen_together([(first, first_full), (second, second_full)])

    def _may_effects_happen_together(
        self, effects: Iterable[tuple[EffectSchema, _ArgumentScope]], *facts_before_action: _FactPattern
    ) -> bool:
        """Whether effects of one action may happen together in a state with ``facts_before_action``.

        The action's checks must pass in the state, and the conditions of all these effects must hold.
        """
        return _HypotheticalState(
            self._prover, self._are_true_at_start, self._is_assumed_exclusive, *facts_before_action
        ).may_hold_together(
            [
                _FormulaWithRequiredTruth(formula, scope)
                for schema, scope in effects
                for formula in (*schema.conditions, *[check.condition for check in schema.operator.checks])
            ]
        )

    def _deletes_fact_whenever_other_effect_happens(
        self,
        effect: EffectSchema,
        other_effect: EffectSchema,
        fact: _FactPattern,
        scope: _ArgumentScope,
    ) -> bool:
        """Whether an effect deletes a fact in all cases in which another effect of its operator happens."""
        own_checks = len(effect.operator.checks)
        return (
            not effect.adds
            and effect.atom.predicate == fact.predicate
            and {*effect.conditions} <= {*other_effect.conditions}
            and {*effect.checks[own_checks:]} <= {*other_effect.checks[own_checks:]}
            and effect.read_variables <= other_effect.read_variables
            and all(
                term == ANYTHING or self._prover.resolve_term(term, scope) == argument
                for term, argument in zip(effect.atom.arguments, fact.arguments, strict=True)
            )
        )


class _HypotheticalState:
    """A hypothetical state for a proof by contradiction: assumed facts, and their immediate consequences.

    Args:
        prover: the prover of the episode.
        are_true_at_start: function that returns whether all of some facts hold in the initial state.
        are_exclusive: whether a pair of facts is exclusive, by a proof or by assumption.
        facts: the facts that are assumed to hold.
    """

    def __init__(
        self,
        prover: _MutualExclusionProver,
        are_true_at_start: Callable[[_Facts], bool],
        are_exclusive: Callable[[_Facts], bool],
        *facts: _FactPattern,
    ) -> None:
        self._prover = prover
        self._are_true_at_start = are_true_at_start
        self._are_exclusive = are_exclusive
        self._true = {fact: _replace_unknown_objects_by_none(fact) for fact in facts}
        self._false: list[_FactPattern] = []
        self._unknown = 0

    def may_hold_together(self, conditions: Sequence[_FormulaWithRequiredTruth]) -> bool:
        """Return False if it is proved that no state meets all conditions.

        The conditions are assumed, so that a contradiction between their consequences can be found.
        """
        # A second pass, because facts that follow from a later condition may contradict an earlier one.
        return all(
            self._assume_and_check_consistency(condition) for _ in range(_PASSES) for condition in conditions
        )

    def _is_impossible(self, condition: _FormulaWithRequiredTruth) -> bool:
        """Whether no objects can meet a condition. A variable with the value None stands for any object."""
        formula, scope, truth, _ = condition
        fact = self._convert_non_derived_atom_to_fact_pattern(condition)
        if fact is not None:
            return self._is_truth_value_of_fact_impossible(fact, truth=truth)
        if isinstance(formula, f.Equals):
            one, other = [self._prover.resolve_term(term, scope) for term in (formula.left, formula.right)]
            if isinstance(one, int) and isinstance(other, int):
                return (one == other) is not truth
            return not truth and one == other and one is not None
        are_all_needed, parts = self._split_into_conjuncts_or_disjuncts(condition)
        return (any if are_all_needed else all)(map(self._is_impossible, parts))

    def _assume_and_check_consistency(self, condition: _FormulaWithRequiredTruth) -> bool:
        """Assume a condition, and record its consequences. Return False if they contradict known facts."""
        are_all_needed, parts = self._split_into_conjuncts_or_disjuncts(
            condition, is_formula_assumed_true=True
        )
        if are_all_needed and parts and not isinstance(condition.formula, f.Exists | f.ForAll):
            return all(map(self._assume_and_check_consistency, parts))
        if self._is_impossible(condition):
            return False
        if self._is_impossible(condition._replace(truth=not condition.truth)):
            return True
        fact = self._convert_non_derived_atom_to_fact_pattern(condition)
        if fact is not None:
            return self._add_fact_and_check_consistency(fact, truth=condition.truth)
        if not are_all_needed:
            parts = [part for part in parts if not self._is_impossible(part)]
        return (not are_all_needed and len(parts) > 1) or all(map(self._assume_and_check_consistency, parts))

    def _split_into_conjuncts_or_disjuncts(
        self, condition: _FormulaWithRequiredTruth, *, is_formula_assumed_true: bool = False
    ) -> tuple[bool, Sequence[_FormulaWithRequiredTruth]]:
        """Return whether all parts of a condition must be met, or only one part, and the parts.

        A condition that cannot be split has no parts.
        """
        formula, scope, truth, unfolded = condition
        match formula:
            case f.Atom(predicate, terms) if predicate not in unfolded:
                derived = self._prover.rules.vocabulary.derived_by_name.get(predicate)
                defined = None if derived is None else find_definition(derived)
                if defined is not None:
                    arguments = [self._prover.resolve_term(term, scope) for term in terms]
                    inner = dict(zip([p.name for p in defined.parameters], arguments, strict=True))
                    return True, [
                        _FormulaWithRequiredTruth(defined.definition, inner, truth, unfolded | {predicate})
                    ]
            case f.Not(operand):
                return True, [_FormulaWithRequiredTruth(operand, scope, not truth, unfolded)]
            case f.And(operands) | f.Or(operands):
                parts = [_FormulaWithRequiredTruth(operand, scope, truth, unfolded) for operand in operands]
                return isinstance(formula, f.And) is truth, parts
            case f.Implies(premise, conclusion):
                either = (
                    _FormulaWithRequiredTruth(premise, scope, not truth, unfolded),
                    _FormulaWithRequiredTruth(conclusion, scope, truth, unfolded),
                )
                return not truth, either
            case f.Exists(variable, body) | f.ForAll(variable, body):
                is_existential = isinstance(formula, f.Exists) is truth
                return True, [
                    _FormulaWithRequiredTruth(body, {**scope, variable.name: term}, truth, unfolded)
                    for term in self._list_values_to_instantiate_quantifier(
                        variable,
                        scope,
                        is_existential=is_existential,
                        is_formula_assumed_true=is_formula_assumed_true,
                    )
                ]
        return True, ()

    def _list_values_to_instantiate_quantifier(
        self,
        variable: f.Variable,
        scope: _ArgumentScope,
        *,
        is_existential: bool,
        is_formula_assumed_true: bool,
    ) -> list[_FactArgument]:
        """Return the values of a variable for which the body of its quantified formula is examined.

        A value is an object, the name of an unknown object, or None. None stands for any object.

        If the formula is assumed to be true, its body is true for each returned value:

        - Existential formula: a name for the unknown object for which the body is true. There is no value if
          an outer variable is None, because each of its objects may need another unknown object.
        - Universal formula: None, because the body is true for any object. There is no value if the variable
          has a category, because the body may be false for other objects.

        Otherwise the formula is impossible if its body is impossible for one returned value:

        - Existential formula: None, because the body must be impossible for any object.
        - Universal formula: the objects in the assumed facts that belong to the variable's category.
        """
        if is_existential and is_formula_assumed_true:
            self._unknown += 1
            # If an outer variable is None (any object), each of its objects may need another object here.
            return [] if None in scope.values() else [f"{self._unknown}"]
        if is_existential or is_formula_assumed_true:
            return [None] if is_existential or variable.category is None else []
        objects = dict.fromkeys(i for fact in self._true for i in fact.arguments)
        if variable.category is None:
            return [*objects]
        members = [_FactPattern(variable.category, (i,), True) for i in objects if isinstance(i, int)]
        return [member.arguments[0] for member in members if self._are_true_at_start((member,))]

    def _convert_non_derived_atom_to_fact_pattern(
        self, condition: _FormulaWithRequiredTruth
    ) -> _FactPattern | None:
        """Return the fact of a condition that is an atom of a stored predicate; None for other conditions."""
        match condition.formula:
            case f.Atom(predicate, terms) if predicate not in self._prover.rules.vocabulary.derived_by_name:
                arguments = [self._prover.resolve_term(term, condition.scope) for term in terms]
                return _FactPattern(predicate, tuple(arguments))
            case _:
                return None

    def _add_fact_and_check_consistency(self, fact: _FactPattern, *, truth: bool) -> bool:
        if not truth:
            self._false.append(fact)
            return not any(_matches_pattern(known_fact, fact) for known_fact in self._true)
        if None not in fact.arguments:
            self._true[fact] = _replace_unknown_objects_by_none(fact)
        return True

    def _is_truth_value_of_fact_impossible(self, fact: _FactPattern, *, truth: bool) -> bool:
        """Whether a fact is proved false; if ``truth`` is False, whether it is proved true.

        An argument that is None stands for any object. The proof then holds for all objects.
        """
        rules, general = self._prover.rules, _replace_unknown_objects_by_none(fact)
        if fact in self._true:
            return not truth
        if fact.predicate not in rules.changed:
            return (truth or (general == fact and None not in fact.arguments)) and (
                self._are_true_at_start((general,)) is not truth
            )
        return truth and (
            any(_matches_pattern(fact, other) for other in self._false)
            or any(self._are_mutually_exclusive(general, other) for other in self._true.values())
        )

    def _are_mutually_exclusive(self, one: _FactPattern, other: _FactPattern) -> bool:
        """Whether two facts without unknown objects exclude each other."""
        rules = self._prover.rules
        if one.predicate == other.predicate:
            different = one != other and None not in one.arguments + other.arguments
            if different and one.predicate in rules.single and one.arguments[:-1] == other.arguments[:-1]:
                return True
        elif {*one.arguments}.isdisjoint({*other.arguments} - {None}):
            return False
        if other.predicate not in rules.rivals.get(one.predicate, ()):
            return False
        if _matches_pattern(one, other) or _matches_pattern(other, one):
            return False
        return self._are_exclusive(tuple(sorted((one, other), key=str)))


def _replace_unknown_objects_by_none(fact: _FactPattern) -> _FactPattern:
    """Return a fact in which None (any object) replaces each name for an unknown object."""
    return _FactPattern(fact.predicate, tuple([i if isinstance(i, int) else None for i in fact.arguments]))


def _matches_pattern(fact: _FactPattern, pattern: _FactPattern) -> bool:
    return fact.predicate == pattern.predicate and all(
        expected in (None, argument)
        for expected, argument in zip(pattern.arguments, fact.arguments, strict=True)
    )


def _replace_object_indices(facts: _Facts, new_indices: Mapping[int, int] | Sequence[int]) -> _Facts:
    return tuple(
        [
            fact._replace(
                arguments=tuple([new_indices[i] if isinstance(i, int) else i for i in fact.arguments])
            )
            for fact in facts
        ]
    )
