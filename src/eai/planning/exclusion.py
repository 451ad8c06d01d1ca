"""Exclusion: proofs, from the declaration of a domain, that no state of an episode meets some literals.

Two facts exclude each other under two conditions. First, they do not both hold at the start. Second, every
action that adds one fact deletes the other, or needs a fact that excludes the other. Pairs of facts are
proved together, by induction over the actions of an episode: a pair is assumed to be exclusive until its
proof fails. If a proof fails, it is unknown whether the facts exclude each other.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache
from typing import NamedTuple, TypeAlias

import eai.logic.formula as f
from eai.logic.traversal import find_predicates, walk_subformulas
from eai.planning.effect_schema import (
    EffectSchema,
    find_changed_predicates,
    find_predicates_without_schema,
    make_effect_schemas,
    match_atom,
)
from eai.planning.subgoal import GroundAtom, find_object
from eai.world.derived import find_definition, find_stored_predicates
from eai.world.domain import Domain
from eai.world.effect import ANYTHING
from eai.world.state import State
from eai.world.vocabulary import Vocabulary

_MAX_PAIRS = 64
"""Maximum number of pairs of facts in one proof; further pairs are assumed not to exclude each other."""

_MAX_CACHED_FACTS = 4096
"""Maximum number of cached answers to the question whether a fact holds in the initial state."""

_PASSES = 2
"""Number of passes over all conditions of a state. A pass may use facts found in earlier passes."""

_FactArgument: TypeAlias = int | str | None
"""Argument of a fact: an object by index, an unknown object by a name, or None for any object."""

_ArgumentScope: TypeAlias = Mapping[str, _FactArgument]


class _FactPattern(NamedTuple):
    """A fact of a stored predicate; an argument that is None matches any object."""

    predicate: str
    arguments: tuple[_FactArgument, ...]


_FactPair: TypeAlias = tuple[_FactPattern, _FactPattern]


class ExclusionRules:
    """The rules by which facts exclude each other in a domain, for any initial state."""

    def __init__(self, domain: Domain) -> None:
        self.vocabulary = domain.vocabulary
        self.effects = {o.name: tuple(make_effect_schemas(o)) for o in domain.operators}
        self.single = {p.name for p in domain.vocabulary.predicates if p.single}
        self.changed = {name for o in domain.operators for name in find_changed_predicates(o)}
        self.unread = {name for o in domain.operators for name in find_predicates_without_schema(o)}
        self.denying = self._find_possibly_excluding_predicates(domain)
        self.rivals = {p: self.denying.get(p, set()) | ({p} & self.single) for p in self.changed}

    def make_exclusion_prover(self, initial: State) -> _ExclusionProver:
        """Return the object that proves exclusions in the episode that begins in a state."""
        return _ExclusionProver(self, initial)

    def _find_possibly_excluding_predicates(self, domain: Domain) -> dict[str, set[str]]:
        """Return a mapping from each predicate to the predicates whose facts may exclude its facts.

        Predicate p is in the set of q, and q in the set of p, if an operator adds facts of p and either
        deletes facts of q or has negated conditions on q.
        """
        rivals: dict[str, set[str]] = {}
        for operator in domain.operators:
            effects = self.effects[operator.name]
            added = {effect.atom.predicate for effect in effects if effect.adds}
            formulas = [c.condition for c in operator.checks] + [g for e in effects for g in e.conditions]
            denied = {effect.atom.predicate for effect in effects if not effect.adds}
            denied |= _find_negated_predicates(formulas, domain.vocabulary)
            for added_predicate in added:
                for denied_predicate in denied:
                    rivals.setdefault(added_predicate, set()).add(denied_predicate)
                    rivals.setdefault(denied_predicate, set()).add(added_predicate)
        return rivals


class _ExclusionProver:
    """Proves that no state of one episode meets given literals.

    Args:
        rules: the rules by which facts exclude each other in the domain.
        initial: the initial state of the episode.
    """

    def __init__(self, rules: ExclusionRules, initial: State) -> None:
        self.rules = rules
        self.scene = initial.scene
        self.holds_at_start = lru_cache(_MAX_CACHED_FACTS)(self._holds_at_start)
        self._initial = initial

    def are_exclusive(self, literals: Iterable[GroundAtom]) -> bool:
        """Whether it is proved that some literals do not all hold in any reachable state."""
        conditions = []
        for literal in literals:
            variables = tuple([f.Variable(str(i)) for i in range(len(literal.arguments))])
            atom = f.Atom(literal.predicate, variables)
            scope = {v.name: i for v, i in zip(variables, literal.arguments, strict=True)}
            conditions.append((atom if literal.truth else f.Not(atom), scope))
        return _InductionProof(self).proves_exclusive(conditions)

    def _holds_at_start(self, fact: _FactPattern) -> bool:
        match fact:
            case _FactPattern(predicate, (None,)):
                return bool(self._initial.mask(predicate))
            case _FactPattern(predicate, (int(source), None)):
                return bool(self._initial.relation(predicate).row(source))
            case _FactPattern(predicate, (None, int(target))):
                return bool(self._initial.relation(predicate).column(target))
            case _FactPattern(predicate, (None, None)):
                return len(self._initial.relation(predicate)) > 0
            case _FactPattern(predicate, arguments) if None in arguments:
                members = self._initial.tuple_set(predicate).members
                return any(_matches_pattern(_FactPattern(predicate, member), fact) for member in members)
            case _:
                return self._initial.has(fact.predicate, *[i for i in fact.arguments if isinstance(i, int)])

    def match_atom_to_fact(
        self, atom: f.Atom, fact: _FactPattern, bound: _ArgumentScope
    ) -> dict[str, _FactArgument] | None:
        """Return a mapping from variables to objects that makes an effect's atom fit a fact, or None."""
        return match_atom(atom, fact.arguments, self.index, bound)

    def deletes_fact_whenever(
        self, effect: EffectSchema, other_effect: EffectSchema, fact: _FactPattern, scope: _ArgumentScope
    ) -> bool:
        """Whether an effect deletes a fact whenever another effect of the same operator takes place."""
        return (
            not effect.adds
            and effect.atom.predicate == fact.predicate
            and {*effect.conditions} <= {*other_effect.conditions}
            and all(
                term == ANYTHING or self.resolve_term(term, scope) == argument
                for term, argument in zip(effect.atom.arguments, fact.arguments, strict=True)
            )
        )

    def resolve_term(self, term: f.Term, scope: _ArgumentScope) -> _FactArgument:
        """Return the object of a term: an index, the name of an unknown object, or None for any object."""
        return scope.get(term.name) if isinstance(term, f.Variable) else self.index(term)

    def index(self, constant: f.Constant) -> int:
        """Return the index of the object that a constant names."""
        return find_object(constant, self.scene)


class _InductionProof:
    """A proof by induction for one question. Pairs of facts are assumed exclusive until a proof fails.

    Every question has its own pairs of facts. So no answer depends on earlier questions, and several threads
    may ask at once.

    Args:
        exclusion: the prover of the episode, which holds the rules and the initial facts.
    """

    def __init__(self, exclusion: _ExclusionProver) -> None:
        self.exclusion = exclusion
        self._assumed: dict[_FactPair, bool] = {}
        self._pending: dict[_FactPair, None] = {}
        self._dependents: dict[_FactPair, dict[_FactPair, None]] = {}
        self._judged: _FactPair | None = None

    def proves_exclusive(self, conditions: Sequence[tuple[f.Formula, _ArgumentScope]]) -> bool:
        """Whether it is proved that some conditions do not all hold in any state of the episode.

        A pair of facts is assumed to be exclusive when it is first needed. If an action breaks the
        assumption, the assumption is given up, and all pairs whose proofs used the assumption are examined
        again.
        """
        if _SupposedState(self).may_hold_together(conditions):
            return False
        while self._pending:
            pair = next(iter(self._pending))
            del self._pending[pair]
            self._judged = pair
            if not self._is_invariant_exclusion(*pair):
                self._assumed[pair] = False
                self._judged = None
                if _SupposedState(self).may_hold_together(conditions):
                    return False
                dependents = self._dependents.pop(pair, {})
                self._pending |= {dependent: None for dependent in dependents if self._assumed[dependent]}
        return True

    def are_exclusive(self, one: _FactPattern, other: _FactPattern) -> bool:
        """Whether two facts exclude each other, by the rules or by assumption.

        The facts have no unknown objects.
        """
        rules = self.exclusion.rules
        if one.predicate == other.predicate:
            different = one != other and None not in one.arguments + other.arguments
            if different and one.predicate in rules.single and one.arguments[:-1] == other.arguments[:-1]:
                return True
        elif {*one.arguments}.isdisjoint({*other.arguments} - {None}):
            return False
        same = _matches_pattern(one, other) or _matches_pattern(other, one)
        if same or other.predicate not in rules.denying.get(one.predicate, ()):
            return False
        return self._is_assumed(
            (one, other) if _make_fact_sort_key(one) < _make_fact_sort_key(other) else (other, one)
        )

    def _is_assumed(self, pair: _FactPair) -> bool:
        if pair not in self._assumed:
            self._assumed[pair] = len(self._assumed) < _MAX_PAIRS
            if self._assumed[pair]:
                self._pending[pair] = None
        if self._judged is not None:
            self._dependents.setdefault(pair, {})[self._judged] = None
        return self._assumed[pair]

    def _is_invariant_exclusion(self, one: _FactPattern, other: _FactPattern) -> bool:
        """Whether two facts do not both hold in the initial state, and no action makes both true."""
        if self.exclusion.rules.unread & {one.predicate, other.predicate} or (
            self.exclusion.holds_at_start(one) and self.exclusion.holds_at_start(other)
        ):
            return False
        return all(
            self._preserves_exclusion(schema, added, other_fact)
            for added, other_fact in ((one, other), (other, one))
            for schemas in self.exclusion.rules.effects.values()
            for schema in schemas
            if schema.adds and schema.atom.predicate == added.predicate
        )

    def _preserves_exclusion(self, schema: EffectSchema, added: _FactPattern, other: _FactPattern) -> bool:
        """Whether an effect that adds one fact guarantees that the other fact is false afterwards."""
        scope = self.exclusion.match_atom_to_fact(schema.atom, added, {})
        if scope is None:
            return True
        full = {**{name: f"{name}?" for name in schema.variables}, **scope}
        terms = [f"{i}?" if condition is None else condition for i, condition in enumerate(other.arguments)]
        other_instance = other._replace(arguments=tuple(terms))
        effects = self.exclusion.rules.effects[schema.operator.name]
        if not any(
            self.exclusion.deletes_fact_whenever(condition, schema, other_instance, full)
            for condition in effects
        ):
            check_conditions = [check.condition for check in schema.operator.checks]
            if _SupposedState(self, other_instance).may_hold_together(
                [(condition, full) for condition in (*schema.conditions, *check_conditions)]
            ):
                return False
        return not any(
            self._may_add_both_facts(schema, scope, condition, other)
            for condition in effects
            if condition.adds and condition.atom.predicate == other.predicate
        )

    def _may_add_both_facts(
        self,
        first: EffectSchema,
        first_scope: _ArgumentScope,
        second: EffectSchema,
        second_fact: _FactPattern,
    ) -> bool:
        parameters = [p.name for p in first.operator.parameters]
        second_scope = self.exclusion.match_atom_to_fact(
            second.atom, second_fact, {n: first_scope[n] for n in parameters if n in first_scope}
        )
        if second_scope is None:
            return False
        scope = {**first_scope, **{name: second_scope[name] for name in parameters if name in second_scope}}
        scope |= {name: f"{name}?" for name in first.variables if name not in scope}
        second_scope |= {name: scope[name] for name in parameters}
        second_scope |= {name: f"{name}??" for name in second.variables if name not in second_scope}
        check_conditions = [(check.condition, scope) for check in first.operator.checks]
        effect_conditions = [
            *[(condition, scope) for condition in first.conditions],
            *[(condition, second_scope) for condition in second.conditions],
        ]
        return _SupposedState(self).may_hold_together([*check_conditions, *effect_conditions])


class _SupposedState:
    """A partly known state: facts that are supposed to hold, and the immediate consequences of the facts.

    Args:
        induction: the proof, with its assumptions about all states of the episode.
        facts: the facts that are supposed to hold.
    """

    def __init__(self, induction: _InductionProof, *facts: _FactPattern) -> None:
        self._induction = induction
        self._exclusion = induction.exclusion
        self._true = {fact: _replace_unknown_by_none(fact) for fact in facts}
        self._false: list[_FactPattern] = []
        self._unknown = 0

    def may_hold_together(self, conditions: Sequence[tuple[f.Formula, _ArgumentScope]]) -> bool:
        """Suppose that conditions hold. Return False if it is proved that no state meets them all."""
        for _ in range(_PASSES):  # consequences of a later condition may decide an earlier condition
            if not all(self._try_to_suppose(formula, scope, truth=True) for formula, scope in conditions):
                return False
        return True

    def _evaluate_formula(
        self, formula: f.Formula, scope: _ArgumentScope, unfolded: frozenset[str] = frozenset()
    ) -> bool | None:
        """Return the truth of a formula, or None if it is unknown."""
        match formula:
            case f.Atom(predicate, terms):
                arguments = tuple([self._exclusion.resolve_term(term, scope) for term in terms])
                if predicate not in self._exclusion.rules.vocabulary.derived_by_name:
                    return self._evaluate_fact(_FactPattern(predicate, arguments))
                inner = None if predicate in unfolded else self._unfold_definition(predicate, arguments)
                return None if inner is None else self._evaluate_formula(*inner, unfolded | {predicate})
            case f.Equals(left, right):
                one, other = (
                    self._exclusion.resolve_term(left, scope),
                    self._exclusion.resolve_term(right, scope),
                )
                are_known = isinstance(one, int) and isinstance(other, int)
                return one == other if are_known or (one == other and one is not None) else None
            case f.Not(operand):
                value = self._evaluate_formula(operand, scope, unfolded)
                return None if value is None else not value
            case f.And(operands) | f.Or(operands):
                deciding = isinstance(formula, f.Or)
                values = set()
                for operand in operands:
                    values.add(self._evaluate_formula(operand, scope, unfolded))
                    if deciding in values:
                        return deciding
                return None if None in values else not deciding
            case f.Implies(premise, conclusion):
                return self._evaluate_formula(f.Or((f.Not(premise), conclusion)), scope, unfolded)
            case f.Exists(variable, body) | f.ForAll(variable, body):
                deciding = isinstance(formula, f.Exists)
                if self._evaluate_formula(body, {**scope, variable.name: None}, unfolded) is (not deciding):
                    return not deciding
                is_decided = any(
                    self._evaluate_formula(body, {**scope, variable.name: term}, unfolded) is deciding
                    for term in self._list_possible_terms(variable)
                )
                return deciding if is_decided else None
            case _:
                return None

    def _try_to_suppose(
        self,
        formula: f.Formula,
        scope: _ArgumentScope,
        unfolded: frozenset[str] = frozenset(),
        *,
        truth: bool,
    ) -> bool:
        """Suppose that a formula is true (or false), and record the consequences.

        Return False if the consequences contradict earlier suppositions.
        """
        value = self._evaluate_formula(formula, scope, unfolded)
        if value is not None:
            return value is truth
        match formula:
            case f.Atom(predicate, terms):
                arguments = tuple([self._exclusion.resolve_term(term, scope) for term in terms])
                if predicate not in self._exclusion.rules.vocabulary.derived_by_name:
                    return self._add_fact(_FactPattern(predicate, arguments), truth=truth)
                inner = None if predicate in unfolded else self._unfold_definition(predicate, arguments)
                return inner is None or self._try_to_suppose(*inner, unfolded | {predicate}, truth=truth)
            case f.Not(operand):
                return self._try_to_suppose(operand, scope, unfolded, truth=not truth)
            case f.Implies(premise, conclusion):
                return self._try_to_suppose(f.Or((f.Not(premise), conclusion)), scope, unfolded, truth=truth)
            case f.And(operands) | f.Or(operands):
                if isinstance(formula, f.And) is truth:
                    return all(
                        self._try_to_suppose(operand, scope, unfolded, truth=truth) for operand in operands
                    )
                undecided = [
                    operand
                    for operand in operands
                    if self._evaluate_formula(operand, scope, unfolded) is None
                ]
                return len(undecided) > 1 or self._try_to_suppose(undecided[0], scope, unfolded, truth=truth)
            case f.Exists(variable, body) | f.ForAll(variable, body):
                if isinstance(formula, f.Exists) is not truth:
                    is_general = variable.category is None
                    return not is_general or self._try_to_suppose(
                        body, {**scope, variable.name: None}, unfolded, truth=truth
                    )
                if None in scope.values():  # None: several objects, which may need different values
                    return True
                self._unknown += 1
                return self._try_to_suppose(
                    body, {**scope, variable.name: f"{self._unknown}"}, unfolded, truth=truth
                )
            case _:
                return True

    def _add_fact(self, fact: _FactPattern, *, truth: bool) -> bool:
        if not truth:
            self._false.append(fact)
            return not any(_matches_pattern(known_fact, fact) for known_fact in self._true)
        if None not in fact.arguments:
            self._true[fact] = _replace_unknown_by_none(fact)
        return True

    def _evaluate_fact(self, fact: _FactPattern) -> bool | None:
        """Return whether a fact (or every fact that a pattern matches) holds; None if it is unknown."""
        if fact in self._true:
            return True
        if fact.predicate not in self._exclusion.rules.changed:
            are_known = all(isinstance(other, int) for other in fact.arguments)
            holds = self._exclusion.holds_at_start(_replace_unknown_by_none(fact))
            return holds if are_known or not holds else None
        if any(_matches_pattern(fact, other) for other in self._false):
            return False
        rivals = self._exclusion.rules.rivals[fact.predicate]
        general = _replace_unknown_by_none(fact)
        for other in self._true.values():
            if other.predicate in rivals and self._induction.are_exclusive(general, other):
                return False
        return None

    def _unfold_definition(
        self, predicate: str, arguments: tuple[_FactArgument, ...]
    ) -> tuple[f.Formula, _ArgumentScope] | None:
        defined = find_definition(self._exclusion.rules.vocabulary.derived_by_name[predicate])
        if defined is None:
            return None
        return defined.definition, dict(zip([p.name for p in defined.parameters], arguments, strict=True))

    def _list_possible_terms(self, variable: f.Variable) -> list[_FactArgument]:
        objects = dict.fromkeys(term for fact in self._true for term in fact.arguments)
        if variable.category is None:
            return [*objects]
        category = self._exclusion.scene.get_category_mask(variable.category)
        return [term for term in objects if isinstance(term, int) and category >> term & 1]


def _find_negated_predicates(formulas: Iterable[f.Formula], vocabulary: Vocabulary) -> set[str]:
    """Return the stored predicates of negated atoms in formulas, and in the definitions of predicates."""
    pending, seen, denied = [*formulas], set[str](), set[str]()
    while pending:
        for part in walk_subformulas(pending.pop()):
            match part:
                case f.Not(operand):
                    denied |= {*find_predicates(operand)}
                case f.Atom(name) if name in vocabulary.derived_by_name and name not in seen:
                    seen.add(name)
                    defined = find_definition(vocabulary.derived_by_name[name])
                    pending += [] if defined is None else [defined.definition]
    return {*find_stored_predicates(denied, vocabulary)}


def _make_fact_sort_key(fact: _FactPattern) -> tuple[str, list[int]]:
    return fact.predicate, [argument if isinstance(argument, int) else -1 for argument in fact.arguments]


def _replace_unknown_by_none(fact: _FactPattern) -> _FactPattern:
    """Return a fact in which None replaces each unknown object."""
    return _FactPattern(fact.predicate, tuple([i if isinstance(i, int) else None for i in fact.arguments]))


def _matches_pattern(fact: _FactPattern, pattern: _FactPattern) -> bool:
    return fact.predicate == pattern.predicate and all(
        expected in (None, argument)
        for expected, argument in zip(pattern.arguments, fact.arguments, strict=True)
    )
