from __future__ import annotations

import pytest

from eai.results.words import Call, read_call


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
