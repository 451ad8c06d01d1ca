"""BEHAVIOR's own language of activities: BDDL problems as scenes, by what the data set says of their objects.

What a file states holds. What none states is as in the data set: what objects are good for and how large they
are goes by their category; furniture stands on the floor of its room; cartons are open. The objects of a
problem that has the name of one of the data set are those of that.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping

import eai.logic.formula as f
from eai.households.behavior import predicates as p
from eai.households.behavior.convert import AGENT_CATEGORY
from eai.households.behavior.evidence import load_evidence
from eai.households.behavior.records import STATE_OF_ABILITY, BehaviorObject, BehaviorRecord
from eai.households.behavior.tasks import RELATIONS, BehaviorTask, build_task
from eai.logic.bddl import Declaration, Problem
from eai.logic.renaming import rename_objects
from eai.pddl.model import PddlProblem, TypedName
from eai.tasks.problem_world import Posed, header_of
from eai.tasks.source import TaskSet

_ROOM = "inroom"


class Activities:
    """How BDDL problems of activities are read.

    Args:
        tasks: those of the data set.

    Attributes:
        header: the categories, rooms and predicates that problems may name.
    """

    def __init__(self, tasks: TaskSet[BehaviorTask]) -> None:
        records = [task.record for task in tasks.values()]
        self._records = {record.problem.name: record for record in records}
        kinds: dict[str, Counter[tuple[str, str, tuple[str, ...]]]] = {}
        for thing in (thing for record in records for thing in record.objects):
            kinds.setdefault(thing.category, Counter())[thing.model, thing.synset, thing.abilities] += 1
        self._kinds = {category: count.most_common(1)[0][0] for category, count in kinds.items()}
        arities = {**dict.fromkeys(STATE_OF_ABILITY.values(), 1), **dict.fromkeys((*RELATIONS, _ROOM), 2)}
        rooms = {name: "room" for record in records for name in _rooms(record)}
        self.header = header_of("behavior", (*self._kinds, AGENT_CATEGORY, "room"), rooms, arities)

    def pose(self, problem: PddlProblem) -> Posed:
        """A problem of these names."""
        known = self._records.get(problem.name)
        things = tuple([self._thing(item, known) for item in problem.objects if item.type != AGENT_CATEGORY])
        record = BehaviorRecord(
            id=problem.name,
            activity=problem.name,
            definition=0,
            scene="" if known is None else known.scene,
            instruction="",
            goal_sentences=(),
            objects=things,
            problem=Problem(
                problem.name,
                problem.domain,
                tuple([Declaration(item.name, item.type) for item in problem.objects]),
                problem.initial,
                problem.goal,
            ),
            plan=(),
        )
        names = {thing.instance: thing.name for thing in things}
        initial = build_task(record, (), load_evidence()).initial
        return Posed(initial, lambda formula: _meaning(formula, names))

    def _thing(self, item: TypedName, known: BehaviorRecord | None) -> BehaviorObject:
        """An object: that of the data set's problem if it is there, else the usual one of its category."""
        for thing in () if known is None else known.objects:
            if (thing.instance, thing.category) == (item.name, item.type):
                return thing
        return BehaviorObject(item.name, item.name, item.type, *self._kinds[item.type])


def _rooms(record: BehaviorRecord) -> list[str]:
    atoms = (each for each in record.problem.init if isinstance(each, f.Atom))
    return [atom.arguments[1].name for atom in atoms if atom.predicate == _ROOM]


def _meaning(formula: f.Formula, names: Mapping[str, str]) -> f.Formula:
    """A condition about objects by name; of rooms no state tells anything."""
    match formula:
        case f.Atom(name) if name == _ROOM:
            return f.TRUE
        case f.Atom("onfloor", (thing, floor)) if thing.name not in names and floor.name in names:
            return f.Atom(p.robot_on.name, (f.Constant(names[floor.name]),))
        case f.Not(operand):
            return f.Not(_meaning(operand, names))
        case _:
            return rename_objects(formula, names)
