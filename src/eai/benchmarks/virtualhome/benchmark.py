"""The benchmark VirtualHome, its official prompts, and a comparison of the stored data with published counts.

For goal interpretation, the data set has a template instead of prompts. The paper's package fills the
template with Python sets, so the order of the values changes from run to run (see its
``goal_interpretation/scripts/generate_prompts.py`` and ``motion_planner.py``). Here the values of each set
have the order of the data set.

The relations in the goal section of a prompt have the order of the goals. In 21 published prompts of subgoal
decomposition, however, relations have the order of a Python set.
"""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from eai.abilities.notation.notation import Notation
from eai.abilities.protocol import Ability
from eai.base.source import open_archive_files
from eai.base.store import DataPackStore, ReportProgress, ignore_progress
from eai.benchmarks import reference_wheel as packs
from eai.benchmarks.benchmark import Benchmark, DataSet, read_answer_formats, read_texts_for_short_prompts
from eai.benchmarks.errata import load_errata
from eai.benchmarks.packs import open_pack
from eai.benchmarks.published import make_reader_of_published_prompts, open_virtualhome_transition_tasks
from eai.benchmarks.registry import TITLES
from eai.benchmarks.virtualhome.domain import make_domain_with_checks_in_paper_order
from eai.benchmarks.virtualhome.notation import VirtualHomeGoalNotation, VirtualHomeSubgoalNotation
from eai.benchmarks.virtualhome.plan_notation import VirtualHomePlanNotation
from eai.benchmarks.virtualhome.predicates import PREDICATE_OF_RELATION, room
from eai.benchmarks.virtualhome.records import PACK, SceneObjectRecord, TaskRecord, VirtualHomeRecords
from eai.benchmarks.virtualhome.records import open_records as open_records
from eai.benchmarks.virtualhome.tasks import VirtualHomeTask, build_tasks
from eai.benchmarks.virtualhome.tasks import open_tasks as open_virtualhome_tasks
from eai.logic.formula import Atom, Formula
from eai.tasks.english import read_english_words
from eai.tasks.goal_test import list_actions_that_meet_goal
from eai.tasks.prompts.prompt import BelievedTask, GoalSection
from eai.tasks.source import Source, TaskSet, cache_opened_tasks_per_data_folder
from eai.tasks.task import GoalKind, Task
from eai.world.relation import iterate_bits

if TYPE_CHECKING:
    from eai.tasks.wording import PromptAndAnswerWording

_LINE = "-----------------"
_ACTIONS_HEADING = (
    "[Actions Must Include]: Actions are listed in the execution order, each line is one action to satisfy. "
    'If "A or B or ..." is presented in one line, then only one of them needs to be satisfied.'
)
_RELATIONS = {predicate: name for name, predicate in PREDICATE_OF_RELATION.items()}


def _format_goals_of_plan_prompt(belief: BelievedTask) -> str:
    """Return the text of the goals in a prompt for a plan.

    Objects are named by their classes, and relations as in scene graphs. For each required action, one line
    has its alternatives joined by `or`, and the next line has them joined by `|`.
    """
    task = belief.task
    classes = {obj.name: obj.category for obj in task.scene.objects}
    actions = [list_actions_that_meet_goal(goal) for goal in task.get_goals_of_kind(GoalKind.ACTION)]
    required = ["There is no action requirement."]
    if actions:
        lines = [line for names in actions for line in (" or ".join(names), "|".join(names))]
        required = ["The following action(s) should be included:", *lines, _LINE]
    return "\n".join(
        [
            *(_format_sentence(goal.formula, classes) for goal in task.get_goals_of_kind(GoalKind.STATE)),
            _LINE,
            "\n\nEdge goals are:",
            *(_format_sentence(goal.formula, classes) for goal in task.get_goals_of_kind(GoalKind.RELATION)),
            _LINE,
            "\n\nAction goals are:",
            *required,
        ]
    )


def _format_goals_of_subgoal_prompt(belief: BelievedTask) -> str:
    """Return the text of the goals, with class and id of each object, and whether actions are required."""
    task = belief.task
    lasting = [goal.formula for goal in task.goals if goal.kind is not GoalKind.ACTION]
    actions = [
        " or ".join(list_actions_that_meet_goal(goal)) for goal in task.get_goals_of_kind(GoalKind.ACTION)
    ]
    return "\n".join(
        [
            "[States]",
            *_list_lines_or_placeholder(
                f"{atom.predicate}({', '.join(_get_argument_names(atom))})"
                for atom in map(_require_atom, lasting)
            ),
            _ACTIONS_HEADING,
            *_list_lines_or_placeholder(actions),
            "\n## Necessity to Use Actions",
            "Yes" if actions else "No",
        ]
    )


GOAL_SECTIONS: Mapping[Ability, GoalSection] = {
    Ability.ACTION_SEQUENCING: GoalSection(
        "Node goals are:\n", "\n\n\nPlease output the list", _format_goals_of_plan_prompt
    ),
    Ability.SUBGOAL_DECOMPOSITION: GoalSection(
        "## Goal States\n", "\n\n## Output", _format_goals_of_subgoal_prompt
    ),
}
"""Ability -> section of the official prompts that states the goals."""


def _format_sentence(formula: Formula, classes: Mapping[str, str]) -> str:
    """Return a goal as a sentence such as ``soap is ON to washing_machine``.

    Objects of the scene have the names of their classes. Other arguments stay unchanged.
    """
    atom = _require_atom(formula)
    name, *others = [classes.get(argument, argument) for argument in _get_argument_names(atom)]
    first = f"{name} is {_RELATIONS.get(atom.predicate, atom.predicate)}"
    return " to ".join([first, *others])


def _require_atom(formula: Formula) -> Atom:
    if not isinstance(formula, Atom):
        raise TypeError(f"goal {formula}: expected one state or relation, because prompts state only these")
    return formula


def _get_argument_names(atom: Atom) -> list[str]:
    return [term.name for term in atom.arguments]


def _list_lines_or_placeholder(lines: Iterable[str]) -> list[str]:
    return list(lines) or ["None"]


def render_goal_interpretation_prompts(source: Source) -> dict[str, str]:
    """Return the prompts of goal interpretation by task id, in the order of the data set.

    Raises:
        DataError: the data cannot be obtained.
    """
    records = open_records(source)
    resources = open_pack(packs.RESOURCES, source)
    template = open_pack(packs.TEMPLATES, source).read_member(packs.TEMPLATE_MEMBER).decode()
    states = resources.read_json("object_states_full.json")
    possible = {
        **states,
        **{name.replace("_", ""): values for name, values in states.items()},
    }  # both spellings occur
    pairs = resources.read_json("relation_object_pairs.json")
    base = {record.id: record for record in records.base.added_objects}
    # the paper's package replaces placeholders in this order, which matters if an inserted text has one
    shared = (
        ("<relation_types>", str(resources.read_json("relation_types.json"))),
        ("<action_space>", str(resources.read_json("action_space.json"))),
        (
            "<rel_obj_pairs>",
            _put_in_braces(f"{name!r}: {_format_set(names)}" for name, names in pairs.items()),
        ),
    )
    return {
        task_id: _fill_template(
            template, (*_pair_placeholders_with_replacement_texts(task, base, possible), *shared)
        )
        for task_id, task in records.items()
    }


def _pair_placeholders_with_replacement_texts(
    task: TaskRecord,
    shared_objects: Mapping[int, SceneObjectRecord],
    possible_states: Mapping[str, Sequence[str]],
) -> tuple[tuple[str, str], ...]:
    """Return pairs: a placeholder of the template, and the text that replaces it for one task."""
    changed = (*task.initial.changed_objects, *task.initial.added_objects)
    objects = {**shared_objects, **{record.id: record for record in changed}}
    relevant = [objects[i] for i in task.relevant_object_ids]
    lines = "".join(_format_object(record, possible_states) for record in relevant)
    # The paper's package reads title and description as lines of a file, with their line ends.
    goal = f"Goal name: {task.title}\n\nGoal description: {task.description}\n\n"
    return (("<object_in_scene>", lines), ("<goal_str>", goal))


def _format_object(record: SceneObjectRecord, possible_states: Mapping[str, Sequence[str]]) -> str:
    states = [state.upper() for state in possible_states.get(record.class_name, ())]
    return f"{record.class_name}, initial states: {list(record.states)}, possible states: {states}\n"


def _format_set(names: Sequence[str]) -> str:
    return _put_in_braces(repr(name) for name in dict.fromkeys(names)) if names else "set()"


def _put_in_braces(parts: Iterable[str]) -> str:
    return "{" + ", ".join(parts) + "}"


def _fill_template(template: str, values: Sequence[tuple[str, str]]) -> str:
    for placeholder, value in values:
        template = template.replace(placeholder, value)
    return template


NAME = "virtualhome"


def open_demonstrations(path: Path, report: ReportProgress = ignore_progress) -> TaskSet[VirtualHomeTask]:
    """Return all 518 demonstrations (plans that people wrote) in the paper's wheel or its unpacked files.

    The data store has only 342 demonstrations. Reading all of them takes a minute.

    Raises:
        DataError: the wheel is absent or damaged.
    """
    with open_archive_files(path) as wheel:
        from eai.benchmarks.virtualhome.convert import convert_demonstrations_to_task_lines

        content = convert_demonstrations_to_task_lines(wheel, report)
    return build_tasks(VirtualHomeRecords(content, hashlib.sha256(content).hexdigest()))


def _find_rooms_and_objects_of_plan(task: Task) -> Iterator[int]:
    """Yield the indices of objects that prompts list in addition to the relevant objects.

    Such objects are rooms, and objects of the annotated plan. Objects of the plan are left out if an answer
    may call the task impossible, or ask which object is meant. Such tasks are made in pairs. If only one of
    the two has a plan, its listed objects would tell a model which task this is.
    """
    yield from iterate_bits(task.initial.mask(room.name))
    if not task.allows_declining_answers:
        for action in task.script:
            yield from action.arguments


def make_wording(ability: Ability) -> PromptAndAnswerWording:
    """Return the names of objects and predicates that prompts of an ability use.

    Prompts of goal interpretation use classes of objects, and relations as in scene graphs.
    """
    from eai.tasks.wording import PromptAndAnswerWording

    predicates = PromptAndAnswerWording.from_domain(make_domain_with_checks_in_paper_order()).predicates
    if ability is not Ability.GOAL_INTERPRETATION:
        return PromptAndAnswerWording(
            make_domain_with_checks_in_paper_order(), predicates, surroundings=_find_rooms_and_objects_of_plan
        )
    return PromptAndAnswerWording(
        make_domain_with_checks_in_paper_order(),
        predicates,
        _RELATIONS,
        lambda task, index: task.scene.objects[index].category,
    )


open_tasks = cache_opened_tasks_per_data_folder(open_virtualhome_tasks)
"""Returns the 342 tasks of VirtualHome."""

open_operators = cache_opened_tasks_per_data_folder(open_virtualhome_transition_tasks)
"""Returns VirtualHome's 296 tasks of transition modeling."""


GOAL_LABELS: Mapping[str, str] = {
    "INSIDE": "transport",
    "INSIDE character": "",
    "ONTOP": "transport",
    "ONTOP character": "",
    "NEXT_TO": "transport relational-goal",
    "NEXT_TO character": "",
    "HOLDS_RH": "transport",
    "HOLDS_LH": "transport",
    "GRAB": "transport",
    "OPEN": "articulated",
    "CLOSED": "articulated",
    "PLUGGED_IN": "precision-fit",
    "PLUGGED_OUT": "precision-fit",
    "ON": "device-operation",
    "OFF": "device-operation",
    "CLEAN": "surface-treatment",
    "DIRTY": "surface-treatment",
    "RINSE": "surface-treatment",
    "SCRUB": "surface-treatment",
    "WASH": "surface-treatment",
    "WIPE": "surface-treatment",
    "POUR": "fluid-granular",
}
"""Goal predicate or action -> labels of tasks, such as ``transport`` (`eai.benchmarks.labels`)."""


def virtualhome() -> Benchmark:
    """Return the benchmark VirtualHome. Only tasks with a temporal goal have questions about subgoals."""
    return Benchmark(
        NAME,
        make_domain_with_checks_in_paper_order(),
        open_tasks,
        Notation(
            VirtualHomePlanNotation(),
            VirtualHomeGoalNotation(),
            VirtualHomeSubgoalNotation(),
            formats=read_answer_formats("eai.benchmarks.virtualhome"),
            short_texts=read_texts_for_short_prompts("eai.benchmarks.virtualhome"),
            wordings=make_wording,
            english=read_english_words("eai.benchmarks.virtualhome"),
        ),
        DataSet(
            TITLES[NAME],
            load_errata(NAME),
            make_reader_of_published_prompts(
                NAME, {Ability.GOAL_INTERPRETATION: render_goal_interpretation_prompts}
            ),
            goal_sections=GOAL_SECTIONS,
            task_id_of=packs.find_task_id,
            own_tasks={Ability.TRANSITION_MODELING: open_operators},
            asks={Ability.SUBGOAL_DECOMPOSITION: lambda task: task.temporal_goal is not None},
            own_figures=compute_data_set_statistics_with_notes,
            open_demonstrations=open_demonstrations,
            labels=GOAL_LABELS,
        ),
    )


def compute_data_set_statistics_with_notes(source: Source) -> dict[str, tuple[int, str]]:
    """Return statistics of the published data set: label -> number, and a note on what the number means.

    Raises DataError if the data cannot be obtained.
    """
    resources = open_pack(packs.RESOURCES, source)
    tasks = open_records(source)
    operators = resources.read_json("gold_action.json")
    return compute_record_statistics_with_notes(
        tasks, resources.read_json("success_task.json"), len(operators)
    )


def compute_record_statistics_with_notes(
    tasks: VirtualHomeRecords, transition_task_ids: Collection[str], operator_count: int
) -> dict[str, tuple[int, str]]:
    """Return statistics of the tasks: label -> number, and a note on what the number means.

    Args:
        tasks: all tasks.
        transition_task_ids: ids of the tasks of transition modeling.
        operator_count: number of annotated operators.
    """
    records = tuple(tasks.values())
    instructed = [task for task in records if task.node_goals or task.edge_goals or task.action_goals]
    dropped = [task for task in records if len(set(task.edge_goals)) > 1]
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
            len(records) - len(dropped),
            f"under protocol eai-1.0.5: tasks less the {len(dropped)} with two or more distinct relation "
            "goals, which the reference drops",
        ),
        "transition modeling tasks": (
            len(transition_task_ids),
            _describe_tasks_left_out_of_transition_tasks(instructed, transition_task_ids),
        ),
        "goals": (state + relation + action, "of all tasks, as annotated, duplicates included"),
        "state goals": (state, "an object is in a state"),
        "relation goals": (relation, "two objects stand in a relation"),
        "action goals": (action, "an action was done, possibly one of several alternatives"),
        "action steps": (sum(len(task.script) for task in instructed), "of the annotated scripts"),
        "transition models": (operator_count, "annotated operators"),
    }


def _describe_tasks_left_out_of_transition_tasks(
    tasks_with_goals: Iterable[TaskRecord], transition_task_ids: Collection[str]
) -> str:
    titles = Counter(task.title for task in tasks_with_goals if task.id not in transition_task_ids)
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
"""Label -> number of tasks, goals, steps or operators in the published data set."""


def list_unexpected_counts(
    store: DataPackStore, expected_counts: Mapping[str, int | float] | None = None
) -> Iterator[str]:
    """Yield a line for each count in the stored data that differs from the expected count.

    All data must be installed.

    Args:
        store: the folder of packs (data packages).
        expected_counts: expected counts by label; if None, those of the published data set.
    """
    expected_counts = PUBLISHED_COUNTS if expected_counts is None else expected_counts
    tasks, resources = VirtualHomeRecords.from_pack(store.open_pack(PACK)), store.open_pack(packs.RESOURCES)
    operators = resources.read_json("gold_action.json")
    counts = compute_record_statistics_with_notes(
        tasks, resources.read_json("success_task.json"), len(operators)
    )
    for label, (count, _) in counts.items():
        if expected_counts.get(label, count) != count:
            yield f"{label}: {count}, expected {expected_counts[label]}"
