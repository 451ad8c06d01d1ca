from __future__ import annotations

import json
import shlex
from pathlib import Path
from typing import Any

import pytest

from boxes import lacking
from by_path import ROOT
from eai.abilities.protocol import PAPER_ABILITIES
from eai.agents.episode_server import open_episode_server
from eai.base.errors import InputError
from eai.base.files import parse_toml
from eai.base.store import DataPackStore
from eai.benchmarks.names import TaskReference
from eai.benchmarks.registry import find_benchmark
from eai.extensions.harbor.folders import IMAGE, NO_SOLUTION, SOLVED_WITHOUT_WORK, write_task_folders
from eai.extensions.harbor.verify import compute_episode_rewards
from eai.tasks.source import Source
from extensions.harbor.trials import HARBOR, Trial, asked, exported, lint
from sweeps import first_of, sweep

WHY_NOT = lacking()
in_boxes = pytest.mark.skipif(WHY_NOT is not None, reason=f"a trial runs in boxes: {WHY_NOT}")

LAMP = {
    "base": "lamps:lamps",
    "instruction": "Light up.",
    "objects": {"robot": "robot", "lamp": "lamp"},
    "agent": "robot",
    "facts": {},
    "goals": ["lit(lamp)"],
    "plan": [["GO", "lamp"], ["PRESS", "lamp"]],
}
ACTION = "(:action flip :parameters (?x) :effect (on ?x))"
DOMAIN = f"(define (domain switches) (:predicates (on ?x)) {ACTION})"
PROBLEM = "(define (problem p) (:domain switches) (:objects s) (:init) (:goal (on s)))"
GIFTS = "assembling_gift_baskets_0_Beechwood_0_int_0_2021-10-26_12-46-37"


@pytest.fixture
def nights(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A file of three tasks; in the second one all is well, and no plan is known to the third."""
    monkeypatch.syspath_prepend(ROOT / "examples" / "lamps")
    lines: list[dict[str, Any]] = [
        {"id": "dark/1", **LAMP},
        {"id": "lit", **LAMP, "facts": {"lit": ["lamp"]}, "plan": []},
        {"id": "odd", **LAMP, "goals": ["at(lamp, lamp)"], "plan": []},
    ]
    (tmp_path / "nights.jsonl").write_text("".join([json.dumps(line) + "\n" for line in lines]))
    return tmp_path / "nights.jsonl"


@pytest.mark.parametrize("ability", ["action_sequencing", "acting"])
def test_tasks_are_left_out_and_counted(ability: str, nights: Path, tmp_path: Path) -> None:
    counts = write_task_folders(*asked(str(nights), ability), tmp_path / "out")
    assert counts == (1, {NO_SOLUTION: 1, SOLVED_WITHOUT_WORK: 1})
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == [
        IMAGE,
        f"lamps-nights-{ability}-dark-1",
    ]


def test_a_folder_says_what_it_is_of(nights: Path, tmp_path: Path) -> None:
    exported(str(nights), "action_sequencing", ["dark/1"], tmp_path / "out", image="a", verifier_image="b:1")
    folder = tmp_path / "out" / "lamps-nights-action_sequencing-dark-1"
    about = parse_toml((folder / "task.toml").read_text())
    assert about["environment"]["docker_image"] == "a"
    assert about["verifier"]["environment"] == {"network_mode": "no-network", "docker_image": "b:1"}
    assert (folder / "tests/Dockerfile").read_text().startswith("FROM b:1\n")
    assert "/workdir/answer.txt" in (folder / "instruction.md").read_text()
    assert "PRESS" in (folder / "solution/solve.sh").read_text()
    task = TaskReference.parse(about["verifier"]["env"]["EAI_TASK"])
    assert task == ("nights.jsonl", "action_sequencing", "dark/1")


def test_tasks_of_files_are_in_the_image(
    nights: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    exported(str(nights), "action_sequencing", ["dark/1"], tmp_path / "out")
    monkeypatch.chdir(tmp_path / "out" / IMAGE)
    assert [*find_benchmark("nights.jsonl").tasks(Source())] == ["dark/1"]


def test_tasks_of_a_file_with_other_words_are_in_the_image(
    nights: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (folder,) = exported(f"obfuscated:{nights}", "action_sequencing", ["dark/1"], tmp_path / "out")
    about = parse_toml((folder / "task.toml").read_text())
    task = TaskReference.parse(about["verifier"]["env"]["EAI_TASK"])
    assert task == ("obfuscated:nights.jsonl", "action_sequencing", "dark/1")
    monkeypatch.chdir(tmp_path / "out" / IMAGE)
    assert [*find_benchmark(task.benchmark).tasks(Source())] == ["dark/1"]


def test_the_id_of_a_task_may_have_any_characters(nights: Path, tmp_path: Path) -> None:
    other = tmp_path / "stars.jsonl"
    other.write_text(json.dumps({"id": "dark \N{GLOWING STAR}", **LAMP}) + "\n")
    (folder,) = exported(str(other), "acting", ["dark \N{GLOWING STAR}"], tmp_path / "out")
    about = parse_toml((folder / "task.toml").read_text("utf-8"))
    assert about["metadata"]["task_id"] == "dark \N{GLOWING STAR}"
    compose = (folder / "environment/docker-compose.yaml").read_text("utf-8")
    assert '"--tasks=dark \N{GLOWING STAR}"' in compose


@pytest.mark.parametrize(
    "reference",
    [
        "pddl:{0}/domain.pddl,{0}/all",
        "pddl:{0}/domain.pddl, {0}/all",
        "pddl:{0}/domain.pddl,{0}/one/domain.pddl",
        "pddl:{0}",
        "rules:pddl:{0}",
    ],
)
def test_problems_in_pddl_are_in_the_image(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, reference: str
) -> None:
    world = tmp_path / "world"
    (world / "all").mkdir(parents=True)
    (world / "domain.pddl").write_text(DOMAIN)
    (world / "all/p.pddl").write_text(PROBLEM)
    if "one" in reference:
        (world / "one").mkdir()
        (world / "one/domain.pddl").write_text(PROBLEM)
    (folder,) = exported(reference.format(world), "action_sequencing", ["p"], tmp_path / "out")
    monkeypatch.chdir(tmp_path / "out" / IMAGE)
    about = parse_toml((folder / "task.toml").read_text())
    task = TaskReference.parse(about["verifier"]["env"]["EAI_TASK"])
    assert str(world) not in task.benchmark
    assert [*find_benchmark(task.benchmark).tasks(Source())] == ["p"]


def test_tasks_whose_world_is_in_other_files_are_refused(tmp_path: Path) -> None:
    (tmp_path / "domain.pddl").write_text(DOMAIN)
    (tmp_path / "p.pddl").write_text(PROBLEM)
    base = f"pddl:{tmp_path}/domain.pddl,{tmp_path}/p.pddl"
    task = {"id": "t", "base": base, "instruction": "Switch.", "objects": {"s": "object"}, "facts": {}}
    other = tmp_path / "other.jsonl"
    other.write_text(json.dumps({**task, "goals": ["on(s)"], "plan": [["flip", "s"]]}) + "\n")
    with pytest.raises(InputError, match="in other files, which cannot be copied"):
        exported(str(other), "action_sequencing", ["t"], tmp_path / "out")


def test_a_wheel_is_in_the_image(nights: Path, tmp_path: Path) -> None:
    wheel = tmp_path / "eai-1.whl"
    wheel.write_bytes(b"PK")
    exported(str(nights), "action_sequencing", ["dark/1"], tmp_path / "out", wheels=(wheel,))
    image = tmp_path / "out" / IMAGE
    assert (image / wheel.name).read_bytes() == b"PK"
    assert "RUN pip install --no-cache-dir ./eai-1.whl\n" in (image / "Dockerfile").read_text()


@pytest.mark.parametrize(
    ("how", "said"),
    [
        ({"wheels": (Path("none.whl"),)}, "none.whl: cannot be read"),
        (
            {"ability": "acting", "is_shared": True},
            "--shared: acting must be scored in a container that the agent cannot write to; omit this option",
        ),
        ({"ability": "scene_graph"}, "prompts with pictures"),
        ({"task_ids": ["lit"]}, "all tasks are left out"),
    ],
)
def test_what_cannot_be_exported(how: dict[str, Any], said: str, nights: Path, tmp_path: Path) -> None:
    ability, task_ids = how.pop("ability", "action_sequencing"), how.pop("task_ids", ["dark/1"])
    with pytest.raises(InputError, match=said):
        exported(str(nights), ability, task_ids, tmp_path / "out", **how)


def test_a_world_is_of_a_task_that_commands_can_name(nights: Path, tmp_path: Path) -> None:
    other = tmp_path / "commas.jsonl"
    other.write_text(json.dumps({"id": "dark,1", **LAMP}) + "\n")
    exported(str(other), "action_sequencing", ["dark,1"], tmp_path / "answers")
    with pytest.raises(InputError, match="expected an id without a comma"):
        exported(str(other), "acting", ["dark,1"], tmp_path / "out")


def test_a_folder_in_use_is_kept(nights: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="expected a new or an empty folder"):
        exported(str(nights), "action_sequencing", ["dark/1"], tmp_path)


def test_names_of_folders_are_unique(nights: Path, tmp_path: Path) -> None:
    other = tmp_path / "other.jsonl"
    objects = {
        "robot": "robot",
        "candle": "lamp",
    }  # as questions have an example
    plan = [["GO", "candle"], ["PRESS", "candle"]]
    second = {"id": "dark-1", **LAMP, "objects": objects, "goals": ["lit(candle)"], "plan": plan}
    other.write_text(nights.read_text() + json.dumps(second) + "\n")
    with pytest.raises(InputError, match="dark/1 and dark-1 have the same folder name"):
        exported(str(other), "action_sequencing", ["dark/1", "dark-1"], tmp_path / "out")
    assert not (tmp_path / "out").exists()


@pytest.mark.skipif(HARBOR is None, reason="Harbor is not installed: see `python -m bench harbor -h`")
@pytest.mark.parametrize("ability", ["action_sequencing", "acting"])
@pytest.mark.parametrize("how", [{}, {"image": "a", "verifier_image": "b"}])
def test_harbor_finds_nothing_wrong(
    ability: str, how: dict[str, Any], data_store: DataPackStore, tmp_path: Path
) -> None:
    (folder,) = exported("virtualhome", ability, ["27_2"], tmp_path / "out", **how)
    assert lint(folder) == []


@in_boxes
@pytest.mark.parametrize("ability", first_of([*PAPER_ABILITIES, "acting"]))
def test_the_solution_wins_and_nothing_does_not(
    ability: str, data_store: DataPackStore, tmp_path: Path
) -> None:
    (folder,) = exported("virtualhome", ability, ["27_2"], tmp_path / "out")
    with Trial(folder, tmp_path / "idle", data_store) as trial:
        assert trial.judge()["reward"] == 0
    with Trial(folder, tmp_path / "trial", data_store) as trial:
        trial.solve()
        assert trial.judge()["reward"] == 1


@in_boxes
def test_an_answer_is_scored_in_the_agents_box(data_store: DataPackStore, tmp_path: Path) -> None:
    (folder,) = exported("behavior", "action_sequencing", [GIFTS], tmp_path / "out", is_shared=True)
    with Trial(folder, tmp_path / "trial", data_store) as trial:
        trial.main.env["EAI_DATA_DIR"] = "/data"
        trial.main.upload(data_store.folder, "/data")
        trial.agent("cp /tests/test.sh answer.txt; ln -s /etc/passwd answer.txt")
        assert trial.judge()["reward"] == 0
        trial.agent("rm answer.txt")
        trial.solve()
        assert trial.judge() == {"reward": 1, "task_success": 1, "execution_success": 1, "valid": 1}


@sweep
@pytest.mark.parametrize("domain", ["virtualhome", "behavior"])
def test_solutions_win_in_the_worlds_of_their_folders(
    domain: str, data_store: DataPackStore, tmp_path: Path
) -> None:
    suite, prompts = asked(domain, "acting")
    some = dict([*prompts.items()][:: len(prompts) // 20][:20])
    written, left_out = write_task_folders(suite, some, tmp_path / "out")
    assert written + left_out.total() == 20
    assert left_out.total() <= 1
    for folder in (tmp_path / "out").glob(f"{domain}-*"):
        task_id = parse_toml((folder / "task.toml").read_text())["metadata"]["task_id"]
        acts = [shlex.split(line)[1] for line in (folder / "solution/solve.sh").read_text().splitlines()[2:]]
        with open_episode_server(tmp_path / task_id, suite, [(task_id, 1)]) as worlds:
            assert compute_episode_rewards(suite, task_id, tmp_path / task_id)["reward"] == 0
            for command in acts:
                worlds.play_command((task_id, 1), command)
        assert compute_episode_rewards(suite, task_id, tmp_path / task_id)["reward"] == 1
