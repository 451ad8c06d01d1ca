"""Repair: the fewest edits that make a plan succeed.

An edit inserts a step, deletes one, or replaces one. What a plan breaks at, a step that is impossible or a
goal that it misses, is its conflict: some edit of every repair helps it, by a change without which it stays
(`eai.planning.flips`). So a search over edited plans, those with fewest edits first, that tries at each no
other edits finds all repairs with fewest edits. Effort is counted and never timed.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
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
from eai.world.execution import Action
from eai.world.fault import FaultKind
from eai.world.state import State

Plan: TypeAlias = Sequence["Action | None"]
"""The steps of a plan as they are written; None is one that means nothing."""

_SOON, _EXACT, _WALKING, _UNDOING = 0.03, 0.7, 0.075, 0.025
"""The parts of the effort: for fewest edits before any edits are looked for and in all, for the ways through
a plan, and for each repair that is found to do without some of its edits."""

_STATES = 300
"""The states that a planner may reach that finishes a plan."""

_LOOKS, _START = 1, 3
"""How many actions a planner may look at for a step that may be tried, and how many times as many from the
start, which it does once a task."""

_WALKS, _ENABLING = 4, Limits(20, looks=2_000)
"""So many ways through a plan are followed side by side; so much is done to make a step possible."""

_STEPS = 8
"""So many steps that are taken count as one thing that is done."""

_KEPT = 50_000
"""So many states are kept from one plan to the next."""

_FATAL = -1
"""The number of the state after a step that cannot be carried out."""


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


class _Course(NamedTuple):
    """The course of an edited plan up to its conflict.

    Attributes:
        states: the number of the state before each entry that was reached, and of the last one.
        taken: how many action goals were taken before each.
    """

    states: tuple[int, ...]
    taken: tuple[int, ...]


class _Walk(NamedTuple):
    """A way through a plan, or through its beginning.

    Attributes:
        plan: the plan as it is edited.
        number: the number of the state that it leads to.
        taken: how many action goals are taken.
    """

    plan: Edited
    number: int
    taken: int

    @property
    def reached(self) -> tuple[int, int]:
        """The number of the state that it leads to, and how many action goals are taken."""
        return self.number, self.taken

    @property
    def edits(self) -> int:
        """The number of its edits."""
        return cost(normal(self.plan)).edits


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
        self._after: dict[tuple[int, Action], tuple[int, bool]] = {}
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
        search = _Search(self, plan)
        best = search.run(effort.limit * _SOON)
        if best is None:
            looks = int(min(_LOOKS * effort.limit, Limits().looks))
            found = [self._undone(each, plan, effort) for each in self._finished(plan, looks, effort)]
            best = min(found, key=_edits, default=None)
            best = search.run(effort.limit * _EXACT, _edits(best)) or best
        effort.used += search.effort.used
        return search.least, None if best is None else told(best)

    def least(self, effort: Effort) -> int:
        """So many steps every plan has that succeeds, as far as so much effort proves."""
        search = _Search(self, ())
        search.run(effort.limit * _EXACT)
        effort.used += search.effort.used
        return search.least

    def _finished(self, plan: Plan, looks: int, effort: Effort) -> Iterator[Edited]:
        """Repairs that need not have fewest edits: a planner goes on from where a plan leads; it begins anew.

        On the way on it may look at so many actions.
        """
        own = Effort(effort.limit * _WALKING)
        walk = self._walk(tuple([_Entry(i, action) for i, action in enumerate(plan)]), own)
        effort.used += own.used
        further = self._way(walk.number, walk.taken, looks)
        if further is not None:
            kept = [entry.action for entry in walk.plan if entry.action is not None]
            yield normal(_aligned(plan, (*kept, *further)))
        whole = self._whole(_START * looks)
        if whole is not None:
            yield normal(_aligned(plan, whole))

    def _walk(self, plan: Edited, effort: Effort) -> _Walk:
        """The best way through a plan: what fails is deleted, or what it needs is put before it.

        Several are followed side by side, as long as the effort lasts.
        """
        walks = [_Walk((), 0, 0)]
        for i, entry in enumerate(plan):
            found: dict[tuple[int, int], _Walk] = {}
            mends = not effort.is_used_up
            for walk in [each for one in walks for each in self._past(one, entry, mends=mends)]:
                known = found.setdefault(walk.reached, walk)
                if walk.edits < known.edits:
                    found[walk.reached] = walk
            walks = [*found.values()]
            if len(walks) > 1:
                rest = plan[i + 1 :]
                effort.used += len(rest) * len(walks)
                lacks = [self.lacks(rest, _Course((w.number,), (w.taken,))) for w in walks]
                ranked = sorted(zip(walks, lacks, strict=True), key=lambda pair: pair[0].edits + pair[1])
                walks = [walk for walk, _ in ranked[:_WALKS]]
        return walks[0]

    def _past(self, walk: _Walk, entry: _Entry, *, mends: bool) -> Iterator[_Walk]:
        """The ways past an entry: as it stands, or else mended or deleted."""
        kept = self._followed(walk, (), entry)
        if kept is not None:
            yield kept
            return
        yield walk._replace(plan=(*walk.plan, entry._replace(action=None)))
        way = self._enabling(walk.number, entry.action) if mends and entry.action is not None else None
        mended = None if way is None else self._followed(walk, way, entry)
        if mended is not None:
            yield mended

    def _followed(self, walk: _Walk, way: Sequence[Action], entry: _Entry) -> _Walk | None:
        """A way through a plan that goes on by some actions and a step; None if one of them is impossible."""
        plan, number, taken = walk
        for each in (*[_Entry(-1, action) for action in way], entry):
            if each.action is not None:
                number, executed = self.after(number, each.action)
                if number == _FATAL:
                    return None
                taken = self.takes(taken, each.action) if executed else taken
            plan = (*plan, each)
        return _Walk(plan, number, taken)

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
            if cost(trial).edits < cost(plan).edits and self.succeeds(
                trial, self.course(trial, _Course((0,), (0,)), 0)
            ):
                plan, trials = trial, _with_one_undone(trial, original)
        effort.used += own.used
        return plan

    def _whole(self, looks: int) -> tuple[Action, ...] | None:
        """A plan from the start, if the planner finds one; looked for once."""
        if looks not in self._plans:
            self._plans[looks] = self._way(0, 0, looks)
        return self._plans[looks]

    def _way(self, number: int, taken: int, looks: int) -> tuple[Action, ...] | None:
        """The actions of the planner from a state, if it finds a plan."""
        goal = PlanningGoal(self.goal.conditions, self.goal.actions[taken:])
        found = self._planner.plan(self.states[number], goal, self.objects, Limits(_STATES, looks=looks))
        return found.plan if found.end is SearchEnd.SOLVED else None

    def singles(self, plan: Plan) -> Iterator[Told]:
        """All single edits that make a plan succeed."""
        entries = tuple([_Entry(i, action) for i, action in enumerate(plan)])
        course = self.course(entries, _Course((0,), (0,)), 0)
        names = {name for names in self.goal.actions for name in names}
        operators = [o for o in self.domain.operators if o.effects or o.tries or o.name in names]
        first = next((i for i, action in enumerate(plan) if action is None), len(plan))
        for i, number in enumerate(course.states[: first + 1]):
            rests = [(i, None)] if i == len(plan) else [(i, None), (i + 1, i)]
            if i < len(plan) and self._wins(number, course.taken[i], entries[i + 1 :]):
                yield Told(i, i, None)
            for operator in operators:
                for action in applicable_actions(self.domain, operator, self.states[number], self.objects):
                    after, executed = self.after(number, action)
                    taken = self.takes(course.taken[i], action) if executed else course.taken[i]
                    for start, gone in rests:
                        if (gone is None or action != plan[gone]) and self._wins(
                            after, taken, entries[start:]
                        ):
                            yield Told(i, gone, action)

    def _wins(self, number: int, taken: int, rest: Edited) -> bool:
        """Whether the rest of a plan succeeds from a state."""
        if any(entry.action is None for entry in rest):
            return False
        course = self.course(rest, _Course((number,), (taken,)), 0)
        return self.succeeds(rest, course)

    def after(self, number: int, action: Action) -> tuple[int, bool]:
        """The state after a step, `_FATAL` if it is impossible, and whether it is executed, not skipped."""
        found = self._after.get((number, action))
        if found is None:
            found = self._after[number, action] = self._try(number, action)
        return found

    def _try(self, number: int, action: Action) -> tuple[int, bool]:
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
        return (number, False) if kind is FaultKind.ADDITIONAL_STEP else (_FATAL, False)

    def takes(self, taken: int, action: Action) -> int:
        """How many action goals are taken after a step that is executed."""
        wanted = self.goal.actions
        return taken + (taken < len(wanted) and action.operator in wanted[taken])

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
        states, taken = list(begin.states[: at + 1]), list(begin.taken[: at + 1])
        for _, action in plan[at:]:
            number, met = states[-1], taken[-1]
            if action is not None:
                number, executed = self.after(number, action)
                if number == _FATAL:
                    break
                met = self.takes(met, action) if executed else met
            states.append(number)
            taken.append(met)
        return _Course(tuple(states), tuple(taken))

    def landmarks(self, plan: Plan) -> Landmarks:
        """The landmarks of all plans that succeed, of which those are looked for that a plan may lack."""
        steps = [step for step in plan if step is not None]
        untaken = [names for names in self.goal.actions if not any(step.operator in names for step in steps)]
        taking = [frozenset([a for name in names for a in self.flips.taking(name)]) for names in untaken]
        return Landmarks(self.flips, self.initial, self.missed(0), steps, taking)

    def lacks(self, plan: Edited, course: _Course) -> int:
        """How many steps fail and goals are missed where steps that fail are passed over."""
        number, taken, failed = course.states[-1], course.taken[-1], 0
        for _, action in plan[len(course.states) - 1 :]:
            if action is not None:
                after, executed = self.after(number, action)
                failed += after == _FATAL
                number = number if after == _FATAL else after
                taken = self.takes(taken, action) if executed else taken
        return failed + len(self.missed(number)) + len(self.goal.actions) - taken

    def succeeds(self, plan: Edited, course: _Course) -> bool:
        """Whether a plan with this course succeeds."""
        all_tried = len(course.states) > len(plan)
        return all_tried and course.taken[-1] == len(self.goal.actions) and not self.missed(course.states[-1])


class _Edit(NamedTuple):
    """An edit of an edited plan: an action is put before the entry with this number, or that is deleted."""

    place: int
    action: Action | None


_Edits: TypeAlias = tuple[int, tuple[Action | None, ...]]
"""The edits at one place."""


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
        at = len(course.states) - 1
        if at < len(plan) and (action := plan[at].action) is not None:
            own: list[_Edits] = [(at, (None,))] if plan[at].is_kept else []
            return own + self._helping(plan, course, self._unblocking(course.states[at], action), frozenset())
        choices = [self._helping(plan, course, c, frozenset()) for c in self._reaching(course.states[at])]
        if course.taken[at] < len(self._world.goal.actions):
            names = [n for names in self._world.goal.actions[: course.taken[at] + 1] for n in names]
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
        for place in range(len(course.states) - 1, -1, -1):
            found.append((place, listed))
            if place == 0:
                break
            entry = plan[place - 1]
            if entry.action is None:
                continue
            behind, undoes = self._behind(course.states[place - 1], entry.action, changes, names)
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


def edited(plan: Edited, edit: _Edit) -> Edited:
    """A plan after one more edit."""
    place, action = edit
    if action is None:
        return (*plan[:place], plan[place]._replace(action=None), *plan[place + 1 :])
    return (*plan[:place], _Entry(-1, action), *plan[place:])


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


class _Queue:
    """The edited plans that are to be looked at, each once before and once after it is carried out.

    Args:
        effort: counts them.
    """

    def __init__(self, effort: Effort) -> None:
        self.effort = effort
        self._waiting: OpenList[_Node] = OpenList()
        self._seen: set[tuple[Edited, bool]] = set()
        self._pushed = 0

    def push(self, node: _Node) -> None:
        """Put a plan where its rank says, if it is new; the last of equals comes first."""
        if (node.plan, node.at < 0) not in self._seen:
            self._seen.add((node.plan, node.at < 0))
            self.push_again(node)

    def push_again(self, node: _Node) -> None:
        """Put a plan where its rank says, though it is not new."""
        self._pushed += 1
        self.effort.used += self._pushed % _PUSHES == 0
        self._waiting.push(node, node.at_least, node.lacks, -self._pushed)

    def pop(self) -> _Node | None:
        """Take the plan that comes next."""
        return self._waiting.pop()


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
        self._queue = _Queue(self.effort)
        start = tuple([_Entry(i, action) for i, action in enumerate(plan)])
        self._queue.push(_Node(start, _Course((0,), (0,)), 0, 0, cost(start), 0, -1, 0))

    def run(self, limit: float, known: float = inf) -> Edited | None:
        """Search best first, or go on with it; the repair with fewest edits if one is found.

        Args:
            limit: what may be spent in all.
            known: the number of edits of a repair that is known; only those with fewer are looked for.
        """
        self.effort.limit = limit
        while self.least < known and (node := self._queue.pop()) is not None:
            informed = self._informed(node)
            if informed.at_least > node.at_least:
                self._queue.push_again(informed)
                continue
            self.least = max(self.least, node.at_least)
            if self.effort.is_used_up:
                self._queue.push_again(informed)
                break
            if node.at < 0:
                self._expand(informed)
            elif self._carry_out(informed):
                return node.plan
        self.least = int(min(self.least, known))
        return None

    def _carry_out(self, node: _Node) -> bool:
        """Whether a plan succeeds; else it is to be gone on with, and so is what takes no edit more."""
        self.effort.used += 1 + len(node.plan) // _STEPS
        course = self._world.course(node.plan, node.course, node.at)
        if self._world.succeeds(node.plan, course):
            return True
        lacks = self._world.lacks(node.plan, course)
        self._queue.push(node._replace(course=course, at=-1, lacks=lacks, least=node.cost.with_steps(1)))
        for place in _replaceable(node.plan):
            if place < len(course.states):
                self._queue.push(self._child(node._replace(course=course, lacks=lacks), _Edit(place, None)))
        return False

    def _expand(self, node: _Node) -> None:
        """Go on with the edits that may help a plan; those that make it take more than it does come later.

        Most are never asked for then (partial expansion, Yoshizumi, Miura and Ishida 2000).
        """
        edits = node.edits or self._conflicts.edits(node.plan, node.course)
        self.effort.used += 0 if node.edits else _CONFLICT * len(node.course.states)
        lacking: dict[Action | None, int] = {}
        ranks: set[int] = set()
        for place, actions in edits:
            if self.effort.is_used_up:
                self._queue.push_again(node)
                return
            if None in actions:
                child = self._child(node, _Edit(place, None))
                ranks.add(child.at_least)
                if child.at_least <= node.at_least:
                    self._queue.push(child)
            elif actions:
                ranks |= self._insert(node, place, actions, lacking)
        if ranks and max(ranks) > node.at_least:
            self._queue.push_again(node._replace(edits=edits, least=node.at_least + 1))

    def _insert(
        self,
        node: _Node,
        place: int,
        actions: Sequence[Action | None],
        lacking: dict[Action | None, int],
    ) -> set[int]:
        """Go on with what takes no more edits where one of some actions is put in; how many they take each.

        ``lacking`` keeps how many steps the plan lacks with each of them.
        """
        self.effort.used += len(actions) // _EDITS
        costs, most = self._cost(node, _Edit(place, actions[0])), node.at_least
        ranks: set[int] = set()
        for action in actions:
            number = lacking.get(action)
            if number is None:
                lacked = node.open & ~self._landmarks.hits(action)
                number = lacking[action] = self._landmarks.lacking(lacked)
            rank = costs.with_steps(number)
            if rank <= most and rank < costs.with_steps(1) and self._is_idle(node, place, action):
                rank += 1
            ranks.add(rank)
            if node.least * bool(node.edits) <= rank <= most:
                self._queue.push(self._child(node, _Edit(place, action)))
        return ranks

    def _cost(self, node: _Node, edit: _Edit) -> _Cost:
        """The cost of a plan after one more edit, whatever action it is about."""
        if not _stands_alone(node.plan, edit):
            return cost(normal(edited(node.plan, edit)))
        edits, deletions, insertions = node.cost
        inserts = edit.action is not None
        return _Cost(edits + 1, deletions + (not inserts), insertions + inserts)

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

    def _child(self, node: _Node, edit: _Edit) -> _Node:
        """A plan after one more edit, to be carried out."""
        child, costs = edited(node.plan, edit), self._cost(node, edit)
        at = min(edit.place, len(node.course.states) - 1)
        if not _stands_alone(node.plan, edit):
            child = normal(child)
            same = zip(child, node.plan, strict=False)
            at = min(at, next((i for i, (a, b) in enumerate(same) if a != b), at))
        lacked = node.open
        if edit.action is not None:
            lacked &= ~self._landmarks.hits(edit.action)
        elif self._landmarks.hits(node.plan[edit.place].action):
            lacked = self._landmarks.open([e.action for e in child if e.action is not None])
        lacking = node.lacking if lacked == node.open else self._landmarks.lacking(lacked)
        return _Node(child, node.course, at, node.lacks, costs, lacked, node.known, lacking)

    def _is_idle(self, node: _Node, place: int, action: Action | None) -> bool:
        """Whether an inserted step cannot be carried out where it stands, or changes nothing there."""
        if action is None or node.cost.insertions:
            return False
        before, taken = node.course.states[place], node.course.taken[place]
        after, executed = self._world.after(before, action)
        takes = executed and self._world.takes(taken, action) > taken
        return after == _FATAL or (after == before and not takes)


_EASY = 60
"""With so much effort no landmarks are looked for yet, as many plans take one edit."""

_PUSHES = 4
"""So many plans are put into a queue with the effort of a step."""

_CONFLICT, _EDITS = 5, 80
"""The effort of taking a conflict apart for each step before it; so many edits are looked at for one more."""


def _stands_alone(plan: Edited, edit: _Edit) -> bool:
    """Whether no entry next to an edit is an edit."""
    place, action = edit
    last = place - 1
    after = place if action is not None else place + 1
    return (last < 0 or plan[last].is_kept) and (after >= len(plan) or plan[after].is_kept)
