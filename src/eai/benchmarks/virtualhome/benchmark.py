"""VirtualHome as a benchmark: its official prompts, and the figures of its records that a store must show.

Of goal interpretation the data set ships a template instead of prompts. The reference prints Python sets in
it, whose order changes from run to run; here each has the order of the data set (reference:
``goal_interpretation/scripts/generate_prompts.py``, ``motion_planner.py``).

Relations among the goals of a task have the order of the goals. In 21 of the published prompts of subgoal
decomposition it is that of a Python set.
"""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from eai.abilities.notation.notation import Notation
from eai.abilities.protocol import Ability
from eai.base.source import open_bundle
from eai.base.store import ReportProgress, Store, ignore_progress
from eai.benchmarks import reference_wheel as packs
from eai.benchmarks.benchmark import Benchmark, DataSet, formats_of
from eai.benchmarks.errata import errata_of
from eai.benchmarks.packs import open_pack
from eai.benchmarks.published import official_prompts, open_virtualhome
from eai.benchmarks.registry import TITLES
from eai.benchmarks.virtualhome.domain import as_meant
from eai.benchmarks.virtualhome.notation import VirtualHomeGoals, VirtualHomeSubgoals
from eai.benchmarks.virtualhome.plan_notation import VirtualHomePlans
from eai.benchmarks.virtualhome.predicates import PREDICATE_OF_RELATION, room
from eai.benchmarks.virtualhome.records import PACK, ObjectRecord, TaskRecord, VirtualHome
from eai.benchmarks.virtualhome.records import open_virtualhome as open_records
from eai.benchmarks.virtualhome.tasks import VirtualHomeTask, build_tasks
from eai.benchmarks.virtualhome.tasks import open_tasks as open_virtualhome_tasks
from eai.logic.formula import Atom, Formula
from eai.tasks.english import english_of
from eai.tasks.goal_test import alternatives
from eai.tasks.prompts.prompt import Belief, GoalSection
from eai.tasks.source import Source, TaskSet, once_per_store
from eai.tasks.task import GoalKind, Task
from eai.world.relation import bits

if TYPE_CHECKING:
    from eai.tasks.wording import Wording

_LINE = "-----------------"
_HEADING_OF_ACTIONS = (
    "[Actions Must Include]: Actions are listed in the execution order, each line is one action to satisfy. "
    'If "A or B or ..." is presented in one line, then only one of them needs to be satisfied.'
)
_RELATIONS = {predicate: name for name, predicate in PREDICATE_OF_RELATION.items()}


def _for_plans(belief: Belief) -> str:
    """Objects by class, relations as scene graphs name them; every line of actions stands there twice."""
    task = belief.task
    classes = {thing.name: thing.category for thing in task.scene.objects}
    actions = [alternatives(goal) for goal in task.goals_of(GoalKind.ACTION)]
    required = ["There is no action requirement."]
    if actions:
        lines = [line for each in actions for line in (" or ".join(each), "|".join(each))]
        required = ["The following action(s) should be included:", *lines, _LINE]
    return "\n".join(
        [
            *(_sentence(goal.formula, classes) for goal in task.goals_of(GoalKind.STATE)),
            _LINE,
            "\n\nEdge goals are:",
            *(_sentence(goal.formula, classes) for goal in task.goals_of(GoalKind.RELATION)),
            _LINE,
            "\n\nAction goals are:",
            *required,
        ]
    )


def _for_subgoals(belief: Belief) -> str:
    """Objects by class and id, predicates as the vocabulary has them, and whether there are any actions."""
    task = belief.task
    lasting = [goal.formula for goal in task.goals if goal.kind is not GoalKind.ACTION]
    actions = [" or ".join(alternatives(goal)) for goal in task.goals_of(GoalKind.ACTION)]
    return "\n".join(
        [
            "[States]",
            *_or_none(f"{each.predicate}({', '.join(_names(each))})" for each in map(_atom, lasting)),
            _HEADING_OF_ACTIONS,
            *_or_none(actions),
            "\n## Necessity to Use Actions",
            "Yes" if actions else "No",
        ]
    )


GOAL_SECTIONS: Mapping[Ability, GoalSection] = {
    Ability.ACTION_SEQUENCING: GoalSection("Node goals are:\n", "\n\n\nPlease output the list", _for_plans),
    Ability.SUBGOAL_DECOMPOSITION: GoalSection("## Goal States\n", "\n\n## Output", _for_subgoals),
}
"""Where the official prompts state the goals."""


def _sentence(formula: Formula, classes: Mapping[str, str]) -> str:
    """``soap is ON to washing_machine``; a name that is no object's stays."""
    atom = _atom(formula)
    name, *others = [classes.get(each, each) for each in _names(atom)]
    first = f"{name} is {_RELATIONS.get(atom.predicate, atom.predicate)}"
    return " to ".join([first, *others])


def _atom(formula: Formula) -> Atom:
    if not isinstance(formula, Atom):
        raise TypeError(f"{formula} is no state and no relation")
    return formula


def _names(atom: Atom) -> list[str]:
    return [term.name for term in atom.arguments]


def _or_none(lines: Iterable[str]) -> list[str]:
    return list(lines) or ["None"]


def goal_interpretation_prompts(source: Source) -> dict[str, str]:
    """The prompt of every task, by id in data set order.

    Raises:
        DataError: the data cannot be obtained.
    """
    records = open_records(source)
    resources = open_pack(packs.RESOURCES, source)
    template = open_pack(packs.TEMPLATES, source).read(packs.TEMPLATE_MEMBER).decode()
    states = resources.read_json("object_states_full.json")
    possible = {**states, **{name.replace("_", ""): each for name, each in states.items()}}  # also so written
    pairs = resources.read_json("relation_object_pairs.json")
    base = {record.id: record for record in records.base.added_objects}
    # What is put in later is not searched for what was to be put in earlier: the reference's order.
    shared = (
        ("<relation_types>", str(resources.read_json("relation_types.json"))),
        ("<action_space>", str(resources.read_json("action_space.json"))),
        ("<rel_obj_pairs>", _braced(f"{name!r}: {_set_text(names)}" for name, names in pairs.items())),
    )
    return {
        task_id: _fill(template, (*_of_task(task, base, possible), *shared))
        for task_id, task in records.items()
    }


def _of_task(
    task: TaskRecord, base: Mapping[int, ObjectRecord], possible: Mapping[str, Sequence[str]]
) -> tuple[tuple[str, str], ...]:
    """Return the template filled for one task."""
    changed = (*task.initial.changed_objects, *task.initial.added_objects)
    objects = {**base, **{record.id: record for record in changed}}
    relevant = [objects[i] for i in task.relevant_in_order]
    lines = "".join(_line(record, possible) for record in relevant)
    # Name and description are lines of a file there, and keep their line ends.
    goal = f"Goal name: {task.title}\n\nGoal description: {task.description}\n\n"
    return (("<object_in_scene>", lines), ("<goal_str>", goal))


def _line(record: ObjectRecord, possible: Mapping[str, Sequence[str]]) -> str:
    states = [state.upper() for state in possible.get(record.class_name, ())]
    return f"{record.class_name}, initial states: {list(record.states)}, possible states: {states}\n"


def _set_text(names: Sequence[str]) -> str:
    return _braced(repr(name) for name in dict.fromkeys(names)) if names else "set()"


def _braced(parts: Iterable[str]) -> str:
    return "{" + ", ".join(parts) + "}"


def _fill(template: str, values: Sequence[tuple[str, str]]) -> str:
    for place, value in values:
        template = template.replace(place, value)
    return template


NAME = "virtualhome"


def open_demonstrations(path: Path, report: ReportProgress = ignore_progress) -> TaskSet[VirtualHomeTask]:
    """The 518 demonstrations in the reference package's wheel, or in a folder into which it is unpacked.

    The store has 342 of them alone. Reading them takes a minute.

    Raises:
        DataError: it is not there, or damaged.
    """
    with open_bundle(path) as wheel:
        from eai.benchmarks.virtualhome.convert import convert_demonstrations

        content = convert_demonstrations(wheel, report)
    return build_tasks(VirtualHome(content, hashlib.sha256(content).hexdigest()))


def _find_surroundings(task: Task) -> Iterator[int]:
    """Yield the rooms and the objects of the annotated plan.

    In a pair of tasks, the objects of the plan would reveal which task has a plan.
    """
    yield from bits(task.initial.mask(room.name))
    if task.missing is None and task.is_told_by_goals:
        for action in task.script:
            yield from action.arguments


def wording(ability: Ability) -> Wording:
    """As declared; but goal interpretation speaks of classes, and names relations as scene graphs do."""
    from eai.tasks.wording import Wording

    said = Wording.of(as_meant()).predicates
    if ability is not Ability.GOAL_INTERPRETATION:
        return Wording(as_meant(), said, surroundings=_find_surroundings)
    return Wording(as_meant(), said, _RELATIONS, lambda task, index: task.scene.objects[index].category)


open_tasks = once_per_store(open_virtualhome_tasks)
"""Opens the 342 tasks."""

open_operators = once_per_store(open_virtualhome)
"""Opens the 296 tasks of transition modeling."""


def virtualhome() -> Benchmark:
    """The benchmark. Subgoals are asked for in the tasks that have a goal in temporal logic."""
    return Benchmark(
        NAME,
        as_meant(),
        open_tasks,
        Notation(
            VirtualHomePlans(),
            VirtualHomeGoals(),
            VirtualHomeSubgoals(),
            formats=formats_of("eai.benchmarks.virtualhome"),
            wordings=wording,
            english=english_of("eai.benchmarks.virtualhome"),
        ),
        DataSet(
            TITLES[NAME],
            errata_of(NAME),
            official_prompts(NAME, {Ability.GOAL_INTERPRETATION: goal_interpretation_prompts}),
            goal_sections=GOAL_SECTIONS,
            task_id_of=packs.published_task,
            own_tasks={Ability.TRANSITION_MODELING: open_operators},
            asks={Ability.SUBGOAL_DECOMPOSITION: lambda task: task.temporal_goal is not None},
            own_figures=annotated_figures,
            open_demonstrations=open_demonstrations,
        ),
    )


def annotated_figures(source: Source) -> dict[str, tuple[int, str]]:
    """The figures of the published data set; DataError if it cannot be had."""
    resources = open_pack(packs.RESOURCES, source)
    tasks = open_records(source)
    operators = resources.read_json("gold_action.json")
    return count_annotated(tasks, resources.read_json("success_task.json"), len(operators))


def count_annotated(
    tasks: VirtualHome, transition_tasks: Collection[str], operators: int
) -> dict[str, tuple[int, str]]:
    """Return the figures of records by label, each with a note.

    Args:
        tasks: all tasks.
        transition_tasks: ids of the tasks of transition modeling.
        operators: number of annotated operators.
    """
    records = tuple(tasks.values())
    instructed = [each for each in records if each.node_goals or each.edge_goals or each.action_goals]
    lost = [task for task in records if len(set(task.edge_goals)) > 1]
    state = sum(len(task.node_goals) for task in records)
    relation = sum(len(task.edge_goals) for task in records)
    action = sum(len(task.action_goals) for task in records)
    return {
        "task names": (len({task.title for task in records}), "distinct names that tasks share"),
        "tasks": (len(records), "annotated; the denominator of goal interpretation"),
        "instructions": (
            len(instructed),
            f"tasks that have a goal; {len(records) - len(instructed)} have none",
        ),
        "action sequencing tasks": (
            len(records) - len(lost),
            f"under protocol eai-1.0.5: tasks less the {len(lost)} with two or more distinct relation goals, "
            "which the reference drops",
        ),
        "transition modeling tasks": (len(transition_tasks), _left_out(instructed, transition_tasks)),
        "goals": (state + relation + action, "of all tasks, as annotated, duplicates included"),
        "state goals": (state, "an object is in a state"),
        "relation goals": (relation, "two objects stand in a relation"),
        "action goals": (action, "an action was done, possibly one of several alternatives"),
        "action steps": (sum(len(task.script) for task in instructed), "of the annotated scripts"),
        "transition models": (operators, "annotated operators"),
    }


def _left_out(instructed: Iterable[TaskRecord], transition_tasks: Collection[str]) -> str:
    titles = Counter(task.title for task in instructed if task.id not in transition_tasks)
    names = ", ".join(f"{title} ({count})" for title, count in titles.most_common())
    return f"instructions less those the reference leaves out: {names or 'none'}"


PUBLISHED_COUNTS: Mapping[str, int | float] = {
    "task names": 26,
    "tasks": 342,
    "instructions": 338,
    "action sequencing tasks": 305,
    "transition modeling tasks": 296,
    "goals": 801,
    "state goals": 340,
    "relation goals": 299,
    "action goals": 162,
    "action steps": 2960,
    "transition models": 33,
}
"""Figures of the published data set, by their labels."""


def check_tasks(store: Store, counts: Mapping[str, int | float] | None = None) -> Iterator[str]:
    """Yield the figures that are not as published. All packs must be there.

    Args:
        store: the folder of packs.
        counts: label of a statistic -> the figure it should show; that of the published data set if None.
    """
    counts = PUBLISHED_COUNTS if counts is None else counts
    tasks, resources = VirtualHome.of(store.open(PACK)), store.open(packs.RESOURCES)
    operators = resources.read_json("gold_action.json")
    figures = count_annotated(tasks, resources.read_json("success_task.json"), len(operators))
    for label, (value, _) in figures.items():
        if counts.get(label, value) != value:
            yield f"{label}: {value}, expected {counts[label]}"
