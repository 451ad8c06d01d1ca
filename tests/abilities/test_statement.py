from __future__ import annotations

import pytest

from eai.abilities.statement import Statement, read_statement


@pytest.mark.parametrize(
    ("text", "call"),
    [
        ("open(jar_0)", Statement("open", ("jar_0",))),
        ("not open(jar_0)", Statement("open", ("jar_0",), positive=False)),
        ("PUTIN(soap.1, box.2)", Statement("PUTIN", ("soap.1", "box.2"))),
        ("STANDUP()", Statement("STANDUP", ())),
        ("TOUCH", Statement("TOUCH", None)),
        ("{'state': 'ON'}", Statement("{'state': 'ON'}", None)),
    ],
)
def test_atoms_and_steps_are_read_again(text: str, call: Statement) -> None:
    assert read_statement(text) == call
