"""Repair: the fewest edits that make a plan succeed.

An edit inserts a step, deletes one, or replaces one. What a plan breaks at, a step that is impossible or a
goal that it misses, is its conflict: some edit of every repair helps it, by a change without which it stays
(`eai.planning.flips`). So a search over edited plans, those with fewest edits first, that tries at each no
other edits finds all repairs with fewest edits. Effort is counted and never timed.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby, product
from math import inf
from typing import NamedTuple, TypeAlias

from eai.planning.effect_schema import Change
from eai.planning.flips import Changes, Flips, left
from eai.planning.landmarks import Landmarks
from eai.planning.planner import Planner, PlanningGoal
from eai.planning.search import Effort, Limits, OpenList, SearchEnd
from eai.planning.subgoal import Subgoal, subgoals_of
from eai.planning.successor_generator import applicable_actions
from eai.world.action import Action
from eai.world.fault import FaultKind
from eai.world.state import State

Plan: TypeAlias = Sequence["Action | None"]
"""The steps of a plan as they are written; None is one that means nothing."""

_SOON, _EXACT, _WALKING, _UNDOING = 0.03, 0.7, 0.075, 0.025
"""The parts of the effort: for fewest edits before any edits are looked for and in all, for the ways through
a plan, and for each repair that is found to do without some of its edits."""

_STATES = 300
"""The states that a planner may reach that finishes a plan."""

_START = 3
"""So many times as many actions a planner may look at from the start, which it does once a task."""

_ENABLING = Limits(20, looks=2_000)
"""So much is done to make a step possible."""

_STEPS = 8
"""So many steps that are taken count as one thing that is done."""

_MANY, _CUTS = 5_000, 500
"""Of more edits than this those are tried that hit landmarks; the effort by which these are looked for."""

_KEPT = 50_000
"""So many states are kept from one plan to the next."""


class _Entry(NamedTuple):
    """An entry of an edited plan.

    Attributes:
        step: the number of the step of the plan that stands or stood here; -1 of an inserted one.
        action: what is done here; None where a step was deleted.
    """

    step: int
    action: Action | None

    @property
    def is_kept(self) -> bool:
        """Whether it is a step as it was."""
        return self.step >= 0 and self.action is not None


Edited: TypeAlias = tuple[_Entry, ...]

_Moment: TypeAlias = tuple[int, int]
"""The number of a state, and how many action goals are taken."""

_Course: TypeAlias = tuple[_Moment, ...]
"""The moment before each entry of a plan up to its conflict, and after the last."""

_BEGIN: _Course = ((0, 0),)


class Told(NamedTuple):
    """An edit of a plan as it is told.

    Attributes:
        step: the step before which an action is put, from 0.
        gone: the step that is deleted or replaced, likewise; None if none is.
        action: what is put there; None if nothing is.
    """

    step: int
    gone: int | None
    action: Action | None


class Mender:
    """Mends plans for one task; the states that they pass through are worked out once.

    Args:
        planner: finds a way on from where a plan leads, which bounds the number of edits from above.
        initial: where plans begin.
        goal: what they are to achieve.
        objects: what inserted steps may be about, by index.
    """

    def __init__(self, planner: Planner, initial: State, goal: PlanningGoal, objects: Sequence[int]) -> None:
        self._planner = planner
        self.domain = planner.domain
        self.initial = initial
        self.goal = goal
        self.objects = objects
        self.flips = Flips(planner.domain, initial, objects, planner.heuristic.achievers)
        self._plans: dict[int, tuple[Action, ...] | None] = {}
        self._forget()
        self._goals = subgoals_of(goal.conditions, initial.scene)

    def _forget(self) -> None:
        """Know no state but the initial one."""
        self.states = [self.initial]
        self._numbers = {self.initial: 0}
        self._after: dict[tuple[int, Action], tuple[int | None, bool]] = {}
        self._missed: dict[int, tuple[Subgoal, ...]] = {}
        self._ways: dict[tuple[int, Action], tuple[Action, ...] | None] = {}

    def mend(self, plan: Plan, effort: Effort) -> tuple[int, tuple[Told, ...] | None]:
        """How many edits every repair of a plan has, and the edits of the smallest that was found, if any.

        Args:
            plan: the plan.
            effort: what may be spent, about; whether something was done before makes no difference.
        """
        if len(self.states) > _KEPT:
            self._forget()
        if self.flips.is_partial:
            return self._bound(plan, effort)
        search = _Search(self, plan)
        best = search.run(effort.limit * _SOON)
        if best is None:
            best = self._planned(plan, effort)
            best = search.run(effort.limit * _EXACT, _edits(best)) or best
        effort.used += search.effort.used
        return search.least, None if best is None else told(best)

    def _bound(self, plan: Plan, effort: Effort) -> tuple[int, tuple[Told, ...] | None]:
        """Return bounds like `mend` from plans alone, as there are too many actions to prove anything."""
        entries = as_entries(plan)
        if None not in plan and self.succeeds(entries, self.course(entries, _BEGIN, 0)):
            return 0, ()
        best = self._planned(plan, effort)
        return 1, None if best is None else told(best)

    def _planned(self, plan: Plan, effort: Effort) -> Edited | None:
        """Return the smallest of the repairs that the planner finds, or None."""
        looks = int(min(effort.limit, Limits().looks))
        repairs = [self._undone(each, plan, effort) for each in self._finished(plan, looks, effort)]
        return min(repairs, key=_edits, default=None)

    def least(self, effort: Effort) -> int:
        """So many steps every plan has that succeeds, as far as so much effort proves."""
        if self.flips.is_partial:
            return int(bool(self.missed(0) or self.goal.actions))
        search = _Search(self, ())
        search.run(effort.limit * _EXACT)
        effort.used += search.effort.used
        return search.least

    def _finished(self, plan: Plan, looks: int, effort: Effort) -> Iterator[Edited]:
        """Repairs that need not have fewest edits: a planner goes on from where a plan leads; it begins anew.

        On the way on it may look at so many actions.
        """
        own = Effort(0 if self.flips.is_partial else effort.limit * _WALKING)
        actions, moment = self._walk(plan, own)
        effort.used += own.used
        further = self._way(moment, looks)
        if further is not None:
            yield normal(_aligned(plan, (*actions, *further)))
        whole = self._whole(_START * looks)
        if whole is not None:
            yield normal(_aligned(plan, whole))

    def _walk(self, plan: Plan, effort: Effort) -> tuple[list[Action], _Moment]:
        """The actions of a plan without what fails, or with what makes it possible, and where they lead."""
        actions: list[Action] = []
        moment, gone = _BEGIN[0], 0
        for i, step in enumerate(plan):
            past = None if step is None else self._past(moment, step, plan[i + 1 :], gone, effort)
            gone = gone + 1 if past is None else 0
            if past is not None:
                own, moment = past
                actions += own
        return actions, moment

    def _past(
        self, moment: _Moment, step: Action, rest: Plan, gone: int, effort: Effort
    ) -> tuple[Sequence[Action], _Moment] | None:
        """A step, after what makes it possible, and where that leads; None if it is better left out.

        Args:
            moment: where it is taken.
            step: the step.
            rest: those after it.
            gone: how many were left out just before it.
            effort: while it lasts a step is made possible.
        """
        after = self.step(moment, step)
        if after is not None:
            return (step,), after
        before = None if effort.is_used_up else self._enabling(moment[0], step)
        if before is None:
            return None
        course = self.course(as_entries((*before, step)), (moment,), 0)
        if len(course) < len(before) + 2:  # which fails before the step, or there
            return None
        after = course[-1]
        effort.used += 2 * len(rest)
        edits = max(0, len(before) - gone) + self.lacks(rest, after)
        return ((*before, step), after) if edits < 1 + self.lacks(rest, moment) else None

    def _enabling(self, number: int, action: Action) -> tuple[Action, ...] | None:
        """The actions by which the planner makes a step possible, if it finds some; looked for once."""
        key = number, action
        if key not in self._ways:
            operator = self.domain.compiled[action.operator].operator
            scope = operator.scope(action.arguments)
            checks = [c.condition for c in operator.checks if c.fault is not FaultKind.ADDITIONAL_STEP]
            goals = tuple([Subgoal(condition, scope, True) for condition in checks])
            self._ways[key] = self._planner.reach(self.states[number], goals, self.objects, _ENABLING)
        return self._ways[key]

    def _undone(self, plan: Edited, original: Plan, effort: Effort) -> Edited:
        """A repair without the edits that it does without, as far as its part of the effort lasts."""
        own = Effort(effort.limit * _UNDOING)
        trials = _with_one_undone(plan, original)
        while (trial := next(trials, None)) is not None and not own.is_used_up:
            own.used += 1 + len(trial) // _STEPS
            if cost(trial).edits < cost(plan).edits and self.succeeds(trial, self.course(trial, _BEGIN, 0)):
                plan, trials = trial, _with_one_undone(trial, original)
        effort.used += own.used
        return plan

    def _whole(self, looks: int) -> tuple[Action, ...] | None:
        """A plan from the start, if the planner finds one; looked for once."""
        if looks not in self._plans:
            self._plans[looks] = self._way(_BEGIN[0], looks)
        return self._plans[looks]

    def _way(self, moment: _Moment, looks: int) -> tuple[Action, ...] | None:
        """The actions of the planner from a moment on, if it finds a plan."""
        number, taken = moment
        goal = PlanningGoal(self.goal.conditions, self.goal.actions[taken:])
        found = self._planner.plan(self.states[number], goal, self.objects, Limits(_STATES, looks=looks))
        return found.plan if found.end is SearchEnd.SOLVED else None

    def singles(self, plan: Plan) -> Iterator[Told]:
        """All single edits that make a plan succeed."""
        entries, conflicts, known = as_entries(plan), _Conflicts(self), self.landmarks(plan)
        course = self.course(entries, _BEGIN, 0)
        if None not in plan:
            helping = conflicts.edits(entries, course)
        else:  # what means nothing has to go
            helping = [(place, (None,)) for place in (plan.index(None),) if place < len(course)]
        if sum([len(actions) for _, actions in helping]) > _MANY:
            known.refine(frozenset(filter(None, plan)), Effort(_CUTS))
        for place, actions in helping:
            if actions == (None,):
                without = edited(entries, place, None)[0]
                left = self.course(without, course, place)
                anything: Iterable[Action | None] = self._possible(course[place])
                if self.succeeds(without, left):
                    yield Told(place, place, None)
                else:
                    anything = dict(conflicts.edits(without, left)).get(place, ())
                yield from self._put(plan, Told(place, place, None), course[place], anything, known)
            else:
                yield from self._put(plan, Told(place, None, None), course[place], actions, known)
                if place < len(plan) and (place, (None,)) not in helping:
                    yield from self._put(plan, Told(place, place, None), course[place], actions, known)

    def _put(
        self,
        plan: Plan,
        edit: Told,
        moment: _Moment,
        actions: Iterable[Action | None],
        known: Landmarks,
    ) -> Iterator[Told]:
        """The edits by which a plan succeeds that put one of some actions where one puts nothing yet."""
        rest = plan[edit.step + (edit.gone is not None) :]
        lacked = known.open(filter(None, (*plan[: edit.step], *rest)))
        was = None if edit.gone is None else plan[edit.gone]
        for action in actions:
            if action is None or action == was or lacked & ~known.hits(action):
                continue
            if self.after(moment[0], action)[1] and self._wins(self.step(moment, action), rest):
                yield edit._replace(action=action)

    def _possible(self, moment: _Moment) -> Iterator[Action]:
        """The actions that are possible and may make a difference."""
        names = {name for names in self.goal.actions for name in names}
        for operator in self.domain.operators:
            if operator.effects or operator.tries or operator.name in names:
                state, bindings = self.states[moment[0]], Effort(Limits().bindings)
                yield from applicable_actions(self.domain, operator, state, self.objects, bindings)

    def _wins(self, moment: _Moment | None, rest: Plan) -> bool:
        """Whether the rest of a plan succeeds from a moment on."""
        if moment is None or None in rest:
            return False
        entries = as_entries(rest)
        return self.succeeds(entries, self.course(entries, (moment,), 0))

    def step(self, moment: _Moment, action: Action) -> _Moment | None:
        """The moment after a step; None if it is impossible."""
        number, taken = moment
        after, executed = self.after(number, action)
        if after is None:
            return None
        wanted = self.goal.actions
        takes = executed and taken < len(wanted) and action.operator in wanted[taken]
        return after, taken + takes

    def after(self, number: int, action: Action) -> tuple[int | None, bool]:
        """The number of the state after a step, None if it is impossible; if it is executed, not skipped."""
        found = self._after.get((number, action))
        if found is None:
            found = self._after[number, action] = self._try(number, action)
        return found

    def _try(self, number: int, action: Action) -> tuple[int | None, bool]:
        state, operator = self.states[number], self.domain.compiled[action.operator]
        binding = operator.bind(state, action.arguments)
        if operator.is_possible(state, binding):
            after = operator.apply(state, binding)
            found = self._numbers.setdefault(after, len(self.states))
            if found == len(self.states):
                self.states.append(after)
            return found, True
        kinds = {failure.check.check.fault for failure in operator.failures(state, binding)}
        kind = min(kinds, key=self.domain.precedence.index)
        return (number if kind is FaultKind.ADDITIONAL_STEP else None), False

    def missed(self, number: int) -> tuple[Subgoal, ...]:
        """The goals about the end that do not hold in a state."""
        found = self._missed.get(number)
        if found is None:
            state, holds = self.states[number], self.flips.holds
            lacking = [g for g in self._goals if holds(g.formula, g.scope, state) != g.truth]
            found = self._missed[number] = tuple(lacking)
        return found

    def course(self, plan: Edited, begin: _Course, at: int) -> _Course:
        """The course of a plan that is as one whose course is known before an entry.

        Args:
            plan: the plan.
            begin: the course of the other plan.
            at: up to which entry both are the same, and can be carried out.
        """
        found = [*begin[: at + 1]]
        for _, action in plan[at:]:
            after = found[-1] if action is None else self.step(found[-1], action)
            if after is None:
                break
            found.append(after)
        return tuple(found)

    def landmarks(self, plan: Plan) -> Landmarks:
        """The landmarks of all plans that succeed, of which those are looked for that a plan may lack."""
        steps = [step for step in plan if step is not None]
        untaken = [names for names in self.goal.actions if not any(step.operator in names for step in steps)]
        taking = [frozenset([a for name in names for a in self.flips.taking(name)]) for names in untaken]
        return Landmarks(self.flips, self.initial, self.missed(0), steps, taking)

    def lacks(self, steps: Plan, moment: _Moment) -> int:
        """How many steps fail and goals are missed from a moment on, where steps that fail are left out."""
        failed = 0
        for action in steps:
            if action is not None:
                after = self.step(moment, action)
                failed += after is None
                moment = after or moment
        number, taken = moment
        return failed + len(self.missed(number)) + len(self.goal.actions) - taken

    def succeeds(self, plan: Edited, course: _Course) -> bool:
        """Whether a plan with this course succeeds."""
        number, taken = course[-1]
        return len(course) > len(plan) and taken == len(self.goal.actions) and not self.missed(number)


_Edits: TypeAlias = tuple[int, tuple[Action | None, ...]]
"""The actions that may be put before an entry, by its number; None: the entry is deleted."""


class _Conflicts:
    """The conflicts of edited plans, and the edits that may help them.

    Args:
        mender: that of the task.
    """

    def __init__(self, mender: Mender) -> None:
        self._world = mender
        self._flips = mender.flips
        self._fatal: dict[tuple[int, Action], Changes] = {}
        self._lacking: dict[int, list[Changes]] = {}

    def edits(self, plan: Edited, course: _Course) -> list[_Edits]:
        """The edits one of which every repair of a plan has, as far as those of others are none of it."""
        at = len(course) - 1
        number, taken = course[at]
        if at < len(plan) and (action := plan[at].action) is not None:
            own: list[_Edits] = [(at, (None,))] if plan[at].is_kept else []
            return own + self._helping(plan, course, self._unblocking(number, action), frozenset())
        choices = [self._helping(plan, course, changes, frozenset()) for changes in self._reaching(number)]
        if taken < len(self._world.goal.actions):
            names = [n for names in self._world.goal.actions[: taken + 1] for n in names]
            choices.append(self._helping(plan, course, frozenset(), frozenset(names)))
        return min(choices, key=lambda edits: sum(len(actions) for _, actions in edits))

    def _unblocking(self, number: int, action: Action) -> Changes:
        """The changes one of which makes a fatal step possible, or one to be skipped."""
        found = self._fatal.get((number, action))
        if found is None:
            found = self._fatal[number, action] = self._find_unblocking(number, action)
        return found

    def _find_unblocking(self, number: int, action: Action) -> Changes:
        state, operator = self._world.states[number], self._world.domain.compiled[action.operator].operator
        scope = operator.scope(action.arguments)
        found: set[Change] = set()
        for check in operator.checks:
            holds = self._flips.holds(check.condition, scope, state)
            if not holds:
                found |= self._flips.of(left(check, operator.checks), scope, state, truth=True)
                return frozenset(found)
            if check.fault is FaultKind.ADDITIONAL_STEP:
                found |= self._flips.of(check.condition, scope, state, truth=False)
        for each in operator.tries:
            for condition in (each.condition, *[check.condition for check in each.checks]):
                holds = self._flips.holds(condition, scope, state)
                if not holds or condition is each.condition:
                    found |= self._flips.of(condition, scope, state, truth=not holds)
        return frozenset(found)

    def _reaching(self, number: int) -> list[Changes]:
        """For each goal that is missed in a state the changes one of which reaches it."""
        found = self._lacking.get(number)
        if found is None:
            state, of = self._world.states[number], self._flips.of
            found = [of(g.formula, g.scope, state, truth=g.truth) for g in self._world.missed(number)]
            self._lacking[number] = found
        return found

    def _helping(
        self, plan: Edited, course: _Course, changes: Changes, names: frozenset[str]
    ) -> list[_Edits]:
        """The edits before the conflict that may make one of some changes, or take one of some operators."""
        found: list[_Edits] = []
        actions = {
            **self._flips.actions(changes),
            **{a: None for n in sorted(names) for a in self._flips.taking(n)},
        }
        listed = tuple(actions)
        for place in range(len(course) - 1, -1, -1):
            found.append((place, listed))
            if place == 0:
                break
            entry = plan[place - 1]
            if entry.action is None:
                continue
            behind, undoes = self._behind(course[place - 1][0], entry.action, changes, names)
            if entry.is_kept and undoes:
                found.append((place - 1, (None,)))
            if not behind <= changes:
                actions |= self._flips.actions(behind - changes)
                listed = tuple(actions)
                changes |= behind
        return found

    def _behind(
        self, number: int, action: Action, changes: Changes, names: frozenset[str]
    ) -> tuple[Changes, bool]:
        """The changes before a step that may alter what it does to those that help; whether it undoes one."""
        state, executed = self._world.states[number], self._world.after(number, action)[1]
        behind, undoes = self._flips.behind(action, state, changes, executed=executed)
        if action.operator in names and not executed:
            behind |= self._flips.skipping(action, state, executed=False)
        return behind, undoes


def as_entries(plan: Plan) -> Edited:
    """A plan without edits."""
    return tuple([_Entry(i, action) for i, action in enumerate(plan)])


def _aligned(plan: Plan, other: Sequence[Action]) -> Edited:
    """Another plan as an edited one, with fewest edits (Levenshtein 1966)."""
    rows = [[*range(len(other) + 1)]]
    for i, step in enumerate(plan, 1):
        row = [i]
        for j, action in enumerate(other):
            row.append(min(rows[-1][j] + (step != action), rows[-1][j + 1] + 1, row[j] + 1))
        rows.append(row)
    found: list[_Entry] = []
    i, j = len(plan), len(other)
    while i or j:
        if i and j and plan[i - 1] == other[j - 1] and rows[i][j] == rows[i - 1][j - 1]:
            i, j = i - 1, j - 1
            found.append(_Entry(i, other[j]))
            continue
        paired = i and j and rows[i][j] == rows[i - 1][j - 1] + 1
        if i and (paired or rows[i][j] == rows[i - 1][j] + 1):
            i -= 1
            found.append(_Entry(i, None))
        if j and (paired or found[-1:] != [_Entry(i, None)]):
            j -= 1
            found.append(_Entry(-1, other[j]))
    return tuple(reversed(found))


def _with_one_undone(plan: Edited, original: Plan) -> Iterator[Edited]:
    """The plans that have an inserted step or a deletion less, or one of each."""
    yield from _with_less(plan)
    start = 0
    for is_kept, entries in groupby(plan, key=lambda entry: entry.is_kept):
        own = [*entries]
        before, after = plan[:start], plan[start + len(own) :]
        start += len(own)
        inserted = [entry for entry in own if entry.step < 0]
        gone = [] if is_kept else own[len(inserted) :]
        for i, place in product(range(len(gone)), range(len(inserted), -1, -1)):
            kept = gone[i]._replace(action=original[gone[i].step])
            if kept.is_kept:
                segment = (*inserted[:place], *gone[:i], kept, *inserted[place:], *gone[i + 1 :])
                yield (*before, *segment, *after)
                yield from _with_less((*before, *segment, *after))


def _with_less(plan: Edited) -> Iterator[Edited]:
    """The plans with an inserted step less."""
    yield from ((*plan[:i], *plan[i + 1 :]) for i, entry in enumerate(plan) if entry.step < 0)


class _Cost(NamedTuple):
    """The number of edits in an edited plan, and how many of them only delete or only insert a step."""

    edits: int
    deletions: int
    insertions: int

    def with_steps(self, number: int) -> int:
        """The number of edits at least where so many steps are put in besides."""
        return self.edits + max(0, number - self.deletions)


def cost(plan: Edited) -> _Cost:
    """The cost of an edited plan: a deleted and an inserted step between two kept ones are one edit."""
    edits = deletions = insertions = deleted = inserted = 0
    for step, action in (*plan, _END):
        if step < 0:
            inserted += 1
        elif action is None:
            deleted += 1
        elif deleted or inserted:
            edits += max(deleted, inserted)
            deletions += max(0, deleted - inserted)
            insertions += max(0, inserted - deleted)
            deleted = inserted = 0
    return _Cost(edits, deletions, insertions)


def _edits(plan: Edited | None) -> float:
    """The number of edits in an edited plan; infinite if there is none."""
    return inf if plan is None else cost(plan).edits


def _replaceable(plan: Edited) -> Iterator[int]:
    """The kept steps that are deleted for nothing, as one more is inserted before each than is deleted."""
    surplus = 0
    for place, entry in enumerate(plan):
        if entry.is_kept and surplus > 0:
            yield place
        surplus = 0 if entry.is_kept else surplus + (1 if entry.step < 0 else -1)


_END = _Entry(0, Action("", ()))
"""Stands for a step that is kept."""


def told(plan: Edited) -> tuple[Told, ...]:
    """The edits in an edited plan; of what is deleted and inserted between kept steps the first are pairs."""
    found: list[Told] = []
    inserted: list[Action | None] = []
    gone: list[int] = []
    for step, action in (*plan, _Entry(max((entry.step for entry in plan), default=-1) + 1, _END.action)):
        if step < 0:
            inserted.append(action)
        elif action is None:
            gone.append(step)
        else:
            pairs = min(len(inserted), len(gone))
            found += [Told(g, g, a) for g, a in zip(gone, inserted, strict=False)]
            found += [Told(g, g, None) for g in gone[pairs:]] + [
                Told(step, None, a) for a in inserted[pairs:]
            ]
            inserted, gone = [], []
    return tuple(found)


def normal(plan: Edited) -> Edited:
    """The same edits with all steps that are inserted between two kept ones before those that are deleted."""
    found: list[_Entry] = []
    for is_kept, entries in groupby(plan, key=lambda entry: entry.is_kept):
        own = [*entries]
        found += own if is_kept else sorted(own, key=lambda entry: entry.step >= 0)
    return tuple(found)


def edited(plan: Edited, place: int, action: Action | None) -> tuple[Edited, int]:
    """A plan after one more edit, in the order of `normal`, and from which entry on it is another."""
    start = place
    while start and plan[start - 1].step >= 0 and plan[start - 1].action is None:
        start -= 1
    if action is not None:
        return (*plan[:start], _Entry(-1, action), *plan[start:]), start
    end = place + 1
    while end < len(plan) and plan[end].step < 0:
        end += 1
    gone = plan[place]._replace(action=None)
    return (*plan[:start], *plan[place + 1 : end], *plan[start:place], gone, *plan[end:]), start


class _Node(NamedTuple):
    """An edited plan that is to be looked at.

    Attributes:
        plan: the plan.
        course: its course, or of the plan before its last edit that is the same up to ``at``.
        at: from which entry on the course is not known; -1 where all of it is.
        lacks: how many steps fail and goals are missed, in the plan before the last edit if ``at`` says so.
        cost: the cost of the plan.
        open: the landmarks that it lacks, as a mask.
        known: how many landmarks were known then.
        lacking: how many steps it lacks at least, as they show.
        least: how many edits it takes at least, as far as that is known otherwise.
        edits: the edits that were put off, as they take more.
    """

    plan: Edited
    course: _Course
    at: int
    lacks: int
    cost: _Cost
    open: int
    known: int
    lacking: int
    least: int = 0
    edits: Sequence[_Edits] = ()

    @property
    def at_least(self) -> int:
        """How many edits all repairs have that have those of the plan."""
        return max(self.least, self.cost.with_steps(self.lacking))


class _Search:
    """The search for the repairs of one plan, which can be gone on with.

    Args:
        mender: that of the task.
        plan: the plan.

    Attributes:
        effort: what is spent.
        least: how many edits every repair has at least.
    """

    def __init__(self, mender: Mender, plan: Plan) -> None:
        self._world = mender
        self._conflicts = _Conflicts(mender)
        self._landmarks = mender.landmarks(plan)
        self._steps = frozenset([step for step in plan if step is not None])
        self.effort = Effort()
        self.least = 0
        self._waiting: OpenList[_Node] = OpenList()
        self._seen: set[tuple[Edited, bool]] = set()
        self._pushed = 0
        start = as_entries(plan)
        self._push(_Node(start, _BEGIN, 0, 0, cost(start), 0, -1, 0))

    def run(self, limit: float, known: float = inf) -> Edited | None:
        """Search best first, or go on with it; the repair with fewest edits if one is found.

        Args:
            limit: what may be spent in all.
            known: the number of edits of a repair that is known; only those with fewer are looked for.
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
        """Put a plan into the queue, once before and once after it is carried out."""
        if (node.plan, node.at < 0) not in self._seen:
            self._seen.add((node.plan, node.at < 0))
            self._push_again(node)

    def _push_again(self, node: _Node) -> None:
        """Put a plan where its rank says; the last of equals comes first."""
        self._pushed += 1
        self.effort.used += self._pushed % _PUSHES == 0
        self._waiting.push(node, node.at_least, node.lacks, -self._pushed)

    def _carry_out(self, node: _Node) -> bool:
        """Whether a plan succeeds; else it is to be gone on with, and so is what takes no edit more."""
        self.effort.used += 1 + len(node.plan) // _STEPS
        course = self._world.course(node.plan, node.course, node.at)
        if self._world.succeeds(node.plan, course):
            return True
        rest = [action for _, action in node.plan[len(course) - 1 :]]
        lacks = self._world.lacks(rest, course[-1])
        self._push(node._replace(course=course, at=-1, lacks=lacks, least=node.cost.with_steps(1)))
        for place in _replaceable(node.plan):
            if place < len(course):
                self._push(self._without(node._replace(course=course, lacks=lacks), place))
        return False

    def _expand(self, node: _Node) -> None:
        """Go on with the edits that may help a plan; those that make it take more than it does come later.

        Most are never asked for then (partial expansion, Yoshizumi, Miura and Ishida 2000).
        """
        edits = node.edits or self._conflicts.edits(node.plan, node.course)
        self.effort.used += 0 if node.edits else _CONFLICT * len(node.course)
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
        """Go on with what takes no more edits where one of some actions is put in; the most that one takes.

        ``lacking`` keeps how many steps the plan lacks with each of them.
        """
        self.effort.used += len(actions) // _EDITS
        plan, at = edited(node.plan, place, actions[0])
        costs, first, last = cost(plan), node.least if node.edits else 0, node.at_least
        most = 0
        for action in filter(None, actions):
            lacked = node.open & ~self._landmarks.hits(action)
            number = lacking.get(action)
            if number is None:
                number = lacking[action] = self._landmarks.lacking(lacked)
            rank = costs.with_steps(number)
            if rank <= last and rank < costs.with_steps(1) and self._is_idle(node, place, action):
                rank += 1
            most = max(most, rank)
            if first <= rank <= last:
                child = (*plan[:at], _Entry(-1, action), *plan[at + 1 :])
                self._push(self._child(node, child, at, costs, lacked))
        return most

    def _without(self, node: _Node, place: int) -> _Node:
        """A plan without one of its steps, to be carried out."""
        plan, at = edited(node.plan, place, None)
        lacked = node.open
        if self._landmarks.hits(node.plan[place].action):
            lacked = self._landmarks.open([e.action for e in plan if e.action is not None])
        return self._child(node, plan, at, cost(plan), lacked)

    def _informed(self, node: _Node) -> _Node:
        """A plan with what all landmarks show that are known, of which more are looked for."""
        known = self._landmarks
        looks = self.effort if self.effort.used > _EASY else Effort(0)
        known.refine(self._steps, looks)
        if node.at >= 0 and node.known == len(known.cuts):
            return node
        steps = frozenset([entry.action for entry in node.plan if entry.action is not None])
        if node.at < 0:
            known.refine(steps, looks)
        lacked = known.open(steps)
        return node._replace(open=lacked, known=len(known.cuts), lacking=known.lacking(lacked))

    def _child(self, node: _Node, plan: Edited, at: int, costs: _Cost, lacked: int) -> _Node:
        """A plan to be carried out that is another than that of a node from an entry on."""
        at = min(at, len(node.course) - 1)
        lacking = self._landmarks.lacking(lacked)
        return _Node(plan, node.course, at, node.lacks, costs, lacked, node.known, lacking)

    def _is_idle(self, node: _Node, place: int, action: Action) -> bool:
        """Whether an inserted step cannot be carried out where it stands, or changes nothing there."""
        if node.cost.insertions:
            return False
        after = self._world.step(node.course[place], action)
        return after is None or after == node.course[place]


_EASY = 60
"""With so much effort no landmarks are looked for yet, as many plans take one edit."""

_PUSHES = 4
"""So many plans are put into a queue with the effort of a step."""

_CONFLICT, _EDITS = 5, 80
"""The effort of taking a conflict apart for each step before it; so many edits are looked at for one more."""
