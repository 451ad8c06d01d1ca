"""Which response files answer a suite: never one that is another suite's by its place or name.

A file names its suite by folders, ``<domain>/<ability>/..._outputs.json``, or, as the challenge has it, by
``<domain>_<ability>_outputs.json``. Many files name none.
"""

from __future__ import annotations

from pathlib import Path

from eai.abilities.protocol import Ability
from eai.abilities.responses import SUFFIX, find_response_files, model_name
from eai.benchmarks.registry import registered
from eai.errors import InputError

_ABILITIES = frozenset(ability.value for ability in Ability)


def files_of_suite(path: Path, domain: str, ability: Ability) -> list[Path]:
    """A response file, or those below a folder, but for the folder's files of other suites.

    Raises:
        InputError: there is none, or all are of other suites.
    """
    found = find_response_files(path)
    others = {file: suite for file in found if (suite := _other_suite(file, domain, ability)) is not None}
    if len(others) == len(found):
        named = " ".join(others[found[0]])
        raise InputError(f"{found[0]}: expected answers to {domain} {ability.value}, not to {named}")
    return [file for file in found if file not in others]


def recorded_file(path: Path, domain: str, ability: Ability) -> Path:
    """The one file with the answers to a suite; in a folder, which may hold many, it has to name the suite.

    Raises:
        InputError: there is no such file, or more than one.
    """
    if not path.is_dir():
        return files_of_suite(path, domain, ability)[0]
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


def _other_suite(file: Path, domain: str, ability: Ability) -> tuple[str, str] | None:
    """The suite that a file names, if it is another; a folder that is no benchmark's name says nothing."""
    named = _suite_of(file)
    if named is None or (named[1] == ability.value and (named[0] == domain or named[0] not in registered())):
        return None
    return named
