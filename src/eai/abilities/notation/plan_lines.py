"""Plans with one step a line, as planners, text games and small models write them.

Each line is a step, a comment, a list number alone, or prose before or after the plan. A line cannot be prose
if it begins with the name of an action, stands between steps, has an unclosed bracket, stands for omitted
steps, or consists of a step and a few other words. The last line can be the beginning of a step. If such a
line cannot be read as a step, the answer is unreadable. In every notation, lines such as ``WALK(soap)`` or
``1. walk soap`` are read if the answer has no JSON, and the verdict notes the repair ``action_lines``.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

from eai.abilities.answer_text import MAX_ANSWER_CHARACTERS, AnswerFormat
from eai.abilities.notation.plan_form import (
    ORDINARY_WORD,
    StepList,
    WrittenPlan,
    WrittenStep,
    correct_action_spelling,
    read_plan,
)
from eai.abilities.notation.step_line import (
    CHARACTERS_AROUND_STEP,
    LABEL,
    PLAIN_CHARACTERS,
    StepReader,
    blank_out_tags_and_emojis,
    find_step_and_whether_line_has_other_text,
    has_step_and_few_other_words,
    strip_punctuation,
)
from eai.abilities.reasoning import blank_out_thoughts, find_thoughts
from eai.abilities.verdict import AnswerSpan, AnswerSpanKind, Unreadable

_COMMENT = re.compile(r";[^\n]*")
_FENCE = "```"
_FENCE_WITH_LANGUAGE = re.compile(r"```+[\w+-]*(?=\s|$)")
_FENCE_MARK = re.compile(r"```+")
_FIRST_WORD = re.compile(r"""[\s"'`(\[{]*([^\s()\[\]{}"'`,:;]+)""")
_MAX_QUOTED = 60
"""Maximum number of characters of a line that a message quotes."""

ACTION_LINES = "action_lines"
"""Name of a repair: reading a plan whose steps are lines of actions instead of JSON."""

_CALL = re.compile(r"([\w-]+)\s*\(([^()]*)\)")
_COMMAND = re.compile(r"[(\[]?([\w-]+)[)\]]?:?((?:[\s,]+[<(]?[\w.-]+[>)]?){0,4})")
_CALL_OR_OBJECTS = re.compile(r"[^\s()]+\s*\([^()]*\)|\([\w.-]+(?:\s*,\s*[\w.-]+)*\)")
_OMISSIONS = ("..", "...", "....", "[...]", "(...)", "<...>", "…", "etc", "etc.")
"""Lines that stand for omitted steps."""

_EMPHASIS = re.compile(r"\*\*|(?<!`)`(?!`)")
_SMILEY = re.compile(r"[:;]-?[()]")
_MAX_LIST_NUMBER_DIGITS = 8
"""Maximum number of digits of a list number; longer numbers are ignored."""

_JSON_LIKE = re.compile(r"\{|\[(?!\w+\])")
_NO_COMMENT = re.compile(r"(?!)")


class _PlanLine(NamedTuple):
    """A line that is not blank and not only a comment.

    Attributes:
        start: position of the line's first character in the answer.
        end: position after the line's last character.
        text: the line without comments, number or list sign, and outer space.
        block_number: number of code-fence marks before the line; odd inside a code fence.
        label: the number or list sign at the beginning of the line, or an empty text.
        step: the step that the line states, or None.
        has_prose: whether the line has a step with a title or a remark beside it. If the remark contains a
            second step, ``step`` is None.
    """

    start: int
    end: int
    text: str
    block_number: int
    label: str
    step: WrittenStep | None
    has_prose: bool


def read_json_plan_or_action_lines(
    text: str, form: AnswerFormat[StepList], actions: Collection[str]
) -> WrittenPlan | Unreadable:
    """Return the plan in an answer, or the reason why it cannot be read.

    Lines of actions are read only if the answer has no JSON.

    Args:
        text: the answer.
        form: the form of the plan in JSON.
        actions: names of actions; without names, lines are not read.
    """
    plan = read_plan(text, form)
    if isinstance(plan, WrittenPlan) or not actions or len(text) > MAX_ANSWER_CHARACTERS:
        return plan
    lines = _read_action_lines(text, actions)
    return plan if lines is None else lines


def looks_like_json(text: str, form: AnswerFormat[StepList] | None = None) -> bool:
    """Whether an answer has the brackets of JSON outside the reasoning of the model.

    If a form is given, the answer must also have text that looks like a part of an answer in this form.
    """
    body = blank_out_thoughts(find_thoughts(text), text)
    return _JSON_LIKE.search(body) is not None and (form is None or form.is_part(body))


def _read_action_lines(text: str, actions: Collection[str]) -> WrittenPlan | Unreadable | None:
    """Return the plan in lines of actions, or None if no line is an action or if the answer has JSON."""
    if looks_like_json(text):
        return None
    names = {name.casefold() for name in actions}
    plan = read_plan_lines(
        text, lambda line: _read_action_line(line, names), actions, _is_call_or_bracketed_objects, _NO_COMMENT
    )
    if not isinstance(plan, WrittenPlan):
        return plan
    steps = [text[span.start : span.end] for span in plan.spans if span.kind is AnswerSpanKind.READ]
    are_steps = any("(" in step for step in steps) or any(step.action in actions for step in plan.steps)
    if "prose" in plan.repairs and not are_steps and "numbered" not in plan.repairs:
        return None  # the lines are short sentences such as "wash hands"
    if "numbered" in plan.repairs:
        prose = [text[span.start : span.end] for span in plan.spans if span.kind is AnswerSpanKind.PROSE]
        if any((label := LABEL.match(line)) and label.end() < len(line) for line in prose):
            return None  # the list has an item that is not an action
    kinds = {AnswerSpanKind.READ: AnswerSpanKind.REPAIRED}
    spans = tuple([replace(span, kind=kinds.get(span.kind, span.kind)) for span in plan.spans])
    return correct_action_spelling(replace(plan, repairs=(*plan.repairs, ACTION_LINES), spans=spans), actions)


def _read_action_line(line: str, action_names: Collection[str]) -> WrittenStep | None:
    words = strip_punctuation(line)
    match = _CALL.fullmatch(words) or _COMMAND.fullmatch(words)
    if match is None or match[1].casefold() not in action_names or _has_unpaired_bracket(words):
        return None
    objects = re.findall(r"""[^\s,<>()"']+""", match[2])
    is_sentence = match.re is _COMMAND and ORDINARY_WORD.search(match[2]) is not None
    return None if is_sentence else WrittenStep(match[1], tuple(objects))


def read_text_of_steps(text: str, actions: Collection[str]) -> StepList | None:
    """Return the steps in a string of a JSON answer, one a line. Return None if some line is not a step.

    A line without brackets is not a step, because another member of the JSON may name its objects. The action
    must be in its declared letter case, because ``open(fridge.97)`` may be a condition.
    """
    names = {name.casefold() for name in actions}
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    read = [_read_action_line(line, names) for line in lines if "(" in line]
    steps = [step for step in read if step is not None and step.action in actions]
    if not steps or len(steps) < len(lines):
        return None
    return StepList(tuple(steps), (ACTION_LINES,))


def _has_unpaired_bracket(text: str) -> bool:
    return any(text.count(opening) != text.count(closing) for opening, closing in ("()", "[]", "<>"))


def _is_call_or_bracketed_objects(line: str) -> bool:
    return _CALL_OR_OBJECTS.fullmatch(line.strip(CHARACTERS_AROUND_STEP)) is not None


def read_plan_lines(
    text: str,
    read_step: StepReader,
    actions: Collection[str],
    looks_like_step: Callable[[str], bool],
    comment: re.Pattern[str] = _COMMENT,
) -> WrittenPlan | Unreadable | None:
    """Return a plan with one step a line, or None if the text has no step.

    A text that consists of comments is a plan without steps. If several code fences have steps, the last
    fence with steps has the plan. Among the answers that are unreadable are those in which

    * the plan is a single step, and an earlier fence has a different step;
    * the previous fence with steps has a different plan, and no words stand between the two fences;
    * the list numbers have a gap, or a list number stands without its step.

    Args:
        text: the answer.
        read_step: returns the step in a line, or None.
        actions: names of actions.
        looks_like_step: whether a line without a readable step was probably meant as a step.
        comment: pattern of comments, which are ignored.
    """
    thoughts = find_thoughts(text)
    spans = [AnswerSpan(thought.start, thought.end, AnswerSpanKind.REASONING) for thought in thoughts]
    repairs = dict.fromkeys(["reasoning"] if thoughts else [])
    outside = blank_out_thoughts(thoughts, text)
    plain = outside.translate(PLAIN_CHARACTERS)
    body = blank_out_tags_and_emojis(plain)
    lines = list(_split_lines(body, read_step, actions, comment))
    steps = [line for line in lines if line.step is not None]
    if not steps:
        return WrittenPlan((), tuple(repairs), tuple(spans)) if not lines and comment.search(body) else None
    names = {name.casefold() for name in actions}
    if thoughts and not thoughts[-1].is_finished:
        unfinished = [line.step for line in _split_lines(thoughts[-1].text, read_step, actions, comment)]
        if any(step is not None and step.action.casefold() in names for step in unfinished):
            return Unreadable("the reasoning is never closed, and has steps of a plan", spans=tuple(spans))
    block = max((line.block_number for line in steps if line.block_number % 2), default=0)
    plan = [line for line in steps if line.block_number == block or not block]
    starts = {line.start for line in plan}
    if len(plan) == 1 and any(line.block_number % 2 and line.step != plan[0].step for line in steps):
        reason = "the last code fence has only one step, and an earlier one has others"
        return _report_unreadable_line(body, plan[0], spans, reason)
    earlier = max(
        (line.block_number for line in steps if line.block_number % 2 and line.block_number < block),
        default=0,
    )
    is_followed = earlier and not any(line.text and earlier < line.block_number < block for line in lines)
    if is_followed and [line.step for line in steps if line.block_number == earlier] != [
        line.step for line in plan
    ]:
        reason = "the code fence before has another plan, and no words between say which one counts"
        return _report_unreadable_line(body, plan[0], spans, reason)
    if _has_gap_in_list_numbers(plan):
        return _report_unreadable_line(body, plan[0], spans, "the numbers of the steps have a gap")
    others = {
        line.start
        for line in lines
        if line.start not in starts
        and (not block or line.block_number == block or line.block_number % 2 == 0)
    }
    numbers = [line for line in lines if line.start in others and not line.text]
    unnumbered = [line for line in plan if not line.label]
    if numbers and (len(numbers) != len(unnumbered) or numbers[-1].start > plan[-1].start):
        return _report_unreadable_line(body, numbers[-1], spans, "a list number stands without its step")
    for line in lines:
        if line.start in others:
            is_between = plan[0].start < line.start < plan[-1].start
            if line.text and (
                is_between
                or _is_line_of_plan(line, names)
                or (line is lines[-1] and _is_beginning_of_step(line.text, names, plan[-1]))
                or looks_like_step(line.text)
                or has_step_and_few_other_words(line.text, read_step, actions)
            ):
                return _report_unreadable_line(body, line, spans)
            repairs["prose" if line.text else "numbered"] = None
        spans.append(
            AnswerSpan(
                line.start, line.end, AnswerSpanKind.READ if line.start in starts else AnswerSpanKind.PROSE
            )
        )
    repairs |= dict.fromkeys(
        ["special_tokens"] if body != _EMPHASIS.sub(_replace_match_by_blanks, plain) else []
    )
    repairs |= dict.fromkeys(["wide_characters"] if plain != outside else [])
    repairs |= dict.fromkeys(["prose"] if any(line.has_prose for line in plan) else [])
    repairs |= dict.fromkeys(["code_fence"] if block else [])
    repairs |= dict.fromkeys(["numbered"] if any(line.label for line in plan) else [])
    taken = tuple([line.step for line in plan if line.step is not None])
    return WrittenPlan(taken, tuple(repairs), tuple(sorted(spans)))


def _replace_match_by_blanks(match: re.Match[str]) -> str:
    return " " * len(match[0])


def _split_lines(
    text: str, read_step: StepReader, actions: Collection[str], comment: re.Pattern[str]
) -> Iterator[_PlanLine]:
    position = block = 0
    for whole in text.splitlines(keepends=True):
        line = comment.sub("", whole).rstrip()
        remark = whole[len(line) :].rstrip().strip(CHARACTERS_AROUND_STEP)
        # the comment in "(;pick a)" begins after the opening bracket of a step
        if remark and any(read_step(words) is not None for words in (remark, f"({remark}")):
            line = whole.rstrip()  # a step is not a comment
        words = line.lstrip()
        start = position + len(line) - len(words)
        position += len(whole)
        if words.startswith(_FENCE):
            block += 1
            begin = _find_offset_after_fence_and_language(words, read_step)
            words, start = words[begin:], start + begin
        is_end = words.endswith(_FENCE)
        words = words.removesuffix(_FENCE).rstrip()
        if words:
            yield _read_plan_line(words, start, block, read_step, actions)
        block += is_end


def _find_offset_after_fence_and_language(line: str, read_step: StepReader) -> int:
    """Return the position after a code fence, the name of its language, and blanks.

    If a step follows the fence in the same line, its first word is not taken for the name of a language.
    """
    for pattern in (_FENCE_MARK, _FENCE_WITH_LANGUAGE):
        mark = pattern.match(line)
        if mark is not None:
            rest = line[mark.end() :].removesuffix(_FENCE).strip()
            if not rest or read_step(rest) is not None or pattern is _FENCE_WITH_LANGUAGE:
                return len(line) - len(line[mark.end() :].lstrip())
    return len(_FENCE)


def _read_plan_line(
    text: str, start: int, block_number: int, read_step: StepReader, actions: Collection[str]
) -> _PlanLine:
    end = start + len(text)
    step = read_step(text)
    label = None if step is not None else LABEL.match(text)
    rest = text if label is None else text[label.end() :]
    step, has_prose = (
        (step, False)
        if step is not None
        else find_step_and_whether_line_has_other_text(rest, read_step, actions)
    )
    return _PlanLine(start, end, rest, block_number, label[0] if label else "", step, has_prose)


def _is_line_of_plan(line: _PlanLine, action_names: Collection[str]) -> bool:
    """Whether a line has steps, an action at its start, an unclosed bracket, or a sign of omitted steps."""
    word = _FIRST_WORD.match(line.text)
    is_named = word is not None and word[1].casefold() in action_names
    words = _SMILEY.sub("", line.text)
    is_open = words.count("(") != words.count(")")
    return line.step is not None or line.has_prose or is_named or is_open or words.lower() in _OMISSIONS


def _is_beginning_of_step(text: str, action_names: Collection[str], last_step: _PlanLine) -> bool:
    """Whether a text is the beginning of a further step, as at the end of a cut answer.

    It is the first letters of an action, or the number of a step if the last step has a number.
    """
    if text.isdigit():
        return re.search(r"\d", last_step.label) is not None
    return any(name.startswith(text.casefold()) for name in action_names)


def _has_gap_in_list_numbers(plan: Sequence[_PlanLine]) -> bool:
    """Whether the list numbers of the steps rise, and either start above 1 or skip a number.

    A single step can have any number, because an agent counts its own turns.
    """
    digits = [re.findall(r"\d+", line.label) for line in plan]
    numbers = [
        int(found[0]) for found in digits if len(found) == 1 and len(found[0]) <= _MAX_LIST_NUMBER_DIGITS
    ]
    rises = len(numbers) == len(plan) and all(one < other for one, other in pairwise(numbers))
    return rises and ((numbers[0] > 1 and len(plan) > 1) or numbers[-1] - numbers[0] >= len(numbers))


def _report_unreadable_line(
    text: str, line: _PlanLine, spans: Sequence[AnswerSpan], reason: str | None = None
) -> Unreadable:
    number = text.count("\n", 0, line.start) + 1
    quoted = line.text if len(line.text) <= _MAX_QUOTED else f"{line.text[: _MAX_QUOTED - 3]}..."
    ending = f" is no step of a plan, and looks like one: {quoted!r}" if reason is None else f": {reason}"
    unread = AnswerSpan(line.start, line.end, AnswerSpanKind.UNREAD)
    return Unreadable(f"line {number}{ending}", spans=tuple(sorted([*spans, unread])))
