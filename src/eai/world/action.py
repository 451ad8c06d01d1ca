"""Ground actions, and faults: the reasons why steps were not executed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from eai.world.fault import FaultKind
from eai.world.operator import Check


class Action(NamedTuple):
    """A ground action: the name of an operator, and the indices of its objects."""

    operator: str
    arguments: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Fault:
    """The reason why a step was not executed.

    Attributes:
        kind: the kind of error.
        check: the operator's check that failed.
        earlier: for a wrong order, the index in the trajectory of the last state in which the missing
            condition held; negative if that state precedes the trajectory. None for other kinds of error.
    """

    kind: FaultKind
    check: Check
    earlier: int | None = None
