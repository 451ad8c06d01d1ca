"""The verdict on a scene graph, and how the graph differs from the scene."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from eai.abilities.verdict import Confusion, Verdict


@dataclass(frozen=True, slots=True)
class Perceived:
    """How a scene graph differs from the scene (paper, appendix on vision models, which names four errors).

    What is described of a scene are the facts that a prompt states, without those that follow from others. A
    fact that holds without being described is no error.

    Attributes:
        facts: how many facts are described.
        relations: how many of them relate two objects.
        perceived: how many facts the scene graph has.
        missing: described facts that it lacks, other than the misplaced ones.
        misplaced: described relations for which it has the same of the same object and another one: spatial
            hallucinations.
        unnecessary: further facts of it that do not hold, of objects that exist.
        invented: facts of it with a name that the scene has not: object hallucinations.
        objects: how many objects there are to name.
        names: how many names the scene graph has.
        invented_names: how many of them the scene has not.
        unseen: how many of the objects it does not name.
        predicates: by predicate, facts that are right, that do not hold, and that it lacks.
        ill_formed: entries of the answer that are no facts: unknown predicates, wrong numbers of objects.
        unreadable: whether there is no scene graph in the answer, so that nothing is perceived.
    """

    facts: int
    relations: int
    perceived: int
    missing: int
    misplaced: int
    unnecessary: int
    invented: int
    objects: int
    names: int
    invented_names: int
    unseen: int
    predicates: Mapping[str, Confusion]
    ill_formed: int = 0
    unreadable: bool = False


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
