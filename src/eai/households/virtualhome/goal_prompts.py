"""VirtualHome's official prompts: how they state goals, and those that the data set ships as a template only.

The template is that of goal interpretation. The reference prints Python sets in it, whose order changes from
run to run; here each has the order of the data set (reference:
``goal_interpretation/scripts/generate_prompts.py``, ``motion_planner.py``).

Relations among the goals of a task have the order of the goals. In 21 of the published prompts of subgoal
decomposition it is that of a Python set.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from eai.abilities.goal_test import alternatives
from eai.abilities.protocol import Ability
from eai.abilities.task import GoalKind
from eai.data.progress import Report, silent
from eai.data.store import Store
from eai.households.packs import RESOURCES, TEMPLATES, open_published
from eai.households.published_files import TEMPLATE_MEMBER
from eai.households.virtualhome.records import ObjectRecord, TaskRecord, open_virtualhome
from eai.households.virtualhome.slot_order import union_order
from eai.households.virtualhome.tasks import PREDICATE_OF_RELATION
from eai.logic.formula import Atom, Formula
from eai.prompts.prompt import Belief, GoalSection

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
    said = f"{name} is {_RELATIONS.get(atom.predicate, atom.predicate)}"
    return " to ".join([said, *others])


def _atom(formula: Formula) -> Atom:
    if not isinstance(formula, Atom):
        raise TypeError(f"{formula} is no state and no relation")
    return formula


def _names(atom: Atom) -> list[str]:
    return [term.name for term in atom.arguments]


def _or_none(lines: Iterable[str]) -> list[str]:
    return list(lines) or ["None"]


def goal_interpretation_prompts(store: Store | None = None, *, report: Report = silent) -> dict[str, str]:
    """The prompt of every task, by id in data set order.

    Raises:
        DataError: the data cannot be obtained.
    """
    records = open_virtualhome(store, report=report)
    resources = open_published(RESOURCES, store, report=report)
    template = open_published(TEMPLATES, store, report=report).read(TEMPLATE_MEMBER).decode()
    possible = _possible_states(resources.read_json("object_states_full.json"))
    pairs = resources.read_json("relation_object_pairs.json")
    base = {record.id: record for record in records.base.objects}
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
    relevant = [objects[i] for i in union_order(task.relevant_from_nodes, task.relevant_from_edges)]
    lines = "".join(_line(record, possible) for record in relevant)
    # Name and description are lines of a file there, and keep their line ends.
    goal = f"Goal name: {task.title}\n\nGoal description: {task.description}\n\n"
    return (("<object_in_scene>", lines), ("<goal_str>", goal))


def _line(record: ObjectRecord, possible: Mapping[str, Sequence[str]]) -> str:
    states = [state.upper() for state in possible.get(record.class_name, ())]
    return f"{record.class_name}, initial states: {list(record.states)}, possible states: {states}\n"


def _possible_states(states: Mapping[str, Sequence[str]]) -> dict[str, Sequence[str]]:
    """The possible states by class name, which may be written without its underscores."""
    table = dict(states)
    for name in states:
        table[name.replace("_", "")] = table[name]
    return table


def _set_text(names: Sequence[str]) -> str:
    return _braced(repr(name) for name in dict.fromkeys(names)) if names else "set()"


def _braced(parts: Iterable[str]) -> str:
    return "{" + ", ".join(parts) + "}"


def _fill(template: str, values: Sequence[tuple[str, str]]) -> str:
    for place, value in values:
        template = template.replace(place, value)
    return template
