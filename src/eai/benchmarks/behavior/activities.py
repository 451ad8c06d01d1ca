"""Read activities (household chores) of BEHAVIOR from BDDL files, and write planning problems.

The initial state of an activity has the facts of its problem file. It also has facts that hold for most
objects of the same category in the data set: abilities, sizes, furniture that stands on the floor of its
room, open cartons. If the data set has a problem of the same name, that problem's objects are used.

A planning problem has some goals of one activity. It has the objects in the goals, objects of categories
that help to reach them, and objects that initial facts relate to those objects. PDDL names have underscores
instead of the dots of BDDL.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import TypeAlias

import eai.logic.formula as f
from eai.base.grouping import group_pairs
from eai.benchmarks.behavior import predicates as p
from eai.benchmarks.behavior.convert import AGENT_CATEGORY
from eai.benchmarks.behavior.evidence import load_unpublished_facts
from eai.benchmarks.behavior.records import STATE_OF_ABILITY, BehaviorObject, BehaviorRecord
from eai.benchmarks.behavior.tasks import RELATIONS, BehaviorTask, build_task
from eai.logic.rewriting import map_terms, rename_objects
from eai.logic.traversal import find_object_names, find_predicates
from eai.pddl.model import OBJECT, PddlProblem, TypedName
from eai.pddl.writer import write_problem
from eai.tasks.problem_world import ConditionConverter, DomainAndProblemReader, make_domain_without_operators
from eai.tasks.source import TaskSet
from eai.tasks.task import Task
from eai.world.state import State

_ROOM = "inroom"
_ROOM_TYPE = "room"


_UsualObject: TypeAlias = tuple[str, str, tuple[str, ...]]
"""Model, synset (sense of a word) and abilities that most objects of a category have."""


def make_activity_problem_reader(tasks: TaskSet[BehaviorTask]) -> DomainAndProblemReader:
    """Return the names that problem files of activities may use, and a function that reads a problem.

    The function returns the initial state of the problem, and a translator of its conditions.

    Args:
        tasks: the tasks of the data set. Problems may name rooms that occur in the tasks.
    """
    records = [task.record for task in tasks.values()]
    objs = [obj for record in records for obj in record.objects]
    kinds = group_pairs((obj.category, (obj.model, obj.synset, obj.abilities)) for obj in objs)
    arities = {**dict.fromkeys(STATE_OF_ABILITY.values(), 1), **dict.fromkeys((*RELATIONS, _ROOM), 2)}
    facts = [atom for record in records for atom in record.problem.initial]
    rooms = {atom.arguments[1].name: _ROOM_TYPE for atom in facts if atom.predicate == _ROOM}
    published = {record.problem.name: record for record in records}
    usual = {category: Counter(objects).most_common(1)[0][0] for category, objects in kinds.items()}
    header = make_domain_without_operators(
        "behavior", dict.fromkeys((*kinds, AGENT_CATEGORY, _ROOM_TYPE), OBJECT), rooms, arities
    )
    return header, lambda problem: _build_state_and_condition_translator(
        problem, published.get(problem.name), usual
    )


def _build_state_and_condition_translator(
    problem: PddlProblem,
    published_record: BehaviorRecord | None,
    usual_object_by_category: Mapping[str, _UsualObject],
) -> tuple[State, ConditionConverter]:
    """Return a problem's initial state, and a function that translates its BDDL conditions.

    In translated conditions, objects have the names of the state's scene.

    Args:
        problem: the problem.
        published_record: the data set's task whose problem has the same name, or None.
        usual_object_by_category: category -> the most frequent model, synset and abilities of its objects.
    """
    published_objects = {
        (obj.instance, obj.category): obj
        for obj in (() if published_record is None else published_record.objects)
    }
    declared = [(item.name, item.type) for item in problem.objects]
    objs = [
        published_objects.get((n, kind)) or BehaviorObject(n, n, kind, *usual_object_by_category[kind])
        for n, kind in declared
        if kind not in (AGENT_CATEGORY, _ROOM_TYPE)
    ]
    record = BehaviorRecord(
        id=problem.name,
        activity=problem.name,
        definition=0,
        scene="" if published_record is None else published_record.scene,
        instruction="",
        objects=tuple(objs),
        problem=problem,
        plan=(),
        goal_options=(),
    )
    names = {obj.instance: obj.name for obj in objs}
    return build_task(
        record, load_unpublished_facts()
    ).initial, lambda formula: _write_condition_with_scene_names(formula, names)


def _write_condition_with_scene_names(formula: f.Formula, scene_names: Mapping[str, str]) -> f.Formula:
    """Return a BDDL condition in which objects have their names in the scene.

    Conditions about rooms become true, because states have no rooms.
    """
    match formula:
        case f.Atom(name) if name == _ROOM:
            return f.TRUE
        case f.Atom("onfloor", (obj, floor)) if obj.name not in scene_names and floor.name in scene_names:
            return f.Atom(p.robot_on.name, (f.Constant(scene_names[floor.name]),))
        case f.Not(operand):
            return f.Not(_write_condition_with_scene_names(operand, scene_names))
        case _:
            return rename_objects(formula, scene_names)


_CLEANERS = (
    "vacuum.n.04",
    "scrub_brush.n.01",
    "piece_of_cloth.n.01",
    "towel.n.01",
    "rag.n.01",
    "dishwasher.n.01",
    "dishtowel.n.01",
    "hand_towel.n.01",
)
_HELPERS: Mapping[str, tuple[str, ...]] = {
    "dusty": _CLEANERS,
    "stained": (*_CLEANERS, "sink.n.01"),
    "soaked": ("teapot.n.01", "sink.n.01"),
    "sliced": ("carving_knife.n.01", "countertop.n.01", "knife.n.01"),
    "frozen": ("electric_refrigerator.n.01",),
    "cooked": ("pan.n.01",),
}
"""Predicate of a goal -> categories of objects that can help to reach the goal.

The table is from ``pddl_generator.py`` in the paper's package.
"""


_AGENT = "agent"
"""Category of the robot in planning problems."""

_SAME = "same_obj"
"""Predicate that relates each object to itself.

Published operators test by this predicate whether two parameters are the same object. Our states lack the
predicate.
"""


def write_task_problem(task: Task, goals: Sequence[f.Formula]) -> str:
    """Return the text of a planning problem. Its goals are ground conditions on objects of the task."""
    if not isinstance(task, BehaviorTask):
        raise TypeError(f"task {task.id} is not a task of BEHAVIOR; only those have planning problems")
    instances = {obj.name: obj.instance for obj in task.record.objects}
    return write_problem(build_pddl_problem(task.record, [rename_objects(goal, instances) for goal in goals]))


def build_pddl_problem(record: BehaviorRecord, goals: Sequence[f.Formula]) -> PddlProblem:
    """Return the planning problem with the given goals.

    The goals are ground conditions, which name objects as the problem file does.
    """
    problem = record.problem
    categories = {item.name: item.type for item in problem.objects}
    needed = {name for goal in goals for name in find_object_names(goal)}
    helping = {category for name in find_predicates(*goals) for category in _HELPERS.get(name, ())}
    needed |= {name for name, category in categories.items() if category in helping}

    def select_facts_about_needed_objects(facts: Iterable[f.Atom]) -> list[f.Atom]:
        """Return the facts about objects that the goals name or need, except facts about rooms."""
        about = ((fact, {*find_object_names(fact)}) for fact in facts)
        return [fact for fact, names in about if names & needed and names <= categories.keys()]

    initial = select_facts_about_needed_objects(problem.initial)
    denied = select_facts_about_needed_objects(problem.denied)
    mentioned = needed.union(*map(find_object_names, (*initial, *denied)))
    initial += [f.Atom(_SAME, (f.Constant(name), f.Constant(name))) for name in sorted(mentioned)]
    pddl = {name: name.replace(".", "_") for name in categories}
    mentioned |= {name for name in categories if name.startswith(AGENT_CATEGORY)}
    types = {AGENT_CATEGORY: _AGENT}
    declared = [
        TypedName(pddl[name], types.get(category, category.replace(".", "_")))
        for name, category in categories.items()
        if name in mentioned
    ]
    return PddlProblem(
        name=record.activity,
        domain=problem.domain,
        objects=tuple(declared),
        initial=tuple([map_terms(fact, lambda term: f.Constant(pddl[term.name])) for fact in initial]),
        denied=tuple([map_terms(fact, lambda term: f.Constant(pddl[term.name])) for fact in denied]),
        goal=f.And(tuple(rename_objects(goal, pddl) for goal in goals)),
    )
