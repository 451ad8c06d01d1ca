"""What VirtualHome subgoals may name: predicates, actions and the objects of a scene."""

from __future__ import annotations

from functools import cache

from eai.abilities.protocol import Protocol
from eai.benchmarks.virtualhome import domain as virtualhome
from eai.benchmarks.virtualhome.predicates import VOCABULARY
from eai.logic.signature import Signature
from eai.world.state import Scene

ACTIONS = (
    "DRINK",
    "EAT",
    "CUT",
    "TOUCH",
    "LOOKAT",
    "WATCH",
    "READ",
    "TYPE",
    "PUSH",
    "PULL",
    "MOVE",
    "SQUEEZE",
    "SLEEP",
    "WAKEUP",
    "RINSE",
    "SCRUB",
    "WASH",
    "WIPE",
    "GRAB",
    "SWITCHOFF",
)
"""The actions that the reference lets subgoals name (``resources/vocabulary.json``, ``subgoal_actions``)."""

FORGOTTEN = "POUR"
"""The action that the goals of five tasks ask for although the reference's vocabulary lacks it."""


def signature(scene: Scene, protocol: Protocol) -> Signature:
    """The names that are allowed under a protocol; objects with their id (``soap.1002``) or by class."""
    return Signature(_predicates(), allowed_actions(protocol), _Names(scene))


class _Names:
    """The names and classes of a scene's objects."""

    __slots__ = ("_index", "_scene")

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._index = scene.index

    def __contains__(self, name: object) -> bool:
        return name in self._index or (isinstance(name, str) and self._scene.category(name) != 0)


def without_arguments(protocol: Protocol) -> frozenset[str]:
    """The actions that take no objects."""
    return frozenset(name for name, arity in allowed_actions(protocol).items() if arity == 0)


@cache
def _predicates() -> dict[str, int | None]:
    return {p.name: p.arity for p in VOCABULARY.predicates if p.visible}


@cache
def allowed_actions(protocol: Protocol) -> dict[str, int | None]:
    """The actions that subgoals may name, with their numbers of objects."""
    names = ACTIONS if protocol is Protocol.EAI_1_0_5 else (*ACTIONS, FORGOTTEN)
    return {o.name: o.arity for o in virtualhome.as_meant().operators if o.name in names}
