r"""Read the operators of an answer. An answer is read completely, or not at all.

An answer is JSON with a text under ``output``, or PDDL alone. Wrong parentheses or keywords make the answer
unreadable. An operator is read if its parts are complete lists. A part with content that PDDL does not allow
is reported as a defect and counts as wrong. The repairs are those of `eai.abilities.answer_text` and the
following:

* ``no_json``: the PDDL stands alone, or in JSON with a syntax error;
* ``escapes``: ``\n`` and similar escapes are used for line breaks;
* ``closing_parenthesis``: one parenthesis is missing, and its place is known: it is at the end of an operator
  or of a condition without nested parts;
* ``stray_parenthesis``: there are too many parentheses after an operator or one of its parts;
* ``duplicate_operator``: an operator is written twice; the last one counts.

A line that begins with a semicolon is a comment, and operators in it do not count.
"""

from __future__ import annotations

import re
from collections import OrderedDict
from collections.abc import Callable, Hashable
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from threading import Lock
from typing import Generic, NamedTuple, TypeAlias, TypeVar

from eai.abilities.answer_text import (
    ANY_VALUE,
    AnswerFormat,
    JsonObject,
    ParsedAnswer,
    has_unclosed_bracket,
    read_json,
)
from eai.abilities.reasoning import blank_out_thoughts, find_thoughts
from eai.abilities.verdict import AnswerSpan, AnswerSpanKind, Unreadable
from eai.logic.formula import TRUE
from eai.pddl.check import PddlError, PddlFinding, PddlViolationKind
from eai.pddl.model import NO_EFFECT, PddlAction
from eai.pddl.reader import ExpressionList, PddlReader, make_pddl_error, read_group

K = TypeVar("K", bound=Hashable)
V = TypeVar("V")

MAX_CACHED_CHARACTERS = 8_000_000
"""Maximum number of characters in the texts of cached operators.

A read operator takes about 25 bytes per character.

Nine models write about 1,800 different operators for a benchmark. Their texts have less than a million
characters; the inputs that the planner gets for them have 1.5 million.
"""


class ResultCache(Generic[K, V]):
    """A cache of results with a maximum size, for use by several threads.

    If the cache is full, it drops the oldest result, which is computed again when needed. So memory does not
    grow with the number of answers.

    Args:
        limit: maximum total size, in the unit of the sizes that `get_or_compute` gets.
    """

    def __init__(self, limit: int = MAX_CACHED_CHARACTERS) -> None:
        self._limit = limit
        self._known: OrderedDict[K, tuple[V, int]] = OrderedDict()
        self._adding = Lock()
        self.size = 0

    def get_or_compute(self, key: K, size: int, compute: Callable[[], V]) -> V:
        """Return the cached result for a key. If there is no such result, compute and cache it.

        Args:
            key: the key.
            size: size of the result.
            compute: computes the result.
        """
        cached = self._known.get(key)
        if cached is not None:
            return cached[0]
        result = compute()
        with self._adding:
            if key not in self._known:  # another thread may have added the key in between
                self._known[key] = result, size
                self.size += size
            while self.size > self._limit:
                self.size -= self._known.popitem(last=False)[1][1]
        return result


_HEAD = re.compile(r"\(\s*:action\b\s*([^\s()]*)", re.IGNORECASE)
_PART = re.compile(r":(parameters|precondition|effect)\b", re.IGNORECASE)
_COMMENT = re.compile(r";[^\n]*")
_PART_START = re.compile(r"[(:]|(?:parameters|precondition|effect)\s*\(", re.IGNORECASE)
"""Pattern of the start of a part of an operator. A text that starts in another way is prose."""
_COMMENT_LINE = re.compile(r"^[^\S\n]*;(?!\s*:action\b)[^\n]*", re.IGNORECASE | re.MULTILINE)
_PART_WITH_LIST = re.compile(r":?(?:parameters|precondition|effect)\s*\(", re.IGNORECASE)
_BRACKET = re.compile(r"[()]")
_STRAYS = re.compile(r"[\s)]*")
_ESCAPE = re.compile(r'\\(["\\nrt])')
_PARAMETERS_START = re.compile(r"[:：]parameters\s*[(（]", re.IGNORECASE)
"""Pattern of ``:parameters (``. Outside operators, it shows that the beginning of an operator is missing."""
_DEFINITION = re.compile(r"\(\s*define\b", re.IGNORECASE)
_PART_IN_COMMENT = re.compile(
    r"(?:\A;|\()\s*:action\b|(?::\s*|\A;+)(?:parameters|precondition|effect)\s*\(\s*(?:[?)]|[\w-]+\s*[?(])",
    re.IGNORECASE,
)
_NON_PDDL_BRACKETS = re.compile(r"[:;]-?[()]|^[^\S\n]*\w{1,2}\)", re.MULTILINE)
"""Pattern of brackets that are not brackets of PDDL: those in smileys and after list numbers."""
_CONNECTIVE = re.compile(r"\(\s*(?:and|or|imply|when|forall|exists)\b", re.IGNORECASE)
_SIGN = re.compile(r"\(\s*:|\(\s*action\b|:\s*action\b", re.IGNORECASE)
_KNOWN_SIGN = re.compile(
    r"\(\s*:(?:action|domain|requirements|types|constants|predicates|functions|objects|init|goal)\b"
    r"|(?<=\()\s*:action\b|(?<=\(\s):action\b",
    re.IGNORECASE,
)
"""Pattern of beginnings of PDDL sections that are known, such as ``(:action``."""
_OPERATOR_SIGN = re.compile(r"""\(\s*:action\b|["']output["']""", re.IGNORECASE)
_END_OF_WRAPPER = re.compile(r"""[\s"'`\]]*\}""")
_END_OF_JSON_TEXT = re.compile(r"""\s*["'][\s\]]*\}""")
_READ = (AnswerSpanKind.READ, AnswerSpanKind.REPAIRED)
_NO_BEGINNING = "there is a part of an operator without its beginning before the first operator"
_CLOSING, _STRAY = "closing_parenthesis", "stray_parenthesis"
_MEANING = {"n": "\n", "r": "\n", "t": "\t", '"': '"', "\\": "\\"}


@dataclass(frozen=True, slots=True)
class WrittenOperator:
    """An operator of an answer.

    Attributes:
        name: the operator's name, in small letters.
        action: the operator as a PDDL action, in which parts that PDDL does not allow are empty. None if PDDL
            does not allow the parameters, or allows neither precondition nor effect.
        unread: reports on the parts that PDDL does not allow, with the reasons.
        repairs: names of the repairs that were needed to read the operator.
        size: number of characters of the operator's text.
    """

    name: str
    action: PddlAction | None
    unread: tuple[PddlFinding, ...]
    repairs: tuple[str, ...]
    size: int


OperatorCache: TypeAlias = ResultCache[str, WrittenOperator | PddlFinding]
"""A cache of operators by their text. For a text with wrong parentheses, it holds the error."""


def read_operators(
    answer: str, readings: OperatorCache
) -> ParsedAnswer[dict[str, WrittenOperator]] | Unreadable:
    """Return a mapping from names to the operators of an answer, in order; or why the answer cannot be read.

    Args:
        answer: the text of the answer.
        readings: the cache of operators.
    """
    reading = read_json(answer, _OUTPUT)
    if isinstance(reading, Unreadable):
        reading = _read_bare_pddl(answer) or reading
    if isinstance(reading, Unreadable):
        return reading
    text, repairs = reading.value, reading.repairs
    if _ESCAPE.search(text):
        text = _ESCAPE.sub(lambda match: _MEANING[match.group(1)], text)
        repairs = (*repairs, "escapes")
    has_operators = _HEAD.search(text) is not None
    text = _COMMENT_LINE.sub("", text)
    if has_operators and _HEAD.search(text) is None:
        return _mark_answer_as_unreadable(reading, "all operators are in comments")
    hidden = next(filter(_PART_IN_COMMENT.search, _COMMENT.findall(text)), None)
    piece = hidden[:40] if hidden else _find_part_with_unknown_keyword(_COMMENT.sub("", text))
    if piece is not None:
        return _mark_answer_as_unreadable(reading, f"{piece!r} begins no operator, and looks like one")
    first = _HEAD.search(text)
    if _has_end_of_operator_without_beginning(text if first is None else text[: first.start()]):
        return _mark_answer_as_unreadable(reading, _NO_BEGINNING)
    operators: dict[str, WrittenOperator] = {}
    for segment in _split_operators(text):
        operator = readings.get_or_compute(segment, len(segment), partial(_read_operator, segment))
        if isinstance(operator, PddlFinding):
            return _mark_answer_as_unreadable(
                reading, f"the {operator.place} cannot be read: {operator.description}"
            )
        if operators.pop(operator.name, None) is not None:
            operator = replace(operator, repairs=(*operator.repairs, "duplicate_operator"))
        repairs = (*repairs, *operator.repairs)
        operators[operator.name] = operator
    return ParsedAnswer(operators, tuple(dict.fromkeys(repairs)), reading.spans)


def _mark_answer_as_unreadable(reading: ParsedAnswer[str], reason: str) -> Unreadable:
    unread = [replace(span, kind=AnswerSpanKind.UNREAD) for span in reading.spans if span.kind in _READ]
    others = [span for span in reading.spans if span.kind not in _READ]
    return Unreadable(reason, spans=tuple(sorted([*unread, *others])))


def _read_output_text(json_value: object) -> str | None:
    if not isinstance(json_value, JsonObject) or _describe_wrong_key(json_value) is not None:
        return None
    output = dict(json_value.members).get("output")
    if isinstance(output, list) and all(isinstance(item, str) for item in output):
        return "\n".join(output)
    return output if isinstance(output, str) else None


def _describe_wrong_key(json_value: object) -> str | None:
    if not isinstance(json_value, JsonObject):
        return None
    if json_value.repeated_key is not None:
        return f'the key "{json_value.repeated_key}" occurs twice'
    keys = [
        key
        for key, part in json_value.members
        if key != "output" and _has_operator_head_or_parameters(repr(part))
    ]
    return f'the key "{keys[0]}" is not known' if keys else None


def _has_operator_head_or_parameters(text: str) -> bool:
    return _HEAD.search(text) is not None or _PARAMETERS_START.search(text) is not None


_OUTPUT = AnswerFormat(
    'JSON object with a text of operators under "output"',
    _read_output_text,
    is_part=lambda text: _OPERATOR_SIGN.search(text) is not None,
    is_answer_line=lambda line: _HEAD.search(line) is not None,
    flaw=_describe_wrong_key,
    is_certain=lambda text: _HEAD.search(text) is not None,
)


def _read_bare_pddl(answer: str) -> ParsedAnswer[str] | Unreadable | None:
    """Return the PDDL in an answer that is not JSON; None if the answer has no operator or was cut off.

    The answer is unreadable if the first operator lacks its beginning, or if reasoning is never closed.
    """
    thoughts = find_thoughts(answer)
    body = _COMMENT_LINE.sub(lambda line: " " * len(line[0]), blank_out_thoughts(thoughts, answer))
    heads = list(_HEAD.finditer(body))
    if not heads:
        return None
    start, end = heads[0].start(), body.rfind(")") + 1
    if end <= heads[-1].start():
        return None
    if thoughts and not thoughts[-1].is_finished and _HEAD.search(thoughts[-1].text):
        return Unreadable("the reasoning is never closed, and has operators")
    before, after = body[:start], body[end:]
    is_wrapped = has_unclosed_bracket(before)
    is_end_of_json = "{" not in body[:end] and _END_OF_JSON_TEXT.match(after) is not None
    if is_end_of_json:
        return Unreadable("the answer ends as a JSON object whose beginning is missing")
    if _has_end_of_operator_without_beginning(before):
        return Unreadable(_NO_BEGINNING)
    if is_wrapped and (
        not _END_OF_WRAPPER.match(after) or isinstance(read_json(answer, ANY_VALUE), ParsedAnswer)
    ):
        return None  # the answer was cut off, or is JSON of another form
    words = _NON_PDDL_BRACKETS.sub("", _COMMENT.sub("", body))
    is_definition_open = _DEFINITION.search(before) is not None and words.count("(") > words.count(")")
    if is_definition_open and not is_wrapped and "```" not in after:
        return Unreadable("the definition around the operators is not closed, as if the answer were cut off")
    last = _read_operator(body[heads[-1].start() :])
    if not is_wrapped and isinstance(last, WrittenOperator) and _CLOSING in last.repairs:
        return None
    spans = [AnswerSpan(thought.start, thought.end, AnswerSpanKind.REASONING) for thought in thoughts]
    spans += [AnswerSpan(0, start, AnswerSpanKind.PROSE)] if before.strip() and not is_wrapped else []
    spans += [AnswerSpan(end, len(body), AnswerSpanKind.PROSE)] if after.strip() and not is_wrapped else []
    spans.append(AnswerSpan(start, end, AnswerSpanKind.REPAIRED))
    operators = body[start:end] if is_wrapped else body[start:]
    return ParsedAnswer(operators, (*(["reasoning"] if thoughts else []), "no_json"), tuple(sorted(spans)))


def _find_part_with_unknown_keyword(text: str) -> str | None:
    """Return the beginning of a text that looks like a part of an operator but has an unknown keyword."""
    for sign in _SIGN.finditer(text):
        if _KNOWN_SIGN.match(text, sign.start()) is None:
            return text[sign.start() :][:40].split("\n")[0]
    return None


def _has_end_of_operator_without_beginning(text: str) -> bool:
    """Whether the text before the first operator contains the end of another operator.

    Surplus closing brackets do not count if the text defines a problem or domain.
    """
    words = _NON_PDDL_BRACKETS.sub("", _COMMENT.sub("", text))
    is_closed = words.count(")") > words.count("(") and _DEFINITION.search(text) is None
    return is_closed or _PARAMETERS_START.search(text) is not None


def _split_operators(text: str) -> list[str]:
    bounds = [*(match.start() for match in _HEAD.finditer(text)), len(text)]
    return [text[start:end] for start, end in pairwise(bounds)]


def _read_operator(text_with_comments: str) -> WrittenOperator | PddlFinding:
    """Return the operator at the beginning of a text. Prose after the operator is ignored."""
    text = _COMMENT.sub("", text_with_comments)
    operator = _read_operator_definition(text, len(text_with_comments))
    end = _find_operator_end_before_prose(text) if isinstance(operator, PddlFinding) else None
    return operator if end is None else _read_operator_definition(text[:end], len(text_with_comments))


def _find_operator_end_before_prose(text: str) -> int | None:
    try:
        end = read_group(text).end
    except PddlError:
        return None
    rest = text[end:]
    is_cut = _PART_WITH_LIST.search(rest) is not None and _has_end_of_operator_without_beginning(rest)
    return end if rest.lstrip()[:1].isalpha() and not is_cut else None


def _read_operator_definition(
    text: str, text_length_before_comment_removal: int
) -> WrittenOperator | PddlFinding:
    head = _HEAD.match(text)
    name = head.group(1).lower() if head else ""
    action = PddlAction(name, (), TRUE, NO_EFFECT)
    allowed: set[str] = set()
    unread: list[PddlFinding] = []
    repairs: dict[str, None] = {}
    place = f"operator {name}"
    try:
        parts = _split_operator_into_parts(text, name, head.end() if head else 0)
        keywords = [part.keyword for part in parts]
        for part in parts:
            place = f"{part.keyword} of {name}"
            group, made = _read_list_and_repairs(part)
            repairs |= dict.fromkeys(made)
            try:
                if keywords.count(part.keyword) > 1:
                    raise make_pddl_error(
                        part.text, 0, PddlViolationKind.MALFORMED, f":{part.keyword} once only"
                    )
                action = _add_part_to_operator(action, part, group)
                allowed.add(part.keyword)
            except PddlError as error:
                unread.append(PddlFinding(error.offence, error.expected, place))
    except PddlError as error:
        return PddlFinding(error.offence, error.expected, place)
    has_parameters = all(finding.place != f"parameters of {name}" for finding in unread)
    is_known = not unread or (has_parameters and not allowed.isdisjoint(("precondition", "effect")))
    return WrittenOperator(
        name,
        action if is_known else None,
        tuple(dict.fromkeys(unread)),
        tuple(repairs),
        text_length_before_comment_removal,
    )


class _OperatorKeywordSection(NamedTuple):
    """A part of an operator: a keyword, and the text after it up to the next keyword or the end."""

    keyword: str
    text: str
    last: bool


def _split_operator_into_parts(text: str, operator_name: str, offset: int) -> list[_OperatorKeywordSection]:
    """Return the parts of an operator that follow its name.

    Raises:
        PddlError: the name is missing, or other text stands between parts.
    """
    keywords = list(_PART.finditer(text, offset))
    between = text[offset : keywords[0].start() if keywords else len(text)].strip()
    if not operator_name or operator_name.startswith(":") or (keywords and between):
        raise make_pddl_error(text, 0, PddlViolationKind.MALFORMED, "(:action NAME ...)")
    if not keywords and not between.startswith(")"):
        raise make_pddl_error(text, 0, PddlViolationKind.UNBALANCED, "a partner for this opening parenthesis")
    bounds = [*(match.start() for match in keywords), len(text)]
    return [
        _OperatorKeywordSection(match.group(1).lower(), text[match.end() : end], match is keywords[-1])
        for match, end in zip(keywords, bounds[1:], strict=True)
    ]


def _read_list_and_repairs(part: _OperatorKeywordSection) -> tuple[ExpressionList, tuple[str, ...]]:
    """Return the list in a part of an operator, and the names of the repairs that the list needed.

    Raises:
        PddlError: the part does not have exactly one list, or lacks more than one parenthesis.
    """
    try:
        group = read_group(part.text)
    except PddlError as error:
        closed = part.text.rstrip() + ")"
        if (
            part.last
            or error.offence is not PddlViolationKind.UNBALANCED
            or len(_CONNECTIVE.findall(closed)) > 1
        ):
            raise
        return read_group(closed), (_CLOSING,)
    rest = part.text[group.end :].strip()
    if part.last and not _BRACKET.search(rest):
        return group, (_CLOSING,)
    is_closed = rest.startswith(")") and _PART_START.match(rest.lstrip(") \n\t\r")) is None
    if part.last and is_closed:
        return group, (_STRAY,) if ")" in rest[1:] else ()
    if not part.last and _STRAYS.fullmatch(rest):
        return group, (_STRAY,) if rest else ()
    raise make_pddl_error(part.text, group.end, PddlViolationKind.MALFORMED, "one list behind a keyword")


def _add_part_to_operator(
    action: PddlAction, part: _OperatorKeywordSection, expression: ExpressionList
) -> PddlAction:
    """Return an operator with one more part.

    Raises:
        PddlError: ``expression`` is not valid PDDL after the part's keyword, such as ``:effect``.
    """
    reader = PddlReader(part.text)
    match part.keyword:
        case "precondition":
            return replace(action, precondition=reader.read_condition_or_empty(expression))
        case "effect":
            return replace(action, effect=reader.read_effect_or_empty(expression))
        case _:
            return replace(action, parameters=reader.read_variables(expression))
