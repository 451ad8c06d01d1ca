"""The verdict on a scene graph, with the differences between the graph and the true scene."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from eai.abilities.verdict import ConfusionCounts, Verdict


@dataclass(frozen=True, slots=True)
class ScenePerceptionErrorCounts:
    """The differences between a scene graph and the true scene, by the paper's four kinds of error.

    The kinds are from the appendix on vision models. The described facts of a scene are those that a prompt
    states, without facts that follow from others. A true fact of the graph that is not described is no error.

    Attributes:
        facts: number of described facts.
        relations: number of described facts that relate two objects.
        perceived: number of facts in the scene graph.
        missing: number of described facts that the graph lacks, without misplaced facts.
        misplaced: number of described relations that the graph states with another second object (the paper's
            spatial hallucinations).
        unnecessary: number of other untrue facts in the graph about existing objects.
        invented: number of facts in the graph with an unknown name (object hallucinations).
        objects: number of objects that the graph should name.
        names: number of names in the graph.
        invented_names: number of names in the graph that the scene does not have.
        unseen: number of objects that the graph does not name.
        predicates: by predicate, the numbers of right, untrue and missing facts.
        ill_formed: number of entries of the answer that are not facts, such as unknown predicates or wrong
            numbers of objects.
        unreadable: whether the answer has no readable scene graph, so that nothing is perceived.
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
    predicates: Mapping[str, ConfusionCounts]
    ill_formed: int = 0
    unreadable: bool = False


_NOTHING_PERCEIVED = ScenePerceptionErrorCounts(0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, {})


@dataclass(frozen=True, slots=True)
class SceneGraphVerdict(Verdict):
    """The verdict on a scene graph: the objects and facts that a model lists for pictures of a scene.

    Attributes:
        success: whether the graph has every fact that a prompt would state, and no untrue fact.
        seen: counts of the differences between the graph and the true scene.
    """

    success: bool = False
    seen: ScenePerceptionErrorCounts = _NOTHING_PERCEIVED
