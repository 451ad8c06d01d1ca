"""Ground actions, and the faults for which they are not executed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from eai.world.fault import FaultKind
from eai.world.operator import Check


class Action(NamedTuple):
    """A ground action: an operator's name and object indices."""

    operator: str
    arguments: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Fault:
    """Why a step was not executed.

    Attributes:
        kind: the kind that counts.
        check: the check whose failure it is.
        earlier: the index of the last state of the trajectory at which what the check seeks was there,
            negative for one before the trajectory; given exactly for a wrong order.
    """

    kind: FaultKind
    check: Check
    earlier: int | None = None
