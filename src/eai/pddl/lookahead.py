"""Lookahead: relaxed planning carried out, each part of it where it is needed (after Vidal 2004).

A relaxed plan forgets that what is true may be lost: it goes but once to where many things have to be
brought. Here each literal is made true just before the action that needs it, and once more where it has been
lost since. The state that this leads to is often the goal, or nearly so.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from eai.pddl.literals import Literals, bits
from eai.pddl.relaxation import Layers, Relaxation, Rule
from eai.pddl.successors import Successors

_ROUNDS = 2
"""How often literals that are needed together are made true, where one is lost while another is made."""

_AGAIN = 2
"""How many actions deep what was true at the start, and is lost, is made true again."""

_RULES = 2_000
"""How many rules one lookahead may try."""


class Taken(NamedTuple):
    """An action that was taken, by its number, and the state after it."""

    action: int
    state: int


class _Mark(NamedTuple):
    """How many actions were taken at some time, and the state and literals then."""

    taken: int
    state: int
    held: int


class _Missing(NamedTuple):
    """How much of a goal is missing: of what was so at the start of a lookahead, and in all."""

    since_start: int
    in_all: int


class Lookahead:
    """Looks ahead from one state.

    Args:
        relaxation: the rules by which literals become true.
        successors: what actions do.
        literals: what conditions are about.
        goal: the literals that are wanted.
    """

    def __init__(self, relaxation: Relaxation, successors: Successors, literals: Literals, goal: int) -> None:
        self._relaxation = relaxation
        self._successors = successors
        self._literals = literals
        self._goal = goal
        self._rules_left = _RULES
        self._layers = Layers([], [])
        self._start = self._state = self._held = 0
        self._taken: list[Taken] = []

    def towards(self, state: int, literals: int) -> Sequence[Taken]:
        """Actions from a state, in which these literals are, after which less of the goal is missing."""
        self._layers = self._relaxation.layers(literals)
        self._state, self._start, self._held = state, literals, literals
        before = None
        while (missing := self._missing()) != before and missing.in_all:
            before = missing
            for literal in self._in_order(self._goal & ~self._held, len(self._layers.fired)):
                if not self._held & literal:
                    self._gain(literal)
        return self._taken

    def _missing(self) -> _Missing:
        missing = self._goal & ~self._held
        return _Missing((missing & ~self._start).bit_count(), missing.bit_count())

    def _gain(self, literal: int) -> None:
        """Make a literal of the goal true by the first rule that leaves less of it missing; or by none."""
        missing, mark = self._missing(), self._mark()
        for depth, fired in enumerate(self._layers.fired):
            for rule in self._relaxation.makers(literal, fired):
                if self._follow(rule, depth) and self._missing() < missing:
                    return
                self._return_to(mark)

    def _follow(self, rule: Rule, depth: int) -> bool:
        """Take the action of a rule of a layer, after what it needs; whether that is possible."""
        self._rules_left -= 1
        if self._rules_left < 0 or not self._make(rule.needs, depth):
            return False
        self._state = self._successors.after(rule.action, self._state, self._held)
        self._held = self._literals.of(self._state)
        self._taken.append(Taken(rule.action, self._state))
        return True

    def _make(self, needed: int, depth: int) -> bool:
        """Make literals true together by rules of the layers before one; whether all are true in the end.

        Those that take longest come first, or else last.
        """
        mark = self._mark()
        for last in (False, True):
            for _ in range(_ROUNDS):
                missing = self._in_order(needed & ~self._held, depth)
                for literal in missing[::-1] if last else missing:
                    if not self._held & literal:
                        self._make_one(literal, depth)
                if not needed & ~self._held:
                    return True
            self._return_to(mark)
        return False

    def _make_one(self, literal: int, depth: int) -> None:
        """Make a literal true by the first rule of the layers before one; if it was lost, of the first."""
        for before, fired in enumerate(self._layers.fired[: max(depth, int(depth > -_AGAIN))]):
            for rule in self._relaxation.makers(literal, fired):
                self._follow(rule, min(before, depth - 1))
                return

    def _in_order(self, missing: int, depth: int) -> list[int]:
        """Literals that are missing, those first that take longest to reach."""
        missing, found = self._literals.chosen(missing, self._layers.reached[max(depth, 0)]), list[int]()
        for reached in self._layers.reached[max(depth, 0) :: -1]:
            found += bits(missing & ~reached)
            missing &= reached
        return [*found, *bits(missing)]

    def _mark(self) -> _Mark:
        return _Mark(len(self._taken), self._state, self._held)

    def _return_to(self, mark: _Mark) -> None:
        """Forget all actions since then."""
        del self._taken[mark.taken :]
        self._state, self._held = mark.state, mark.held
