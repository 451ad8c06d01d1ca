"""Maximum matching in bipartite graphs: what decides quantified goals without listing their options."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence


def maximum_matching(adjacency: Sequence[Sequence[int]]) -> list[int | None]:
    """Match as many left vertices as possible, each with a right vertex of its own (Hopcroft and Karp 1973).

    Args:
        adjacency: for each left vertex ``0 .. len(adjacency) - 1`` the numbers of its right neighbours.

    Returns:
        For each left vertex the right vertex it is matched with, or None. The size of the matching is the
        number of entries that are not None. Earlier neighbours are preferred; equal input gives equal output.

    Takes O(E sqrt(V)) time and does not recurse.
    """
    partner: list[int | None] = [None] * len(adjacency)
    owner: dict[int, int] = {}
    while layers := _layers(adjacency, partner, owner):
        unexplored = [iter(neighbours) for neighbours in adjacency]
        for left, matched in enumerate(partner):
            if matched is None:
                _augment(left, unexplored, layers, partner, owner)
    return partner


def _layers(
    adjacency: Sequence[Sequence[int]], partner: Sequence[int | None], owner: dict[int, int]
) -> dict[int, int]:
    """Distance of left vertices from the free ones on alternating paths; empty if none can be augmented."""
    layers = {left: 0 for left, matched in enumerate(partner) if matched is None}
    queue = deque(layers)
    augmentable = False
    while queue:
        left = queue.popleft()
        for right in adjacency[left]:
            holder = owner.get(right)
            if holder is None:
                augmentable = True
            elif holder not in layers:
                layers[holder] = layers[left] + 1
                queue.append(holder)
    return layers if augmentable else {}


def _augment(
    start: int,
    unexplored: Sequence[Iterator[int]],
    layers: dict[int, int],
    partner: list[int | None],
    owner: dict[int, int],
) -> None:
    """Flip one alternating path from a free left vertex along the layers to a free right one, if any.

    ``unexplored`` is shared by all searches of a phase: an edge that led nowhere is not tried again.
    """
    path = [start]
    edges: list[int] = []
    while path:
        left = path[-1]
        right = next(unexplored[left], None)
        if right is None:
            path.pop()
            if edges:
                edges.pop()
            continue
        holder = owner.get(right)
        if holder is None:
            for vertex, matched in zip(path, (*edges, right), strict=True):
                partner[vertex] = matched
                owner[matched] = vertex
            return
        if layers.get(holder) == layers[left] + 1:
            path.append(holder)
            edges.append(right)
