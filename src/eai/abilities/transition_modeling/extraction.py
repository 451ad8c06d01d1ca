r"""Reading operators out of an answer.

Looked for is JSON with a text under ``output``, anywhere in the answer; failing that, PDDL in the answer
itself. Each operator is read on its own, and each of its sides, so that a broken one does not take the others
with it. What had to be put right on the way is named in ``repairs``:

* those of `json_text`: ``reasoning``, ``special_tokens``, ``code_fence``, ``prose``, ``single_quotes``;
* ``no_json``: the PDDL does not stand in readable JSON;
* ``escapes``: ``\n`` and the like stood where line ends were meant;
* ``closing_parenthesis``: the last parenthesis of an operator or of one of its parts is missing; with it the
  part can be read;
* ``stray_parenthesis``: there are too many behind an operator or one of its parts;
* ``duplicate_operator``: an operator is written twice; the last counts.
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

from eai.abilities.json_text import Pairs, find_json
from eai.logic.formula import TRUE
from eai.pddl.check import Offence, PddlError, PddlFinding
from eai.pddl.model import NO_EFFECT, PddlAction
from eai.pddl.reader import Group, PddlReader, error_at, read_group

K = TypeVar("K", bound=Hashable)
V = TypeVar("V")

LIMIT = 8_000_000
"""How many characters of operators are remembered at most, some 25 bytes each once they are read. Nine models
write some 1,800 different operators for a benchmark in under a million, and 1.5 million for the planner."""


class Memory(Generic[K, V]):
    """Results by what they are results of; beyond a limit the oldest is forgotten, to be found out again.

    However many answers are scored, and however long, memory stays flat. Any number of threads may ask.

    Args:
        limit: how much is remembered, in the unit of what `recall` is given.
    """

    def __init__(self, limit: int = LIMIT) -> None:
        self._limit = limit
        self._known: OrderedDict[K, tuple[V, int]] = OrderedDict()
        self._adding = Lock()
        self.size = 0

    def recall(self, key: K, size: int, find: Callable[[], V]) -> V:
        """The result for a key of that size, which ``find`` finds out where it is not remembered."""
        known = self._known.get(key)
        if known is not None:
            return known[0]
        result = find()
        with self._adding:
            if key not in self._known:  # no other thread has just found it, too
                self._known[key] = result, size
                self.size += size
            while self.size > self._limit:
                self.size -= self._known.popitem(last=False)[1][1]
        return result


_HEAD = re.compile(r"\(\s*:action\b\s*([^\s()]*)", re.IGNORECASE)
_PART = re.compile(r":(parameters|precondition|effect)\b", re.IGNORECASE)
_COMMENT = re.compile(r";[^\n]*")
_BRACKET = re.compile(r"[()]")
_STRAYS = re.compile(r"[\s)]*")
_ESCAPE = re.compile(r'\\(["\\nrt])')
_TAIL = re.compile(r"""[\s"'`}\]]*""")
"""Text that may stand behind the last operator: the end of JSON, of a code fence."""
_CLOSING, _STRAY = "closing_parenthesis", "stray_parenthesis"
_MEANING = {"n": "\n", "r": "\n", "t": "\t", '"': '"', "\\": "\\"}


@dataclass(frozen=True, slots=True)
class WrittenOperator:
    """An operator of an answer, as far as it can be read.

    Attributes:
        action: its value, in which a side that cannot be read is empty; None if no side can be, or not the
            parameters.
        unread: what is wrong with what cannot be read, and in which part.
        repairs: the names of the repairs that it took to read it.
        size: how many characters it takes.
    """

    name: str
    action: PddlAction | None
    unread: tuple[PddlFinding, ...]
    repairs: tuple[str, ...]
    size: int


Readings: TypeAlias = Memory[str, WrittenOperator]


def extract(answer: str, readings: Readings) -> tuple[dict[str, WrittenOperator], tuple[str, ...]] | None:
    """The operators of an answer in order, by name, and the repairs that it took to read them.

    None if it holds neither JSON with ``output`` nor an operator.

    Args:
        answer: the text.
        readings: what operators written the same way were read as.
    """
    found = find_json(answer, _output)
    if found is not None:
        text, repairs = found
    elif _HEAD.search(answer):
        text, repairs = answer, ("no_json",)
    else:
        return None
    if _ESCAPE.search(text):
        text = _ESCAPE.sub(lambda match: _MEANING[match.group(1)], text)
        repairs = (*repairs, "escapes")
    operators: dict[str, WrittenOperator] = {}
    for segment in _segments(text):
        operator = readings.recall(segment, len(segment), partial(_read, segment))
        if operators.pop(operator.name, None) is not None:
            operator = replace(operator, repairs=(*operator.repairs, "duplicate_operator"))
        repairs = (*repairs, *operator.repairs)
        operators[operator.name] = operator
    return operators, tuple(dict.fromkeys(repairs))


def _output(value: object) -> str | None:
    """The text that a JSON value offers as the answer."""
    if not isinstance(value, Pairs):
        return None
    output = dict(value.members).get("output")
    if isinstance(output, list) and all(isinstance(item, str) for item in output):
        return "\n".join(output)
    return output if isinstance(output, str) else None


def _segments(text: str) -> list[str]:
    """The stretches of a text from one operator's beginning to the next."""
    bounds = [*(match.start() for match in _HEAD.finditer(text)), len(text)]
    return [text[start:end] for start, end in pairwise(bounds)]


def _read(segment: str) -> WrittenOperator:
    """An operator, each of its parts on its own."""
    text = _COMMENT.sub("", segment)
    head = _HEAD.match(text)
    name = head.group(1).lower() if head else ""
    action = PddlAction(name, (), TRUE, NO_EFFECT)
    read: set[str] = set()
    unread: list[PddlFinding] = []
    repairs: tuple[str, ...] = ()
    try:
        parts = _parts(text, name, head.end() if head else 0)
    except PddlError as error:
        finding = PddlFinding(error.offence, error.expected, f"operator {name}")
        return WrittenOperator(name, None, (finding,), (), len(segment))
    for part in parts:
        try:
            group, made, ends = _list(part)
            repairs = (*repairs, *made)
            action = _with(action, part, group)
            read.add(part.keyword)
            if ends:
                break
        except PddlError as error:
            unread.append(PddlFinding(error.offence, error.expected, f"{part.keyword} of {name}"))
    no_parameters = any(finding.place == f"parameters of {name}" for finding in unread)
    known = not unread or (not no_parameters and not read.isdisjoint(("precondition", "effect")))
    repairs = tuple(dict.fromkeys(repairs))
    return WrittenOperator(name, action if known else None, tuple(unread), repairs, len(segment))


class _Part(NamedTuple):
    """A keyword of an operator and what stands behind it, up to the next one or the end of the text."""

    keyword: str
    text: str
    last: bool


def _parts(text: str, name: str, offset: int) -> list[_Part]:
    """The parts that stand behind the name of an operator.

    Raises:
        PddlError: there is no name, or something else behind it.
    """
    found = list(_PART.finditer(text, offset))
    between = text[offset : found[0].start() if found else len(text)].strip()
    if not name or name.startswith(":") or (found and between):
        raise error_at(text, 0, Offence.MALFORMED, "(:action NAME ...)")
    if not found and not between.startswith(")"):
        raise error_at(text, 0, Offence.UNBALANCED, "a partner for this opening parenthesis")
    bounds = [*(match.start() for match in found), len(text)]
    return [
        _Part(match.group(1).lower(), text[match.end() : end], match is found[-1])
        for match, end in zip(found, bounds[1:], strict=True)
    ]


def _list(part: _Part) -> tuple[Group, tuple[str, ...], bool]:
    """The list of a part, the repairs that it took, and whether the operator ends behind it.

    Where need be one parenthesis is put behind it.

    Raises:
        PddlError: there is not one list.
    """
    try:
        group = read_group(part.text)
    except PddlError as error:
        end = part.text.rfind(")") + 1 if part.last else len(part.text)
        if error.offence is not Offence.UNBALANCED or not _TAIL.fullmatch(part.text, end):
            raise
        return read_group(part.text[:end] + ")"), (_CLOSING,), False
    rest = part.text[group.end :].strip()
    if part.last and not _BRACKET.search(rest):
        return group, (_CLOSING,), False
    if part.last and rest.startswith(")"):
        return group, (_STRAY,) if ")" in rest[1:] else (), False
    if not part.last and _STRAYS.fullmatch(rest):
        return group, (_STRAY,) if rest else (), False
    if not part.last and rest.startswith(")"):
        return group, (), True
    raise error_at(part.text, group.end, Offence.MALFORMED, "one list behind a keyword")


def _with(action: PddlAction, part: _Part, group: Group) -> PddlAction:
    """An operator with one more part.

    Raises:
        PddlError: the list is no such part.
    """
    reader = PddlReader(part.text)
    match part.keyword:
        case "precondition":
            return replace(action, precondition=reader.condition(group))
        case "effect":
            return replace(action, effect=reader.whole_effect(group))
        case _:
            return replace(action, parameters=reader.variables(group))
