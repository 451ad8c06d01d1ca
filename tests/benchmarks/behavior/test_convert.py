"""Conversion of a made-up wheel and a made-up bddl archive with one task."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import pytest

from eai.base.errors import DataError
from eai.base.store import DataPackStore, ignore_progress
from eai.benchmarks.behavior.convert import convert_tasks
from eai.benchmarks.behavior.records import OPTIONS_MEMBER, TASKS_MEMBER, read_records
from eai.logic.formula import And, get_operands

TASK = "dusting_0_Nowhere_0_int_0_2021-01-01_00-00-00"
DATA = "behavior_eval/evaluation/goal_interpretation/resources/data/"
SEQUENCING = "behavior_eval/evaluation/action_sequencing/resources/"
PROBLEM = """
(define (problem dusting_0)\r
  (:domain igibson)
  (:objects jar.n.01_1 - jar.n.01 floor.n.01_1 - floor.n.01 agent.n.01_1 - agent.n.01)
  (:init (dusty jar.n.01_1) (onfloor jar.n.01_1 floor.n.01_1) (onfloor agent.n.01_1 floor.n.01_1))
  (:goal (and (not (dusty ?jar.n.01_1)))))
"""
PROMPT = """Example: Your task: interactable objects:
{'name': 'rag_0', 'category': 'rag.n.01'}
Your task:
['dusty', 'jar_7']
interactable objects:
{'name': 'jar_7', 'category': 'jar.n.01'}
{'name': 'room_floor_kitchen_0', 'category': 'floor.n.01'}
Output:"""
OPTIONS = [[[["not", ["dusty", "jar.n.01_1"]]]]]
TAXONOMY = {
    "name": "entity.n.01",
    "igibson_categories": [],
    "abilities": {},
    "children": [
        {"name": "jar.n.01", "igibson_categories": ["jar"], "abilities": {"openable": {}, "dustyable": {}}},
        {"name": "floor.n.01", "igibson_categories": ["floors"], "abilities": {"stainable": {}}},
    ],
}


@dataclass(frozen=True)
class Files:
    """A bundle in memory."""

    contents: Mapping[str, bytes] = field(default_factory=dict)

    def names(self) -> tuple[str, ...]:
        return tuple(self.contents)

    def read(self, path: str) -> bytes:
        if path not in self.contents:
            raise DataError(f"no file {path}")
        return self.contents[path]


def wheel(**changed: Any) -> Files:
    """Return the wheel; keyword arguments replace contents of its files."""
    values = {
        "prompt": PROMPT,
        "states": {"jar.n.01_1": ["Open", "Dusty"], "floor.n.01_1": ["Stained"]},
        "plan": [{"action": "CLEAN", "object": "jar_7"}, {"action": "PUT", "object": " jar_7 , rag_0"}],
    } | changed
    files = {
        "behavior_eval/data/demo_stats.json": {
            TASK: {"task": "dusting", "task_id": 0, "scene_id": "Nowhere"}
        },
        f"{SEQUENCING}prompts/helm_prompts.json": [{"identifier": TASK, "llm_prompt": values["prompt"]}],
        f"{SEQUENCING}human_annotations/{TASK}.json": values["plan"],
        f"{DATA}all_objects.json": {TASK: values["states"]},
        f"{DATA}all_conditions.json": {TASK: {"goal_conditions": {"1": OPTIONS[0]}}},
        f"{DATA}instructions_by_activity_name.json": {"dusting": "Dust it."},
        f"{DATA}natural_language_goal_conditions.json": {"dusting": ["it is not dusty"]},
    }
    return Files({path: json.dumps(content).encode() for path, content in files.items()})


def bddl(problem: str = PROBLEM) -> Files:
    return Files(
        {
            "bddl/hierarchy_owned.json": json.dumps(TAXONOMY).encode(),
            "bddl/activity_definitions/dusting/problem0.bddl": problem.encode(),
        }
    )


def test_a_task_is_assembled_from_both_archives(tmp_path: Any) -> None:
    steps: list[tuple[int, ...]] = []
    members = convert_tasks(wheel(), bddl(), lambda _, subject, *counts: steps.append(counts))
    assert members.keys() == {TASKS_MEMBER, OPTIONS_MEMBER}
    assert steps == [(0, 1), (1, 1)]
    tasks = read_records(DataPackStore(tmp_path).write_pack("behavior", {}, members))
    assert list(tasks) == [TASK]
    record = tasks[TASK]
    jar, floor = record.objects
    assert (record.activity, record.scene, record.instruction) == ("dusting", "Nowhere", "Dust it.")
    assert (jar.name, jar.instance, jar.model, jar.abilities) == (
        "jar_7",
        "jar.n.01_1",
        "jar",
        ("dustyable", "openable"),
    )
    assert (floor.name, floor.is_floor, floor.possible_states) == ("room_floor_kitchen_0", True, ("stained",))
    assert (jar.possible_states, jar.names_of_sliced_halves) == (("dusty", "open"), ())
    assert record.plan == (("CLEAN", ("jar_7",)), ("PUT", ("jar_7", "rag_0")))
    assert len(get_operands(record.problem.goal, And)) == 1
    assert record.goal_options == (((("not", ("dusty", "jar.n.01_1")),),),)
    assert tasks[TASK] is record


@pytest.mark.parametrize(
    ("wheel_", "bddl_", "problem"),
    [
        (wheel(prompt=PROMPT.replace("'jar.n.01'", "'mug.n.01'")), bddl(), "have different objects"),
        (wheel(prompt=PROMPT.replace("jar_7", "jar")), bddl(), "'jar' in a prompt: expected a category"),
        (wheel(states={"jar.n.01_1": ["Open"]}), bddl(), "possible states of jar.n.01_1"),
        (wheel(), bddl("(define"), "problem0.bddl of dusting: line 1"),
        (wheel(), Files(), "no file"),
    ],
)  # fmt: skip
def test_contradictory_files_are_an_error(wheel_: Files, bddl_: Files, problem: str) -> None:
    with pytest.raises(DataError, match=problem):
        convert_tasks(wheel_, bddl_, ignore_progress)
