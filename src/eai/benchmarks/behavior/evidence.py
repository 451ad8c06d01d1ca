"""Load facts about BEHAVIOR's scenes that no published file states.

The table ``evidence.toml`` of this package lists the facts, with the reasons to believe them.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import TypeAlias

from eai.base.files import parse_toml
from eai.base.grouping import group_pairs

_FILE = "evidence.toml"


GroundRelation: TypeAlias = tuple[str, str, str]
"""A relation of two objects: the predicate and the names of the two objects."""


@dataclass(frozen=True, slots=True)
class _EstimatedObjectVolumes:
    """Estimated volumes in cubic metres.

    Attributes:
        default: volume of objects that the other attributes do not list.
        ratio_of_half: volume of half an object, as a share of the whole object's volume.
        by_model: volume by model category.
        by_object: volume by scene and object name. It takes precedence over the volumes in the other
            attributes.
    """

    default: float
    ratio_of_half: float
    by_model: Mapping[str, float]
    by_object: Mapping[tuple[str, str], float]

    def get_volume(self, scene: str, name: str, model: str) -> float:
        """Return the estimated volume of an object in cubic metres."""
        return self.by_object.get((scene, name), self.by_model.get(model, self.default))


@dataclass(frozen=True, slots=True)
class UnpublishedSceneFacts:
    """All facts about BEHAVIOR's scenes that no published file states.

    Attributes:
        initially_open: model categories whose objects are open at the start.
        standing: model categories whose objects stand on the floor of their room, unless a file places them
            elsewhere.
        added: relations that a problem file lacks, by task.
        removed: wrong relations of a problem file by task. Each is a pair: the predicate and the first
            object.
        listed_relations_only: tasks whose published verdicts on subgoals were made with exactly the relations
            of the problem file, without `added` and `removed`.
        volumes: estimated volumes of objects.
        sha256: digest of the table, recorded with every result made from it.
    """

    initially_open: frozenset[str]
    standing: frozenset[str]
    added: Mapping[str, Sequence[GroundRelation]]
    removed: Mapping[str, Sequence[tuple[str, str]]]
    listed_relations_only: frozenset[str]
    volumes: _EstimatedObjectVolumes
    sha256: str


@cache
def load_unpublished_facts() -> UnpublishedSceneFacts:
    """Return the facts about BEHAVIOR's scenes that no published file states, from the packaged table."""
    content = resources.files("eai.benchmarks.behavior").joinpath(_FILE).read_bytes()
    table = parse_toml(content.decode())
    added, removed, volume = table["added_relations"], table["removed_relations"], table["volume"]
    of_object = {(entry["scene"], entry["object"]): entry["volume"] for entry in volume["of_object"]}
    return UnpublishedSceneFacts(
        initially_open=frozenset(table["initially_open"]["categories"]),
        standing=frozenset(table["stands_on_floor"]["categories"]),
        added=group_pairs((entry["task"], tuple(entry["fact"])) for entry in added),
        removed=group_pairs((entry["task"], (entry["predicate"], entry["object"])) for entry in removed),
        listed_relations_only=frozenset(table["listed_relations_only"]["tasks"]),
        volumes=_EstimatedObjectVolumes(volume["default"], volume["part"], volume["of_category"], of_object),
        sha256=hashlib.sha256(content).hexdigest(),
    )
