"""A defect of the reference's simulators, as a change of a declared domain."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from eai.world.domain import Domain


@dataclass(frozen=True, slots=True)
class Quirk:
    """A named defect of the reference's simulator.

    Attributes:
        name: what reports call it.
        source: where the reference has it.
        meaning: what it does, in one sentence.
        apply: puts it into a domain.
    """

    name: str
    source: str
    meaning: str
    apply: Callable[[Domain], Domain]
