"""The additive heuristic: the estimated number of actions until a condition holds, computed backwards.

A condition that does not hold is established by an operator that makes one of its atoms true (or false). The
checks of that operator must be established first, and so on, until every needed condition holds. Costs are
added up as if actions never interfered, as in the additive heuristic of Bonet and Geffner (2001). Estimation
starts at the goal, so that only conditions relevant to the goal are estimated.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Sequence, Set
from itertools import islice
from typing import NamedTuple, TypeAlias

import eai.logic.formula as f
from eai.logic.choice import AndNode, BipartiteMatchingNode, ExactCountNode, OrNode
from eai.logic.matching import find_heaviest_matching
from eai.planning.achievers import AchieversByPredicate, FailingConditionsByAction, GroundActions
from eai.planning.search import Limits, SearchEffort
from eai.planning.subgoal import GroundAtom, Subgoal, SubgoalParts, find_object_indices_of_arguments
from eai.world.action import Action
from eai.world.condition import FormulaEvaluator, Scope
from eai.world.derived import DefinedPredicate
from eai.world.domain import Domain
from eai.world.relation import iterate_bits, make_mask
from eai.world.state import State

Cost: TypeAlias = Callable[[Subgoal], float]
"""Function that returns the cost of a condition: the estimated number of actions that make it true."""


def choose_cheapest_subgoals_for_exact_count(
    number: int, conditions: Sequence[Subgoal], cost: Cost
) -> list[Subgoal] | None:
    """Choose ``number`` of some conditions: the cheapest ones, together with the negations of all others.

    This makes exactly ``number`` conditions true.

    The result is None if there are fewer than ``number`` conditions.
    """
    if number > len(conditions):
        return None
    opposites = [condition.negated for condition in conditions]

    def make_extra_cost_over_negation_sort_key(condition_index: int) -> tuple[bool, float]:
        own_cost = cost(conditions[condition_index])
        return own_cost == INFINITE, own_cost - cost(opposites[condition_index])

    order = sorted(range(len(conditions)), key=make_extra_cost_over_negation_sort_key)
    return [*(conditions[i] for i in order[:number]), *(opposites[i] for i in order[number:])]


def choose_cells_in_distinct_rows_and_columns(
    number: int, cells: Sequence[Sequence[Subgoal | None]], cost: Cost
) -> list[Subgoal] | None:
    """Choose ``number`` cells of a table with the lowest total cost, no two in one row or column.

    No chosen cell has an infinite cost. The result is None if there is no such choice.
    """
    weights = [
        [None if cell is None or (price := cost(cell)) == INFINITE else -price for cell in row]
        for row in cells
    ]
    pairs = find_heaviest_matching(weights, number)
    return None if pairs is None else [cell for i, j in pairs if (cell := cells[i][j]) is not None]


INFINITE = float("inf")
"""Cost of a condition that no action can establish."""

OPAQUE_COST = 2.0
"""Cost of a derived predicate that a function computes.

The cost is a guess, because only the predicates that the function reads are known.
"""

_HORIZONS = (2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 12.0, 18.0, 27.0, 40.0, 60.0, INFINITE)
"""Limits of the cost of actions, tried in this order so that actions of low cost are found first."""


def _round_up_to_predefined_cost_limit(limit: float) -> float:
    """Return the lowest of `_HORIZONS` that is at least a cost limit.

    If fewer different limits are in use, fewer estimates must be cached.
    """
    return _HORIZONS[bisect_left(_HORIZONS, limit)]


_MIN_COST = 1.0
"""Minimum cost of a condition that does not hold."""

_MAX_DEPTH = 60
"""Maximum nesting depth of computations of the cost of atoms. Deeper atoms count as unreachable."""


class _GroundFormulaKey(NamedTuple):
    """A formula (given by its ``id``), the objects of its free variables, and whether it must hold."""

    formula: int
    values: tuple[int, ...]
    truth: bool


_ConditionKey: TypeAlias = GroundAtom | _GroundFormulaKey


class _CheapestAction(NamedTuple):
    """The cheapest known action that establishes a condition, its cost, and its prerequisites."""

    cost: float
    action: Action | None
    prerequisites: tuple[Subgoal, ...]


_NO_SUPPORTER = _CheapestAction(INFINITE, None, ())


class AdditiveHeuristic:
    """The additive heuristic of one domain, and the data that the estimates from all states share."""

    def __init__(self, domain: Domain) -> None:
        self.domain = domain
        self.achievers = AchieversByPredicate(domain)
        self.readings = FormulaEvaluator(domain.vocabulary)
        self.derived = domain.vocabulary.derived_by_name
        self.static = frozenset(p.name for p in domain.vocabulary.predicates if p.static)


class _SubgoalSplitter:
    """Splits conditions into their parts, given one state.

    Args:
        evaluator: evaluates the formulas of the domain.
        state: the state.
        objects: the objects that actions may use.
    """

    def __init__(self, evaluator: FormulaEvaluator, state: State, objects: Sequence[int]) -> None:
        self._evaluator = evaluator
        self._state = state
        self._objects = objects

    def holds(self, subgoal: Subgoal) -> bool:
        """Whether a subgoal is reached in the state."""
        formula, scope, truth = subgoal
        return self._evaluator.holds(formula, scope, self._state) == truth

    def ground_atom_of_subgoal(self, atom: f.Atom, subgoal: Subgoal) -> GroundAtom:
        """Return a subgoal's atom with objects in place of its terms."""
        arguments = find_object_indices_of_arguments(atom, subgoal.scope, self._state.scene)
        return GroundAtom(atom.predicate, arguments, subgoal.truth)

    def split_into_parts(self, subgoal: Subgoal) -> SubgoalParts | None:
        """Return the parts of a compound condition and how many must hold; None for other conditions."""
        formula, scope, truth = subgoal
        match formula:
            case f.Not(operand):
                return AndNode((Subgoal(operand, scope, not truth),))
            case f.And(operands) | f.Or(operands):
                parts = tuple([Subgoal(operand, scope, truth) for operand in operands])
                return AndNode(parts) if isinstance(formula, f.And) == truth else OrNode(parts)
            case f.Implies(premise, conclusion):
                either = (Subgoal(premise, scope, not truth), Subgoal(conclusion, scope, truth))
                return OrNode(either) if truth else AndNode(either)
            case f.Exists(variable, body) | f.ForAll(variable, body):
                if isinstance(formula, f.Exists) == truth:
                    values = (
                        self._find_objects_meeting_any_conjunct(variable, body, scope)
                        if truth
                        else self._find_objects_usable_by_actions(variable)
                    )
                    return OrNode(self._make_subgoals_for_values(variable, body, scope, truth, values))
                violating = self._find_counterexample_values(variable, body, scope, truth)
                return AndNode(self._make_subgoals_for_values(variable, body, scope, truth, violating))
            case f.Exactly(count, variable, body) if truth:
                return ExactCountNode(
                    count,
                    self._make_subgoals_for_values(
                        variable, body, scope, truth, self._find_all_values(variable)
                    ),
                )
            case f.ForPairs() if truth:
                return self._make_matching_node_of_pair_subgoals(formula, scope)
            case _:
                return None

    def _make_subgoals_for_values(
        self, variable: f.Variable, body: f.Formula, scope: Scope, truth: bool, values: Sequence[int]
    ) -> tuple[Subgoal, ...]:
        return tuple([Subgoal(body, {**scope, variable.name: value}, truth) for value in values])

    def _find_all_values(self, variable: f.Variable) -> list[int]:
        return list(iterate_bits(self._state.scene.get_category_mask(variable.category)))

    def _find_objects_usable_by_actions(self, variable: f.Variable) -> list[int]:
        allowed = self._state.scene.get_category_mask(variable.category)
        return [i for i in self._objects if allowed >> i & 1]

    def _find_objects_meeting_any_conjunct(
        self, variable: f.Variable, body: f.Formula, scope: Scope
    ) -> list[int]:
        """Return the objects for which at least one conjunct of a quantifier's body holds.

        Only objects that actions may use are returned. If no conjunct holds for any of them, return them all.
        """
        usable = self._find_objects_usable_by_actions(variable)
        parts = body.operands if isinstance(body, f.And) else ()
        promising = {
            i for part in parts for i in self._evaluator.find_witnesses(variable, part, scope, self._state)
        }
        return [i for i in usable if i in promising] or usable

    def _find_counterexample_values(
        self, variable: f.Variable, body: f.Formula, scope: Scope, wanted_truth: bool
    ) -> list[int]:
        holding = self._evaluator.find_witnesses(variable, body, scope, self._state)
        if not wanted_truth:
            return list(holding)
        held = set(holding)
        return [i for i in self._find_all_values(variable) if i not in held]

    def _make_matching_node_of_pair_subgoals(
        self, formula: f.ForPairs, scope: Scope
    ) -> BipartiteMatchingNode[Subgoal]:
        first, second, body = formula.first, formula.second, formula.body
        rows, columns = self._find_all_values(first), self._find_all_values(second)
        count = min(len(rows), len(columns)) if formula.count is None else formula.count
        return BipartiteMatchingNode(
            count,
            tuple(
                tuple(
                    None if x == y else Subgoal(body, {**scope, first.name: x, second.name: y}, True)
                    for y in columns
                )
                for x in rows
            ),
        )


class CostEstimates:
    """Estimates of the number of actions from one state until a condition holds.

    Args:
        heuristic: the heuristic of the domain.
        state: the state.
        objects: the objects that actions may use.
        protected_subgoals: closed conditions that should stay true. Each such condition that an action makes
            false raises the cost of the action by one.
        looks: counter of actions tested for estimates; if its limit is exceeded, estimates are invalid.
        bindings: counter of values given to variables to find actions; if its limit is exceeded, estimates
            are invalid.
        previous: earlier estimates of the same search. Their tests of actions are used again if no fact that
            the conditions of an action read has changed.
        forbid_undoing_protected: whether actions that make a condition in ``protected_subgoals`` false are
            left out.
        excluded: further actions that are left out.

    Attributes:
        state: the state.
        objects: the objects that actions may use.
        bindings: counter of values given to variables.
    """

    def __init__(
        self,
        heuristic: AdditiveHeuristic,
        state: State,
        objects: Sequence[int],
        protected_subgoals: Sequence[Subgoal] = (),
        looks: SearchEffort | None = None,
        bindings: SearchEffort | None = None,
        previous: CostEstimates | None = None,
        *,
        forbid_undoing_protected: bool = False,
        excluded: Set[Action] = frozenset(),
    ) -> None:
        self.state = state
        self._forbid_undoing_protected = forbid_undoing_protected
        self._excluded = excluded
        self._is_filtered = forbid_undoing_protected or bool(excluded)
        self.objects = objects
        self.bindings = bindings or SearchEffort(Limits().bindings)
        self._heuristic = heuristic
        self._looks = looks or SearchEffort()
        self._unfolding = _SubgoalSplitter(heuristic.readings, state, objects)
        self.holds = self._unfolding.holds
        self.atom = self._unfolding.ground_atom_of_subgoal
        self._protected = [condition for condition in protected_subgoals if self.holds(condition)]
        self._usable = make_mask(objects)
        self._matches = heuristic.achievers.get_atom_achiever_finder(state, self._usable)
        self._candidates: dict[object, GroundActions] = {}
        self._kept_tests: FailingConditionsByAction = {}
        if previous is None or previous._matches is not self._matches:
            self._reachable = self._matches.make_reachable_action_finder(state)
        else:
            self._reachable = previous._reachable
            self._kept_tests, previous._kept_tests = previous._kept_tests, {}
            self._matches.remove_outdated_test_results(self._kept_tests, previous.state, state)
        self._other_tests: FailingConditionsByAction = {}
        self._supporters: dict[GroundAtom, _CheapestAction] = {}
        self._costs: dict[_ConditionKey, float] = {}
        self._failed_limits: dict[_ConditionKey, float] = {}
        self._undone: dict[Action, int] = {}
        # The conditions whose costs are being computed, each with its depth in the recursion.
        self._open: dict[_ConditionKey, int] = {}
        # Lowest depth of an open condition whose cost the innermost computation needed; _MAX_DEPTH for none.
        self._cut_depth = _MAX_DEPTH
        # Conditions for which no cost was found, perhaps only because an open condition had no cost yet.
        self._uncertain: list[_ConditionKey] = []
        # Condition without a cost -> the open condition whose missing cost may be the reason.
        self._causes: dict[_ConditionKey, _ConditionKey] = {}

    def estimate(self, subgoal: Subgoal, max_cost: float = INFINITE) -> float:
        """Estimate the number of actions until a condition holds.

        The estimate is infinite if no action can establish the condition, or if it is not below ``max_cost``
        (a number of `_HORIZONS`).
        """
        if self.holds(subgoal):
            return 0.0
        costs = (self._compute_cost(subgoal, limit) for limit in _HORIZONS if limit <= max_cost)
        return next((cost for cost in costs if cost < INFINITE), INFINITE)

    def find_cheapest_action_of_operators(self, operator_names: Sequence[str]) -> _CheapestAction:
        """Return the cheapest action, with any objects, of the operators with these names."""
        for limit in _HORIZONS:
            best = self._find_cheaper_action(operator_names, _CheapestAction(limit, None, ()))
            if best.action is not None:
                return best
        return _NO_SUPPORTER

    def split_into_cheapest_literal_subgoals(self, subgoal: Subgoal) -> tuple[Subgoal, ...]:
        """Return literals that together establish a condition, by the cheapest choice in each disjunction."""
        parts = (
            None
            if isinstance(subgoal.formula, f.Atom)
            else self.split_into_cheapest_sufficient_parts(subgoal)
        )
        if parts is None:
            return (subgoal,)
        return tuple([c for part in parts for c in self.split_into_cheapest_literal_subgoals(part)])

    def split_into_cheapest_sufficient_parts(self, subgoal: Subgoal) -> Sequence[Subgoal] | None:
        """Return the cheapest parts that together establish a condition.

        Costs are estimated numbers of actions. Return None if no choice of parts establishes the condition,
        or if the condition has no parts. An atom has a part, the formula that defines its predicate, only if
        the predicate is neither stored nor computed by a function.
        """
        if isinstance(subgoal.formula, f.Atom):
            definition = self._replace_atom_by_definition(self.atom(subgoal.formula, subgoal))
            return None if definition is None else (definition,)
        parts = self._unfolding.split_into_parts(subgoal)
        return None if parts is None else self._choose_cheapest_parts(parts)

    def find_prerequisites(self, subgoal: Subgoal) -> Sequence[Subgoal]:
        """Return the conditions that must hold before a condition can hold.

        For an atom of a stored predicate these are the prerequisites of the cheapest action that establishes
        the atom, otherwise the parts of the condition.
        """
        if isinstance(subgoal.formula, f.Atom) and subgoal.formula.predicate not in self._heuristic.derived:
            return self.find_supporter(self.atom(subgoal.formula, subgoal)).prerequisites
        parts = self.split_into_cheapest_sufficient_parts(subgoal) or ()
        return self.find_prerequisites(parts[0]) if len(parts) == 1 else parts

    def find_cheapest_disjuncts(self, subgoal: Subgoal) -> Sequence[Subgoal]:
        """Return the operands of a disjunction that have the lowest cost; () for other conditions."""
        parts = None if isinstance(subgoal.formula, f.Atom) else self._unfolding.split_into_parts(subgoal)
        costs = [(part, self.estimate(part)) for part in parts.parts] if isinstance(parts, OrNode) else []
        least = min((cost for _, cost in costs), default=INFINITE)
        return [part for part, cost in costs if cost == least < INFINITE]

    def find_supporter(self, atom: GroundAtom, limit: float = INFINITE) -> _CheapestAction:
        """Return the cheapest action that makes an atom of a stored predicate true, or false.

        The cost is infinite if no action costs less than ``limit``. An action does not count if one of its
        conditions can be established only after the atom. If a search without a cost limit finds no action,
        it is repeated with ``with_subgoals_on_parameters_not_in_atom`` (see
        `AchieversByPredicate.find_achievers`).
        """
        supporter = self._supporters.get(atom)
        if supporter is None:
            if self._would_find_no_cost_below_limit(atom, limit) or atom.predicate in self._heuristic.static:
                return _NO_SUPPORTER
            horizon = _round_up_to_predefined_cost_limit(limit)
            before = self._begin_cost_computation_and_save_values(atom)
            best = self._find_cheaper_action(atom, _CheapestAction(horizon, None, ()))
            if best.action is None and horizon == INFINITE:
                best = self._find_cheaper_action(atom, best, with_subgoals_on_parameters_not_in_atom=True)
            supporter = _NO_SUPPORTER if best.action is None else best
            self._end_cost_computation_and_store_cost(atom, supporter.cost, horizon, before)
            if best.action is not None:
                self._supporters[atom] = best
        return supporter if supporter.cost < limit else _NO_SUPPORTER

    def _find_cheaper_action(
        self,
        target: GroundAtom | Sequence[str],
        best: _CheapestAction,
        *,
        with_subgoals_on_parameters_not_in_atom: bool = False,
    ) -> _CheapestAction:
        """Return the first of the cheapest actions that cost less than the action ``best``, else ``best``.

        ``target`` is a literal that the action must make true, or the names of the operators that the action
        may execute.
        """
        matches = (
            self._matches.find_achievers_of_atom(
                target, with_subgoals_on_parameters_not_in_atom=with_subgoals_on_parameters_not_in_atom
            )
            if isinstance(target, GroundAtom)
            else self._matches.get_achievers_of_operators(target)
        )
        for match in matches:
            if match.has_min_number_of_failing_conditions(self.state, best.cost - _MIN_COST):
                continue
            candidates = self._candidates.get(match)
            if candidates is None:
                candidates = self._reachable.find_reachable_actions(match)
                if candidates is None:
                    candidates = match.find_actions_that_may_have_effect(
                        self.state, self._usable, self.bindings
                    )
                self._candidates[match] = candidates
            best = self._find_cheapest_candidate(candidates, best)
            if best.cost <= _MIN_COST:
                break
        return best

    def _compute_cost(self, subgoal: Subgoal, limit: float) -> float:
        """Return the cost of a condition that does not hold, or infinity if the cost is not below the limit.

        A condition that is needed to establish itself has infinite cost.
        """
        if limit <= _MIN_COST:
            return INFINITE
        match subgoal.formula:
            case f.Atom(predicate) as atom:
                ground = self.atom(atom, subgoal)
                if predicate not in self._heuristic.derived:
                    return self.find_supporter(ground, limit).cost
                key: _ConditionKey = ground
            case f.Exists() | f.ForAll() as formula:
                names = self._heuristic.readings.list_free_variables(formula)
                values = tuple([subgoal.scope[name] for name in names])
                key = _GroundFormulaKey(id(formula), values, subgoal.truth)
            case _:
                return self._compute_cost_of_parts(subgoal, limit)
        cost = self._costs.get(key, INFINITE)
        if cost == INFINITE:
            if self._would_find_no_cost_below_limit(key, limit):
                return INFINITE
            horizon = _round_up_to_predefined_cost_limit(limit)
            before = self._begin_cost_computation_and_save_values(key)
            cost = self._compute_cost_of_parts(subgoal, horizon)
            self._end_cost_computation_and_store_cost(key, cost, horizon, before)
            if cost < INFINITE:
                self._costs[key] = cost
        return cost if cost < limit else INFINITE

    def _would_find_no_cost_below_limit(self, key: _ConditionKey, limit: float) -> bool:
        """Whether computing the cost of a condition would find no cost below ``limit``.

        There are three reasons: an earlier computation found no cost below ``limit``, the cost is being
        computed already, or the costs of `_MAX_DEPTH` conditions are being computed.
        """
        depth = self._open.get(key)
        if depth is None:
            if self._failed_limits.get(key, 0.0) < limit:
                return len(self._open) >= _MAX_DEPTH
            while key in self._causes:
                key = self._causes[key]
            depth = self._open.get(key, _MAX_DEPTH)
        if depth < self._cut_depth:
            self._cut_depth = depth
        return True

    def _begin_cost_computation_and_save_values(self, key: _ConditionKey) -> tuple[int, int]:
        """Mark the cost of a condition as being computed. Return values for the end of this computation."""
        self._causes.pop(key, None)
        self._open[key] = len(self._open)
        before = self._cut_depth, len(self._uncertain)
        self._cut_depth = _MAX_DEPTH
        return before

    def _end_cost_computation_and_store_cost(
        self, key: _ConditionKey, cost: float, cost_limit: float, values_saved_at_begin: tuple[int, int]
    ) -> None:
        """Store the cost of a condition; an infinite cost means that no cost below ``cost_limit`` was found.

        Such a failure is uncertain if it was caused by another condition whose cost is still being computed.
        It then proves only that no cost is below the cost of this other condition plus one. If no cost of the
        other condition is found, its cost limit counts as its cost.

        ``values_saved_at_begin`` is the result of `_begin_cost_computation_and_save_values`.
        """
        depth = self._open.pop(key)
        cut, self._cut_depth = self._cut_depth, values_saved_at_begin[0]
        if cut < depth:
            self._causes[key] = next(islice(self._open, cut, None))
        proved_limit = min(cost, cost_limit) + _MIN_COST
        for other in self._uncertain[values_saved_at_begin[1] :]:
            self._failed_limits[other] = min(self._failed_limits[other], proved_limit)
        if cost < INFINITE:
            return
        self._failed_limits[key] = cost_limit
        if cut < depth:
            self._uncertain.append(key)
            self._cut_depth = min(self._cut_depth, cut)
        else:
            del self._uncertain[values_saved_at_begin[1] :]

    def _compute_cost_of_parts(self, subgoal: Subgoal, limit: float) -> float:
        if isinstance(subgoal.formula, f.Atom):
            definition = self._replace_atom_by_definition(self.atom(subgoal.formula, subgoal))
            if definition is not None:
                return self._compute_cost(definition, limit)
            return OPAQUE_COST if limit > OPAQUE_COST else INFINITE
        parts = self._unfolding.split_into_parts(subgoal)
        if isinstance(parts, OrNode):
            return self._find_least_cost(parts.parts, limit)
        conditions = None if parts is None else self._choose_cheapest_parts(parts)
        if conditions is None:
            return INFINITE
        return self._sum_costs_of_failing_conditions(
            [(part, None) for part in conditions if not self.holds(part)], limit
        )

    def _find_least_cost(self, conditions: Sequence[Subgoal], limit: float) -> float:
        best = INFINITE
        for condition in conditions:
            best = min(best, self._compute_cost(condition, min(best, limit)))
            if best <= _MIN_COST:
                break
        return best

    def _sum_costs_of_failing_conditions(
        self, failing: Sequence[tuple[Subgoal, GroundAtom | None]], limit: float
    ) -> float:
        """Return the sum of the costs of failing conditions, or infinity if the sum reaches the limit.

        A condition that is known as a literal of a stored predicate is paired with this literal. Other
        conditions are paired with None.
        """
        rest, total = limit - (len(failing) - 1) * _MIN_COST, 0.0
        for _, atom in failing[1:]:  # a known failure here makes the cost of the first condition needless
            if (
                atom is not None
                and atom not in self._supporters
                and self._would_find_no_cost_below_limit(atom, rest)
            ):
                return INFINITE
        for condition, atom in failing:
            if rest <= _MIN_COST:
                return INFINITE
            cost = self.find_supporter(atom, rest).cost if atom else self._compute_cost(condition, rest)
            if cost == INFINITE:
                return INFINITE
            total += cost
            rest += _MIN_COST - cost
        return total

    def _choose_cheapest_parts(self, parts: SubgoalParts) -> Sequence[Subgoal] | None:
        """Return the cheapest parts that together make a compound condition true; None if no parts do."""
        match parts:
            case AndNode(conditions):
                return conditions
            case OrNode(conditions):
                cheapest = self._find_cheapest(conditions)
                return None if cheapest is None else (cheapest,)
            case ExactCountNode(number, conditions):
                return choose_cheapest_subgoals_for_exact_count(number, conditions, self.estimate)
            case BipartiteMatchingNode(number, cells):
                return choose_cells_in_distinct_rows_and_columns(number, cells, self.estimate)

    def _find_cheapest(self, conditions: Sequence[Subgoal]) -> Subgoal | None:
        for condition in conditions:
            if self.holds(condition):
                return condition
        for limit in _HORIZONS:
            best, cheapest = limit, None
            for condition in conditions:
                cost = self._compute_cost(condition, best)
                if cost < best:
                    best, cheapest = cost, condition
            if cheapest is not None:
                return cheapest
        return None

    def _replace_atom_by_definition(self, atom: GroundAtom) -> Subgoal | None:
        derived = self._heuristic.derived.get(atom.predicate)
        if not isinstance(derived, DefinedPredicate):
            return None
        scope = {p.name: index for p, index in zip(derived.parameters, atom.arguments, strict=True)}
        return Subgoal(derived.definition, scope, atom.truth)

    def _find_cheapest_candidate(self, candidates: GroundActions, best: _CheapestAction) -> _CheapestAction:
        for candidate in candidates:
            if self._is_filtered and self._is_left_out(candidate.action):
                continue
            tests = self._kept_tests if candidate.is_test_kept else self._other_tests
            failing = tests.get(candidate)
            if failing is None:
                if self._looks.spend_and_check_limit():
                    break
                failing = tests[candidate] = candidate.find_failing_conditions(self.state)
            max_rest = best.cost - _MIN_COST
            if len(failing) >= max_rest:
                continue
            cost = _MIN_COST + (
                self._sum_costs_of_failing_conditions(failing, max_rest)
                if failing
                else self._count_protected_conditions_broken_by(candidate.action)
            )
            if cost < best.cost:
                best = _CheapestAction(cost, candidate.action, tuple([part for part, _ in failing]))
                if cost <= _MIN_COST:
                    break
        return best

    def _is_left_out(self, action: Action) -> bool:
        return action in self._excluded or (
            self._forbid_undoing_protected and self._count_protected_conditions_broken_by(action) > 0
        )

    def _count_protected_conditions_broken_by(self, action: Action) -> int:
        if not self._protected:
            return 0
        undone = self._undone.get(action)
        if undone is None:
            after = self._heuristic.domain.apply(self.state, action)
            holds = self._heuristic.readings.holds
            undone = sum(holds(formula, scope, after) != truth for formula, scope, truth in self._protected)
            self._undone[action] = undone
        return undone
