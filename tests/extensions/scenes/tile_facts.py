"""The facts that tiles show."""

from __future__ import annotations

import re

from eai.extensions.scenes.tiles import BOTH_WAYS, HANDS, NO_OBJECT, ONE_WAY
from eai.studies.perception.scene_graph import SceneGraphFact
from eai.studies.report.explorer import ObjectRectangle


def told_by(tile: ObjectRectangle, agent: str) -> set[SceneGraphFact]:
    """All that a tile says, and those in it."""
    said = {SceneGraphFact(mark, () if tile.name == NO_OBJECT else (tile.name,)) for mark in tile.marks}
    for line in tile.lines:
        if line.endswith(")"):
            predicate, *others = re.split(r"[(),]+ ?", line.removesuffix(")"))
            assert others[0] == tile.name
            said.add(SceneGraphFact(predicate, tuple(others)))
            continue
        predicate, arrow, *others = re.split(r"[ ,]+", line)
        for other in others:
            said.add(SceneGraphFact(predicate, (tile.name, other)))
            if arrow == BOTH_WAYS:
                said.add(SceneGraphFact(predicate, (other, tile.name)))
        assert arrow in (BOTH_WAYS, ONE_WAY)
    for relation, within in tile.zones.items():
        for inner in within:
            around = (tile.name, inner.name) if tile.name == agent else (inner.name, tile.name)
            about = (inner.name,) if tile.name == HANDS else around
            said |= {SceneGraphFact(relation, about), *told_by(inner, agent)}
    return said
