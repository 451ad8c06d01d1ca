"""Landmarks: sets of actions. Every plan that succeeds contains an action of each landmark.

Landmarks are found in the delete relaxation: deletions are ignored and actions are repeated. If the actions
of a plan do not reach the goals in this relaxation, the plan lacks actions. All lacking actions that can
come first form a cut (a disjunctive landmark). The plan misses a cut if it has no action of the cut. A
smallest set that has an action of every missed cut is added to the plan's actions. Then the next cut is
computed, until the goals are reachable (an implicit hitting set, Bonet and Helmert 2010). A plan needs at
least as many more actions as such a smallest set has.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from functools import cached_property, reduce
from operator import or_
from typing import TypeAlias

import eai.logic.formula as f
from eai.planning.conflict_changes import NecessaryChangeFinder, make_change_sort_key
from eai.planning.effect_schema import FactChange
from eai.planning.search import SearchEffort
from eai.planning.subgoal import Subgoal, find_object_indices_of_arguments
from eai.world.action import Action
from eai.world.condition import Scope
from eai.world.derived import find_definition
from eai.world.relation import iterate_bits
from eai.world.state import State

Cut: TypeAlias = frozenset[Action]
"""Set of actions: every plan that succeeds contains at least one of them."""

_TRUE, _FALSE = 0, 1
"""Numbers of two nodes in the graph: the condition that always holds, and the condition that never holds."""

_MAX_CONDITIONS = 30_000
"""Maximum number of conditions in a `_RelaxationGraph`; further conditions are assumed to hold."""

_MAX_VALUES = 60
"""Maximum number of values of a quantified variable that `_RelaxationGraph` examines one by one."""

_MAX_BRANCHES = 200
"""Maximum number of branches of the search for a smallest set with an action of every landmark.

A landmark (cut) is a set of actions; every plan that succeeds has at least one action of the set. If there
are more branches, disjoint landmarks are counted instead.
"""

_MAX_CUT_SIZE = 250
"""Maximum number of actions of a landmark (cut); only the first landmark may have more.

A landmark is a set of actions; every plan that succeeds has at least one action of the set.
"""

_CONDITIONS_PER_EFFORT = 20
"""Number of graph nodes for which each search for a landmark counts one more operation (`SearchEffort`)."""


class _RelaxationGraph:
    """The delete relaxation of one episode: a graph of conditions and changes of facts.

    A condition needs either all of its parts, or any single part. A change needs one action that makes the
    change. The graph begins with the goals. `find_cut_disjoint_from` extends it backwards until the goals
    are reached or no action can be added. Its actions are steps of the plan, and actions that were passed to
    this method.

    Args:
        change_finder: the changes that conditions need, and the actions that make changes.
        initial: the state in which plans begin.
        goals: the goals of plans.
        steps: the steps of a plan. Their objects need not be among the objects of ``change_finder``.
    """

    def __init__(
        self,
        change_finder: NecessaryChangeFinder,
        initial: State,
        goals: Iterable[Subgoal],
        steps: Iterable[Action],
    ) -> None:
        self._change_finder = change_finder
        self._initial = initial
        self._actions = [*dict.fromkeys(steps)]
        self._others = [
            step for step in self._actions if step not in change_finder.get_actions_of_operator(step.operator)
        ]
        self._parts: list[tuple[int, ...]] = [(), ()]
        self._missing = [0, 1]
        self._cut_sizes = [0, 0]
        self._above: list[list[int]] = [[], []]
        self._numbers: dict[object, int] = {}
        self._formulas: list[f.Formula] = []
        self._changes: dict[int, FactChange] = {}
        self._tried: dict[int, int] = {}
        self._needs: dict[Action, list[int]] = {}
        self._makers: dict[int, dict[Action, list[int]]] = {}
        self._grouped: dict[int, list[tuple[dict[Action, None], list[int]]]] = {}
        self._made: dict[int, list[tuple[Action, int]]] = {}
        self._open: set[object] = set()
        self._goal = self._add_conjunction_node(
            [self._get_condition_node(goal.formula, goal.scope, goal.truth) for goal in goals]
        )

    @property
    def node_count(self) -> int:
        """Number of nodes in the graph: conditions, and changes of facts."""
        return len(self._parts)

    def find_cut_disjoint_from(self, actions: Collection[Action]) -> list[Action] | None:
        """Return a landmark (cut) without the given actions; None if these actions may reach the goals.

        A landmark is a set of actions; every plan that succeeds has at least one action of the set.
        """
        self._actions += sorted({*actions}.difference(self._actions))
        while True:
            reached = self._mark_reached_conditions(actions)
            if reached[self._goal]:
                return None
            between = self._find_nodes_separating_actions_from_goals(actions, reached)
            if not self._add_actions_making_fact_changes(between):
                break
        cut_actions: dict[Action, None] = {}
        is_apart = between.keys().isdisjoint
        for number in between:
            if number in self._changes:
                for makers, conditions in self._group_actions_by_conditions(number):
                    if is_apart(conditions):
                        cut_actions.update(makers)
                cut_actions.update(dict.fromkeys([a for a in self._others if a in self._makers[number]]))
        return [action for action in cut_actions if action not in actions]

    def _find_nodes_separating_actions_from_goals(
        self, actions: Collection[Action], reached: bytearray
    ) -> dict[int, None]:
        """Return the numbers of the nodes that a search backwards from the goals visits, goals first.

        If a condition needs all parts, the search continues at one unreached part, otherwise at every part.
        From a change of a fact, it continues at the conditions on which given actions make the change.
        """
        seen = {self._goal: None}
        queue = [self._goal]
        for number in queue:  # the queue grows meanwhile
            parts: Iterable[int] = self._parts[number]
            if number in self._changes:
                parts = [
                    part
                    for a, alternatives in self._makers[number].items()
                    if a in actions
                    for part in alternatives
                ]
            elif self._missing[number] > 1:
                lacking = [part for part in parts if not reached[part]]
                if not seen.keys().isdisjoint(lacking):
                    continue
                parts = (min(lacking, key=self._cut_sizes.__getitem__),)
            for part in parts:
                if part not in seen:
                    seen[part] = None
                    queue.append(part)
        return seen

    def _group_actions_by_conditions(self, change_node: int) -> list[tuple[dict[Action, None], list[int]]]:
        """Return the actions that make a change of a fact, grouped by the conditions of their effects.

        ``change_node`` is the number of the change's node. A group is a pair: its actions, and the numbers of
        the nodes of its conditions. Conditions that hold at the start are left out, and so are groups with a
        condition that can never hold.
        """
        groups = self._grouped.get(change_node)
        if groups is None:
            makers = [
                (actions, {self._get_condition_node(*condition, True) for condition in conditions})
                for actions, conditions in self._change_finder.group_actions_making_change_by_conditions(
                    self._changes[change_node]
                )
            ]
            groups = self._grouped[change_node] = [
                (dict.fromkeys(actions), [*(conditions - {_TRUE})])
                for actions, conditions in makers
                if _FALSE not in conditions
            ]
        return groups

    def _mark_reached_conditions(self, actions: Collection[Action]) -> bytearray:
        missing, reached = self._missing.copy(), bytearray(len(self._missing))
        pending = [_TRUE]
        while pending:
            number = pending.pop()
            if reached[number]:
                continue
            reached[number] = 1
            for above in self._above[number]:
                missing[above] -= 1
                if missing[above] <= 0 and not reached[above]:
                    pending.append(above)
            pending += [change for action, change in self._made.get(number, ()) if action in actions]
        return reached

    def _add_actions_making_fact_changes(self, change_node_numbers: Iterable[int]) -> bool:
        """Add actions to this graph as ways to change facts. Return whether any action was added.

        The changes are given by the numbers of their nodes; nodes of conditions are skipped.
        """
        fresh = [
            (number, action)
            for number in change_node_numbers
            if number in self._changes
            for action in self._actions[self._tried[number] :]
        ]
        self._tried.update(dict.fromkeys([number for number, _ in fresh], len(self._actions)))
        return sum([self._add_action_making_change(number, action) for number, action in fresh]) > 0

    def _add_action_making_change(self, change_node_number: int, action: Action) -> bool:
        """Add an action to the graph as a way to change a fact, if the action's conditions can be met.

        The change is given by the number of its node. Return whether the action was added.
        """
        alternatives: list[int] = []
        for conditions in self._change_finder.find_effect_conditions(
            action, self._changes[change_node_number]
        ):
            condition_numbers = [self._get_condition_node(*part, True) for part in conditions]
            condition = self._add_conjunction_node(
                [*self._find_precondition_nodes(action), *condition_numbers]
            )
            if condition != _FALSE:
                alternatives.append(condition)
                self._made.setdefault(condition, []).append((action, change_node_number))
        if alternatives:
            self._makers[change_node_number][action] = alternatives
        return bool(alternatives)

    def _find_precondition_nodes(self, action: Action) -> list[int]:
        numbers = self._needs.get(action)
        if numbers is None:
            needs = self._change_finder.find_preconditions(action)
            numbers = self._needs[action] = [
                self._get_condition_node(*condition, True) for condition in needs
            ]
        return numbers

    def _get_condition_node(self, formula: f.Formula, scope: Scope, truth: bool) -> int:
        key = id(formula), tuple([scope[name] for name in self._change_finder.names(formula)]), truth
        number = self._numbers.get(key)
        if number is None:
            self._formulas.append(formula)  # keeps the formula alive, so that its id stays unique
            number = self._numbers[key] = self._add_condition_node(formula, scope, truth)
        return number

    def _add_condition_node(self, formula: f.Formula, scope: Scope, truth: bool) -> int:
        if (
            self._change_finder.holds(formula, scope, self._initial) == truth
            or len(self._parts) > _MAX_CONDITIONS
        ):
            return _TRUE
        match formula:
            case f.Not(operand):
                return self._get_condition_node(operand, scope, not truth)
            case f.And(operands) | f.Or(operands):
                parts = [(operand, scope) for operand in operands]
                return self._add_compound_node(parts, truth, all_needed=isinstance(formula, f.And) == truth)
            case f.Exists(variable, body) | f.ForAll(variable, body):
                values = [*iterate_bits(self._initial.scene.get_category_mask(variable.category))]
                if len(values) <= _MAX_VALUES:
                    parts = [(body, {**scope, variable.name: value}) for value in values]
                    return self._add_compound_node(
                        parts, truth, all_needed=isinstance(formula, f.ForAll) == truth
                    )
            case f.Atom():
                return self._add_atom_node(formula, scope, truth)
        return self._add_changes_node(
            self._change_finder.find_necessary_changes(formula, scope, self._initial, truth=truth)
        )

    def _add_compound_node(
        self, parts: Sequence[tuple[f.Formula, Scope]], truth: bool, *, all_needed: bool
    ) -> int:
        numbers: list[int] = []
        for formula, scope in sorted(
            parts, key=lambda part: self._change_finder.count_predicates_changed_by_actions(part[0])
        ):
            number = self._get_condition_node(formula, scope, truth)
            if number == (_FALSE if all_needed else _TRUE):
                return number
            numbers.append(number)
        return self._add_conjunction_node(numbers) if all_needed else self._add_disjunction_node(numbers)

    def _add_atom_node(self, atom: f.Atom, scope: Scope, truth: bool) -> int:
        arguments = find_object_indices_of_arguments(atom, scope, self._initial.scene)
        derived = self._change_finder.derived(atom.predicate)
        defined = None if derived is None else find_definition(derived)
        if defined is None:
            return self._add_changes_node(
                self._change_finder.find_necessary_changes(atom, scope, self._initial, truth=truth)
            )
        key = atom.predicate, arguments, truth
        result = self._numbers.get(key)
        if result is not None and not truth and key in self._open:  # circular definition
            return self._add_changes_node(self._change_finder.find_all_fact_changes_of_predicates_in(atom))
        if result is None:  # a recursive definition needs the number of this node
            number = self._numbers[key] = self._add_graph_node((), 1, 0)
            self._open.add(key)
            inner = dict(zip([p.name for p in defined.parameters], arguments, strict=True))
            part = self._get_condition_node(defined.definition, inner, truth)
            self._open.discard(key)
            self._parts[number] = (part,)
            self._cut_sizes[number] = self._cut_sizes[part]
            self._above[part].append(number)
            self._numbers[key] = result = part if part in (_TRUE, _FALSE) else number
        return result

    def _add_changes_node(self, changes: Iterable[FactChange]) -> int:
        return self._add_disjunction_node(
            [self._add_change_node(change) for change in sorted(changes, key=make_change_sort_key)]
        )

    def _add_change_node(self, change: FactChange) -> int:
        number = self._numbers.get(change)
        if number is None:
            makers = self._change_finder.find_actions_making_change(change) or [
                a for a in self._others if self._change_finder.may_make_change(a, change)
            ]
            number = self._numbers[change] = self._add_graph_node((), 1, len(makers)) if makers else _FALSE
            if makers:
                self._changes[number] = change
                self._makers[number] = {}
                self._tried[number] = 0
        return number

    def _add_conjunction_node(self, parts: Iterable[int]) -> int:
        numbers = tuple(dict.fromkeys([part for part in parts if part != _TRUE]))
        return _FALSE if _FALSE in numbers else self._get_and_or_node(numbers, len(numbers), _TRUE)

    def _add_disjunction_node(self, parts: Iterable[int]) -> int:
        numbers = tuple(dict.fromkeys([part for part in parts if part != _FALSE]))
        return _TRUE if _TRUE in numbers else self._get_and_or_node(numbers, 1, _FALSE)

    def _get_and_or_node(
        self, part_nodes: tuple[int, ...], needed_part_count: int, node_if_no_parts: int
    ) -> int:
        """Return the number of the node of a conjunction or disjunction, given the nodes of its parts.

        ``needed_part_count`` is the number of parts that must hold: 1 in a disjunction, all in a conjunction.
        If there is only one part, its node is returned.
        """
        if len(part_nodes) < 2:
            return part_nodes[0] if part_nodes else node_if_no_parts
        key = needed_part_count > 1, part_nodes
        number = self._numbers.get(key)
        if number is None:
            widths = [self._cut_sizes[part] for part in part_nodes]
            width = min(widths) if needed_part_count > 1 else sum(widths)
            number = self._numbers[key] = self._add_graph_node(part_nodes, needed_part_count, width)
        return number

    def _add_graph_node(self, part_nodes: tuple[int, ...], needed_part_count: int, cut_size: int) -> int:
        number = len(self._parts)
        self._parts.append(part_nodes)
        self._missing.append(needed_part_count)
        self._cut_sizes.append(cut_size)
        self._above.append([])
        for part in part_nodes:
            self._above[part].append(number)
        return number


class Landmarks:
    """Landmarks (cuts) found while one plan is repaired. They give a minimum number of missing actions.

    A landmark is a set of actions; every plan that succeeds has at least one action of the set.

    Args:
        change_finder: the changes that conditions need, and the actions that make changes.
        initial: the state in which plans begin.
        goals: the goals of plans.
        steps: the steps of the plan.
        cuts: cuts that are known from the start, such as the set of actions that a goal requires.

    Attributes:
        cuts: the cuts found so far.
    """

    def __init__(
        self,
        change_finder: NecessaryChangeFinder,
        initial: State,
        goals: Iterable[Subgoal],
        steps: Iterable[Action],
        cuts: Iterable[Cut] = (),
    ) -> None:
        self._given = change_finder, initial, goals, steps
        self.cuts: list[Cut] = []
        self._hits: dict[Action, int] = {}
        self._fewest: dict[int, tuple[int, tuple[Action, ...]]] = {0: (0, ())}
        self._done: set[frozenset[Action]] = set()
        for cut in filter(None, cuts):
            self._add_cut(cut)

    @cached_property
    def _relaxation_graph(self) -> _RelaxationGraph:
        return _RelaxationGraph(*self._given)

    def _add_cut(self, cut: Iterable[Action]) -> None:
        bit = 1 << len(self.cuts)
        self.cuts.append(frozenset(cut))
        for action in cut:
            self._hits[action] = self._hits.get(action, 0) | bit

    def get_mask_of_cuts_with_action(self, action: Action | None) -> int:
        """Return the landmarks (see `Cut`) that contain an action, as a bit mask; 0 for no action (None)."""
        return 0 if action is None else self._hits.get(action, 0)

    def get_mask_of_cuts_missed_by(self, actions: Iterable[Action]) -> int:
        """Return the landmarks (see `Cut`) that contain none of the given actions, as a bit mask."""
        missed = (1 << len(self.cuts)) - 1
        for action in actions:
            missed &= ~self._hits.get(action, 0)
        return missed

    def compute_lower_bound_of_hitting_set_size(self, cuts_bit_mask: int) -> int:
        """Return a proved lower bound of the size of a set that has an action of each given landmark.

        The landmarks (see `Cut`) are given as a bit mask.
        """
        return self._get_min_hitting_set(cuts_bit_mask)[0]

    def add_cuts_missed_by(self, plan_actions: frozenset[Action], effort: SearchEffort) -> None:
        """Find and add landmarks (sets of actions, see `Cut`) that contain no action of a plan.

        Stop when the landmarks prove a higher minimum number of actions to add to the plan, or when no
        landmark is left.

        Args:
            plan_actions: the actions of the plan.
            effort: counter of operations of the search; at its limit the search stops.
        """
        if plan_actions in self._done or effort.is_limit_reached:
            return
        lacked = self.compute_lower_bound_of_hitting_set_size(self.get_mask_of_cuts_missed_by(plan_actions))
        while (
            plan_actions not in self._done
            and not effort.is_limit_reached
            and self.compute_lower_bound_of_hitting_set_size(self.get_mask_of_cuts_missed_by(plan_actions))
            == lacked
        ):
            actions = {
                *plan_actions,
                *self._get_min_hitting_set(self.get_mask_of_cuts_missed_by(plan_actions))[1],
            }
            number = len(self.cuts)
            while not effort.is_limit_reached:
                cut = self._relaxation_graph.find_cut_disjoint_from(actions)
                effort.used += 1 + self._relaxation_graph.node_count // _CONDITIONS_PER_EFFORT
                if not cut or (self.cuts and len(cut) > _MAX_CUT_SIZE):
                    break
                self._add_cut(cut)
                actions.update([action for action in cut if action.arguments == cut[0].arguments])
            if len(self.cuts) == number:
                self._done.add(plan_actions)

    def _get_min_hitting_set(self, mask: int) -> tuple[int, tuple[Action, ...]]:
        result = self._fewest.get(mask)
        if result is None:
            result = self._fewest[mask] = self._compute_min_hitting_set(mask)
        return result

    def _compute_min_hitting_set(self, cuts_bit_mask: int) -> tuple[int, tuple[Action, ...]]:
        by_hits: dict[int, Action] = {}
        for action, hits in self._hits.items():
            if hits & cuts_bit_mask:
                by_hits.setdefault(hits & cuts_bit_mask, action)
        patterns = [p for p in by_hits if not any(p & q == p != q for q in by_hits)]
        search = _HittingSetSearch(patterns, cuts_bit_mask)
        return search.least, tuple([by_hits[pattern] for pattern in search.best])


class _HittingSetSearch:
    """A search for a smallest set of bit masks (patterns) that together contain all bits of a mask.

    Args:
        patterns: the available bit masks.
        mask: the mask to cover.

    Attributes:
        least: lower bound of the number of patterns.
        best: the smallest set found.
    """

    def __init__(self, patterns: Sequence[int], mask: int) -> None:
        with_bit = {
            bit: [pattern for pattern in patterns if pattern & bit]
            for bit in map((1).__lshift__, iterate_bits(mask))
        }
        self._with_bit = dict(sorted(with_bit.items(), key=lambda item: len(item[1])))
        self._covered_with = {
            bit: reduce(or_, patterns_of_bit) for bit, patterns_of_bit in self._with_bit.items()
        }
        self._branches = 0
        self.best: tuple[int, ...] = self._choose_hitting_set_greedily(mask)
        self.least = self._count_disjoint_cuts(mask)
        if self.least < len(self.best):
            self._search_smaller_cover(mask, ())
            if self._branches <= _MAX_BRANCHES:
                self.least = len(self.best)

    def _choose_hitting_set_greedily(self, cuts_bit_mask: int) -> tuple[int, ...]:
        chosen = []
        for bit, patterns in self._with_bit.items():
            if cuts_bit_mask & bit:
                chosen.append(max(patterns, key=lambda pattern: (pattern & cuts_bit_mask).bit_count()))
                cuts_bit_mask &= ~chosen[-1]
        return tuple(chosen)

    def _count_disjoint_cuts(self, cuts_bit_mask: int) -> int:
        """Count disjoint landmarks (see `Cut`), chosen greedily: no two landmarks have a common action."""
        number = 0
        for bit, covered in self._covered_with.items():
            if cuts_bit_mask & bit:
                number += 1
                cuts_bit_mask &= ~covered
        return number

    def _search_smaller_cover(self, uncovered_mask: int, patterns_so_far: tuple[int, ...]) -> None:
        self._branches += 1
        if not uncovered_mask:
            self.best = patterns_so_far
            return
        if self._branches > _MAX_BRANCHES or len(patterns_so_far) + self._count_disjoint_cuts(
            uncovered_mask
        ) >= len(self.best):
            return
        patterns = next(
            patterns_of_bit for bit, patterns_of_bit in self._with_bit.items() if uncovered_mask & bit
        )
        for pattern in sorted(patterns, key=lambda pattern: -(pattern & uncovered_mask).bit_count()):
            self._search_smaller_cover(uncovered_mask & ~pattern, (*patterns_so_far, pattern))
