"""Entry points: objects that this package and others register by name. They are imported on request."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from importlib.resources import files
from typing import Any

from eai.errors import InputError

_OURS = "eai."
_CORE = ("eai.abilities", "eai.benchmarks", "eai.commands", "eai.studies")
"""Groups of which the metadata of this package always have entry points."""


def entry_points_of(group: str, first: Sequence[str] = ()) -> Mapping[str, EntryPoint]:
    """Return the entry points of a group by name. A point of this package whose module is absent is left out.

    Args:
        group: the group.
        first: names that come first, in this order. The others follow by name.

    Raises:
        InputError: the metadata of this package are not installed.
    """
    declared = _declared(group)
    return {name: declared[name] for name in names_of(group, first) if is_there(declared[name].module)}


def names_of(group: str, first: Sequence[str] = ()) -> list[str]:
    """Return the names of the entry points of a group, also those whose module is absent.

    Args:
        group: the group.
        first: names that come first, in this order. The others follow by name.
    """
    declared = _declared(group)
    return [name for name in dict.fromkeys((*first, *sorted(declared))) if name in declared]


def _declared(group: str) -> Mapping[str, EntryPoint]:
    points = {point.name: point for point in _installed(tuple(sys.path)).select(group=group)}
    if group in _CORE and not points:
        raise InputError(
            f"no entry points of {group}: eai is not installed, or was installed before they changed: "
            "run `pip install -e .` in its source tree"
        )
    return points


@cache
def _installed(path: tuple[str, ...]) -> Any:
    """Return the entry points of all distributions on `sys.path`. Each has a file of them, read once."""
    return entry_points()


def is_there(module: str) -> bool:
    """Whether a module of this package exists. A module of another distribution is taken to exist.

    That module is not looked for, since this would import its package.
    """
    if not module.startswith(_OURS):
        return True
    place = module.removeprefix(_OURS).replace(".", "/")
    return (files("eai") / f"{place}.py").is_file()
