from __future__ import annotations

import time

import pytest

from benchmarks.virtualhome.household import make_task
from eai.abilities.answer_text import MAX_ANSWER_CHARACTERS, TOO_LONG
from eai.abilities.notation.plan_form import WrittenPlan
from eai.abilities.verdict import Unreadable
from eai.extensions.reference.virtualhome_plans import (
    LIST_IS_NOT_JSON,
    VirtualHomeActionSequencingScorer,
    _VirtualHomeGoalTest,
    read_plan,
)
from eai.tasks.goal_test import GoalTest
from eai.tasks.share import Share, TalliesByGoalKind
from eai.tasks.task import Task

Steps = list[tuple[str, tuple[object, ...]]]

WALK_GRAB: Steps = [("WALK", ("sofa",)), ("GRAB", ("cup",))]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ('{"WALK": ["sofa"], "GRAB": ["cup"]}', WALK_GRAB),
        ('```json\n{"WALK": ["sofa"], "GRAB": ["cup"]}\n```', WALK_GRAB),
        ('``` {"WALK": ["sofa"], "GRAB": ["cup"]} ```', WALK_GRAB),
        ("{'WALK': ['sofa'], 'GRAB': ['cup']}", WALK_GRAB),
        ('[{"WALK": ["sofa"]}, {"GRAB": ["cup"]}]', WALK_GRAB),
        ('Sure: "WALK": ["sofa"] and then "GRAB" : ["cup"]', WALK_GRAB),
        ('{"WALK": ["sofa"], "GRAB": ["cup"], "PUTBACK": ["cup", "ta', WALK_GRAB),
        ('{"WALK":\n["so\nfa"],\n"GRAB":\t["cup"]}', WALK_GRAB),
        ('<think>"WALK": ["sofa"]</think>"GRAB": ["cup"]', WALK_GRAB),
        ('{"STANDUP": [ ]}', [("STANDUP", ())]),
        ('{"STANDUP": [], "GRAB": ["cup"]}', [("GRAB", ("cup",))]),
        ('{"WALK": ["sofa", 352]}', [("WALK", ("sofa", 352))]),
        ('{"walk": ["sofa"]}', [("walk", ("sofa",))]),
        ('{"WALK": [""]}', [("WALK", ("",))]),
    ],
)
def test_every_pair_in_the_text_is_a_step(text: str, expected: Steps) -> None:
    plan = read_plan(text)
    assert isinstance(plan, WrittenPlan), plan
    assert [tuple(step) for step in plan.steps] == expected
    assert plan.repairs == ()


@pytest.mark.parametrize(
    "text",
    ["", "{}", "I would walk.", '{"STANDUP": []}', '{"WALK": "sofa"}', '{"WALK: ["sofa"]}', '"WALK": [', "]"],
)
def test_no_step_at_all_counts_once(text: str) -> None:
    assert read_plan(text) == Unreadable("no step was found")


@pytest.mark.parametrize(
    "text",
    [
        '{"WALK": [sofa]}',
        '{"GRAB": ["child\'s cup"]}',
        '{"WALK": [["sofa"]]}',
        '{"WALK": ["\0"]}',
        '{"WALK": ' + "[" * 100_000 + "]}",
        '{"WALK": [' + "1" * 10_000 + "]}",
    ],
    ids=lambda text: text[:20],
)
def test_a_list_that_is_not_json_counts_twice(text: str) -> None:
    assert read_plan(text) is LIST_IS_NOT_JSON


def test_an_endless_answer_is_not_searched() -> None:
    assert read_plan('{"WALK": ["sofa"]}' + " " * MAX_ANSWER_CHARACTERS) is TOO_LONG


@pytest.mark.parametrize("piece", ['"A": [', '"A":', '"', "[", '"A": []', '"A": [] '])
def test_reading_takes_time_in_proportion_to_the_text(piece: str) -> None:
    text = piece * (MAX_ANSWER_CHARACTERS // len(piece))
    started = time.process_time()
    assert isinstance(read_plan(text), Unreadable)
    assert time.process_time() - started < 10


@pytest.mark.parametrize(
    ("plan", "outcome"),
    [
        # The data set's script, which is not executed and counts as a failure.
        ('{"WALK": ["sofa_bed", "40"], "SIT": ["sofa_bed", "40"]}', "equals the script"),
        ('{"WALK": ["sofa_bed", 40], "SIT": ["sofa_bed", "40"]}', "equals the script"),
        # Name and id are looked up as one text, and so compared with the script as another one.
        ('{"WALK": ["sofa", "bed_40"], "SIT": ["sofa_bed", "40"]}', "success"),
        ('{"WALK": ["sofa_bed", "40"], "SIT": ["sofa", "bed_40"]}', "success"),
        ('{"WALK": ["sofa_bed", "40"], "WALK": ["sofa_bed", "40"], "SIT": ["sofa_bed", "40"]}', "success"),
        ('{"WALK": ["sofa_bed", "040"], "SIT": ["sofa_bed", "40"]}', "hallucination"),
        ('{"WALK": ["sofa_bed", 40.0], "SIT": ["sofa_bed", "40"]}', "hallucination"),
        ('{"WALK": ["sofa_bed ", "40"], "SIT": ["sofa_bed", "40"]}', "hallucination"),
        ('{"WALK": ["", "sofa_bed_40"], "SIT": ["sofa_bed", "40"]}', "hallucination"),
        ('{"WALK": ["Sofa_bed", "40"], "SIT": ["sofa_bed", "40"]}', "hallucination"),
    ],
)
def test_equal_to_the_script_is_what_has_its_text(plan: str, outcome: str) -> None:
    task = make_task(
        "SITTABLE sofa_bed.40",
        "INSIDE sofa_bed.40 bedroom.2",
        goals=("state SITTING character.65",),
        script=["WALK sofa_bed.40", "SIT sofa_bed.40"],
        more_objects=("sofa_bed.40",),
    )
    verdict = VirtualHomeActionSequencingScorer(task, with_ids=True).score(plan)
    if verdict.error is not None:
        assert verdict.error.kind.value == outcome
        return
    assert ("success" if verdict.success else "equals the script") == outcome
    assert verdict.executable


OPEN_FRIDGE = "state OPEN fridge.10"
TWO_RELATIONS = ("relation ONTOP cup.13 table.12", "relation ONTOP bread.14 table.12")
BOTH = pytest.mark.parametrize("kind", [GoalTest, _VirtualHomeGoalTest], ids=["strict", "reference"])


def tallies(kind: type[GoalTest], task: Task, actions: list[str]) -> TalliesByGoalKind:
    test = kind(task)
    return test.tally_by_kind(test.evaluate_each_goal(task.initial, actions))


def actions_met(kind: type[GoalTest], goals: list[str], actions: list[str]) -> Share:
    return tallies(kind, make_task(goals=[f"action {goal}" for goal in goals]), actions).action


@BOTH
@pytest.mark.parametrize(
    ("goals", "expected"),
    [
        (["state CLOSED fridge.10", OPEN_FRIDGE], ((1, 2), (0, 0), (0, 0))),
        (["relation ONTOP cup.13 table.12"], ((0, 0), (1, 1), (0, 0))),
        (["relation ONTOP cup.13 bed.20"], ((0, 0), (0, 1), (0, 0))),
        (["relation INSIDE milk.11 fridge.10", "state ON fridge.10"], ((0, 1), (1, 1), (0, 0))),
        (["action GRAB"], ((0, 0), (0, 0), (0, 1))),
        ([], ((0, 0), (0, 0), (0, 0))),
    ],
)
def test_goals_are_counted_by_kind(
    kind: type[GoalTest], goals: list[str], expected: tuple[tuple[int, int], ...]
) -> None:
    counted = tallies(kind, make_task(goals=goals), [])
    assert counted == TalliesByGoalKind(*(Share(*tally) for tally in expected))


@pytest.mark.parametrize(("kind", "counted"), [(GoalTest, 2), (_VirtualHomeGoalTest, 1)])
def test_quirk_the_first_relation_that_holds_ends_the_count(kind: type[GoalTest], counted: int) -> None:
    assert tallies(kind, make_task(goals=TWO_RELATIONS), []).relation == Share(counted, 2)


@BOTH
@pytest.mark.parametrize(
    ("goals", "actions", "satisfied"),
    [
        (["GRAB"], [], 0),
        (["GRAB"], ["WALK", "GRAB"], 1),
        (["LOOKAT|WATCH"], ["WATCH"], 1),
        (["LOOKAT|WATCH"], ["LOOKAT"], 1),
        (["LOOKAT|WATCH"], ["READ"], 0),
        (["GRAB", "WASH|RINSE"], ["GRAB", "WALK", "RINSE"], 2),
        (["GRAB", "WASH|RINSE"], ["RINSE", "GRAB"], 1),
        (["GRAB", "WASH"], ["GRAB", "GRAB"], 1),
        (["GRAB", "GRAB"], ["GRAB"], 1),
    ],
)
def test_action_goals_count_in_order(
    kind: type[GoalTest], goals: list[str], actions: list[str], satisfied: int
) -> None:
    assert actions_met(kind, goals, actions) == Share(satisfied, len(goals))


@pytest.mark.parametrize(
    ("goals", "actions", "strict", "reference"),
    [
        # Substrings: the reference finds LOOKAT in LOOKAT_SHORT, and PUT in PUTBACK.
        (["LOOKAT"], ["LOOKAT_SHORT"], 0, 1),
        (["PUT"], ["PUTBACK"], 0, 1),
        # The first alternative that occurs at all counts for the reference, even if another occurs earlier.
        (["A|B", "C"], ["B", "C", "A"], 2, 1),
        # After an unmet goal the reference skips all later goals; `strict` does not.
        (["GRAB", "WASH"], ["WASH"], 1, 0),
        # The reference searches goals in the order of hash seed 0, which is alphabetical.
        (["TYPE", "SWITCHOFF"], ["TYPE", "SWITCHOFF"], 2, 1),
        (["TYPE", "SWITCHOFF"], ["SWITCHOFF", "TYPE"], 1, 2),
    ],
)
def test_quirks_of_action_goals(goals: list[str], actions: list[str], strict: int, reference: int) -> None:
    assert actions_met(GoalTest, goals, actions).numerator == strict
    assert actions_met(_VirtualHomeGoalTest, goals, actions).numerator == reference


@pytest.mark.parametrize(
    ("goals", "reorders"),
    [(("action TYPE", "action SWITCHOFF"), True), (("action GRAB", "action WASH"), False), ((), False)],
)
def test_action_goals_can_be_taken_in_the_order_of_the_data_set(
    goals: tuple[str, ...], *, reorders: bool
) -> None:
    task = make_task(goals=goals)
    assert _VirtualHomeGoalTest(task).reorders is reorders
    in_order = _VirtualHomeGoalTest(task, in_data_set_order=True)
    assert not in_order.reorders
    assert in_order.evaluate_each_goal(task.initial, ["TYPE", "GRAB", "SWITCHOFF", "WASH"]) == (True,) * len(
        goals
    )


@BOTH
def test_each_goal_by_itself(kind: type[GoalTest]) -> None:
    task = make_task(goals=("action GRAB", TWO_RELATIONS[0], OPEN_FRIDGE, "action WASH"))
    assert kind(task).evaluate_each_goal(task.initial, ["GRAB", "WASH"]) == (True, True, False, True)
    assert kind(task).evaluate_each_goal(task.initial, ["GRAB"]) == (True, True, False, False)


@BOTH
def test_an_answer_that_never_ran_satisfies_none_of_all_goals(kind: type[GoalTest]) -> None:
    test = kind(make_task(goals=(*TWO_RELATIONS, OPEN_FRIDGE, "action GRAB")))
    assert test.tally_by_kind(test.none_reached) == TalliesByGoalKind(Share(0, 1), Share(0, 2), Share(0, 1))


@pytest.mark.parametrize(
    ("goals", "passes"),
    [
        (("relation ONTOP cup.13 table.12", "action GRAB"), True),
        (TWO_RELATIONS, False),
        ((OPEN_FRIDGE,), False),
        ((), True),
    ],
)
def test_the_gold_test_is_on_states_and_relations(goals: tuple[str, ...], *, passes: bool) -> None:
    task = make_task(goals=goals)
    assert _VirtualHomeGoalTest(task).are_goals_reached_in_gold_final_state(task.initial) is passes
