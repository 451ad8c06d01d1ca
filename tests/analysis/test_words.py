from __future__ import annotations

import pytest

from eai.analysis.words import Call, names_in, read_call


@pytest.mark.parametrize(
    ("text", "call"),
    [
        ("open(jar_0)", Call("open", ("jar_0",))),
        ("not open(jar_0)", Call("open", ("jar_0",), positive=False)),
        ("PUTIN(soap.1, box.2)", Call("PUTIN", ("soap.1", "box.2"))),
        ("STANDUP()", Call("STANDUP", ())),
        ("TOUCH", Call("TOUCH", None)),
        ("{'state': 'ON'}", Call("{'state': 'ON'}", None)),
    ],
)
def test_atoms_and_steps_are_read_again(text: str, call: Call) -> None:
    assert read_call(text) == call


@pytest.mark.parametrize(
    ("goal", "names"),
    [
        ("exists x: jar.n.01. (inside(peach_0, x) and not inside(plum_0, x))", ("inside",)),
        ("ontop(a, b) or nextto(a, b)", ("ontop", "nextto")),
        ("TOUCH or GRAB", ("TOUCH", "GRAB")),
    ],
)
def test_a_goal_mentions_each_predicate_once(goal: str, names: tuple[str, ...]) -> None:
    assert names_in(goal) == names
