from __future__ import annotations

import dataclasses
from collections.abc import Sequence

from eai.data.dataset import fetch
from eai.data.source import Pack
from eai.data.store import Store
from eai.households.packs import PROMPTS, RESOURCES, VIRTUALHOME, validate


def problems(store: Store, packs: Sequence[Pack], **counts: int) -> list[str]:
    return [f"{each.place}: {each.problem}" for each in validate(store, packs=packs, counts=counts)]


def test_a_fetched_store_is_valid(store: Store, packs: Sequence[Pack]) -> None:
    fetch(store, packs=packs)
    assert validate(store, packs=packs, counts={"tasks": 3, "goals": 5}) == ()


def test_a_wrong_count_is_found(store: Store, packs: Sequence[Pack]) -> None:
    fetch(store, packs=packs)
    assert problems(store, packs, tasks=342) == ["virtualhome: tasks: 3, expected 342"]


def test_an_absent_a_damaged_and_a_foreign_pack_are_found(store: Store, packs: Sequence[Pack]) -> None:
    fetch(store, packs=packs)
    store.path(VIRTUALHOME).unlink()
    content = bytearray(store.path(RESOURCES).read_bytes())
    place = content.index(b"vocabulary.json") + len("vocabulary.json")
    content[place] ^= 0xFF
    store.path(RESOURCES).write_bytes(content)
    pinned = packs[2].archives[0]
    foreign = dataclasses.replace(packs[2], archives=(dataclasses.replace(pinned, sha256="0" * 64),))
    found = validate(store, packs=[*packs[:2], foreign])
    assert [each.place for each in found] == [VIRTUALHOME, RESOURCES, PROMPTS]
    assert "no such data" in found[0].problem
    assert "vocabulary.json" in found[1].problem
    assert "other archives" in found[2].problem


def test_the_published_data_is_valid(data_store: Store) -> None:
    assert validate(data_store) == ()
