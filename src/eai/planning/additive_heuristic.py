"""How far a state is from a condition, estimated backwards from what the operators declare.

A condition that does not hold is brought about by an operator that adds (or deletes) an atom of it; what that
operator checks must be brought about first, and so on, until everything needed holds. Costs are added up as
if nothing ever got in the way of anything else, like the additive heuristic of Bonet and Geffner (2001), but
from the goal backwards, so that only what the goal is about is looked at.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple, TypeAlias

from eai.logic.choice import AllOf, AnyOf, Choose, Pairing
from eai.logic.formula import Atom, Exists, ForAll
from eai.planning.achievers import Achiever, Achievers
from eai.planning.search import Effort, Limits
from eai.planning.subgoal import GroundAtom, Subgoal, SubgoalParts, Unfolding
from eai.world.action import Action
from eai.world.condition import FormulaEvaluator
from eai.world.derived import Defined
from eai.world.domain import Domain
from eai.world.frame import FrameBinding
from eai.world.relation import mask_of
from eai.world.state import State

Cost: TypeAlias = Callable[[Subgoal], float]
"""The cost of bringing a condition about."""


def choose_exactly(number: int, conditions: Sequence[Subgoal], cost: Cost) -> list[Subgoal] | None:
    """Return the cheapest `number` conditions and the opposites of the others, or None if there are fewer."""
    if number > len(conditions):
        return None
    opposites = [each.negated for each in conditions]

    def loss(i: int) -> tuple[bool, float]:
        own = cost(conditions[i])
        return own == float("inf"), own - cost(opposites[i])

    order = sorted(range(len(conditions)), key=loss)
    return [*(conditions[i] for i in order[:number]), *(opposites[i] for i in order[number:])]


def choose_pairs(number: int, cells: Sequence[Sequence[Subgoal | None]], cost: Cost) -> list[Subgoal] | None:
    """So many cells, no two in one row or column, or None if that leads nowhere.

    The cheapest cell comes first, then the cheapest of those in other rows and columns, and so on.
    """
    ranked = sorted(
        (price, i, j)
        for i, row in enumerate(cells)
        for j, cell in enumerate(row)
        if cell is not None and (price := cost(cell)) < float("inf")
    )
    columns: dict[int, int] = {}
    for _, i, j in ranked:
        if len(columns) < number and i not in columns and j not in columns.values():
            columns[i] = j
    chosen = [cell for i, j in columns.items() if (cell := cells[i][j]) is not None]
    return chosen if len(chosen) == number else None


INFINITE = float("inf")
"""The cost of what no action brings about."""

OPAQUE_COST = 2.0
"""The cost of a derived predicate that is a function, of which only what it reads is known."""

_HORIZONS = (2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 12.0, INFINITE)
"""How far to look, one after the other: what is cheap is found before anything dear is looked at."""


def _horizon(most: float) -> float:
    """The nearest horizon that is not nearer: so nothing is looked at anew for each cost that comes up."""
    return next(horizon for horizon in _HORIZONS if horizon >= most)


_LEAST = 1.0
"""No condition that does not hold costs less."""

_DEEPEST = 60
"""How many atoms may be brought about for one another: what takes more looks out of reach."""


class _Instance(NamedTuple):
    """A formula, by identity, with the objects of its free variables, and whether it shall hold."""

    formula: int
    values: tuple[int, ...]
    truth: bool


_Key: TypeAlias = GroundAtom | _Instance


class _Supporter(NamedTuple):
    """The cheapest action found to bring something about, its cost, and what it needs first."""

    cost: float
    action: Action | None
    before: tuple[Subgoal, ...]


_NO_SUPPORTER = _Supporter(INFINITE, None, ())


class AdditiveHeuristic:
    """The heuristic for one domain: what estimates from any state need to know of it; made once."""

    def __init__(self, domain: Domain) -> None:
        self.domain = domain
        self.achievers = Achievers(domain)
        self.readings = FormulaEvaluator(domain.vocabulary)
        self.derived = domain.vocabulary.derived_by_name
        self.static = frozenset(p.name for p in domain.vocabulary.predicates if p.static)


class Estimates:
    """Estimates from one state.

    Args:
        heuristic: the heuristic for the domain.
        state: the state.
        objects: what actions may be about.
        kept: closed conditions; an action that undoes one of them costs one more.
        looks: counts the actions that are looked at; when it is exceeded, estimates mean nothing.
        bindings: counts the values given to variables to find these actions, with the same effect.

    Attributes:
        state: the state.
        objects: what actions may be about.
        bindings: counts the values that are given to variables.
    """

    def __init__(
        self,
        heuristic: AdditiveHeuristic,
        state: State,
        objects: Sequence[int],
        protected: Sequence[Subgoal] = (),
        looks: Effort | None = None,
        bindings: Effort | None = None,
    ) -> None:
        self.state = state
        self.objects = objects
        self.bindings = bindings or Effort(Limits().bindings)
        self._heuristic = heuristic
        self._looks = looks or Effort()
        self._unfolding = Unfolding(heuristic.readings, state, objects)
        self.holds = self._unfolding.holds
        self.atom = self._unfolding.atom
        self._kept = [condition for condition in protected if self.holds(condition)]
        self._usable = mask_of(objects)
        self._matches = heuristic.achievers.matches(state, self._usable)
        self._supporters: dict[GroundAtom, tuple[_Supporter, float]] = {}
        self._costs: dict[_Key, tuple[float, float]] = {}
        self._undone: dict[Action, int] = {}
        self._open: set[_Key] = set()

    def estimate(self, subgoal: Subgoal) -> float:
        """The estimated number of actions until a condition holds; infinite if none brings it about."""
        if self.holds(subgoal):
            return 0.0
        costs = (self._cost(subgoal, most) for most in _HORIZONS)
        return next((cost for cost in costs if cost < INFINITE), INFINITE)

    def estimate_action(self, names: Sequence[str]) -> _Supporter:
        """The cheapest of these actions, with any of the objects."""
        for most in _HORIZONS:
            best = _Supporter(most, None, ())
            for achiever in self._heuristic.achievers.find_operators(names):
                best = self._cheapest(
                    achiever, achiever.bindings(self.state, {}, self._usable, self.bindings), best
                )
            if best.action is not None:
                return best
        return _NO_SUPPORTER

    def choose_atoms(self, subgoal: Subgoal) -> tuple[Subgoal, ...]:
        """The conditions on single atoms that a condition comes down to by the cheapest choices."""
        needed = None if isinstance(subgoal.formula, Atom) else self.choose_parts(subgoal)
        return (
            (subgoal,) if needed is None else tuple([c for part in needed for c in self.choose_atoms(part)])
        )

    def choose_parts(self, subgoal: Subgoal) -> Sequence[Subgoal] | None:
        """The conditions that one is made up of, all of them needed, by the cheapest choices.

        None for atoms of stored predicates and functions, and where no choice is known to bring it about.
        """
        if isinstance(subgoal.formula, Atom):
            definition = self._definition(self.atom(subgoal.formula, subgoal))
            return None if definition is None else (definition,)
        parts = self._unfolding.parts(subgoal)
        return None if parts is None else self._choice(parts)

    def find_prerequisites(self, subgoal: Subgoal) -> Sequence[Subgoal]:
        """The parts that a condition comes down to, or what the last action on the way to it needs."""
        if isinstance(subgoal.formula, Atom) and subgoal.formula.predicate not in self._heuristic.derived:
            return self.find_supporter(self.atom(subgoal.formula, subgoal)).before
        needed = self.choose_parts(subgoal) or ()
        return self.find_prerequisites(needed[0]) if len(needed) == 1 else needed

    def find_alternatives(self, subgoal: Subgoal) -> Sequence[Subgoal]:
        """Where one of several conditions is enough, those that cost least; otherwise none."""
        parts = None if isinstance(subgoal.formula, Atom) else self._unfolding.parts(subgoal)
        costs = [(each, self.estimate(each)) for each in parts.parts] if isinstance(parts, AnyOf) else []
        least = min((cost for _, cost in costs), default=INFINITE)
        return [each for each, cost in costs if cost == least < INFINITE]

    def find_supporter(self, atom: GroundAtom, most: float = INFINITE) -> _Supporter:
        """The cheapest action that makes an atom of a stored predicate true or false for less than ``most``.

        What is needed to bring itself about does not count. Where nothing does it at any cost, wide achievers
        are looked at.
        """
        known, tried = self._supporters.get(atom, (_NO_SUPPORTER, 0.0))
        if known.cost < most:
            return known
        if known.action is not None or tried >= most or self._is_open(atom):
            return _NO_SUPPORTER
        if atom.predicate in self._heuristic.static:
            return _NO_SUPPORTER
        self._open.add(atom)
        far = _horizon(most)
        best = self._supported(atom, _Supporter(far, None, ()))
        if best.action is None and far == INFINITE:
            best = self._supported(atom, best, wide=True)
        self._open.discard(atom)
        found = _NO_SUPPORTER if best.action is None else best
        self._supporters[atom] = (found, far)
        return found if found.cost < most else _NO_SUPPORTER

    def _supported(self, atom: GroundAtom, best: _Supporter, *, wide: bool = False) -> _Supporter:
        """The best supporter of an atom by any achiever, or ``best`` if that is as good."""
        for match in self._matches.of(atom, wide=wide):
            if match.needs(self.state, best.cost - _LEAST):
                continue
            best = self._cheapest(
                match.achiever, match.bindings(self.state, self._usable, self.bindings), best
            )
            if best.cost <= _LEAST:
                break
        return best

    # The cost of conditions.

    def _cost(self, subgoal: Subgoal, most: float) -> float:
        """The cost of a condition that does not hold, or infinity if it is not less than ``most``.

        What is needed to bring itself about has no cost that is less.
        """
        if most <= _LEAST:
            return INFINITE
        match subgoal.formula:
            case Atom(predicate) as atom:
                ground = self.atom(atom, subgoal)
                if predicate not in self._heuristic.derived:
                    return self.find_supporter(ground, most).cost
                key: _Key = ground
            case Exists() | ForAll() as formula:
                names = self._heuristic.readings.names(formula)
                values = tuple([subgoal.scope[name] for name in names])
                key = _Instance(id(formula), values, subgoal.truth)
            case _:
                return self._cost_of_parts(subgoal, most)
        known, tried = self._costs.get(key, (INFINITE, 0.0))
        if known < most:
            return known
        if known < INFINITE or tried >= most or self._is_open(key):
            return INFINITE
        self._open.add(key)
        far = _horizon(most)
        cost = self._cost_of_parts(subgoal, far)
        self._open.discard(key)
        self._costs[key] = (cost, far)
        return cost if cost < most else INFINITE

    def _is_open(self, key: _Key) -> bool:
        """Whether a condition is needed to bring itself about, or for one that lies too deep."""
        return key in self._open or len(self._open) >= _DEEPEST

    def _cost_of_parts(self, subgoal: Subgoal, most: float) -> float:
        if isinstance(subgoal.formula, Atom):
            definition = self._definition(self.atom(subgoal.formula, subgoal))
            if definition is not None:
                return self._cost(definition, most)
            return OPAQUE_COST if most > OPAQUE_COST else INFINITE
        parts = self._unfolding.parts(subgoal)
        if isinstance(parts, AnyOf):
            return self._least(parts.parts, most)
        needed = None if parts is None else self._choice(parts)
        if needed is None:
            return INFINITE
        return self._sum([each for each in needed if not self.holds(each)], most)

    def _least(self, conditions: Sequence[Subgoal], most: float) -> float:
        """The cost of the cheapest of conditions none of which holds."""
        best = INFINITE
        for condition in conditions:
            best = min(best, self._cost(condition, min(best, most)))
            if best <= _LEAST:
                break
        return best

    def _sum(self, failing: Sequence[Subgoal], most: float) -> float:
        """The costs of conditions that do not hold together, or infinity if not less than ``most``."""
        others = len(failing) * _LEAST
        if others >= most:
            return INFINITE
        total = 0.0
        for condition in failing:
            others -= _LEAST
            total += self._cost(condition, most - total - others)
            if total >= most:
                return INFINITE
        return total

    # Choices.

    def _choice(self, parts: SubgoalParts) -> Sequence[Subgoal] | None:
        """The conditions that parts come down to, all of which are needed, or None if nothing does it."""
        match parts:
            case AllOf(conditions):
                return conditions
            case AnyOf(conditions):
                cheapest = self._cheapest_of(conditions)
                return None if cheapest is None else (cheapest,)
            case Choose(number, conditions):
                return choose_exactly(number, conditions, self.estimate)
            case Pairing(number, cells):
                return choose_pairs(number, cells, self.estimate)

    def _cheapest_of(self, conditions: Sequence[Subgoal]) -> Subgoal | None:
        for condition in conditions:
            if self.holds(condition):
                return condition
        for most in _HORIZONS:
            best, cheapest = most, None
            for condition in conditions:
                cost = self._cost(condition, best)
                if cost < best:
                    best, cheapest = cost, condition
            if cheapest is not None:
                return cheapest
        return None

    # Atoms.

    def _definition(self, atom: GroundAtom) -> Subgoal | None:
        """The definition of a derived predicate, about the objects of the atom; None if it is not defined."""
        derived = self._heuristic.derived.get(atom.predicate)
        if not isinstance(derived, Defined):
            return None
        scope = {p.name: index for p, index in zip(derived.parameters, atom.arguments, strict=True)}
        return Subgoal(derived.definition, scope, atom.truth)

    def _cheapest(self, achiever: Achiever, bindings: Iterable[FrameBinding], best: _Supporter) -> _Supporter:
        """The best supporter by one effect of an operator, or ``best`` if that is as good."""
        for binding in bindings:
            self._looks.used += 1
            if self._looks.is_exceeded:
                break
            failing = achiever.failing(self.state, binding, best.cost - _LEAST)
            if failing is None:
                continue
            full = achiever.scope(binding) if failing else {}
            before = tuple([Subgoal(condition, full, True) for condition in failing])
            action = Action(achiever.schema.operator.name, achiever.arguments(binding))
            cost = _LEAST + (self._sum(before, best.cost - _LEAST) if before else self._harm(action))
            if cost < best.cost:
                best = _Supporter(cost, action, before)
            if best.cost <= _LEAST:
                break
        return best

    def _harm(self, action: Action) -> int:
        """How many of the conditions to keep are undone by an action that is possible at once."""
        if not self._kept:
            return 0
        undone = self._undone.get(action)
        if undone is None:
            after = self._heuristic.domain.apply(self.state, action)
            holds = self._heuristic.readings.holds
            undone = sum(holds(formula, scope, after) != truth for formula, scope, truth in self._kept)
            self._undone[action] = undone
        return undone
