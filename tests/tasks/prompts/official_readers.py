"""Readers of the prompts of action sequencing that the paper's data sets have."""

from __future__ import annotations

import re
from ast import literal_eval

from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.virtualhome.predicates import PREDICATE_OF_RELATION
from eai.tasks.task import Task
from tasks.prompts.readers import STORED
from tasks.prompts.sufficiency import Reader, Told

_HOUSE = "house.0"
_OBJECT = re.compile(r"([\w-]+), id: (\d+), properties: (\[.*\])")
_NODE = re.compile(r"([\w-]+), states: (\[.*\]), properties:.*")
_EDGE = re.compile(r"<([\w-]+)> \((\d+)\) is (\w+) to <([\w-]+)> \((\d+)\)")


def official_reader_of(benchmark: Benchmark, task: Task) -> Reader:
    """Return the reader of the data set's prompt about a task.

    Prompts of BEHAVIOR name kinds and no abilities: the reader knows which kinds can be opened, say.
    """
    if benchmark.domain.name == "virtualhome":
        return Reader(benchmark.domain, _virtualhome, STORED["virtualhome"])
    abilities = [
        (each.predicate, *[task.scene.objects[i].name for i in each.arguments])
        for each in task.initial.facts()
        if benchmark.domain.vocabulary.find_stored_predicate(each.predicate).static  # type: ignore[union-attr]
    ]

    def read(prompt: str) -> Told:
        told = _behavior(prompt)
        told.statements |= {each: None for each in abilities if {*each[1:]} <= told.kinds.keys()}
        return told

    return Reader(benchmark.domain, read, STORED["behavior"])


def _virtualhome(prompt: str) -> Told:
    """Read objects with ids; nodes have none, so a node is about all objects of its class.

    Few edges say in which room a thing is. The reader takes for granted that each thing is in the house.
    """
    told = Told()
    text = prompt.rpartition("\nObjects in the scene:\n")[2].partition("\nNode goals are:")[0]
    for line in text.splitlines():
        thing, node, edge = _OBJECT.fullmatch(line), _NODE.fullmatch(line), _EDGE.fullmatch(line)
        if thing is not None:
            name = f"{thing[1]}.{thing[2]}"
            told.kinds[name] = thing[1]
            for ability in literal_eval(thing[3]):
                told.state(ability, name)
        elif node is not None:
            for name in [name for name, kind in told.kinds.items() if kind == node[1]]:
                for state in literal_eval(node[2]):
                    told.state(state, name)
        elif edge is not None:
            predicate = "NEXT_TO" if edge[3] == "NEAR" else PREDICATE_OF_RELATION[edge[3]]
            told.state(predicate, f"{edge[1]}.{edge[2]}", f"{edge[4]}.{edge[5]}")
        elif line.strip("- ") and line not in ("The current environment state is", "Nodes:", "Edges:"):
            told.unread.append(line)
    told.state("ROOM", _HOUSE)
    for name in told.kinds:
        told.state("INSIDE", name, _HOUSE)
    return told


def _behavior(prompt: str) -> Told:
    """Read lists of words; a fact about the agent is where it stands."""
    told = Told()
    text = prompt.rpartition("initial environment state:\n")[2]
    for line in text.rpartition("interactable objects:\n")[2].splitlines():
        if line.startswith("{"):
            thing = literal_eval(line)
            told.kinds[thing["name"]] = thing["category"]
    for line in text.partition("\n\n")[0].splitlines():
        predicate, *names = literal_eval(line)
        if names[0].startswith("agent."):
            told.state("robot_on", names[1])
        elif predicate != "not":
            told.state(predicate, *names)
    return told
