"""How far a state is from a condition, estimated backwards from what the operators declare.

A condition that does not hold is brought about by an operator that adds (or deletes) an atom of it; what that
operator checks must be brought about first, and so on, until everything needed holds. Costs are added up as
if nothing ever got in the way of anything else, like the additive heuristic of Bonet and Geffner (2001), but
from the goal backwards, so that only what the goal is about is looked at. The actions at the ends of the
chains, all of whose checks hold already, are the helpful ones (Hoffmann and Nebel 2001).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product
from typing import NamedTuple

from eai.logic.formula import (
    And,
    Atom,
    Exists,
    ForAll,
    Formula,
    Implies,
    Not,
    Or,
    Term,
    Variable,
)
from eai.world.achiever import Achiever, Achievers, taking
from eai.world.domain import Domain
from eai.world.execution import Action
from eai.world.frame import AGENT
from eai.world.operator import Operator
from eai.world.reading import Readings, Scope
from eai.world.state import State
from eai.world.vocabulary import Defined

INFINITE = float("inf")
"""The cost of what no action brings about."""

OPAQUE_COST = 2.0
"""The cost of a derived predicate that is a function, of which only what it reads is known."""

_HORIZONS = (3.0, 6.0, 12.0, 24.0, INFINITE)
"""How far to look, one after the other: what is cheap is found before anything dear is looked at."""

_LEAST = 1.0
"""No condition that does not hold costs less."""


class Wanted(NamedTuple):
    """A condition that shall hold, or (``truth`` False) shall not."""

    formula: Formula
    scope: Scope
    truth: bool


class Way(NamedTuple):
    """The cheapest action found for something, its cost, and what must be brought about before it."""

    cost: float
    action: Action | None
    before: tuple[Wanted, ...]


_NO_WAY = Way(INFINITE, None, ())


class Regression:
    """What estimates need to know of a domain; made once."""

    def __init__(self, domain: Domain) -> None:
        self.domain = domain
        self.achievers = Achievers(domain)
        self.readings = Readings(domain.vocabulary)
        self.derived = domain.vocabulary.derived_by_name
        self.static = frozenset(p.name for p in domain.vocabulary.predicates if p.static)


class Distances:
    """Estimates from one state.

    Args:
        regression: the domain.
        state: the state.
        objects: what actions may be about.
    """

    def __init__(self, regression: Regression, state: State, objects: Sequence[int]) -> None:
        self._domain = regression
        self._state = state
        self._objects = objects
        self._ways: dict[tuple[str, tuple[int, ...], bool], tuple[Way, float]] = {}
        self._open: set[tuple[str, tuple[int, ...], bool]] = set()

    def to(self, formula: Formula) -> float:
        """The estimated number of actions until a closed formula holds; infinite if none brings it about."""
        wanted = Wanted(formula, {}, True)
        costs = (self._cost(wanted, most) for most in _HORIZONS)
        return next((cost for cost in costs if cost < INFINITE), INFINITE)

    def to_action(self, names: Sequence[str]) -> Way:
        """The cheapest way to take one of these actions, with any of the objects."""
        operators = [op for name in names if (op := self._domain.domain.operator(name)) is not None]
        for most in _HORIZONS:
            best = Way(most, None, ())
            for operator in operators:
                best = self._cheapest(taking(operator), {}, best)
            if best.action is not None:
                return best
        return _NO_WAY

    def helpful(self, formula: Formula) -> dict[Action, None]:
        """The actions that are possible at once on the cheapest ways to a closed formula, in order."""
        found: dict[Action, None] = {}
        self._collect(Wanted(formula, {}, True), found, set())
        return found

    def helpful_on(self, way: Way) -> dict[Action, None]:
        """The actions that are possible at once on a way."""
        found: dict[Action, None] = {}
        self._collect_way(way, found, set())
        return found

    # The cost of conditions.

    def _holds(self, wanted: Wanted) -> bool:
        formula, scope, truth = wanted
        return self._domain.readings.holds(formula, scope, self._state) == truth

    def _cost(self, wanted: Wanted, most: float = INFINITE) -> float:
        """The cost of a condition, or infinity if it is not less than ``most``."""
        if self._holds(wanted):
            return 0.0
        if most <= _LEAST:
            return INFINITE
        formula, scope, truth = wanted
        if isinstance(formula, Atom):
            return self._atom_cost(formula, scope, truth, most)
        parts = self._parts(wanted)
        if parts is None:
            return INFINITE
        if parts.all_needed:
            return self._sum(parts.conditions, most)
        best = INFINITE
        for part in parts.conditions:
            best = min(best, self._cost(part, min(best, most)))
            if best <= _LEAST:
                break
        return best

    def _sum(self, conditions: Sequence[Wanted], most: float) -> float:
        """The costs added up, or infinity if the sum is not less than ``most``."""
        total = 0.0
        for condition in conditions:
            total += self._cost(condition, most - total)
            if total >= most:
                return INFINITE
        return total

    def _parts(self, wanted: Wanted) -> Parts | None:
        """What a compound condition comes down to, or None if nothing is known of it."""
        formula, scope, truth = wanted
        match formula:
            case Not(operand):
                return Parts((Wanted(operand, scope, not truth),), all_needed=True)
            case And(operands):
                return Parts(tuple([Wanted(f, scope, truth) for f in operands]), all_needed=truth)
            case Or(operands):
                return Parts(tuple([Wanted(f, scope, truth) for f in operands]), all_needed=not truth)
            case Implies(premise, conclusion):
                either = (Wanted(premise, scope, not truth), Wanted(conclusion, scope, truth))
                return Parts(either, all_needed=not truth)
            case Exists(variable, body) | ForAll(variable, body):
                return self._instances(variable, body, wanted, isinstance(formula, Exists))
            case _:
                return None

    def _instances(self, variable: Variable, body: Formula, wanted: Wanted, exists: bool) -> Parts:
        """For an ``exists`` that shall hold one value is enough; otherwise all that are in the way matter."""
        _, scope, truth = wanted
        if exists == truth:
            allowed = self._state.scene.category(variable.category)
            values = [i for i in self._objects if allowed >> i & 1]
        else:
            values = list(self._offending(variable, body, scope, exists))
        return Parts(
            tuple([Wanted(body, {**scope, variable.name: value}, truth) for value in values]),
            all_needed=exists != truth,
        )

    def _offending(self, variable: Variable, body: Formula, scope: Scope, exists: bool) -> Iterator[int]:
        holding = self._domain.readings.witnesses(variable, body, scope, self._state)
        if exists:
            return holding
        everything = self._state.scene.category(variable.category)
        held = set(holding)
        return (i for i in range(len(self._state.scene.objects)) if everything >> i & 1 and i not in held)

    # The cost of atoms.

    def _atom_cost(self, atom: Atom, scope: Scope, truth: bool, most: float) -> float:
        arguments = self._indices(atom.arguments, scope)
        derived = self._domain.derived.get(atom.predicate)
        if isinstance(derived, Defined):
            return self._cost(_unfolded(derived, arguments, truth), most)
        if derived is not None:
            return OPAQUE_COST if most > OPAQUE_COST else INFINITE
        return self._way(atom.predicate, arguments, truth, most).cost

    def _indices(self, terms: Sequence[Term], scope: Scope) -> tuple[int, ...]:
        return tuple([self._index(term, scope) for term in terms])

    def _index(self, term: Term, scope: Scope) -> int:
        scene = self._state.scene
        if isinstance(term, Variable):
            return scope[term.name]
        if term == AGENT and scene.agent is not None:
            return scene.agent
        return scene.index[term.name]

    def _way(self, predicate: str, arguments: tuple[int, ...], truth: bool, most: float = INFINITE) -> Way:
        """The cheapest way to make a stored atom true or false that costs less than ``most``.

        What is needed to bring itself about is no way.
        """
        key = (predicate, arguments, truth)
        known, tried = self._ways.get(key, (_NO_WAY, 0.0))
        if known.cost < most:
            return known
        if known.action is not None or tried >= most or key in self._open:
            return _NO_WAY
        if predicate in self._domain.static:
            return _NO_WAY
        self._open.add(key)
        best = Way(most, None, ())
        for achiever in self._domain.achievers.of(predicate, adding=truth):
            scope = achiever.match(arguments, self._state.scene.agent)
            if scope is not None:
                best = self._cheapest(achiever, scope, best)
            if best.cost <= _LEAST:
                break
        self._open.discard(key)
        found = _NO_WAY if best.action is None else best
        self._ways[key] = (found, most)
        return found

    def _cheapest(self, achiever: Achiever, scope: Scope, best: Way) -> Way:
        """The best way by one change of an operator, or ``best`` if that is as good."""
        unbound = [name for name in achiever.variables if name not in scope]
        for values in product(self._objects, repeat=len(unbound)):
            full = {**scope, **dict(zip(unbound, values, strict=True))} if unbound else scope
            if not all(self._holds(Wanted(given, full, True)) for given in achiever.given):
                continue
            needed = [Wanted(condition, full, True) for condition in achiever.conditions]
            cost = _LEAST + self._sum(needed, best.cost - _LEAST)
            if cost < best.cost:
                arguments = tuple([full[p.name] for p in achiever.operator.parameters])
                action = Action(achiever.operator.name, arguments)
                before = tuple([each for each in needed if not self._holds(each)])
                best = Way(cost, action, before)
            if best.cost <= _LEAST:
                break
        return best

    # Helpful actions.

    def _collect(self, wanted: Wanted, found: dict[Action, None], seen: set[int]) -> None:
        if self._holds(wanted):
            return
        formula, scope, truth = wanted
        if isinstance(formula, Atom):
            self._collect_atom(formula, scope, truth, found, seen)
            return
        parts = self._parts(wanted)
        if parts is None or not parts.conditions:
            return
        if parts.all_needed:
            for part in parts.conditions:
                self._collect(part, found, seen)
        else:
            cheapest = self._cheapest_of(parts.conditions)
            if cheapest is not None:
                self._collect(cheapest, found, seen)

    def _cheapest_of(self, conditions: Sequence[Wanted]) -> Wanted | None:
        for most in _HORIZONS:
            best, cheapest = most, None
            for condition in conditions:
                cost = self._cost(condition, best)
                if cost < best:
                    best, cheapest = cost, condition
            if cheapest is not None:
                return cheapest
        return None

    def _collect_atom(
        self, atom: Atom, scope: Scope, truth: bool, found: dict[Action, None], seen: set[int]
    ) -> None:
        arguments = self._indices(atom.arguments, scope)
        derived = self._domain.derived.get(atom.predicate)
        if isinstance(derived, Defined):
            self._collect(_unfolded(derived, arguments, truth), found, seen)
        elif derived is not None:
            found.update(self._changing(derived.reads))
        else:
            self._collect_way(self._way(atom.predicate, arguments, truth), found, seen)

    def _collect_way(self, way: Way, found: dict[Action, None], seen: set[int]) -> None:
        if way.action is None or id(way) in seen:
            return
        seen.add(id(way))
        if not way.before:
            found[way.action] = None
        for condition in way.before:
            self._collect(condition, found, seen)

    def _changing(self, predicates: Sequence[str]) -> dict[Action, None]:
        """All actions possible at once that change some of these predicates."""
        return {
            action: None
            for operator in self._domain.achievers.writers(predicates)
            for action in possible_actions(self._domain.domain, operator, self._state, self._objects)
        }


class Parts(NamedTuple):
    """What a compound condition comes down to: all of some conditions, or any one of them."""

    conditions: tuple[Wanted, ...]
    all_needed: bool


def _unfolded(derived: Defined, arguments: tuple[int, ...], truth: bool) -> Wanted:
    scope = {p.name: i for p, i in zip(derived.parameters, arguments, strict=True)}
    return Wanted(derived.definition, scope, truth)


def possible_actions(
    domain: Domain, operator: Operator, state: State, objects: Sequence[int]
) -> Iterator[Action]:
    """The actions by an operator on some objects that no check forbids in a state."""
    compiled = domain.compiled[operator.name]
    for arguments in product(objects, repeat=operator.arity):
        if compiled.first_failure(state, compiled.bind(state, arguments)) is None:
            yield Action(operator.name, arguments)
