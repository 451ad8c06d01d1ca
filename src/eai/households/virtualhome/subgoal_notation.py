"""How VirtualHome subgoals are read and written: by the prompts' words, objects with their ids."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence

from eai.abilities.answer_schema import Schema, closed, listed, text
from eai.abilities.subgoal_decomposition.notation import (
    SubgoalLexicon,
    SubgoalNotation,
    WrittenSubgoals,
    objects_and_classes,
    read_output,
)
from eai.abilities.verdict import Unreadable
from eai.households.virtualhome import domain as virtualhome
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


class VirtualHomeSubgoals(SubgoalNotation):
    """The words of VirtualHome's prompts; objects with their id (``soap.1002``) or by class.

    Args:
        actions: the actions that subgoals may name.
    """

    def __init__(self, actions: Sequence[str] = (*ACTIONS, FORGOTTEN)) -> None:
        super().__init__(virtualhome.as_meant())
        self._actions: dict[str, int | None] = {
            operator.name: operator.arity for operator in self.domain.operators if operator.name in actions
        }
        self._predicates: dict[str, int | None] = {
            p.name: p.arity for p in self.domain.vocabulary.predicates if p.visible
        }
        self._alone = frozenset(name for name, arity in self._actions.items() if arity == 0)

    def lexicon(self, scene: Scene) -> SubgoalLexicon:
        """The names of the data set, which are those of the scene."""
        names = objects_and_classes(scene.index, scene)
        return SubgoalLexicon(scene, Signature(self._predicates, self._actions, names), scene.index)

    def read(self, text: str) -> WrittenSubgoals | Unreadable:
        """The subgoals in an answer; actions without objects need no brackets."""
        return read_output(text, self._alone)

    def join(self, parts: Iterable[str]) -> str:
        """The subgoals as one answer."""
        answer = {"necessity_to_use_action": "no", "actions_to_include": [], "output": list(parts)}
        return json.dumps(answer, indent=1)

    def schema(self) -> Schema:
        """The members that the published prompts ask for."""
        return closed(
            {
                "necessity_to_use_action": text(("yes", "no")),
                "actions_to_include": listed(text(self._actions)),
                "output": listed(text()),
            }
        )
