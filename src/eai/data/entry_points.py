"""Entry points: what this package and other distributions add by name, loaded where it is asked for."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from importlib.resources import files
from typing import Any

_OURS = "eai."


def entry_points_of(group: str, built_in: Mapping[str, str] | None = None) -> Mapping[str, EntryPoint]:
    """The entry points of a group by name. One of this package whose module is not there is left out.

    Args:
        group: the group.
        built_in: those of this package, ``module:object`` by name, which a source tree has whether or not it
            was installed since they were declared.
    """
    declared = [EntryPoint(name, value, group) for name, value in (built_in or {}).items()]
    found = _installed(tuple(sys.path)).select(group=group)
    return {point.name: point for point in (*declared, *found) if is_there(point.module)}


@cache
def _installed(path: tuple[str, ...]) -> Any:
    """Those of all distributions on a path, `sys.path`: each has a file of them, which is read once."""
    return entry_points()


def is_there(module: str) -> bool:
    """Whether a module of this package is there; one of another distribution is taken to be.

    That one is not looked for, as this would import its package.
    """
    if not module.startswith(_OURS):
        return True
    place = module.removeprefix(_OURS).replace(".", "/")
    return (files("eai") / f"{place}.py").is_file()
