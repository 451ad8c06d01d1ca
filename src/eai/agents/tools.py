"""Tools by which an agent acts, for all who offer them: made from the declaration of a domain."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from eai.agents.command import DONE, LOOK
from eai.base.errors import InputError
from eai.world.domain import Domain

ACT, READ, END = "act", "look", "done"
"""The names of the tools."""


def tools_of(domain: Domain) -> tuple[tuple[str, str, Mapping[str, Any]], ...]:
    """The tools by which an agent acts in a domain: name, meaning, and JSON schema of the arguments.

    Actions are no enumeration: one that there is not is an error that the world diagnoses, not one of the
    call.
    """
    signatures = [f"{each.name}({', '.join([p.name for p in each.parameters])})" for each in domain.operators]
    names = "Names of objects, in the order of the action's parameters."
    action = {
        "action": {"type": "string", "description": f"One of {'; '.join(signatures)}."},
        "objects": {"type": "array", "items": {"type": "string"}, "description": names},
    }
    return (
        (ACT, "Take one action and read what became of it.", _object(action)),
        (READ, "Read again what you see. This costs nothing, once between two actions.", _object({})),
        (END, "Say that the task is done. Nothing can be done after it.", _object({})),
    )


def _object(properties: Mapping[str, object]) -> dict[str, Any]:
    return {"type": "object", "properties": {**properties}, "required": [*properties]}


def command_of(name: str, arguments: Mapping[str, object]) -> str:
    """The command that a call of a tool is.

    Raises:
        InputError: there is no such tool, or its arguments are others.
    """
    if name in (READ, END):
        return LOOK if name == READ else DONE
    if name != ACT:
        raise InputError(f"there is no tool {name[:100]!r}: {ACT}, {READ}, {END}")
    match arguments:
        case {"action": str(action), "objects": [*objects]} if all(isinstance(each, str) for each in objects):
            return f"{action}({', '.join(map(str, objects))})"
    raise InputError("the arguments: expected action, a name, and objects, a list of names")
