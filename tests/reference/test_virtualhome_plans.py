from __future__ import annotations

import time

import pytest

from benchmark.plan_scorers import virtualhome_scorer
from eai.abilities.action_sequencing.plan import TOO_LONG, WrittenPlan
from eai.abilities.json_text import MAX_LENGTH
from eai.abilities.protocol import Protocol
from eai.abilities.unreadable import Unreadable
from eai.reference.virtualhome_plans import LIST_IS_NOT_JSON, read_plan
from households.virtualhome.household import make_task

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
    assert read_plan('{"WALK": ["sofa"]}' + " " * MAX_LENGTH) is TOO_LONG


@pytest.mark.parametrize("piece", ['"A": [', '"A":', '"', "[", '"A": []', '"A": [] '])
def test_reading_takes_time_in_proportion_to_the_text(piece: str) -> None:
    text = piece * (MAX_LENGTH // len(piece))
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
    verdict = virtualhome_scorer(task, Protocol.EAI_1_0_5, with_ids=True).score(plan)
    if verdict.error is not None:
        assert verdict.error.kind.value == outcome
        return
    assert ("success" if verdict.success else "equals the script") == outcome
    assert verdict.executable
