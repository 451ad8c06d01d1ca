"""Defects of the reference: as changes of a declared domain, and as answers at which its whole run ends."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from eai.abilities.verdict import Unreadable
from eai.world.domain import Domain


class Aborting(Unreadable):
    """Why an answer cannot be read, where the reference does not count it as unread but stops."""

    __slots__ = ()


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
