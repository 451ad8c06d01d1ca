"""Finding JSON in an answer: in code fences, in prose, with single quotes; every repair is named."""

from __future__ import annotations

import ast
import json
import re
import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import TypeAlias, TypeVar

_FENCED = re.compile(r"```[\w-]*\s*([^`]*(?:`(?!``)[^`]*)*)(?:```|\Z)")
_SPECIAL_TOKENS = re.compile(r"<\|[\w-]+\|>")
_THINKING = re.compile(r"<think>.*?</think>", re.DOTALL)
_END_OF_THINKING = "</think>"

# Each can match in one way only, so that looking takes time in proportion to the text.
_OPENING = re.compile(r"[^{\[\\]*(?:\\.[^{\[\\]*)*[{\[]", re.DOTALL)
_BRACKET = re.compile(r'[^{}\[\]"\\]*(?:(?:\\.|"[^"\\]*(?:\\.[^"\\]*)*")[^{}\[\]"\\]*)*[{}\[\]]', re.DOTALL)
_ALIKE = re.compile(r"""[\[\]{},:0-9\s]*(?:'[^'"\\\x00-\x1f\ud800-\udfff]*'[\[\]{},:0-9\s]*)*""")
"""Text that means the same in Python and, with other quotes, in JSON, if it is JSON then."""

MAX_LENGTH = 1_000_000
"""Longest answer, in characters, that is searched for JSON; no model writes as much."""

MAX_DEPTH = 100
"""Deepest nesting of a value that is found."""

T = TypeVar("T")


class Pairs:
    """A JSON object as its members in order, duplicates included."""

    __slots__ = ("members",)

    def __init__(self, members: Iterable[tuple[str, object]]) -> None:
        self.members = tuple(members)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Pairs) and self.members == other.members

    def __hash__(self) -> int:
        return hash(self.members)

    def __repr__(self) -> str:
        return "{" + ", ".join(f"{key!r}: {value!r}" for key, value in self.members) + "}"


_Found: TypeAlias = tuple[object, tuple[str, ...]]
"""A JSON value and the names of the repairs that were needed to find it."""

_DECODER = json.JSONDecoder(object_pairs_hook=Pairs)
_BEGINNINGS = frozenset('{["-0123456789tfnNI')
"""How a JSON value may begin, NaN and Infinity included. A refusal by the decoder costs most of a reading."""


def find_json(text: str, accept: Callable[[object], T | None]) -> tuple[T, tuple[str, ...]] | None:
    """The last JSON value in a text that ``accept`` makes something of, and the repairs it took.

    The whole text is tried first, then what stands in code fences, then what stands between brackets in
    prose. Objects come as `Pairs`, arrays as lists. Texts longer than `MAX_LENGTH` are not searched, and
    values nested deeper than `MAX_DEPTH` not found.
    """
    if len(text) > MAX_LENGTH:
        return None
    for stretch, repairs in _stretches(text):
        found = _decoded(stretch, repairs)
        if found is not None:
            value, repairs = found
            accepted = accept(value)
            if accepted is not None:
                return accepted, repairs
    return None


def _stretches(text: str) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Texts that may be JSON, with the repairs that it took to find them."""
    repairs: tuple[str, ...] = ()
    for remove, repair in ((_without_reasoning, "reasoning"), (_without_special_tokens, "special_tokens")):
        if (rest := remove(text)) != text:
            text, repairs = rest, (*repairs, repair)
    text = text.strip()
    yield text, repairs
    fenced: list[str] = [block.strip() for block in _FENCED.findall(text)]
    for block in reversed(fenced):
        yield block, (*repairs, "code_fence")
    for start, end in reversed(_brackets(text)[0]):  # the outermost bracketed stretches
        yield text[start:end], (*repairs, "prose")


def _without_reasoning(text: str) -> str:
    """The text without what models think aloud; what is never closed stays."""
    end = text.rfind(_END_OF_THINKING) + len(_END_OF_THINKING)
    return _THINKING.sub("", text[:end]) + text[end:] if _END_OF_THINKING in text else text


def _without_special_tokens(text: str) -> str:
    return _SPECIAL_TOKENS.sub("", text) if "<|" in text else text


def _decoded(text: str, repairs: tuple[str, ...]) -> _Found | None:
    """The value of a text that is JSON, or a Python literal with single quotes; no blanks are around it."""
    try:
        value, end = _DECODER.raw_decode(text) if text[:1] in _BEGINNINGS else (None, -1)
    except (ValueError, RecursionError):
        value, end = None, -1
    if end != len(text):
        return _decoded_literal(text, repairs)
    is_shallow = text.count("[") + text.count("{") < MAX_DEPTH or _is_shallow(value)
    return (value, repairs) if is_shallow else None


def _is_shallow(value: object) -> bool:
    """Whether a value is nested no deeper than `MAX_DEPTH`, so that it can be walked recursively."""
    level = [value]
    for _ in range(MAX_DEPTH):
        level = [part for whole in level for part in _parts(whole)]
        if not level:
            return True
    return False


def _parts(value: object) -> Sequence[object]:
    if isinstance(value, Pairs):
        return [part for _, part in value.members]
    return value if isinstance(value, list) else ()


def _decoded_literal(text: str, repairs: tuple[str, ...]) -> _Found | None:
    if "'" not in text or not text.startswith(("{", "[")):
        return None
    repairs = (*repairs, "single_quotes")
    if _ALIKE.fullmatch(text):
        found = _decoded(text.replace("'", '"'), repairs)
        if found is not None:
            return found
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # the compiler's remarks on escapes in the answer
            tree = ast.parse(text, mode="eval").body
        return _literal(tree, MAX_DEPTH), repairs
    except (ValueError, SyntaxError, RecursionError, MemoryError):
        return None


def _literal(node: ast.expr, depth: int) -> object:
    """The value of a literal; keys of dictionaries keep their order and their duplicates.

    Raises:
        ValueError: the expression is not a literal, or is nested too deep.
    """
    if depth == 0:
        raise ValueError("nested too deep")
    if isinstance(node, ast.Constant):
        return node.value
    if isinstance(node, ast.List | ast.Tuple):
        return [_literal(element, depth - 1) for element in node.elts]
    if not isinstance(node, ast.Dict):
        raise ValueError("not a literal")
    members = []
    for key, value in zip(node.keys, node.values, strict=True):
        if not isinstance(key, ast.Constant) or not isinstance(key.value, str):
            raise ValueError("a key is not a string")
        members.append((key.value, _literal(value, depth - 1)))
    return Pairs(members)


def is_cut_off(text: str) -> bool:
    """Whether a bracket is opened in a text and not closed again."""
    return len(text) <= MAX_LENGTH and bool(_brackets(text)[1])


def _brackets(text: str) -> tuple[list[tuple[int, int]], list[int]]:
    """Where the outermost brackets are, and those that stay open; within them quoted ones do not count."""
    opened: list[int] = []
    closed: list[tuple[int, int]] = []
    position = 0
    while match := (_BRACKET if opened else _OPENING).match(text, position):
        position = match.end()
        if text[position - 1] in "{[":
            opened.append(position - 1)
            continue
        start = opened.pop()
        while closed and closed[-1][0] > start:
            closed.pop()
        closed.append((start, position))
    return closed, opened
