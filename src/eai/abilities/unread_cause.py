"""Find out why nothing in an answer could be read, for example because it is a refusal or repeats itself.

The cause is stored as the id of the failed check in a parsing error (`ErrorReport.check`), so that tables of
errors count causes. A cause never changes whether an answer is read.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Collection
from dataclasses import replace
from textwrap import shorten
from typing import Literal, NamedTuple, TypeAlias, TypeVar

from eai.abilities.answer_text import MAX_ANSWER_CHARACTERS, has_unclosed_bracket
from eai.abilities.explanation import VerdictExplanation
from eai.abilities.protocol import Ability
from eai.abilities.reasoning import blank_out_thoughts, find_thoughts
from eai.abilities.scorer import Assessment
from eai.abilities.verdict import Verdict
from eai.world.fault import FaultKind

V = TypeVar("V", bound=Verdict)


UnreadCause: TypeAlias = Literal[
    "loop",
    "unfinished_thought",
    "empty",
    "other_ability",
    "other_notation",
    "cut_off",
    "refusal",
    "prose",
]
"""The causes for which answers cannot be read. If several causes apply, the first counts.

- loop: the same text is repeated again and again.
- unfinished_thought: the reasoning has no end.
- empty: there are no words.
- other_ability: the answer has the form of another kind of question.
- other_notation: the answer is in lines of actions, PDDL, XML or program code.
- cut_off: the end of the answer is missing.
- refusal: the model refuses to answer.
- prose: there is only prose.
"""


class _CauseOfUnreadability(NamedTuple):
    """A cause, and a sentence that explains it."""

    cause: UnreadCause
    sentence: str


_CUT_OFF = _CauseOfUnreadability("cut_off", "the end of the answer is missing")

_MAX_SEARCHED_CHARACTERS = 4000
"""Maximum number of characters at the end of an answer that are searched for a loop."""

_MIN_REPEATS, _MIN_LOOP = 5, 40
"""Minimum number of repeats in a loop (repeated text), and its minimum length in characters, with repeats."""

_MIN_LOOP_IN_LONG_ANSWER = 1000
"""Minimum length of a loop (repeated text) that fills less than half the answer, counted as `_MIN_LOOP`."""

_MAX_QUOTED = 60
_MAX_BEFORE_REFUSAL = 200
"""Maximum number of characters that may stand before a refusal in an answer."""

_TOKENS = re.compile(r"<\|[\w-]+\|>|</?s>|```[\w-]*")
_KEY = re.compile(r"""["'][^"'\n]*["']\s*:""")
_LIST_NUMBER = re.compile(r"^[ \t]*\d+[.):][ \t]*", re.MULTILINE)
_JSON = re.compile(r"""[{\[]\s*["'“{\[]""")
_QUOTE = re.compile(r'(?<!\\)"')
_APPENDED_CHARACTERS = "]}`\n\t "
"""Closing brackets and similar characters, which programs append to an answer that was cut off."""

_REFUSAL = re.compile(
    r"\bI (?:can(?:['’]t|not)|could not|won['’]t|will not)"
    r"(?:[.!]|$|,? (?:help|assist|do|provide|create|write|generate|fulfil|comply|answer|complete|perform"
    r"|carry|plan|physically|directly|execute|give|continue)\b)|\bI(?:['’]m| am) (?:unable|not able) to\b"
    r"|\bI must decline\b"
    r"|\bas an? (?:AI|(?:large )?language model)\b[^.!?\n]{0,80}(?:\bnot?\b|n['’]t\b|cannot\b|\bunable\b)",
    re.IGNORECASE,
)
_OPERATOR = re.compile(r"\(\s*:action\b")
_UNQUOTED_LISP = re.compile(r"""["']\s*:\s*\(""")
_LABEL = r"""^[ \t*>•"'`\[(-]*(?:(?i:step)[ \t]*)?(?:\d+[ \t]*[.):]+[ \t*"'`\[(-]*)?"""
_CALL_LINE = re.compile(_LABEL + r"(?P<call>[A-Za-z_][\w.]*\([^()\n]*\))", re.MULTILINE)
_LISP_LINE = re.compile(r"^[ \t]*\([ \t]*:?[\w-]+(?:[ \t)][^\n]*)?$", re.MULTILINE)
_XML = re.compile(r"</[A-Za-z]\w*>")
_CODE = re.compile(r"^[ \t]*(?:def \w+\(|import \w|from \w+ import |print\()", re.MULTILINE)


def find_cause_of_unreadability(
    text: str, actions: Collection[str], find_other_ability: Callable[[], Ability | None]
) -> _CauseOfUnreadability | None:
    """Return why an answer cannot be read, or None if no cause applies.

    Args:
        text: the answer.
        actions: names of the domain's actions.
        find_other_ability: returns another ability whose form the answer has, or None.
    """
    if len(text) > MAX_ANSWER_CHARACTERS:
        return None
    looped = find_repeated_ending(text)
    if looped:
        quoted = shorten(looped, _MAX_QUOTED, placeholder=" ...")
        return _CauseOfUnreadability("loop", f"the answer repeats the same text again and again: {quoted}")
    thoughts = find_thoughts(text)
    if thoughts and not thoughts[-1].is_finished:
        return _CauseOfUnreadability("unfinished_thought", "the reasoning does not end, so no answer follows")
    body = _TOKENS.sub(" ", blank_out_thoughts(thoughts, text)).strip()
    if not re.search(r"\w", _KEY.sub("", body)):
        return _CauseOfUnreadability("empty", "the answer is empty: it holds no words")
    is_json = _JSON.search(body) is not None
    ability = find_other_ability()
    if ability is not None:
        name = ability.value.replace("_", " ")
        return _CauseOfUnreadability("other_ability", f"the answer has the form of {name}")
    notation = _find_name_of_wrong_notation(body, actions, is_json=is_json)
    if notation:
        return _CauseOfUnreadability("other_notation", f"the answer looks like {notation}")
    if _is_cut_off(body, is_json=is_json):
        return _CUT_OFF
    if is_json:
        return None
    if _REFUSAL.search(body[:_MAX_BEFORE_REFUSAL]):
        return _CauseOfUnreadability("refusal", "the model refuses to answer")
    return _CauseOfUnreadability("prose", "the answer is only prose")


def find_repeated_ending(text: str) -> str:
    """Return the text that an answer repeats at its end, or an empty text if there is no loop.

    Repeats may differ in white space and in the numbers of list items.
    """
    words = " ".join(_LIST_NUMBER.sub("", text).split()).rstrip(_APPENDED_CHARACTERS)
    backwards = words[: -_MAX_SEARCHED_CHARACTERS - 1 : -1]
    borders = [0] * len(backwards)
    looped, unit, border = 0, 0, 0
    for i in range(1, len(backwards)):
        while border and backwards[i] != backwards[border]:
            border = borders[border - 1]
        border += backwards[i] == backwards[border]
        borders[i] = border
        period = i + 1 - border
        if i + 1 >= _MIN_REPEATS * period:
            looped, unit = i + 1, period
    if looped < _MIN_LOOP or (2 * looped < len(words) and looped < _MIN_LOOP_IN_LONG_ANSWER):
        return ""
    start = len(words) - looped
    start += words[start : start + unit].find(" ") + 1  # begin with a whole word
    return words[start : start + unit].strip()


def _find_name_of_wrong_notation(body: str, actions: Collection[str], *, is_json: bool) -> str | None:
    """Return the wrong notation of an answer in words, such as PDDL; None if it is right or unknown."""
    if _OPERATOR.search(body):
        return "PDDL that is not quoted as a text" if _UNQUOTED_LISP.search(body) else None
    if is_json:
        return "a JSON list of texts, not of steps" if _is_list_of_action_texts(body, actions) else None
    named = re.compile(_LABEL + rf"(?:{'|'.join(map(re.escape, actions))})\b[\])]?[ :(<]", re.MULTILINE)
    call = _CALL_LINE.search(body)
    if call is not None:
        return f"lines of ACTION(x): {shorten(call['call'], _MAX_QUOTED, placeholder=' ...')}"
    if actions and named.search(body):
        return "lines of ACTION x"
    for pattern, name in ((_LISP_LINE, "PDDL"), (_XML, "XML"), (_CODE, "program code")):
        if pattern.search(body):
            return name
    return None


def _is_list_of_action_texts(body: str, actions: Collection[str]) -> bool:
    """Whether an answer is a JSON list of texts that begin with names of actions."""
    try:
        value = json.loads(body)
    except (ValueError, RecursionError):
        return False
    if not isinstance(value, list) or not value:
        return False
    return all(isinstance(item, str) and re.split(r"\W", item)[0] in actions for item in value)


def _is_cut_off(body: str, *, is_json: bool) -> bool:
    """Whether the end of an answer is missing.

    Programs may have appended closing brackets to an answer that was cut off.
    """
    if is_json and has_unclosed_bracket(body):
        return True
    if not any(body.count(opening) > body.count(closing) for opening, closing in ("{}", "[]", "()")):
        return False
    end = body.rstrip(_APPENDED_CHARACTERS)[-1:]
    return len(_QUOTE.findall(body)) % 2 == 1 or end in ",:([{" or (not is_json and body[-1].isalnum())


def add_cause_of_unreadability(assessment: Assessment, cause: _CauseOfUnreadability | None) -> Assessment:
    """Return an assessment whose error and explanation also name the cause; unchanged without a cause."""
    if cause is None:
        return assessment
    verdict = _set_error_cause(assessment.verdict, cause.cause)
    return assessment._replace(
        verdict=verdict, explain=lambda: _add_sentence_on_cause(assessment.explain(), cause)
    )


def mark_as_cut_off(
    verdict: V, explanation: VerdictExplanation | None
) -> tuple[V, VerdictExplanation | None]:
    """Return a verdict and its explanation, changed because a length limit cut the answer off.

    If the answer is unreadable with the cause ``prose`` or without a cause, its cause becomes ``cut_off``.
    Else nothing changes. An explanation that is None stays None.
    """
    error = verdict.error
    if error is None or error.kind is not FaultKind.PARSING or error.check not in (None, "prose"):
        return verdict, explanation
    verdict = _set_error_cause(verdict, _CUT_OFF.cause)
    return verdict, None if explanation is None else _add_sentence_on_cause(explanation, _CUT_OFF)


def _set_error_cause(verdict: V, cause: UnreadCause) -> V:
    error = verdict.error
    return verdict if error is None else replace(verdict, error=replace(error, check=cause))


def _add_sentence_on_cause(
    explanation: VerdictExplanation, cause: _CauseOfUnreadability
) -> VerdictExplanation:
    notes = [note for note in explanation.notes if not note.startswith("prose: ")]
    return replace(explanation, notes=(*notes, f"{cause.cause}: {cause.sentence}"))
