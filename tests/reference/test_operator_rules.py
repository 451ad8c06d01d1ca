"""How the reference cuts operators out of answers."""

from __future__ import annotations

import pytest

from abilities.transition_modeling.test_extraction import BOTH, NAMES, OPEN, SHUT, wrapped
from eai.reference.operator_rules import extract_as_reference


@pytest.mark.parametrize(
    ("answer", "names"),
    [
        (wrapped(BOTH), NAMES),
        (BOTH, NAMES),
        (f"```json{wrapped(BOTH)}```", NAMES),
        (
            f" ```json{wrapped(BOTH)}```",
            NAMES,
        ),  # The fence is no fence, but the text is searched all the same.
        (f"{OPEN} ; comment\n{SHUT}", ("open",)),  # Line ends go first, so the comment swallows the rest.
        (wrapped(f"{OPEN} ; comment\n{SHUT}"), NAMES),
        (BOTH.upper(), ()),
        (wrapped(BOTH.replace("close", "close-it")), ("open", "close")),
        (
            wrapped(f"(:action a :parameters () :precondition ()) {OPEN}"),
            ("a",),
        ),  # Borrows the effect of open.
        (wrapped(f"{OPEN} (:action a :parameters () :precondition ())"), ("open",)),
        (wrapped(f"{OPEN} {OPEN.replace('shut', 'locked')}"), ("open",)),
        (wrapped(""), ()),
        ("no operators", ()),
    ],
)
def test_the_reference_finds(answer: str, names: tuple[str, ...]) -> None:
    found = extract_as_reference(answer)
    assert found is not None
    assert tuple(operator.name for operator in found) == names


@pytest.mark.parametrize(
    "answer",
    [
        "[]",
        "3",
        '{"output": 3}',
        '{"output": null}',
        '{"a": 1}',
        "(:action a :parameters (:precondition :effect",
    ],
)
def test_the_reference_calls_a_format_error(answer: str) -> None:
    assert extract_as_reference(answer) is None


def test_the_reference_makes_unbalanced_parts_unreadable() -> None:
    found = extract_as_reference("(:action a :parameters () :precondition (and (p) :effect (q)")
    assert found is not None
    assert (found[0].precondition, found[0].effect) == ("(()", "(q)")


def test_the_reference_does_not_count_a_parenthesis_right_behind_the_first() -> None:
    found = extract_as_reference("(:action a :parameters () :precondition ((p) (q)) :effect (q))")
    assert found is not None
    assert found[0].precondition == "((p)"
