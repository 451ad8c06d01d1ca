from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from eai.abilities.json_text import MAX_LENGTH, Pairs
from eai.abilities.notation.plans import TOO_LONG, WrittenPlan
from eai.abilities.verdict import Unreadable
from eai.households.virtualhome.plan_notation import Identified, VirtualHomePlans, read_steps
from eai.world.execution import Action
from households.virtualhome import flat
from households.virtualhome.household import make_task
from protocols import of_reference

virtualhome_plans = of_reference("virtualhome_plans")

Steps = list[tuple[str, tuple[object, ...]]]

WALK_GRAB: Steps = [("WALK", ("sofa",)), ("GRAB", ("cup",))]


def steps(text: str) -> Steps:
    plan = read_steps(text)
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
        'First {"SIT": ["sofa"]}. No, rather {"WALK": ["sofa"], "GRAB": ["cup"]}.',
        '<think>{"SIT": ["sofa"]}</think>{"WALK": ["sofa"], "GRAB": ["cup"]}<|eot_id|>',
        '{"WALK": ["sofa"], "GRAB": ["cup"]',
        '{"WALK": ["sofa"], "GRAB": ["cup"], "PUTBACK": ["cup", "ta',
        '"WALK": ["sofa"], "GRAB": ["cup"]',
        "WALK: then 'WALK': ['sofa'] and 'GRAB': ['cup']",
        '{"WALK": ["sofa"],}\n{"GRAB": ["cup"],}',
    ],
)
def test_one_plan_in_many_guises(text: str) -> None:
    assert steps(text) == WALK_GRAB


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ('{"WALK": ["sofa"], "WALK": ["sofa"]}', [("WALK", ("sofa",)), ("WALK", ("sofa",))]),
        ('{"STANDUP": []}', [("STANDUP", ())]),
        ('{"STANDUP": [ ]}', [("STANDUP", ())]),
        ('{"WALK": ["sofa", 352]}', [("WALK", ("sofa", 352))]),
        ('{"WALK": ["sofa", null, {"a": 1}]}', [("WALK", ("sofa", None, Pairs([("a", 1)])))]),
        ('{"walk": ["sofa"]}', [("walk", ("sofa",))]),
        ('{"": [""]}', [("", ("",))]),
        ("{'WALK': ('sofa',)}", [("WALK", ("sofa",))]),
    ],
)
def test_what_stands_there_is_kept(text: str, expected: Steps) -> None:
    assert steps(text) == expected


@pytest.mark.parametrize(
    ("text", "repairs"),
    [
        ('{"WALK": ["sofa"]}', ()),
        ('```{"WALK": ["sofa"]}```', ("code_fence",)),
        ('{"WALK": ["sofa"], "GRAB', ("broken_json",)),
    ],
)
def test_repairs_are_named(text: str, repairs: tuple[str, ...]) -> None:
    plan = read_steps(text)
    assert isinstance(plan, WrittenPlan)
    assert plan.repairs == repairs


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("", "no step was found"),
        ("   \n", "no step was found"),
        ("I would walk to the sofa.", "no step was found"),
        ("{}", "no step was found"),
        ("[]", "no step was found"),
        ("null", "no step was found"),
        ('"WALK"', "no step was found"),
        ('["WALK", "sofa"]', "no step was found"),
        ('{"WALK": "sofa"}', "no step was found"),
        ('{"plan": {"a": {"b": 1}}}', "no step was found"),
        ("[" * 500 + "]" * 500, "no step was found"),
        ('{"WALK": [sofa]}', "the list of step 1 (WALK) is not JSON"),
        ('{"WALK": ["sofa"], "GRAB": [cup]}', "the list of step 2 (GRAB) is not JSON"),
    ],
)
def test_what_no_plan_can_be_read_from(text: str, reason: str) -> None:
    assert read_steps(text) == Unreadable(reason)


def test_an_endless_answer_is_not_searched() -> None:
    assert read_steps('{"WALK": ["sofa"]}' + " " * MAX_LENGTH) is TOO_LONG


SCENE = flat.scene()
NOTATION = VirtualHomePlans()
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
    actions = [flat.action(step, SCENE) for step in plan]
    assert NOTATION.join(NOTATION.write(actions, SCENE)) == text


@given(st.lists(ACTIONS, min_size=1, max_size=5).filter(lambda plan: any(a.arguments for a in plan)))
def test_both_protocols_read_what_is_written(plan: list[Action]) -> None:
    task = make_task()
    text = NOTATION.join(NOTATION.write(plan, task.scene))
    for notation in (NOTATION, virtualhome_plans._Notation(), virtualhome_plans._Notation(with_ids=True)):
        read = notation.read(text)
        assert isinstance(read, WrittenPlan)
        index_of = notation.objects(task)
        assert [Action(s.action, tuple(map(index_of, s.objects))) for s in read.steps] == plan  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("text", "objects"),
    [
        ('{"PUTIN": ["cup", "13", "fridge", 10]}', (Identified("cup", "13"), Identified("fridge", 10))),
        ('{"PUTIN": ["cup", "13", "fridge"]}', (Identified("cup", "13"), Identified("fridge", None))),
        ('{"PUTIN": ["cup", "fridge"]}', ("cup", "fridge")),
    ],
)
def test_a_class_and_an_id_are_one_object(text: str, objects: tuple[object, ...]) -> None:
    plan = NOTATION.read(text)
    assert isinstance(plan, WrittenPlan)
    assert plan.steps[0].objects == objects


def test_what_messages_call_an_object() -> None:
    assert (str(Identified("cup", 13)), str(Identified("cup", None))) == ("cup_13", "cup without an id")
