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
_ALWAYS_INSTALLED = "eai.abilities"
"""A group that is in the metadata of every installed copy of this package."""


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
    return {point.name: point for point in _installed(tuple(sys.path)).select(group=group)}


@cache
def _installed(path: tuple[str, ...]) -> Any:
    """Return the entry points of all distributions on `sys.path`. Each has a file of them, read once."""
    points = entry_points()
    if _ALWAYS_INSTALLED not in points.groups:
        raise InputError(
            "eai is not installed, or was installed before its entry points changed: "
            "run `pip install -e .` in its source tree"
        )
    return points


def is_there(module: str) -> bool:
    """Whether a module of this package exists. A module of another distribution is taken to exist.

    That module is not looked for, since this would import its package.
    """
    if not module.startswith(_OURS):
        return True
    place = module.removeprefix(_OURS).replace(".", "/")
    return (files("eai") / f"{place}.py").is_file()
