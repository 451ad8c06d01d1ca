from __future__ import annotations

import json
import re
import time
from dataclasses import replace
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from eai.abilities.answer_text import (
    MAX_ANSWER_CHARACTERS,
    MAX_JSON_DEPTH,
    AnswerFormat,
    JsonObject,
    ParsedAnswer,
    contains_json_string,
    read_json,
)
from eai.abilities.verdict import AnswerSpanKind, Unreadable

PLAN = '{"WALK": ["sofa"]}'


def plain(value: object) -> object:
    """Return JSON objects as lists of pairs, at all depths."""
    if isinstance(value, JsonObject):
        return [(key, plain(part)) for key, part in value.members]
    return [plain(part) for part in value] if isinstance(value, list) else value


ANYTHING: AnswerFormat[object] = AnswerFormat("value", plain)
OBJECT: AnswerFormat[object] = AnswerFormat(
    "object",
    lambda value: plain(value) if isinstance(value, JsonObject) and value.members else None,
    is_part=contains_json_string,
    is_answer_line=lambda line: line.startswith("WALK"),
    flaw=lambda value: "a list" if isinstance(value, list) else None,
)


def found(text: str, form: AnswerFormat[object] = OBJECT) -> object:
    reading = read_json(text, form)
    return reading.value if isinstance(reading, ParsedAnswer) else None


@pytest.mark.parametrize(
    ("text", "repairs"),
    [
        (PLAN, ()),
        (f"\n  {PLAN}\n", ()),
        (f"```json\n{PLAN}\n```", ("code_fence",)),
        (f"```\n{PLAN}\n```", ("code_fence",)),
        (f"```json\n{PLAN}", ("code_fence",)),
        (f"Use `json` or ``more``:\n```\n{PLAN}\n```", ("code_fence",)),
        (f"Sure!\n```python\n{PLAN}\n```\nThat's it.", ("code_fence",)),
        (f"Here it is: {PLAN} Good luck!", ("prose",)),
        (f"See [1]. {PLAN}", ("prose",)),
        ("{'WALK': ['sofa']}", ("single_quotes",)),
        ("{'WALK': ['sofa'],}", ("single_quotes",)),
        ("```json\n{'WALK': ['sofa']}\n```", ("code_fence", "single_quotes")),
        ("It's {'WALK': ['sofa']}", ("prose", "single_quotes")),
        ('{"WALK": ["sofa",],}', ("trailing_comma",)),
        ('{"WALK": ["sofa"], # there\n}', ("comments", "trailing_comma")),
        ('{"WALK": ["sofa"] // there\n}', ("comments",)),
        ("{“WALK”: [“sofa”]}", ("curly_quotes",)),
        ('{"WALK"：\u00a0["sofa"]}', ("wide_characters",)),
        ('{"WALK": ["sofa"] /* ] there */}', ("comments",)),
        ('{\\"WALK\\": [\\"sofa\\"]}', ("escapes",)),
        ("{&quot;WALK&quot;: [&quot;sofa&quot;]}", ("escapes",)),
        (f"[{PLAN}]", ("wrapper_list",)),
        (rf"So \boxed{{{PLAN}}}", ("boxed", "prose", "stray_bracket")),
        (f"{PLAN}\n<think>Was that", ("reasoning",)),
        (f"{PLAN}}}", ("stray_bracket",)),
        (json.dumps(PLAN), ("json_in_string",)),
        (f"{PLAN}<|eot_id|>", ("special_tokens",)),
        (f"<think>{PLAN[:5]} hm</think>{PLAN}", ("reasoning",)),
        (
            f"<think>a</think><think>b</think>```{PLAN}```<|end|>",
            ("reasoning", "special_tokens", "code_fence"),
        ),
    ],
)
def test_json_is_found_and_every_repair_named(text: str, repairs: tuple[str, ...]) -> None:
    reading = read_json(text, OBJECT)
    assert isinstance(reading, ParsedAnswer)
    assert (reading.value, reading.repairs) == ([("WALK", ["sofa"])], repairs)


@pytest.mark.parametrize(
    ("others", "is_read"),
    [
        ({"b": "Walk there."}, True),
        ({"b": 3, "c": None}, True),
        ({"b": "WALK chair"}, False),
        ({"b": "there:\nWALK chair"}, False),
        ({"reasoning": "WALK chair"}, True),
        ({"Chain_of_thought": "WALK chair"}, True),
        ({"reasoning": ["WALK chair"]}, False),
    ],
    ids=str,
)
def test_a_text_beside_a_wrapped_value_is_no_part_of_the_answer(
    others: dict[str, object], is_read: bool
) -> None:
    form: AnswerFormat[object] = replace(
        OBJECT, read=lambda value: value if isinstance(value, list) else None
    )
    text = json.dumps({"plan": ["sofa"], **others})
    assert found(text, form) == (["sofa"] if is_read else None)


def test_a_string_may_hold_line_breaks() -> None:
    reading = read_json('{"a": "b\n\tc"}', OBJECT)
    assert isinstance(reading, ParsedAnswer)
    assert (reading.value, reading.repairs) == ([("a", "b\n\tc")], ("line_breaks",))


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ('{"A": [1], "A": [2]}', [("A", [1]), ("A", [2])]),
        ("{'A': (1,), 'A': [None]}", [("A", [1]), ("A", [None])]),
        ('```{"A": [1]}``` rather ```{"B": [2]}```', [("B", [2])]),
        ('first {"A": [1]}, no, {"B": [2]}', [("B", [2])]),
        ('["A"] is a draft of {"B": [2]}', [("B", [2])]),
        ('{"A": [1]} {"A": [1]}', [("A", [1])]),
        ('{"A": [1]}, {"A": [1]}; no, rather {"B": [2]}', [("B", [2])]),
        ('{"A": "a } in quotes"} or not', [("A", "a } in quotes")]),
        ('{"A": [1]} }', [("A", [1])]),
        ("{'A': ['\\d']}", [("A", ["\\d"])]),
        ("{'A': ['b' 'c', 00,], 'A': {}}", [("A", ["bc", 0]), ("A", [])]),
        ("{'A': ['{', 'é ]', 12]}", [("A", ["{", "é ]", 12])]),
    ],
    ids=str,
)
def test_duplicates_stay_and_the_last_value_wins(text: str, value: object) -> None:
    assert found(text) == value


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ('{ {"A": [1]}', "line 1, column 1: this bracket is not closed, as if the answer were cut off"),
        ('so:\n{"A": ["b"', "line 2, column 1: this bracket is not closed, as if the answer were cut off"),
        ('{"A": ["b"}]', "line 1, column 11: this } does not close the [ of line 1, column 7"),
        ('{"A": ["b" "c"]}', "line 1, column 12: expected ',' delimiter"),
        ('{"A": ["b"]} or\n["c"]', "a list"),
        (
            f"{PLAN}\nWALK chair",
            "line 2, column 1: 'WALK chair' looks like a part of the answer and stands outside",
        ),
        ('{"A": [1]} {"B": [2]}', "looks like a part of the answer and stands outside"),
        ('{"A": [1]}\n---\n{"B": [2]}', "looks like a part of the answer and stands outside"),
        ('1. {"A": [1]}\n2. {"B": [2]}', "looks like a part of the answer and stands outside"),
        (
            '```json\n{"A": [1]}\n```\n\n**\n````json\n{"B": [2]}\n````',
            "looks like a part of the answer and stands outside",
        ),
        (
            '{"A": ["b"]}, "c"]}',
            "line 1, column 19: no opening bracket of a list matches this one: "
            "the parts need a list around them",
        ),
        ("{'A': [...]}", "line 1, column 2: expected property name enclosed in double quotes"),
    ],
    ids=str,
)
def test_an_incomplete_answer_is_unreadable_at_a_position(text: str, reason: str) -> None:
    reading = read_json(text, OBJECT)
    assert isinstance(reading, Unreadable)
    assert reading.reason.startswith("there is no ")
    assert reading.reason.endswith(reason)
    assert AnswerSpanKind.UNREAD in [span.kind for span in reading.spans]


@pytest.mark.parametrize(
    "text",
    [
        f"<think>never closed {PLAN}",
        f"<|channel|>analysis<|message|>{PLAN}",
        f"[THINK]{PLAN}",
        f"◁think▷{PLAN}",
        f'{PLAN}\n<think>and then {{"GRAB": ["cup"]}}',
    ],
)
def test_reasoning_that_is_not_finished_holds_no_answer(text: str) -> None:
    reading = read_json(text, OBJECT)
    assert isinstance(reading, Unreadable)
    assert reading.reason == "the reasoning is never closed, so that there is no answer"


def test_every_part_of_a_text_is_accounted_for() -> None:
    text = f"<think>no</think> So: {PLAN[:-1]},}} Yes."
    reading = read_json(text, OBJECT)
    assert isinstance(reading, ParsedAnswer)
    assert [(text[span.start : span.end], span.kind.value) for span in reading.spans] == [
        ("<think>no</think>", "reasoning"),
        ("So:", "prose"),
        ('{"WALK": ["sofa"],}', "repaired"),
        ("Yes.", "prose"),
    ]


@pytest.mark.parametrize(
    "text",
    [
        "",
        "I cannot do that.",
        '{"WALK": ["so',
        "{'WALK': ['so",
        "{'WALK': open('file')}",
        "{'WALK': [x for x in y]}",
        "{1: ['sofa']}",
        "{'WALK': ['sofa', true]}",
        "{'WALK': [-1]}",
        "{'WALK': ['\ud800']}",
        "{'WALK': {'sofa'}}",
        "{**{'WALK': ['sofa']}}",
        "{" * 100_000,
        "[" * 100_000 + "]" * 100_000,
        '{"a":' * 50_000 + "1" + "}" * 50_000,
        "{'a': " * 300 + "1" + "}" * 300,
        '{"WALK": [' + "1" * 10_000 + "]}",
        "\0",
        "{'WALK': ['\0']}",
        PLAN + " " * MAX_ANSWER_CHARACTERS,
    ],
    ids=lambda text: text[:20],
)
def test_a_text_without_json_is_unreadable(text: str) -> None:
    assert found(text) is None


def test_code_in_an_answer_is_never_run() -> None:
    assert found("{'WALK': [__import__('os').abort()]}", ANYTHING) is None


def test_a_lone_surrogate_counts_as_text() -> None:
    assert found('{"WALK": ["\ud800"]}') == [("WALK", ["\ud800"])]


def test_texts_of_up_to_a_million_characters_are_searched() -> None:
    assert found("[]" + " " * 999_998, ANYTHING) == []
    assert found("[]" + " " * 999_999, ANYTHING) is None


def test_values_are_found_down_to_the_greatest_depth() -> None:
    def nested(depth: int) -> str:
        return "[" * depth + "]" * depth

    assert found(nested(MAX_JSON_DEPTH), ANYTHING) is not None
    assert found(nested(MAX_JSON_DEPTH + 1), ANYTHING) is None
    for depth, is_read in ((MAX_JSON_DEPTH, True), (MAX_JSON_DEPTH + 1, False)):  # in the quotes of Python
        text = "{'a': " * (depth - 1) + "{}" + "}" * (depth - 1)
        assert (found(text, ANYTHING) is not None) is is_read
    around = nested(MAX_JSON_DEPTH)
    assert found(around.replace("[]", "[0]"), ANYTHING) is None  # as deep as its content


@pytest.mark.parametrize(
    "piece",
    [
        "<think>",
        "</think>",
        "<|a",
        '"',
        "'",
        "{",
        "[",
        "{}",
        "{a} ",
        "{'a' b} ",
        "```",
        "```json\n",
        '"A": [',
        "\\",
        '\\"',
        "[/* ",
    ],
)
def test_the_search_takes_time_in_proportion_to_the_text(piece: str) -> None:
    """A quadratic search would take minutes on a text of the maximum length."""
    text = f"{PLAN}\n{piece * (MAX_ANSWER_CHARACTERS // len(piece) - 20)}"
    started = time.process_time()
    read_json(text[len(PLAN) :], OBJECT)
    read_json(text, OBJECT)
    assert time.process_time() - started < 20


WITHOUT_SPECIAL_TOKENS = st.text().filter(lambda text: "<|" not in text)  # these are no part of an answer

PLAIN_JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | WITHOUT_SPECIAL_TOKENS,
    lambda parts: st.lists(parts, max_size=4) | st.dictionaries(WITHOUT_SPECIAL_TOKENS, parts, max_size=4),
    max_leaves=20,
)


@given(PLAIN_JSON)
def test_json_is_read_as_it_was_written(value: object) -> None:
    def from_pairs(value: object) -> object:
        if isinstance(value, JsonObject):
            return {key: from_pairs(part) for key, part in value.members}
        return [from_pairs(part) for part in value] if isinstance(value, list) else value

    reading = read_json(json.dumps(value), AnswerFormat("value", lambda read: (from_pairs(read),)))
    assert isinstance(reading, ParsedAnswer)
    assert reading.value == (value,)


@given(st.text(alphabet="{}[]\"',:` \n\\a1<>|/think", max_size=60))
def test_the_reader_terminates_on_any_text(text: str) -> None:
    reading = read_json(text, OBJECT)
    assert isinstance(reading, Unreadable | ParsedAnswer)
    assert all(0 <= span.start < span.end <= len(text) for span in reading.spans)
    assert all(one.end <= other.start for one, other in pairwise(reading.spans))


@given(st.text(alphabet="{}[]\"',:` \n\\a1<>|/think", max_size=60))
def test_only_blanks_fences_and_control_tokens_have_no_span(text: str) -> None:
    reading = read_json(text, OBJECT)
    left = list(text)
    for span in reading.spans:
        left[span.start : span.end] = " " * (span.end - span.start)
    assert not re.sub(r"```[\w-]*|<\|[\w-]+\|>|[}\]]", "", "".join(left)).strip()
