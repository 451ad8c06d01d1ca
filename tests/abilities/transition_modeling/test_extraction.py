from __future__ import annotations

import json

import pytest

from eai.abilities.transition_modeling.extraction import extract
from eai.abilities.transition_modeling.memory import Memory
from eai.benchmarks.reference.operator_extraction import extract_as_reference
from eai.pddl.model import PddlAction
from eai.pddl.offence import Offence, PddlFinding

OPEN = "(:action open :parameters (?o) :precondition (shut ?o) :effect (not (shut ?o)))"
SHUT = "(:action close :parameters (?o) :precondition () :effect (shut ?o))"
BOTH = f"{OPEN}\n{SHUT}"


def wrapped(text: str) -> str:
    return json.dumps({"output": text})


@pytest.mark.parametrize(
    ("answer", "repairs"),
    [
        (wrapped(BOTH), ()),
        (json.dumps({"output": [OPEN, SHUT]}), ()),
        (f"```json\n{wrapped(BOTH)}\n```", ("code_fence",)),
        (f"```\n{wrapped(BOTH)}\n```", ("code_fence",)),
        (f"Here you are: {wrapped(BOTH)} I hope so.", ("prose",)),
        (f"<think>(:action</think>{wrapped(BOTH)}", ("reasoning",)),
        (BOTH, ("no_json",)),
        (f"I would say:\n```pddl\n{BOTH}\n```", ("no_json",)),
        (f'{{"output": "{BOTH}"}}', ("no_json",)),
        (f'{{"output": "{OPEN}\\n{SHUT}"', ("no_json", "escapes")),
        (wrapped(BOTH.upper()), ()),
        (wrapped(BOTH.replace("\n", " ; a comment (with a parenthesis\n")), ()),
        (wrapped(f"{OPEN}) {SHUT}"), ("stray_parenthesis",)),
        (wrapped(f"{OPEN[:-1]}\n{SHUT}"), ("closing_parenthesis",)),
        (wrapped(f"{SHUT}{BOTH}"), ("duplicate_operator",)),
    ],
)
def test_operators_are_found_and_repairs_are_named(answer: str, repairs: tuple[str, ...]) -> None:
    found = extract(answer, Memory())
    assert found is not None
    assert [operator.name for operator in found.operators] == ["open", "close"]
    assert all(isinstance(operator.reading, PddlAction) for operator in found.operators)
    assert found.repairs == repairs


@pytest.mark.parametrize("answer", ["", "No.", "{}", "[1]", '{"output": 3}', "(define (domain d))"])
def test_an_answer_without_operators_or_output_is_unreadable(answer: str) -> None:
    assert extract(answer, Memory()) is None


def test_an_output_without_operators_is_empty() -> None:
    found = extract(wrapped("none"), Memory())
    assert found is not None
    assert found.operators == ()


def test_a_broken_operator_does_not_take_the_others_with_it() -> None:
    broken = "(:action lift :parameters (?o) :precondition (and (shut ?o) :effect (shut"
    found = extract(wrapped(f"{OPEN} {broken} {SHUT}"), Memory())
    assert found is not None
    readings = {operator.name: operator.reading for operator in found.operators}
    assert list(readings) == ["open", "lift", "close"]
    lift = readings["lift"]
    assert isinstance(lift, PddlFinding)
    assert lift.offence is Offence.UNBALANCED


def test_of_two_operators_of_one_name_the_last_counts() -> None:
    found = extract(wrapped(f"{OPEN} (:action OPEN :effect (shut k))"), Memory())
    assert found is not None
    (operator,) = found.operators
    assert isinstance(operator.reading, PddlAction)
    assert operator.reading.parameters == ()


NAMES = ("open", "close")


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
