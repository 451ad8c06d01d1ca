"""Find the differences between a scene graph and the true scene, by the paper's four kinds of error."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from functools import partial

from eai.abilities.explanation import VerdictExplanation, write_repair_notes
from eai.abilities.scorer import Assessment, Scorer
from eai.abilities.verdict import ConfusionCounts, ErrorReport
from eai.studies.perception.scene_graph import (
    SceneGraph,
    SceneGraphFact,
    SceneGraphVocabulary,
    read_scene_graph,
)
from eai.studies.perception.verdict import SceneGraphVerdict, ScenePerceptionErrorCounts
from eai.tasks.task import Task
from eai.world.fault import FaultKind


def make_scorer_factory(words: SceneGraphVocabulary) -> Callable[[Task], Scorer]:
    """Return a function that makes the scorer of a task's scene graphs, which use the names in ``words``."""
    return partial(_SceneGraphAnswerScorer, words)


class _SceneGraphAnswerScorer(Scorer):
    def __init__(self, words: SceneGraphVocabulary, task: Task) -> None:
        self._words, self._task = words, task

    def assess(self, text: str) -> Assessment:
        """Return the verdict on an answer with its explanation.

        An unreadable answer counts as an empty scene graph.
        """
        graph = read_scene_graph(text, self._words.arity_by_predicate_name_in_graphs)
        seen = find_perception_errors(self._task, self._words, graph)
        verdict = SceneGraphVerdict(
            error=None
            if graph.unreadable is None
            else ErrorReport(FaultKind.PARSING, None, graph.unreadable),
            repairs=graph.repairs,
            success=not any((seen.missing, seen.misplaced, seen.unnecessary, seen.invented, seen.unreadable)),
            seen=seen,
        )
        return Assessment(verdict, partial(_explain_scene_graph_errors, self._task, self._words, graph))


def _explain_scene_graph_errors(
    task: Task, words: SceneGraphVocabulary, graph: SceneGraph
) -> VerdictExplanation:
    lost, wrong = _find_missing_and_untrue_facts(task, words, graph)
    notes = [
        *(f"not listed: {fact}" for fact in lost),
        *(f"does not hold: {fact}" for fact in wrong),
        *(f"no fact: {entry}" for entry in graph.ill_formed),
    ]
    return VerdictExplanation(notes=(*notes, *write_repair_notes(graph.repairs)))


def find_perception_errors(
    task: Task, words: SceneGraphVocabulary, graph: SceneGraph
) -> ScenePerceptionErrorCounts:
    """Return the differences between a scene graph and a task's scene.

    A relation that the graph lacks counts as misplaced if the graph has an untrue fact with the same
    predicate, the same first object and another second object. Otherwise, the relation counts as missing.
    Each untrue fact makes at most one relation count as misplaced.
    """
    described = words.make_true_graph(task)
    lost, wrong = _find_missing_and_untrue_facts(task, words, graph)
    index = {name: number for number, name in enumerate(words.list_object_names(task))}
    strange = [fact for fact in wrong if not index.keys() >= {*fact.arguments}]
    moved = Counter(
        _get_predicate_and_subject(fact) for fact in wrong if fact not in strange and len(fact.arguments) == 2
    )
    gone = Counter(_get_predicate_and_subject(fact) for fact in lost if len(fact.arguments) == 2)
    misplaced = (moved & gone).total()
    objects = {name for name in described.objects if index[name] != task.scene.agent}
    right = set(described.facts).intersection(graph.facts)
    return ScenePerceptionErrorCounts(
        facts=len(described.facts),
        relations=sum(len(fact.arguments) == 2 for fact in described.facts),
        perceived=len(graph.facts),
        missing=len(lost) - misplaced,
        misplaced=misplaced,
        unnecessary=len(wrong) - len(strange) - misplaced,
        invented=len(strange),
        objects=len(objects),
        names=len(graph.mentioned_objects),
        invented_names=len([name for name in graph.mentioned_objects if name not in index]),
        unseen=len(objects.difference(graph.mentioned_objects)),
        predicates=_count_confusions(right, wrong, lost),
        ill_formed=len(graph.ill_formed),
        unreadable=graph.unreadable is not None,
    )


def _find_missing_and_untrue_facts(
    task: Task, words: SceneGraphVocabulary, graph: SceneGraph
) -> tuple[Sequence[SceneGraphFact], Sequence[SceneGraphFact]]:
    """Return two lists: facts of the true scene graph that the graph lacks, and untrue facts of the graph."""
    names, seen, mentioned = words.list_object_names(task), set(graph.facts), set(graph.mentioned_objects)
    about = [index for index, name in enumerate(names) if name in mentioned]
    holding = {words.to_named_fact(fact, names) for fact in words.list_facts(task.initial, about)}
    lost = [fact for fact in words.make_true_graph(task).facts if fact not in seen]
    return lost, [fact for fact in graph.facts if fact not in holding]


def _get_predicate_and_subject(fact: SceneGraphFact) -> tuple[str, str]:
    return fact.predicate, fact.arguments[0]


def _count_confusions(
    right_facts: Iterable[SceneGraphFact],
    untrue_facts: Iterable[SceneGraphFact],
    missing_facts: Iterable[SceneGraphFact],
) -> dict[str, ConfusionCounts]:
    """Return three counts for each predicate: right facts, untrue facts and missing facts."""
    counts = [
        Counter(fact.predicate for fact in facts) for facts in (right_facts, untrue_facts, missing_facts)
    ]
    names = dict.fromkeys(name for count in counts for name in count)
    return {name: ConfusionCounts(*(count[name] for count in counts)) for name in sorted(names)}
