from __future__ import annotations

import pytest

from eai.abilities.action_sequencing.behavior_answer import read_plan
from eai.abilities.action_sequencing.plan import Unreadable

OPEN = ("OPEN", ("jar_0",))


@pytest.mark.parametrize(
    ("text", "steps", "repairs"),
    [
        ('[{"action": "OPEN", "object": "jar_0"}]', [OPEN], ()),
        ('Sure [1]:\n```json\n[{"action": "OPEN", "object": "jar_0"}]\n```', [OPEN], ("code_fence",)),
        ("[{'action': 'OPEN', 'object': 'jar_0'}]", [OPEN], ("single_quotes",)),
        ('{"output": [{"action": "OPEN", "object": "jar_0"}]}', [OPEN], ()),
        ('[{"action": "OPEN", "object": "jar_0"} # the jar\n]', [OPEN], ("comments",)),
        ('[{"action": "OPEN", "object": "jar_0"}, # don\'t close\n]', [OPEN], ("single_quotes",)),
        ('[{"action": "PUT", "object": ["a", "b"]}]', [("PUT", ("a", "b"))], ()),
        ('[{"action": "PUT", "object": "a, b"}]', [("PUT", ("a", " b"))], ()),
    ],
)  # fmt: skip
def test_steps_that_are_found(
    text: str, steps: list[tuple[str, tuple[str, ...]]], repairs: tuple[str, ...]
) -> None:
    plan = read_plan(text)
    assert not isinstance(plan, Unreadable)
    assert [tuple(step) for step in plan.steps] == steps
    assert plan.repairs == repairs


@pytest.mark.parametrize(
    "text",
    ["", "[]", "{}", '[{"action": "OPEN"}]', '[{"action": 1, "object": "jar_0"}]', '["OPEN jar_0"]'],
)
def test_texts_without_steps(text: str) -> None:
    assert isinstance(read_plan(text), Unreadable)
