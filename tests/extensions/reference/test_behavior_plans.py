from __future__ import annotations

import gc

import pytest

from eai.abilities.verdict import Unreadable
from eai.extensions.reference.behavior_plans import read_plan

OPEN = ("OPEN", ("jar_0",))


@pytest.mark.parametrize(
    ("text", "steps"),
    [
        ('[{"action": "OPEN", "object": "jar_0"}]', [OPEN]),
        ("```json\n[{'action': 'OPEN', 'object': 'jar_0'}]\n```", [OPEN]),
        ('{"output": [{"action": "OPEN", "object": "jar_0"}]}', [OPEN]),
        ('[{"action": "OPEN", "object": "jar_0"}, # the jar\n]', [OPEN]),
        ('[{"action": "OPEN", # first: "it"\r"object": "jar_0"}]', [OPEN]),
        (
            '[{"action": "OPEN", "object": "jar#0"} # {"action": "X", "object": "y"}\n]',
            [("OPEN", ("jar#0",))],
        ),
        ("[{'action': 'OPEN', 'object': 'jar#0'}, # \"why\"\n]", [("OPEN", ("jar#0",))]),
        ('[dict(action="OPEN", object="jar_0")]', [OPEN]),
        ('[{"action": "OPEN", "object": "jar_0"}, 7, {"action": "CLOSE"}]', [OPEN]),
        ('[{"action": "OP" "EN", "object": "jar\\u005f0"}]', [OPEN]),
        ('[{"action": "OPEN", "object": "jar_0", "why": 3}]', [OPEN]),
        ('[{"action": "PUT", "object": " a, b "}]', [("PUT", ("a", "b"))]),
        ('[{"action": "OPEN", "object": f"jar_0"}]', [OPEN]),
        ('[{"action": f"OP" "EN", "object": f"jar_0", "why": f"{{}}"}]', [OPEN]),
        ('[{"action": "OPEN", "object": "jar_0", 7: (1, {2})}]', [OPEN]),
        ('[{**{"action": "OPEN"}, "object": "jar_0"}]', [OPEN]),
        ('[dict(action="CLOSE", **{"object": "jar_0"}), dict()]', [("CLOSE", ("jar_0",))]),
    ],
)
def test_steps_that_are_found(text: str, steps: list[tuple[str, tuple[str, ...]]]) -> None:
    plan = read_plan(text)
    assert not isinstance(plan, Unreadable)
    assert [tuple(step) for step in plan.steps] == steps


@pytest.mark.parametrize(
    "text",
    [
        "",
        "no list",
        "[]",
        "] [",
        '[{"action": "OPEN", "object": "jar_0"}',
        '[{"action": "OPEN", "object": ["jar_0"]}]',
        '[{"action": "OPEN", "object": "jar_0", "done": true}]',
        '[{"action": "OPEN", "object": "jar_0", "why": NaN}]',
        '[x for x in "a"]',
        '[__import__("os").system("true")]',
        '[dict([("action", "OPEN")])]',
        '[{"action": "OPEN", "object": f"jar_{0}"}]',
        '[{"action": "OPEN", "object": f"{str()}jar_0"}]',
        '[{**7, "action": "OPEN", "object": "jar_0"}]',
        '[{{"y"}: 3, "action": "OPEN", "object": "jar_0"}]',
        "[" * 5000,
    ],
)
def test_texts_without_steps(text: str) -> None:
    assert isinstance(read_plan(text), Unreadable)


def test_reading_a_list_of_constants_leaves_nothing_to_the_garbage_collector() -> None:
    text = "[" + "{'action': f'OPEN', 'object': 'jar_0', 7: 8}, " * 20 + "]"
    read_plan(text)
    gc.collect()
    gc.disable()
    try:
        assert not isinstance(read_plan(text), Unreadable)
        assert gc.collect() == 0
    finally:
        gc.enable()
