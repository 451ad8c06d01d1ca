from __future__ import annotations

import json
from collections.abc import Callable

import pytest

from benchmarks.virtualhome import flat
from benchmarks.virtualhome.household import make_task
from eai.abilities.protocol import Ability
from eai.abilities.verdict import PlanVerdict
from eai.base.store import DataPackStore
from eai.benchmarks.gold_answers import AnswersByTask, open_answers_of_planner, open_gold_answers
from eai.benchmarks.suite import open_suite
from eai.benchmarks.virtualhome.notation import VirtualHomeSubgoalNotation
from eai.tasks.source import Source
from sweeps import swept

WORDS = VirtualHomeSubgoalNotation()

AT_HAND = tuple(
    f"NEXT_TO character.65 {category}.{number}"
    for category, number in (
        ("fridge", 10),
        ("milk", 11),
        ("table", 12),
        ("cup", 13),
        ("shirt", 17),
        ("bed", 20),
    )
)


@pytest.mark.parametrize(
    ("step", "subgoal"),
    [
        ("WALK kitchen.1", "INSIDE(character.65, kitchen.1)"),
        ("FIND book.16", "NEXT_TO(character.65, book.16)"),
        ("OPEN fridge.10", "OPEN(fridge.10)"),
        ("LIE bed.20", "ONTOP(character.65, bed.20)"),
        ("WASH table.12", "CLEAN(table.12)"),
        ("TOUCH table.12", "TOUCH(table.12)"),
    ],
)
def test_a_step_is_written_as_the_subgoal_that_it_reaches(step: str, subgoal: str) -> None:
    task = make_task(*AT_HAND)
    assert WORDS.write(task, [flat.parse_action(step, task.scene)]) == (subgoal,)


def test_a_step_that_only_ends_a_state_is_written_as_a_negation() -> None:
    task = make_task("SITTING character.65")
    assert WORDS.write(task, [flat.parse_action("STANDUP", task.scene)]) == ("not SITTING(character.65)",)


def test_a_step_without_effect_and_without_a_subgoal_name_is_left_out() -> None:
    task = make_task(*AT_HAND, "NEXT_TO cup.13 character.65")
    assert WORDS.write(task, [flat.parse_action("FIND cup.13", task.scene)]) == ()


def test_an_action_without_objects_is_written_by_its_name() -> None:
    task = make_task("LYING character.65", "ONTOP character.65 bed.20")
    assert WORDS.write(task, [flat.parse_action("SLEEP", task.scene)]) == ("SLEEP()",)


def test_subgoals_are_joined_into_an_answer() -> None:
    assert json.loads(WORDS.join(["A(x)", "B(y)"]))["output"] == ["A(x)", "B(y)"]


@pytest.mark.parametrize("open_book", [open_gold_answers, *swept(open_answers_of_planner)])
def test_subgoals_of_scripts_and_of_plans_reach_every_goal(
    open_book: Callable[..., AnswersByTask], data_store: DataPackStore
) -> None:
    source = Source(data_store)
    suite = open_suite("virtualhome", Ability.SUBGOAL_DECOMPOSITION, source=source)
    book = open_book(suite.benchmark, Ability.SUBGOAL_DECOMPOSITION, source)
    missed, left_out = [], 0
    for task_id in suite.task_ids:
        verdict = suite.score(task_id, book[task_id].text)
        assert isinstance(verdict, PlanVerdict)
        left_out += verdict.excluded is not None
        missed += [task_id] if verdict.success is False else []
    assert (missed, left_out) == ([], 1)
