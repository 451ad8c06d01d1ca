"""The verdict on a scene graph."""

from __future__ import annotations

from dataclasses import dataclass

from eai.abilities.verdict import Verdict
from eai.results.record import Perceived

_NOTHING_PERCEIVED = Perceived(0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, {})


@dataclass(frozen=True, slots=True)
class SceneGraphVerdict(Verdict):
    """How right a scene graph is.

    Attributes:
        success: whether it has every described fact, and nothing that does not hold.
        seen: its differences from the scene.
    """

    success: bool = False
    seen: Perceived = _NOTHING_PERCEIVED
