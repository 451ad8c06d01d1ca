"""The errata (known errors in published data) that can change a verdict, as stored with the verdict.

This module is separate so that reading stored verdicts does not load the table of errata.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class ApplicableErrata:
    """The errata (known errors in published data) that can change a verdict.

    Attributes:
        version: version of the table of errata.
        entries: ids of the errata of this task that can change its verdict.
    """

    version: str
    entries: tuple[str, ...] = ()
