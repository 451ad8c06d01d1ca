from __future__ import annotations

import hashlib
import json
from collections.abc import Collection, Sequence
from pathlib import Path

import pytest

from by_path import ROOT
from command_line import Command
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.generator.census import learn_usual_goals_from_tasks
from eai.benchmarks.generator.generator import TaskGenerator
from eai.benchmarks.generator.seeds import TaskSeedOutcome
from eai.benchmarks.generator.spec import SeedRejectionReason
from eai.benchmarks.generator.usual_goals import UsualGoalsOfDataSet
from eai.pddl.val import NOT_VALID, VALID
from eai.tasks.task import Task

pytestmark = pytest.mark.usefixtures("data_store")
FEW = 50
"""After how many seeds in a row that give none no more are tried here."""


@pytest.fixture(scope="module")
def priors() -> dict[str, UsualGoalsOfDataSet]:
    """Return a cache of the usual goals by name of the benchmark."""
    return {}


@pytest.fixture(autouse=True)
def counted_once(priors: dict[str, UsualGoalsOfDataSet], monkeypatch: pytest.MonkeyPatch) -> None:
    """Learn the usual goals of each benchmark only once for all commands."""

    def prior(benchmark: Benchmark, tasks: Sequence[Task]) -> UsualGoalsOfDataSet:
        if benchmark.name not in priors:
            priors[benchmark.name] = learn_usual_goals_from_tasks(benchmark, tasks)
        return priors[benchmark.name]

    monkeypatch.setattr("eai.benchmarks.generator.generator.learn_usual_goals_from_tasks", prior)


def made(eai: Command, out: Path, *options: object, n: int = 3) -> list[dict[str, object]]:
    outcome = eai("generate", "--like", "behavior", "--n", n, "--out", out, *options)
    assert outcome.status == 0, outcome.err
    split = options[options.index("--split") + 1] if "--split" in options else "tasks"
    return [json.loads(line) for line in (out / f"{split}.jsonl").read_text().splitlines()]


def test_equal_arguments_give_equal_bytes(eai: Command, tmp_path: Path) -> None:
    first = made(eai, tmp_path / "a", "--seed", 7)
    assert first == made(eai, tmp_path / "b", "--seed", 7) != made(eai, tmp_path / "c", "--seed", 8)
    assert [task["id"] for task in first] == [task["id"] for task in made(eai, tmp_path / "a", "--seed", 7)]
    assert eai("check", tmp_path / "a").status == 0
    assert all("canary" in str(task["about"]) for task in first)


def test_a_folder_says_how_it_was_made(eai: Command, tmp_path: Path) -> None:
    made(eai, tmp_path, "--split", "train", "--tier", "S")
    hidden = made(eai, tmp_path, "--split", "test", "--secret", "only we know", "--tier", "S")
    sets = json.loads((tmp_path / "generated.json").read_text())["sets"]
    assert list(sets) == ["train", "test"]
    assert sets["train"]["secret_sha256"] is None
    assert sets["test"]["secret_sha256"] == hashlib.sha256(b"only we know").hexdigest()
    assert "only we know" not in (tmp_path / "test.jsonl").read_text()
    for split in sets:
        assert sets[split]["sha256"] == hashlib.sha256((tmp_path / f"{split}.jsonl").read_bytes()).hexdigest()
        assert (sets[split]["tasks"], sets[split]["spec"]["tier"]) == (3, "S")
    other = made(eai, tmp_path / "other", "--split", "test", "--secret", "another", "--tier", "S")
    assert {task["id"] for task in other}.isdisjoint(task["id"] for task in hidden)


def test_splits_have_nothing_in_common_in_whatever_order_they_are_made(eai: Command, tmp_path: Path) -> None:
    for split in ("test", "train"):
        made(eai, tmp_path, "--split", split, "--tier", "S", "--seed", 3)
    overlap = json.loads((tmp_path / "generated.json").read_text())["overlap"]
    nothing = {"tasks": 3, "same": 0, "same_goals": 0, "solved_by_lookup": 0}
    assert overlap == {"test": {"train": nothing}}
    files = [str(tmp_path / f"{split}.jsonl") for split in ("train", "test")]
    told = eai("check", files[1], "--against", files[0], "--json")
    assert json.loads(told.out) == nothing
    same = eai("check", files[0], "--against", files[0])
    assert same.out == "of 3 tasks 3 are the same, 3 have the same goals, 0 are solved by lookup\n"
    away = tmp_path / "elsewhere"
    made(eai, away, "--split", "test", "--tier", "S", "--seed", 3, "--against", files[1])
    texts = [(folder / "test.jsonl").read_text().splitlines() for folder in (tmp_path, away)]
    ids = [{json.loads(line)["id"] for line in lines} for lines in texts]
    assert ids[0].isdisjoint(ids[1])
    assert json.loads((away / "generated.json").read_text())["overlap"] == {"test": {files[1]: nothing}}


def test_only_three_splits_have_a_name(eai: Command, tmp_path: Path) -> None:
    outcome = eai("generate", "--like", "behavior", "--out", tmp_path, "--split", "fresh")
    assert outcome.status == 2
    assert "'tasks', 'train', 'validation', 'test'" in outcome.err.replace("\n", " ")


def test_a_secret_is_revealed_to_prove_what_was_used(eai: Command, tmp_path: Path) -> None:
    made(eai, tmp_path, "--split", "test", "--secret", "only we know", "--tier", "S")
    asked = ("check", tmp_path, "--split", "test", "--secret")
    assert eai(*asked, "only we know").status == 0
    guessed = eai(*asked, "a guess")
    assert guessed.status == 2
    assert "the digest of the secret is not" in guessed.out
    assert "3 of 3 tasks are of a seed that does not follow" in guessed.out
    file = tmp_path / "test.jsonl"
    file.write_text("".join(file.read_text().splitlines(keepends=True)[:2]))
    assert "is not what was published" in eai(*asked, "only we know").out
    assert "generated with --secret" in eai("check", tmp_path, "--split", "x", "--secret", "s").err


def test_compressed_files_hold_the_same(eai: Command, tmp_path: Path) -> None:
    made(eai, tmp_path)
    outcome = eai("generate", "--like", "behavior", "--n", 3, "--out", tmp_path / "z", "--gzip")
    assert outcome.status == 0
    digest = json.loads((tmp_path / "generated.json").read_text())["sets"]["tasks"]["sha256"]
    assert json.loads((tmp_path / "z" / "generated.json").read_text())["sets"]["tasks"]["sha256"] == digest
    assert eai("check", tmp_path / "z").status == 0


def test_a_world_that_has_no_more_tasks_says_so(
    eai: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("eai.benchmarks.generator.seeds._MAX_FAILED_SEEDS", FEW)
    monkeypatch.syspath_prepend(ROOT / "examples" / "lamps")
    outcome = eai("generate", "--like", "lamps:lamps", "--n", 1000, "--out", tmp_path)
    assert outcome.status == 2
    kept = (tmp_path / "tasks.jsonl").read_text()
    number = len(kept.splitlines())
    assert f"only {number} of 1000 tasks generated; the last {FEW} seeds gave no task" in outcome.err
    assert f"; {number} tasks written to {tmp_path / 'tasks.jsonl'}, as with --n {number}" in outcome.err
    again = eai("generate", "--like", "lamps:lamps", "--n", number, "--out", tmp_path / "again")
    assert again.status == 0
    entry = json.loads((tmp_path / "generated.json").read_text())["sets"]["tasks"]
    estimate = f"estimated number of different tasks: at least {entry['estimated_tasks']}"
    assert estimate in outcome.err
    assert again.out.endswith(f"{estimate}\n")
    for name in ("tasks.jsonl", "generated.json"):
        assert (tmp_path / "again" / name).read_bytes() == (tmp_path / name).read_bytes()


def test_an_interrupt_keeps_what_was_found_unless_something_stands_there(
    eai: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = TaskGenerator.make_task_from_seed
    calls = [0]

    def judge(generator: TaskGenerator, seed: str, known: Collection[tuple[str, str]]) -> TaskSeedOutcome:
        calls[0] += 1
        if calls[0] > 6:
            raise KeyboardInterrupt
        return whole(generator, seed, known)

    monkeypatch.setattr(TaskGenerator, "make_task_from_seed", judge)
    for first in (True, False):
        calls[0] = 0
        outcome = eai("generate", "--like", "behavior", "--n", 100, "--out", tmp_path)
        assert (outcome.status, outcome.out) == (130, "")
        assert "\neai: interrupted" in f"\n{outcome.err}", outcome.err  # after progress, if slow
        assert ("written to" in outcome.err) is first
        assert eai("check", tmp_path).status == 0


def test_a_folder_that_cannot_be_is_told_before_anything_is_made(eai: Command, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    outcome = eai("generate", "--like", "behavior", "--n", 10**9, "--out", tmp_path / "file")
    assert outcome.status == 2
    assert "file: cannot be written" in outcome.err


def test_tasks_of_an_expected_difficulty_are_asked_for(eai: Command, tmp_path: Path) -> None:
    for low, high, n in ((-3, 0, 1), (0.5, 9, 3)):
        for task in made(eai, tmp_path / str(low), "--difficulty", f"{low}:{high}", n=n):
            about = task["about"]
            assert isinstance(about, dict)
            assert low <= about["difficulty"]["expected"] <= high
    outcome = eai("generate", "--like", "behavior", "--out", tmp_path, "--difficulty", "2:1")
    assert outcome.status == 2
    assert "expected two numbers LOW:HIGH" in outcome.err


def test_tasks_that_hold_as_much_as_is_asked_for(eai: Command, tmp_path: Path) -> None:
    for task in made(eai, tmp_path / "a", "--at-least", "containers=1", "--at-least", "goals=3"):
        about, goals = task["about"], task["goals"]
        assert isinstance(about, dict)
        assert isinstance(goals, list)
        assert about["containers"] >= 1
        assert about["goals"] == len(goals) >= 3
    spec = json.loads((tmp_path / "a" / "generated.json").read_text())["sets"]["tasks"]["spec"]
    assert spec["at_least"] == [["containers", 1], ["goals", 3]]


@pytest.mark.parametrize(
    ("asked", "told"),
    [
        ("container=1", "found 'container=1'; did you mean containers?"),
        ("goals", "expected NAME=N, as in containers=1, found 'goals'"),
        ("goals=-1", "found 'goals=-1'"),
    ],
)
def test_what_cannot_be_measured_is_told(eai: Command, tmp_path: Path, asked: str, told: str) -> None:
    outcome = eai("generate", "--like", "behavior", "--out", tmp_path, "--at-least", asked)
    assert outcome.status == 2
    assert told in outcome.err


def test_val_is_asked_where_that_is_wanted(
    eai: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    outcome = eai("generate", "--like", "behavior", "--out", tmp_path, "--val", "--kind", "order")
    assert (outcome.status, outcome.out) == (2, "")
    plain = made(eai, tmp_path / "plain")
    monkeypatch.setattr("eai.cli.generate.find_val_program", lambda: Path("Validate"))
    for verdict, status in ((VALID, 0), ("no answer in 60 CPU seconds", 0), (NOT_VALID, 1)):
        monkeypatch.setattr("eai.cli.generate.run_val", lambda *_, verdict=verdict: verdict)
        outcome = eai("generate", "--like", "behavior", "--n", 3, "--val", "--out", tmp_path / verdict)
        assert (outcome.status == 0) == (status == 0)
        assert (tmp_path / verdict / "tasks.jsonl").exists() == (status == 0)
        if verdict not in (VALID, NOT_VALID):
            assert "VAL accepts 0 certificates, no answer on 3" in outcome.out
    assert "VAL rejects a plan that eai accepts, so no file is written" in outcome.err
    text = (tmp_path / VALID / "tasks.jsonl").read_text()
    assert [json.loads(line) for line in text.splitlines()] == plain


def test_the_order_of_a_pair_does_not_say_which_has_a_plan(eai: Command, tmp_path: Path) -> None:
    first, second = made(eai, tmp_path, "--kind", "pairs", "--seed", 0, n=1)
    assert [line["id"] for line in (first, second)] == sorted([str(first["id"]), str(second["id"])])
    assert first["missing"], "the one that was made first has a plan"
    assert not second["missing"]


def read_files(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir())}


@pytest.mark.parametrize(
    "sets",
    [
        [["--split", "test"], ["--split", "train"]],
        [["--kind", "order"], ["--kind", "hazards", "--split", "train"]],
        [["--kind", "pairs"]],
    ],
)
def test_any_number_of_workers_writes_the_same_bytes(
    eai: Command, tmp_path: Path, sets: list[list[str]]
) -> None:
    for workers in (1, 2):
        for options in sets:
            number = 4 if "--kind" not in options else 1
            made(eai, tmp_path / str(workers), *options, "--seed", 8, "--workers", workers, n=number)
    assert read_files(tmp_path / "1") == read_files(tmp_path / "2")


def test_any_number_of_workers_refuses_the_same_copies(
    eai: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("eai.benchmarks.generator.seeds._MAX_FAILED_SEEDS", FEW)
    monkeypatch.syspath_prepend(ROOT / "examples" / "lamps")
    messages = set()
    for workers in (1, 2):
        out = tmp_path / str(workers)
        outcome = eai("generate", "--like", "lamps:lamps", "--n", 1000, "--out", out, "--workers", workers)
        messages.add(outcome.err.splitlines()[-1].replace(str(out), ""))
    assert len(messages) == 1
    assert read_files(tmp_path / "1") == read_files(tmp_path / "2")
    rejected = json.loads((tmp_path / "2" / "generated.json").read_text())["sets"]["tasks"]["rejected"]
    assert rejected[SeedRejectionReason.COPY.value]


def test_a_set_is_not_written_twice_in_two_forms(eai: Command, tmp_path: Path) -> None:
    """The tasks of the older file would count as tasks of another set, and be refused."""
    (tmp_path / "train.jsonl").touch()
    outcome = eai("generate", "--like", "behavior", "--split", "train", "--out", tmp_path, "--gzip")
    assert outcome.status == 2
    assert f"{tmp_path / 'train.jsonl'}: the set train is there already" in outcome.err
