"""What the VirtualHome data set says, as plain records: no world state, no check, no interpretation.

A scene is stored once; a task says how its own initial graph differs from it, and how its final graph
differs from the initial one.

Order: objects come by ascending id, which is their order in every initial graph of the data set. The
targets of one source under `ON` or `INSIDE` keep the order of the data set's file, because the reference
asks for the first of them; edges of other relations come by ascending ids.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

CHARACTER_ID = 65
"""Id of the acting character in every VirtualHome graph of the data set."""


class Edge(NamedTuple):
    """`source` stands in `relation` to `target`, both object ids. A named tuple since a scene has 5,700."""

    source: int
    relation: str
    target: int


@dataclass(frozen=True, slots=True)
class ObjectRecord:
    """One object of a graph; `properties` and `states` are sorted and without duplicates."""

    id: int
    class_name: str
    category: str
    properties: tuple[str, ...]
    states: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class BaseScene:
    """What all initial graphs share: every id that occurs in all of them, every edge that does.

    An object's record is its most frequent one; a task whose object differs lists it as changed.
    """

    objects: tuple[ObjectRecord, ...]
    edges: tuple[Edge, ...]


@dataclass(frozen=True, slots=True)
class GraphDelta:
    """How one graph comes from another: take away, then replace, then append, each in order.

    An edge may be in both `removed_edges` and `added_edges`: it then moves to the end of its source's
    `ON` or `INSIDE` targets.
    """

    removed_ids: tuple[int, ...]
    changed_objects: tuple[ObjectRecord, ...]
    added_objects: tuple[ObjectRecord, ...]
    removed_edges: tuple[Edge, ...]
    added_edges: tuple[Edge, ...]


@dataclass(frozen=True, slots=True)
class ScriptObject:
    """An object that a script names: the class name as written, and the graph's id."""

    class_name: str
    id: int


@dataclass(frozen=True, slots=True)
class ScriptStep:
    """One step of the annotated (gold) script, such as `GRAB` with one object."""

    action: str
    objects: tuple[ScriptObject, ...]


@dataclass(frozen=True, slots=True)
class NodeGoal:
    """An object shall be in a state."""

    id: int
    class_name: str
    state: str


@dataclass(frozen=True, slots=True)
class EdgeGoal:
    """Two objects shall stand in a relation."""

    from_id: int
    relation: str
    to_id: int


@dataclass(frozen=True, slots=True)
class ActionGoal:
    """One of the alternatives shall have been done, such as `LOOKAT` or `WATCH`."""

    alternatives: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class TaskRecord:
    """One task as the data set annotates it. Goals keep its order and its duplicates.

    Attributes:
        id: the data set's id, such as `27_2`, without the subgoal files' `scene_1_` prefix.
        title: the name that tasks of a kind share, such as `Wash clothes`.
        description: the natural-language instruction.
        script: the annotated steps.
        tl_goal: the goal as a temporal-logic text; None for the four tasks without goals.
        initial: how the initial graph differs from the base scene.
        final: how the final graph differs from the initial one.
        relevant_from_nodes: ids of objects that differ between the two graphs, without duplicates, in the
            order of the initial graph. The reference calls these, and the next, the relevant objects.
        relevant_from_edges: ends of the edges that differ, without duplicates, in the order met: source
            before target, the initial graph's edges before the final graph's, each in file order.
    """

    id: str
    title: str
    description: str
    script: tuple[ScriptStep, ...]
    node_goals: tuple[NodeGoal, ...]
    edge_goals: tuple[EdgeGoal, ...]
    action_goals: tuple[ActionGoal, ...]
    tl_goal: str | None
    initial: GraphDelta
    final: GraphDelta
    relevant_from_nodes: tuple[int, ...]
    relevant_from_edges: tuple[int, ...]
