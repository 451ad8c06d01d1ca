"""Relaxed planning: estimate the distance to the goal as if no true literal were ever lost.

A relaxed state is a set of literals that only grows (`grounding`). There is one exception. If every action
that adds a missing atom of the goal deletes a true atom of the goal, the true atom must be made true again.
Example: a machine must be switched on again if every action that closes its door switches it off.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import reduce
from operator import or_
from typing import NamedTuple, TypeAlias

from eai.pddl.grounding import (
    GroundProblem,
    LiteralMask,
    StateMask,
    estimate_cost_of_condition_lookup,
    iterate_one_bit_masks,
    map_bits_to_indices_of_containing_masks,
)
from eai.planning.search import SearchEffort

_ALL_LITERALS = -1
"""Bit mask in which all bits are set, so that it contains the literals of every problem."""

_MAX_ROUNDS = 2
"""Maximum number of attempts to make several literals true at once, if one makes another false."""

_MAX_REPEAT_DEPTH = 2
"""Maximum recursion depth for making literals true again that held at the start and were lost.

The depth grows by 1 if an action for this purpose needs another lost literal.
"""

_MAX_RULES = 2_000
"""Maximum number of rules (effects of actions) that one lookahead (`_RelaxedPlanFollower`) tries."""


class _RelaxedRule(NamedTuple):
    """A conditional effect as a rule: the number of its action, and the literals it needs and makes true."""

    action: int
    needs: int
    makes: int


class _UnreachedLiteral(NamedTuple):
    """A literal that is not yet true, and masks of the rules that need it and that make it true."""

    literal: int
    needing: int
    making: int


class _RelaxedLayers(NamedTuple):
    """Relaxed states, each one step after the one before; and the rules that each of the steps applies."""

    reached: list[int]
    fired: list[int]


class _RelaxedPlan(NamedTuple):
    """A relaxed plan: its number of actions, and the bit mask of its actions that are possible now."""

    length: int
    helpful: int


class Relaxation:
    """Relaxed planning for one ground problem: a literal that is true once stays true.

    Args:
        problem: the problem.
        looks: counter of the literals tested for estimates. If it exceeds its limit, results are invalid.
    """

    def __init__(self, problem: GroundProblem, looks: SearchEffort) -> None:
        self._looks = looks
        self._problem = problem
        self._again = 2 * problem.atoms
        self._prices = _map_goal_atoms_to_unavoidable_deletion_masks(problem)
        self._rules = [
            _RelaxedRule(number, action.needs | change.needs, change.add | change.delete << problem.atoms)
            for number, action in enumerate(problem.actions)
            for change in action.changes
        ]
        self._price = estimate_cost_of_condition_lookup(len(self._rules))
        self._making = map_bits_to_indices_of_containing_masks([rule.makes for rule in self._rules])
        needing = map_bits_to_indices_of_containing_masks([rule.needs for rule in self._rules])
        asked = problem.add_disjuncts_of_needed_disjunctions(
            reduce(or_, [rule.needs for rule in self._rules], problem.goal)
        )
        self._asked = [
            _UnreachedLiteral(literal, needing.get(literal, 0), self._making.get(literal, 0))
            for literal in iterate_one_bit_masks(asked)
        ]

    def find_relaxed_plan(self, state: StateMask, true_literals: LiteralMask) -> _RelaxedPlan | None:
        """Return a relaxed plan from a state to the goal, or None if there is no relaxed plan.

        Without a relaxed plan there is no plan at all. ``true_literals`` are the literals that the state
        makes true (`GroundProblem.find_state_literals`).
        """
        again = self._find_true_goal_atoms_that_must_be_lost(state)
        goal = self._problem.goal | again << self._again
        layers = self._build_relaxed_layers(true_literals, goal, again)
        return self._extract_relaxed_plan(goal, layers) if not goal & ~layers.reached[-1] else None

    def _find_true_goal_atoms_that_must_be_lost(self, state: StateMask) -> LiteralMask:
        """Return the goal's true atoms that will become false before the whole goal holds."""
        missing = self._problem.goal & ~state
        lost = 0
        for bit, price in self._prices.items():
            if missing & bit:
                lost |= price
        return lost & state

    def _build_relaxed_layers(
        self, start_literals: LiteralMask, goal: int, atoms_to_make_true_again: int
    ) -> _RelaxedLayers:
        """Return relaxed states, one for each step, until they contain the goal or stop growing.

        No more states follow if the budget is exceeded. The atoms in ``atoms_to_make_true_again`` are true at
        the start, but will be lost and must be made true again. So ``goal`` has a second literal for each
        such atom. Actions that add the atom make the second literal true.
        """
        literals = start_literals
        lacking = [
            literal_lacking for literal_lacking in self._asked if not literals & literal_lacking.literal
        ]
        lacking += [
            _UnreachedLiteral(bit << self._again, 0, self._making.get(bit, 0))
            for bit in iterate_one_bit_masks(atoms_to_make_true_again)
        ]
        layers, waiting = _RelaxedLayers([literals], []), (1 << len(self._rules)) - 1
        looks = self._looks
        while goal & ~literals and not looks.is_limit_exceeded:
            looks.used += self._price * len(lacking)
            blocked = 0
            for _, needing, _ in lacking:
                blocked |= needing
            fired = waiting & ~blocked
            waiting &= blocked
            before = literals
            for literal, _, making in lacking:
                if making & fired:
                    literals |= literal
            if literals != before:
                literals = self._problem.add_literals_of_true_disjunctions(literals)
                lacking = [
                    literal_lacking for literal_lacking in lacking if not literals & literal_lacking.literal
                ]
            layers.fired.append(fired)
            layers.reached.append(literals)
            if literals == before:
                break
        return layers

    def _extract_relaxed_plan(self, goal: int, layers: _RelaxedLayers) -> _RelaxedPlan:
        """Return the relaxed plan, found backwards: the first rule that makes a literal true is taken."""
        chosen, helpful = set[int](), 0
        needed = self._problem.replace_disjunctions_by_true_disjuncts(goal, layers.reached[-1])
        for relaxed_step in range(len(layers.fired) - 1, -1, -1):
            before, fired = layers.reached[relaxed_step], layers.fired[relaxed_step]
            missing = needed & ~before
            needed &= before
            while missing:
                action, needs, makes = self._find_first_rule_making_any_literal_true(missing, fired)
                missing &= ~(makes | makes << self._again)
                chosen.add(action)
                if relaxed_step == 0:
                    helpful |= 1 << action
                needed |= self._problem.replace_disjunctions_by_true_disjuncts(needs, before)
        return _RelaxedPlan(len(chosen), helpful)

    def build_all_layers(self, literals: LiteralMask) -> _RelaxedLayers:
        """Return the relaxed states after a set of literals, one for each step, until they stop growing."""
        return self._build_relaxed_layers(literals, _ALL_LITERALS, 0)

    def find_rules_making_literal_true(self, literal: int, rules_mask: int) -> Iterator[_RelaxedRule]:
        """Yield the rules (conditional effects) among `rules_mask` that make a literal true, in order."""
        for bit in iterate_one_bit_masks(self._making.get(literal, 0) & rules_mask):
            yield self._rules[bit.bit_length() - 1]

    def _find_first_rule_making_any_literal_true(
        self, missing_literals: LiteralMask, fired_rules_mask: int
    ) -> _RelaxedRule:
        """Return the first rule (conditional effect) that makes any of the missing literals true."""
        making = 0
        for literal in iterate_one_bit_masks(missing_literals):
            making |= self._making.get(literal) or self._making.get(literal >> self._again, 0)
        making &= fired_rules_mask
        return self._rules[(making & -making).bit_length() - 1]


def _map_goal_atoms_to_unavoidable_deletion_masks(problem: GroundProblem) -> dict[int, int]:
    """Return a mapping from each goal atom to the goal atoms that every action adding it makes false."""
    goal = problem.goal & (1 << problem.atoms) - 1
    prices: dict[int, int] = {}
    for action in problem.actions:
        adds = deletes = 0
        for change in action.changes:
            adds |= change.add
            if not change.needs:
                deletes |= change.delete
        lost = deletes & ~adds & goal
        for bit in iterate_one_bit_masks(adds & goal):
            prices[bit] = prices.get(bit, goal) & lost
    return {bit: price for bit, price in prices.items() if price}


_ActionNumber: TypeAlias = int

_ActionsAndStateSnapshot: TypeAlias = tuple[int, StateMask, LiteralMask]
"""A point to which a lookahead may return: number of actions so far, state, and its true literals."""


class _MissingGoalCounts(NamedTuple):
    """Number of false goal literals that were also false at the start, and number of all false literals."""

    false_at_start: int
    all: int


def find_lookahead_actions_and_states(
    problem: GroundProblem, relaxation: Relaxation, state: StateMask, true_literals: LiteralMask
) -> Sequence[tuple[_ActionNumber, StateMask]]:
    """Return actions from a state that reach more of the goal, each with the state after it.

    The actions carry out relaxed planning (after Vidal 2004). A relaxed plan ignores that true atoms may be
    lost: it visits a place once although several things must be brought there. Here each literal is made true
    just before the action that needs it, and again if it has been lost. The final state is often the goal, or
    close to it.
    """
    return _RelaxedPlanFollower(
        problem, relaxation, state, true_literals
    ).find_lookahead_actions_with_next_states()


class _RelaxedPlanFollower:
    """Follows relaxed plans from one state, and stores the actions so far and the state that they reach."""

    def __init__(
        self, problem: GroundProblem, relaxation: Relaxation, state: StateMask, literals: LiteralMask
    ) -> None:
        self._problem = problem
        self._relaxation = relaxation
        self._rules_left = _MAX_RULES
        self._layers = relaxation.build_all_layers(literals)
        self._state, self._start, self._held = state, literals, literals
        self._taken: list[tuple[_ActionNumber, StateMask]] = []

    def find_lookahead_actions_with_next_states(self) -> Sequence[tuple[_ActionNumber, StateMask]]:
        """Make missing literals of the goal true, one after the other, until no more can be made true.

        Return the actions that do this, each with the state after it.
        """
        before = None
        while (goal := self._problem.goal & ~self._held) and (
            missing := self._count_missing_goals()
        ) != before:
            before = missing
            for literal in self._order_literals_reached_latest_first(goal, len(self._layers.fired)):
                if not self._held & literal:
                    self._try_to_add_actions_reaching_goal_literal(literal)
        return self._taken

    def _count_missing_goals(self) -> _MissingGoalCounts:
        missing = self._problem.goal & ~self._held
        return _MissingGoalCounts((missing & ~self._start).bit_count(), missing.bit_count())

    def _try_to_add_actions_reaching_goal_literal(self, literal: int) -> None:
        """Make a goal literal true, by the first action after which fewer goal literals are missing.

        Nothing changes if no action achieves this.
        """
        missing, start_point = self._count_missing_goals(), self._make_snapshot_of_actions_and_state()
        for relaxed_step, fired in enumerate(self._layers.fired):
            for rule in self._relaxation.find_rules_making_literal_true(literal, fired):
                if self._apply_rule_if_possible(rule, relaxed_step) and self._count_missing_goals() < missing:
                    return
                self._restore_actions_and_state(start_point)

    def _apply_rule_if_possible(self, rule: _RelaxedRule, relaxed_step: int) -> bool:
        """Make the precondition of a rule true, and apply its action. Return whether this is possible."""
        self._rules_left -= 1
        if self._rules_left < 0 or not self._try_to_reach_literals_together(rule.needs, relaxed_step):
            return False
        self._state = self._problem.apply_action(rule.action, self._state, self._held)
        self._held = self._problem.find_state_literals(self._state)
        self._taken.append((rule.action, self._state))
        return True

    def _try_to_reach_literals_together(self, needed: LiteralMask, relaxed_step: int) -> bool:
        """Add actions after which several literals are true together. Return whether this is possible.

        `_try_to_reach_literal` adds the actions for each false literal, with the same ``relaxed_step``. The
        first attempt begins with the literals that relaxed planning reaches last. If the attempt fails, a
        second attempt treats these literals last. If both attempts fail, all these actions are undone.
        """
        start_point = self._make_snapshot_of_actions_and_state()
        for last in (False, True):
            for _ in range(_MAX_ROUNDS):
                missing = self._order_literals_reached_latest_first(needed & ~self._held, relaxed_step)
                for literal in missing[::-1] if last else missing:
                    if not self._held & literal:
                        self._try_to_reach_literal(literal, relaxed_step)
                if not needed & ~self._held:
                    return True
            self._restore_actions_and_state(start_point)
        return False

    def _try_to_reach_literal(self, literal: int, relaxed_step: int) -> None:
        """Apply the first rule (effect of an action) that makes a literal true, if the rule is possible.

        The steps of relaxed planning are numbered from 0. A rule is tried only if its step is before
        ``relaxed_step``. If ``relaxed_step`` is 0 or negative, the literal was true at the start and has been
        lost. Then rules of step 0 are tried, until ``relaxed_step`` has fallen to `-_MAX_REPEAT_DEPTH`.
        """
        for before, fired in enumerate(
            self._layers.fired[: max(relaxed_step, int(relaxed_step > -_MAX_REPEAT_DEPTH))]
        ):
            for rule in self._relaxation.find_rules_making_literal_true(literal, fired):
                self._apply_rule_if_possible(rule, min(before, relaxed_step - 1))
                return

    def _order_literals_reached_latest_first(self, missing: LiteralMask, relaxed_step: int) -> list[int]:
        """Return the missing literals in order: literals that take longest to reach come first."""
        missing = self._problem.replace_disjunctions_by_true_disjuncts(
            missing, self._layers.reached[max(relaxed_step, 0)]
        )
        ordered = list[int]()
        for reached in self._layers.reached[max(relaxed_step, 0) :: -1]:
            ordered += iterate_one_bit_masks(missing & ~reached)
            missing &= reached
        return [*ordered, *iterate_one_bit_masks(missing)]

    def _make_snapshot_of_actions_and_state(self) -> _ActionsAndStateSnapshot:
        return len(self._taken), self._state, self._held

    def _restore_actions_and_state(self, snapshot: _ActionsAndStateSnapshot) -> None:
        """Undo all actions that the lookahead has taken since a point."""
        taken, self._state, self._held = snapshot
        del self._taken[taken:]
