"""What the help of a command says of its parameters: a short name for each value, and no type of Python's."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

HELP_OPTIONS = ("-h", "--help")

METAVARS: Mapping[str, str] = {
    f"--{option}": metavar
    for metavar, options in {
        "NAME": "ability domain errata like metric model planner prompt-name protocol reference split",
        "N": "bins conditions depth epochs examples limit max-connections max-tokens n objects"
        " sample seed workers",
        "P": "least",
        "S": "planner-seconds",
        "X": "margin",
        "DIR": "data images out prompts",
        "FILE": "explorer prices",
        "PATH": "demonstrations from goals",
        "ID,ID": "tasks",
        "SECRET": "secret",
        "URL": "model-base-url",
    }.items()
    for option in options.split()
}
"""What the value of an option is called where the option does not say it itself."""


def label(command: Any) -> None:
    """Have the help of a command name values by their metavars alone, and fill its paragraphs.

    Typer would say of each value what Python reads it as, and break lines where the docstring does.
    """
    command.help = "\n\n".join(" ".join(part.split()) for part in (command.help or "").split("\n\n"))
    for parameter in command.get_params(command.context_class(command, help_option_names=[*HELP_OPTIONS])):
        if parameter.param_type_name == "argument":
            parameter.metavar = parameter.metavar or parameter.name.upper()
            parameter.display_type_rich = _nothing
        elif parameter.metavar is None:
            name = max(parameter.opts, key=len)
            parameter.metavar = METAVARS.get(name, "" if parameter.is_flag else None)
        if "--protocol" in parameter.opts:
            from eai.abilities.protocol import registered_protocols

            parameter.help = f"{parameter.help} Here: {', '.join(('strict', *registered_protocols()))}."


def _nothing(ctx: Any) -> str:
    return ""
