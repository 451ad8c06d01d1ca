"""Repair: the fewest edits that make a plan succeed.

An edit inserts a step, deletes one, or replaces one. Every repair has an edit that may help the conflict of
the plan (`conflicts`). So a search over edited plans that expands the plan with fewest edits first, by the
edits that may help its conflict, finds all repairs with fewest edits. Effort is counted and never timed.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from math import inf
from typing import NamedTuple

from eai.planning.conflict_changes import ConflictChanges
from eai.planning.landmarks import Landmarks
from eai.planning.planner import Planner, PlanningGoal
from eai.planning.repair.conflicts import START, HelpingEdits, PlanMoment, PlanPath, PlanStates, helping_edits
from eai.planning.repair.edits import (
    EditCost,
    EditedPlan,
    PlanEdit,
    PlanEntry,
    PlanSteps,
    align,
    apply_edit,
    as_entries,
    count_edits,
    edit_cost,
    edits_of,
    normalize,
    replaceable,
    undo_one_edit,
)
from eai.planning.search import Effort, Limits, OpenList, SearchEnd
from eai.planning.subgoal import Subgoal
from eai.planning.successor_generator import applicable_actions
from eai.world.action import Action
from eai.world.fault import FaultKind
from eai.world.state import State

_SOON, _EXACT, _WALKING, _UNDOING = 0.03, 0.7, 0.075, 0.025
"""Shares of the effort: of the search before the planner is asked and in all, of making the steps of a plan
possible, and of removing needless edits from each repair."""

_STATES = 300
"""Maximum number of states that the planner may reach to finish a plan."""

_START = 3
"""Factor of the actions that the planner may look at from the initial state, once for each task."""

_ENABLING = Limits(20, looks=2_000)
"""Limits of the search for actions that make a step possible."""

_STEPS = 8
"""Number of executed steps that count as one unit of effort."""

_MANY, _CUTS = 5_000, 500
"""Number of edits from which on only those are tried that hit landmarks; effort of finding the landmarks."""

_KEPT = 50_000
"""Maximum number of states that are kept from one plan to the next."""

_EASY = 60
"""Effort up to which no landmarks are looked for, as many plans take one edit."""

_PUSHES = 4
"""Number of plans put into the queue that count as much as a step."""

_CONFLICT, _EDITS = 5, 80
"""Effort of taking a conflict apart for each step before it; number of edits that count as one step."""


class Repairer:
    """Repairs plans for one task.

    Args:
        planner: finishes plans, which bounds the number of edits from above.
        initial: the state in which plans begin.
        goal: the goal of plans.
        objects: the objects of inserted steps, by index.

    Attributes:
        flips: the changes that conditions need.
        states: the states that plans lead to.
    """

    def __init__(self, planner: Planner, initial: State, goal: PlanningGoal, objects: Sequence[int]) -> None:
        self._planner = planner
        self._objects = objects
        self.conflict_changes = ConflictChanges(planner.domain, initial, objects, planner.heuristic.achievers)
        self.states = PlanStates(planner.domain, initial, goal, self.conflict_changes)
        self._plans: dict[int, tuple[Action, ...] | None] = {}
        self._ways: dict[tuple[int, Action], tuple[Action, ...] | None] = {}

    def repair(self, plan: PlanSteps, effort: Effort) -> tuple[int, tuple[PlanEdit, ...] | None]:
        """Return the minimum number of edits of repairs, and the edits of the smallest repair found, or None.

        Args:
            plan: the plan.
            effort: the approximate limit. Earlier calls do not change the result.
        """
        if len(self.states.by_number) > _KEPT:
            self.states.forget()
            self._ways.clear()
        if self.conflict_changes.is_partial:
            return self._bound(plan, effort)
        search = _Search(self, plan)
        best = search.run(effort.limit * _SOON)
        if best is None:
            best = self._planned(plan, effort)
            best = search.run(effort.limit * _EXACT, count_edits(best)) or best
        effort.used += search.effort.used
        return search.least, None if best is None else edits_of(best)

    def _bound(self, plan: PlanSteps, effort: Effort) -> tuple[int, tuple[PlanEdit, ...] | None]:
        """Return bounds like `mend` from plans alone, as there are too many actions to prove anything."""
        if None not in plan and self.states.reaches_goal(as_entries(plan)):
            return 0, ()
        best = self._planned(plan, effort)
        return 1, None if best is None else edits_of(best)

    def _planned(self, plan: PlanSteps, effort: Effort) -> EditedPlan | None:
        """Return the smallest of the repairs that the planner finds, or None."""
        looks = int(min(effort.limit, Limits().looks))
        repairs = [self._undone(each, plan, effort) for each in self._finished(plan, looks, effort)]
        return min(repairs, key=count_edits, default=None)

    def least(self, effort: Effort) -> int:
        """Return the minimum number of steps of plans that succeed, as far as the effort proves it."""
        if self.conflict_changes.is_partial:
            return int(bool(self.states.missed_goals(0) or self.states.goal.actions))
        search = _Search(self, ())
        search.run(effort.limit * _EXACT)
        effort.used += search.effort.used
        return search.least

    def _finished(self, plan: PlanSteps, looks: int, effort: Effort) -> Iterator[EditedPlan]:
        """Yield repairs that end with a plan of the planner: from where the plan leads, and from the start.

        The planner may look at ``looks`` actions on the way from where the plan leads.
        """
        own = Effort(0 if self.conflict_changes.is_partial else effort.limit * _WALKING)
        actions, moment = self._walk(plan, own)
        effort.used += own.used
        further = self._way(moment, looks)
        if further is not None:
            yield normalize(align(plan, (*actions, *further)))
        whole = self._whole(_START * looks)
        if whole is not None:
            yield normalize(align(plan, whole))

    def _walk(self, plan: PlanSteps, effort: Effort) -> tuple[list[Action], PlanMoment]:
        """Return the possible actions of a plan, with others that make some possible, and where they lead."""
        actions: list[Action] = []
        moment, gone = START[0], 0
        for i, step in enumerate(plan):
            past = None if step is None else self._past(moment, step, plan[i + 1 :], gone, effort)
            gone = gone + 1 if past is None else 0
            if past is not None:
                own, moment = past
                actions += own
        return actions, moment

    def _past(
        self, moment: PlanMoment, step: Action, rest: PlanSteps, gone: int, effort: Effort
    ) -> tuple[Sequence[Action], PlanMoment] | None:
        """Return a step after actions that make it possible, and where it leads; None to leave it out.

        Args:
            moment: the moment before the step.
            step: the step.
            rest: the steps after it.
            gone: number of steps left out just before it.
            effort: the effort of making steps possible.
        """
        after = self.states.take_step(moment, step)
        if after is not None:
            return (step,), after
        before = None if effort.is_used_up else self._enabling(moment[0], step)
        if before is None:
            return None
        path = self.states.path(as_entries((*before, step)), (moment,), 0)
        if len(path) < len(before) + 2:  # an action before the step fails, or the step itself
            return None
        after = path[-1]
        effort.used += 2 * len(rest)
        edits = max(0, len(before) - gone) + self.states.count_failures(rest, after)
        return ((*before, step), after) if edits < 1 + self.states.count_failures(rest, moment) else None

    def _enabling(self, number: int, action: Action) -> tuple[Action, ...] | None:
        """Return the actions by which the planner makes a step possible, or None; searched once."""
        key = number, action
        if key not in self._ways:
            operator = self.states.domain.compiled[action.operator].operator
            scope = operator.scope(action.arguments)
            checks = [c.condition for c in operator.checks if c.fault is not FaultKind.ADDITIONAL_STEP]
            goals = tuple([Subgoal(condition, scope, True) for condition in checks])
            self._ways[key] = self._planner.reach(
                self.states.by_number[number], goals, self._objects, _ENABLING
            )
        return self._ways[key]

    def _undone(self, plan: EditedPlan, original: PlanSteps, effort: Effort) -> EditedPlan:
        """Return a repair without its needless edits, as far as its share of the effort lasts."""
        own = Effort(effort.limit * _UNDOING)
        trials = undo_one_edit(plan, original)
        while (trial := next(trials, None)) is not None and not own.is_used_up:
            own.used += 1 + len(trial) // _STEPS
            if edit_cost(trial).edits < edit_cost(plan).edits and self.states.reaches_goal(trial):
                plan, trials = trial, undo_one_edit(trial, original)
        effort.used += own.used
        return plan

    def _whole(self, looks: int) -> tuple[Action, ...] | None:
        """Return the plan of the planner from the start, or None; searched once."""
        if looks not in self._plans:
            self._plans[looks] = self._way(START[0], looks)
        return self._plans[looks]

    def _way(self, moment: PlanMoment, looks: int) -> tuple[Action, ...] | None:
        """Return the plan of the planner from a moment on, or None."""
        number, taken = moment
        goal = PlanningGoal(self.states.goal.conditions, self.states.goal.actions[taken:])
        found = self._planner.plan(
            self.states.by_number[number], goal, self._objects, Limits(_STATES, looks=looks)
        )
        return found.plan if found.end is SearchEnd.SOLVED else None

    def single_edits(self, plan: PlanSteps) -> Iterator[PlanEdit]:
        """Yield all single edits that make a plan succeed."""
        entries, find_edits, known = as_entries(plan), helping_edits(self.states), self.landmarks(plan)
        path = self.states.path(entries, START, 0)
        if None not in plan:
            helping = find_edits(entries, path)
        else:  # an unreadable step has to go
            helping = [(place, (None,)) for place in (plan.index(None),) if place < len(path)]
        if sum([len(actions) for _, actions in helping]) > _MANY:
            known.refine(frozenset(filter(None, plan)), Effort(_CUTS))
        for place, actions in helping:
            if actions == (None,):
                without = apply_edit(entries, place, None)[0]
                left = self.states.path(without, path, place)
                anything: Iterable[Action | None] = self._possible(path[place])
                if self.states.succeeds(without, left):
                    yield PlanEdit(place, place, None)
                else:
                    anything = dict(find_edits(without, left)).get(place, ())
                yield from self._put(plan, PlanEdit(place, place, None), path[place], anything, known)
            else:
                yield from self._put(plan, PlanEdit(place, None, None), path[place], actions, known)
                if place < len(plan) and (place, (None,)) not in helping:
                    yield from self._put(plan, PlanEdit(place, place, None), path[place], actions, known)

    def _put(
        self,
        plan: PlanSteps,
        edit: PlanEdit,
        moment: PlanMoment,
        actions: Iterable[Action | None],
        known: Landmarks,
    ) -> Iterator[PlanEdit]:
        """Yield the edits that insert one of some actions besides an edit, and make a plan succeed."""
        rest = plan[edit.step + (edit.removed is not None) :]
        lacked = known.missed_cuts(filter(None, (*plan[: edit.step], *rest)))
        was = None if edit.removed is None else plan[edit.removed]
        for action in actions:
            if action is None or action == was or lacked & ~known.hit_cuts(action):
                continue
            if self.states.try_step(moment[0], action)[1] and self._wins(
                self.states.take_step(moment, action), rest
            ):
                yield edit._replace(action=action)

    def _possible(self, moment: PlanMoment) -> Iterator[Action]:
        """Yield the possible actions that change the world or are asked for by a goal."""
        names = {name for names in self.states.goal.actions for name in names}
        for operator in self.states.domain.operators:
            if operator.effects or operator.tries or operator.name in names:
                state, bindings = self.states.by_number[moment[0]], Effort(Limits().bindings)
                yield from applicable_actions(self.states.domain, operator, state, self._objects, bindings)

    def _wins(self, moment: PlanMoment | None, rest: PlanSteps) -> bool:
        """Whether the rest of a plan succeeds from a moment on."""
        return moment is not None and None not in rest and self.states.reaches_goal(as_entries(rest), moment)

    def landmarks(self, plan: PlanSteps) -> Landmarks:
        """Return the landmarks of plans that succeed; only landmarks that a plan may lack are looked for."""
        steps = [step for step in plan if step is not None]
        untaken = [
            names for names in self.states.goal.actions if not any(step.operator in names for step in steps)
        ]
        taking = [
            frozenset([a for name in names for a in self.conflict_changes.actions_of(name)])
            for names in untaken
        ]
        return Landmarks(
            self.conflict_changes, self.states.initial, self.states.missed_goals(0), steps, taking
        )


class _Node(NamedTuple):
    """An edited plan in the queue.

    Attributes:
        plan: the plan.
        path: its path, or the path of the plan before its last edit, which is equal up to ``at``.
        at: the first entry whose moment is not known; -1 if all moments are known.
        lacks: number of failed steps and missed goals; of the plan before the last edit if ``at`` >= 0.
        cost: the cost of the plan.
        open: the landmarks that the plan lacks, as a mask.
        known: number of landmarks known when ``open`` was computed.
        lacking: minimum number of missing steps by the landmarks.
        least: minimum number of edits for other reasons.
        edits: the edits that were put off because they cost more.
    """

    plan: EditedPlan
    path: PlanPath
    at: int
    lacks: int
    cost: EditCost
    open: int
    known: int
    lacking: int
    least: int = 0
    edits: Sequence[HelpingEdits] = ()

    @property
    def at_least(self) -> int:
        """Minimum number of edits of all repairs that include the edits of the plan."""
        return max(self.least, self.cost.min_edits_with(self.lacking))


class _Search:
    """A search for repairs of one plan, which can be continued.

    Args:
        mender: repairs plans for the task.
        plan: the plan.

    Attributes:
        effort: the effort spent.
        least: minimum number of edits of all repairs.
    """

    def __init__(self, mender: Repairer, plan: PlanSteps) -> None:
        self._states = mender.states
        self._find_edits = helping_edits(mender.states)
        self._landmarks = mender.landmarks(plan)
        self._steps = frozenset([step for step in plan if step is not None])
        self.effort = Effort()
        self.least = 0
        self._waiting: OpenList[_Node] = OpenList()
        self._seen: set[tuple[EditedPlan, bool]] = set()
        self._pushed = 0
        start = as_entries(plan)
        self._push(_Node(start, START, 0, 0, edit_cost(start), 0, -1, 0))

    def run(self, limit: float, known: float = inf) -> EditedPlan | None:
        """Search best first, or continue the search; return a repair with fewest edits, or None.

        Args:
            limit: the effort of all calls together.
            known: number of edits of a known repair; only repairs with fewer edits are looked for.
        """
        self.effort.limit = limit
        while self.least < known and (node := self._waiting.pop()) is not None:
            informed = self._informed(node)
            if informed.at_least > node.at_least:
                self._push_again(informed)
                continue
            self.least = max(self.least, node.at_least)
            if self.effort.is_used_up:
                self._push_again(informed)
                break
            if node.at < 0:
                self._expand(informed)
            elif self._carry_out(informed):
                return node.plan
        self.least = int(min(self.least, known))
        return None

    def _push(self, node: _Node) -> None:
        """Put a plan into the queue, once before and once after it is executed."""
        if (node.plan, node.at < 0) not in self._seen:
            self._seen.add((node.plan, node.at < 0))
            self._push_again(node)

    def _push_again(self, node: _Node) -> None:
        """Put a plan into the queue by its rank; the last of equal ranks comes first."""
        self._pushed += 1
        self.effort.used += self._pushed % _PUSHES == 0
        self._waiting.push(node, node.at_least, node.lacks, -self._pushed)

    def _carry_out(self, node: _Node) -> bool:
        """Whether a plan succeeds; if not, queue it, and the plans that replace one more step for free."""
        self.effort.used += 1 + len(node.plan) // _STEPS
        path = self._states.path(node.plan, node.path, node.at)
        if self._states.succeeds(node.plan, path):
            return True
        rest = [action for _, action in node.plan[len(path) - 1 :]]
        lacks = self._states.count_failures(rest, path[-1])
        self._push(node._replace(path=path, at=-1, lacks=lacks, least=node.cost.min_edits_with(1)))
        for place in replaceable(node.plan):
            if place < len(path):
                self._push(self._without(node._replace(path=path, lacks=lacks), place))
        return False

    def _expand(self, node: _Node) -> None:
        """Queue the plans after each helping edit that costs no more; the other edits are put off.

        Most of them are never needed (partial expansion, Yoshizumi, Miura and Ishida 2000).
        """
        edits = node.edits or self._find_edits(node.plan, node.path)
        self.effort.used += 0 if node.edits else _CONFLICT * len(node.path)
        lacking: dict[Action, int] = {}
        most = node.at_least
        for place, actions in edits:
            if self.effort.is_used_up:
                self._push_again(node)
                return
            if actions == (None,):
                child = self._without(node, place)
                most = max(most, child.at_least)
                if child.at_least <= node.at_least:
                    self._push(child)
            elif actions:
                most = max(most, self._insert(node, place, actions, lacking))
        if most > node.at_least:
            self._push_again(node._replace(edits=edits, least=node.at_least + 1))

    def _insert(
        self, node: _Node, place: int, actions: Sequence[Action | None], lacking: dict[Action, int]
    ) -> int:
        """Queue the plans with one inserted action that cost no more; return the maximum cost of all of them.

        ``lacking`` keeps the number of missing steps with each action.
        """
        self.effort.used += len(actions) // _EDITS
        plan, at = apply_edit(node.plan, place, actions[0])
        costs, first, last = edit_cost(plan), node.least if node.edits else 0, node.at_least
        most = 0
        for action in filter(None, actions):
            lacked = node.open & ~self._landmarks.hit_cuts(action)
            number = lacking.get(action)
            if number is None:
                number = lacking[action] = self._landmarks.min_actions(lacked)
            rank = costs.min_edits_with(number)
            if rank <= last and rank < costs.min_edits_with(1) and self._is_idle(node, place, action):
                rank += 1
            most = max(most, rank)
            if first <= rank <= last:
                child = (*plan[:at], PlanEntry(-1, action), *plan[at + 1 :])
                self._push(self._child(node, child, at, costs, lacked))
        return most

    def _without(self, node: _Node, place: int) -> _Node:
        """Return the node of a plan without one of its steps."""
        plan, at = apply_edit(node.plan, place, None)
        lacked = node.open
        if self._landmarks.hit_cuts(node.plan[place].action):
            lacked = self._landmarks.missed_cuts([e.action for e in plan if e.action is not None])
        return self._child(node, plan, at, edit_cost(plan), lacked)

    def _informed(self, node: _Node) -> _Node:
        """Return a node with the bounds by all known landmarks, after looking for more landmarks."""
        known = self._landmarks
        looks = self.effort if self.effort.used > _EASY else Effort(0)
        known.refine(self._steps, looks)
        if node.at >= 0 and node.known == len(known.cuts):
            return node
        steps = frozenset([entry.action for entry in node.plan if entry.action is not None])
        if node.at < 0:
            known.refine(steps, looks)
        lacked = known.missed_cuts(steps)
        return node._replace(open=lacked, known=len(known.cuts), lacking=known.min_actions(lacked))

    def _child(self, node: _Node, plan: EditedPlan, at: int, costs: EditCost, lacked: int) -> _Node:
        """Return the node of a plan that differs from the plan of a node from an entry on."""
        at = min(at, len(node.path) - 1)
        lacking = self._landmarks.min_actions(lacked)
        return _Node(plan, node.path, at, node.lacks, costs, lacked, node.known, lacking)

    def _is_idle(self, node: _Node, place: int, action: Action) -> bool:
        """Whether an inserted step is impossible where it stands, or changes nothing there."""
        if node.cost.insertions:
            return False
        after = self._states.take_step(node.path[place], action)
        return after is None or after == node.path[place]
