"""Answers to the VirtualHome action sequencing tasks, made from the data set's own scripts.

Each task has one answer: the script's steps that use relevant objects only, with one seeded change. A step
with another object would be a hallucination, and the reference package never executes an unchanged script. In
both cases the reference package would skip the work that is to be measured.
"""

from __future__ import annotations

import json
import random
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from differential.reference import Response

SCENE = "TrimmedTestScene1_graph/results_intentions_march-13-18"
DATA_SET = "dataset/programs_processed_precond_nograb_morepreconds"
STEP = re.compile(r"\[(?P<action>\w+)\]")
OBJECT = re.compile(r"<(?P<name>[^>]+)> \((?:\d+\.)*(?P<number>\d+)\)")


UNUSABLE = frozenset({"PLUGIN", "PLUGOUT", "PUTOBJBACK"})
"""Actions that the reference package rejects, or aborts on if the object was not grabbed before."""


class Item(NamedTuple):
    """An object that a step names."""

    name: str
    number: int


class Step(NamedTuple):
    """A step of a plan: an action with its objects."""

    action: str
    items: tuple[Item, ...]


def make_responses(package: Path, seed: int = 0) -> list[Response]:
    """Return one answer for each of the 342 tasks, in the data set's order. Equal seeds give equal answers.

    Args:
        package: Folder of the installed package `virtualhome_eval`.
        seed: Seed of the changes.
    """
    tasks = json.loads((package / "resources" / "virtualhome" / "id2task.json").read_text(encoding="utf-8"))
    choice = random.Random(seed)  # noqa: S311 - reproducible, not secret
    return [
        Response(task_id, write_answer(change_one_step(list_executable_steps(package, task_id), choice)))
        for task_id in tasks
    ]


def list_executable_steps(package: Path, task_id: str) -> list[Step]:
    """Return the steps of a script that the reference package can execute, with relevant objects only."""
    script = package / DATA_SET / "executable_programs" / SCENE / f"file{task_id}.txt"
    usable = find_changed_objects(
        package / DATA_SET / "init_and_final_graphs" / SCENE / f"file{task_id}.json"
    )
    return [
        step
        for step in read_script_steps(script)
        if step.action not in UNUSABLE and all(item.number in usable for item in step.items)
    ]


def read_script_steps(script: Path) -> Iterator[Step]:
    """Return all steps of a script file. Lines without a leading bracket are its title and description."""
    for line in script.read_text(encoding="utf-8").splitlines():
        if action := STEP.match(line):
            items = tuple(Item(match["name"], int(match["number"])) for match in OBJECT.finditer(line))
            yield Step(action["action"], items)


def find_changed_objects(graphs: Path) -> frozenset[int]:
    """Return the ids of objects whose states or relations differ between a task's first and last graph."""
    pair = json.loads(graphs.read_text(encoding="utf-8"))
    before, after = (list_graph_facts(pair[key]) for key in ("init_graph", "final_graph"))
    return frozenset(number for fact in before ^ after for number in (fact.subject, fact.other))


class Fact(NamedTuple):
    """A relation between two objects, or the states of one object (then `other` is the object itself)."""

    subject: int
    value: str
    other: int


def list_graph_facts(graph: dict[str, Any]) -> frozenset[Fact]:
    """Return the nodes and edges of a graph, in a form that can be compared across graphs."""
    nodes = (Fact(node["id"], " ".join(sorted(node["states"])), node["id"]) for node in graph["nodes"])
    edges = (Fact(edge["from_id"], edge["relation_type"], edge["to_id"]) for edge in graph["edges"])
    return frozenset((*nodes, *edges))


def change_one_step(plan: list[Step], choice: random.Random) -> list[Step]:
    """Return the plan with one step repeated, removed, or exchanged with the next one."""
    at = choice.randrange(len(plan))
    kind = choice.choice(("repeat", "leave out", "exchange"))
    if kind == "repeat" or len(plan) == 1:
        return [*plan[: at + 1], *plan[at:]]
    if kind == "leave out":
        return [*plan[:at], *plan[at + 1 :]]
    at = min(at, len(plan) - 2)
    return [*plan[:at], plan[at + 1], plan[at], *plan[at + 2 :]]


def write_answer(plan: list[Step]) -> str:
    """Return a plan in the form that prompts ask for: `"ACTION": ["name", "number", ...]`, in order."""
    return "{" + ", ".join(f'"{step.action}": [{write_step_arguments(step)}]' for step in plan) + "}"


def write_step_arguments(step: Step) -> str:
    """Return a step's object names and numbers in turn.

    A step without objects has a blank, because the reference package drops a step with `[]`.
    """
    return ", ".join(f'"{item.name}", "{item.number}"' for item in step.items) or " "
