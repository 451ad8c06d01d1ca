"""Ground actions, and the faults that keep steps from being executed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from eai.world.fault import FaultKind
from eai.world.operator import Check


class Action(NamedTuple):
    """A ground action: the name of an operator, and the objects by index."""

    operator: str
    arguments: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Fault:
    """The reason why a step was not executed.

    Attributes:
        kind: the kind of error.
        check: the check of the operator that failed.
        earlier: index of the last state of the trajectory at which the missing condition held; negative for a
            state before the trajectory. Only faults of kind wrong order have an index, others None.
    """

    kind: FaultKind
    check: Check
    earlier: int | None = None
