"""BEHAVIOR as a benchmark."""

from __future__ import annotations

from eai.abilities.protocol import Ability
from eai.abilities.task import Task
from eai.abilities.transition_modeling.task import TransitionTask
from eai.benchmark.benchmark import Benchmark
from eai.benchmark.errata import errata_of
from eai.benchmark.formats import formats_of
from eai.english.english import english_of
from eai.households.behavior.activities import Activities
from eai.households.behavior.domain import as_meant
from eai.households.behavior.goal_notation import BehaviorGoals
from eai.households.behavior.goal_section import GOAL_SECTIONS
from eai.households.behavior.planning_problems import PlanningProblems, problem_text
from eai.households.behavior.predicates import GOAL_RELATIONS, GOAL_STATES
from eai.households.behavior.subgoal_notation import BehaviorSubgoals
from eai.households.behavior.tasks import BehaviorTask
from eai.households.behavior.tasks import open_tasks as open_behavior_tasks
from eai.households.gold_operators import open_behavior
from eai.households.identifiers import published_task
from eai.households.published_prompts import OfficialPrompts
from eai.prompts.wording import ObjectName, Wording, declared_name
from eai.tasks.source import Source, TaskSet, once_per_store

_GOAL_PREDICATES = (*(state.name for state in GOAL_STATES), *(each.name for each in GOAL_RELATIONS))
_HANDS = {"in_right_hand": "holds_rh", "in_left_hand": "holds_lh"}


NAME = "behavior"


def wording(ability: Ability) -> Wording:
    """The words for an ability: subgoals also speak of hands, goal interpretation names instances."""
    if ability is Ability.SUBGOAL_DECOMPOSITION:
        written_as = {**_HANDS, "toggled_on": "toggledon"}
        return Wording(as_meant(), (*_GOAL_PREDICATES, *_HANDS), written_as, _dotted_name)
    names: ObjectName = _instance_name if ability is Ability.GOAL_INTERPRETATION else declared_name
    return Wording(as_meant(), _GOAL_PREDICATES, {}, names)


def _dotted_name(task: Task, index: int) -> str:
    """``rag_51`` as subgoals write it: ``rag.51``."""
    return ".".join(declared_name(task, index).rsplit("_", 1))


def _instance_name(task: Task, index: int) -> str:
    """The name of an object in its problem file: ``rag.n.01_1``."""
    name = declared_name(task, index)
    if not isinstance(task, BehaviorTask):
        return name
    return next((thing.instance for thing in task.record.objects if thing.name == name), name)


@once_per_store
def open_tasks(source: Source) -> TaskSet[BehaviorTask]:
    """The 100 tasks."""
    return open_behavior_tasks(source.store, report=source.report)


@once_per_store
def open_operators(source: Source) -> TaskSet[TransitionTask]:
    """The 100 tasks of transition modeling."""
    return open_behavior(source.store, report=source.report)


def behavior() -> Benchmark:
    """The benchmark."""
    return Benchmark(
        name=NAME,
        title="BEHAVIOR",
        domain=as_meant(),
        open_tasks=open_tasks,
        goals=BehaviorGoals(),
        subgoals=BehaviorSubgoals(),
        open_operators=open_operators,
        wordings=wording,
        also_observed=("in_left_hand", "in_right_hand", "robot_on"),
        formats=formats_of("eai.households.behavior"),
        published_prompts=OfficialPrompts(NAME),
        errata=errata_of(NAME),
        problem_of=problem_text,
        open_bddl=lambda source: Activities(open_tasks(source)),
        open_pddl=lambda source: PlanningProblems(Activities(open_tasks(source))),
        goal_sections=GOAL_SECTIONS,
        task_id_of=published_task,
        english=english_of("eai.households.behavior"),
        planner_seconds=200,
    )
