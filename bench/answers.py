"""Answers to the VirtualHome action sequencing tasks, made from the data set's own scripts.

One answer a task: the script's steps that use relevant objects only, with one seeded change. A step about
anything else would be a hallucination, and an untouched script is never executed: either would spare the
reference the work that is to be measured.
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
"""Actions that the reference rejects, and one on which it aborts when the object was not grabbed before."""


class Item(NamedTuple):
    """An object that a step names."""

    name: str
    number: int


class Step(NamedTuple):
    """An action with its objects."""

    action: str
    items: tuple[Item, ...]


def responses(package: Path, seed: int = 0) -> list[Response]:
    """One answer for each of the 342 tasks, in the data set's order; the same for the same seed.

    Args:
        package: the folder of the installed package `virtualhome_eval`.
        seed: chooses the changes.
    """
    tasks = json.loads((package / "resources" / "virtualhome" / "id2task.json").read_text(encoding="utf-8"))
    choice = random.Random(seed)  # noqa: S311 - reproducible, not secret
    return [Response(task_id, answer_text(changed(steps(package, task_id), choice))) for task_id in tasks]


def steps(package: Path, task_id: str) -> list[Step]:
    """The steps of a task's script that the reference can execute and that use relevant objects only."""
    script = package / DATA_SET / "executable_programs" / SCENE / f"file{task_id}.txt"
    usable = relevant(package / DATA_SET / "init_and_final_graphs" / SCENE / f"file{task_id}.json")
    return [
        step
        for step in script_steps(script)
        if step.action not in UNUSABLE and all(item.number in usable for item in step.items)
    ]


def script_steps(script: Path) -> Iterator[Step]:
    """All steps of a script file; its title and description are the lines without a bracket in front."""
    for line in script.read_text(encoding="utf-8").splitlines():
        if action := STEP.match(line):
            items = tuple(Item(match["name"], int(match["number"])) for match in OBJECT.finditer(line))
            yield Step(action["action"], items)


def relevant(graphs: Path) -> frozenset[int]:
    """Numbers of the objects of which a state or relation differs between a task's first and last graph."""
    pair = json.loads(graphs.read_text(encoding="utf-8"))
    before, after = (facts(pair[key]) for key in ("init_graph", "final_graph"))
    return frozenset(number for fact in before ^ after for number in (fact.subject, fact.other))


class Fact(NamedTuple):
    """A relation between two objects of a graph, or the states of one (then `other` is the object itself)."""

    subject: int
    value: str
    other: int


def facts(graph: dict[str, Any]) -> frozenset[Fact]:
    """The nodes and edges of a graph, comparable across graphs."""
    nodes = (Fact(node["id"], " ".join(sorted(node["states"])), node["id"]) for node in graph["nodes"])
    edges = (Fact(edge["from_id"], edge["relation_type"], edge["to_id"]) for edge in graph["edges"])
    return frozenset((*nodes, *edges))


def changed(plan: list[Step], choice: random.Random) -> list[Step]:
    """The plan with a step repeated, left out, or exchanged with the next one."""
    at = choice.randrange(len(plan))
    kind = choice.choice(("repeat", "leave out", "exchange"))
    if kind == "repeat" or len(plan) == 1:
        return [*plan[: at + 1], *plan[at:]]
    if kind == "leave out":
        return [*plan[:at], *plan[at + 1 :]]
    at = min(at, len(plan) - 2)
    return [*plan[:at], plan[at + 1], plan[at], *plan[at + 2 :]]


def answer_text(plan: list[Step]) -> str:
    """A plan as a model is asked to write it: `"ACTION": ["name", "number", ...]`, in order."""
    return "{" + ", ".join(f'"{step.action}": [{arguments(step)}]' for step in plan) + "}"


def arguments(step: Step) -> str:
    """A step's names and numbers in turn; a blank for none, because the reference drops a step with `[]`."""
    return ", ".join(f'"{item.name}", "{item.number}"' for item in step.items) or " "
