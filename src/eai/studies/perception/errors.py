"""How wrong a scene graph is: its differences from the scene, by the paper's four kinds of error."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable

from eai.abilities.record import Perceived
from eai.abilities.task import Task
from eai.abilities.verdict import Confusion
from eai.studies.perception.description import SceneWords
from eai.studies.perception.scene_graph import NamedFact, ReadGraph


def perception_errors(task: Task, words: SceneWords, read: ReadGraph) -> Perceived:
    """What a scene graph has and lacks of a task's scene.

    A lost relation is misplaced, not missing, where the graph has the same predicate of the same object and
    another one, which does not hold: each such fact accounts for one lost relation.
    """
    graph, described = read.graph, words.describe(task)
    seen, wrong = set(graph.facts), _wrong(task, words, read)
    lost = [fact for fact in described.facts if fact not in seen]
    index = {name: place for place, name in enumerate(words.names(task))}
    strange = [fact for fact in wrong if not index.keys() >= {*fact.arguments}]
    told = Counter(_place(fact) for fact in wrong if fact not in strange and len(fact.arguments) == 2)
    gone = Counter(_place(fact) for fact in lost if len(fact.arguments) == 2)
    misplaced = (told & gone).total()
    objects = {name for name in described.objects if index[name] != task.scene.agent}
    return Perceived(
        facts=len(described.facts),
        relations=sum(len(fact.arguments) == 2 for fact in described.facts),
        perceived=len(graph.facts),
        missing=len(lost) - misplaced,
        misplaced=misplaced,
        unnecessary=len(wrong) - len(strange) - misplaced,
        invented=len(strange),
        objects=len(objects),
        names=len(graph.names),
        invented_names=len([name for name in graph.names if name not in index]),
        unseen=len(objects.difference(graph.names)),
        predicates=_confusions([fact for fact in described.facts if fact in seen], wrong, lost),
        ill_formed=len(read.ill_formed),
        unreadable=read.unreadable is not None,
    )


def _wrong(task: Task, words: SceneWords, read: ReadGraph) -> list[NamedFact]:
    """The facts of a scene graph that do not hold, in order."""
    names, mentioned = words.names(task), set(read.graph.names)
    about = [index for index, name in enumerate(names) if name in mentioned]
    holding = {words.named(fact, names) for fact in words.holding(task.initial, about)}
    return [fact for fact in read.graph.facts if fact not in holding]


def _place(fact: NamedFact) -> tuple[str, str]:
    """What a relation is said of."""
    return fact.predicate, fact.arguments[0]


def _confusions(
    right: Iterable[NamedFact], wrong: Iterable[NamedFact], lost: Iterable[NamedFact]
) -> dict[str, Confusion]:
    """By predicate, how many facts are right, do not hold, and are lacking."""
    counts = [Counter(fact.predicate for fact in facts) for facts in (right, wrong, lost)]
    names = dict.fromkeys(name for count in counts for name in count)
    return {name: Confusion(*(count[name] for count in counts)) for name in sorted(names)}
