"""How episodes go: how often possible actions do not work, who notices, and when an episode ends."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

from eai.errors import InputError

Notice: TypeAlias = Literal["detected", "silent"]
"""Whether whoever acts learns of a slip.

A detected slip ends the plan. After a silent one the plan continues as if the action had worked, and what
depends on it fails later.
"""

Until: TypeAlias = Literal["goal", "done"]
"""When an episode ends: in the first state in which all goals are reached, or when the agent says so."""


@dataclass(frozen=True, slots=True)
class Slips:
    """How often possible actions do not work (paper, appendix on replanning with stochastic actions).

    Attributes:
        probability: that a possible action slips, independently of all others.
        seed: of the draws.
        notice: whether a slip is noticed.

    Raises:
        InputError: the probability is not between 0 and 1.
    """

    probability: float
    seed: int = 0
    notice: Notice = "detected"

    def __post_init__(self) -> None:
        if not 0 <= self.probability <= 1:
            raise InputError(f"a slip probability of {self.probability:g} is not between 0 and 1")
