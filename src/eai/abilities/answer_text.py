"""Reading the JSON value of an answer: every character is read, repaired by name, or set aside as prose.

`read_json` serves all abilities and benchmarks. An `AnswerForm` says what is looked for, and what looks like
a part of it. Text outside the value that looks like a part makes the answer unreadable, since the value is
then not the whole answer. So does a bracket that is never closed: the answer was cut off. Repairs are:

* ``reasoning``, ``special_tokens``: reasoning (`eai.abilities.reasoning`) or control tokens are removed;
* ``code_fence``, ``prose``: the value stands in a code fence, or between other words;
* ``line_breaks``: strings hold line breaks or tabs that JSON asks to escape;
* ``curly_quotes``, ``single_quotes``, ``comments``, ``trailing_comma``: the value is JSON without them;
* ``stray_bracket``: a bracket outside the value closes nothing;
* ``json_in_string``, ``wrapper_key``: the value is a string that holds JSON, or a member of an object whose
  other members are plain;
* ``json_lines``, ``numbered``: parts of the value follow each other without a list around them, with numbers.
"""

from __future__ import annotations

import ast
import json
import re
import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Generic, NamedTuple, Protocol, TypeAlias, TypeVar

from eai.abilities.reasoning import thoughts_in, without
from eai.abilities.verdict import Span, SpanKind, Unreadable

MAX_LENGTH = 1_000_000
"""Maximum length of an answer that is searched, in characters; no model writes as much."""

MAX_DEPTH = 100
"""Maximum nesting of a value that is read."""

_MAX_QUOTED = 60
"""Maximum number of characters of an answer that a message quotes."""

MAX_VALUES = 10_000
"""Maximum number of bracketed values in an answer."""

TOO_LONG = Unreadable(f"the answer is longer than {MAX_LENGTH:,} characters")

_SPECIAL_TOKENS = re.compile(r"<\|[\w-]+\|>")
_FENCE = "```"
_FENCE_MARK = re.compile(r"```[\w-]*")
_BRACKET = re.compile(r"[{}\[\]]")
_INSIDE = re.compile(
    r"""
    "[^"\\]*(?:\\.[^"\\]*)*"
    | (?<=[\[{,:(\s])'[^'\\\n]*(?:\\.[^'\\\n]*)*'(?=\s*[\]},:)])
    | (?<=[\[\]{},\s])(?:\#|//)[^\n]*
    | [{}\[\]]
    """,
    re.VERBOSE | re.DOTALL,
)
"""Strings, comments and brackets inside a value; brackets in strings and comments do not count."""
_STRING_OR_COMMENT = re.compile(
    r"""(?P<string>"[^"\\]*(?:\\.[^"\\]*)*")|(?P<comment>(?<=[\[\]{},\s])(?:\#|//)[^\n]*)""", re.DOTALL
)
_STRING_OR_COMMA = re.compile(r"""(?P<string>"[^"\\]*(?:\\.[^"\\]*)*")|(?P<comma>,)(?=\s*[\]}])""", re.DOTALL)
_ALIKE = re.compile(r"""[\[\]{},:0-9\s]*(?:'[^'"\\\x00-\x1f\ud800-\udfff]*'[\[\]{},:0-9\s]*)*""")
"""Text that means the same in Python and, with other quotes, in JSON, if it is JSON then."""
_NUMBERING = re.compile(r"(?i:[\s,;*_#>-]|•|step\b|\d+[.):]|\d+(?=\s*$)|:)*")
"""Text between the parts of a value that does no more than separate and number them."""
_SEPARATORS = re.compile(r"[\s,;]*")
_CURLY = str.maketrans("“”„‟‘’‚‛", "\"\"\"\"''''")
_PARTNER = {"}": "{", "]": "["}

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

    @property
    def repeated(self) -> str | None:
        """The first key that occurs more than once, or None."""
        keys = [key for key, _ in self.members]
        return None if len(set(keys)) == len(keys) else next(key for key in keys if keys.count(key) > 1)


_STRICT = json.JSONDecoder(object_pairs_hook=Pairs)
_LENIENT = json.JSONDecoder(object_pairs_hook=Pairs, strict=False)
_BEGINNINGS = frozenset('{["-0123456789tfnNI')
"""First characters of JSON values, NaN and Infinity included. An exception costs most of a reading."""


def _looks_like_nothing(text: str) -> bool:
    return False


def _no_repairs(meaning: object) -> tuple[str, ...]:
    return ()


def _is_no_piece(meaning: object) -> bool:
    return False


def _has_no_flaw(value: object) -> str | None:
    return None


@dataclass(frozen=True, slots=True)
class AnswerForm(Generic[T]):
    """The form of the value that an answer holds.

    Attributes:
        wanted: the value in words, after "there is no".
        read: returns the meaning of a JSON value, or None if the value has another form. Objects come as
            `Pairs`, arrays as lists.
        is_part: whether a bracketed text looks like a part of the answer, even if it cannot be read.
        is_line_of_answer: whether a line outside brackets looks like a part of the answer.
        flaw: returns why a JSON value that looks like a part has another form, in words, or None.
        join: puts parts together that follow each other without a list; None if parts never do.
        is_piece: whether a meaning is that of one part, such as a single step.
        repairs_of: the names of the repairs that reading a value took.
        is_certain: whether a meaning names something of the task. Meanings that do not are taken for examples
            if another one does.
        stands_alone: whether two values side by side make the answer unreadable, unless they are equal.
        wrappers: keys of objects around the value that the question asks for, which are no repair.
    """

    wanted: str
    read: Callable[[object], T | None]
    is_part: Callable[[str], bool] = _looks_like_nothing
    is_line_of_answer: Callable[[str], bool] = _looks_like_nothing
    flaw: Callable[[object], str | None] = _has_no_flaw
    join: Callable[[Sequence[T]], T] | None = None
    is_piece: Callable[[T], bool] = _is_no_piece
    repairs_of: Callable[[T], tuple[str, ...]] = _no_repairs
    is_certain: Callable[[T], bool] = bool
    stands_alone: bool = True
    wrappers: frozenset[str] = frozenset()


_QUOTED = re.compile(r"""["'“‘]""")


def holds_strings(text: str) -> bool:
    """Whether a bracketed text holds a string, as JSON that a question asks for does."""
    return _QUOTED.search(text) is not None


def _object_or_list(value: object) -> Pairs | list[object] | None:
    return value if isinstance(value, Pairs | list) else None


ANY_VALUE = AnswerForm("JSON object or list", _object_or_list, is_part=holds_strings, stands_alone=False)
"""Any object or list; the last one of an answer counts."""


@dataclass(frozen=True, slots=True)
class Reading(Generic[T]):
    """The meaning of an answer, the names of the repairs, and which part of the text is which."""

    value: T
    repairs: tuple[str, ...] = ()
    spans: tuple[Span, ...] = ()


class _Decoded(NamedTuple):
    value: object
    repairs: tuple[str, ...] = ()


class _Problem(NamedTuple):
    """Why a stretch of text is no JSON, and at which position of the text."""

    reason: str
    position: int


class _Stretch(NamedTuple):
    """A bracketed stretch of a text: positions, and the problem with its brackets if there is one."""

    start: int
    end: int
    problem: _Problem | None = None


class _Part(Protocol):
    """A part of a text: the position of its first character and the one after the last."""

    @property
    def start(self) -> int: ...

    @property
    def end(self) -> int: ...


@dataclass(frozen=True, slots=True)
class _Value(Generic[T]):
    """A stretch that can be read."""

    start: int
    end: int
    meaning: T
    repairs: tuple[str, ...]


def read_json(text: str, form: AnswerForm[T]) -> Reading[T] | Unreadable:
    """Read the value of a form in an answer, or say why the answer cannot be read as a whole.

    Of several values that stand apart from each other the last one counts.
    """
    if len(text) > MAX_LENGTH:
        return TOO_LONG
    return _AnswerText(text, form).reading()


class _AnswerText(Generic[T]):
    """An answer that is being read for a form."""

    def __init__(self, text: str, form: AnswerForm[T]) -> None:
        self.form = form
        self.strays: list[_Stretch] = []
        self.thoughts = thoughts_in(text)
        self.removed: tuple[str, ...] = ("reasoning",) if self.thoughts else ()
        self.text = without(self.thoughts, text)
        if "<|" in self.text and _SPECIAL_TOKENS.search(self.text):
            self.text = _SPECIAL_TOKENS.sub(lambda token: " " * len(token[0]), self.text)
            self.removed = (*self.removed, "special_tokens")

    def reading(self) -> Reading[T] | Unreadable:
        body = self.text.strip()
        start = self.text.find(body) if body else 0
        decoded = _decoded(body)
        whole = None if isinstance(decoded, _Problem) else _unwrapped(decoded.value, self.form)
        if whole is not None and isinstance(decoded, _Decoded):
            value = _Value(start, start + len(body), whole[0], (*decoded.repairs, *whole[1]))
            return self._result([value], value.meaning, ())
        if not body:
            return self._nothing()
        values = self._values()
        return values if isinstance(values, Unreadable) else self._chosen(values)

    def _nothing(self) -> Unreadable:
        if self.thoughts and not self.thoughts[-1].is_finished:
            return Unreadable(
                "the reasoning is never closed, so that there is no answer", spans=self._spans([])
            )
        return Unreadable(f"there is no {self.form.wanted}", spans=self._spans([]))

    def _values(self) -> list[_Value[T]] | Unreadable:
        """Read all bracketed values of the form; another part of the answer is an error, if it is no draft.

        A draft is closed and stands before a whole value: before one that is not a piece of the answer.
        """
        values: list[_Value[T]] = []
        error: Unreadable | None = None
        for number, stretch in enumerate(_stretches(self.text)):
            if number == MAX_VALUES:
                return Unreadable(f"the answer has more than {MAX_VALUES:,} bracketed values")
            if stretch.problem is not None:
                return self._error(stretch, stretch.problem)
            inside = self.text[stretch.start : stretch.end]
            if inside in _PARTNER:
                self.strays.append(stretch)
                continue
            is_part = self.form.is_part(inside)
            decoded = _decoded(inside, stretch.start, repair=is_part)
            meaning = None if isinstance(decoded, _Problem) else _unwrapped(decoded.value, self.form)
            if meaning is not None and isinstance(decoded, _Decoded):
                repairs = (*decoded.repairs, *meaning[1])
                values.append(_Value(stretch.start, stretch.end, meaning[0], repairs))
                if self.form.is_certain(meaning[0]) and not self.form.is_piece(meaning[0]):
                    error = None
            elif is_part and error is None:
                error = self._error(stretch, decoded)
        return values if error is None else error

    def _error(self, stretch: _Stretch, cause: _Problem | _Decoded) -> Unreadable:
        if isinstance(cause, _Problem):
            flaw: str | None = f"{_place(self.text, cause.position)}: {cause.reason}"
        else:
            flaw = self.form.flaw(cause.value)
        reason = f"there is no {self.form.wanted}" + (f": {flaw}" if flaw else "")
        return Unreadable(reason, spans=self._spans([], unread=stretch))

    def _chosen(self, values: list[_Value[T]]) -> Reading[T] | Unreadable:
        """Choose the value that is the answer, or join the pieces of one."""
        chosen = self._relevant(values)
        line = self._line_of_answer(values)
        if line is not None:
            return self._stray(line)
        if not chosen:
            return self._nothing()
        gaps = [_Stretch(one.end, other.start) for one, other in pairwise(chosen)]
        texts = [self.text[gap.start : gap.end] for gap in gaps]
        are_pieces = gaps and any(self.form.is_piece(value.meaning) for value in chosen)
        if self.form.join is not None and are_pieces:
            between = next(
                (gap for gap, text in zip(gaps, texts, strict=True) if not _NUMBERING.fullmatch(text)), None
            )
            if between is not None:
                return self._stray(between)
            are_numbered = not all(map(_SEPARATORS.fullmatch, texts))
            repairs = ("json_lines", *(["numbered"] if are_numbered else []))
            return self._result(chosen, self.form.join([value.meaning for value in chosen]), repairs)
        are_adjacent = self.form.stands_alone and any(map(_SEPARATORS.fullmatch, texts))
        if are_adjacent and not _are_equal(self.text, chosen):
            return self._stray(_Stretch(chosen[-2].start, chosen[-1].end))
        return self._result(chosen[-1:], chosen[-1].meaning, ())

    def _relevant(self, values: list[_Value[T]]) -> list[_Value[T]]:
        """Return the values that name something of the task, and their neighbours; all if none does."""
        groups: list[list[_Value[T]]] = []
        for value in values:
            is_neighbour = groups and _NUMBERING.fullmatch(self.text[groups[-1][-1].end : value.start])
            if is_neighbour:
                groups[-1].append(value)
            else:
                groups.append([value])
        certain = [group for group in groups if any(self.form.is_certain(each.meaning) for each in group)]
        return [value for group in certain or groups for value in group]

    def _line_of_answer(self, values: Sequence[_Value[T]]) -> _Stretch | None:
        """Find a line outside the values that looks like a part of the answer."""
        for start, end in _between(values, len(self.text)):
            for line in re.finditer(r"[^\n]+", self.text[start:end]):
                if not line[0].isspace() and self.form.is_line_of_answer(line[0]):
                    return _Stretch(start + line.start(), start + line.end())
        return None

    def _stray(self, stretch: _Stretch) -> Unreadable:
        inside = self.text[stretch.start : stretch.end]
        words = " ".join(inside.split())
        quoted = words if len(words) <= _MAX_QUOTED else f"{words[: _MAX_QUOTED - 3]}..."
        place = _place(self.text, stretch.start + len(inside) - len(inside.lstrip()))
        reason = f"{place}: {quoted!r} looks like a part of the answer and stands outside"
        return Unreadable(
            f"there is no whole {self.form.wanted}: {reason}", spans=self._spans([], unread=stretch)
        )

    def _result(self, chosen: Sequence[_Value[T]], meaning: T, repairs: tuple[str, ...]) -> Reading[T]:
        text, first = self.text, chosen[0]
        around: tuple[str, ...] = ("stray_bracket",) if self.strays else ()
        outside = "".join([text[start:end] for start, end in _between([*self.strays, *chosen], len(text))])
        if _FENCE in outside and text.count(_FENCE, 0, first.start) % 2:
            around = ("code_fence", *around)
        elif outside and not outside.isspace():
            around = ("prose", *around)
        made = [repair for value in chosen for repair in value.repairs]
        names = tuple(dict.fromkeys([*self.removed, *around, *repairs, *made]))
        return Reading(meaning, names, self._spans(chosen))

    def _spans(self, chosen: Sequence[_Value[T]], unread: _Stretch | None = None) -> tuple[Span, ...]:
        """Return what became of each part of the text, in order; blank parts and code fences are left out."""
        marked = [Span(thought.start, thought.end, SpanKind.REASONING) for thought in self.thoughts]
        for value in chosen:
            kind = SpanKind.REPAIRED if value.repairs else SpanKind.READ
            marked.append(Span(value.start, value.end, kind))
        if unread is not None:
            marked.append(Span(unread.start, unread.end, SpanKind.UNREAD))
        for start, end in _between(marked, len(self.text)):
            words = _FENCE_MARK.sub(lambda mark: " " * len(mark[0]), self.text[start:end])
            if stripped := words.strip():
                begin = start + words.index(stripped)
                marked.append(Span(begin, begin + len(stripped), SpanKind.PROSE))
        return tuple(sorted(marked))


def _between(taken: Iterable[_Part], length: int) -> Iterator[tuple[int, int]]:
    """Yield the stretches of a text of some length that lie outside parts of it."""
    position = 0
    for part in sorted(taken, key=lambda part: part.start):
        if position < part.start:
            yield position, part.start
        position = max(position, part.end)
    if position < length:
        yield position, length


def _are_equal(text: str, values: Sequence[_Value[T]]) -> bool:
    return len({"".join(text[value.start : value.end].split()) for value in values}) == 1


def _place(text: str, position: int) -> str:
    line_start = text.rfind("\n", 0, position) + 1
    return f"line {text.count(chr(10), 0, position) + 1}, column {position - line_start + 1}"


def _stretches(text: str) -> Iterator[_Stretch]:
    """Yield the outermost bracketed stretches of a text; the first one with a problem ends the search."""
    position = 0
    while bracket := _BRACKET.search(text, position):
        start = bracket.start()
        if bracket[0] in _PARTNER:
            yield _Stretch(start, start + 1)
            position = start + 1
            continue
        stretch = _stretch_at(text, start)
        yield stretch
        if stretch.problem is not None:
            return
        position = stretch.end


def _stretch_at(text: str, start: int) -> _Stretch:
    """Return the stretch of the bracket that opens at a position."""
    opened: list[int] = []
    for token in _INSIDE.finditer(text, start):
        word = token[0]
        if word in ("{", "["):
            opened.append(token.start())
        elif word in _PARTNER:
            opening = opened.pop()
            if text[opening] != _PARTNER[word]:
                reason = f"this {word} does not close the {text[opening]} of {_place(text, opening)}"
                return _Stretch(start, len(text), _Problem(reason, token.start()))
            if not opened:
                return _Stretch(start, token.end())
    reason = "this bracket is not closed, as if the answer were cut off"
    return _Stretch(start, len(text), _Problem(reason, opened[0]))


_Meaning: TypeAlias = tuple[T, tuple[str, ...]]
"""The meaning of a value, and the names of the repairs inside it."""


def _unwrapped(value: object, form: AnswerForm[T], depth: int = 3) -> tuple[T, tuple[str, ...]] | None:
    """Return the meaning of a value, or of the one in a string or in a member of it."""
    meaning = form.read(value)
    if meaning is not None or depth == 0:
        return None if meaning is None else (meaning, form.repairs_of(meaning))
    if isinstance(value, str):
        if "{" not in value and "[" not in value:
            return None
        decoded = _decoded(value.strip())
        inner = None if isinstance(decoded, _Problem) else _unwrapped(decoded.value, form, depth - 1)
        if inner is None or isinstance(decoded, _Problem):
            return None
        return inner[0], ("json_in_string", *decoded.repairs, *inner[1])
    if not isinstance(value, Pairs):
        return None
    inside = [(key, _unwrapped(member, form, depth - 1)) for key, member in value.members]
    wrapped = [(key, inner) for key, inner in inside if inner is not None]
    others = [
        member for (key, member), (_, inner) in zip(value.members, inside, strict=True) if inner is None
    ]
    if len(wrapped) != 1 or any(isinstance(member, Pairs | list) and _parts(member) for member in others):
        return None
    key, (meaning, repairs) = wrapped[0]
    named = () if key in form.wrappers and not others else ("wrapper_key",)
    return meaning, (*named, *repairs)


def _decoded(text: str, offset: int = 0, *, repair: bool = True) -> _Decoded | _Problem:
    """Return the value of a text that is JSON, at once or after repairs of its own characters.

    Args:
        text: the text, without blanks around it.
        offset: position of its first character in the answer.
        repair: whether repairs are tried.
    """
    value = _json(text, _STRICT)
    if not isinstance(value, _Problem):
        return value
    if not repair or text[:1] not in ("{", "["):
        return value._replace(position=value.position + offset)
    repaired_texts = list(_repaired(text))
    for repaired, names in repaired_texts:
        again = _json(repaired, _LENIENT)
        if isinstance(again, _Decoded):
            return _Decoded(again.value, names or ("line_breaks",))
    for repaired, names in repaired_texts:
        literal = _literal_of(repaired)
        if literal is not None:
            return _Decoded(literal.value, (*names, "single_quotes"))
    return value._replace(position=value.position + offset)


def _repaired(text: str) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Yield a text, then with one more repair each time, and the names of the repairs."""
    names: tuple[str, ...] = ()
    yield text, names
    for repair, name in (
        (lambda words: words.translate(_CURLY), "curly_quotes"),
        (_without_comments, "comments"),
        (_without_trailing_commas, "trailing_comma"),
    ):
        repaired = repair(text)
        if repaired != text:
            text, names = repaired, (*names, name)
            yield text, names


def _without_comments(text: str) -> str:
    return _STRING_OR_COMMENT.sub(lambda part: part["string"] or "", text)


def _without_trailing_commas(text: str) -> str:
    return _STRING_OR_COMMA.sub(lambda part: part["string"] or "", text)


def _json(text: str, decoder: json.JSONDecoder) -> _Decoded | _Problem:
    if text[:1] not in _BEGINNINGS:
        return _Problem("expected a JSON value", 0)
    try:
        value, end = decoder.raw_decode(text)
    except json.JSONDecodeError as error:
        return _Problem(_in_words(error), error.pos)
    except (ValueError, RecursionError):
        return _Problem("expected a JSON value that is less nested, with shorter numbers", 0)
    if end != len(text):
        return _Problem("expected the end of the JSON value", end)
    if text.count("[") + text.count("{") >= MAX_DEPTH and not _is_shallow(value):
        return _Problem(f"expected at most {MAX_DEPTH} nested brackets", 0)
    return _Decoded(value)


def _in_words(error: json.JSONDecodeError) -> str:
    """Return the message of a JSON error as the others are written."""
    message = error.msg.removeprefix("Expecting ").removeprefix("Illegal ")
    return (
        f"expected {message}" if error.msg.startswith("Expecting") else error.msg[:1].lower() + error.msg[1:]
    )


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


def _literal_of(text: str) -> _Decoded | None:
    """Return the value of a Python literal with single quotes, or None if the text is no such literal."""
    if "'" not in text:
        return None
    if _ALIKE.fullmatch(text):
        decoded = _json(text.replace("'", '"'), _STRICT)
        if isinstance(decoded, _Decoded):
            return decoded
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # the compiler's remarks on escapes in the answer
            tree = ast.parse(text, mode="eval").body
        return _Decoded(_literal(tree, MAX_DEPTH))
    except (ValueError, SyntaxError, RecursionError, MemoryError):
        return None


def _literal(node: ast.expr, depth: int) -> object:
    """Return the value of a literal; keys of dictionaries keep their order and their duplicates.

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
