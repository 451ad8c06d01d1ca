"""Steps of plans in JSON: the forms that answers use, and how to recognize a step outside the list of steps.

Prompts ask for ``{"action": "OPEN", "object": "jar_0"}`` or ``{"OPEN": ["jar_0"]}``, depending on the
benchmark. A step in the other form is read, too, and the verdict notes the repair ``step_form``.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import NamedTuple

from eai.abilities.answer_text import AnswerFormat, JsonObject, contains_json_object, read_json
from eai.abilities.verdict import AnswerSpan, Unreadable

ACTION, OBJECT = "action", "object"
"""Keys of a step in JSON: `ACTION` for its action, and `OBJECT` for the action's objects."""

_OBJECT_KEYS = (OBJECT, "objects", "args", "arguments", "parameters")
_REMARK_KEYS = frozenset(
    (
        "thought",
        "thoughts",
        "reason",
        "reasoning",
        "explanation",
        "description",
        "comment",
        "note",
        "step",
        "id",
    )
)
"""Keys of a step's JSON object that only hold remarks on the step."""

STEP_FORM = "step_form"
"""Name of a repair: reading a step in a form that the benchmark does not ask for."""

LETTER_CASE = "letter_case"
"""Name of a repair: reading an action in small letters, or with only its first letter in capitals."""

_CONNECTIVE = r"\b(?i:first|and|then|next|also|finally|lastly)\b"
_LABEL = rf"(?i:[\s*_>#,;-]|•|step\b|{_CONNECTIVE}|\d+[.)]|\d+\s*:|:)*"
_KEY = r"""["'“‘]\s*action\s*["'”’]\s*:"""
ORDINARY_WORD = re.compile(r"\b(?:the|to|a|an|into|from|with|and|on|in|of|is|it)\b", re.IGNORECASE)
_MAX_WORDS_AFTER_ACTION = 3
"""Maximum number of words after the name of an action. A line with more words is no step."""


_CALL = re.compile(r"(?<![\w-])([\w-]+)\s*\([^()]*\)")
_MAX_WORDS_OUTSIDE_CALLS = 8
"""Maximum number of words outside calls in a line with a step. A line with more words counts as a remark."""


class WrittenStep(NamedTuple):
    """One step of an answer.

    Attributes:
        action: the name of the action, as written.
        objects: for each object of the action, the JSON value that names the object, as written. Messages
            quote these values.
    """

    action: str
    objects: tuple[object, ...]


@dataclass(frozen=True, slots=True)
class WrittenPlan:
    """The steps of an answer, in order.

    Attributes:
        steps: the steps.
        repairs: names of the repairs that were needed to read the steps.
        spans: parts of the answer's text, and how each was treated.
    """

    steps: tuple[WrittenStep, ...]
    repairs: tuple[str, ...] = ()
    spans: tuple[AnswerSpan, ...] = field(default=(), compare=False)


class StepList(NamedTuple):
    """The steps in a JSON value of an answer.

    Attributes:
        steps: the steps, in order.
        repairs: names of the repairs that were needed to read the steps.
        is_single_step: whether the value is a single step, without a list around it.
    """

    steps: tuple[WrittenStep, ...]
    repairs: tuple[str, ...] = ()
    is_single_step: bool = False


def join_step_lists(step_lists: Iterable[StepList]) -> StepList:
    """Return the steps in several JSON values as one list."""
    listed = list(step_lists)
    repairs = dict.fromkeys([repair for part in listed for repair in part.repairs])
    return StepList(tuple([step for part in listed for step in part.steps]), tuple(repairs))


def make_plan_format(
    description: str,
    read: Callable[[object], StepList | None],
    actions: Collection[str],
    wrapper_key: str,
    read_steps_in_text: Callable[[str], StepList | None],
) -> AnswerFormat[StepList]:
    """Return the format of answers that are plans in JSON: a value with steps, or a list of such values.

    Args:
        description: the plan in words; the message about an answer without a plan is "there is no ...".
        read: returns the steps in a value, or None. It is called for each item of a list.
        actions: names of actions in answers; empty if these names are unknown.
        wrapper_key: key under which a JSON object may hold the plan, if questions may ask for such an object.
        read_steps_in_text: returns the steps in a string of the JSON value, or None.
    """

    def read_steps_in_list_item(value: object) -> StepList | None:
        return read_steps_in_text(value) if isinstance(value, str) else read(value)

    names = {action.casefold() for action in actions}
    part, line = _compile_json_step_and_step_line_patterns(frozenset(actions))
    return AnswerFormat(
        description,
        lambda value: (
            join_steps_of_items(value, read_steps_in_list_item)
            if isinstance(value, list)
            else read_steps_in_list_item(value)
        ),
        is_part=lambda text: part.search(text) is not None,
        is_answer_line=lambda text: line is not None and _is_step_line(line, text),
        is_text_with_part=lambda text: (
            line is not None and (text.strip() in actions or _has_step_and_few_other_words(text, line, names))
        ),
        flaw=lambda value: _find_flaw_in_step_list(value, read_steps_in_list_item),
        join=join_step_lists,
        is_piece=lambda steps: steps.is_single_step,
        repairs_of=lambda steps: steps.repairs,
        is_certain=lambda steps: any(not actions or step.action in actions for step in steps.steps),
        wrappers=frozenset((wrapper_key,)),
    )


def join_steps_of_items(
    items: Iterable[object], read: Callable[[object], StepList | None]
) -> StepList | None:
    """Return the steps in several JSON values as one list, or None if some value has no steps."""
    parts = [read(item) for item in items]
    return None if None in parts else join_step_lists([part for part in parts if part is not None])


def read_plan(text: str, form: AnswerFormat[StepList]) -> WrittenPlan | Unreadable:
    """Return the plan in an answer, or the reason why the answer cannot be read."""
    reading = read_json(text, form)
    if isinstance(reading, Unreadable):
        return reading
    return WrittenPlan(reading.value.steps, reading.repairs, reading.spans)


def correct_action_spelling(
    plan: WrittenPlan, declared_actions: Collection[str], to_operator_name: Callable[[str], str] = str
) -> WrittenPlan:
    """Return a plan with the declared names of actions in place of other spellings such as ``open``.

    Args:
        plan: the plan.
        declared_actions: the declared names of actions.
        to_operator_name: returns the name of the operator that a word means.
    """
    if not declared_actions or all(to_operator_name(step.action) in declared_actions for step in plan.steps):
        return plan
    if len({name.casefold() for name in declared_actions}) < len(declared_actions):
        return plan
    declared = {spelling: name for name in declared_actions for spelling in (name.lower(), name.capitalize())}
    steps = tuple([step._replace(action=declared.get(step.action, step.action)) for step in plan.steps])
    repairs = plan.repairs if steps == plan.steps else (*plan.repairs, LETTER_CASE)
    return replace(plan, steps=steps, repairs=repairs)


@lru_cache(64)
def _compile_json_step_and_step_line_patterns(
    actions: frozenset[str],
) -> tuple[re.Pattern[str], re.Pattern[str] | None]:
    if not actions:
        return re.compile(_KEY), None
    names = "|".join(map(re.escape, sorted(actions, key=len, reverse=True)))
    part = rf"""{_KEY}|["'“‘]\s*(?:{names})\s*["'”’]"""
    key = rf"""["'“‘]\s*(?:{names})\s*["'”’]\s*:"""
    member = rf"""(?:[,\[\]{{}}]\s*{key}|{key}\s*[\[({{"'“‘])"""
    line = rf"""(?:{_LABEL})["'“‘`\[({{]*(?P<name>{names})\b(?P<rest>.*)|.*{member}"""
    return re.compile(part), re.compile(line)


def _is_step_line(line_pattern: re.Pattern[str], text: str) -> bool:
    """Whether a line is the name of an action, followed by text that probably names the action's objects."""
    if re.search(_KEY, text):
        return True
    match = line_pattern.match(text)
    if match is None:
        return False
    if match["name"] is None:
        return True
    if re.search(_CONNECTIVE, text[: match.start("name")]):
        return match["rest"].lstrip()[:1] in ("(", "[", "{", "<")
    rest = match["rest"].strip()
    if rest[:1] in tuple("""([{:"'<`"""):
        return True
    return 0 < len(rest.split()) <= _MAX_WORDS_AFTER_ACTION and ORDINARY_WORD.search(rest) is None


def _has_step_and_few_other_words(
    text: str, line_pattern: re.Pattern[str], action_names: Collection[str]
) -> bool:
    """Whether a line has a step, and few words outside calls such as ``walk(soap)``.

    Args:
        text: the line.
        line_pattern: the pattern of lines that begin with a step.
        action_names: names of actions in small letters. Letter case does not matter in calls.
    """
    words = _CALL.sub(" ", text).split()
    if len(words) > _MAX_WORDS_OUTSIDE_CALLS:
        return False
    return any(call[1].casefold() in action_names for call in _CALL.finditer(text)) or any(
        _is_step_line(line_pattern, " ".join(words[begin : begin + 1 + _MAX_WORDS_AFTER_ACTION]))
        for begin in range(len(words))
    )


def read_step_from_action_and_object_keys(value: JsonObject) -> StepList | None:
    """Return the only step in a JSON object with keys for action and objects; None for other values.

    Two objects of an action are separated by a comma or stand in a list. An empty text stands for no object.
    """
    members = value.members
    repairs: tuple[str, ...] = ()
    if len(members) == 2 and members[0][0] == ACTION and members[1][0] == OBJECT:
        action, objects = members[0][1], members[1][1]  # a step in the form that prompts ask for
    else:
        by_key = dict(members)
        keys = [key for key in _OBJECT_KEYS if key in by_key]
        if len(keys) != 1 or len(by_key) != len(members) or find_unknown_keys(value):
            return None
        action, objects = by_key.get(ACTION), by_key[keys[0]]
        repairs = () if keys == [OBJECT] else (STEP_FORM,)
    if not isinstance(action, str):
        return None
    if isinstance(objects, str):
        names = (
            strip_blanks_around_names(objects.split(","))
            if "," in objects
            else (name,)
            if (name := objects.strip())
            else ()
        )
        return StepList((WrittenStep(action, names),), repairs, is_single_step=True)
    if not isinstance(objects, list):
        return None
    return StepList(
        (WrittenStep(action, strip_blanks_around_names(map(str, objects))),), repairs, is_single_step=True
    )


def find_unknown_keys(step: JsonObject) -> list[str]:
    """Return those keys of a JSON object that belong neither to a step nor to remarks on the step."""
    return [
        key
        for key, value in step.members
        if key not in (ACTION, *_OBJECT_KEYS)
        and (key.lower() not in _REMARK_KEYS or contains_json_object(value))
    ]


def read_steps_keyed_by_action(value: JsonObject, actions: Collection[str]) -> StepList | None:
    """Return the steps of a JSON object whose keys are actions, or None if a member is not a step.

    The value of each key is a list of objects. A text of names with commas is accepted, too, and noted as the
    repair ``step_form``.

    Args:
        value: the JSON object.
        actions: names of the actions whose objects may be a text with commas.
    """
    steps: list[WrittenStep] = []
    repairs: tuple[str, ...] = ()
    for action, objects in value.members:
        if isinstance(objects, list) and not any(isinstance(item, JsonObject) for item in objects):
            steps.append(WrittenStep(action, tuple(objects)))
        elif isinstance(objects, str) and action in actions:
            steps.append(
                WrittenStep(action, strip_blanks_around_names(objects.split(",")) if objects.strip() else ())
            )
            repairs = (STEP_FORM,)
        else:
            return None
    return StepList(tuple(steps), repairs, is_single_step=len(steps) == 1)


def strip_blanks_around_names(words: Iterable[str]) -> tuple[str, ...]:
    """Return names without blanks before and after each name."""
    return tuple(map(str.strip, words))


def _find_flaw_in_step_list(value: object, read_steps: Callable[[object], StepList | None]) -> str | None:
    """Return in words what is wrong with the first item that is not a step, or None if all are steps."""
    if isinstance(value, JsonObject):
        lists = [member for _, member in value.members if isinstance(member, list | JsonObject)]
        if len(lists) == 1 and not read_steps(value):
            return _find_flaw_in_step_list(lists[0], read_steps)
        return _describe_item_flaw(value, "the step")
    if not isinstance(value, list) or not value:
        return None
    number, item = next(
        ((number, item) for number, item in enumerate(value, 1) if read_steps(item) is None), (0, None)
    )
    return _describe_item_flaw(item, f"step {number}") if number else None


def _describe_item_flaw(item: object, item_name: str) -> str:
    members = dict(item.members) if isinstance(item, JsonObject) else {}
    missing = [key for key in (ACTION, OBJECT) if key not in members]
    if missing:
        return f'{item_name} has no "{missing[0]}"'
    unknown = find_unknown_keys(item) if isinstance(item, JsonObject) else []
    return f'{item_name} has the unknown key "{unknown[0]}"' if unknown else f"{item_name} has another form"
