"""Entry points: objects that this package and others register by name. They are imported on request.

The entry-point files are parsed here, because `importlib.metadata` would make `eai --help` 10 % slower.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping, Sequence
from functools import cache, reduce
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

from eai.base.errors import InputError

_OURS = "eai."
_PACKAGE = Path(__file__).parents[1]
_CORE_GROUPS = ("eai.abilities", "eai.benchmarks", "eai.commands", "eai.studies")
"""Groups of entry points that eai itself registers. If a group is empty, eai's metadata are missing."""


class EntryPoint(NamedTuple):
    """An object of a module, and the name under which it is registered in a group."""

    name: str
    value: str
    group: str

    @property
    def module(self) -> str:
        """Name of the Python module that defines the object of this entry point."""
        return self.value.partition(":")[0].strip()

    @property
    def attr(self) -> str:
        """Name of the registered object in its module."""
        return self.value.partition(":")[2].partition("[")[0].strip()

    def load(self) -> Any:
        """Import the module of the entry point, and return the registered object.

        Raises:
            InputError: the module calls ``sys.exit()``.
        """
        try:
            module = import_module(self.module)
        except SystemExit as error:
            origin = f"{self.module} (entry point {self.name} of {self.group})"
            raise InputError(f"{origin}: {describe_exit(error)}") from error
        return reduce(getattr, filter(None, self.attr.split(".")), module)


def describe_exit(error: SystemExit) -> str:
    """Return a message about a module that ends Python while it is imported."""
    return f"the import calls sys.exit({error.code!r}); only a program may do so"


def get_entry_points(group: str, first: Sequence[str] = ()) -> Mapping[str, EntryPoint]:
    """Return a mapping from the names of a group's entry points to the entry points.

    Outdated metadata may name a module of eai that no longer exists. Such an entry point is left out.

    Args:
        group: the group.
        first: names that come first, in this order. All other names follow in alphabetical order.

    Raises:
        InputError: the metadata of this package are not installed.
    """
    points = _read_entry_points_of_group(group)
    return {
        name: points[name] for name in get_entry_point_names(group, first) if has_module(points[name].module)
    }


def load_from_extension(name: str, needed_by: str) -> Any:
    """Import an object that an extension (a package in `eai.extensions`) registers for use outside of it.

    Args:
        name: name of the object's entry point in the group ``eai.offers``.
        needed_by: the user's option or value that needs the object. The error message begins with this text.

    Raises:
        InputError: no installed extension offers the object.
    """
    points = get_entry_points("eai.offers")
    if name not in points:
        raise InputError(f"{needed_by}: {name!r} is not installed; reinstall eai, which contains it")
    return points[name].load()


def get_entry_point_names(group: str, first: Sequence[str] = ()) -> list[str]:
    """Return the names of a group's entry points, even if the modules that they point to are absent.

    Args:
        group: the group.
        first: names that come first, in this order. All other names follow in alphabetical order.
    """
    points = _read_entry_points_of_group(group)
    return [name for name in dict.fromkeys((*first, *sorted(points))) if name in points]


def _read_entry_points_of_group(group: str) -> Mapping[str, EntryPoint]:
    points = {point.name: point for point in _read_all_entry_points(tuple(sys.path)) if point.group == group}
    if group in _CORE_GROUPS and not points:
        raise InputError(
            f"no entry points of {group}: eai is not installed, or its installed metadata are outdated: "
            "run `pip install -e .` in its source tree"
        )
    return points


@cache
def _read_all_entry_points(sys_path: tuple[str, ...]) -> Sequence[EntryPoint]:
    """Read the entry points of all distributions on `sys.path`.

    If two folders of `sys.path` have an entry point of the same name, the first folder counts. Folders are
    therefore read from last to first: entry points of earlier folders replace those of later folders.
    """
    files = [file for folder in reversed(sys_path) for file in Path(folder).glob("*.*-info/entry_points.txt")]
    return [point for file in files for point in _read_entry_points_file(file)]


def _read_entry_points_file(file: Path) -> Iterator[EntryPoint]:
    group = ""
    for line in map(str.strip, file.read_text(encoding="utf-8").splitlines()):
        if line.startswith("["):
            group = line.strip("[]")
        elif line and not line.startswith(("#", ";")):
            name, _, value = line.partition("=")
            yield EntryPoint(name.strip(), value.strip(), group)


def has_module(module: str) -> bool:
    """Whether a module of this package is installed. Return True for every module of another package.

    To search another package for a module, Python would import that package.
    """
    if not module.startswith(_OURS):
        return True
    path = module.removeprefix(_OURS).replace(".", "/")
    return (_PACKAGE / f"{path}.py").is_file()
