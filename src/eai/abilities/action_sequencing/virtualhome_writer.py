"""Plans written as VirtualHome answers: names with ids, as release 1.0.5 asks for them."""

from __future__ import annotations

import json
from collections.abc import Iterable

from eai.world.execution import Action
from eai.world.state import Scene


def write_steps(plan: Iterable[Action], scene: Scene) -> tuple[str, ...]:
    """Each step as ``"GRAB": ["soap", "1002"]``; the reference needs the blank in an empty list."""
    return tuple(_step(action, scene) for action in plan)


def join_steps(steps: Iterable[str]) -> str:
    """The steps as one answer."""
    return "{" + ", ".join(steps) + "}"


def _step(action: Action, scene: Scene) -> str:
    words = [part for i in action.arguments for part in scene.objects[i].name.rsplit(".", 1)]
    return f"{json.dumps(action.operator)}: {json.dumps(words) if words else '[ ]'}"
