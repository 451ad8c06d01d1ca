"""Landmarks of plans: sets of actions, of each of which every plan that succeeds has one.

They are found in the delete relaxation. What some actions never bring about, whatever they delete and
however often they are taken, takes another action: one that makes the first of the changes that lie between
them and the goals. Such a cut is a disjunctive landmark, whatever else a plan has. A plan lacks at least as
many actions as hit all cuts that it does not hit itself; if a fewest set of these is taken to be there, too,
the next cut is found (an implicit hitting set, Bonet and Helmert 2010), until the goals are in reach.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Collection, Iterable, Sequence
from functools import cached_property, reduce
from operator import or_
from typing import TypeAlias

import eai.logic.formula as f
from eai.planning.conflict_changes import ConflictChanges, change_order
from eai.planning.effect_schema import FactChange
from eai.planning.search import Effort
from eai.planning.subgoal import Subgoal, arguments_of
from eai.world.action import Action
from eai.world.condition import Scope
from eai.world.derived import find_definition
from eai.world.relation import bits
from eai.world.state import State

Cut: TypeAlias = frozenset[Action]
"""Actions of which every plan that succeeds has one."""

_TRUE, _FALSE = 0, 1
"""The numbers of the conditions that always hold, and never."""

_MOST = 30_000
"""So many conditions are looked at; then what is asked for is taken to hold."""

_VALUES = 60
"""Of a variable with more values than this they are not told apart."""

_BRANCHES = 200
"""So many ways to hit all cuts are tried; then disjoint cuts are counted instead."""

_WIDE = 250
"""A cut with more actions than this is only taken where it is the first."""

_AT_ONCE = 20
"""So many conditions of the graph take the effort of a step in each look for a cut."""


class _Relaxation:
    """The delete relaxation of one episode: a graph of conditions and of the changes they come down to.

    A condition needs all or any of its parts, a change needs one of the actions that make it. The graph grows
    backwards from the conditions that are asked about, by the actions that are asked about, where these seem
    not to reach the goals.

    Args:
        flips: says which changes conditions need, and which actions make them.
        initial: where plans begin.
        goals: what plans are to achieve.
        steps: the steps of a plan, be they about other objects than the actions that flips know.
    """

    def __init__(
        self, flips: ConflictChanges, initial: State, goals: Iterable[Subgoal], steps: Iterable[Action]
    ) -> None:
        self._flips = flips
        self._initial = initial
        self._actions = [*dict.fromkeys(steps)]
        self._others = [each for each in self._actions if each not in flips.actions_of(each.operator)]
        self._parts: list[tuple[int, ...]] = [(), ()]
        self._missing = [0, 1]
        self._widths = [0, 0]
        self._above: list[list[int]] = [[], []]
        self._numbers: dict[object, int] = {}
        self._formulas: list[f.Formula] = []
        self._changes: dict[int, FactChange] = {}
        self._tried: dict[int, int] = {}
        self._needs: dict[Action, list[int]] = {}
        self._makers: dict[int, dict[Action, list[int]]] = {}
        self._grouped: dict[int, list[tuple[Sequence[Action], list[int]]]] = {}
        self._made: dict[int, list[tuple[Action, int]]] = {}
        self._open: set[object] = set()
        self._goal = self._all([self._condition(goal.formula, goal.scope, goal.truth) for goal in goals])

    @property
    def size(self) -> int:
        """The number of conditions in the graph."""
        return len(self._parts)

    def cut(self, actions: Collection[Action]) -> list[Action] | None:
        """A cut between some actions and the goals; None if they may reach them."""
        self._actions += sorted({*actions}.difference(self._actions))
        while True:
            reached = self._reached(actions)
            if reached[self._goal]:
                return None
            between = self._between(actions, reached)
            if not self._grow(between):
                break
        found: dict[Action, None] = {}
        for number in between:
            for makers, given in self._groups(number):
                if between.keys().isdisjoint(given):
                    found.update(dict.fromkeys(makers))
            found.update(dict.fromkeys([a for a in self._others if a in self._makers.get(number, ())]))
        return [action for action in found if action not in actions]

    def _between(self, actions: Collection[Action], reached: bytearray) -> dict[int, None]:
        """The conditions between some actions and the goals, nearest first.

        Of conditions that are all needed it is one that fails, of those any of which helps it is each.
        """
        seen = {self._goal: None}
        pending = deque(seen)
        while pending:
            number = pending.popleft()
            parts: Iterable[int] = self._parts[number]
            if number in self._changes:
                parts = [part for a, ways in self._makers[number].items() if a in actions for part in ways]
            elif self._missing[number] > 1:
                lacking = [part for part in parts if not reached[part]]
                near = [part for part in lacking if part in seen]
                parts = near[:1] or [min(lacking, key=self._widths.__getitem__)]
            fresh = [part for part in parts if part not in seen]
            seen.update(dict.fromkeys(fresh))
            pending += fresh
        return seen

    def _groups(self, number: int) -> list[tuple[Sequence[Action], list[int]]]:
        """The actions that make a change, those together under the same conditions; none of a condition."""
        change = self._changes.get(number)
        if change is None:
            return []
        found = self._grouped.get(number)
        if found is None:
            makers = [
                (a, [self._condition(*each, True) for each in given])
                for a, given in self._flips.group_makers(change)
            ]
            found = self._grouped[number] = [(a, given) for a, given in makers if _FALSE not in given]
        return found

    def _reached(self, actions: Collection[Action]) -> bytearray:
        """Which conditions some actions may bring about, by number."""
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

    def _grow(self, numbers: Iterable[int]) -> bool:
        """Enter the actions that make some changes; whether there were new ones."""
        fresh = [
            (number, action)
            for number in numbers
            if number in self._changes
            for action in self._actions[self._tried[number] :]
        ]
        self._tried.update(dict.fromkeys([number for number, _ in fresh], len(self._actions)))
        return sum([self._enter(number, action) for number, action in fresh]) > 0

    def _enter(self, number: int, action: Action) -> bool:
        """Enter the conditions under which an action makes a change, one for each way, if there are any."""
        ways: list[int] = []
        for conditions in self._flips.effect_conditions(action, self._changes[number]):
            own = [self._condition(*each, True) for each in conditions]
            condition = self._all([*self._needed(action), *own])
            if condition != _FALSE:
                ways.append(condition)
                self._made.setdefault(condition, []).append((action, number))
        if ways:
            self._makers[number][action] = ways
        return bool(ways)

    def _needed(self, action: Action) -> list[int]:
        """The conditions under which an action is carried out."""
        found = self._needs.get(action)
        if found is None:
            needs = self._flips.preconditions(action)
            found = self._needs[action] = [self._condition(*each, True) for each in needs]
        return found

    def _condition(self, formula: f.Formula, scope: Scope, truth: bool) -> int:
        """The number of a condition."""
        key = id(formula), tuple([scope[name] for name in self._flips.names(formula)]), truth
        known = self._numbers.get(key)
        if known is None:
            self._formulas.append(formula)  # so that no other one gets its id
            known = self._numbers[key] = self._find(formula, scope, truth)
        return known

    def _find(self, formula: f.Formula, scope: Scope, truth: bool) -> int:
        if self._flips.holds(formula, scope, self._initial) == truth or len(self._parts) > _MOST:
            return _TRUE
        match formula:
            case f.Not(operand):
                return self._condition(operand, scope, not truth)
            case f.And(operands) | f.Or(operands):
                parts = [(operand, scope) for operand in operands]
                return self._joined(parts, truth, all_needed=isinstance(formula, f.And) == truth)
            case f.Exists(variable, body) | f.ForAll(variable, body):
                values = [*bits(self._initial.scene.category(variable.category))]
                if len(values) <= _VALUES:
                    parts = [(body, {**scope, variable.name: value}) for value in values]
                    return self._joined(parts, truth, all_needed=isinstance(formula, f.ForAll) == truth)
            case f.Atom():
                return self._atom(formula, scope, truth)
        return self._any_change(self._flips.find_changes(formula, scope, self._initial, truth=truth))

    def _joined(self, parts: Sequence[tuple[f.Formula, Scope]], truth: bool, *, all_needed: bool) -> int:
        found: list[int] = []
        for formula, scope in sorted(parts, key=lambda part: self._flips.count_read_predicates(part[0])):
            number = self._condition(formula, scope, truth)
            if number == (_FALSE if all_needed else _TRUE):
                return number
            found.append(number)
        return self._all(found) if all_needed else self._any(found)

    def _atom(self, atom: f.Atom, scope: Scope, truth: bool) -> int:
        arguments = arguments_of(atom, scope, self._initial.scene)
        derived = self._flips.derived(atom.predicate)
        defined = None if derived is None else find_definition(derived)
        if defined is None:
            return self._any_change(self._flips.find_changes(atom, scope, self._initial, truth=truth))
        key = atom.predicate, arguments, truth
        known = self._numbers.get(key)
        if known is not None and not truth and key in self._open:  # it may cease to be so with itself
            return self._any_change(self._flips.all_changes(atom))
        if known is None:  # nothing is so because it is so: what is asked for on the way is this condition
            number = self._numbers[key] = self._new((), 1, 0)
            self._open.add(key)
            inner = dict(zip([p.name for p in defined.parameters], arguments, strict=True))
            part = self._condition(defined.definition, inner, truth)
            self._open.discard(key)
            self._parts[number] = (part,)
            self._widths[number] = self._widths[part]
            self._above[part].append(number)
            self._numbers[key] = known = part if part in (_TRUE, _FALSE) else number
        return known

    def _any_change(self, changes: Iterable[FactChange]) -> int:
        return self._any([self._change(change) for change in sorted(changes, key=change_order)])

    def _change(self, change: FactChange) -> int:
        known = self._numbers.get(change)
        if known is None:
            makers = self._flips.actions_making(change) or [
                a for a in self._others if self._flips.may_make(a, change)
            ]
            known = self._numbers[change] = self._new((), 1, len(makers)) if makers else _FALSE
            if makers:
                self._changes[known] = change
                self._makers[known] = {}
                self._tried[known] = 0
        return known

    def _all(self, parts: Iterable[int]) -> int:
        own = tuple(dict.fromkeys([part for part in parts if part != _TRUE]))
        return _FALSE if _FALSE in own else self._of(own, len(own), _TRUE)

    def _any(self, parts: Iterable[int]) -> int:
        own = tuple(dict.fromkeys([part for part in parts if part != _FALSE]))
        return _TRUE if _TRUE in own else self._of(own, 1, _FALSE)

    def _of(self, parts: tuple[int, ...], needed: int, none: int) -> int:
        """The number of the condition that needs so many of its parts."""
        if len(parts) < 2:
            return parts[0] if parts else none
        key = needed > 1, parts
        known = self._numbers.get(key)
        if known is None:
            widths = [self._widths[part] for part in parts]
            width = min(widths) if needed > 1 else sum(widths)
            known = self._numbers[key] = self._new(parts, needed, width)
        return known

    def _new(self, parts: tuple[int, ...], needed: int, width: int) -> int:
        number = len(self._parts)
        self._parts.append(parts)
        self._missing.append(needed)
        self._widths.append(width)
        self._above.append([])
        for part in parts:
            self._above[part].append(number)
        return number


class Landmarks:
    """The cuts that are known while one plan is repaired, and how many actions hit them.

    Args:
        flips: says which changes conditions need, and which actions make them.
        initial: where plans begin.
        goals: what they are to achieve.
        steps: the steps of the plan.
        cuts: cuts that are known from the start.

    Attributes:
        cuts: those that are known.
    """

    def __init__(
        self,
        flips: ConflictChanges,
        initial: State,
        goals: Iterable[Subgoal],
        steps: Iterable[Action],
        cuts: Iterable[Cut] = (),
    ) -> None:
        self._given = flips, initial, goals, steps
        self.cuts: list[Cut] = []
        self._hits: dict[Action, int] = {}
        self._fewest: dict[int, tuple[int, tuple[Action, ...]]] = {0: (0, ())}
        self._done: set[frozenset[Action]] = set()
        for cut in filter(None, cuts):
            self._take(cut)

    @cached_property
    def _relaxation(self) -> _Relaxation:
        return _Relaxation(*self._given)

    def _take(self, cut: Iterable[Action]) -> None:
        bit = 1 << len(self.cuts)
        self.cuts.append(frozenset(cut))
        for action in cut:
            self._hits[action] = self._hits.get(action, 0) | bit

    def hit_cuts(self, action: Action | None) -> int:
        """The cuts that an action hits, as a mask."""
        return 0 if action is None else self._hits.get(action, 0)

    def missed_cuts(self, actions: Iterable[Action]) -> int:
        """The cuts that none of some actions hits, as a mask."""
        found = (1 << len(self.cuts)) - 1
        for action in actions:
            found &= ~self._hits.get(action, 0)
        return found

    def min_actions(self, mask: int) -> int:
        """The fewest actions that hit some cuts."""
        return self._hitting(mask)[0]

    def refine(self, own: frozenset[Action], effort: Effort) -> None:
        """Find cuts until a plan is known to lack more, or all that it lacks is known.

        Args:
            own: the actions of the plan.
            effort: what may be spent; it counts conditions that are looked at.
        """
        if own in self._done or effort.is_used_up:
            return
        lacked = self.min_actions(self.missed_cuts(own))
        while (
            own not in self._done
            and not effort.is_used_up
            and self.min_actions(self.missed_cuts(own)) == lacked
        ):
            there, number = {*own, *self._hitting(self.missed_cuts(own))[1]}, len(self.cuts)
            while not effort.is_used_up:
                cut = self._relaxation.cut(there)
                effort.used += 1 + self._relaxation.size // _AT_ONCE
                if not cut or (self.cuts and len(cut) > _WIDE):
                    break
                self._take(cut)
                there.update([action for action in cut if action.arguments == cut[0].arguments])
            if len(self.cuts) == number:
                self._done.add(own)

    def _hitting(self, mask: int) -> tuple[int, tuple[Action, ...]]:
        """The number of actions that hit some cuts at least, and actions that do."""
        found = self._fewest.get(mask)
        if found is None:
            found = self._fewest[mask] = self._find(mask)
        return found

    def _find(self, mask: int) -> tuple[int, tuple[Action, ...]]:
        by_hits: dict[int, Action] = {}
        for action, hits in self._hits.items():
            if hits & mask:
                by_hits.setdefault(hits & mask, action)
        patterns = [p for p in by_hits if not any(p & q == p != q for q in by_hits)]
        search = _HittingSets(patterns, mask)
        return search.least, tuple([by_hits[pattern] for pattern in search.best])


class _HittingSets:
    """A search for a fewest set of patterns that covers a mask.

    Args:
        patterns: the masks that there are.
        mask: the mask.

    Attributes:
        least: so many patterns it takes at least.
        best: the fewest that were found.
    """

    def __init__(self, patterns: Sequence[int], mask: int) -> None:
        with_bit = {
            bit: [pattern for pattern in patterns if pattern & bit] for bit in map((1).__lshift__, bits(mask))
        }
        self._with_bit = dict(sorted(with_bit.items(), key=lambda item: len(item[1])))
        self._beside = {bit: reduce(or_, own) for bit, own in self._with_bit.items()}
        self._branches = 0
        self.best: tuple[int, ...] = self._greedy(mask)
        self.least = self._disjoint(mask)
        if self.least < len(self.best):
            self._cover(mask, ())
            if self._branches <= _BRANCHES:
                self.least = len(self.best)

    def _greedy(self, mask: int) -> tuple[int, ...]:
        found = []
        for bit, patterns in self._with_bit.items():
            if mask & bit:
                found.append(max(patterns, key=lambda pattern: (pattern & mask).bit_count()))
                mask &= ~found[-1]
        return tuple(found)

    def _disjoint(self, mask: int) -> int:
        """The number of cuts that are found of which no two are hit by one pattern."""
        number = 0
        for bit, beside in self._beside.items():
            if mask & bit:
                number += 1
                mask &= ~beside
        return number

    def _cover(self, mask: int, chosen: tuple[int, ...]) -> None:
        self._branches += 1
        if not mask:
            self.best = chosen
            return
        if self._branches > _BRANCHES or len(chosen) + self._disjoint(mask) >= len(self.best):
            return
        patterns = next(own for bit, own in self._with_bit.items() if mask & bit)
        for pattern in sorted(patterns, key=lambda pattern: -(pattern & mask).bit_count()):
            self._cover(mask & ~pattern, (*chosen, pattern))
