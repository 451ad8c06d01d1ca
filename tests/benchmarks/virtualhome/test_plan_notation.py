from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.virtualhome import flat
from benchmarks.virtualhome.household import make_task
from eai.abilities.answer_text import MAX_ANSWER_CHARACTERS, TOO_LONG
from eai.abilities.notation.plan_form import WrittenPlan
from eai.abilities.notation.plans import PlanNotation
from eai.abilities.verdict import Unreadable
from eai.benchmarks.virtualhome.plan_notation import ObjectWithId, VirtualHomePlanNotation, read_steps
from eai.world.action import Action
from eai.world.state import Scene

ACTION_NAMES = ("WALK", "GRAB", "SIT", "PUTBACK")

Steps = list[tuple[str, tuple[object, ...]]]

WALK_GRAB: Steps = [("WALK", ("sofa",)), ("GRAB", ("cup",))]


def steps(text: str) -> Steps:
    plan = read_steps(text, ACTION_NAMES)
    assert isinstance(plan, WrittenPlan), plan
    return [tuple(step) for step in plan.steps]


@pytest.mark.parametrize(
    "text",
    [
        '{"WALK": ["sofa"], "GRAB": ["cup"]}',
        '[{"WALK": ["sofa"]}, {"GRAB": ["cup"]}]',
        '[{"WALK": ["sofa"], "GRAB": ["cup"]}]',
        '[[{"WALK": ["sofa"]}], [{"GRAB": ["cup"]}]]',
        '{"plan": {"WALK": ["sofa"], "GRAB": ["cup"]}}',
        '{"plan": [{"WALK": ["sofa"]}, {"GRAB": ["cup"]}]}',
        '{"thought": "Sit?", "plan": {"WALK": ["sofa"], "GRAB": ["cup"]}}',
        '```json\n{"WALK": ["sofa"], "GRAB": ["cup"]}\n```',
        "{'WALK': ['sofa'], 'GRAB': ['cup']}",
        'First {"SIT": ["sofa"], "GRAB": ["cup"]}. No, rather {"WALK": ["sofa"], "GRAB": ["cup"]}.',
        'Each step is {"ACTION": ["object"]}.\n{"WALK": ["sofa"], "GRAB": ["cup"]}\nSee {"ACTION": [1]}.',
        '<think>{"SIT": ["sofa"]}</think>{"WALK": ["sofa"], "GRAB": ["cup"]}<|eot_id|>',
        '{"WALK": ["sofa"],}\n{"GRAB": ["cup"],}',
        '1. {"WALK": ["sofa"]}\n2. {"GRAB": ["cup"]}',
        '{"WALK": "sofa", "GRAB": "cup"}',
        '[{"action": "WALK", "object": "sofa"}, {"action": "GRAB", "objects": ["cup"]}]',
        '{"plan": "[{\\"WALK\\": [\\"sofa\\"]}, {\\"GRAB\\": [\\"cup\\"]}]"}',
    ],
)
def test_many_forms_of_a_plan_are_read_alike(text: str) -> None:
    assert steps(text) == WALK_GRAB


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ('{"WALK": ["sofa"], "WALK": ["sofa"]}', [("WALK", ("sofa",)), ("WALK", ("sofa",))]),
        ('{"STANDUP": []}', [("STANDUP", ())]),
        ('{"STANDUP": [ ]}', [("STANDUP", ())]),
        ('{"WALK": ["sofa", 352]}', [("WALK", ("sofa", 352))]),
        ('{"WALK": ["sofa", null, [1]]}', [("WALK", ("sofa", None, [1]))]),
        ('{"walk": ["sofa"]}', [("walk", ("sofa",))]),
        ('{"": [""]}', [("", ("",))]),
        ("{'WALK': ('sofa',)}", [("WALK", ("sofa",))]),
    ],
)
def test_words_of_a_plan_are_read_as_written(text: str, expected: Steps) -> None:
    assert steps(text) == expected


@pytest.mark.parametrize(
    ("text", "repairs"),
    [
        ('{"WALK": ["sofa"]}', ()),
        ('```{"WALK": ["sofa"]}```', ("code_fence",)),
        ('{"WALK": ["sofa"],}', ("trailing_comma",)),
        ('{"WALK": "sofa"}', ("step_form",)),
        ('{"why": "to sit", "plan": {"WALK": ["sofa"]}}', ("wrapper_key",)),
    ],
)
def test_a_read_plan_names_its_repairs(text: str, repairs: tuple[str, ...]) -> None:
    plan = read_steps(text, ACTION_NAMES)
    assert isinstance(plan, WrittenPlan)
    assert plan.repairs == repairs


@pytest.mark.parametrize("text", ["{}", "[]", "[{}]", '{"action commands": []}'])
def test_an_empty_plan_has_no_steps(text: str) -> None:
    assert steps(text) == []


NO_PLAN = "there is no object or list of actions with their objects"


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("", NO_PLAN),
        ("   \n", NO_PLAN),
        ("I would walk to the sofa.", NO_PLAN),
        ("null", NO_PLAN),
        ('"WALK"', "'\"WALK\"' looks like a part of the answer and stands outside"),
        ('["WALK", "sofa"]', f'{NO_PLAN}: step 1 has no "action"'),
        ('{"SIT": ["a"], "why": "b"}', f'{NO_PLAN}: step 1 has no "action"'),
        ('{"plan": {"a": {"b": 1}}}', NO_PLAN),
        ('{"WALK": [sofa]}', f"{NO_PLAN}: line 1, column 11: expected value"),
        ('{"WALK": ["sofa"], "GRAB": [cup]}', f"{NO_PLAN}: line 1, column 29: expected value"),
        ('{"WALK": ["sofa"], "GRAB": ["cup"]', "as if the answer were cut off"),
        ('{"WALK": ["sofa"], "GRAB": ["cup"], "PUTBACK": ["cup", "ta', "as if the answer were cut off"),
        ('"WALK": ["sofa"], "GRAB": ["cup"]', "looks like a part of the answer and stands outside"),
        ('{"WALK": ["sofa"]}\nGRAB cup', "'GRAB cup' looks like a part of the answer and stands outside"),
        ('{"WALK": ["sofa"]} then {"GRAB": ["cup"]}', "'then' looks like a part of the answer"),
        ('{"plan": {"WALK": ["sofa"]}, "GRAB": ["cup"]}', NO_PLAN),
    ],
)
def test_an_incomplete_plan_cannot_be_read(text: str, reason: str) -> None:
    plan = read_steps(text, ACTION_NAMES)
    assert isinstance(plan, Unreadable)
    assert reason in plan.reason


def test_an_answer_beyond_the_maximum_length_is_not_searched() -> None:
    assert read_steps('{"WALK": ["sofa"]}' + " " * MAX_ANSWER_CHARACTERS) is TOO_LONG


SCENE = flat.make_scene()
NOTATION = VirtualHomePlanNotation()
ACTIONS = st.builds(
    Action,
    st.sampled_from(["WALK", "PUTBACK", "STANDUP"]),
    st.lists(st.sampled_from(range(len(SCENE.objects))), max_size=2).map(tuple),
)


@pytest.mark.parametrize(
    ("plan", "text"),
    [
        ([], "{}"),
        (["WALK fridge.10"], '{"WALK": ["fridge", "10"]}'),
        (["STANDUP", "STANDUP"], '{"STANDUP": [ ], "STANDUP": [ ]}'),
        (["PUTIN cup.13 fridge.10"], '{"PUTIN": ["cup", "13", "fridge", "10"]}'),
    ],
)
def test_a_plan_is_written_with_names_and_ids(plan: list[str], text: str) -> None:
    actions = [flat.parse_action(step, SCENE) for step in plan]
    assert NOTATION.join(NOTATION.write(actions, SCENE)) == text


PLANS = st.lists(ACTIONS, min_size=1, max_size=5).filter(lambda plan: any(a.arguments for a in plan))


def assert_reads_written_plan(notation: PlanNotation, plan: list[Action]) -> None:
    """Fail unless a notation reads a plan that the notation of `strict` wrote."""
    task = make_task()
    read = notation.read(NOTATION.join(NOTATION.write(plan, task.scene)))
    assert isinstance(read, WrittenPlan)
    index_of = notation.make_object_lookup(task)
    assert [Action(s.action, tuple(map(index_of, s.objects))) for s in read.steps] == plan  # type: ignore[arg-type]


@given(PLANS)
def test_a_written_plan_is_read_as_the_same_plan(plan: list[Action]) -> None:
    assert_reads_written_plan(NOTATION, plan)


@pytest.mark.parametrize(
    ("text", "objects"),
    [
        ('{"PUTIN": ["cup", "13", "fridge", 10]}', (ObjectWithId("cup", "13"), ObjectWithId("fridge", 10))),
        ('{"PUTIN": ["cup", "13", "fridge"]}', (ObjectWithId("cup", "13"), ObjectWithId("fridge", None))),
        ('{"PUTIN": ["cup", "fridge"]}', ("cup", "fridge")),
    ],
)
def test_a_class_followed_by_an_id_is_read_as_one_object(text: str, objects: tuple[object, ...]) -> None:
    plan = NOTATION.read(text)
    assert isinstance(plan, WrittenPlan)
    assert plan.steps[0].objects == objects


def test_an_object_may_have_no_id() -> None:
    task = make_task()
    scene = Scene(task.scene.vocabulary, {"cup.13": "cup", "box": "box", "bed.20": "bed"})
    task = replace(task, initial=scene.state([]), relevant=(0, 1, 2))
    assert NOTATION.list_words_that_name_objects(task) == ("cup", "box", "bed", "13", "20")


def test_a_message_names_an_object_by_class_and_id() -> None:
    assert (str(ObjectWithId("cup", 13)), str(ObjectWithId("cup", None))) == ("cup_13", "cup without an id")


def test_many_numbers_before_no_step_are_read_in_linear_time() -> None:
    assert isinstance(read_steps("step 1: " * 2000, ACTION_NAMES), Unreadable)
