"""How protocol `strict` reads subgoals.

An answer is an object with the key ``output``, anywhere in the text: a list of formulas. Texts in the list
that have no formula at all are left out, and actions without objects need no brackets; both are repairs.
"""

from __future__ import annotations

from collections.abc import Collection

from eai.abilities.json_text import Pairs, find_json
from eai.abilities.subgoal_decomposition.written import Unreadable, WrittenSubgoals


def read_subgoals(text: str, without_arguments: Collection[str]) -> WrittenSubgoals | Unreadable:
    """The subgoals in an answer, or why there are none.

    ``without_arguments`` are the actions that take no objects.
    """
    found = find_json(text, _output)
    if found is None:
        return Unreadable('there is no JSON object with "output", a list of strings')
    subgoals: list[str] = []
    output, repairs = found
    made = dict.fromkeys(repairs)
    for subgoal in map(str.strip, output):
        if subgoal in without_arguments:
            made["brackets"] = None
            subgoals.append(f"{subgoal}()")
        elif "(" in subgoal:
            subgoals.append(subgoal)
        elif subgoal:
            made["no_formula"] = None
    return WrittenSubgoals(tuple(subgoals), tuple(made))


def _output(value: object) -> list[str] | None:
    output = dict(value.members).get("output") if isinstance(value, Pairs) else None
    if not isinstance(output, list):
        return None
    texts = [entry for entry in output if isinstance(entry, str)]
    return texts if len(texts) == len(output) else None
