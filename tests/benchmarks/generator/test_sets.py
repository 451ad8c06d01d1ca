"""Sets of generated tasks: their manifest, proofs of a secret, and files of other sets of a world."""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict, replace
from itertools import islice
from pathlib import Path
from threading import Thread
from typing import Any

import pytest

from eai.base.errors import InputError
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.generator import sets
from eai.benchmarks.generator.sets import (
    MANIFEST,
    add_set_to_manifest,
    compute_set_statistics,
    estimate_number_of_distinct_tasks,
    find_other_task_sets_of_benchmark,
    find_reasons_to_doubt_published_set,
    make_manifest_entry,
    make_seeds,
    read_tasks_of_set,
)
from eai.benchmarks.generator.spec import (
    CANARY,
    GeneratedTask,
    PlanLengthTier,
    SeedRejectionReason,
    TaskSpecification,
)
from eai.tasks.source import Source
from eai.tasks.task import Task
from eai.tasks.task_files import write_task_file
from eai.tasks.task_lines import write_task_line
from eai.world.action import Action

SPEC = TaskSpecification("lamps", "0" * 64, PlanLengthTier.M)
SECRET = "tomatoes"  # noqa: S105


@pytest.fixture
def light(lamps: Benchmark) -> Task:
    return lamps.tasks(Source())["light"]


def of_steps(light: Task, *numbers: int) -> list[Task]:
    lamp = light.scene.index["lamp_1"]
    return [replace(light, script=(Action("GO", (lamp,)),) * number) for number in numbers]


@pytest.mark.parametrize(
    ("steps", "spread"),
    [
        ((), ()),
        ((0,), ()),
        ((4,), (4,)),
        ((4, 8), (4, 5, 6, 7, 8)),
        ((9, 1, 0, 5, 3, 7), (1, 3, 5, 7, 9)),
    ],
)
def test_the_shape_of_a_set_has_minimum_quartiles_and_maximum(
    light: Task, steps: tuple[int, ...], spread: tuple[int, ...]
) -> None:
    tasks = of_steps(light, *steps)
    shape = compute_set_statistics(tasks)
    assert shape["steps"] == list(spread)
    assert set(shape["goals"]) == ({1} if tasks else set())
    assert set(shape["objects"]) == ({5} if tasks else set())
    assert shape["forms"] == ({"ForAll": len(tasks)} if tasks else {})


def test_the_most_frequent_form_is_first(lamps: Benchmark) -> None:
    light, pack = lamps.tasks(Source()).values()
    assert compute_set_statistics([light, pack, pack])["forms"] == {"Atom": 2, "ForAll": 1}


def test_an_entry_allows_making_a_set_again_and_counts_rejections(light: Task) -> None:
    rejected = [SeedRejectionReason.COPY, SeedRejectionReason.TOO_LONG, SeedRejectionReason.COPY]
    made = [GeneratedTask(task, {}) for task in of_steps(light, 3, 4)]
    fingerprint_log = [("a", "a"), ("b", "b"), ("b", "b")]
    entry = make_manifest_entry(SPEC, 7, SECRET, b"content", made, rejected, fingerprint_log)
    spec = entry.pop("spec")
    assert json.loads(json.dumps(spec)) == json.loads(json.dumps(asdict(SPEC)))
    assert entry == {
        "spec_sha256": SPEC.sha256,
        "seed": 7,
        "secret_sha256": hashlib.sha256(SECRET.encode()).hexdigest(),
        "tasks": 2,
        "sha256": hashlib.sha256(b"content").hexdigest(),
        "rejected": {SeedRejectionReason.TOO_LONG.value: 1, SeedRejectionReason.COPY.value: 2},
        "estimated_tasks": 2,
        "shape": {
            "steps": [3, 3, 4, 4, 4],
            "goals": [1] * 5,
            "objects": [5] * 5,
            "forms": {"ForAll": 2},
        },
    }
    assert make_manifest_entry(SPEC, 7, None, b"", [], [])["secret_sha256"] is None


@pytest.mark.parametrize(
    ("fingerprint_log", "number"),
    [
        ("", None),
        ("abcd", None),  # no task came twice
        ("aabb", 2),  # each task came twice, so there are probably no more
        ("aab", 2),
        ("aabcde", 8),  # 5 tasks, 4 of them once and 1 twice: 5 + 4 * 3 / (2 * 2)
        ("aaabcde", 11),  # 5 + 4 * 3 / 2
    ],
)
def test_the_number_of_tasks_is_estimated_by_captures(fingerprint_log: str, number: int | None) -> None:
    assert estimate_number_of_distinct_tasks((letter, letter) for letter in fingerprint_log) == number


def write_set(folder: Path, lamps: Benchmark, seeds: list[str]) -> None:
    """Write a set made with the secret from these seeds; one seed in three was rejected."""
    light = lamps.tasks(Source())["light"]
    lines = [
        write_task_line(replace(light, id=f"t{n}"), "lamps:lamps", lamps.domain, {"seed": seed})
        for n, seed in enumerate(seeds)
    ]
    file = folder / "test.jsonl"
    write_task_file(file, lines)
    made, rejected = [GeneratedTask(light, {})] * len(seeds), [SeedRejectionReason.COPY] * 2
    entry = make_manifest_entry(SPEC, 3, SECRET, file.read_bytes(), made, rejected)
    add_set_to_manifest(folder, "test", entry, {})


def first_seeds(number: int) -> list[str]:
    return list(islice(make_seeds("test", 3, SECRET), number))


@pytest.mark.parametrize(
    ("chosen", "secret", "content", "found"),
    [
        ([0, 1, 3], SECRET, b"", []),
        ([0, 1, 4], SECRET, b"", []),  # five were tried
        ([0, 1, 5], SECRET, b"", ["1 of 3 tasks are of a seed that does not follow from the secret"]),
        ([0], SECRET, b"\n", ["the content of "]),
        ([0, 1], "potatoes", b"", ["the digest of the secret", "2 of 2 tasks are of a seed"]),
    ],
)
def test_false_claims_about_a_secret_are_reported(
    lamps: Benchmark, tmp_path: Path, chosen: list[int], secret: str, content: bytes, found: list[str]
) -> None:
    seeds = first_seeds(6)
    write_set(tmp_path, lamps, [seeds[number] for number in chosen])
    file = tmp_path / "test.jsonl"
    file.write_bytes(file.read_bytes().replace(b"Switch", b"Turn") if content else file.read_bytes())
    problems = list(find_reasons_to_doubt_published_set(tmp_path, "test", secret))
    assert len(problems) == len(found)
    assert all(problem.startswith(start) for problem, start in zip(problems, found, strict=True))


def test_without_a_secret_or_a_file_nothing_can_be_proved(lamps: Benchmark, tmp_path: Path) -> None:
    write_set(tmp_path, lamps, first_seeds(1))
    add_set_to_manifest(tmp_path, "open", make_manifest_entry(SPEC, 3, None, b"", [], []), {})
    for split in ("open", "train"):
        with pytest.raises(InputError, match="that was generated with --secret"):
            list(find_reasons_to_doubt_published_set(tmp_path, split, SECRET))
    (tmp_path / "test.jsonl").unlink()
    with pytest.raises(InputError, match=r"expected test\.jsonl or test\.jsonl\.gz"):
        list(find_reasons_to_doubt_published_set(tmp_path, "test", SECRET))


def test_a_manifest_keeps_other_sets_and_their_overlap(tmp_path: Path) -> None:
    one, two, three = ({"tasks": number, "same": 0} for number in (1, 2, 3))
    add_set_to_manifest(tmp_path, "train", {"tasks": 1}, {})
    add_set_to_manifest(tmp_path, "test", {"tasks": 2}, {("test", "train"): one})
    add_set_to_manifest(tmp_path, "other", {"tasks": 3}, {("other", "test"): two, ("test", "other"): three})

    def manifest() -> dict[str, Any]:
        return dict(json.loads((tmp_path / MANIFEST).read_text()))

    found = manifest()
    assert found["canary"] == CANARY
    assert found["sets"] == {"train": {"tasks": 1}, "test": {"tasks": 2}, "other": {"tasks": 3}}
    assert found["overlap"] == {
        "test": {"train": one, "other": three},
        "other": {"test": two},
    }
    add_set_to_manifest(tmp_path, "test", {"tasks": 4}, {("test", "train"): two})
    found = manifest()
    assert found["sets"]["test"] == {"tasks": 4}
    assert found["overlap"] == {"test": {"train": two}}


def test_sets_that_are_added_at_once_are_all_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    other = Thread(target=add_set_to_manifest, args=(tmp_path, "test", {"tasks": 2}, {}))
    write = sets.write_files_atomically

    def write_while_other_adds(contents: Any) -> None:
        monkeypatch.setattr(sets, "write_files_atomically", write)
        other.start()
        other.join(0.2)  # it waits for the lock
        write(contents)

    monkeypatch.setattr(sets, "write_files_atomically", write_while_other_adds)
    add_set_to_manifest(tmp_path, "train", {"tasks": 1}, {})
    other.join()
    assert json.loads((tmp_path / MANIFEST).read_text())["sets"] == {
        "train": {"tasks": 1},
        "test": {"tasks": 2},
    }


@pytest.mark.parametrize("content", ["[]", "{}", "nothing", '{"sets": 3}'])
def test_a_file_that_is_no_manifest_is_refused(tmp_path: Path, content: str) -> None:
    (tmp_path / MANIFEST).write_text(content)
    with pytest.raises(InputError, match="expected the manifest of generated tasks"):
        add_set_to_manifest(tmp_path, "test", {}, {})


def test_only_nonempty_sets_of_the_same_world_are_read(lamps: Benchmark, tmp_path: Path) -> None:
    light = lamps.tasks(Source())["light"]

    def write(name: str, base: str) -> None:
        write_task_file(tmp_path / name, [write_task_line(replace(light, id=name), base, lamps.domain)])

    for name in ("v1.train.jsonl", "v1.test.jsonl.gz", "mine.jsonl"):
        write(name, "lamps:lamps")
    write("theirs.jsonl", "virtualhome")
    (tmp_path / "empty.jsonl").touch()
    (tmp_path / "notes.txt").write_text("nothing")
    files = find_other_task_sets_of_benchmark(tmp_path, "lamps:lamps", excluded_file=tmp_path / "mine.jsonl")
    assert {
        name: [task.id for task in read_tasks_of_set(file, lamps.domain)] for name, file in files.items()
    } == {
        "v1.test": ["v1.test.jsonl.gz"],
        "v1.train": ["v1.train.jsonl"],
    }
    assert find_other_task_sets_of_benchmark(tmp_path / "none", "lamps:lamps", excluded_file=tmp_path) == {}
