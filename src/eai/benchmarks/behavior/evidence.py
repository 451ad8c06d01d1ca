"""Facts about BEHAVIOR's scenes that no published file has: a table of this package, with reasons."""

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
"""A relation of two objects: the predicate and their names."""


@dataclass(frozen=True, slots=True)
class _Volumes:
    """Estimated volumes in cubic metres.

    Attributes:
        default: of an object of any other model.
        part: of a half, relative to the whole.
        of_model: by model category.
        of_object: by scene and name, before anything else.
    """

    default: float
    ratio_of_half: float
    by_model: Mapping[str, float]
    by_object: Mapping[tuple[str, str], float]

    def get_volume(self, scene: str, name: str, model: str) -> float:
        """The volume of an object."""
        return self.by_object.get((scene, name), self.by_model.get(model, self.default))


@dataclass(frozen=True, slots=True)
class UnpublishedFacts:
    """All facts that are in no published file.

    Attributes:
        initially_open: model categories whose objects are open at the start.
        standing: model categories whose objects stand on the floor of their room unless placed elsewhere.
        added: relations of a task that its problem file lacks.
        removed: of a task, predicate and source of relations that its problem file has wrongly.
        listed_relations_only: tasks whose published verdicts on subgoals come out with the
            relations of the problem file and no others.
        volumes: sizes.
        sha256: digest of the table, to be recorded with every result made from it.
    """

    initially_open: frozenset[str]
    standing: frozenset[str]
    added: Mapping[str, Sequence[GroundRelation]]
    removed: Mapping[str, Sequence[tuple[str, str]]]
    listed_relations_only: frozenset[str]
    volumes: _Volumes
    sha256: str


@cache
def load_evidence() -> UnpublishedFacts:
    """The table of this package."""
    content = resources.files("eai.benchmarks.behavior").joinpath(_FILE).read_bytes()
    table = parse_toml(content.decode())
    added, removed, volume = table["added_relations"], table["removed_relations"], table["volume"]
    of_object = {(entry["scene"], entry["object"]): entry["volume"] for entry in volume["of_object"]}
    return UnpublishedFacts(
        initially_open=frozenset(table["initially_open"]["categories"]),
        standing=frozenset(table["stands_on_floor"]["categories"]),
        added=group_pairs((entry["task"], tuple(entry["fact"])) for entry in added),
        removed=group_pairs((entry["task"], (entry["predicate"], entry["object"])) for entry in removed),
        listed_relations_only=frozenset(table["listed_relations_only"]["tasks"]),
        volumes=_Volumes(volume["default"], volume["part"], volume["of_category"], of_object),
        sha256=hashlib.sha256(content).hexdigest(),
    )
