"""Which errata decided a verdict: records hold it, and reading records loads no errata."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class ErrataUse:
    """The errata behind a verdict.

    Attributes:
        version: version of the table of errata.
        entries: ids of the errata that concern the task and decide verdicts on it.
    """

    version: str
    entries: tuple[str, ...] = ()
