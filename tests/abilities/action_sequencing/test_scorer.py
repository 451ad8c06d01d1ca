from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace

import pytest

from eai.abilities.action_sequencing.scorer import ActionSequencingScorer
from eai.abilities.notation.plans import JsonPlanNotation
from eai.abilities.verdict import PlanVerdict
from eai.logic.formula import Atom, Constant, Occurs
from eai.tasks.share import Share, TalliesByGoalKind
from eai.tasks.task import NO_GOALS, Goal, GoalKind, Task
from eai.world.fault import FaultKind
from world import toy

LIT = Goal(GoalKind.STATE, Atom("lit", (Constant("lamp"),)))
MOVED = Goal(GoalKind.RELATION, Atom("at", (Constant("red"), Constant("shed"))))
DROPPED = Goal(GoalKind.ACTION, Occurs("DROP"))
TASK = Task("1", "Toy", "Play.", toy.initial(), (LIT, MOVED, DROPPED), tuple(range(6)))
SCORER = ActionSequencingScorer(TASK, toy.DOMAIN, JsonPlanNotation())
SUCCESS = ("LIFT red", "GO shed", "DROP red", "PRESS lamp")


def answer(*steps: str) -> str:
    """Return an answer from steps such as ``LIFT red`` or ``LIFT red, blue``."""
    words = (step.partition(" ") for step in steps)
    return json.dumps([{"action": action, "object": names} for action, _, names in words])


def verdict(text: str) -> PlanVerdict:
    found = SCORER.score(text)
    assert isinstance(found, PlanVerdict)
    return found


@pytest.mark.parametrize(
    ("steps", "error"),
    [
        (["FLY shed"], (FaultKind.HALLUCINATION, 0, "FLY is not an action")),
        (["GO shed", "GO moon"], (FaultKind.HALLUCINATION, 1, "GO: there is no moon")),
        (["gO shed"], (FaultKind.HALLUCINATION, 0, "gO is not an action")),
        (["go shed"], None),
        (["GO shed, moon, mars"], (FaultKind.HALLUCINATION, 0, "GO: there is no moon")),
        (["GO hall, shed"], (FaultKind.ARGUMENT_NUMBER, 0, "GO takes 1 object, not 2")),
        (["GO"], (FaultKind.ARGUMENT_NUMBER, 0, "GO takes 1 object, not 0")),
        # All names are tested before any number of objects.
        (["GO hall, shed", "GO moon"], (FaultKind.HALLUCINATION, 1, "GO: there is no moon")),
        # Errors while the plan runs.
        (["LIFT lamp"], (FaultKind.AFFORDANCE, 0, "lamp is no box")),
        (["DROP red"], (FaultKind.MISSING_STEP, 0, "red is not held")),
        (["LIFT blue"], (FaultKind.MISSING_STEP, 0, "the robot is not beside blue")),
        (["GO shed", "LIFT red"], (FaultKind.WRONG_ORDER, 1, "the robot is not beside red")),
        (SUCCESS, None),
        (SUCCESS[:3], None),
    ],
)
def test_the_error_names_the_failure_that_ends_a_plan(
    steps: Sequence[str], error: tuple[FaultKind, int, str] | None
) -> None:
    found = verdict(answer(*steps))
    assert (found.error and (found.error.kind, found.error.step, found.error.detail)) == error
    assert found.executable is (error is None)


@pytest.mark.parametrize(
    ("steps", "check", "objects"),
    [
        (["FLY shed"], "unknown_action", ()),
        (["GO moon"], "unknown_object", ("moon",)),
        (["GO hall, shed"], "wrong_arity", ()),
        (["LIFT lamp"], "is_no_box", ("lamp",)),
        (["LIFT blue"], "the_robot_is_not_beside", ("blue",)),
        (["LIFT red", "LIFT red"], "the_hand_is_full", ()),
    ],
)
def test_an_error_names_the_failed_check_and_its_objects(
    steps: Sequence[str], check: str, objects: tuple[str, ...]
) -> None:
    error = verdict(answer(*steps)).error
    assert error is not None
    assert (error.check, error.objects) == (check, objects)


def test_goals_are_reported_even_if_nothing_is_executed() -> None:
    for text in ("I cannot.", answer("FLY shed")):
        assert [goal.satisfied for goal in SCORER.explain(text).goals] == [False, False, False]


@pytest.mark.parametrize("text", ["", "I would go to the shed.", '{"OPEN": 3}', "[]"])
def test_an_answer_without_a_plan_is_a_parsing_error(text: str) -> None:
    error = verdict(text).error
    assert error is not None
    assert (error.kind, error.step) == (FaultKind.PARSING, None)


def test_a_plan_that_reaches_all_goals_succeeds() -> None:
    found = verdict(answer(*SUCCESS))
    assert (found.executable, found.success, found.goals_satisfied) == (True, True, (True, True, True))
    assert found.goals == TalliesByGoalKind(Share(1, 1), Share(1, 1), Share(1, 1))
    assert (found.additional_steps, found.counted, found.repairs) == (0, None, ())


def test_a_plan_that_misses_a_goal_fails() -> None:
    found = verdict(answer(*SUCCESS[:3]))
    assert (found.executable, found.success, found.goals_satisfied) == (True, False, (False, True, True))


def test_a_plan_that_fails_after_all_goals_are_reached_fails() -> None:
    found = verdict(answer(*SUCCESS, "DROP red"))
    assert (found.executable, found.success, found.goals_satisfied) == (False, False, (True, True, True))


def test_additional_steps_are_skipped_and_counted() -> None:
    found = verdict(answer("GO hall", "GO hall", *SUCCESS))
    assert (found.success, found.additional_steps) == (True, 2)


@pytest.mark.parametrize("text", ["no plan", answer("FLY shed"), answer("GO hall, shed")])
def test_an_answer_that_never_ran_reaches_no_goal(text: str) -> None:
    at_home = Goal(GoalKind.RELATION, Atom("at", (Constant("red"), Constant("hall"))))
    scorer = ActionSequencingScorer(replace(TASK, goals=(at_home,)), toy.DOMAIN, JsonPlanNotation())
    found, idle = scorer.score(text), scorer.score(answer("GO hall"))
    assert isinstance(found, PlanVerdict)
    assert (found.success, found.goals_satisfied, found.additional_steps) == (False, (False,), 0)
    assert found.goals == TalliesByGoalKind(Share(0, 0), Share(0, 1), Share(0, 0))
    assert idle.success


def test_a_verdict_does_not_depend_on_earlier_answers(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("eai.abilities.action_sequencing.scorer._MAX_STEPS_BEFORE_CLEARING_OUTCOMES", 6)
    often = ActionSequencingScorer(TASK, toy.DOMAIN, JsonPlanNotation())
    ways = [
        SUCCESS,
        SUCCESS[:3],
        ("GO shed", "LIFT red"),
        (*SUCCESS, "DROP red"),
        ("GO shed", "FLY shed"),
        ("GO",),
    ]
    for steps in ways * 3:
        text = answer(*steps)
        assert often.score(text) == ActionSequencingScorer(TASK, toy.DOMAIN, JsonPlanNotation()).score(text)


def test_a_task_without_goals_is_excluded_but_explained() -> None:
    scorer = ActionSequencingScorer(replace(TASK, goals=()), toy.DOMAIN, JsonPlanNotation())
    assert scorer.score(answer(*SUCCESS)) == PlanVerdict(excluded=NO_GOALS)
    explanation = scorer.explain(answer(*SUCCESS))
    assert explanation.notes == (f"excluded: {NO_GOALS}",)
    assert len(explanation.steps) == 4


def test_repairs_are_named() -> None:
    found = verdict(f"My plan:\n```json\n{answer(*SUCCESS)}\n```")
    assert (found.success, found.repairs) == (True, ("code_fence",))


def test_explanations_list_repairs_errors_steps_and_goals() -> None:
    fenced = SCORER.explain(f"```\n{answer('GO hall', 'LIFT red', 'DROP blue')}\n```")
    assert fenced.notes == ("read with repair: code_fence",)
    assert [step.outcome for step in fenced.steps] == ["additional_step", "executed", "missing_step"]
    assert [goal.satisfied for goal in fenced.goals] == [False, False, False]
    assert SCORER.explain(answer("GO shed", "FLY shed")).notes == (
        "hallucination: step 2: FLY is not an action",
    )
    assert SCORER.explain("?").notes[0].startswith("parsing: there is no list")
