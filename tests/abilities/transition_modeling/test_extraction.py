"""Reading operators from answers, and the limit of their cache."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

from eai.abilities.answer_text import ParsedAnswer
from eai.abilities.transition_modeling.extraction import ResultCache, WrittenOperator, read_operators
from eai.abilities.verdict import Unreadable
from eai.logic.formula import TRUE
from eai.pddl.check import PddlViolationKind
from eai.pddl.model import NO_EFFECT, PddlAction
from eai.pddl.reader import read_action

OPEN = "(:action open :parameters (?o) :precondition (shut ?o) :effect (not (shut ?o)))"
SHUT = "(:action close :parameters (?o) :precondition () :effect (shut ?o))"
BOTH = f"{OPEN}\n{SHUT}"


def wrapped(text: str) -> str:
    return json.dumps({"output": text})


def read(answer: str) -> tuple[list[WrittenOperator], tuple[str, ...]]:
    found = read_operators(answer, ResultCache())
    assert isinstance(found, ParsedAnswer), found
    return list(found.value.values()), found.repairs


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
        (wrapped(f"(define (problem p) (:goal (shut a))))\n{BOTH}"), ()),
        (f"{BOTH}\n{wrapped(BOTH)}", ("no_json", "escapes", "duplicate_operator")),
        (f"See [1] :)\n1) The operators:\n{BOTH}", ("no_json",)),
        (f"{BOTH} ; effect (?o is shut)", ("no_json",)),
        (f"{BOTH}\n\nThe :effect of shut: a) the door b) the wind", ("no_json",)),
        (f"I would say:\n```pddl\n{BOTH}\n```", ("no_json",)),
        (f'{{"output": "{BOTH}"}}', ("line_breaks",)),
        (f'{{"output": {BOTH}}}', ("no_json",)),
        (wrapped(BOTH.upper()), ()),
        (wrapped(BOTH.replace("\n", " ; a comment (with a parenthesis\n")), ()),
        (wrapped(f"{OPEN}) {SHUT}"), ("stray_parenthesis",)),
        (wrapped(f"{OPEN[:-1]}\n{SHUT}"), ("closing_parenthesis",)),
        (wrapped(f"{SHUT}{BOTH}"), ("duplicate_operator",)),
        (wrapped(f"; (:action wait)\n{BOTH}"), ()),
        (wrapped(f"{BOTH}\n ; like (:action open :effect (shut ?o))"), ()),
        (wrapped(f"{BOTH}\n; (:action wait\n;  :effect (shut k))"), ()),
        (f"; (:action wait)\n{BOTH}", ("no_json",)),
        (f"{OPEN} ; its effect (that it is open) counts\n{SHUT}", ("no_json",)),
        (f"{BOTH}\n; (:action wait", ("no_json",)),
        (f"(define (domain d)\n{BOTH})", ("no_json", "stray_parenthesis")),
        (f"```pddl\n(define (domain d)\n{BOTH}\n```", ("no_json",)),
    ],
)
def test_operators_are_found_and_repairs_are_named(answer: str, repairs: tuple[str, ...]) -> None:
    operators, repaired = read(answer)
    assert [operator.name for operator in operators] == ["open", "close"]
    assert all(operator.action is not None and not operator.unread for operator in operators)
    assert repaired == repairs


@pytest.mark.parametrize("answer", ["", "No.", "{}", "[1]", '{"output": 3}', "(define (domain d))"])
def test_an_answer_without_operators_or_output_is_unreadable(answer: str) -> None:
    assert isinstance(read_operators(answer, ResultCache()), Unreadable)


def test_an_output_without_operators_is_empty() -> None:
    operators, _ = read(wrapped("none"))
    assert operators == []


@pytest.mark.parametrize(
    ("broken", "reason"),
    [
        (
            "(:action lift :parameters (?o) :precondition (and (shut ?o) :effect (shut",
            "the effect of lift cannot be read: expected a partner for this opening parenthesis",
        ),
        (
            "(:actoin lift :parameters (?o))",
            "'(:actoin lift :parameters (?o)) (:action' begins no operator",
        ),
        (":action lift :parameters (?o)", "begins no operator, and looks like one"),
        ("(:action lift :parameters (?o)) (wide ?o)", "the parameters of lift cannot be read"),
    ],
)
def test_an_operator_with_wrong_brackets_or_keywords_makes_an_answer_unreadable(
    broken: str, reason: str
) -> None:
    answer = read_operators(wrapped(f"{OPEN} {broken} {SHUT}"), ResultCache())
    assert isinstance(answer, Unreadable)
    assert reason in answer.reason


@pytest.mark.parametrize(
    "answer",
    [
        f'{{"output": "{OPEN}\\n{SHUT}"',
        f"{OPEN}\n{SHUT[:-1]}",
        f"{OPEN}\n(:action close",
        f'{{"output": "{OPEN}", "operators": "{SHUT}"}}',
        f'{{"output": "{OPEN}", "output": "{SHUT}"}}',
        f"{OPEN[20:]}\n{SHUT}",
        f"{OPEN[1:]}\n{SHUT}",
        wrapped(f"{OPEN[20:]}\n{SHUT}"),
        wrapped(f"({OPEN[2:]}\n{SHUT}"),
        wrapped(f"{OPEN}\n;{SHUT[1:]}"),
        wrapped(f"(.{OPEN[2:]}"),
        wrapped(f"{OPEN}\nclose {SHUT[14:]}\n{OPEN}"),
        f'{SHUT}"}}',
        f"{OPEN}\n<think>{SHUT}",
        json.dumps({"output": OPEN, "rest": SHUT[14:]}),
        wrapped(f"; {OPEN}"),
        wrapped(f"{OPEN} ; {SHUT}"),
        f"(define (domain d)\n{OPEN}",
        wrapped("(:action open :precondition (shut ?o)) and :effect (wide ?o))"),
        wrapped("(:action open :precondition (shut ?o) )effect (wide ?o))"),
        wrapped(OPEN.replace(":effect", "; opens it :effect")),
        OPEN.replace(":precondition", ";precondition"),
    ],
)
def test_a_truncated_answer_or_one_with_other_parts_is_unreadable(answer: str) -> None:
    assert isinstance(read_operators(answer, ResultCache()), Unreadable)


def test_an_end_of_json_without_its_beginning_is_named() -> None:
    answer = read_operators(f'{BOTH}"}}', ResultCache())
    assert isinstance(answer, Unreadable)
    assert answer.reason == "the answer ends as a JSON object whose beginning is missing"


def test_many_semicolons_are_searched_once() -> None:
    operators, _ = read(wrapped(f"{BOTH} {';' * 500_000}"))
    assert len(operators) == 2


def test_many_blanks_before_an_operator_are_searched_once() -> None:
    operators, _ = read("\n" * 30_000 + " " * 30_000 + BOTH)
    assert len(operators) == 2


HEAD = "(:action open :parameters (?o)"
EFFECT = PddlViolationKind.EFFECT_IN_CONDITION
BEFORE = ":precondition (and (shut ?o) (near ?o))"
AFTER = ":effect (and (wide ?o))"
OPENED = read_action(f"{HEAD} {BEFORE} {AFTER})")


@pytest.mark.parametrize(
    ("text", "repairs"),
    [
        (f"{HEAD} {BEFORE} {AFTER}", ("closing_parenthesis",)),
        (f"{HEAD} {BEFORE[:-1]} {AFTER})", ("closing_parenthesis",)),
        (f"{HEAD[:-1]} {BEFORE[:-1]} ; )\n {AFTER}", ("closing_parenthesis",)),
        (f"{HEAD} {BEFORE[:-1]} {AFTER}))", ("closing_parenthesis", "stray_parenthesis")),
        (f"{HEAD} {BEFORE}) {AFTER})", ("stray_parenthesis",)),
        (f"{HEAD} {AFTER} {BEFORE})) x", ("stray_parenthesis",)),
    ],
)
def test_missing_and_stray_parentheses_are_repaired(text: str, repairs: tuple[str, ...]) -> None:
    operators, _ = read(wrapped(text))
    (operator,) = operators
    assert (operator.action, operator.unread, operator.repairs) == (OPENED, (), repairs)


@pytest.mark.parametrize(
    ("text", "lost", "offence"),
    [
        (
            f"{HEAD} :precondition (shut ?o) :effect (or (wide ?o)))",
            "effect",
            PddlViolationKind.CONDITION_IN_EFFECT,
        ),
        (
            f"{HEAD} :precondition (and ((shut ?o)) :effect (wide ?o))",
            "precondition",
            PddlViolationKind.MALFORMED,
        ),
        (
            f"{HEAD} :precondition (when (a) (b)) :effect (wide ?o))",
            "precondition",
            PddlViolationKind.EFFECT_IN_CONDITION,
        ),
        (
            f"{HEAD} :precondition (shut ?o) :effect (shut ?o) :effect (wide ?o))",
            "effect",
            PddlViolationKind.MALFORMED,
        ),
        (
            f"{HEAD} :precondition (wide ?o) :precondition (shut ?o) :effect (wide ?o))",
            "precondition",
            PddlViolationKind.MALFORMED,
        ),
    ],
)
def test_an_unreadable_side_leaves_the_other_side_readable(
    text: str, lost: str, offence: PddlViolationKind
) -> None:
    operators, _ = read(wrapped(text))
    (operator,) = operators
    assert [(each.offence, each.place) for each in operator.unread] == [(offence, f"{lost} of open")]
    whole = read_action(f"{HEAD} :precondition (shut ?o) :effect (wide ?o))")
    empty = replace(whole, precondition=TRUE) if lost == "precondition" else replace(whole, effect=NO_EFFECT)
    assert operator.action == empty


@pytest.mark.parametrize(
    "text",
    [
        "(:action)",
        "(:action :parameters ())",
        "(:action open",
        "(:action open (?o) :effect (wide ?o))",
        "(:action open :parameters ?o :precondition (shut ?o) :effect (wide ?o))",
        f"{HEAD} :precondition (shut ?o) :effect (wide ?o) (lit ?o))",
        f"{HEAD} :precondition (shut ?o) :effect (and (not (wide ?o)",
        f"{HEAD} :precondition (shut ?o) :effect",
        f"{HEAD} :precondition (and (or (shut ?o) :effect (wide ?o))",
        f"{HEAD} {BEFORE} {AFTER[:-1]}",
    ],
)
def test_an_operator_whose_parts_are_no_lists_is_unreadable(text: str) -> None:
    assert isinstance(read_operators(wrapped(text), ResultCache()), Unreadable)


def test_an_operator_without_a_valid_side_has_no_meaning() -> None:
    operators, _ = read(f"{HEAD} :precondition ((shut ?o)) :effect ((wide ?o)))")
    (operator,) = operators
    assert operator.action is None
    assert operator.unread


def test_an_operator_may_have_no_parts() -> None:
    operators, _ = read("(:action open)")
    assert operators[0].action == PddlAction("open", (), TRUE, NO_EFFECT)


def test_text_behind_an_operator_does_not_belong_to_it() -> None:
    text = f"{HEAD} :precondition (shut ?o) :effect (wide ?o))\n\nNote that the :effect (of it) is (wide ?o)."
    operators, _ = read(text)
    assert operators[0].action == read_action(text)


def test_the_last_of_two_operators_with_one_name_counts() -> None:
    operators, _ = read(wrapped(f"{OPEN} (:action OPEN :effect (shut k))"))
    (operator,) = operators
    assert operator.action is not None
    assert operator.action.parameters == ()


NAMES = ("open", "close")


def test_results_are_found_once_until_they_are_forgotten() -> None:
    memory: ResultCache[int, str] = ResultCache(limit=6)
    found: list[int] = []

    def recalled(key: int) -> str:
        return memory.get_or_compute(key, size=key, compute=lambda: str(found.append(key) or key))

    assert [recalled(key) for key in (1, 5, 1, 3, 5, 1, 3)] == ["1", "5", "1", "3", "5", "1", "3"]
    assert found == [1, 5, 3, 5, 1, 3]  # 3 displaces 1 and 5; 5 displaces 3
    assert memory.size == 4


def test_a_result_larger_than_the_cache_is_not_kept() -> None:
    memory: ResultCache[str, int] = ResultCache(limit=2)
    assert [memory.get_or_compute("long", 3, lambda: 7), memory.size] == [7, 0]
    assert [memory.get_or_compute("a", 1, lambda: 8), memory.get_or_compute("a", 1, lambda: 9)] == [8, 8]
