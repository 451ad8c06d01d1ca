"""Plans with one action a line, as small models write them, in each notation that has names of actions."""

from __future__ import annotations

import pytest

from eai.abilities.notation.plan_form import WrittenPlan
from eai.abilities.notation.plans import JsonPlanNotation, PddlPlanNotation, PlanNotation
from eai.abilities.verdict import AnswerSpan, AnswerSpanKind, Unreadable
from eai.benchmarks.virtualhome.plan_notation import VirtualHomePlanNotation

ACTIONS = ("WALK", "GRAB", "PUT", "SLEEP")
WALK, GRAB, PUT, SLEEP = ("WALK", ("soap",)), ("GRAB", ("soap",)), ("PUT", ("soap", "bin")), ("SLEEP", ())

LINES = [
    ("WALK(soap)\nGRAB(soap)", [WALK, GRAB], ("action_lines",)),
    ("WALK (soap),\nPUT(soap, bin).", [WALK, PUT], ("action_lines",)),
    ("1. WALK soap\n2) PUT soap, bin\n", [WALK, PUT], ("action_lines", "numbered")),
    ("4. WALK soap", [WALK], ("action_lines", "numbered")),
    ("WALK(soap)\nGRAB(soap)\n\nConfidence:\n95", [WALK, GRAB], ("prose", "action_lines")),
    ("1: WALK soap\n2: GRAB soap", [WALK, GRAB], ("action_lines", "numbered")),
    ("- **WALK(soap)**\n- `GRAB(soap)`", [WALK, GRAB], ("action_lines", "numbered")),
    ("**Step 1:** WALK(soap)\n**Step 2:** GRAB(soap)", [WALK, GRAB], ("action_lines", "numbered")),
    ("walk soap\ngrab soap", [WALK, GRAB], ("action_lines", "letter_case")),
    ("So:\n1. Walk(soap)\n2. sleep", [WALK, SLEEP], ("prose", "action_lines", "numbered", "letter_case")),
    ("```\nWALK: soap\n```", [WALK], ("code_fence", "action_lines")),
    ("[WALK] <soap>\n[SLEEP]", [WALK, SLEEP], ("action_lines",)),
    ('WALK("soap")\n"GRAB(soap)",', [WALK, GRAB], ("action_lines",)),
    ("<think>WALK(bin)</think>WALK(soap)", [WALK], ("reasoning", "action_lines")),
    ("Answer: WALK(soap)\nGRAB(soap)", [WALK, GRAB], ("prose", "action_lines")),
    ("Final answer:\n1. WALK(soap)\n2. GRAB(soap)", [WALK, GRAB], ("action_lines", "numbered", "prose")),
    ("Action 1: WALK(soap)\nAction 2: GRAB(soap)", [WALK, GRAB], ("prose", "action_lines")),
    ("<answer>WALK(soap)\nGRAB(soap)</answer>", [WALK, GRAB], ("special_tokens", "action_lines")),
    ("[INST]WALK(soap)\nGRAB(soap)<|eot_id|></s>", [WALK, GRAB], ("special_tokens", "action_lines")),
    ("\ufeffWALK(soap)\r\nGRAB\u00a0(soap)\u200b\x00", [WALK, GRAB], ("wide_characters", "action_lines")),
    ("WALK（soap）\nPUT(soap， bin)", [WALK, PUT], ("wide_characters", "action_lines")),
    ("WALK（soap）</s>", [WALK], ("special_tokens", "wide_characters", "action_lines")),
    ("```text WALK(soap)\nGRAB(soap)```", [WALK, GRAB], ("code_fence", "action_lines")),
    ("```WALK(soap)\nGRAB(soap)\n```", [WALK, GRAB], ("code_fence", "action_lines")),
    ("(1) WALK(soap)\n(2) GRAB(soap)", [WALK, GRAB], ("action_lines", "numbered")),
    ("a. WALK(soap)\nb. GRAB(soap)", [WALK, GRAB], ("action_lines", "numbered")),
    ("→ WALK(soap)\n✅ GRAB(soap)", [WALK, GRAB], ("special_tokens", "action_lines", "numbered")),
    ("WALK(soap)\\nGRAB(soap)", [WALK, GRAB], ("special_tokens", "action_lines")),
    ('{"plan": ["WALK(soap)", "GRAB(soap)"]}', [WALK, GRAB], ("action_lines",)),
    ('"WALK(soap)\\nGRAB(soap)"', [WALK, GRAB], ("action_lines",)),
    ("Step 1:\nWALK(soap)\nStep 2:\nGRAB(soap)", [WALK, GRAB], ("action_lines", "numbered")),
    ("1. WALK(soap) - go\n2. GRAB(soap): take it", [WALK, GRAB], ("prose", "action_lines", "numbered")),
    ("WALK(soap) # walk to it\nGRAB(soap) // take it", [WALK, GRAB], ("prose", "action_lines")),
    ("WALK(soap): WALK to the soap\nGRAB(soap) - grab the soap", [WALK, GRAB], ("prose", "action_lines")),
    ("WALK(soap_dish): WALK to the soap_dish", [("WALK", ("soap_dish",))], ("prose", "action_lines")),
    ("1. WALK(soap) # Walk to it.", [WALK], ("prose", "action_lines", "numbered")),
    ("1. WALK(soap): the soap is far away, so walk to it", [WALK], ("prose", "action_lines", "numbered")),
    ("Here you go :)\nWALK(soap)\nGood luck ;)", [WALK], ("prose", "action_lines")),
    ("WALK(soap)\nThe last step is WALK(soap) near the bin.", [WALK], ("prose", "action_lines")),
]  # fmt: skip


@pytest.mark.parametrize(
    "notation", [JsonPlanNotation(), VirtualHomePlanNotation()], ids=["default", "virtualhome"]
)
@pytest.mark.parametrize(("text", "steps", "repairs"), LINES)
def test_lines_of_actions_are_read_by_named_repairs(
    notation: PlanNotation, text: str, steps: list[tuple[str, tuple[str, ...]]], repairs: tuple[str, ...]
) -> None:
    plan = notation.read(text, ACTIONS)
    assert isinstance(plan, WrittenPlan)
    assert [tuple(step) for step in plan.steps] == steps
    assert {*plan.repairs} - {"wrapper_key"} == set(repairs)
    assert {span.kind for span in plan.spans} <= {
        AnswerSpanKind.REPAIRED,
        AnswerSpanKind.PROSE,
        AnswerSpanKind.REASONING,
    }


@pytest.mark.parametrize("notation", [JsonPlanNotation(), VirtualHomePlanNotation(), PddlPlanNotation()])
@pytest.mark.parametrize(
    "text",
    [
        "WALK(soap)\nthen\nGRAB(soap)",
        "WALK(soap)\nGRAB the soap",
        "WALK(soap); GRAB(soap)",
        "WALK(soap) and GRAB(soap)",
        "WALK(soap)\nGRAB(soap",
        "1. Walk to the soap.\n2. Grab it.",
        "I would walk there first.\ngrab soap\nThat is all.",
        'WALK(soap)\n{"GRAB": ["soap"',
        '1. WALK(soap)\n2. {"action": "GRAB"}',
        "WALK(soap, GRAB(bin))",
        "FLY(soap)",
        "FLY(soap)\nWALK(soap)",
        "1. TURN ON: (x)\n2. WALK: (soap)\n3. GRAB: (soap)",
        "1. WALK(soap)\n2. Take it",
        "First, WALK(soap)\nGRAB(soap)",
        "# WALK(soap)\nGRAB(soap)",
        "| WALK(soap)\nGRAB(soap)",
        "WALK(soap)\n***GRAB(soap)",
        "WALK(soap)\n\\nGRAB(soap)",
        "WALK(soap)\nnull,GRAB(soap)",
        "WALK(soap)\nRobot: GRAB(soap)",
        "WALK(soap)\n(soap)",
        "WALK(soap) - GRAB(soap)",
        "WALK(soap) - then GRAB soap",
        "WALK(soap): then WALK bin and GRAB soap",
        "WALK(soap): WALK to the bin",
        "WALK(soap): WALK soap",
        "WALK(soap): WALK to it, GRAB it",
        "GRAB(soap): WALK to the soap",
        "1. WALK(soap) # and GRAB soap",
        "1. WALK(soap) # and GRAB soap\n2. PUT(soap, bin)",
        "Answer: WALK(soap) - then GRAB soap because it is needed\nPUT(soap, bin)",
        "PUT(soap, bin)\nAnswer: WALK(soap) - then GRAB soap because it is needed",
        "WALK(soap)\nGRAB(soap)...",
        "WALK(soap)\n<think>\nGRAB(soap)",
        "(WALK",
        '["WALK(soap)", "go away"]',
        '{"action": "PUT soap", "target": "bin"}',
        '{"step1": "WALK(bin)", "step2": "WALK(soap), GRAB(soap)"}',
        '{"1": "WALK(soap)", "2": "GRAB soap"}',
        '{"plan": ["WALK(soap)"], "step2": "GRAB soap"}',
        '{"plan": ["WALK(soap)"], "more": "then GRAB(soap)"}',
        '{"plan": ["WALK(soap)"], "more": "then GRAB soap"}',
        '{"plan": [{"action": "WALK", "object": "soap"}], "more": "and finally grab(soap) with the hand"}',
        '{"plan": "WALK(soap)\\nGRAB(soap)", "rest": "1. PUT(soap, bin)"}',
        '{"plan": ["WALK(soap)"], "rest": "Then: GRAB(soap), PUT(soap, bin), WALK(bin), PUT(soap, bin)"}',
        "(WALK soap",
        "Step 1:\n```\nWALK(soap)\n```\nStep 2:\n```\nGRAB(soap)\n```",
    ],
)
def test_lines_are_read_whole_or_not_at_all(notation: PlanNotation, text: str) -> None:
    assert isinstance(notation.read(text, ACTIONS), Unreadable)


@pytest.mark.parametrize("text", ["WALK(soap)\nthen\nGRAB(soap)", "WALK(soap)\nGRAB the soap"])
def test_the_line_that_cannot_be_read_is_named(text: str) -> None:
    read = JsonPlanNotation().read(text, ACTIONS)
    assert isinstance(read, Unreadable)
    assert read.reason.startswith("line 2 is no step of a plan, and looks like one: ")


def test_a_fence_with_one_step_is_named_if_an_earlier_fence_has_others() -> None:
    text = "Step 1:\n```\nWALK(soap)\n```\n```\nGRAB(soap)\n```"
    read = JsonPlanNotation().read(text, ACTIONS)
    assert isinstance(read, Unreadable)
    assert read.reason == "line 6: the last code fence has only one step, and an earlier one has others"
    assert AnswerSpan(text.index("GRAB"), text.index("GRAB") + 10, AnswerSpanKind.UNREAD) in read.spans


def test_the_last_of_several_whole_plans_counts() -> None:
    fence = "```\nWALK(soap)\n%s(soap)\n```\n"
    plan = JsonPlanNotation().read(f"{fence % 'WALK'}Better:\n{fence % 'GRAB'}", ACTIONS)
    assert isinstance(plan, WrittenPlan)
    assert [tuple(step) for step in plan.steps] == [WALK, GRAB]


@pytest.mark.parametrize("notation", [JsonPlanNotation(), VirtualHomePlanNotation(), PddlPlanNotation()])
@pytest.mark.parametrize(
    "template", ["```\n%s(soap)\n%s(soap)\n```\n", '```json\n["%s(soap)", "%s(soap)"]\n```\n']
)
def test_of_two_plans_in_fences_without_words_between_none_counts(
    notation: PlanNotation, template: str
) -> None:
    first, second = template % ("WALK", "GRAB"), template % ("WALK", "SLEEP")
    assert isinstance(notation.read(f"{first}\n{second}", ACTIONS), Unreadable)
    assert isinstance(notation.read(f"{first}\n{first}", ACTIONS), WrittenPlan)
    plan = notation.read(f"{first}I would rather say:\n{second}", ACTIONS)
    assert isinstance(plan, WrittenPlan)
    assert [step.action for step in plan.steps] == ["WALK", "SLEEP"]


_LONG = 60_000


@pytest.mark.parametrize(
    "run", [" ", "\u00a0", ".", "(", ")", "[", "<", "1", "a", "a ", "1. ", "step ", "- ", ", "]
)
def test_long_runs_of_characters_do_not_take_quadratic_time(run: str) -> None:
    for begin in ("WALK(soap)", "Answer", "Answer 1"):
        JsonPlanNotation().read(f"{begin}{run * (_LONG // len(run))}x\nGRAB(soap)", ACTIONS)


def test_long_runs_of_backticks_between_values_do_not_take_exponential_time() -> None:
    first, second = '["WALK(soap)", "GRAB(soap)"]', '["WALK(soap)", "SLEEP(soap)"]'
    plan = JsonPlanNotation().read(f"{first}\n{'`' * _LONG} so\n{second}", ACTIONS)
    assert isinstance(plan, WrittenPlan)
    assert [step.action for step in plan.steps] == ["WALK", "SLEEP"]


def test_reasoning_inside_a_line_does_not_take_quadratic_time() -> None:
    plan = JsonPlanNotation().read(
        f"WALK(soap)<think>{'so ' * (_LONG // 3)}</think> # to wash it\nGRAB(soap)", ACTIONS
    )
    assert isinstance(plan, WrittenPlan)
    assert [tuple(step) for step in plan.steps] == [WALK, GRAB]


@pytest.mark.parametrize("notation", [JsonPlanNotation(), VirtualHomePlanNotation(), PddlPlanNotation()])
@pytest.mark.parametrize(
    "remark",
    [
        '"reasoning": "First I walk to the soap."',
        '"explanation": "I WALK(soap), since the GRAB(soap) that follows needs it."',
        '"reasoning": "1. WALK soap\\n2. GRAB soap"',
        '"task": "GRAB soap"',
        '"summary": "First I walk to the soap."',
        '"summary": "To do so, WALK(soap) must come before you can GRAB(soap) with one of your hands."',
        '"note": "WALK to the soap",  "confidence": 0.9, "done": true',
    ],
)
def test_remarks_beside_a_plan_in_json_are_harmless(notation: PlanNotation, remark: str) -> None:
    plan = notation.read(f'{{{remark}, "plan": [{{"action": "WALK", "object": "soap"}}]}}', ACTIONS)
    assert isinstance(plan, WrittenPlan)
    assert [tuple(step) for step in plan.steps] == [WALK]


def test_lines_are_not_read_if_the_names_of_actions_are_unknown() -> None:
    assert isinstance(JsonPlanNotation().read("WALK(soap)"), Unreadable)


def test_a_pddl_plan_may_have_lines_of_actions() -> None:
    plan = PddlPlanNotation().read("1. pick(ball1, rooma)\n2. DROP ball1 rooma", ("pick", "drop"))
    assert isinstance(plan, WrittenPlan)
    assert [step.objects for step in plan.steps] == [("ball1", "rooma")] * 2
    assert "action_lines" in plan.repairs


@pytest.mark.parametrize("step", ['{"action": "%s", "objects": ["soap"]}', '{"%s": ["soap"]}'])
@pytest.mark.parametrize("word", ["walk", "Walk"])
def test_steps_in_json_may_name_actions_in_other_letter_case(step: str, word: str) -> None:
    plan = JsonPlanNotation().read(f"[{step % word}]", ACTIONS)
    assert isinstance(plan, WrittenPlan)
    assert [tuple(each) for each in plan.steps] == [WALK]
    assert "letter_case" in plan.repairs


def test_a_name_that_differs_from_two_actions_in_letter_case_is_not_changed() -> None:
    plan = JsonPlanNotation().read('[{"action": "Walk", "object": "soap"}]', ("WALK", "walk"))
    assert isinstance(plan, WrittenPlan)
    assert plan.steps[0].action == "Walk"
    assert plan.repairs == ()


def test_a_name_of_mixed_letters_is_not_changed() -> None:
    plan = JsonPlanNotation().read('[{"action": "WAlk", "object": "soap"}]', ACTIONS)
    assert isinstance(plan, WrittenPlan)
    assert plan.steps[0].action == "WAlk"


def test_json_in_brackets_is_no_step_of_pddl() -> None:
    for text in (
        '([{"action": "WALK", "object": "soap"}])',
        '[{"action": "WALK", "object": "soap"}]\n(note)',
    ):
        plan = PddlPlanNotation().read(text, ACTIONS)
        assert isinstance(plan, WrittenPlan)
        assert [tuple(step) for step in plan.steps] == [WALK]
    assert isinstance(
        PddlPlanNotation().read('(WALK soap)\n{"action": "GRAB", "object": "soap"', ACTIONS), Unreadable
    )


@pytest.mark.parametrize(
    "text",
    [
        "(pick a); (drop a)",
        "; (pick a)\n(drop a)",
        ";pick a)\n(drop a)",
        "(pick a)\n; (drop b)\n(pick c)",
        "(pick a)\n; (drop b).\n(pick c)",
        "(pick a)\n; (drop b).\r\n(pick c)",
        "(pick a)\n(drop b) ; (pick c).\n(drop c)",
        "(pick a)\n;(drop b).\u2028(pick c)",
        "(pick a)\n; (drop b).",
        "(drop a)\nNext (pick a)",
        "(drop a)\n... (pick a)",
    ],
)
def test_a_step_of_pddl_is_neither_comment_nor_prose(text: str) -> None:
    assert isinstance(PddlPlanNotation().read(text, ("pick", "drop")), Unreadable)


def test_a_comment_behind_a_step_of_pddl_is_ignored() -> None:
    plan = PddlPlanNotation().read("; pick the ball (if it is free)\n(pick a). ; cost 1", ("pick", "drop"))
    assert isinstance(plan, WrittenPlan)
    assert [tuple(step) for step in plan.steps] == [("pick", ("a",))]


def test_a_step_whose_bracket_is_before_the_sign_of_a_comment_is_not_dropped() -> None:
    plan = PddlPlanNotation().read("(;pick a)\n(drop a)", ("pick", "drop"))
    assert isinstance(plan, WrittenPlan)
    assert [step.action for step in plan.steps] == [";pick", "drop"]
