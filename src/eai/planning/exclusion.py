"""Exclusion: what no state of an episode meets, as far as it follows from the declaration of the domain.

Two facts exclude each other if they do not both hold at the start, and no action that adds one leaves the
other: it deletes it, or needs what the other excludes. Pairs are shown together, by induction over the
actions of an episode: what a pair rests on is assumed until it fails. What cannot be shown is left open.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache
from typing import NamedTuple, TypeAlias

import eai.logic.formula as f
from eai.logic.traversal import predicates_of, walk
from eai.planning.effect_schema import (
    EffectSchema,
    changed_predicates,
    effect_schemas,
    match_atom,
    unread_predicates,
)
from eai.planning.subgoal import GroundAtom, find_object
from eai.world.derived import find_definition, find_stored_predicates
from eai.world.domain import Domain
from eai.world.effect import ANYTHING
from eai.world.state import State
from eai.world.vocabulary import Vocabulary

_MOST_PAIRS = 64
"""How many pairs are looked at for one question; of others it is taken that they can hold together."""

_REMEMBERED = 4096
"""How many facts are remembered of which it is known whether they hold at the start."""

_PASSES = 2
"""How often conditions are gone through."""

_Term: TypeAlias = int | str | None
"""An object, one that is not known by its name, or any."""

_Scope: TypeAlias = Mapping[str, _Term]


class _Fact(NamedTuple):
    """A fact about a stored predicate; with None in it, all such facts."""

    predicate: str
    arguments: tuple[_Term, ...]


_Pair: TypeAlias = tuple[_Fact, _Fact]


class ExclusionRules:
    """The rules by which facts exclude each other in a domain, wherever an episode begins.

    Args:
        domain: the domain.
    """

    def __init__(self, domain: Domain) -> None:
        self.vocabulary = domain.vocabulary
        self.effects = {o.name: tuple(effect_schemas(o)) for o in domain.operators}
        self.single = {p.name for p in domain.vocabulary.predicates if p.single}
        self.changed = {name for o in domain.operators for name in changed_predicates(o)}
        self.unread = {name for o in domain.operators for name in unread_predicates(o)}
        self.denying = self._denied_by(domain)
        self.rivals = {p: self.denying.get(p, set()) | ({p} & self.single) for p in self.changed}

    def exclusion_from(self, initial: State) -> _Exclusion:
        """Return what excludes literals in the episode that begins in a state."""
        return _Exclusion(self, initial)

    def _denied_by(self, domain: Domain) -> dict[str, set[str]]:
        """For each predicate those that may exclude it: what adds one deletes or denies the other."""
        found: dict[str, set[str]] = {}
        for operator in domain.operators:
            effects = self.effects[operator.name]
            added = {each.atom.predicate for each in effects if each.adds}
            formulas = [c.condition for c in operator.checks] + [g for e in effects for g in e.conditions]
            denied = {each.atom.predicate for each in effects if not each.adds}
            denied |= _denied(formulas, domain.vocabulary)
            for one in added:
                for other in denied:
                    found.setdefault(one, set()).add(other)
                    found.setdefault(other, set()).add(one)
        return found


class _Exclusion:
    """The literals that no state of an episode meets.

    Args:
        rules: what the declaration says.
        initial: where the episode begins.
    """

    def __init__(self, rules: ExclusionRules, initial: State) -> None:
        self.rules = rules
        self.scene = initial.scene
        self.at_start = lru_cache(_REMEMBERED)(self._at_start)
        self._initial = initial

    def excludes(self, literals: Iterable[GroundAtom]) -> bool:
        """Whether no state that actions lead to meets all the literals."""
        wanted = []
        for literal in literals:
            variables = tuple([f.Variable(str(i)) for i in range(len(literal.arguments))])
            atom = f.Atom(literal.predicate, variables)
            scope = {v.name: i for v, i in zip(variables, literal.arguments, strict=True)}
            wanted.append((atom if literal.truth else f.Not(atom), scope))
        return _Induction(self).shows(wanted)

    def _at_start(self, fact: _Fact) -> bool:
        """Whether any such fact holds at the start."""
        match fact:
            case _Fact(predicate, (None,)):
                return bool(self._initial.mask(predicate))
            case _Fact(predicate, (int(source), None)):
                return bool(self._initial.relation(predicate).row(source))
            case _Fact(predicate, (None, int(target))):
                return bool(self._initial.relation(predicate).column(target))
            case _Fact(predicate, (None, None)):
                return len(self._initial.relation(predicate)) > 0
            case _Fact(predicate, arguments) if None in arguments:
                members = self._initial.tuple_set(predicate).members
                return any(_is_among(_Fact(predicate, each), fact) for each in members)
            case _:
                return self._initial.has(fact.predicate, *[i for i in fact.arguments if isinstance(i, int)])

    def match(self, atom: f.Atom, fact: _Fact, known: _Scope) -> dict[str, _Term] | None:
        """The objects of variables where an effect is on such a fact; None if it cannot be."""
        return match_atom(atom, fact.arguments, self.index, known)

    def deletes(self, effect: EffectSchema, schema: EffectSchema, fact: _Fact, scope: _Scope) -> bool:
        """Whether an effect deletes a fact wherever another one takes place."""
        return (
            not effect.adds
            and effect.atom.predicate == fact.predicate
            and {*effect.conditions} <= {*schema.conditions}
            and all(
                term == ANYTHING or self.term(term, scope) == argument
                for term, argument in zip(effect.atom.arguments, fact.arguments, strict=True)
            )
        )

    def term(self, term: f.Term, scope: _Scope) -> _Term:
        """The object that a term stands for."""
        return scope.get(term.name) if isinstance(term, f.Variable) else self.index(term)

    def index(self, constant: f.Constant) -> int:
        """The object that a constant names."""
        return find_object(constant, self.scene)


class _Induction:
    """The pairs of facts that the answer to one question rests on, each assumed until it fails.

    Every question has pairs of its own: no answer rests on what was asked before, and threads may ask at
    once.

    Args:
        known: what is known of all actions of the episode.
    """

    def __init__(self, known: _Exclusion) -> None:
        self.known = known
        self._assumed: dict[_Pair, bool] = {}
        self._pending: dict[_Pair, None] = {}
        self._resting: dict[_Pair, dict[_Pair, None]] = {}
        self._judged: _Pair | None = None

    def shows(self, wanted: Sequence[tuple[f.Formula, _Scope]]) -> bool:
        """Whether it follows that no state meets all that is wanted.

        A pair is assumed as it is asked for. One that does not last is given up, and what rests on it judged
        again.
        """
        if _Supposition(self).meets(wanted):
            return False
        while self._pending:
            pair = next(iter(self._pending))
            del self._pending[pair]
            self._judged = pair
            if not self._lasts(*pair):
                self._assumed[pair] = False
                self._judged = None
                if _Supposition(self).meets(wanted):
                    return False
                resting = self._resting.pop(pair, {})
                self._pending |= {each: None for each in resting if self._assumed[each]}
        return True

    def apart(self, one: _Fact, other: _Fact) -> bool:
        """Whether facts of two general forms exclude each other, as far as is known or assumed."""
        rules = self.known.rules
        if one.predicate == other.predicate:
            different = one != other and None not in one.arguments + other.arguments
            if different and one.predicate in rules.single and one.arguments[:-1] == other.arguments[:-1]:
                return True
        elif {*one.arguments}.isdisjoint({*other.arguments} - {None}):
            return False
        same = _is_among(one, other) or _is_among(other, one)
        if same or other.predicate not in rules.denying.get(one.predicate, ()):
            return False
        return self._is_assumed((one, other) if _order(one) < _order(other) else (other, one))

    def _is_assumed(self, pair: _Pair) -> bool:
        if pair not in self._assumed:
            self._assumed[pair] = len(self._assumed) < _MOST_PAIRS
            if self._assumed[pair]:
                self._pending[pair] = None
        if self._judged is not None:
            self._resting.setdefault(pair, {})[self._judged] = None
        return self._assumed[pair]

    def _lasts(self, one: _Fact, other: _Fact) -> bool:
        """Whether no more than one of them holds at the start, and no action changes that."""
        if self.known.rules.unread & {one.predicate, other.predicate} or (
            self.known.at_start(one) and self.known.at_start(other)
        ):
            return False
        return all(
            self._keeps(schema, added, kept)
            for added, kept in ((one, other), (other, one))
            for schemas in self.known.rules.effects.values()
            for schema in schemas
            if schema.adds and schema.atom.predicate == added.predicate
        )

    def _keeps(self, schema: EffectSchema, added: _Fact, other: _Fact) -> bool:
        """Whether what adds a fact does not leave the other, nor add it, too."""
        scope = self.known.match(schema.atom, added, {})
        if scope is None:
            return True
        full = {**{name: f"{name}?" for name in schema.variables}, **scope}
        terms = [f"{i}?" if each is None else each for i, each in enumerate(other.arguments)]
        held = other._replace(arguments=tuple(terms))
        effects = self.known.rules.effects[schema.operator.name]
        if not any(self.known.deletes(each, schema, held, full) for each in effects):
            asked = [check.condition for check in schema.operator.checks]
            if _Supposition(self, held).meets([(each, full) for each in (*schema.conditions, *asked)]):
                return False
        return not any(
            self._adds_both(schema, scope, each, other)
            for each in effects
            if each.adds and each.atom.predicate == other.predicate
        )

    def _adds_both(self, schema: EffectSchema, first: _Scope, second: EffectSchema, other: _Fact) -> bool:
        """Whether an action that makes an addition, about the first objects, may make another one at once."""
        parameters = [p.name for p in schema.operator.parameters]
        own = self.known.match(second.atom, other, {n: first[n] for n in parameters if n in first})
        if own is None:
            return False
        scope = {**first, **{name: own[name] for name in parameters if name in own}}
        scope |= {name: f"{name}?" for name in schema.variables if name not in scope}
        own |= {name: scope[name] for name in parameters}
        own |= {name: f"{name}??" for name in second.variables if name not in own}
        asked = [(check.condition, scope) for check in schema.operator.checks]
        given = [*[(each, scope) for each in schema.conditions], *[(each, own) for each in second.conditions]]
        return _Supposition(self).meets([*asked, *given])


class _Supposition:
    """A state of which only some facts are known: what is supposed, and what follows at once.

    Args:
        induction: what is known of all states of the episode, or assumed.
        facts: what holds.
    """

    def __init__(self, induction: _Induction, *facts: _Fact) -> None:
        self._induction = induction
        self._known = induction.known
        self._true = {fact: _general(fact) for fact in facts}
        self._false: list[_Fact] = []
        self._unknown = 0

    def meets(self, conditions: Sequence[tuple[f.Formula, _Scope]]) -> bool:
        """Whether it may meet conditions, as far as is known; they are supposed."""
        for _ in range(_PASSES):  # what follows from one may decide another
            if not all(self._suppose(formula, scope, truth=True) for formula, scope in conditions):
                return False
        return True

    def _value(self, formula: f.Formula, scope: _Scope, within: frozenset[str] = frozenset()) -> bool | None:
        """Whether a formula holds; None where that is not known."""
        match formula:
            case f.Atom(predicate, terms):
                arguments = tuple([self._known.term(term, scope) for term in terms])
                if predicate not in self._known.rules.vocabulary.derived_by_name:
                    return self._fact(_Fact(predicate, arguments))
                inner = None if predicate in within else self._unfolded(predicate, arguments)
                return None if inner is None else self._value(*inner, within | {predicate})
            case f.Equals(left, right):
                one, other = self._known.term(left, scope), self._known.term(right, scope)
                known = isinstance(one, int) and isinstance(other, int)
                return one == other if known or (one == other and one is not None) else None
            case f.Not(operand):
                value = self._value(operand, scope, within)
                return None if value is None else not value
            case f.And(operands) | f.Or(operands):
                deciding = isinstance(formula, f.Or)
                values = set()
                for each in operands:
                    values.add(self._value(each, scope, within))
                    if deciding in values:
                        return deciding
                return None if None in values else not deciding
            case f.Implies(premise, conclusion):
                return self._value(f.Or((f.Not(premise), conclusion)), scope, within)
            case f.Exists(variable, body) | f.ForAll(variable, body):
                deciding = isinstance(formula, f.Exists)
                if self._value(body, {**scope, variable.name: None}, within) is (not deciding):
                    return not deciding
                some = any(
                    self._value(body, {**scope, variable.name: term}, within) is deciding
                    for term in self._terms(variable)
                )
                return deciding if some else None
            case _:
                return None

    def _suppose(
        self, formula: f.Formula, scope: _Scope, within: frozenset[str] = frozenset(), *, truth: bool
    ) -> bool:
        """Suppose a formula, or its opposite, as far as one thing follows; False if it cannot be so."""
        value = self._value(formula, scope, within)
        if value is not None:
            return value is truth
        match formula:
            case f.Atom(predicate, terms):
                arguments = tuple([self._known.term(term, scope) for term in terms])
                if predicate not in self._known.rules.vocabulary.derived_by_name:
                    return self._enter(_Fact(predicate, arguments), truth=truth)
                inner = None if predicate in within else self._unfolded(predicate, arguments)
                return inner is None or self._suppose(*inner, within | {predicate}, truth=truth)
            case f.Not(operand):
                return self._suppose(operand, scope, within, truth=not truth)
            case f.Implies(premise, conclusion):
                return self._suppose(f.Or((f.Not(premise), conclusion)), scope, within, truth=truth)
            case f.And(operands) | f.Or(operands):
                if isinstance(formula, f.And) is truth:
                    return all(self._suppose(each, scope, within, truth=truth) for each in operands)
                left = [each for each in operands if self._value(each, scope, within) is None]
                return len(left) > 1 or self._suppose(left[0], scope, within, truth=truth)
            case f.Exists(variable, body) | f.ForAll(variable, body):
                if isinstance(formula, f.Exists) is not truth:
                    every = variable.category is None
                    return not every or self._suppose(
                        body, {**scope, variable.name: None}, within, truth=truth
                    )
                if None in scope.values():  # a different object for each
                    return True
                self._unknown += 1
                return self._suppose(body, {**scope, variable.name: f"{self._unknown}"}, within, truth=truth)
            case _:
                return True

    def _enter(self, fact: _Fact, *, truth: bool) -> bool:
        if not truth:
            self._false.append(fact)
            return not any(_is_among(each, fact) for each in self._true)
        if None not in fact.arguments:
            self._true[fact] = _general(fact)
        return True

    def _fact(self, fact: _Fact) -> bool | None:
        """Whether a fact holds, or all such facts; None where that is not known."""
        if fact in self._true:
            return True
        if fact.predicate not in self._known.rules.changed:
            known = all(isinstance(each, int) for each in fact.arguments)
            found = self._known.at_start(_general(fact))
            return found if known or not found else None
        if any(_is_among(fact, each) for each in self._false):
            return False
        rivals = self._known.rules.rivals[fact.predicate]
        general = _general(fact)
        for each in self._true.values():
            if each.predicate in rivals and self._induction.apart(general, each):
                return False
        return None

    def _unfolded(self, predicate: str, arguments: tuple[_Term, ...]) -> tuple[f.Formula, _Scope] | None:
        """The definition of a derived predicate, for these arguments, if it has one."""
        defined = find_definition(self._known.rules.vocabulary.derived_by_name[predicate])
        if defined is None:
            return None
        return defined.definition, dict(zip([p.name for p in defined.parameters], arguments, strict=True))

    def _terms(self, variable: f.Variable) -> list[_Term]:
        """The objects that a variable may stand for, of what is known to be about something."""
        known = dict.fromkeys(term for fact in self._true for term in fact.arguments)
        if variable.category is None:
            return [*known]
        category = self._known.scene.category(variable.category)
        return [term for term in known if isinstance(term, int) and category >> term & 1]


def _denied(formulas: Iterable[f.Formula], vocabulary: Vocabulary) -> set[str]:
    """The stored predicates that formulas deny, themselves or by what they define."""
    pending, seen, denied = [*formulas], set[str](), set[str]()
    while pending:
        for part in walk(pending.pop()):
            match part:
                case f.Not(operand):
                    denied |= {*predicates_of(operand)}
                case f.Atom(name) if name in vocabulary.derived_by_name and name not in seen:
                    seen.add(name)
                    defined = find_definition(vocabulary.derived_by_name[name])
                    pending += [] if defined is None else [defined.definition]
    return {*find_stored_predicates(denied, vocabulary)}


def _order(fact: _Fact) -> tuple[str, list[int]]:
    """By which two facts of a pair are put in order."""
    return fact.predicate, [each if isinstance(each, int) else -1 for each in fact.arguments]


def _general(fact: _Fact) -> _Fact:
    """All facts that one about unknown objects may be."""
    return _Fact(fact.predicate, tuple([i if isinstance(i, int) else None for i in fact.arguments]))


def _is_among(fact: _Fact, facts: _Fact) -> bool:
    return fact.predicate == facts.predicate and all(
        general in (None, own) for general, own in zip(facts.arguments, fact.arguments, strict=True)
    )
