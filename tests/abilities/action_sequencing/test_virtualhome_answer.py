from __future__ import annotations

import pytest

from eai.abilities.action_sequencing.plan import TOO_LONG, Unreadable, WrittenPlan
from eai.abilities.action_sequencing.virtualhome_answer import read_plan
from eai.abilities.json_text import MAX_LENGTH

Steps = list[tuple[str, tuple[object, ...]]]

WALK_GRAB: Steps = [("WALK", ("sofa",)), ("GRAB", ("cup",))]


def steps(text: str) -> Steps:
    plan = read_plan(text)
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
        ('{"WALK": ["sofa", null, {"a": 1}]}', [("WALK", ("sofa", None, ((("a", 1),),)))]),
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
    plan = read_plan(text)
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
    assert read_plan(text) == Unreadable(reason)


def test_an_endless_answer_is_not_searched() -> None:
    assert read_plan('{"WALK": ["sofa"]}' + " " * MAX_LENGTH) is TOO_LONG
