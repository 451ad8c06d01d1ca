"""Lay out the objects of a scene graph as nested rectangles, for diagrams.

The rectangle of a cup in a box lies in the frame ``inside`` of the rectangle of the box. All other facts
about the cup are written in its own rectangle. A diagram therefore shows each perceptible fact exactly once.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from eai.base.grouping import group_pairs
from eai.studies.perception.scene_graph import (
    SceneGraph,
    SceneGraphFact,
    SceneGraphVocabulary,
    SupportRelation,
)
from eai.studies.report.explorer import ObjectRectangle

BOTH_WAYS, ONE_WAY = "\N{LEFT RIGHT ARROW}", "\N{RIGHTWARDS ARROW}"
"""Arrows in texts of relations: for a relation that holds in both directions, and for one direction only."""

NO_OBJECT = "(no object)"
"""Name of the drawn rectangle with the facts that name no object."""

HANDS = "(hands)"
"""Name of the drawn rectangle around the objects in the hands, for scenes in which no object is the agent."""


def make_object_rectangles(
    graph: SceneGraph, words: SceneGraphVocabulary, agent: str | None, others: Sequence[str] = ()
) -> list[ObjectRectangle]:
    """Return the outermost rectangles of a scene graph. The rectangle of the agent comes first.

    Each rectangle contains the rectangles of the objects that are in, on or held by its object.

    Args:
        graph: the scene graph.
        words: the words for objects and relations in scene graphs.
        agent: the name of the acting object, or None if no object acts.
        others: the names of objects that do not occur in the task.
    """
    hands = [words.find_predicate_name_in_graphs(name) for name in words.holding_predicate_names]
    doer = agent or HANDS
    tiles: dict[str, ObjectRectangle] = {}
    if hands or doer in graph.mentioned_objects:
        tiles[doer] = ObjectRectangle(doer, "agent", zones={hand: [] for hand in hands})
    for name in graph.mentioned_objects:
        tiles.setdefault(name, ObjectRectangle(name, "other" if name in others else "object"))
    placed = _map_objects_to_location_facts(graph, words, agent, hands)
    for name, fact in placed.items():
        holder = doer if fact.predicate in hands else fact.arguments[1]
        tiles[holder].zones.setdefault(fact.predicate, []).append(tiles[name])
    shown = set(placed.values())
    for fact in graph.facts:
        if fact not in shown and len(fact.arguments) < 2:
            name = fact.arguments[0] if fact.arguments else NO_OBJECT
            tiles.setdefault(name, ObjectRectangle(name, "object")).marks.append(fact.predicate)
    for name, line in _pair_object_names_with_relation_lines(
        [fact for fact in graph.facts if fact not in shown]
    ):
        tiles[name].lines.append(line)
    return [tile for name, tile in tiles.items() if name not in placed]


def _map_objects_to_location_facts(
    graph: SceneGraph, words: SceneGraphVocabulary, agent: str | None, hands: Sequence[str]
) -> dict[str, SceneGraphFact]:
    """Return a mapping from each object to the fact that places it in another object or in a hand.

    If several facts place an object, the mapping has the fact with the innermost place.
    """
    names = {words.find_predicate_name_in_graphs(name) for name in words.placement_predicate_names}
    support_facts = group_pairs((fact.arguments[0], fact) for fact in graph.facts if fact.predicate in names)
    depths = {
        name: _compute_nesting_depth(name, support_facts, frozenset()) for name in graph.mentioned_objects
    }
    circles = SupportRelation(frozenset([*names, *hands]))
    placed: dict[str, SceneGraphFact] = {}
    for fact in graph.facts:
        if fact.predicate in hands and (len(fact.arguments) == 1 or fact.arguments[0] == agent):
            carried = fact._replace(arguments=(fact.arguments[-1], agent or HANDS))
            if not circles.would_close_cycle(carried):
                placed.setdefault(fact.arguments[-1], fact)
                circles.add_fact(carried)
    for name, facts in support_facts.items():
        for fact in sorted(facts, key=lambda each: -depths[each.arguments[1]]):
            if name not in placed and not circles.would_close_cycle(fact):
                placed[name] = fact
                circles.add_fact(fact)
    return placed


def _compute_nesting_depth(
    object_name: str, support_facts: dict[str, list[SceneGraphFact]], visited_names: frozenset[str]
) -> int:
    """Return the number of objects that carry an object, from its support down to the floor."""
    if object_name in visited_names:
        return 0
    visited_names |= {object_name}
    return max(
        [
            1 + _compute_nesting_depth(fact.arguments[1], support_facts, visited_names)
            for fact in support_facts.get(object_name, ())
        ],
        default=0,
    )


def _pair_object_names_with_relation_lines(facts: Sequence[SceneGraphFact]) -> Iterator[tuple[str, str]]:
    """Yield pairs of an object's name and a text line for the object's rectangle in a diagram.

    A line has a predicate, an arrow and all objects to which the object has this relation. A mutual relation
    is in the rectangle of only one of its objects. A fact about three or more objects has its own line.
    """
    known = set(facts)
    seconds_of: dict[tuple[str, str, str], list[str]] = {}
    for fact in facts:
        if len(fact.arguments) > 2:
            yield fact.arguments[0], f"{fact.predicate}({', '.join(fact.arguments)})"
        if len(fact.arguments) != 2:
            continue
        first, second = fact.arguments
        back = fact._replace(arguments=(second, first))
        is_mutual = back in known
        if is_mutual and first in seconds_of.get((second, fact.predicate, BOTH_WAYS), ()):
            continue
        seconds_of.setdefault((first, fact.predicate, BOTH_WAYS if is_mutual else ONE_WAY), []).append(second)
    for (name, predicate, arrow), seconds in seconds_of.items():
        yield name, f"{predicate} {arrow} {', '.join(seconds)}"
