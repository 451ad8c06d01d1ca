from __future__ import annotations

import dataclasses
import json
from collections.abc import Callable, Sequence
from typing import Any

import pytest

from eai.data.dataset import fetch
from eai.data.source import Pack
from eai.data.store import Store
from eai.households.packs import PROMPTS, RESOURCES, VIRTUALHOME, validate
from eai.households.virtualhome.records import TASKS_MEMBER

Change = Callable[[dict[str, Any]], None]


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


def rewritten(store: Store, packs: Sequence[Pack], change: Change) -> None:
    """Change the last task's line, with matching digests: what a faulty converter would write."""
    fetch(store, packs=packs)
    lines = store.open(VIRTUALHOME).read(TASKS_MEMBER).splitlines()
    values = json.loads(lines[-1])
    change(values)
    content = b"\n".join([*lines[:-1], json.dumps(values).encode()])
    store.write(VIRTUALHOME, packs[0].pins, {TASKS_MEMBER: content})


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda task: task["node_goals"].append([44, "x", "ON"]), "no object 44 in its graph"),
        (lambda task: task["edge_goals"].append([65, "ON", 44]), "no object 44 in its graph"),
        (lambda task: task["script"].append(["GRAB", [["x", 44]]]), "no object 44 in its graph"),
        (lambda task: task["relevant_from_edges"].append(44), "no object 44 in its graph"),
        (lambda task: task["initial"]["removed_ids"].append(44), "removes the unknown object 44"),
        (lambda task: task["initial"]["removed_ids"].append(65), "no object 65 in its graph"),
        (lambda task: task["initial"].update(added_objects=[0]), "is there already"),
        (lambda task: task["final"].update(changed_objects=[99]), "is unknown"),
        (lambda task: task["final"]["added_edges"].extend([65, 0, 44]), "between unknown objects"),
        (
            lambda task: task["final"]["removed_edges"].extend([65, 0, 44]),
            "removes an edge that is not there",
        ),
    ],
)
def test_a_reference_to_nothing_is_found(
    store: Store, packs: Sequence[Pack], change: Change, told: str
) -> None:
    def with_known_object(task: dict[str, Any]) -> None:
        change(task)
        header = json.loads(store.open(VIRTUALHOME).read(TASKS_MEMBER).splitlines()[0])
        absent = [
            n for n, row in enumerate(header["objects"]) if n not in header["base_objects"] and row[0] == 1000
        ]
        if task["final"]["changed_objects"] == [99]:
            task["initial"]["added_objects"] = []
            task["final"]["changed_objects"] = absent

    rewritten(store, packs, with_known_object)
    assert any(told in problem for problem in problems(store, packs))


def test_prompts_of_unknown_tasks_are_found(store: Store, packs: Sequence[Pack]) -> None:
    fetch(store, packs=packs)
    opened = store.open(PROMPTS)
    members = {name: opened.read(name) for name in opened.manifest.members}
    members["virtualhome/action_sequencing.json"] = b'[{"identifier": "9_9"}]'
    store.write(PROMPTS, packs[2].pins, members)
    assert problems(store, packs) == [
        "prompts/virtualhome/action_sequencing.json: names 1 unknown tasks, the first 9_9"
    ]


def test_the_published_data_is_valid(data_store: Store) -> None:
    assert validate(data_store) == ()
