from __future__ import annotations

import json
import time

import pytest
from hypothesis import given
from hypothesis import strategies as st

from eai.abilities.json_text import MAX_DEPTH, MAX_LENGTH, Pairs, find_json

PLAN = '{"WALK": ["sofa"]}'


def anything(value: object) -> object | None:
    """Accepts every value but null."""
    return plain(value)


def an_object(value: object) -> object | None:
    return plain(value) if isinstance(value, Pairs) else None


def plain(value: object) -> object:
    """Pairs as a list of pairs, all the way down."""
    if isinstance(value, Pairs):
        return [(key, plain(part)) for key, part in value.members]
    return [plain(part) for part in value] if isinstance(value, list) else value


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
        ("{'WALK': ['sofa']}", ("single_quotes",)),
        ("{'WALK': ['sofa'],}", ("single_quotes",)),
        ("```json\n{'WALK': ['sofa']}\n```", ("code_fence", "single_quotes")),
        ("It's {'WALK': ['sofa']}", ("prose", "single_quotes")),
        (f"{PLAN}<|eot_id|>", ("special_tokens",)),
        (f"<think>{PLAN[:5]} hm</think>{PLAN}", ("reasoning",)),
        (
            f"<think>a</think><think>b</think>```{PLAN}```<|end|>",
            ("reasoning", "special_tokens", "code_fence"),
        ),
        (f"<think>never closed {PLAN}", ("prose",)),
    ],
)
def test_json_is_found_and_every_repair_named(text: str, repairs: tuple[str, ...]) -> None:
    assert find_json(text, an_object) == ([("WALK", ["sofa"])], repairs)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ('{"A": [1], "A": [2]}', [("A", [1]), ("A", [2])]),
        ("{'A': (1,), 'A': [None]}", [("A", [1]), ("A", [None])]),
        ('```{"A": [1]}``` rather ```{"B": [2]}```', [("B", [2])]),
        ('first {"A": [1]}, no, {"B": [2]}', [("B", [2])]),
        ('{"A": "a } in quotes"} or not', [("A", "a } in quotes")]),
        ('{ {"A": [1]}', [("A", [1])]),
        ('{"A": [1]} }', [("A", [1])]),
        ("{'A': ['\\d']}", [("A", ["\\d"])]),
        ("{'A': ['b' 'c', 00,], 'A': {}}", [("A", ["bc", 0]), ("A", [])]),
        ("{'A': ['{', 'é ]', 12]}", [("A", ["{", "é ]", 12])]),
    ],
    ids=str,
)
def test_duplicates_stay_and_the_last_value_wins(text: str, value: object) -> None:
    found = find_json(text, an_object)
    assert found is not None
    assert found[0] == value


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
        PLAN + " " * MAX_LENGTH,
    ],
    ids=lambda text: text[:20],
)
def test_nothing_is_found_where_nothing_is(text: str) -> None:
    assert find_json(text, an_object) is None


def test_an_answer_is_never_run() -> None:
    assert find_json("{'WALK': [__import__('os').abort()]}", anything) is None


def test_lone_surrogates_are_text() -> None:
    assert find_json('{"WALK": ["\ud800"]}', an_object) == ([("WALK", ["\ud800"])], ())


def test_texts_of_up_to_a_million_characters_are_searched() -> None:
    assert find_json("[]" + " " * 999_998, anything) == ([], ())
    assert find_json("[]" + " " * 999_999, anything) is None


def test_values_are_found_down_to_the_greatest_depth() -> None:
    def nested(depth: int) -> str:
        return "[" * depth + "]" * depth

    assert find_json(nested(MAX_DEPTH), anything) is not None
    assert find_json(nested(MAX_DEPTH + 1), anything) is None
    for depth, found in ((MAX_DEPTH, True), (MAX_DEPTH + 1, False)):  # in the quotes of Python
        text = "{'a': " * (depth - 1) + "{}" + "}" * (depth - 1)
        assert (find_json(text, anything) is not None) is found
    around = nested(MAX_DEPTH)
    assert find_json(around.replace("[]", "[0]"), anything) is None  # as deep as what it holds


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
    ],
)
def test_the_search_takes_time_in_proportion_to_the_text(piece: str) -> None:
    """Quadratic search would take minutes on a text of the greatest length."""
    text = piece * (MAX_LENGTH // len(piece))
    started = time.process_time()
    find_json(text, an_object)
    assert time.process_time() - started < 20


WITHOUT_SPECIAL_TOKENS = st.text().filter(lambda text: "<|" not in text)  # these are no part of an answer

PLAIN_JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | WITHOUT_SPECIAL_TOKENS,
    lambda parts: st.lists(parts, max_size=4) | st.dictionaries(WITHOUT_SPECIAL_TOKENS, parts, max_size=4),
    max_leaves=20,
)


@given(PLAIN_JSON)
def test_json_reads_as_what_was_written(value: object) -> None:
    def from_pairs(value: object) -> object:
        if isinstance(value, Pairs):
            return {key: from_pairs(part) for key, part in value.members}
        return [from_pairs(part) for part in value] if isinstance(value, list) else value

    found = find_json(json.dumps(value), lambda read: (from_pairs(read),))
    assert found is not None
    assert found[0] == (value,)


@given(st.text(alphabet="{}[]\"',:` \n\\a1<>|/think", max_size=60))
def test_whatever_the_text_is_the_search_ends(text: str) -> None:
    found = find_json(text, an_object)
    assert found is None or isinstance(found[0], list)


LITERALS = st.one_of(PLAIN_JSON.map(repr), st.text(alphabet="{}[]',:0 a\\n\"", max_size=30))


@given(LITERALS)
def test_a_literal_is_read_alike_with_and_without_a_comment_in_it(inside: str) -> None:
    """What JSON would read but for the quotes takes another way than other literals, and means the same."""
    assert as_a_whole(f"['', {inside}]") == as_a_whole(f"['', {inside}#\n]")


def as_a_whole(text: str) -> object:
    found = find_json(text, anything)
    return found if found is not None and found[1] == ("single_quotes",) else None


def outermost(text: str) -> list[str]:
    """The outermost bracketed stretches of a text, found mark by mark."""
    opened: list[int] = []
    closed: list[tuple[int, int]] = []
    quoted = escaped = False
    for position, mark in enumerate(text):
        if escaped or mark == "\\":
            escaped = not escaped
        elif mark == '"':
            quoted = bool(opened) and not quoted
        elif mark in "{[" and not quoted:
            opened.append(position)
        elif mark in "}]" and not quoted and opened:
            start = opened.pop()
            closed = [pair for pair in closed if pair[0] < start] + [(start, position + 1)]
    return [text[start:end] for start, end in closed]


@given(st.text(alphabet='{}[]"\\1, ', max_size=40))
def test_what_stands_in_brackets_is_looked_at_from_the_last_to_the_first(text: str) -> None:
    tried = [value for segment in reversed(outermost(text)) for value in decoded(segment)]
    seen: list[object] = []
    find_json(f"x {text}", seen.append)
    assert list(map(plain, seen)) == tried


def decoded(text: str) -> list[object]:
    try:
        return [json.loads(text, object_pairs_hook=list)]
    except ValueError:
        return []
