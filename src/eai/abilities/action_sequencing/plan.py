"""Plans as a model writes them: steps with names, before anyone knows whether the names mean something."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from eai.abilities.explanation import Explanation
from eai.abilities.json_text import MAX_LENGTH
from eai.abilities.verdict import ErrorReport


class WrittenStep(NamedTuple):
    """One step of an answer.

    Attributes:
        action: the action as written.
        arguments: what stands in its list, as written; numbers and other JSON values are kept.
    """

    action: str
    arguments: tuple[object, ...]


@dataclass(frozen=True, slots=True)
class WrittenPlan:
    """The steps of an answer in order, and the names of the repairs that were needed to read them."""

    steps: tuple[WrittenStep, ...]
    repairs: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Unreadable:
    """Why no plan can be read from an answer.

    ``times_counted`` is how often the reference counts it among the parsing errors.
    """

    reason: str
    times_counted: int = 1


TOO_LONG = Unreadable(f"the answer is longer than {MAX_LENGTH:,} characters")
"""What both protocols say of an answer that no model writes; it is not searched."""


@dataclass(frozen=True, slots=True)
class Rejected:
    """An answer that cannot be run, and why: parsing, hallucination or argument number."""

    error: ErrorReport


def rejection_explained(notes: tuple[str, ...], error: ErrorReport) -> Explanation:
    """Why an answer cannot be run, after the notes on it."""
    step = f"step {error.step + 1}: " if error.step is not None else ""
    return Explanation(notes=(*notes, f"{error.kind.value}: {step}{error.detail}"))
