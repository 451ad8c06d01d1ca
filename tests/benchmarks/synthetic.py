"""A small made-up data set in the layout of the published wheel."""

from __future__ import annotations

import base64
import hashlib
import io
import json
import tarfile
import zipfile
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from eai.base.source import ArchiveFiles, PackageArchive
from eai.benchmarks.packs import DataPack, find_packs
from eai.benchmarks.reference_wheel import (
    BEHAVIOR_PDDL,
    EAI_EVAL,
    PROMPTS,
    RESOURCES,
    TEMPLATE_SOURCE,
    map_data_pack_files_to_wheel_paths,
)

PROGRAMS = "virtualhome_eval/dataset/programs_processed_precond_nograb_morepreconds/"
SCENE = "TrimmedTestScene1_graph/results_intentions_march-13-18/file"
GOALS = "virtualhome_eval/resources/virtualhome/task_state_LTL_formula_accurate.json"
PROBLEMS = "virtualhome_eval/resources/virtualhome/problem_pddl/"

Triple = tuple[int, str, int]


def node(
    identifier: int, name: str, states: Iterable[str] = (), properties: Iterable[str] = ()
) -> dict[str, Any]:
    return {
        "id": identifier,
        "class_name": name,
        "category": "Rooms" if name.endswith("room") else "placable_objects",
        "properties": list(properties),
        "states": list(states),
        "prefab_name": None,
        "bounding_box": None,
    }


def graph(nodes: Iterable[Mapping[str, Any]], edges: Iterable[Triple]) -> dict[str, Any]:
    triples = ({"from_id": source, "relation_type": kind, "to_id": target} for source, kind, target in edges)
    return {"nodes": list(nodes), "edges": list(triples)}


@dataclass(frozen=True)
class MadeTask:
    id: str
    title: str
    script: str
    goals: list[dict[str, Any]]
    actions: list[str]
    tl_goal: str | None
    initial: dict[str, Any]
    final: dict[str, Any]


def bundle(files: Mapping[str, bytes]) -> ArchiveFiles:
    return ArchiveFiles(tuple(files), files.__getitem__)


ROOM = node(1, "bathroom", ["CLEAN"])
LAMP = node(7, "lamp", ["OFF", "CLEAN", "OFF"], ["HAS_SWITCH", "CAN_OPEN"])
CHARACTER = node(65, "character")
SOFA = node(90, "sofa", ["CLEAN"], ["SITTABLE"])
CUP = node(1000, "cup", ["DIRTY"], ["GRABBABLE"])
LAMP_ON = node(7, "lamp", ["CLEAN", "ON"], ["CAN_OPEN", "HAS_SWITCH"])
PLACES: list[Triple] = [(65, "INSIDE", 1), (7, "INSIDE", 1), (90, "INSIDE", 1)]
NEAR: list[Triple] = [(65, "CLOSE", 90), (65, "CLOSE", 7), (65, "CLOSE", 7)]

TASKS = (
    MadeTask(
        "1_1",
        "Turn on light",
        "Turn on light\nSwitch the lamp on.\n\n\n[WALK] <lamp> (1.7)\n[SWITCHON] <lamp> (1.7)\n",
        [{"id": 7, "class_name": "lamp", "state": "ON"}],
        ["LOOKAT|WATCH"],
        "ON(lamp.7)",
        graph([node(90, "stool"), ROOM, LAMP, CHARACTER, SOFA], [*PLACES, *NEAR]),
        graph([ROOM, LAMP_ON, CHARACTER, SOFA], [*PLACES, (65, "CLOSE", 7)]),
    ),
    MadeTask(
        "2_1",
        "Turn on light",
        "Turn on light\nNothing to do.\n\n[STANDUP]\n",
        [],
        [],
        None,
        graph([ROOM, LAMP, CHARACTER, SOFA], [*PLACES, *NEAR]),
        graph([ROOM, LAMP, CHARACTER, SOFA], [*PLACES, *NEAR]),
    ),
    MadeTask(
        "3_1",
        "Put cup",
        "Put cup\nPut it on the sofa.\n\n[GRAB] <cup> (1.1000)\n[PUTBACK] <cup> (1.1000) <sofa> (1.90)\n",
        [
            {"from_id": 1000, "relation_type": "ON", "to_id": 90},
            {"from_id": 1000, "relation_type": "ON", "to_id": 7},
        ],
        ["GRAB"],
        "ONTOP(cup.1000, sofa.90)",
        # Inside the lamp first, then the room: not the shared order followed by the task's own.
        graph([ROOM, LAMP, CHARACTER, SOFA, CUP], [(65, "INSIDE", 7), *PLACES, (1000, "INSIDE", 1), NEAR[1]]),
        graph([ROOM, LAMP, CHARACTER, SOFA, CUP], [(65, "INSIDE", 7), *PLACES, (1000, "ON", 90), NEAR[1]]),
    ),
)


def files(tasks: Iterable[MadeTask] = TASKS) -> dict[str, bytes]:
    """Return the content of the wheel by path."""
    made = list(tasks)
    goals: dict[str, dict[str, Any]] = {}
    copied = [
        file
        for pack in (RESOURCES, BEHAVIOR_PDDL, PROMPTS)
        for file in map_data_pack_files_to_wheel_paths(pack).values()
    ]
    contents = dict.fromkeys(copied, b"[]")
    for task in made:
        goal = {"vh_goal": {"actions": task.actions, "goal": task.goals}, "tl_goal": task.tl_goal}
        goals.setdefault(task.title, {})[task.id] = goal
        graphs = {"init_graph": task.initial, "final_graph": task.final}
        contents[f"{PROGRAMS}init_and_final_graphs/{SCENE}{task.id}.json"] = json.dumps(graphs).encode()
        contents[f"{PROGRAMS}executable_programs/{SCENE}{task.id}.txt"] = task.script.encode()
        contents[f"{PROBLEMS}{task.title.replace(' ', '_')}/{task.id}.pddl"] = b"(define)"
    contents[GOALS] = json.dumps({"scene_1": goals}).encode()
    contents[map_data_pack_files_to_wheel_paths(RESOURCES)["success_task.json"]] = json.dumps(
        [made[0].id]
    ).encode()
    contents[map_data_pack_files_to_wheel_paths(RESOURCES)["gold_action.json"]] = b'{"grab": {}}'
    prompts = [{"identifier": f"scene_1_{made[0].id}", "llm_prompt": "?"}]
    contents[TEMPLATE_SOURCE] = b'prompt = """<goal_str>"""'
    contents[map_data_pack_files_to_wheel_paths(PROMPTS)["virtualhome/subgoal_decomposition.json"]] = (
        json.dumps(prompts).encode()
    )
    return contents


def build_wheel(folder: Path, contents: Mapping[str, bytes] | None = None) -> PackageArchive:
    """Write `madeup_eval-1.0-py3-none-any.whl` into the folder, and return its pin."""
    information = "madeup_eval-1.0.dist-info/"
    entries = dict(files() if contents is None else contents)
    entries[f"{information}METADATA"] = b"Metadata-Version: 2.1\nName: madeup-eval\nVersion: 1.0\n"
    entries[f"{information}WHEEL"] = b"Wheel-Version: 1.0\nRoot-Is-Purelib: true\nTag: py3-none-any\n"
    digests = {
        path: base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
        for path, content in entries.items()
    }
    lines = [f"{path},sha256={digests[path]},{len(content)}" for path, content in entries.items()]
    entries[f"{information}RECORD"] = "\n".join([*lines, f"{information}RECORD,,", ""]).encode()
    path = folder / "madeup_eval-1.0-py3-none-any.whl"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in entries.items():
            archive.writestr(name, content)
    published = sorted((name, digest) for name, digest in digests.items() if ".dist-info/" not in name)
    record = "".join(f"{name},{digest}\n" for name, digest in published)
    return pin("madeup-eval", path, hashlib.sha256(record.encode()).hexdigest())


def build_sdist(folder: Path, witness: Path) -> PackageArchive:
    """Write a source distribution whose `setup.py` leaves a file when it is run, and return its pin."""
    path = folder / "madeup_problems-1.0.tar.gz"
    entries = {
        "PKG-INFO": b"Metadata-Version: 2.1\nName: madeup-problems\nVersion: 1.0\n\nSome text.\n",
        "setup.py": f"import pathlib\npathlib.Path({str(witness)!r}).touch()\nraise SystemExit(1)\n".encode(),
        "problems/one.bddl": b"(define)",
    }
    with tarfile.open(path, "w:gz") as archive:
        for name, content in entries.items():
            member = tarfile.TarInfo(f"madeup_problems-1.0/{name}")
            member.size = len(content)
            archive.addfile(member, io.BytesIO(content))
    return pin("madeup-problems", path)


def pin(name: str, path: Path, record_sha256: str | None = None) -> PackageArchive:
    content = path.read_bytes()
    return PackageArchive(
        name, "1.0", path.name, hashlib.sha256(content).hexdigest(), len(content), record_sha256
    )


def packs_from(wheel: PackageArchive) -> tuple[DataPack, ...]:
    """Return the packs that need only the published wheel, made from another wheel."""
    return tuple(replace(pack, archives=(wheel,)) for pack in find_packs() if pack.archives == (EAI_EVAL,))
