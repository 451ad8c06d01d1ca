"""Which response files answer a suite: never one that is another suite's by its place or name.

A file names its suite by folders, ``<domain>/<ability>/..._outputs.json``, or, as the challenge has it, by
``<domain>_<ability>_outputs.json``. Many files name none.
"""

from __future__ import annotations

import os
import tempfile
import zipfile
import zlib
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING

from eai.abilities.protocol import Ability, place_of, registered_abilities
from eai.base.errors import EaiError, InputError
from eai.base.files import MAX_UNPACKED, UNPACKED_PER_BYTE, read_toml
from eai.benchmarks.registry import find_benchmark, registered
from eai.results.responses import ENDINGS, SUFFIX, attempt_name, find_response_files, model_name

if TYPE_CHECKING:
    from eai.benchmarks.benchmark import Benchmark

_RUN, _ABOVE = "run*.toml", 4
"""How the files are called that say what runs were of, and how many folders above records they may be."""

ZIP = ".zip"
"""How the names of zips end."""

UNREADABLE = (OSError, EOFError, zipfile.BadZipFile, zlib.error, RuntimeError, ValueError)
"""The errors raised where a zip or a member is damaged, encrypted, or packed in an unknown way."""


@dataclass(frozen=True, slots=True)
class _SuiteFile:
    """A response file that names its suite.

    Attributes:
        model: the file's name, or that of its folder where the file is named after the suite.
    """

    path: Path
    domain: str
    ability: Ability
    model: str

    @property
    def order(self) -> tuple[int, int, str]:
        """The key by which files are sorted."""
        return (*registered(), self.domain).index(self.domain), place_of(self.ability), self.model


def benchmarks_of_runs(paths: Iterable[Path]) -> Mapping[str, Benchmark]:
    """The benchmarks that are not registered of the runs at some paths, by name, as far as they still open.

    A run says in its ``run.toml`` by what its benchmarks were found.
    """
    found: dict[str, Benchmark] = {}
    for path in map(Path.absolute, paths):
        beside = (file for folder in (path, *path.parents[:_ABOVE]) for file in folder.glob(_RUN))
        for file in dict.fromkeys((*path.glob(f"*/{_RUN}"), *beside)):
            try:
                references = read_toml(file).get("tasks", {}).get("domain", ())
                opened = [find_benchmark(each) for each in references if each not in registered()]
            except EaiError:
                continue
            found |= {benchmark.name: benchmark for benchmark in opened}
    return found


def suite_files(path: Path, own: Collection[str] = ()) -> list[_SuiteFile]:
    """The response file at a path, or all below a folder, in order; each names its suite.

    Args:
        path: the file or folder.
        own: the names of benchmarks that are known besides those that are registered.

    Raises:
        InputError: there is none, or one does not say what it answers.
    """
    found = []
    for file in find_response_files(path):
        suite = _suite_of(file)
        if suite is None:
            named = f"<domain>/<ability>/<model>{SUFFIX} or <domain>_<ability>{SUFFIX}"
            raise InputError(f"{file}: give --domain and --ability; its place does not say them ({named})")
        domain, ability = suite
        if domain not in (*registered(), *own):
            raise InputError(f"{file}: {domain} is no registered benchmark; give --domain")
        model = model_name(file)
        if model == f"{domain}_{ability}":
            model = file.absolute().parent.name
        found.append(_SuiteFile(file, domain, Ability(ability), model))
    return sorted(found, key=lambda each: each.order)


@contextmanager
def unpacked(path: Path, also: Collection[str] = ()) -> Iterator[Path]:
    """The path, or, of a zip, a folder of its name with its response files, for as long as the block lasts.

    An InputError that the block raises calls a file of this folder ``ZIP: MEMBER``.

    Args:
        path: the path.
        also: names of other files that are wanted of a zip.

    Raises:
        InputError: the zip or a response file in it cannot be read, or they hold too much.
    """
    if path.suffix.lower() != ZIP or not path.is_file():
        yield path
        return
    with tempfile.TemporaryDirectory(prefix="eai-answers-") as place:
        folder = Path(place) / path.stem
        name = str(path)
        try:
            with zipfile.ZipFile(path) as archive:
                members = [info for info in members_of(archive) if _is_wanted(info, also)]
                limit = MAX_UNPACKED + UNPACKED_PER_BYTE * path.stat().st_size
                if sum(info.file_size for info in members) > limit:  # no more of a member is ever read
                    raise InputError(f"{path}: expected at most {limit:,} bytes of answers in it")
                for info in members:
                    name = f"{path}: {info.filename}"
                    if (folder / info.filename).exists():
                        raise InputError(f"{name}: stands there twice")
                    archive.extract(info, folder)
        except UNREADABLE as error:
            raise InputError(f"{name}: expected a zip that can be read ({error})") from error
        folder.mkdir(exist_ok=True)
        try:
            yield folder
        except InputError as error:
            text = str(error).replace(f"{folder}{os.sep}", f"{path}: ").replace(str(folder), str(path))
            raise InputError(text) from error


def members_of(archive: zipfile.ZipFile) -> list[zipfile.ZipInfo]:
    """Return the members of a zip, whose names have slashes even if Windows wrote backslashes."""
    members = archive.infolist()
    for info in members:
        info.filename = info.filename.replace("\\", "/")
    return members


def _is_wanted(info: zipfile.ZipInfo, also: Collection[str]) -> bool:
    """Whether a member is a response file; what systems add to zips, such as ``__MACOSX/._...``, is none."""
    name = PurePosixPath(info.filename).name
    is_answers = name.endswith(ENDINGS) and not name.startswith(".")
    return (is_answers or name in also) and not info.is_dir()


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


def recorded_file(path: Path, domain: str, ability: Ability, attempt: int = 1) -> Path:
    """The one file with the answers to a suite; in a folder, which may hold many, it has to name the suite.

    Those of one attempt in an experiment are in a file of their own, beside that of the first. A file that is
    not of an attempt has the first answers.

    Raises:
        InputError: there is no such file, or more than one.
    """
    if not path.is_dir():
        first = files_of_suite(path, domain, ability)[0]
        name = model_name(first).removesuffix(attempt_name("", 1))
        return first if attempt == 1 else first.with_name(f"{attempt_name(name, attempt)}{SUFFIX}")
    files: list[Path] = []
    if attempt == 1:
        with suppress(InputError):  # there may be those of single attempts alone
            files = find_response_files(path)
    files = files or sorted(path.rglob(f"*{attempt_name('', attempt)}{SUFFIX}"))
    found = [file for file in files if _suite_of(file) == (domain, ability.value)]
    if len(found) != 1:
        name = "<model>" if attempt == 1 else attempt_name("<model>", attempt)
        place = path / domain / ability.value / f"{name}{SUFFIX}"
        raise InputError(f"{path}: expected one file {place}, found {len(found) or 'none'}")
    return found[0]


def _suite_of(file: Path) -> tuple[str, str] | None:
    """The domain and ability that a file names by its folders or its name."""
    for ability in registered_abilities():
        domain = model_name(file).removesuffix(f"_{ability}")
        if domain != model_name(file):
            return domain, ability.value
    folders = file.absolute().parent.parts
    places = [i for i, name in enumerate(folders) if name in registered_abilities() and i]
    return (folders[places[-1] - 1], folders[places[-1]]) if places else None


def _other_suite(file: Path, domain: str, ability: Ability) -> tuple[str, str] | None:
    """The suite that a file names, if it is another; a folder that is no benchmark's name says nothing."""
    named = _suite_of(file)
    if named is None or (named[1] == ability.value and (named[0] == domain or named[0] not in registered())):
        return None
    return named
