"""Find the step of a plan in a line that also has a number, a title, a remark, or tags around the step."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterator, Sequence
from itertools import islice
from typing import TypeAlias

from eai.abilities.answer_text import WIDE_CHARACTERS
from eai.abilities.notation.plan_form import ORDINARY_WORD, WrittenStep

StepReader: TypeAlias = Callable[[str], WrittenStep | None]
"""Function that returns the step which a text states, or None."""

LABEL = re.compile(
    r"(?:(?:[*>•‣◦▪●–—→+]|->?)\s+|(?i:step)\s*\d+\s*(?:[.:)]|-\s|$)|\d+\s*(?:[.:)](?!\d)|-\s)\s*"
    r"|[(\[]\d+[)\]]\s+|[A-Za-z][.)]\s+|[\u2460-\u2473]\s*)+"
)
"""Pattern of numbers or list signs at the beginning of a line.

A time as in ``0.000:`` belongs to the step.
"""
_TITLE = re.compile(
    r"(?:(?:the|my|final|action)\s+)*(?:answer|plan|output|solution|response|result|assistant"
    r"|(?:action|step|command)s?|sequence)(?:\s*\d+)?\s*[:=]\s*",
    re.IGNORECASE,
)
"""Pattern of a title before a step, such as ``Final answer:``."""
_REMARK_SEPARATOR = re.compile(r"(?<!\s)(?:\s*:|\s+(?:#|//|--?|–|—))(?=\s)")
"""Pattern of the separator between a step and a remark on the step."""
_TAGS_AND_EMOJIS = re.compile(
    r"<\|[\w-]+\|>|\[/?INST\]|\*\*|(?<!`)`(?!`)|</?(?:answer|final_answer|output|response|result|solution|plan"
    r"|actions?|steps?|pre|code|br|s|end_of_turn)\s*/?>|[\u2600-\u27bf\ufe0f\U0001f300-\U0001faff]",
    re.IGNORECASE,
)
"""Pattern of tags, control tokens, emojis and marks of emphasis, which belong to no step."""
PLAIN_CHARACTERS: dict[int, str] = {
    **WIDE_CHARACTERS,
    **dict(zip(map(ord, "\0\xad（）"), "  ()", strict=True)),
}
"""Mapping from blank or invisible characters in a line to a blank, and from wide punctuation to ASCII."""
_NOISE = re.compile(r"<[^<>\s]*>|\\[nrt]|\.{3,}|[^\w\s().,<>\[\]-]+|(?<=,)(?=\S)|(?=\()")
_WORD = re.compile(r"[\w-]+")
_MAX_SEPARATORS = 3
"""Maximum number of separators of one line that are tried as the beginning of a remark."""
_MAX_WORDS_AROUND = 3
"""Maximum number of words before a step in its line, and after it. A line with more words is prose."""

CHARACTERS_AROUND_STEP = " \t,.;!\"'“”‘’"
"""Characters that do not belong to a step if they stand before or after it in a line."""
_CHARACTERS_BEFORE_STEP = " \t,\"'“”‘’"
"""Characters that do not belong to a step if they stand before it in a line. A semicolon begins a comment."""


def blank_out_tags_and_emojis(text: str) -> str:
    """Return a text of equal length with blanks in place of tags, control tokens and emojis.

    If the text has no line break except at its ends, each escaped line break (two characters) becomes a blank
    and a real line break.
    """
    lines = text.replace("\\n", " \n") if "\\n" in text and "\n" not in text.strip() else text
    return _TAGS_AND_EMOJIS.sub(lambda sign: " " * len(sign[0]), lines)


def find_step_and_whether_line_has_other_text(
    line: str, read_step: StepReader, actions: Collection[str]
) -> tuple[WrittenStep | None, bool]:
    """Return the step in a line, and whether a title such as ``Answer:`` or a remark stands beside the step.

    The caller has removed list numbers. If the remark contains a second step, alone or among a few other
    words, None is returned as the step.
    """
    title = _TITLE.match(line)
    for begin in (0, *([] if title is None else [title.end()])):
        text = line[begin:]
        step = read_step(text) or read_step(strip_punctuation(text))
        if step is not None:
            return step, begin > 0
        for separator in islice(_REMARK_SEPARATOR.finditer(text), _MAX_SEPARATORS):
            words = strip_punctuation(text[: separator.start()])
            remark = strip_punctuation(text[separator.end() :])
            if _is_remark_after_step(remark, words) and (step := read_step(words)) is not None:
                has_other_step = read_step(remark) or (
                    not _describes_step(remark, step, actions)
                    and has_step_and_few_other_words(remark, read_step, actions)
                )
                return (None if has_other_step else step), True
    return None, False


def _describes_step(remark: str, step: WrittenStep, actions: Collection[str]) -> bool:
    """Whether a remark is a sentence on its own step, such as ``WALK to the soap`` after ``WALK(soap)``.

    Such a remark begins with the step's action and an ordinary word. It names an object of the step, or
    contains "it", and names no further action.
    """
    action, *words = _WORD.findall(remark.casefold()) or [""]
    if action != step.action.casefold() or not words or ORDINARY_WORD.fullmatch(words[0]) is None:
        return False
    names_of_objects = [str(name).casefold() for name in step.objects]
    objects = {*names_of_objects, *re.findall(r"[^\W\d_]{2,}", " ".join(names_of_objects))}
    names = {name.casefold() for name in actions}
    return names.isdisjoint(words) and not objects.union({"it"}).isdisjoint(words)


def _is_remark_after_step(text: str, step: str) -> bool:
    """Whether the text after a step is a remark, and not an object of the step.

    The text must have no ``(``. The step must end in ``)``, or it must end in a digit and the text must
    contain an ordinary word.
    """
    is_sentence = step[-1:].isdigit() and ORDINARY_WORD.search(text) is not None
    return "(" not in text and (step.endswith(")") or is_sentence)


def strip_punctuation(text: str) -> str:
    """Return a text without the punctuation before and after it.

    A single word keeps its quotes, as it may be a piece of JSON. Dots that stand for omitted text stay, too.
    """
    words = text.lstrip(_CHARACTERS_BEFORE_STEP).rstrip(CHARACTERS_AROUND_STEP)
    is_omission = ".." in text[text.find(words) + len(words) :]
    if is_omission:
        return text.strip()
    return words if " " in words or "(" in words else text.strip(" \t,.;!")


def has_step_and_few_other_words(line: str, read_step: StepReader, actions: Collection[str]) -> bool:
    """Whether a line is a step with at most three other words on each side. The action must be declared.

    A step without brackets counts only if its action is written as declared.
    """
    words = _NOISE.sub(" ", line)
    names = {name.casefold() for name in actions}
    if names.isdisjoint(_WORD.findall(words.casefold())):
        return False
    return any(
        step.action in actions or ("(" in text and step.action.casefold() in names)
        for text in _generate_texts_without_outer_words(words.split())
        if (step := read_step(text)) is not None
    )


def _generate_texts_without_outer_words(words: Sequence[str]) -> Iterator[str]:
    for begin in range(min(_MAX_WORDS_AROUND + 1, len(words))):
        for end in range(max(begin + 1, len(words) - _MAX_WORDS_AROUND), len(words) + 1):
            yield strip_punctuation(" ".join(words[begin:end]))
