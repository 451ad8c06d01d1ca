"""Find the response files of a suite: files with a model's answers to the suite's tasks.

A suite is a domain with an ability, a kind of question. A file names its suite by its folders,
``<domain>/<ability>/..._outputs.json``, or by its own name, ``<domain>_<ability>_outputs.json`` (as in the
paper's public challenge). Many files name no suite. A file that names another suite is left out or refused.
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

from eai.abilities.protocol import Ability, find_ability_entry_points, get_ability_sort_key
from eai.base.errors import EaiError, InputError
from eai.base.files import MAX_UNPACKED, UNPACKED_PER_BYTE, read_toml
from eai.benchmarks.registry import find_benchmark, list_benchmarks
from eai.results.responses import ENDINGS, SUFFIX, find_response_files, format_attempt_name, read_model_name

if TYPE_CHECKING:
    from eai.benchmarks.benchmark import Benchmark

_RUN_FILES, _MAX_FOLDERS_ABOVE = "run*.toml", 4
"""File names of run specifications; number of parent folders of records in which they are sought."""

ZIP = ".zip"
"""File extension of zip archives."""

UNREADABLE = (OSError, EOFError, zipfile.BadZipFile, zlib.error, RuntimeError, ValueError)
"""Exceptions that reading a zip raises if the zip or a member is damaged, encrypted or packed unusually."""


@dataclass(frozen=True, slots=True)
class _ResponseFileOfSuite:
    """A response file that names its suite, the benchmark and the ability that its answers are for.

    Attributes:
        model: name of the model: the file's name, or its folder's name if the file is named after the suite.
    """

    path: Path
    domain: str
    ability: Ability
    model: str

    @property
    def sort_key(self) -> tuple[int, int, str]:
        """Key for sorting files by domain, ability and model."""
        return (
            (*list_benchmarks(), self.domain).index(self.domain),
            get_ability_sort_key(self.ability),
            self.model,
        )


def find_benchmarks_of_runs(paths: Iterable[Path]) -> Mapping[str, Benchmark]:
    """Return a mapping from names to unregistered benchmarks that the runs at some paths use.

    The ``run.toml`` of a run states where its benchmarks are. A benchmark that can no longer be opened is
    left out.
    """
    benchmarks: dict[str, Benchmark] = {}
    for path in map(Path.absolute, paths):
        files_beside = (
            file for folder in (path, *path.parents[:_MAX_FOLDERS_ABOVE]) for file in folder.glob(_RUN_FILES)
        )
        for file in dict.fromkeys((*path.glob(f"*/{_RUN_FILES}"), *files_beside)):
            try:
                opened = [
                    find_benchmark(reference)
                    for reference in _read_benchmark_references(file)
                    if reference not in list_benchmarks()
                ]
            except EaiError:
                continue
            benchmarks |= {benchmark.name: benchmark for benchmark in opened}
    return benchmarks


def _read_benchmark_references(file: Path) -> list[str]:
    """Return the references in a run specification; none from a TOML file of another program."""
    tasks = read_toml(file).get("tasks")
    references = tasks.get("domain") if isinstance(tasks, dict) else None
    listed = references if isinstance(references, list) else [references]
    return [reference for reference in listed if isinstance(reference, str)]


def find_suite_files(path: Path, unregistered_benchmarks: Collection[str] = ()) -> list[_ResponseFileOfSuite]:
    """Return the response file at a path, or all below a folder, sorted; each must name its suite.

    A suite is an ability in a benchmark.

    Args:
        path: the file or folder.
        unregistered_benchmarks: names of further benchmarks that files may name.

    Raises:
        InputError: there is no response file, or one does not name its suite.
    """
    files = []
    for file in find_response_files(path):
        suite = read_domain_and_ability_from_path(file)
        if suite is None:
            expected_names = f"<domain>/<ability>/<model>{SUFFIX} or <domain>_<ability>{SUFFIX}"
            raise InputError(
                f"{file}: give --domain and --ability; its path does not name them ({expected_names})"
            )
        domain, ability = suite
        if domain not in (*list_benchmarks(), *unregistered_benchmarks):
            raise InputError(f"{file}: {domain} is not a registered benchmark; give --domain")
        model = read_model_name(file)
        if model == f"{domain}_{ability}":
            model = file.absolute().parent.name
        files.append(_ResponseFileOfSuite(file, domain, Ability(ability), model))
    return sorted(files, key=lambda suite_file: suite_file.sort_key)


@contextmanager
def unpack_answers_if_zipped(
    path: Path, names_of_other_files_to_unpack: Collection[str] = ()
) -> Iterator[Path]:
    """Yield a path, or a temporary folder with the response files of the zip at this path.

    The folder has the zip's name and exists until the block ends. An InputError that the block raises names a
    file of this folder as ``ZIP: MEMBER``.

    Args:
        path: the path of a file, a folder or a zip.
        names_of_other_files_to_unpack: names of further files to unpack, besides response files.

    Raises:
        InputError: the zip or a response file in it cannot be read, or its files unpack to too many bytes.
    """
    if path.suffix.lower() != ZIP or not path.is_file():
        yield path
        return
    with tempfile.TemporaryDirectory(prefix="eai-answers-") as temporary:
        folder = Path(temporary) / path.stem
        name = str(path)
        try:
            with zipfile.ZipFile(path) as archive:
                members = [
                    info
                    for info in list_zip_members(archive)
                    if _is_answer_file_or_wanted_file(info, names_of_other_files_to_unpack)
                ]
                limit = MAX_UNPACKED + UNPACKED_PER_BYTE * path.stat().st_size
                if (
                    sum(info.file_size for info in members) > limit
                ):  # `zipfile` reads at most the size that a zip states for a member
                    raise InputError(
                        f"{path}: expected at most {limit:,} bytes of answers in it; split the zip"
                    )
                for info in members:
                    name = f"{path}: {info.filename}"
                    if (folder / info.filename).exists():
                        raise InputError(f"{name}: the zip has two members of this name; keep one")
                    archive.extract(info, folder)
        except UNREADABLE as error:
            raise InputError(f"{name}: expected a readable zip ({error})") from error
        folder.mkdir(exist_ok=True)
        try:
            yield folder
        except InputError as error:
            text = str(error).replace(f"{folder}{os.sep}", f"{path}: ").replace(str(folder), str(path))
            raise InputError(text) from error


def list_zip_members(archive: zipfile.ZipFile) -> list[zipfile.ZipInfo]:
    """Return the file names in a zip, with slashes between folders even if Windows wrote backslashes."""
    members = archive.infolist()
    for info in members:
        info.filename = info.filename.replace("\\", "/")
    return members


def _is_answer_file_or_wanted_file(info: zipfile.ZipInfo, wanted_file_names: Collection[str]) -> bool:
    """Whether to unpack a file of a zip: a response file, or a file with another wanted name.

    Files that operating systems add, such as ``__MACOSX/._...``, are not unpacked.
    """
    name = PurePosixPath(info.filename).name
    is_answers = name.endswith(ENDINGS) and not name.startswith(".")
    return (is_answers or name in wanted_file_names) and not info.is_dir()


def find_files_of_suite(path: Path, domain: str, ability: Ability) -> list[Path]:
    """Return the response files at a path that may have answers to a suite. The path is a file or a folder.

    Files whose paths name another suite (ability in a benchmark) are left out.

    Raises:
        InputError: there is no response file, or all files name other suites.
    """
    files = find_response_files(path)
    suites_of_others = {
        file: suite
        for file in files
        if (suite := _find_conflicting_suite_in_path(file, domain, ability)) is not None
    }
    if len(suites_of_others) == len(files):
        other_suite = " ".join(suites_of_others[files[0]])
        raise InputError(f"{files[0]}: expected answers to {domain} {ability.value}, not to {other_suite}")
    return [file for file in files if file not in suites_of_others]


def find_response_file_of_suite(path: Path, domain: str, ability: Ability, attempt: int = 1) -> Path:
    """Return the only response file with the answers to a suite. In a folder, the file must name the suite.

    A suite is an ability in a benchmark. A run with several attempts at each task has a file for each
    attempt; ``attempt`` selects it. A file without the number of an attempt in its name has the first
    answers.

    Raises:
        InputError: there is no such file, or more than one.
    """
    if not path.is_dir():
        first = find_files_of_suite(path, domain, ability)[0]
        name = read_model_name(first).removesuffix(format_attempt_name("", 1))
        return first if attempt == 1 else first.with_name(f"{format_attempt_name(name, attempt)}{SUFFIX}")
    files: list[Path] = []
    if attempt == 1:
        # this search ignores files with an attempt number; if it finds no other files, it raises
        with suppress(InputError):
            files = find_response_files(path)

    def is_of_suite(file: Path) -> bool:
        return read_domain_and_ability_from_path(file) == (domain, ability.value)

    of_suite = list(filter(is_of_suite, files)) or sorted(
        filter(is_of_suite, path.rglob(f"*{format_attempt_name('', attempt)}{SUFFIX}"))
    )
    if len(of_suite) != 1:
        name = "<model>" if attempt == 1 else format_attempt_name("<model>", attempt)
        expected = path / domain / ability.value / f"{name}{SUFFIX}"
        raise InputError(f"{path}: expected one file {expected}, found {len(of_suite) or 'none'}")
    return of_suite[0]


def read_domain_and_ability_from_path(file: Path) -> tuple[str, str] | None:
    """Return the domain and the ability that a path names, or None if it names no suite."""
    for ability in find_ability_entry_points():
        domain = read_model_name(file).removesuffix(f"_{ability}")
        if domain != read_model_name(file):
            return domain, ability.value
    folders = file.absolute().parent.parts
    positions = [i for i, name in enumerate(folders) if name in find_ability_entry_points() and i]
    return (folders[positions[-1] - 1], folders[positions[-1]]) if positions else None


def _find_conflicting_suite_in_path(file: Path, domain: str, ability: Ability) -> tuple[str, str] | None:
    """Return the benchmark and the ability in a file's path if they are not the wanted ones, else None.

    A path with the wanted ability and an unknown folder in place of the benchmark is accepted.
    """
    suite = read_domain_and_ability_from_path(file)
    if suite is None or (
        suite[1] == ability.value and (suite[0] == domain or suite[0] not in list_benchmarks())
    ):
        return None
    return suite
