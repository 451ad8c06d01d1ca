from __future__ import annotations

import jsonschema
import pytest

from eai.abilities.answer_text import MAX_ANSWER_CHARACTERS
from eai.abilities.notation.plan_form import WrittenPlan
from eai.abilities.notation.plans import JsonPlanNotation, PddlPlanNotation
from eai.abilities.verdict import Unreadable
from eai.logic.formula import Variable
from eai.world.action import Action
from eai.world.domain import Domain
from eai.world.operator import Operator
from eai.world.vocabulary import Vocabulary
from world import toy

NOTATION = JsonPlanNotation()
OPEN = ("OPEN", ("jar_0",))


@pytest.mark.parametrize(
    ("text", "steps", "repairs"),
    [
        ('[{"action": "OPEN", "object": "jar_0"}]', [OPEN], ()),
        ('Sure [1]:\n```json\n[{"action": "OPEN", "object": "jar_0"}]\n```', [OPEN], ("code_fence",)),
        ("[{'action': 'OPEN', 'object': 'jar_0'}]", [OPEN], ("single_quotes",)),
        ('{"plan": [{"action": "OPEN", "object": "jar_0"}]}', [OPEN], ()),
        ('{"output": [{"action": "OPEN", "object": "jar_0"}]}', [OPEN], ("wrapper_key",)),
        ('{"thoughts": "a jar", "plan": [{"action": "OPEN", "object": "jar_0"}]}', [OPEN], ("wrapper_key",)),
        ('{"action": "OPEN", "object": "jar_0"}\n{"action": "WAIT", "object": ""}',
         [OPEN, ("WAIT", ())], ("json_lines",)),
        ('[{"action": "OPEN", "object": "jar_0"},]', [OPEN], ("trailing_comma",)),
        ('[{"action": "OPEN", "args": ["jar_0"], "reason": "it is shut"}]', [OPEN], ("step_form",)),
        ("[]", [], ()),
        ('[{"action": "OPEN", "object": "jar_0"} # the jar\n]', [OPEN], ("comments",)),
        ('[{"action": "OPEN", "object": "jar_0"}, # don\'t close\n]', [OPEN], ("comments", "trailing_comma")),
        ('[{"action": "PUT", "object": ["a", "b"]}]', [("PUT", ("a", "b"))], ()),
        ('[{"action": "WAIT", "object": ""}]', [("WAIT", ())], ()),
        ('[{"action": "PUT", "object": "a, b"}]', [("PUT", ("a", "b"))], ()),
    ],
)  # fmt: skip
def test_steps_are_read_in_several_forms(
    text: str, steps: list[tuple[str, tuple[str, ...]]], repairs: tuple[str, ...]
) -> None:
    plan = NOTATION.read(text)
    assert not isinstance(plan, Unreadable)
    assert [tuple(step) for step in plan.steps] == steps
    assert plan.repairs == repairs


@pytest.mark.parametrize(
    "text",
    ["", "{}", '[{"action": "OPEN"}]', '[{"action": 1, "object": "jar_0"}]', '["OPEN jar_0"]'],
)
def test_a_text_without_steps_is_an_empty_plan_or_unreadable(text: str) -> None:
    assert isinstance(NOTATION.read(text), Unreadable)


@pytest.mark.parametrize(
    ("text", "cut_off"),
    [
        ('[{"action": "OPEN", "object": "jar_0"}, {"action": "OP', True),
        ('[{"action": "OPEN", "object": "jar_0"}, {"action": "OP]', False),
        ('[{"action": "OPEN", "object": "jar_0"}', True),
        ('[{"action": "OPEN"}]', False),
        ("I cannot [do] that.", False),
        ("", False),
    ],
)
def test_a_truncated_answer_differs_from_one_without_steps(text: str, cut_off: bool) -> None:
    found = NOTATION.read(text)
    assert isinstance(found, Unreadable)
    assert found.reason.startswith("there is no list of steps with an action and an object")
    assert ("this bracket is not closed" in found.reason) is cut_off


@pytest.mark.parametrize(
    ("step", "why"),
    [
        ('{"action": "RELEASE"}', 'step 2 has no "object"'),
        ('"RELEASE"', 'step 2 has no "action"'),
        ('{"action": "RELEASE", "object": null}', "step 2 has another form"),
    ],
)
def test_the_error_names_the_first_step_of_another_form(step: str, why: str) -> None:
    found = NOTATION.read(f'{{"plan": [{{"action": "OPEN", "object": "jar_0"}}, {step}, {step}]}}')
    assert isinstance(found, Unreadable)
    assert found.reason == f"there is no list of steps with an action and an object: {why}"


@pytest.mark.parametrize(
    ("steps", "text"),
    [
        ([], "[]"),
        ([("LIFT", ("red",))], '[{"action": "LIFT", "object": "red"}]'),
        ([("SWAP", ("red", "blue"))], '[{"action": "SWAP", "object": "red, blue"}]'),
        (
            [("WAIT", ()), ("WAIT", ())],
            '[{"action": "WAIT", "object": ""}, {"action": "WAIT", "object": ""}]',
        ),
    ],
)
def test_written_plans_are_read_back(steps: list[tuple[str, tuple[str, ...]]], text: str) -> None:
    scene = toy.initial().scene
    plan = [Action(name, tuple(scene.index[each] for each in objects)) for name, objects in steps]
    assert NOTATION.join(NOTATION.write(plan, scene)) == text
    read = NOTATION.read(text)
    assert isinstance(read, WrittenPlan)
    assert steps == [tuple(step) for step in read.steps]


def test_two_objects_without_known_words_may_be_any_text() -> None:
    x, y = Variable("x"), Variable("y")
    domain = Domain("shop", Vocabulary(()), (Operator("SWAP", (x, y), (), ()),))
    step = {"action": "SWAP", "object": "lamp, cup"}
    jsonschema.validate({"plan": [step]}, NOTATION.make_json_schema_of_answer(domain, None))
    jsonschema.validate({"plan": [step]}, NOTATION.make_json_schema_of_answer(domain, ("cup", "lamp")))
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate({"plan": [step]}, NOTATION.make_json_schema_of_answer(domain, ("cup",)))


PICK, DROP = ("pick", ("ball1", "rooma", "left")), ("drop", ("ball1", "roomb", "left"))
LINES = "(pick ball1 rooma left)\n(drop ball1 roomb left)"


@pytest.mark.parametrize(
    ("text", "steps", "repairs"),
    [
        (LINES, [PICK, DROP], ()),
        ("; 2\n(pick ball1 rooma left) ; 1\n\n  (drop ball1 roomb left)\n; cost = 2", [PICK, DROP], ()),
        ("0.000: (pick ball1 rooma left) [1.000]\n1: (drop ball1 roomb left)", [PICK, DROP], ()),
        (f"```\n{LINES}\n```", [PICK, DROP], ("code_fence",)),
        (f"First:\n```\n(wait)\n```\nNo:\n```\n{LINES}\n```", [PICK, DROP], ("prose", "code_fence")),
        (f"The plan is:\n\n{LINES}\nThat is all.", [PICK, DROP], ("prose",)),
        ("Step 1:\n(pick ball1 rooma left)\n2. (drop ball1 roomb left)", [PICK, DROP], ("numbered",)),
        ("; cost = 0", [], ()),
        ("(wait)", [("wait", ())], ()),
        ('[{"action": "pick", "object": "ball1, rooma, left"}]', [PICK], ()),
    ],
)  # fmt: skip
def test_plans_are_read_as_planners_write_them(
    text: str, steps: list[tuple[str, tuple[str, ...]]], repairs: tuple[str, ...]
) -> None:
    plan = PddlPlanNotation().read(text)
    assert not isinstance(plan, Unreadable)
    assert [tuple(step) for step in plan.steps] == steps
    assert plan.repairs == repairs


@pytest.mark.parametrize(
    ("text", "line"),
    [
        (f"{LINES}\nwait", "line 3"),
        (f"{LINES}\nWait", "line 3"),
        ("(pick ball1 rooma left)\nthen\n(drop ball1 roomb left)", "line 2"),
        (f"{LINES}\n(wait", "line 3"),
        (f"(wait)\n```\n{LINES}\n```", "line 1"),
        ('(pick ball1 rooma left)\n[{"action": "wait"}]\n(wait)', "line 2"),
    ],
)
def test_a_line_that_looks_like_a_step_is_not_prose(text: str, line: str) -> None:
    plan = PddlPlanNotation().read(text, ("pick", "drop", "wait"))
    assert isinstance(plan, Unreadable)
    assert plan.reason.startswith(f"{line} is no step of a plan, and looks like one: ")


@pytest.mark.parametrize("text", ["", "()", "pick ball1", "(pick (ball1))", "see (pick)"])
def test_lines_without_steps_are_no_plan(text: str) -> None:
    assert isinstance(PddlPlanNotation().read(text), Unreadable)


def test_lines_of_an_excessive_text_are_not_read() -> None:
    assert isinstance(PddlPlanNotation().read(f"{LINES}\n{' ' * MAX_ANSWER_CHARACTERS}"), Unreadable)


def test_only_a_pddl_domain_takes_lines() -> None:
    assert isinstance(JsonPlanNotation().read(LINES), Unreadable)
