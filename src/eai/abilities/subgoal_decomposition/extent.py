"""How much a subgoal comes down to in a scene, counted before anything is unfolded.

A few words can ask for millions of literals: quantifiers multiply, and so do alternatives. What asks for too
much is refused, the same on every machine.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import prod

import eai.logic.formula as f
from eai.abilities.task import Task
from eai.errors import InputError
from eai.logic.traversal import children
from eai.world.relation import bits

MAX_LITERALS = 100_000
"""The most literals that a subgoal may come down to, and all its alternatives together."""

TOO_MUCH = f"it comes down to more than {MAX_LITERALS:,} literals"


class Extent:
    """The range of the quantifiers of subgoals, and how much that makes.

    Args:
        task: the task.
    """

    def __init__(self, task: Task) -> None:
        self._scene = task.scene
        self._relevant = task.relevant

    def everything(self, variable: f.Variable) -> Sequence[int]:
        """The objects of a variable's class: what a ``forall`` asks for."""
        return tuple(bits(self._scene.category(variable.category)))

    def usable(self, variable: f.Variable) -> Sequence[int]:
        """The task's objects of a class, or, if there are none, all in the scene: what ``exists`` tries."""
        mask = self._scene.category(variable.category)
        return [i for i in self._relevant if mask >> i & 1] or tuple(bits(mask))

    def literals(self, formula: f.Formula) -> int:
        """How many literals a test of a formula may look at.

        A kind of which there is nothing counts as one thing: what stands within or around is looked at.

        Raises:
            InputError: there are more than `MAX_LITERALS`.
        """
        match formula:
            case f.Exists(variable, body) | f.ForAll(variable, body) | f.Exactly(_, variable, body):
                number = self._size(variable) * self.literals(body)
            case f.ForPairs(first, second, body):
                number = self._size(first) * self._size(second) * self.literals(body)
            case _:
                number = sum(map(self.literals, children(formula))) or 1
        return _few(number)

    def _size(self, variable: f.Variable) -> int:
        return max(1, self._scene.category(variable.category).bit_count())

    def to_be_done(self, formula: f.Formula) -> int:
        """How many literals the alternatives of a formula in negation normal form have, all together.

        An alternative counts as one at least, also if it asks for nothing of a kind of which there is none.

        Raises:
            InputError: there are more than `MAX_LITERALS`, or a test looks at more.
        """
        self.literals(formula)
        return _few(self._choices(formula) * max(1, self._longest(formula)))

    def _choices(self, formula: f.Formula) -> int:
        """How many alternatives there are, counted no further than is allowed."""
        match formula:
            case f.And(parts):
                choices = prod(map(self._choices, parts))
            case f.Or(parts):
                choices = sum(map(self._choices, parts))
            case f.Exists(variable, body):
                choices = len(self.usable(variable)) * self._choices(body)
            case f.ForAll(variable, body):
                choices = self._choices(body) ** len(self.everything(variable))
            case _:
                choices = 1
        return min(choices, MAX_LITERALS + 1)

    def _longest(self, formula: f.Formula) -> int:
        """How many literals one alternative has at most."""
        match formula:
            case f.And(parts):
                return sum(map(self._longest, parts))
            case f.Or(parts):
                return max(map(self._longest, parts), default=0)
            case f.Exists(_, body):
                return self._longest(body)
            case f.ForAll(variable, body):
                return len(self.everything(variable)) * self._longest(body)
            case _:
                return 1


def _few(number: int) -> int:
    if number > MAX_LITERALS:
        raise InputError(TOO_MUCH)
    return number
