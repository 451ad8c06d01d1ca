"""Separate reasoning from the answer in a model's output.

Models mark reasoning in different ways: tags such as ``<think>``, special tokens, and channels. Scoring, runs
and rewards use the same definition of reasoning:

* text between an opening and a closing mark is reasoning;
* text before a closing mark without an opening mark is reasoning, because chat templates may write the
  opening mark into the prompt;
* text after an opening mark that is never closed is reasoning, so such text contains no answer.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import NamedTuple

_NAMES = r"(?:seed:)?(?:think(?:ing)?|thoughts?|reasoning|reflection|scratchpad|analysis)"
_FINAL = r"(?:final|response|answer|output|solution)"

_OPENING = "|".join(
    [
        rf"(?i:<{_NAMES}>)",
        rf"(?i:<\|(?:begin_of_|start_)?{_NAMES}\|>)",
        r"\[THINK\]",
        rf"◁{_NAMES}▷",
        r"<unused94>(?:thought\b)?",
        r"<\|channel\|?>\s*(?:analysis|commentary|thought)\b(?:[^<\n]*<\|message\|>)?",
        # without its special tokens, "<|channel|>analysis<|message|>We ..." becomes "analysisWe ..."
        r"\Aanalysis(?=[A-Z])",
    ]
)
_CLOSING = "|".join(
    [
        rf"(?i:</{_NAMES}>)",
        rf"(?i:<\|(?:end_of_|end_|/){_NAMES}\|>)",
        r"\[/THINK\]",
        rf"◁/{_NAMES}▷",
        r"<unused95>",
        rf"(?:<\|end\|>\s*)?(?:<\|start\|>assistant)?<\|channel\|?>\s*{_FINAL}\b(?:[^<\n]*<\|message\|>)?",
        r"<channel\|>",
    ]
)
_MARK_WITHOUT_TOKENS = "assistantfinal"
"""The mark between reasoning and answer without its special tokens: `analysis... assistantfinal...`."""
_MARK = re.compile(rf"(?P<opening>{_OPENING})|(?P<closing>{_CLOSING})|(?P<glued>{_MARK_WITHOUT_TOKENS})")
_HINT = re.compile(r"<[/|]?\|?[A-Za-z]|\[/?THINK|◁|\Aanalysis[A-Z]")


class _ReasoningBlock(NamedTuple):
    """A continuous text of reasoning, and its positions in the output.

    Attributes:
        start: position of the first character. An opening mark belongs to the reasoning.
        end: position after the last character. A closing mark belongs to the reasoning.
        text: the reasoning without its marks.
        is_finished: whether the reasoning has a closing mark.
    """

    start: int
    end: int
    text: str
    is_finished: bool = True


def find_thoughts(text: str) -> tuple[_ReasoningBlock, ...]:
    """Return each continuous text of reasoning in an output, in order and without overlap."""
    if not _HINT.search(text):
        return ()
    thoughts: list[_ReasoningBlock] = []
    opening: re.Match[str] | None = None
    start = _find_end_of_reasoning_without_opening_mark(text)
    for mark in _MARK.finditer(text, start):
        if mark["opening"] is not None:
            opening = opening or mark
        elif opening is not None:
            thoughts.append(_ReasoningBlock(opening.start(), mark.end(), text[opening.end() : mark.start()]))
            opening = None
    if opening is not None:
        thoughts.append(_ReasoningBlock(opening.start(), len(text), text[opening.end() :], is_finished=False))
    return (_ReasoningBlock(0, start, _MARK.sub(" ", text[:start])), *thoughts) if start else tuple(thoughts)


def _find_end_of_reasoning_without_opening_mark(text: str) -> int:
    """Return the position after the last closing mark without an opening mark; 0 without such a mark."""
    end, is_open = 0, False
    for mark in _MARK.finditer(text):
        if mark["closing"] is not None and not is_open:
            end = mark.end()
        is_open = mark["opening"] is not None or (
            is_open and mark["closing"] is None and mark["glued"] is None
        )
    return end


def blank_out_thoughts(thoughts: Iterable[_ReasoningBlock], text: str) -> str:
    """Return a text with blanks in place of reasoning. Positions in the text stay the same."""
    pieces, position = [], 0
    for thought in thoughts:
        pieces += [text[position : thought.start], " " * (thought.end - thought.start)]
        position = thought.end
    return "".join([*pieces, text[position:]])


def split_answer_and_reasoning(text: str) -> tuple[str, str]:
    """Return the answer and the reasoning in a model's output. Either text may be empty.

    The marks before and after reasoning are left out.
    """
    thoughts = find_thoughts(text)
    if not thoughts:
        return text, ""
    answer, position = [], 0
    for thought in thoughts:
        answer.append(text[position : thought.start])
        position = thought.end
    answer.append(text[position:])
    reasoning = [thought.text.strip() for thought in thoughts]
    return "".join(answer).strip(), "\n\n".join(filter(None, reasoning))
