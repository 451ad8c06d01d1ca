r"""Reading operators out of an answer.

Looked for is JSON with a text under ``output``, anywhere in the answer; failing that, PDDL in the answer
itself. Each operator is read on its own, so that a broken one does not take the others with it. What had to
be put right on the way is named in ``repairs``:

* those of `json_text`: ``reasoning``, ``special_tokens``, ``code_fence``, ``prose``, ``single_quotes``;
* ``no_json``: the PDDL does not stand in readable JSON;
* ``escapes``: ``\n`` and the like stood where line ends were meant;
* ``closing_parenthesis``: an operator's own last parenthesis is missing;
* ``stray_parenthesis``: one too many behind an operator;
* ``duplicate_operator``: an operator is written twice; the last counts.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import TypeAlias

from eai.abilities.json_text import Pairs, find_json
from eai.abilities.transition_modeling.memory import Memory
from eai.logic.frozen import Frozen
from eai.pddl.model import PddlAction
from eai.pddl.offence import Offence, PddlError, PddlFinding
from eai.pddl.reader import PddlReader
from eai.pddl.sexpr import read_group

_HEAD = re.compile(r"\(\s*:action\b\s*([^\s()]*)", re.IGNORECASE)
_ESCAPE = re.compile(r'\\(["\\nrt])')
_TAIL = re.compile(r"""[\s"'`}\]]*""")
"""What may stand behind the last operator: the end of JSON, of a code fence."""
_MEANING = {"n": "\n", "r": "\n", "t": "\t", '"': '"', "\\": "\\"}


@dataclass(frozen=True, slots=True)
class WrittenOperator(Frozen):
    """An operator of an answer: its value, or the offence for which it cannot be read.

    Attributes:
        size: how many characters it takes.
    """

    name: str
    reading: PddlAction | PddlFinding
    size: int


Reading: TypeAlias = tuple[WrittenOperator, tuple[str, ...]]
"""An operator, and the repairs that it took to read it."""

Readings: TypeAlias = Memory[str, Reading]


@dataclass(frozen=True, slots=True)
class WrittenOperators(Frozen):
    """The operators of an answer in order, each name once, and the repairs it took to read them."""

    operators: tuple[WrittenOperator, ...]
    repairs: tuple[str, ...]


def extract(answer: str, readings: Readings) -> WrittenOperators | None:
    """The operators of an answer, or None if it holds neither JSON with ``output`` nor an operator.

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
        operator, more = readings.recall(segment, len(segment), partial(_read, segment))
        repairs = (*repairs, *more)
        if operators.pop(operator.name, None) is not None:
            repairs = (*repairs, "duplicate_operator")
        operators[operator.name] = operator
    return WrittenOperators(tuple(operators.values()), tuple(dict.fromkeys(repairs)))


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


def _read(segment: str) -> Reading:
    head = _HEAD.match(segment)
    name = head.group(1).lower() if head else ""
    try:
        return _parse(segment)
    except PddlError as error:
        closed = _closed(segment) if error.offence is Offence.UNBALANCED else None
        if closed is not None:
            return closed
        finding = PddlFinding(error.offence, error.expected, f"operator {name}")
        return WrittenOperator(name, finding, len(segment)), ()


def _closed(segment: str) -> Reading | None:
    """The operator with one parenthesis put behind it, if that is all it lacks."""
    end = segment.rfind(")") + 1
    if not _TAIL.fullmatch(segment, end):
        return None
    try:
        operator, repairs = _parse(segment[:end] + ")")
    except PddlError:
        return None
    return operator, ("closing_parenthesis", *repairs)


def _parse(segment: str) -> Reading:
    group = read_group(segment)
    action = PddlReader(segment).action(group)
    repairs = ("stray_parenthesis",) if ")" in segment[group.end :] else ()
    return WrittenOperator(action.name, action, len(segment)), repairs
