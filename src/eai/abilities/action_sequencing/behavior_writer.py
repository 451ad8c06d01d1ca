"""Plans written as BEHAVIOR answers: a list of actions with their objects."""

from __future__ import annotations

import json
from collections.abc import Iterable

from eai.world.execution import Action
from eai.world.state import Scene


def write_steps(plan: Iterable[Action], scene: Scene) -> tuple[str, ...]:
    """Each step as ``{"action": "OPEN", "object": "jar_0"}``."""
    return tuple(_step(action, scene) for action in plan)


def join_steps(steps: Iterable[str]) -> str:
    """The steps as one answer."""
    return "[" + ", ".join(steps) + "]"


def _step(action: Action, scene: Scene) -> str:
    names = ", ".join(scene.objects[i].name for i in action.arguments)
    return json.dumps({"action": action.operator, "object": names})
