"""Which response file answers a suite, for ``eai/replay``: never one that is another suite's."""

from __future__ import annotations

from pathlib import Path

from eai.abilities.protocol import Ability
from eai.abilities.responses import SUFFIX, find_response_files, model_name
from eai.benchmarks.registry import registered
from eai.errors import InputError

_ABILITIES = frozenset(ability.value for ability in Ability)


def recorded_file(path: Path, domain: str, ability: Ability) -> Path:
    """The file with the answers to a suite.

    A folder has one for each suite, ``<domain>/<ability>/..._outputs.json`` somewhere below it or, as the
    challenge has them, ``<domain>_<ability>_outputs.json``. A file is taken as it is, unless its place or
    name says that it is of another suite.

    Raises:
        InputError: there is no such file, or more than one.
    """
    if not path.is_dir():
        find_response_files(path)
        named = _suite_of(path)
        if named is not None and _is_another(named, domain, ability):
            raise InputError(
                f"{path}: expected answers to {domain} {ability.value}, not to {' '.join(named)}"
            )
        return path
    found = [file for file in find_response_files(path) if _suite_of(file) == (domain, ability.value)]
    if len(found) != 1:
        place = path / domain / ability.value / f"<model>{SUFFIX}"
        raise InputError(f"{path}: expected one file {place}, found {len(found) or 'none'}")
    return found[0]


def _suite_of(file: Path) -> tuple[str, str] | None:
    """The domain and ability that a file names by its folders or its name."""
    for ability in _ABILITIES:
        domain = model_name(file).removesuffix(f"_{ability}")
        if domain != model_name(file):
            return domain, ability
    folders = file.absolute().parent.parts
    places = [i for i, name in enumerate(folders) if name in _ABILITIES and i]
    return (folders[places[-1] - 1], folders[places[-1]]) if places else None


def _is_another(named: tuple[str, str], domain: str, ability: Ability) -> bool:
    """Whether a file that names a suite names another; a folder that is no benchmark's name says nothing."""
    return named[1] != ability.value or (named[0] in registered() and named[0] != domain)
