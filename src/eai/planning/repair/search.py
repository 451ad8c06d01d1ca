"""Repair: the fewest edits that make a plan succeed.

An edit inserts, deletes or replaces a step. Every repair has an edit that may resolve the plan's conflict
(its first failure, see `conflicts`). The search first expands the edited plan with fewest edits, by the edits
that may resolve its conflict. So it finds a repair with fewest edits. Effort counts operations, never time.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from math import inf
from typing import NamedTuple, TypeAlias

from eai.planning.conflict_changes import NecessaryChangeFinder
from eai.planning.landmarks import Landmarks
from eai.planning.planner import Planner, PlanningGoal
from eai.planning.repair.conflicts import (
    START,
    EditsAtPosition,
    PlanMoment,
    PlanPath,
    PlanStateCache,
    make_repair_edits_finder,
)
from eai.planning.repair.edits import (
    EditCost,
    EditedPlan,
    EditedPlanStep,
    PlanEdit,
    PlanSteps,
    align_plans,
    compute_edit_cost,
    count_edits_or_infinity,
    find_positions_deletable_without_extra_edit,
    insert_or_delete_step,
    list_plan_edits,
    make_unedited_plan,
    put_insertions_before_deletions,
    undo_one_edit,
)
from eai.planning.search import Limits, OpenList, SearchEffort, SearchEndReason
from eai.planning.subgoal import Subgoal
from eai.planning.successor_generator import generate_applicable_actions_of_operator
from eai.world.action import Action
from eai.world.fault import FaultKind
from eai.world.state import State

MinEdits: TypeAlias = int
"""Proved minimum number of edits of any repair of a plan."""

_FIRST_SHARE, _SEARCH_SHARE, _ENABLING_SHARE, _UNDOING_SHARE = 0.03, 0.7, 0.075, 0.025
"""Shares, from 0 to 1, of the effort for repairing one plan.

The shares are for the search before the planner runs, for the whole search, for actions that make a step
possible, and for removing needless edits from each repair.
"""

_MAX_PLANNER_STATES = 300
"""Maximum number of states that the planner may reach to complete a plan."""

_START_FACTOR = 3
"""Factor that raises the number of actions that the planner may test for a plan from the initial state.

The number may be higher because this plan is made only once per task.
"""

_ENABLING_LIMITS = Limits(20, looks=2_000)
"""Limits of each search for actions that make an impossible step possible."""

_STEPS_PER_EFFORT = 8
"""Number of executed steps that count as one operation of the search."""

_MANY_EDITS, _LANDMARK_EFFORT = 5_000, 500
"""Two limits of the search for repairs that consist of a single edit.

If more than ``_MANY_EDITS`` edits may help, landmarks (sets of actions, see `Cut`) rule out some of them.
``_LANDMARK_EFFORT`` is the maximum effort for finding these landmarks.
"""

_MAX_CACHED_STATES = 50_000
"""Maximum number of cached states that are kept when the repair of the next plan begins."""

_EASY_EFFORT = 60
"""Effort after which a search for repairs starts to look for landmarks: many plans need only one edit."""

_PUSHES_PER_EFFORT = 4
"""Number of plans put into the queue that count as one operation of the search."""

_CONFLICT_EFFORT, _EDITS_PER_EFFORT = 5, 80
"""Effort for a conflict (the first failure of a plan), counted in operations of the search.

Finding the edits that may resolve the conflict costs ``_CONFLICT_EFFORT`` operations for each moment of the
plan's `PlanPath`. Trying ``_EDITS_PER_EFFORT`` edits costs one operation.
"""


class FewestEditsPlanRepairer:
    """Repairs plans for one task.

    Args:
        planner: the planner; its plans give repairs, and so upper bounds of the number of edits.
        initial: the state in which plans begin.
        goal: the goal of plans.
        objects: the objects that inserted steps may use, by index.

    Attributes:
        change_finder: finds the changes of facts that may make a condition true or false.
        states: the states that plans lead to.
        find_edits: finds the edits that may resolve the conflict (the first failure) of an edited plan.
    """

    def __init__(self, planner: Planner, initial: State, goal: PlanningGoal, objects: Sequence[int]) -> None:
        self._planner = planner
        self._objects = objects
        self.change_finder = NecessaryChangeFinder(
            planner.domain, initial, objects, planner.heuristic.achievers
        )
        self.states = PlanStateCache(planner.domain, initial, goal, self.change_finder)
        self.find_edits = make_repair_edits_finder(self.states)
        self._plans: dict[int, tuple[Action, ...] | None] = {}
        self._enabling_actions: dict[tuple[int, Action], tuple[Action, ...] | None] = {}

    def repair(
        self, plan: PlanSteps, effort: SearchEffort, edit_limit: float = inf
    ) -> tuple[MinEdits, tuple[PlanEdit, ...] | None]:
        """Return the proved minimum number of edits, and the edits of the smallest repair found, or None.

        Args:
            plan: the plan.
            effort: counter of effort with an approximate limit. The result does not depend on earlier calls.
            edit_limit: number of edits; the search ends when it proves that no repair has fewer edits.
        """
        self._limit_cached_states()
        if self.change_finder.has_operator_with_too_many_actions_to_list:
            return self._repair_by_planner(plan, effort)
        search = _RepairSearch(self, plan)
        best = search.run(effort.limit * _FIRST_SHARE, edit_limit)
        if best is None and search.min_edits < edit_limit:
            best = self._find_best_repair_made_by_planner(plan, effort)
            best = (
                search.run(effort.limit * _SEARCH_SHARE, min(count_edits_or_infinity(best), edit_limit))
                or best
            )
        effort.used += search.effort.used
        return search.min_edits, None if best is None else list_plan_edits(best)

    def reaches_goal(self, plan: PlanSteps) -> bool:
        """Whether a plan reaches the goal."""
        self._limit_cached_states()
        return None not in plan and self.states.reaches_goal(make_unedited_plan(plan))

    def _limit_cached_states(self) -> None:
        if len(self.states.by_number) > _MAX_CACHED_STATES:
            self.states.clear_cached_states()
            self.change_finder.clear_cached_effects()
            self.find_edits = make_repair_edits_finder(self.states)
            self._enabling_actions.clear()

    def _repair_by_planner(
        self, plan: PlanSteps, effort: SearchEffort
    ) -> tuple[MinEdits, tuple[PlanEdit, ...] | None]:
        """Return a lower bound of the number of edits, and the edits of the planner's best repair.

        The lower bound is 0 if the plan reaches the goal, else 1. The edits are None if the planner finds no
        repair. `repair` calls this method if the domain has too many actions to prove a better lower bound.
        """
        if self.reaches_goal(plan):
            return 0, ()
        best = self._find_best_repair_made_by_planner(plan, effort)
        return 1, None if best is None else list_plan_edits(best)

    def _find_best_repair_made_by_planner(self, plan: PlanSteps, effort: SearchEffort) -> EditedPlan | None:
        looks = int(min(effort.limit, Limits().looks))
        repairs = [
            self._remove_needless_edits(repair, plan, effort)
            for repair in self._generate_repairs_made_by_planner(plan, looks, effort)
        ]
        return min(repairs, key=count_edits_or_infinity, default=None)

    def compute_proved_min_plan_length(self, effort: SearchEffort) -> int:
        """Return a proved lower bound of the number of steps in any plan that succeeds.

        If ``effort`` has a higher limit, a higher lower bound may be proved.
        """
        if self.change_finder.has_operator_with_too_many_actions_to_list:
            return int(bool(self.states.find_unmet_goals(0) or self.states.goal.actions))
        search = _RepairSearch(self, ())
        search.run(effort.limit * _SEARCH_SHARE)
        effort.used += search.effort.used
        return search.min_edits

    def _generate_repairs_made_by_planner(
        self, plan: PlanSteps, max_tested_actions: int, effort: SearchEffort
    ) -> Iterator[EditedPlan]:
        """Yield up to two repairs by the planner.

        One repair keeps the plan's possible steps and continues after them. The other is a new plan from the
        initial state. ``max_tested_actions`` limits the actions that the planner tests for the first repair.
        """
        walk_effort = SearchEffort(
            0
            if self.change_finder.has_operator_with_too_many_actions_to_list
            else effort.limit * _ENABLING_SHARE
        )
        actions, moment = self._execute_possible_steps(plan, walk_effort)
        effort.used += walk_effort.used
        further = self._find_plan_from(moment, max_tested_actions)
        if further is not None:
            yield put_insertions_before_deletions(align_plans(plan, (*actions, *further)))
        whole = self._find_plan_from_start(_START_FACTOR * max_tested_actions)
        if whole is not None:
            yield put_insertions_before_deletions(align_plans(plan, whole))

    def _execute_possible_steps(
        self, plan: PlanSteps, effort: SearchEffort
    ) -> tuple[list[Action], PlanMoment]:
        """Return a plan's possible steps, with inserted actions that make more of its steps possible.

        The second returned value is the moment (`PlanMoment`) after the last step.
        """
        actions: list[Action] = []
        moment, skipped = START[0], 0
        for i, step in enumerate(plan):
            outcome = (
                None
                if step is None
                else self._insert_enabling_actions_and_take_step(moment, step, plan[i + 1 :], skipped, effort)
            )
            skipped = skipped + 1 if outcome is None else 0
            if outcome is not None:
                step_actions, moment = outcome
                actions += step_actions
        return actions, moment

    def _insert_enabling_actions_and_take_step(
        self,
        moment: PlanMoment,
        step: Action,
        later_steps: PlanSteps,
        just_skipped_step_count: int,
        effort: SearchEffort,
    ) -> tuple[Sequence[Action], PlanMoment] | None:
        """Return a step with actions before it that make it possible, and the `PlanMoment` after the step.

        The result is None if the step should be left out.

        Args:
            moment: the moment before the step.
            step: the step.
            later_steps: the steps after this step.
            just_skipped_step_count: number of steps left out just before this step.
            effort: counter of the effort for making steps possible.
        """
        after = self.states.compute_moment_after_step(moment, step)
        if after is not None:
            return (step,), after
        before = None if effort.is_limit_reached else self._find_enabling_actions(moment[0], step)
        if before is None:
            return None
        path = self.states.compute_plan_path(make_unedited_plan((*before, step)), (moment,), 0)
        if len(path) < len(before) + 2:  # the step is impossible even after the inserted actions
            return None
        after = path[-1]
        effort.used += 2 * len(later_steps)
        edits = max(
            0, len(before) - just_skipped_step_count
        ) + self.states.count_failed_steps_and_missed_goals(later_steps, after)
        if edits < 1 + self.states.count_failed_steps_and_missed_goals(later_steps, moment):
            return ((*before, step), after)
        return None

    def _find_enabling_actions(self, state_number: int, action: Action) -> tuple[Action, ...] | None:
        key = state_number, action
        if key not in self._enabling_actions:
            operator = self.states.domain.compiled_operators[action.operator].operator
            scope = operator.map_parameters(action.arguments)
            checks = [c.condition for c in operator.checks if c.fault is not FaultKind.ADDITIONAL_STEP]
            goals = tuple([Subgoal(condition, scope, True) for condition in checks])
            self._enabling_actions[key] = self._planner.find_actions_towards(
                self.states.by_number[state_number], goals, self._objects, _ENABLING_LIMITS
            )
        return self._enabling_actions[key]

    def _remove_needless_edits(
        self, plan: EditedPlan, original: PlanSteps, effort: SearchEffort
    ) -> EditedPlan:
        """Remove needless edits from a repair, until the share of effort for such removals is used up."""
        undo_effort = SearchEffort(effort.limit * _UNDOING_SHARE)
        trials = undo_one_edit(plan, original)
        while (trial := next(trials, None)) is not None and not undo_effort.is_limit_reached:
            undo_effort.used += 1 + len(trial) // _STEPS_PER_EFFORT
            if compute_edit_cost(trial).edits < compute_edit_cost(plan).edits and self.states.reaches_goal(
                trial
            ):
                plan, trials = trial, undo_one_edit(trial, original)
        effort.used += undo_effort.used
        return plan

    def _find_plan_from_start(self, max_tested_actions: int) -> tuple[Action, ...] | None:
        if max_tested_actions not in self._plans:
            self._plans[max_tested_actions] = self._find_plan_from(START[0], max_tested_actions)
        return self._plans[max_tested_actions]

    def _find_plan_from(self, moment: PlanMoment, max_tested_actions: int) -> tuple[Action, ...] | None:
        number, taken = moment
        goal = PlanningGoal(self.states.goal.conditions, self.states.goal.actions[taken:])
        result = self._planner.find_plan(
            self.states.by_number[number],
            goal,
            self._objects,
            Limits(_MAX_PLANNER_STATES, looks=max_tested_actions),
        )
        return result.plan if result.end is SearchEndReason.SOLVED else None

    def find_single_edit_repairs(self, plan: PlanSteps) -> Iterator[PlanEdit]:
        """Yield all single edits that make a plan succeed."""
        entries = make_unedited_plan(plan)
        find_edits = self.find_edits
        landmarks = self.make_landmarks_for_repair_of(plan)
        path = self.states.compute_plan_path(entries, START, 0)
        if None not in plan:
            helping = find_edits(entries, path)
        else:  # an unreadable step must be deleted
            helping = [(position, (None,)) for position in (plan.index(None),) if position < len(path)]
        if sum([len(actions) for _, actions in helping]) > _MANY_EDITS:
            landmarks.add_cuts_missed_by(frozenset(filter(None, plan)), SearchEffort(_LANDMARK_EFFORT))
        for position, actions in helping:
            if actions == (None,):
                without = insert_or_delete_step(entries, position, None)[0]
                path_without = self.states.compute_plan_path(without, path, position)
                candidates: Iterable[Action | None] = self._find_state_changing_or_goal_required_actions(
                    path[position]
                )
                if self.states.plan_succeeds(without, path_without):
                    yield PlanEdit(position, position, None)
                else:
                    candidates = dict(find_edits(without, path_without)).get(position, ())
                yield from self._generate_edits_making_plan_succeed(
                    plan, PlanEdit(position, position, None), path[position], candidates, landmarks
                )
            else:
                yield from self._generate_edits_making_plan_succeed(
                    plan, PlanEdit(position, None, None), path[position], actions, landmarks
                )
                if position < len(plan) and (position, (None,)) not in helping:
                    yield from self._generate_edits_making_plan_succeed(
                        plan, PlanEdit(position, position, None), path[position], actions, landmarks
                    )

    def _generate_edits_making_plan_succeed(
        self,
        plan: PlanSteps,
        edit: PlanEdit,
        moment: PlanMoment,
        actions: Iterable[Action | None],
        landmarks: Landmarks,
    ) -> Iterator[PlanEdit]:
        """Yield copies of an edit, each with one of the actions as the inserted action.

        A copy is yielded only if the edited plan succeeds. The given edit has only the position and, for a
        replacement, the removed step.
        """
        rest = plan[edit.step + (edit.removed is not None) :]
        lacked = landmarks.get_mask_of_cuts_missed_by(filter(None, (*plan[: edit.step], *rest)))
        old_action = None if edit.removed is None else plan[edit.removed]
        for action in actions:
            if (
                action is None
                or action == old_action
                or lacked & ~landmarks.get_mask_of_cuts_with_action(action)
            ):
                continue
            if self.states.get_next_state_number_and_is_executed(moment[0], action)[
                1
            ] and self._succeeds_from(self.states.compute_moment_after_step(moment, action), rest):
                yield edit._replace(action=action)

    def _find_state_changing_or_goal_required_actions(self, moment: PlanMoment) -> Iterator[Action]:
        """Yield the possible actions in a state that change the world, or that the goal requires."""
        names = {name for names in self.states.goal.actions for name in names}
        for operator in self.states.domain.operators:
            if operator.effects or operator.alternatives or operator.name in names:
                state, bindings = self.states.by_number[moment[0]], SearchEffort(Limits().bindings)
                yield from generate_applicable_actions_of_operator(
                    self.states.domain, operator, state, self._objects, bindings
                )

    def _succeeds_from(self, moment: PlanMoment | None, rest: PlanSteps) -> bool:
        return (
            moment is not None
            and None not in rest
            and self.states.reaches_goal(make_unedited_plan(rest), moment)
        )

    def make_landmarks_for_repair_of(self, plan: PlanSteps) -> Landmarks:
        """Return the landmarks for the repair of a plan: at first only actions that the goal requires.

        A landmark is a set of actions; every plan that succeeds has at least one action of the set. Required
        actions that the plan contains give no landmark. Further landmarks are computed when they are needed.
        """
        steps = [step for step in plan if step is not None]
        untaken = [
            names for names in self.states.goal.actions if not any(step.operator in names for step in steps)
        ]
        taking = [
            frozenset([a for name in names for a in self.change_finder.get_actions_of_operator(name)])
            for names in untaken
        ]
        return Landmarks(
            self.change_finder, self.states.initial, self.states.find_unmet_goals(0), steps, taking
        )


class _PlanRepairNode(NamedTuple):
    """An edited plan in the queue.

    Attributes:
        plan: the plan.
        path: the moment (`PlanMoment`) before each entry up to the first failure. Until the plan is executed,
            this is its path before the last edit, which is right only up to the entry ``first_unknown``.
        first_unknown: index of the first entry to execute after the last edit; -1 if the plan was executed.
        failures: number of failed steps and missed goals. Before the plan is executed, this is the number
            before its last edit.
        cost: the numbers of edits of the plan, by kind of edit.
        missed_cuts_mask: the landmarks (sets of actions, see `Cut`) without an action of this plan, as a bit
            mask.
        known_cuts: number of landmarks known when ``missed_cuts_mask`` was computed.
        missing_steps: minimum number of missing steps that the landmarks prove.
        min_edits: another minimum number of edits, from the plan's first failure or from postponed edits.
        edits: the edits that were postponed, because they cost more than other edits.
    """

    plan: EditedPlan
    path: PlanPath
    first_unknown: int
    failures: int
    cost: EditCost
    missed_cuts_mask: int
    known_cuts: int
    missing_steps: int
    min_edits: int = 0
    edits: Sequence[EditsAtPosition] = ()

    @property
    def min_repair_edits(self) -> int:
        """Minimum number of edits of any repair that includes all edits made to the plan so far."""
        return max(self.min_edits, self.cost.count_min_edits_after_more_insertions(self.missing_steps))


class _RepairSearch:
    """A search for repairs of one plan. It can be continued with more effort.

    Args:
        repairer: the repairer of the task.
        plan: the plan.

    Attributes:
        effort: counter of the effort so far.
        min_edits: proved minimum number of edits of all repairs.
    """

    def __init__(self, repairer: FewestEditsPlanRepairer, plan: PlanSteps) -> None:
        self._states = repairer.states
        self._find_edits = repairer.find_edits
        self._landmarks = repairer.make_landmarks_for_repair_of(plan)
        self._steps = frozenset([step for step in plan if step is not None])
        self.effort = SearchEffort()
        self.min_edits = 0
        self._waiting: OpenList[_PlanRepairNode] = OpenList()
        self._seen: set[tuple[EditedPlan, bool]] = set()
        self._pushed = 0
        start = make_unedited_plan(plan)
        self._push_node(_PlanRepairNode(start, START, 0, 0, compute_edit_cost(start), 0, -1, 0))

    def run(self, limit: float, edits_of_known_repair: float = inf) -> EditedPlan | None:
        """Search for a repair with fewest edits, or continue the search. Return the repair, or None.

        Args:
            limit: maximum effort of all calls together.
            edits_of_known_repair: number of edits of a known repair; only repairs with fewer edits are
                searched.
        """
        self.effort.limit = limit
        while self.min_edits < edits_of_known_repair and (node := self._waiting.pop()) is not None:
            updated = self._update_min_missing_steps(node)
            if updated.min_repair_edits > node.min_repair_edits:
                self._add_to_queue(updated)
                continue
            self.min_edits = max(self.min_edits, node.min_repair_edits)
            if self.effort.is_limit_reached:
                self._add_to_queue(updated)
                break
            if node.first_unknown < 0:
                self._expand_node(updated)
            elif self._execute_plan_and_check_success(updated):
                return node.plan
        self.min_edits = int(min(self.min_edits, edits_of_known_repair))
        return None

    def _push_node(self, node: _PlanRepairNode) -> None:
        """Put a node into the queue, unless a node with this plan was queued before.

        Nodes before and after the execution of a plan count separately: a plan that fails is queued again.
        """
        number_before = len(self._seen)
        self._seen.add((node.plan, node.first_unknown < 0))  # a test before `add` would hash the plan twice
        if len(self._seen) > number_before:
            self._add_to_queue(node)

    def _add_to_queue(self, node: _PlanRepairNode) -> None:
        """Put a plan into the queue, even if it was queued before.

        The plan whose repair needs fewest edits comes first, then the plan with fewest failures, then the
        newest plan.
        """
        self._pushed += 1
        self.effort.used += self._pushed % _PUSHES_PER_EFFORT == 0
        self._waiting.push(node, node.min_repair_edits, node.failures, -self._pushed)

    def _execute_plan_and_check_success(self, node: _PlanRepairNode) -> bool:
        """Execute the plan of a node. Return True if the plan succeeds.

        If the plan fails, its node is queued again, with the result of the execution. For each step at or
        before the failure, a copy of the plan without the step is queued, too, if this deletion costs no
        edit. It costs none if it counts as a replacement together with an earlier insertion.
        """
        self.effort.used += 1 + len(node.plan) // _STEPS_PER_EFFORT
        path = self._states.compute_plan_path(node.plan, node.path, node.first_unknown)
        if self._states.plan_succeeds(node.plan, path):
            return True
        rest = [action for _, action in node.plan[len(path) - 1 :]]
        lacks = self._states.count_failed_steps_and_missed_goals(rest, path[-1])
        self._push_node(
            node._replace(
                path=path,
                first_unknown=-1,
                failures=lacks,
                min_edits=node.cost.count_min_edits_after_more_insertions(1),
            )
        )
        for position in find_positions_deletable_without_extra_edit(node.plan):
            if position < len(path):
                self._push_node(self._make_deletion_node(node._replace(path=path, failures=lacks), position))
        return False

    def _expand_node(self, node: _PlanRepairNode) -> None:
        """Queue the plan with each helping edit that adds no cost, and postpone costlier edits.

        An edit helps if it may resolve the plan's conflict (its first failure). Most postponed edits are
        never needed (partial expansion, Yoshizumi, Miura and Ishida 2000).
        """
        edits = node.edits or self._find_edits(node.plan, node.path)
        self.effort.used += 0 if node.edits else _CONFLICT_EFFORT * len(node.path)
        max_cost = node.min_repair_edits
        for position, actions in edits:
            if self.effort.is_limit_reached:
                self._add_to_queue(node)
                return
            if actions == (None,):
                child = self._make_deletion_node(node, position)
                max_cost = max(max_cost, child.min_repair_edits)
                if child.min_repair_edits <= node.min_repair_edits:
                    self._push_node(child)
            elif actions:
                max_cost = max(
                    max_cost, self._queue_insertions_and_find_max_lower_bound(node, position, actions)
                )
        if max_cost > node.min_repair_edits:
            self._add_to_queue(node._replace(edits=edits, min_edits=node.min_repair_edits + 1))

    def _queue_insertions_and_find_max_lower_bound(
        self, node: _PlanRepairNode, position: int, actions: Sequence[Action | None]
    ) -> int:
        """For each action, queue a copy of the plan in which the action is inserted at a position.

        For each copy, a lower bound of the number of edits of its repairs is proved. A copy is not
        queued if its bound is greater than `min_repair_edits` of the node, or if it was queued earlier.
        Return the highest bound: if it is greater, the caller must try the postponed copies later.
        """
        self.effort.used += len(actions) // _EDITS_PER_EFFORT
        plan, at = insert_or_delete_step(node.plan, position, actions[0])
        costs = compute_edit_cost(plan)
        first = node.min_edits if node.edits else 0
        last = node.min_repair_edits
        one_more = costs.count_min_edits_after_more_insertions(1)
        ranks: dict[int, int] = {}
        max_cost = 0
        for action in filter(None, actions):
            lacked = node.missed_cuts_mask & ~self._landmarks.get_mask_of_cuts_with_action(action)
            rank = ranks.get(lacked, -1)
            if rank < 0:
                missing_steps = self._landmarks.compute_lower_bound_of_hitting_set_size(lacked)
                rank = ranks[lacked] = costs.count_min_edits_after_more_insertions(missing_steps)
            if rank <= last and rank < one_more and self._is_useless_insertion(node, position, action):
                rank += 1
            if rank > max_cost:
                max_cost = rank
            if first <= rank <= last:
                child = (*plan[:at], EditedPlanStep(-1, action), *plan[at + 1 :])
                self._push_node(self._make_child_node(node, child, at, costs, lacked))
        return max_cost

    def _make_deletion_node(self, node: _PlanRepairNode, position: int) -> _PlanRepairNode:
        plan, at = insert_or_delete_step(node.plan, position, None)
        lacked = node.missed_cuts_mask
        if self._landmarks.get_mask_of_cuts_with_action(node.plan[position].action):
            lacked = self._landmarks.get_mask_of_cuts_missed_by(
                [e.action for e in plan if e.action is not None]
            )
        return self._make_child_node(node, plan, at, compute_edit_cost(plan), lacked)

    def _update_min_missing_steps(self, node: _PlanRepairNode) -> _PlanRepairNode:
        """Search for more landmarks, and return the node with an updated minimum number of missing steps.

        A landmark is a set of actions; every plan that succeeds has at least one action of the set. The
        minimum number follows from the landmarks that contain no action of the plan.
        """
        landmarks = self._landmarks
        search_effort = self.effort if self.effort.used > _EASY_EFFORT else SearchEffort(0)
        landmarks.add_cuts_missed_by(self._steps, search_effort)
        if node.first_unknown >= 0 and node.known_cuts == len(landmarks.cuts):
            return node
        steps = frozenset([entry.action for entry in node.plan if entry.action is not None])
        if node.first_unknown < 0:
            landmarks.add_cuts_missed_by(steps, search_effort)
        lacked = landmarks.get_mask_of_cuts_missed_by(steps)
        return node._replace(
            missed_cuts_mask=lacked,
            known_cuts=len(landmarks.cuts),
            missing_steps=landmarks.compute_lower_bound_of_hitting_set_size(lacked),
        )

    def _make_child_node(
        self,
        parent: _PlanRepairNode,
        plan: EditedPlan,
        first_changed: int,
        costs: EditCost,
        missed_cuts_mask: int,
    ) -> _PlanRepairNode:
        first_changed = min(first_changed, len(parent.path) - 1)
        lacking = self._landmarks.compute_lower_bound_of_hitting_set_size(missed_cuts_mask)
        return _PlanRepairNode(
            plan,
            parent.path,
            first_changed,
            parent.failures,
            costs,
            missed_cuts_mask,
            parent.known_cuts,
            lacking,
        )

    def _is_useless_insertion(self, node: _PlanRepairNode, position: int, action: Action) -> bool:
        """Whether an inserted action is impossible at its position, or changes nothing."""
        if node.cost.insertions:
            return False
        after = self._states.compute_moment_after_step(node.path[position], action)
        return after is None or after == node.path[position]
