"""Submissions to the challenge: one zip with the answers to all eight suites.

A submission is built from a run, and checked row by row.
"""

from __future__ import annotations

import io
import json
import zipfile
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path, PurePosixPath

from eai.abilities.protocol import PAPER_ABILITIES, Ability
from eai.base.errors import InputError
from eai.base.files import MAX_UNPACKED, require_file, write_files_atomically
from eai.base.grouping import group_pairs
from eai.base.store import DataPackStore
from eai.benchmarks.reference_wheel import SCENE_PREFIX, get_task_id_of_published_id
from eai.benchmarks.registry import PAPER_BENCHMARKS, find_benchmark
from eai.results.answer_files import UNREADABLE, list_zip_members
from eai.results.responses import SUFFIX, find_response_files, read_responses
from eai.tasks.prompts.prompt import read_prompt_file
from eai.tasks.source import DataMistake, Source

_PROMPTS_SUFFIX = "_prompts.json"
"""Suffix of the names of the prompt files in the challenge's starter kit."""

_SUITES = [(domain, ability) for domain in PAPER_BENCHMARKS for ability in PAPER_ABILITIES]

_EPOCH = (1980, 1, 1, 0, 0, 0)


def get_task_identifiers_by_submission_file(
    store: DataPackStore | None = None, prompts: Path | None = None
) -> dict[str, tuple[str, ...]]:
    """Return the names of a submission's files, each with the task identifiers that the file must contain.

    Args:
        store: store of the data set; None for the user's default store.
        prompts: a folder with the prompts of a phase of the challenge, as its starter kit has them:
            ``<domain>_<ability>_prompts.json``. The identifiers are those of these prompts. None for the
            identifiers of the data set, which the first phase used.

    Raises:
        InputError: a file of prompts cannot be read, or the folder has no such file.
        DataError: the data set cannot be obtained.
    """
    if prompts is None:
        return {_format_file_name(*suite): _list_prompt_identifiers(*suite, store) for suite in _SUITES}
    files = {suite: prompts / _format_file_name(*suite).replace(SUFFIX, _PROMPTS_SUFFIX) for suite in _SUITES}
    identifiers = {
        _format_file_name(*suite): tuple(read_prompt_file(file))
        for suite, file in files.items()
        if file.exists()
    }
    if not identifiers:
        raise InputError(f"{prompts}: expected a folder with <domain>_<ability>{_PROMPTS_SUFFIX}, found none")
    return identifiers


def build_submission(
    run: Path,
    out: Path,
    store: DataPackStore | None = None,
    *,
    model: str | None = None,
    folder: str | None = None,
    prompts: Path | None = None,
) -> None:
    """Put the answers of one model to all suites into a zip. Equal answers give equal bytes.

    Args:
        run: the folder of a run, with answers in ``<domain>/<ability>/<model>/``.
        out: the path of the zip to write.
        store: store of the data set; None for the user's default store.
        model: the model's name in the run; optional if the run has only one model.
        folder: name of a folder in the zip for its files; None to put them at the top of the zip.
        prompts: a folder with the prompts of a phase of the challenge, as for
            `get_task_identifiers_by_submission_file`.

    Raises:
        InputError: the run has no answers or answers of several models, a name is not the plain name of a
            folder, or the zip cannot be written.
        DataError: the data set cannot be obtained.
    """
    for name in (model, folder):
        if name is not None and (PurePosixPath(name).name != name or not name.strip(".")):
            raise InputError(f"{name!r}: expected the name of a folder, not a path")
    files = find_response_files(run)
    model = model or _find_name_of_single_model(run, files)
    expected = get_task_identifiers_by_submission_file(store, prompts)
    members = {}
    for domain, ability in _SUITES:
        name = _format_file_name(domain, ability)
        file = run / domain / ability.value / model / f"{model}{SUFFIX}"
        if file in files and name in expected:
            members[name] = _make_submission_content(file, expected[name])
    if not members:
        raise InputError(f"{run}: no answers of a model named {model}; give a model's folder name")
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w") as archive:
        for name, content in members.items():
            info = zipfile.ZipInfo(name if folder is None else f"{folder}/{name}", date_time=_EPOCH)
            archive.writestr(info, content, zipfile.ZIP_DEFLATED)
    write_files_atomically({out: made.getvalue()})


def check_submission(
    path: Path, store: DataPackStore | None = None, prompts: Path | None = None
) -> list[DataMistake]:
    """Return all errors of a submission, file by file in a fixed order; empty if it is correct.

    Task identifiers are accepted with and without the prefix that names their scene. Files may be in a folder
    of the zip. The expected files and identifiers are those of `get_task_identifiers_by_submission_file`.

    Raises:
        InputError: the zip cannot be read.
        DataError: the data set cannot be obtained.
    """
    expected = get_task_identifiers_by_submission_file(store, prompts)
    require_file(path)
    try:
        with zipfile.ZipFile(path) as archive:
            members = group_pairs(
                (PurePosixPath(info.filename).name, info)
                for info in list_zip_members(archive)
                if not info.is_dir()
            )
            findings = [
                DataMistake(path.name, f"{name} is not one of the files")
                for name in members
                if name not in expected
            ]
            for file, identifiers in expected.items():
                candidates = members.get(file, [])
                if len(candidates) != 1:
                    problem = "is missing" if not candidates else f"is there {len(candidates)} times"
                    findings.append(DataMistake(file, problem))
                elif candidates[0].file_size > MAX_UNPACKED:
                    findings.append(DataMistake(file, f"holds more than {MAX_UNPACKED:,} bytes"))
                else:
                    findings += [
                        DataMistake(file, problem)
                        for problem in _describe_errors_of_submission_file(
                            archive, candidates[0], identifiers
                        )
                    ]
    except UNREADABLE as error:
        why = error.strerror if isinstance(error, OSError) else error
        raise InputError(f"{path}: expected a zip that can be read ({why})") from error
    return findings


def _describe_errors_of_submission_file(
    archive: zipfile.ZipFile, member: zipfile.ZipInfo, required_task_identifiers: Sequence[str]
) -> Iterator[str]:
    """Yield the errors of one file in the zip."""
    try:
        content = archive.read(member)
    except UNREADABLE as error:
        yield f"cannot be read ({error})"
        return
    try:
        rows = json.loads(content)
    except (ValueError, RecursionError) as error:
        yield f"is not JSON ({error})"
        return
    if not isinstance(rows, list):
        yield 'is not a list of {"identifier", "llm_output"}'
        return
    expected = {get_task_id_of_published_id(identifier) for identifier in required_task_identifiers}
    times: Counter[str] = Counter()
    for number, row in enumerate(rows, 1):
        identifier = row.get("identifier") if isinstance(row, dict) else None
        if not isinstance(identifier, str):
            yield f'row {number} has no text "identifier"'
            continue
        task_id = get_task_id_of_published_id(identifier)
        times[task_id] += 1
        if times[task_id] == 2:
            yield f"{identifier} is repeated"
        if task_id not in expected:
            yield f"{identifier} is unknown"
        yield from _find_answer_problems(identifier, row)
    for identifier in required_task_identifiers:
        if get_task_id_of_published_id(identifier) not in times:
            yield f"{get_task_id_of_published_id(identifier)} is missing"


def _find_answer_problems(identifier: str, row: Mapping[str, object]) -> Iterator[str]:
    answer = row.get("llm_output")
    if answer is None or (isinstance(answer, str) and not answer.strip()):
        yield f"{identifier} is empty"
    elif not isinstance(answer, str):
        yield f'{identifier}: "llm_output" is not a text'


def _format_file_name(domain: str, ability: Ability) -> str:
    return f"{domain}_{ability.value}{SUFFIX}"


def _list_prompt_identifiers(domain: str, ability: Ability, store: DataPackStore | None) -> tuple[str, ...]:
    """Return the identifiers of a suite's published prompts. Each answer must repeat its prompt's identifier.

    Identifiers that begin with `SCENE_PREFIX` stay as they are. Some other identifiers are known to be wrong;
    they are replaced by the task ids of the data set.
    """
    published = find_benchmark(domain).data.prompts
    if published is None:
        raise InputError(
            f"{domain} has no published prompts, which a submission answers; leave out this benchmark"
        )
    rows = json.loads(published(ability, Source(store)).prompts)
    identifiers: list[str] = [row["identifier"] for row in rows]
    return tuple(i if i.startswith(SCENE_PREFIX) else get_task_id_of_published_id(i) for i in identifiers)


def _find_name_of_single_model(run: Path, files: Sequence[Path]) -> str:
    names = sorted({file.parent.name for file in files if file.name == f"{file.parent.name}{SUFFIX}"})
    if len(names) != 1:
        raise InputError(f"{run}: expected the answers of one model, found {', '.join(names) or 'none'}")
    return names[0]


def _make_submission_content(file: Path, identifiers: Sequence[str]) -> bytes:
    """Return the answers of a response file in the challenge's JSON form, in the order of the identifiers."""
    ids = {get_task_id_of_published_id(identifier): identifier for identifier in identifiers}
    texts = {
        response.task_id: response.text
        for response in read_responses(file, ids, get_task_id_of_published_id).responses
    }
    rows = [
        {"identifier": identifier, "llm_output": texts[task_id]}
        for task_id, identifier in ids.items()
        if task_id in texts
    ]
    return json.dumps(rows, indent=1).encode()
