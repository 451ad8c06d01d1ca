r"""Read the JSON value in the text of an answer.

Every character of the text is read unchanged, is read after a named repair, or counts as prose.

`read_json` serves all abilities and benchmarks. An `AnswerFormat` describes the expected value, and how to
recognize its parts. An answer is unreadable in four cases:

* text outside the value looks like a part of the answer, so that the value is incomplete;
* a bracket is never closed, so that the answer was cut off;
* a closing bracket has no opening bracket, and no list encloses the parts of the answer;
* reasoning that is never finished contains a part of the answer.

The repairs are:

* ``reasoning``, ``special_tokens``: reasoning (`eai.abilities.reasoning`) or control tokens are removed;
* ``code_fence``, ``prose``: the value stands in a code fence, or between other words;
* ``line_breaks``: strings contain line breaks or tabs that JSON requires to be escaped;
* ``curly_quotes``, ``single_quotes``, ``wide_characters`` (blanks and punctuation that JSON does not allow),
  ``comments``, ``trailing_comma``: these are replaced or removed to get JSON;
* ``escapes``: all quotes of the value are escaped, with a backslash or as in HTML;
* ``stray_bracket``: a closing bracket outside the value has no opening bracket;
* ``boxed``: the value stands in ``\boxed{}``;
* ``json_in_string``: the value is JSON inside a string;
* ``wrapper_key``: the value is a member of an object whose other members are not parts of an answer;
* ``wrapper_list``: the value is the only item of a list;
* ``json_lines``: the parts of the value follow each other without a list around them;
* ``numbered``: parts that follow each other have numbers.
"""

from __future__ import annotations

import ast
import html
import json
import re
import warnings
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice, pairwise
from typing import Generic, NamedTuple, Protocol, TypeVar

from eai.abilities.reasoning import blank_out_thoughts, find_thoughts
from eai.abilities.verdict import AnswerSpan, AnswerSpanKind, Unreadable

MAX_ANSWER_CHARACTERS = 1_000_000
"""Maximum length of readable answers, in characters. Answers of models are shorter."""

MAX_JSON_DEPTH = 100
"""Maximum depth of nested lists and objects in a value that is read."""

_MAX_QUOTED = 60
"""Maximum number of characters that an error message quotes from an answer."""

MAX_JSON_VALUES = 10_000
"""Maximum number of JSON lists and objects in an answer, nested ones not counted."""

_UNOPENED = "no opening bracket of a list matches this one: the parts need a list around them"
_UNCLOSED = "this bracket is not closed, as if the answer were cut off"

TOO_LONG = Unreadable(f"the answer is longer than {MAX_ANSWER_CHARACTERS:,} characters")

_SPECIAL_TOKENS = re.compile(r"<\|[\w-]+\|>")
_BOX = re.compile(r"\\boxed\s*\{(?=\s*[{\[])")
_FENCE = "```"
_FENCE_MARK = re.compile(r"`{3,}[\w+-]*")
_BRACKET = re.compile(r"[{}\[\]]")
_STRING_COMMENT_OR_BRACKET = re.compile(
    r"""
    (?<!\\)"[^"\\]*(?:\\.[^"\\]*)*"
    | (?<=[\[{,:(\s])'[^'\\\n]*(?:\\.[^'\\\n]*)*'(?=\s*[\]},:)])
    | (?<=[\[\]{},\s])(?:(?:\#|//)[^\n]*|/\*.{0,400}?\*/)
    | [{}\[\]]
    """,
    re.VERBOSE | re.DOTALL,
)
"""Pattern of strings, comments and brackets in a value. Brackets in strings and comments are not counted."""
_STRING = r"""(?P<string>(?<!\\)"[^"\\]*(?:\\.[^"\\]*)*")"""
_STRING_OR_COMMENT = re.compile(
    _STRING + r"|(?P<comment>(?<=[\[\]{},\s])(?:(?:\#|//)[^\n]*|/\*.{0,400}?\*/))", re.DOTALL
)
WIDE_CHARACTERS: dict[int, str] = {
    **dict.fromkeys([0xA0, 0x2007, 0x202F, 0x2060, 0x3000, 0xFEFF, *range(0x200B, 0x2010)], " "),
    **dict(zip(map(ord, "，："), ",:", strict=True)),
}
"""Mapping from unusual blanks and wide punctuation between JSON values to a blank or ASCII."""
_STRING_OR_WIDE = re.compile(rf"{_STRING}|[{''.join(map(chr, WIDE_CHARACTERS))}]", re.DOTALL)
_UNESCAPED_QUOTE = re.compile(r"""(?<!\\)["'“”‘’]""")
_ESCAPE = re.compile(r'\\(["\\nrt])')
_UNESCAPED = {"n": " ", "r": " ", "t": " "}
_STRING_OR_COMMA = re.compile(_STRING + r"|(?P<comma>,)(?=\s*[\]}])", re.DOTALL)
_JSON_LIKE_LITERAL = re.compile(r"""[\[\]{},:0-9\s]*(?:'[^'"\\\x00-\x1f\ud800-\udfff]*'[\[\]{},:0-9\s]*)*""")
"""Pattern of Python literals that become equal JSON if double quotes replace their single quotes."""
_SEPARATORS_OR_NUMBERS = re.compile(r"(?i:[\s,;*_#>-]|•|step\b|\d+[.):]|\d+(?=\s*$)|:)*")
"""Pattern of a text between two JSON values that contains only separators and item numbers.

It shows that the values belong together.
"""
_SEPARATORS = re.compile(r"[\s,;]*")
_WORD_THAT_CHOOSES = re.compile(
    r"\b(?:no|wait|final|answer|correct(?:ed|ion)?|fixed|revised|instead|rather|actually)\b", re.IGNORECASE
)
"""Pattern of a word between two values that makes the second value the answer."""
_SEPARATORS_OR_CONNECTIVES = re.compile(
    r"(?:[^\w`]|\b\d+\b|(?<!`)`{3,}(?!`)[\w+-]*"
    r"|(?i:\b(?:and|or|then|next|also|finally|after(?:wards| that)|alternatively)\b)"
    r"|(?i:\b(?:part|phase|stage|step|option) ?\w\b))*"
)
"""Pattern of a text between two values that does not show which of them is the answer.

It has only signs, numbers, connectives and labels such as ``step 2``. A run of backticks matches as a whole,
so matching takes linear time.
"""
_CURLY = str.maketrans("“”„‟‘’‚‛", "\"\"\"\"''''")
_OPENING_BRACKET = {"}": "{", "]": "["}
_CALL = re.compile(r"(?<![\w.])[\w.]+\s*\([^()]*\)")
_CONNECTIVE_OR_SIGN = re.compile(r"\b(?:and|or|not|then|next|finally|also)\b|\W", re.IGNORECASE)
_REASONING_KEY = re.compile(
    r"(?:.*[_ -])?(?:thoughts?|thinking|reason(?:ing|s)?|explanations?|analysis|rationale|why|description)"
    r"|(?:task|goal|title|name)(?:[_ -]name)?",
    re.IGNORECASE,
)
"""Pattern of keys whose texts explain an answer, or name its task, and are not parts of the answer."""

T = TypeVar("T")


class JsonObject:
    """A JSON object as a sequence of members. Unlike a dictionary, it keeps members with duplicate keys."""

    __slots__ = ("members",)

    def __init__(self, members: Iterable[tuple[str, object]]) -> None:
        self.members = tuple(members)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, JsonObject) and self.members == other.members

    def __hash__(self) -> int:
        return hash(self.members)

    def __repr__(self) -> str:
        return "{" + ", ".join(f"{key!r}: {value!r}" for key, value in self.members) + "}"

    @property
    def repeated_key(self) -> str | None:
        """The first key that occurs more than once in the object, or None."""
        times = Counter([key for key, _ in self.members])
        return next((key for key, number in times.items() if number > 1), None)


_STRICT = json.JSONDecoder(object_pairs_hook=JsonObject)
_LENIENT = json.JSONDecoder(object_pairs_hook=JsonObject, strict=False)
_FIRST_CHARACTERS_OF_JSON = frozenset('{["-0123456789tfnNI')
"""First characters of JSON values, NaN and Infinity included.

A text is tested for them before it is parsed, which avoids slow exceptions.
"""


def _return_false(*values: object) -> bool:
    return False


def _return_no_repairs(value: object) -> tuple[str, ...]:
    return ()


def _return_no_flaw(value: object) -> str | None:
    return None


@dataclass(frozen=True, slots=True)
class AnswerFormat(Generic[T]):
    """The form of the value that an answer must contain.

    The meaning of a JSON value is the Python value that is made from it, such as a tuple of steps.

    Attributes:
        description: the expected value in words, for messages that begin with "there is no".
        read: returns the meaning of a JSON value, or None if the value has another form. It gets objects as
            `JsonObject` and arrays as lists.
        is_part: whether a text in brackets looks like a part of the answer, even if it cannot be read.
        is_answer_line: whether a line outside brackets looks like a part of the answer.
        is_text_with_part: whether a line has a part of the answer among few other words. The line is from a
            string under another key of the object around the value.
        flaw: returns in words why a JSON value that looks like a part of the answer has another form, or
            None.
        join: combines the meanings of parts that follow each other without a list around them; None if such
            parts are not combined.
        is_piece: whether a meaning is only a single part of an answer, such as one step.
        repairs_of: returns the names of the repairs that were needed to read the value of a meaning.
        is_certain: whether a meaning names something of the task. If some meaning does, all other meanings
            count as examples.
        is_single: whether an answer with two different values is unreadable if only signs, numbers,
            connectives (`and then`) or labels (`step 2`) stand between them.
        is_complete: whether a meaning can be the whole answer, even if it names nothing of the task. A value
            that cannot be read is then no part of the answer. `is_certain` if None.
        are_halves: whether two meanings are different parts of one answer, so that neither is complete.
        wrappers: keys of an object around the value, if the question asks for such an object. Removing this
            object does not count as a repair.
    """

    description: str
    read: Callable[[object], T | None]
    is_part: Callable[[str], bool] = _return_false
    is_answer_line: Callable[[str], bool] = _return_false
    is_text_with_part: Callable[[str], bool] = _return_false
    flaw: Callable[[object], str | None] = _return_no_flaw
    join: Callable[[Sequence[T]], T] | None = None
    is_piece: Callable[[T], bool] = _return_false
    repairs_of: Callable[[T], tuple[str, ...]] = _return_no_repairs
    is_certain: Callable[[T], bool] = bool
    is_complete: Callable[[T], bool] | None = None
    is_single: bool = True
    are_halves: Callable[[T, T], bool] = _return_false
    wrappers: frozenset[str] = frozenset()


_QUOTED = re.compile(r"""["'“‘]""")


def contains_json_string(text: str) -> bool:
    """Whether a bracketed text contains a quoted string, as JSON answers do."""
    return _QUOTED.search(text) is not None


def _get_object_or_list(value: object) -> JsonObject | list[object] | None:
    return value if isinstance(value, JsonObject | list) else None


ANY_VALUE = AnswerFormat(
    "JSON object or list", _get_object_or_list, is_part=contains_json_string, is_single=False
)
"""Form of an answer whose value is any JSON object or list. The last object or list in the answer counts."""


@dataclass(frozen=True, slots=True)
class ParsedAnswer(Generic[T]):
    """A value that was read from an answer.

    Attributes:
        value: the value.
        repairs: names of the repairs that were needed to read the text.
        spans: parts of the text, each with how it was treated, such as read or repaired.
    """

    value: T
    repairs: tuple[str, ...] = ()
    spans: tuple[AnswerSpan, ...] = ()


class _DecodedJson(NamedTuple):
    value: object
    repairs: tuple[str, ...] = ()


class _InvalidJson(NamedTuple):
    """The reason why a text is not JSON, and the position of the first wrong character."""

    reason: str
    position: int


class _BracketedText(NamedTuple):
    """Start and end of a bracketed part of a text, and the problem with its brackets, if any."""

    start: int
    end: int
    problem: _InvalidJson | None = None


class _TextRange(Protocol):
    """A range of a text: the position of its first character and the position after its last one."""

    @property
    def start(self) -> int: ...

    @property
    def end(self) -> int: ...


@dataclass(frozen=True, slots=True)
class _ValueInText(Generic[T]):
    """A part of a text that was read as a value."""

    start: int
    end: int
    meaning: T
    repairs: tuple[str, ...]


def read_json(text: str, form: AnswerFormat[T]) -> ParsedAnswer[T] | Unreadable:
    """Return the value in an answer that has the given form, or the reason why the answer cannot be read.

    If an answer has several such values with other text between them, the last value counts.
    """
    if len(text) > MAX_ANSWER_CHARACTERS:
        return TOO_LONG
    return _AnswerReader(text, form).read_answer()


class _AnswerReader(Generic[T]):
    """Finds the value in an answer that has an expected format (`AnswerFormat`)."""

    def __init__(self, text: str, form: AnswerFormat[T]) -> None:
        self.form = form
        self.strays: list[_BracketedText] = []
        self.invalid_objects: list[_BracketedText] = []
        self.thoughts = find_thoughts(text)
        self.removed: tuple[str, ...] = ("reasoning",) if self.thoughts else ()
        self.text = blank_out_thoughts(self.thoughts, text)
        if "\\boxed" in self.text and _BOX.search(self.text):
            self.text = _BOX.sub(lambda box: " " * len(box[0]), self.text)
            self.removed = (*self.removed, "boxed")
        if "<|" in self.text and _SPECIAL_TOKENS.search(self.text):
            self.text = _SPECIAL_TOKENS.sub(lambda token: " " * len(token[0]), self.text)
            self.removed = (*self.removed, "special_tokens")

    def read_answer(self) -> ParsedAnswer[T] | Unreadable:
        body = self.text.strip()
        start = self.text.find(body) if body else 0
        decoded = _decode_with_repairs(body)
        whole = (
            None
            if isinstance(decoded, _InvalidJson)
            else _read_answer_and_repairs_from_json_value(decoded.value, self.form)
        )
        if whole is not None and isinstance(decoded, _DecodedJson):
            if self._has_answer_json_in_unfinished_reasoning():
                return self._report_unfinished_thought()
            value = _ValueInText(start, start + len(body), whole[0], (*decoded.repairs, *whole[1]))
            return self._make_parsed_answer([value], value.meaning, ())
        if not body:
            return self._report_missing_value()
        values = self._read_values()
        return values if isinstance(values, Unreadable) else self._choose_answer_value(values)

    def _report_missing_value(self) -> Unreadable:
        if self.thoughts and not self.thoughts[-1].is_finished:
            return self._report_unfinished_thought()
        return Unreadable(
            f"there is no {self.form.description}", spans=self._classify_spans_of_answer_text([])
        )

    def _report_unfinished_thought(self) -> Unreadable:
        return Unreadable(
            "the reasoning is never closed, so that there is no answer",
            spans=self._classify_spans_of_answer_text([]),
        )

    def _has_answer_json_in_unfinished_reasoning(self) -> bool:
        """Whether the answer ends in reasoning without a closing mark, and this reasoning contains JSON."""
        if not self.thoughts or self.thoughts[-1].is_finished:
            return False
        text = self.thoughts[-1].text
        parts = islice(_find_bracketed_texts(text), MAX_JSON_VALUES)
        return any(self._is_json_fragment_of_answer(text[part.start : part.end]) for part in parts)

    def _is_json_fragment_of_answer(self, text: str) -> bool:
        return self.form.is_part(text) or (
            _UNESCAPED_QUOTE.search(text) is None and self.form.is_part(_unescape(text))
        )

    def _read_values(self) -> list[_ValueInText[T]] | Unreadable:
        """Return all bracketed texts that can be read as an answer, or why the answer cannot be read.

        A bracketed text that looks like a part of the answer, but cannot be read, makes the answer
        unreadable. If a complete answer follows such a text, the text counts as a draft and is ignored.
        """
        values: list[_ValueInText[T]] = []
        error: Unreadable | None = None
        for number, bracketed_text in enumerate(_find_bracketed_texts(self.text)):
            if number == MAX_JSON_VALUES:
                return Unreadable(f"the answer has more than {MAX_JSON_VALUES:,} JSON lists and objects")
            if bracketed_text.problem is not None:
                return self._report_unreadable_value(bracketed_text, bracketed_text.problem)
            inside = self.text[bracketed_text.start : bracketed_text.end]
            if inside in _OPENING_BRACKET:
                self.strays.append(bracketed_text)
                continue
            is_part = self._is_json_fragment_of_answer(inside)
            decoded = _decode_with_repairs(inside, bracketed_text.start, repair=is_part)
            meaning = (
                None
                if isinstance(decoded, _InvalidJson)
                else _read_answer_and_repairs_from_json_value(decoded.value, self.form)
            )
            if meaning is not None and isinstance(decoded, _DecodedJson):
                repairs = (*decoded.repairs, *meaning[1])
                values.append(_ValueInText(bracketed_text.start, bracketed_text.end, meaning[0], repairs))
                is_complete = self.form.is_complete or self.form.is_certain
                if is_complete(meaning[0]) and not self.form.is_piece(meaning[0]):
                    error = None
            elif is_part and error is None:
                error = self._report_unreadable_value(bracketed_text, decoded)
            elif isinstance(decoded, _InvalidJson) and inside.startswith("{"):
                self.invalid_objects.append(bracketed_text)
        return values if error is None else error

    def _report_unreadable_value(
        self, bracketed_text: _BracketedText, result: _InvalidJson | _DecodedJson
    ) -> Unreadable:
        if isinstance(result, _InvalidJson):
            flaw: str | None = f"{_format_line_and_column(self.text, result.position)}: {result.reason}"
        else:
            flaw = self.form.flaw(result.value)
        reason = f"there is no {self.form.description}" + (f": {flaw}" if flaw else "")
        return Unreadable(reason, spans=self._classify_spans_of_answer_text([], unread_text=bracketed_text))

    def _choose_answer_value(self, values: list[_ValueInText[T]]) -> ParsedAnswer[T] | Unreadable:
        """Return the value that counts as the answer, or the reason why no value does.

        Pieces of an answer, such as single steps, are joined to one value.
        """
        chosen = self._select_values_with_known_names(values)
        line = self._find_answer_line_outside_json_values(values)
        if line is not None:
            return self._report_unread_text(line)
        if not chosen:
            return self._report_missing_value()
        if self._has_answer_json_in_unfinished_reasoning():
            return self._report_unfinished_thought()
        gaps = [_BracketedText(one.end, other.start) for one, other in pairwise(chosen)]
        texts = [self.text[gap.start : gap.end] for gap in gaps]
        has_pieces = any(self.form.is_piece(value.meaning) for value in chosen)
        stray = self._find_closing_bracket_of_unopened_list(chosen, has_pieces=has_pieces)
        if stray is not None:
            return self._report_unreadable_value(stray, _InvalidJson(_UNOPENED, stray.start))
        for other in self.invalid_objects if has_pieces else ():
            around = [self.text[min(other.end, one.end) : max(other.start, one.start)] for one in chosen]
            if any(map(_SEPARATORS_OR_NUMBERS.fullmatch, around)):
                return self._report_unread_text(other)
        if self.form.join is not None and gaps and has_pieces:
            between = next(
                (
                    gap
                    for gap, text in zip(gaps, texts, strict=True)
                    if not _SEPARATORS_OR_NUMBERS.fullmatch(text)
                ),
                None,
            )
            if between is not None:
                return self._report_unread_text(between)
            are_numbered = not all(map(_SEPARATORS.fullmatch, texts))
            repairs = ("json_lines", *(["numbered"] if are_numbered else []))
            return self._make_parsed_answer(
                chosen, self.form.join([value.meaning for value in chosen]), repairs
            )
        last = chosen[-1].meaning
        has_no_choice = self.form.is_single  # no words after the two values make a later value the answer
        for (first, second), text in reversed([*zip(pairwise(chosen), texts, strict=True)]):
            has_no_choice = has_no_choice and _SEPARATORS_OR_CONNECTIVES.fullmatch(text) is not None
            if (has_no_choice and first.meaning != second.meaning) or self.form.are_halves(
                first.meaning, last
            ):
                return self._report_unread_text(_BracketedText(first.start, second.end))
        return self._make_parsed_answer(chosen[-1:], last, ())

    def _find_closing_bracket_of_unopened_list(
        self, values: Sequence[_ValueInText[T]], *, has_pieces: bool
    ) -> _BracketedText | None:
        """Return a closing bracket that seems to end a list whose opening bracket is missing, or None."""
        for stray in self.strays if has_pieces else ():
            if len(values) > 1 or stray.start < values[0].start or self.text[stray.start] == "]":
                return stray
        last = self.strays[-1] if self.strays else None
        between = self.text[values[-1].end : last.start].rstrip() if last else ""
        is_end_of_list = between.endswith(('"', "'", "”", "’", "]", "}", ")")) and self.form.is_part(between)
        return last if is_end_of_list else None

    def _select_values_with_known_names(self, values: list[_ValueInText[T]]) -> list[_ValueInText[T]]:
        """Return the JSON values that belong to the answer. All other values count as examples in its prose.

        Neighbours are values with only separators or item numbers between them. A row of neighbours belongs
        to the answer if one of them names something of the task (`AnswerFormat.is_certain`). All values are
        returned if none names something of the task, or if words such as ``Final answer`` choose the last.
        """
        groups: list[list[_ValueInText[T]]] = []
        for value in values:
            is_neighbour = groups and _SEPARATORS_OR_NUMBERS.fullmatch(
                self.text[groups[-1][-1].end : value.start]
            )
            if is_neighbour:
                groups[-1].append(value)
            else:
                groups.append([value])
        certain = [
            group for group in groups if any(self.form.is_certain(neighbour.meaning) for neighbour in group)
        ]
        if certain and certain[-1] is not groups[-1]:
            words = self.text[certain[-1][-1].end : groups[-1][0].start]
            certain = groups if _WORD_THAT_CHOOSES.search(words) else certain
        return [value for group in certain or groups for value in group]

    def _find_answer_line_outside_json_values(
        self, values: Sequence[_ValueInText[T]]
    ) -> _BracketedText | None:
        for start, end in _find_ranges_between(values, len(self.text)):
            for line in re.finditer(r"[^\n]+", self.text[start:end]):
                if not line[0].isspace() and self.form.is_answer_line(line[0]):
                    return _BracketedText(start + line.start(), start + line.end())
        return None

    def _report_unread_text(self, unread_text: _BracketedText) -> Unreadable:
        inside = self.text[unread_text.start : unread_text.end]
        words = " ".join(inside.split())
        quoted = words if len(words) <= _MAX_QUOTED else f"{words[: _MAX_QUOTED - 3]}..."
        position = _format_line_and_column(self.text, unread_text.start + len(inside) - len(inside.lstrip()))
        reason = f"{position}: {quoted!r} looks like a part of the answer and stands outside"
        return Unreadable(
            f"there is no whole {self.form.description}: {reason}",
            spans=self._classify_spans_of_answer_text([], unread_text=unread_text),
        )

    def _make_parsed_answer(
        self, answer_values: Sequence[_ValueInText[T]], meaning: T, repairs: tuple[str, ...]
    ) -> ParsedAnswer[T]:
        text, first = self.text, answer_values[0]
        around: tuple[str, ...] = ("stray_bracket",) if self.strays else ()
        outside = "".join(
            [
                text[start:end]
                for start, end in _find_ranges_between([*self.strays, *answer_values], len(text))
            ]
        )
        if _FENCE in outside and text.count(_FENCE, 0, first.start) % 2:
            around = ("code_fence", *around)
        elif outside and not outside.isspace():
            around = ("prose", *around)
        made = [repair for value in answer_values for repair in value.repairs]
        names = tuple(dict.fromkeys([*self.removed, *around, *repairs, *made]))
        return ParsedAnswer(meaning, names, self._classify_spans_of_answer_text(answer_values))

    def _classify_spans_of_answer_text(
        self, answer_values: Sequence[_ValueInText[T]], unread_text: _BracketedText | None = None
    ) -> tuple[AnswerSpan, ...]:
        """Return the parts of the answer's text, each with its treatment (`AnswerSpanKind`), in order.

        Blank parts and code fences are left out.
        """
        marked = [
            AnswerSpan(thought.start, thought.end, AnswerSpanKind.REASONING) for thought in self.thoughts
        ]
        for value in answer_values:
            kind = AnswerSpanKind.REPAIRED if value.repairs else AnswerSpanKind.READ
            marked.append(AnswerSpan(value.start, value.end, kind))
        if unread_text is not None:
            marked.append(AnswerSpan(unread_text.start, unread_text.end, AnswerSpanKind.UNREAD))
        for start, end in _find_ranges_between(marked, len(self.text)):
            words = _FENCE_MARK.sub(lambda mark: " " * len(mark[0]), self.text[start:end])
            if stripped := words.strip():
                begin = start + words.index(stripped)
                marked.append(AnswerSpan(begin, begin + len(stripped), AnswerSpanKind.PROSE))
        return tuple(sorted(marked))


def _find_ranges_between(ranges: Iterable[_TextRange], length: int) -> Iterator[tuple[int, int]]:
    """Yield start and end of each range of a text that lies outside the given ranges.

    Args:
        ranges: the given ranges.
        length: length of the text.
    """
    position = 0
    for text_range in sorted(ranges, key=lambda text_range: text_range.start):
        if position < text_range.start:
            yield position, text_range.start
        position = max(position, text_range.end)
    if position < length:
        yield position, length


def _format_line_and_column(text: str, position: int) -> str:
    line_start = text.rfind("\n", 0, position) + 1
    return f"line {text.count(chr(10), 0, position) + 1}, column {position - line_start + 1}"


def has_unclosed_bracket(text: str) -> bool:
    """Whether a text opens a bracket that it never closes."""
    return any(
        bracketed_text.problem is not None and bracketed_text.problem.reason == _UNCLOSED
        for bracketed_text in _find_bracketed_texts(text)
    )


def _find_bracketed_texts(text: str) -> Iterator[_BracketedText]:
    position = 0
    while bracket := _BRACKET.search(text, position):
        start = bracket.start()
        if bracket[0] in _OPENING_BRACKET:
            yield _BracketedText(start, start + 1)
            position = start + 1
            continue
        bracketed_text = _find_bracketed_text_at(text, start)
        yield bracketed_text
        if bracketed_text.problem is not None:
            return
        position = bracketed_text.end


def _find_bracketed_text_at(text: str, start: int) -> _BracketedText:
    opened: list[int] = []
    for token in _STRING_COMMENT_OR_BRACKET.finditer(text, start):
        word = token[0]
        if word in ("{", "["):
            opened.append(token.start())
        elif word in _OPENING_BRACKET:
            opening = opened.pop()
            if text[opening] != _OPENING_BRACKET[word]:
                where = _format_line_and_column(text, opening)
                reason = f"this {word} does not close the {text[opening]} of {where}"
                return _BracketedText(start, len(text), _InvalidJson(reason, token.start()))
            if not opened:
                return _BracketedText(start, token.end())
    return _BracketedText(start, len(text), _InvalidJson(_UNCLOSED, opened[0]))


def _read_answer_and_repairs_from_json_value(
    value: object, form: AnswerFormat[T], max_depth: int = 3
) -> tuple[T, tuple[str, ...]] | None:
    """Return the answer in a JSON value (`AnswerFormat.read`), and the names of the repairs that it needs.

    If the value itself is not an answer, the answer is read from inside the value: from the JSON in a string,
    from the only item of a list, or from a member of an object. Only one member of an object may be an
    answer. No other member may be an object or a list, or look like a part of the answer. Return None if
    there is no answer.
    """
    meaning = form.read(value)
    if meaning is not None or max_depth == 0:
        return None if meaning is None else (meaning, form.repairs_of(meaning))
    if isinstance(value, str):
        if "{" not in value and "[" not in value:
            return None
        decoded = _decode_with_repairs(value.strip())
        inner = (
            None
            if isinstance(decoded, _InvalidJson)
            else _read_answer_and_repairs_from_json_value(decoded.value, form, max_depth - 1)
        )
        if inner is None or isinstance(decoded, _InvalidJson):
            return None
        return inner[0], ("json_in_string", *decoded.repairs, *inner[1])
    if isinstance(value, list) and len(value) == 1 and contains_json_object(value[0]):
        item = _read_answer_and_repairs_from_json_value(value[0], form, max_depth - 1)
        return None if item is None else (item[0], ("wrapper_list", *item[1]))
    if not isinstance(value, JsonObject):
        return None
    inside = [
        (key, _read_answer_and_repairs_from_json_value(member, form, max_depth - 1))
        for key, member in value.members
    ]
    wrapped = [(key, inner) for key, inner in inside if inner is not None]
    others = [member for member, (_, inner) in zip(value.members, inside, strict=True) if inner is None]
    if len(wrapped) != 1 or any(_looks_like_part_of_answer(key, member, form) for key, member in others):
        return None
    key, (meaning, repairs) = wrapped[0]
    named = () if key in form.wrappers and not others else ("wrapper_key",)
    return meaning, (*named, *repairs)


def _looks_like_part_of_answer(key: str, member: object, form: AnswerFormat[T]) -> bool:
    if not isinstance(member, str):
        return len(list_nested_values(member)) > 0
    return has_answer_line_under_key(
        key, member, lambda line: form.is_answer_line(line) or form.is_text_with_part(line)
    )


def has_answer_line_under_key(key: str, text: str, is_answer_line: Callable[[str], bool]) -> bool:
    """Whether the text under a key of a JSON object has a line for which ``is_answer_line`` returns True.

    A text is not searched if its key stands for explanations or names, such as ``reasoning`` or ``task``.
    """
    return _REASONING_KEY.fullmatch(key) is None and any(map(is_answer_line, text.splitlines()))


def consists_of_calls(text: str) -> bool:
    """Whether a text has calls such as ``ON(lamp)``, and no other words than connectives."""
    others = _CALL.sub("", text)
    return others != text and not _CONNECTIVE_OR_SIGN.sub("", others)


def contains_json_object(value: object) -> bool:
    """Whether a JSON value is an object, or a list that contains an object at any depth."""
    return isinstance(value, JsonObject) or (
        isinstance(value, list) and any(map(contains_json_object, value))
    )


def _decode_with_repairs(text: str, offset: int = 0, *, repair: bool = True) -> _DecodedJson | _InvalidJson:
    """Return the value of a text that is JSON, or that becomes JSON when some of its characters are repaired.

    Args:
        text: the text, without blanks around it.
        offset: position of the text's first character in the answer.
        repair: whether repairs are tried.
    """
    value = _decode_json(text, _STRICT)
    if not isinstance(value, _InvalidJson):
        return value
    if not repair or text[:1] not in ("{", "["):
        return value._replace(position=value.position + offset)
    repaired_texts = list(_yield_repaired_texts(text))
    for repaired, names in repaired_texts:
        again = _decode_json(repaired, _LENIENT)
        if isinstance(again, _DecodedJson):
            return _DecodedJson(again.value, names or ("line_breaks",))
    for repaired, names in repaired_texts:
        literal = _parse_python_literal(repaired)
        if literal is not None:
            return _DecodedJson(literal.value, (*names, "single_quotes"))
    return value._replace(position=value.position + offset)


def _yield_repaired_texts(text: str) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Yield the text itself, then the text after each further repair, with the names of all its repairs."""
    names: tuple[str, ...] = ()
    yield text, names
    if _UNESCAPED_QUOTE.search(text) is None and (unescaped := _unescape(text)) != text:
        text, names = unescaped, ("escapes",)
        yield text, names
    for repair, name in (
        (lambda words: words.translate(_CURLY), "curly_quotes"),
        (_replace_wide_characters, "wide_characters"),
        (_remove_comments, "comments"),
        (_remove_trailing_commas, "trailing_comma"),
    ):
        repaired = repair(text)
        if repaired != text:
            text, names = repaired, (*names, name)
            yield text, names


def _unescape(text: str) -> str:
    """Return a text without the escapes of JSON strings and HTML; escaped line breaks become blanks."""
    return html.unescape(_ESCAPE.sub(lambda match: _UNESCAPED.get(match[1], match[1]), text))


def _replace_wide_characters(text: str) -> str:
    return _STRING_OR_WIDE.sub(lambda match: match["string"] or WIDE_CHARACTERS[ord(match[0])], text)


def _remove_comments(text: str) -> str:
    return _STRING_OR_COMMENT.sub(lambda match: match["string"] or "", text)


def _remove_trailing_commas(text: str) -> str:
    return _STRING_OR_COMMA.sub(lambda match: match["string"] or "", text)


def _decode_json(text: str, decoder: json.JSONDecoder) -> _DecodedJson | _InvalidJson:
    if text[:1] not in _FIRST_CHARACTERS_OF_JSON:
        return _InvalidJson("expected a JSON value", 0)
    try:
        value, end = decoder.raw_decode(text)
    except json.JSONDecodeError as error:
        return _InvalidJson(_describe_json_error(error), error.pos)
    except (ValueError, RecursionError):
        return _InvalidJson("expected a JSON value that is less nested, with shorter numbers", 0)
    if end != len(text):
        return _InvalidJson("expected the end of the JSON value", end)
    if text.count("[") + text.count("{") >= MAX_JSON_DEPTH and not _is_nested_shallowly(value):
        return _InvalidJson(f"expected at most {MAX_JSON_DEPTH} nested brackets", 0)
    return _DecodedJson(value)


def _describe_json_error(error: json.JSONDecodeError) -> str:
    message = error.msg.removeprefix("Expecting ").removeprefix("Illegal ")
    if error.msg.startswith("Expecting"):
        return f"expected {message}"
    return error.msg[:1].lower() + error.msg[1:]


def _is_nested_shallowly(value: object) -> bool:
    """Whether a value is nested at most `MAX_JSON_DEPTH` deep.

    Recursive functions cannot read deeper values.
    """
    level = [value]
    for _ in range(MAX_JSON_DEPTH):
        level = [part for whole in level for part in list_nested_values(whole)]
        if not level:
            return True
    return False


def list_nested_values(value: object) -> Sequence[object]:
    """Return the elements of a list or the values of a `JsonObject`; an empty list for another value."""
    if isinstance(value, JsonObject):
        return [part for _, part in value.members]
    return value if isinstance(value, list) else ()


def _parse_python_literal(text: str) -> _DecodedJson | None:
    """Return the value of a text that is a Python literal with single quotes, or None for any other text."""
    if "'" not in text:
        return None
    if _JSON_LIKE_LITERAL.fullmatch(text):
        decoded = _decode_json(text.replace("'", '"'), _STRICT)
        if isinstance(decoded, _DecodedJson):
            return decoded
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # Python warns about invalid escapes in answers
            tree = ast.parse(text, mode="eval").body
        return _DecodedJson(_evaluate_literal(tree, MAX_JSON_DEPTH))
    except (ValueError, SyntaxError, RecursionError, MemoryError):
        return None


def _evaluate_literal(node: ast.expr, depth: int) -> object:
    """Return the value of a Python literal, given its syntax tree.

    A dictionary becomes a `JsonObject`, which keeps the order and the duplicates of keys.

    Raises:
        ValueError: the expression is not a literal, or is nested too deep.
    """
    if depth == 0:
        raise ValueError(f"the Python literal has more than {MAX_JSON_DEPTH} nested levels")
    if isinstance(node, ast.Constant) and isinstance(node.value, str | int | float | None):
        return node.value
    if isinstance(node, ast.List | ast.Tuple):
        return [_evaluate_literal(element, depth - 1) for element in node.elts]
    if not isinstance(node, ast.Dict):
        raise ValueError(
            "the Python literal contains an expression other than a constant, a list or a dictionary"
        )
    members = []
    for key, value in zip(node.keys, node.values, strict=True):
        if not isinstance(key, ast.Constant) or not isinstance(key.value, str):
            raise ValueError("the Python literal has a dictionary with a key that is not a string")
        members.append((key.value, _evaluate_literal(value, depth - 1)))
    return JsonObject(members)
