"""Figures of a data set: a number, and what exactly is counted."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Figure:
    """One figure; `note` says what is counted."""

    label: str
    value: int | float
    note: str
