"""The objects of a scene as what the variables of a formula range over."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from eai.logic.frozen import Frozen
from eai.world.state import Scene


@dataclass(frozen=True, slots=True)
class SceneObjects(Frozen):
    """The objects of a scene by category, for quantifiers (`eai.logic.choice.Universe`)."""

    scene: Scene

    def objects(self, category: str | None) -> Sequence[str]:
        """The names of the objects of a category, in the scene's order."""
        return self.scene.names(self.scene.category(category))
