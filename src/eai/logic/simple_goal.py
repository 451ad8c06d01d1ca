"""Simple goals, and the goals that stand for many of them (paper, section on LTL goals and its appendix).

A simple goal is an ordered list of actions followed by a conjunction of propositions for the final state. A
goal ``g`` with quantifiers and disjunctions stands for the set ``G(g, U)`` of simple goals into which it
expands over the objects ``U``. Scores against ``g`` are defined as the best over all of ``G(g, U)``; they are
computed on its and-or tree (`eai.logic.choice`), with matchings for pairings, not on the list.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass

from eai.errors import InputError
from eai.logic.choice import AllOf, AnyOf, Choice, Leaf, Literal, Universe, ground, literals
from eai.logic.formula import Atom, Equals, Formula, Not, Occurs, Then
from eai.logic.options import Option, choice_options, count_choice_options
from eai.logic.rating import Frontier, alternatives, combined, independent, ratings
from eai.logic.trajectory import Trajectory
from eai.logic.traversal import walk


@dataclass(frozen=True, slots=True)
class SimpleGoal:
    """Actions to be taken in this order, and conditions on the final state."""

    actions: tuple[Occurs, ...]
    propositions: frozenset[Literal]

    def conditions(self) -> frozenset[Literal]:
        """``set(g)``: the actions and the propositions without order."""
        return self.propositions.union(self.actions)


@dataclass(frozen=True, slots=True)
class Overlap:
    """Counts of conditions: those that two goals share, and all of either."""

    shared: int
    predicted: int
    gold: int


@dataclass(frozen=True, slots=True)
class Satisfaction:
    """How many of a simple goal's actions and propositions a trajectory satisfies."""

    satisfied: int
    total: int


def simple_goals(formula: Formula, universe: Universe) -> Iterator[SimpleGoal]:
    """``G(g, U)``: the simple goals into which a closed goal expands, lazily; some may be equal.

    Raises:
        InputError: the goal has no such expansion: a proposition comes before a ``then``, an action is
            negated, or see `choice.ground`.
    """
    return map(_simple_goal, choice_options(_expansion(formula, universe)))


def count_simple_goals(formula: Formula, universe: Universe) -> int:
    """How many simple goals `simple_goals` gives, without producing them.

    Raises:
        InputError: as `simple_goals`.
    """
    return count_choice_options(_expansion(formula, universe))


def best_overlap(predicted: Collection[Literal], formula: Formula, universe: Universe) -> Overlap:
    """The counts of ``max F1(set(p), set(g'))`` over all ``g'`` in ``G(g, U)``.

    F1 is ``2 * shared / (predicted + gold)``; among the best, the one that shares most is taken.

    Args:
        predicted: the conditions of the predicted goal, ``SimpleGoal.conditions()``.
        formula: the goal that it is compared with.
        universe: the objects.

    Raises:
        InputError: as `simple_goals`, or nothing can make the goal true.
    """
    wanted = frozenset(predicted)
    found = ratings(_expansion(formula, universe), lambda condition: condition in wanted)
    size, shared = _best(found, lambda size: len(wanted) + size)
    return Overlap(shared, len(wanted), size)


def partial_success(formula: Formula, trajectory: Trajectory) -> Satisfaction:
    """``PartialSucc(t, g)``: the largest satisfied share of a simple goal in ``G(g, U)``.

    Of a simple goal's conditions are satisfied: each proposition that holds in the final state, and as many
    actions as the trajectory takes in the order of the goal (a longest common subsequence). Among equal
    shares the one with most satisfied conditions is taken.

    Raises:
        InputError: as `simple_goals`, or nothing can make the goal true.
    """
    performance = _Performance(trajectory)
    parts = _conjuncts(performance.pruned(_expansion(formula, trajectory)))
    acting = AllOf(tuple(part for part in parts if _acts(part)))
    resting = AllOf(tuple(part for part in parts if not _acts(part)))
    if not independent((acting, resting)):
        acting, resting = AllOf(tuple(parts)), AllOf(())
    found = combined(
        alternatives(performance.rated(option) for option in choice_options(acting)),
        ratings(resting, performance.holds_finally),
    )
    total, satisfied = _best(found, lambda size: size)
    return Satisfaction(satisfied, total)


class _Performance:
    """What a trajectory does and ends with."""

    def __init__(self, trajectory: Trajectory) -> None:
        self._trajectory = trajectory
        self._last = trajectory.length - 1

    def holds_finally(self, literal: Literal) -> bool:
        match literal:
            case Not(operand):
                return not (isinstance(operand, Atom) and self.holds_finally(operand))
            case Atom(predicate, arguments):
                return bool(
                    self._trajectory.atom(predicate, tuple(t.name for t in arguments)) >> self._last & 1
                )
            case Occurs():
                return False

    def positions(self, action: Occurs) -> int:
        return self._trajectory.occurrence(action.action, tuple(t.name for t in action.arguments))

    def rated(self, option: Option) -> tuple[int, int]:
        """The size of an option and how much of it is satisfied."""
        goal = _simple_goal(option)
        satisfied = sum(map(self.holds_finally, goal.propositions)) + self._in_order(goal.actions)
        return len(goal.actions) + len(goal.propositions), satisfied

    def _in_order(self, actions: tuple[Occurs, ...]) -> int:
        """The most actions that are taken one after the other: ``earliest[k]`` is where k of them can end."""
        earliest = [-1]
        for action in actions:
            positions = self.positions(action)
            for k in range(len(earliest) - 1, -1, -1):
                later = positions >> (earliest[k] + 1)
                if later:
                    end = earliest[k] + (later & -later).bit_length()
                    if k + 1 == len(earliest):
                        earliest.append(end)
                    else:
                        earliest[k + 1] = min(earliest[k + 1], end)
        return len(earliest) - 1

    def pruned(self, choice: Choice) -> Choice:
        """The same choice without actions that never occur and have an alternative just as useless."""
        match choice:
            case AllOf(parts):
                return AllOf(tuple(map(self.pruned, parts)))
            case AnyOf():
                disjuncts = _disjuncts(choice)
                idle = [self._idle(part) for part in disjuncts]
                first = idle.index(True) if True in idle else None
                kept = [part for i, part in enumerate(disjuncts) if not idle[i] or i == first]
                return AnyOf(tuple(map(self.pruned, kept)))
            case _:
                return choice

    def _idle(self, choice: Choice) -> bool:
        if not isinstance(choice, Leaf) or not isinstance(choice.literal, Occurs):
            return False
        return not self.positions(choice.literal)


def _simple_goal(option: Option) -> SimpleGoal:
    actions = tuple(condition for condition in option if isinstance(condition, Occurs))
    return SimpleGoal(actions, frozenset(option).difference(actions))


def _expansion(formula: Formula, universe: Universe) -> Choice:
    """The and-or tree of a goal that stands for simple goals."""
    for part in walk(formula):
        if isinstance(part, Then):
            earlier = (inner for step in part.parts[:-1] for inner in walk(step))
            if any(isinstance(inner, (Atom, Equals)) for inner in earlier):
                raise InputError("not a simple goal: a proposition comes before 'then'")
    choice = ground(formula, universe)
    if any(isinstance(literal, Not) and isinstance(literal.operand, Occurs) for literal in literals(choice)):
        raise InputError("not a simple goal: an action is negated")
    return choice


def _best(found: Frontier, whole: Callable[[int], int]) -> tuple[int, int]:
    """Size and rating of the entry with the largest share of the whole that its size means."""
    if not found:
        raise InputError("nothing can make this goal true")
    entries = iter(found.items())
    best = next(entries)
    for size, rating in entries:
        difference = rating * whole(best[0]) - best[1] * whole(size)
        if difference > 0 or (difference == 0 and rating > best[1]):
            best = size, rating
    return best


def _acts(choice: Choice) -> bool:
    return any(isinstance(literal, Occurs) for literal in literals(choice))


def _conjuncts(choice: Choice) -> list[Choice]:
    if not isinstance(choice, AllOf):
        return [choice]
    return [inner for part in choice.parts for inner in _conjuncts(part)]


def _disjuncts(choice: Choice) -> list[Choice]:
    if not isinstance(choice, AnyOf):
        return [choice]
    return [inner for part in choice.parts for inner in _disjuncts(part)]
