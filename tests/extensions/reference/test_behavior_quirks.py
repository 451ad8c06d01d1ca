from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from benchmarks.behavior.kitchen import make_task, parse_actions
from eai.base.errors import InputError
from eai.benchmarks.behavior import domain as behavior
from eai.benchmarks.behavior.tasks import BehaviorTask, BehaviorTasks
from eai.extensions.reference.behavior_quirks import (
    list_dnf_terms_that_eai_eval_tries,
    make_behavior_goal_test,
)
from eai.logic.choice import count_dnf_terms, generate_dnf_terms
from eai.logic.formula import And, Atom, Formula, Not, Variable
from eai.tasks.goal_test import GoalTest
from eai.tasks.share import Share
from eai.world.execution import execute_plan
from eai.world.state import State
from logic.activities import as_list, records, universe
from logic.bddl_text import read_condition
from oracle import read_shared


def file(name: str) -> Any:
    return read_shared("oracle", "behavior", name)


def after(task: BehaviorTask, *steps: str) -> State:
    return execute_plan(
        behavior.make_domain_with_checks_in_paper_order(), task.initial, parse_actions(task.initial, *steps)
    ).final_state


def satisfied(goal: str, *steps: str) -> tuple[bool, bool]:
    """Whether a goal holds after these steps under `strict` and under `eai-1.0.5`."""
    task = make_task(goal)
    state = after(task, *steps)
    strict, reference = (
        test.evaluate_each_goal(state, ()) for test in (GoalTest(task), make_behavior_goal_test(task))
    )
    return strict[0], reference[0]


IN_FRIDGE = ("OPEN fridge_1", "RIGHT_GRASP rag_1", "RIGHT_PLACE_INSIDE carton_1", "RIGHT_GRASP carton_1")
SLICED = ("OPEN fridge_1", "RIGHT_GRASP carving_knife_1", "SLICE peach_1")


@pytest.mark.parametrize(
    ("goal", "steps", "expected"),
    [
        ("(inside peach.n.01_1 fridge.n.01_1)", (), (True, True)),
        ("(not (open fridge.n.01_1))", (), (True, True)),
        ("(open fridge.n.01_1)", ("OPEN fridge_1",), (True, True)),
        # What lies in something that is inside is inside too; the reference sees the nearest only.
        (
            "(inside rag.n.01_1 fridge.n.01_1)",
            (*IN_FRIDGE, "RIGHT_PLACE_INSIDE fridge_1"),
            (True, False),
        ),
        # A sliced object is what both of its parts are.
        ("(sliced peach.n.01_1)", SLICED, (True, True)),
        ("(inside peach.n.01_1 fridge.n.01_1)", SLICED, (True, True)),
        ("(inside peach.n.01_1 fridge.n.01_1)", (*SLICED, "LEFT_GRASP peach_1_part_0"), (False, False)),
        ("(not (frozen peach.n.01_1))", (*SLICED, "FREEZE peach_1_part_0"), (True, True)),
        (
            "(frozen peach.n.01_1)",
            (*SLICED, "FREEZE peach_1_part_0", "FREEZE peach_1_part_1"),
            (True, True),
        ),
        ("(forall (?p.n.01 - plate.n.01) (ontop ?p.n.01 table.n.01_1))", (), (True, True)),
        ("(forn (1) (?p.n.01 - plate.n.01) (stained ?p.n.01))", (), (True, True)),
        ("(forn (1) (?p.n.01 - plate.n.01) (dusty ?p.n.01))", (), (False, True)),
        (
            "(forpairs (?r.n.01 - rag.n.01) (?f.n.01 - floor.n.01) (onfloor ?r.n.01 ?f.n.01))",
            (),
            (False, False),
        ),
    ],
)
def test_when_a_goal_holds(goal: str, steps: tuple[str, ...], expected: tuple[bool, bool]) -> None:
    assert satisfied(goal, *steps) == expected


def test_a_goal_of_both_kinds_counts_half_as_each() -> None:
    goal = "(and (and (open fridge.n.01_1) (inside peach.n.01_1 fridge.n.01_1)) (dusty plate.n.01_1))"
    task = make_task(goal)
    for goals in (GoalTest(task), make_behavior_goal_test(task)):
        assert goals.tally_by_kind((True, False)) == (Share(0.5, 1.5), Share(0.5, 0.5), Share(0, 0))
        assert goals.tally_by_kind((False, True)) == (Share(1, 1.5), Share(0, 0.5), Share(0, 0))


def test_shares_are_those_of_the_reference(behavior_tasks: BehaviorTasks) -> None:
    kinds = file("goal_kinds.json")
    for task_id, task in behavior_tasks.items():
        goals = GoalTest(task)
        number = len(task.goals)
        for i, expected in enumerate(kinds[task_id]):
            tallies = goals.tally_by_kind(tuple(i == j for j in range(number)))
            assert [tallies.state.numerator, tallies.relation.numerator] == expected


def test_options_are_those_that_the_reference_keeps(behavior_tasks: BehaviorTasks) -> None:
    kept = file("goal_options_truncated.json.gz")
    for task_id, task in behavior_tasks.items():
        names = {thing.name: thing.instance for thing in task.record.objects}
        found = [
            [[_as_list(literal, names) for literal in option] for option in options]
            for options in (
                list_dnf_terms_that_eai_eval_tries(goal.formula, task.scene.names_of_category)
                for goal in task.goals
            )
        ]
        assert found == kept[task_id]


def _as_list(literal: Formula, names: dict[str, str]) -> list[object]:
    if isinstance(literal, Not):
        return ["not", _as_list(literal.operand, names)]
    assert isinstance(literal, Atom)
    return [literal.predicate, *(names[term.name] for term in literal.arguments)]


def test_strict_accepts_options_that_the_reference_drops(behavior_tasks: BehaviorTasks) -> None:
    """A plan that pairs the last candle with the first basket, and so on, is right."""
    (task,) = (task for task in behavior_tasks.values() if task.title == "assembling_gift_baskets")
    task = replace(task, goals=task.goals[:1])
    steps = [
        step for i in range(4) for step in (f"RIGHT_GRASP candle_{i}", f"RIGHT_PLACE_INSIDE basket_{3 - i}")
    ]
    state = after(task, *steps)
    assert GoalTest(task).evaluate_each_goal(state, ()) == (True,)
    assert make_behavior_goal_test(task).evaluate_each_goal(state, ()) == (False,)


def test_truncated_options_are_those_of_the_reference(oracle: Any) -> None:
    expected = oracle("behavior", "", "goal_options_truncated")
    for task, (goals, objects, _) in records(oracle).items():
        found = [
            [list(map(as_list, o)) for o in list_dnf_terms_that_eai_eval_tries(goal, objects)]
            for goal in goals
        ]
        assert found == expected[task], task


@pytest.mark.parametrize(
    "text",
    [
        "(forn (999999999) (?y - b) (open ?y))",
        "(fornpairs (999999999) (?x - a) (?y - b) (in ?x ?y))",
        "(fornpairs (3) (?x - a) (?y - b) (in ?x ?y))",
        "(fornpairs (3) (?y - b) (?x - a) (in ?x ?y))",
    ],
)
def test_more_things_than_there_are_give_no_truncated_option(text: str) -> None:
    assert list_dnf_terms_that_eai_eval_tries(read_condition(text), universe(a=2, b=5).list_objects) == []


def test_truncation_loses_options_of_large_pairings() -> None:
    formula = read_condition("(forpairs (?x - a) (?y - b) (in ?x ?y))")
    assert len(list_dnf_terms_that_eai_eval_tries(formula, universe(a=4, b=4).list_objects)) == 10
    assert len(list_dnf_terms_that_eai_eval_tries(formula, universe(a=3, b=3).list_objects)) == 6


def test_truncation_loses_the_last_options_of_small_products() -> None:
    formula = read_condition("(forall (?x - a) (exists (?y - b) (in ?x ?y)))")
    objects = universe(a=2, b=2).list_objects
    missing = set(generate_dnf_terms(formula, objects)) - set(
        list_dnf_terms_that_eai_eval_tries(formula, objects)
    )
    assert missing == set()
    assert (
        len(list_dnf_terms_that_eai_eval_tries(formula, universe(a=5, b=2).list_objects))
        < count_dnf_terms(formula, universe(a=5, b=2).list_objects)
        == 32
    )


def test_negated_goals_choose_one_condition_of_every_option() -> None:
    formula = read_condition("(imply (or (p a) (and (q a) (r a))) (not (s a)))")
    found = [
        list(map(as_list, option))
        for option in list_dnf_terms_that_eai_eval_tries(formula, universe().list_objects)
    ]
    assert found == [
        [["not", ["p", "a"]], ["not", ["q", "a"]]],
        [["not", ["p", "a"]], ["not", ["r", "a"]]],
        [["not", ["s", "a"]]],
    ]


def test_unbound_variables_are_an_error() -> None:
    unbound = And((Atom("p", (Variable("x"),)),))
    with pytest.raises(InputError, match="variable x is not bound"):
        list_dnf_terms_that_eai_eval_tries(unbound, universe().list_objects)
