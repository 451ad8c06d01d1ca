"""The errata that decided a verdict. Records contain this value; reading records loads no errata."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class ErrataUse:
    """The errata behind a verdict.

    Attributes:
        version: version of the table of errata.
        entries: ids of the errata of this task that can change its verdict.
    """

    version: str
    entries: tuple[str, ...] = ()
