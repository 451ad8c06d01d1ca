"""Makers of mutated answers to the tasks of a suite."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TypeAlias

from differential.mutated_goals import behavior_goals, virtualhome_goals
from differential.mutated_operators import operators
from differential.mutated_plans import behavior_plan, virtualhome_plan
from differential.mutated_subgoals import Words, subgoals
from differential.mutations import Dice
from eai.abilities.protocol import Ability
from eai.benchmarks.behavior import tasks as behavior
from eai.benchmarks.behavior.notation import BehaviorSubgoalNotation
from eai.benchmarks.gold_answers import AnswersByTask, open_gold_answers
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.virtualhome import tasks as virtualhome
from eai.benchmarks.virtualhome.notation import SUBGOAL_ACTIONS, VirtualHomeSubgoalNotation
from eai.world.state import Scene

Maker: TypeAlias = Callable[[Dice, str], str]
"""Makes an answer to the task with an id."""

BESIDES = {"necessity_to_use_action": "no", "actions_to_include": []}
"""Further keys that VirtualHome's prompts ask for beside subgoals."""


def maker(domain: str, ability: Ability) -> Maker:
    """Return the function that makes the answers of a suite."""
    book = open_gold_answers(find_benchmark(domain), ability)
    if ability is Ability.TRANSITION_MODELING:
        return partial(_operators, book)
    return _in_homes(ability, book) if domain == "virtualhome" else _in_scenes(ability, book)


def _in_homes(ability: Ability, book: AnswersByTask) -> Maker:
    tasks = virtualhome.open_tasks()

    def words(task_id: str) -> Words:
        scene = tasks[task_id].scene
        near = [scene.objects[i].name for i in tasks[task_id].relevant]
        signature = (
            VirtualHomeSubgoalNotation(SUBGOAL_ACTIONS).make_lexicon_of_names_in_subgoals(scene).signature
        )
        return Words(signature, [thing.name for thing in scene.objects], near)

    match ability:
        case Ability.ACTION_SEQUENCING:
            return lambda dice, i: virtualhome_plan(dice, tasks[i])
        case Ability.GOAL_INTERPRETATION:
            return lambda dice, i: virtualhome_goals(dice, tasks[i], book[i].parts)
        case _:
            return lambda dice, i: subgoals(dice, book[i].parts, words(i), BESIDES)


def _in_scenes(ability: Ability, book: AnswersByTask) -> Maker:
    tasks = behavior.open_tasks()
    match ability:
        case Ability.ACTION_SEQUENCING:
            return lambda dice, i: behavior_plan(dice, tasks[i])
        case Ability.GOAL_INTERPRETATION:
            return lambda dice, i: behavior_goals(dice, tasks[i])
        case _:
            return lambda dice, i: subgoals(dice, book[i].parts, _words(tasks[i].scene), {})


def _words(scene: Scene) -> Words:
    known = BehaviorSubgoalNotation().make_lexicon_of_names_in_subgoals(scene)
    names = [name for name in known.objects if "." in name and "_part" not in name]
    return Words(known.signature, names, names)


def _operators(book: AnswersByTask, dice: Dice, task_id: str) -> str:
    return operators(dice, book[task_id].parts, book[dice.one(tuple(book))].parts)
