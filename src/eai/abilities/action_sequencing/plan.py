"""Plans as a model writes them: steps with names, before anyone knows whether the names mean something."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from eai.abilities.json_text import MAX_LENGTH
from eai.abilities.unreadable import Unreadable
from eai.logic.frozen import Frozen


class WrittenStep(NamedTuple):
    """One step of an answer.

    Attributes:
        action: the action as written.
        objects: what stands for each of its objects; the text of it is what messages call the object.
    """

    action: str
    objects: tuple[object, ...]


@dataclass(frozen=True, slots=True)
class WrittenPlan(Frozen):
    """The steps of an answer in order, and the names of the repairs that were needed to read them."""

    steps: tuple[WrittenStep, ...]
    repairs: tuple[str, ...] = ()


TOO_LONG = Unreadable(f"the answer is longer than {MAX_LENGTH:,} characters")
"""What there is to say of an answer that no model writes; it is not searched."""
