"""Cutting operators out of an answer exactly as eai-eval 1.0.5 does (protocol ``eai-1.0.5``).

Reproduced are the first lines of ``worker_process`` in ``transition_modeling/scripts/evaluate_results.py``
and ``extract_action_details`` in ``simulation/evolving_graph/eval_utils.py``, both of ``virtualhome_eval``.
The quirks, in the order in which they act: a code fence counts only at the very start; line ends are
deleted before JSON is read, so that a comment outside JSON swallows the rest; single quotes become double
ones; JSON that does not load is searched as it is; the three parts of an operator are looked for
independently and may belong to a later one; an operator without one of them ends the search; the name ends
at the first character that is not a word character; an unbalanced condition or effect becomes the
unreadable text ``(()``; of two operators of one name the last wins.
"""

from __future__ import annotations

import json
import re

from eai.pddl.operator_text import OperatorText

_COMMENT = re.compile(r";.*$", re.MULTILINE)
_HEAD = re.compile(r"\(:action\s+(\w+)")
_FENCE = "```json"
_UNBALANCED = "(()"
_UNBALANCED_CLOSE = 1  # Where the first closing parenthesis of an unbalanced effect is taken to be.


def extract_as_reference(answer: str) -> tuple[OperatorText, ...] | None:
    """The operators of an answer in order of first mention, or None for the reference's format error.

    An answer without any operator is no format error but an empty result.
    """
    content = _payload(answer)
    if content is None:
        return None
    if ";" in content:
        content = _COMMENT.sub("", content)
    content = " ".join(content.split())
    found: dict[str, OperatorText] = {}
    position = 0
    while head := _HEAD.search(content, position):
        places = [content.find(key, head.end()) for key in (":parameters", ":precondition", ":effect")]
        if -1 in places:
            break
        parameters, precondition, effect = (_block(content, place) for place in places)
        if parameters is None:
            return None
        name = head.group(1)
        found[name] = OperatorText(name, parameters, precondition or _UNBALANCED, effect or _UNBALANCED)
        closing = _UNBALANCED_CLOSE if effect is None else effect.index(")") - 1
        position = places[2] + closing + 1
    return tuple(found.values())


def _payload(answer: str) -> str | None:
    """The text to search, or None if the answer is JSON that holds no text."""
    if answer.startswith(_FENCE):
        answer = answer[len(_FENCE) :].strip("`")
    text = answer.strip().replace("\n", "").replace("'", '"')
    try:
        value = json.loads(text)
    except (ValueError, RecursionError):
        return text
    if isinstance(value, dict) and "output" in value:
        value = value["output"]
    return value if isinstance(value, str) else None


def _block(content: str, place: int) -> str | None:
    """The balanced list that opens behind a place, or None if it does not close.

    Without any opening parenthesis the reference starts at the first character of the whole text; the
    character behind the opening parenthesis is not counted as a parenthesis unless it closes at once.
    """
    start = content.find("(", place) + 1
    if content.startswith(")", start):
        return "()"
    depth, position = 1, start + 1
    while (closing := content.find(")", position)) >= 0:
        depth += content.count("(", position, closing) - 1
        position = closing + 1
        if not depth:
            return "(" + content[start:position]
    return None
