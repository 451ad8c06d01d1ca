"""What a check of files finds."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing that is not as it should be.

    Attributes:
        place: the file or pack that it is about; the whole where it is about all of it.
        problem: what is wrong, with the identifier where there is one.
    """

    place: str
    problem: str
