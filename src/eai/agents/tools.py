"""Make an agent's tools from the declaration of a domain, and read calls of these tools."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from eai.agents.command import DONE, LOOK
from eai.base.errors import InputError
from eai.world.domain import Domain

ACT, READ, END = "act", "look", "done"
"""Names of the tools that act, read the observation, and end the episode."""


def list_tool_names_texts_and_schemas(domain: Domain) -> tuple[tuple[str, str, Mapping[str, Any]], ...]:
    """Return the tools of an agent in a domain: name, description, and JSON schema of the arguments.

    The schema does not enumerate actions. A call with an unknown action is therefore valid, and
    the world reports the action as an error of the agent.
    """
    signatures = [f"{each.name}({', '.join([p.name for p in each.parameters])})" for each in domain.operators]
    names = "Names of objects, in the order of the action's parameters."
    action = {
        "action": {"type": "string", "description": f"One of {'; '.join(signatures)}."},
        "objects": {"type": "array", "items": {"type": "string"}, "description": names},
    }
    return (
        (ACT, "Take one action and read what became of it.", _make_object_schema(action)),
        (
            READ,
            "Read again what you see. This costs nothing, once between two actions.",
            _make_object_schema({}),
        ),
        (END, "Say that the task is done. Nothing can be done after it.", _make_object_schema({})),
    )


def _make_object_schema(properties: Mapping[str, object]) -> dict[str, Any]:
    return {"type": "object", "properties": {**properties}, "required": [*properties]}


def convert_tool_call_to_command(tool_name: str, arguments: Mapping[str, object]) -> str:
    """Return a tool call as the text of a command, such as ``LOOK``.

    Raises:
        InputError: the tool does not exist, or its arguments are invalid.
    """
    if tool_name in (READ, END):
        return LOOK if tool_name == READ else DONE
    if tool_name != ACT:
        raise InputError(f"there is no tool {tool_name[:100]!r}; call {ACT}, {READ} or {END}")
    match arguments:
        case {"action": str(action), "objects": [*objects]} if all(isinstance(each, str) for each in objects):
            return f"{action}({', '.join(map(str, objects))})"
    raise InputError("arguments: expected `action`, the name of an action, and `objects`, a list of names")
