"""How eai-eval 1.0.5 reads the goals of a BEHAVIOR task (``evaluate_results.py`` parse_json).

Its quirks: the whole answer is put in lower case, apostrophes become quotation marks, and what counts is what
stands between the first opening brace and the next brace; names of sections do not matter. An answer that
cannot be read predicts nothing. Values of an unexpected type abort the whole run.
"""

from __future__ import annotations

import json
import re

from eai.abilities.goal_interpretation.behavior_conditions import Unreadable, Value, Written, see

_OBJECT = re.compile(r"{[^{}]*}")


def read_conditions(text: str) -> Written | Unreadable:
    """The conditions that the reference finds in an answer."""
    match = _OBJECT.search(text.lower().replace("'", '"').replace("toggledon", "toggled_on"))
    if match is None:
        return Unreadable("there is no object in braces")
    try:
        sections = json.loads(match[0])
    except (ValueError, RecursionError) as error:
        return Unreadable(f"the object in braces is not JSON: {error}")
    conditions: list[Value] = []
    for section in sections.values():
        if not isinstance(section, list | str):
            return Unreadable("a section is not a list", aborts=True)
        conditions += map(_frozen, section)
    if any(see(condition) is None for condition in conditions):
        return Unreadable("a condition is empty, or not a list", aborts=True)
    return Written(tuple(conditions))


def _frozen(value: object) -> Value:
    return tuple(map(_frozen, value)) if isinstance(value, list) else value
