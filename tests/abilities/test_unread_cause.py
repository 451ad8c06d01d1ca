"""The causes for which nothing in an answer could be read, on answers in our own words."""

from __future__ import annotations

from time import process_time

import pytest

from eai.abilities.answer_text import MAX_ANSWER_CHARACTERS
from eai.abilities.explanation import VerdictExplanation
from eai.abilities.notation.plans import JsonPlanNotation
from eai.abilities.protocol import Ability
from eai.abilities.unread_cause import find_cause_of_unreadability, find_repeated_ending, mark_as_cut_off
from eai.abilities.verdict import ErrorReport, PlanVerdict
from eai.world.fault import FaultKind

ACTIONS = ("WALK", "GRAB", "PUTBACK")
STEP = '{"action": "WALK", "object": "soap"}'


def cause_of(text: str, ability: Ability | None = None) -> str | None:
    found = find_cause_of_unreadability(text, ACTIONS, lambda: ability)
    return None if found is None else found.cause


@pytest.mark.parametrize(
    ("text", "cause"),
    [
        ("", "empty"),
        (" \n", "empty"),
        ("{}", "empty"),
        ("```json\n[]\n```", "empty"),
        ('{"plan": []}', "empty"),
        ("<|eot_id|>", "empty"),
        ("\n" * 2000 + "}", "empty"),
        ("<think>The soap is dirty.</think>", "empty"),
        ("<think>First I walk, then", "unfinished_thought"),
        ("Sure.\n<think>First I walk, then", "unfinished_thought"),
        ("I'm sorry, but I can't help with that.", "refusal"),
        ("As an AI language model, I have no body.", "refusal"),
        ("I cannot do this task.", "refusal"),
        ("I cannot.", "refusal"),
        ("I am unable to wash clothes.", "refusal"),
        ("I'm sorry to say so, but the soap is far away: walk there first.", "prose"),
        ("As an AI language model, I will help you to wash the clothes.", "prose"),
        ("I cannot see the soap from here, so I walk to the bathroom.", "prose"),
        ("The robot walks to the soap and grabs it.", "prose"),
        ("1. Go to the bathroom.\n2. Find the soap.", "prose"),
        ("To wash the soap (it is dirty), go [there].", "prose"),
        (f"[{STEP}, {STEP[:20]}", "cut_off"),
        (f"[{STEP}", "cut_off"),
        (f"[{STEP}, {STEP[:20]}]", "cut_off"),
        (f"[{STEP}, {{\n]", "cut_off"),
        ('{"output": "(:action walk\\n :parameters (?x - obj\\n}', "cut_off"),
        ("robot.walk(soap)\nrobot.grab(soap)", "other_notation"),
        ("1. WALK(soap) - go there\n2. GRAB(soap) - take it", "other_notation"),
        ("1. WALK to the soap\n2. GRAB the soap", "other_notation"),
        ('["WALK soap", "GRAB soap"]', "other_notation"),
        ("(and (clean soap)\n     (inside soap sink))", "other_notation"),
        ("<plan><step>walk</step></plan>", "other_notation"),
        ("```python\ndef wash():\n    pass\n```", "other_notation"),
        ('{"output":\n(:action walk :parameters (?x) :effect (at ?x))\n', "other_notation"),
        (f"[{STEP}, {{\"action\": \"GRAB\"}}]", None),
        (f"[{STEP}}}]", None),
        ('{"steps": 3}', None),
        ('{"WALK": ["cd\\_player"]}', None),
    ],
)  # fmt: skip
def test_the_cause_is_found_from_the_text(text: str, cause: str | None) -> None:
    assert cause_of(text) == cause


def test_the_form_of_another_ability_is_named() -> None:
    found = find_cause_of_unreadability(
        '{"node goals": [["open", "jar"]]}', ACTIONS, lambda: Ability.GOAL_INTERPRETATION
    )
    assert found == ("other_ability", "the answer has the form of goal interpretation")


@pytest.mark.parametrize(
    ("text", "unit"),
    [
        ("I will walk to the soap. " * 30, "I will walk to the soap."),
        ("Fine. " + "walk walk " * 20, "walk"),
        ("[" + f"{STEP}, " * 12 + STEP[:9], f"{STEP},"),
        ("".join(f"{n}. WALK to the soap\n" for n in range(1, 40)), "WALK to the soap"),
        ('{"output": "' + "\\n" * 900 + "}", "\\n"),
        ("<think>" + "Wait, is it clean? " * 40, "Wait, is it clean?"),
        ("x " * 700 + "then the robot stops and the task is done", ""),
        (f"[{STEP}, {STEP}, {STEP}]", ""),
        ("".join(f'["clean", "cup_{n}"], ' for n in range(40)), ""),
        ("no no no no no", ""),
    ],
)
def test_a_loop_is_the_same_text_again_and_again(text: str, unit: str) -> None:
    found = find_repeated_ending(text)
    assert found.split() == unit.split() or sorted(found.split()) == sorted(unit.split())
    assert bool(unit) is (cause_of(text) == "loop")


HOSTILE = ["\n", " ", "(", "a(", "1.", "WALK(", '"', "{", "</a", "[WALK] <", "WALK soap\n", "- "]


@pytest.mark.parametrize("piece", HOSTILE)
def test_a_cause_takes_time_in_proportion_to_the_text(piece: str) -> None:
    """A quadratic search would take minutes on a text of the maximum length."""
    text = f"so {piece * (MAX_ANSWER_CHARACTERS // len(piece) - 3)} it"
    started = process_time()
    find_cause_of_unreadability(text, ACTIONS, lambda: None)
    JsonPlanNotation().read(text, ACTIONS)
    assert process_time() - started < 20


@pytest.mark.parametrize(
    ("check", "cause"),
    [("prose", "cut_off"), (None, "cut_off"), ("loop", "loop"), ("unfinished_thought", "unfinished_thought")],
)
def test_a_length_limit_explains_prose_but_not_a_loop(check: str | None, cause: str) -> None:
    verdict = PlanVerdict(error=ErrorReport(FaultKind.PARSING, None, "there is no list", check))
    notes = ("parsing: there is no list", f"{check}: the answer is strange")
    marked, explanation = mark_as_cut_off(verdict, VerdictExplanation(notes))
    assert marked.error is not None
    assert marked.error.check == cause
    assert explanation is not None
    assert [note for note in explanation.notes if note.startswith("prose")] == []
    assert ("cut_off: the end of the answer is missing" in explanation.notes) is (cause == "cut_off")


def test_a_length_limit_is_no_cause_of_an_error_in_a_plan() -> None:
    verdict = PlanVerdict(error=ErrorReport(FaultKind.MISSING_STEP, 0, "red is not held", "not_held"))
    assert mark_as_cut_off(verdict, None) == (verdict, None)
