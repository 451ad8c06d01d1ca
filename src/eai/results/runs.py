"""Reads runs.

A run has the records (scored answers) of one model in one suite under one protocol (scoring rules). It may
belong to an experiment (a choice of study options).
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple, TypeAlias
from urllib.parse import urlencode

from eai.abilities.declaration import get_declaration
from eai.abilities.experiment import Experiment
from eai.abilities.protocol import Ability, Protocol, get_ability_sort_key
from eai.abilities.replanning_options import ReplanningOptions
from eai.base.errors import InputError
from eai.base.files import find_files_below, read_content, write_files_atomically
from eai.base.grouping import group_pairs
from eai.base.json_value import Json
from eai.benchmarks.names import TaskReference
from eai.benchmarks.protocols import find_implementation
from eai.benchmarks.registry import list_benchmarks
from eai.results.lines import SuiteKey
from eai.results.paper_tables import read_paper_protocol_and_tables
from eai.results.record import Record
from eai.results.records import RECORDS, read_records

_LOG_FILE = "inspect.json"
"""Name of a file beside records. It names the log of Inspect that has the samples of these records."""


LogSamples: TypeAlias = tuple[str | Mapping[str, str], int | Mapping[str, int]]
"""File name of the Inspect log with a run's samples, and the epoch (round of answers) of these samples.

If tasks differ, a mapping from tasks to names or epochs replaces the name or the epoch.
"""


class RunKey(NamedTuple):
    """Identity of a run.

    Keys sort by protocol (scoring rules), domain and ability in the order of their declaration, then by name.
    """

    protocol: Protocol
    domain: str
    ability: Ability
    model: str
    experiment: Experiment | None = None

    @property
    def name(self) -> str:
        """Name of the run within its suite: its model, and the label of its study options, if any."""
        return self.model if self.experiment is None else f"{self.model}, {self.experiment.label}"

    @property
    def suite(self) -> SuiteKey:
        """Suite of the run: protocol (scoring rules), benchmark and ability, as tables name them."""
        return SuiteKey(self.protocol.value, self.domain, self.ability.value)

    @property
    def protocol_domain_ability_and_name(self) -> tuple[str, str, str, str]:
        """Protocol, domain, ability and name of the run, as the first columns of many tables have them."""
        return (*self.suite, self.name)

    @property
    def has_standard_rules_and_no_study_options(self) -> bool:
        """Whether the run has no options of a study (variation), and its game rules are standard.

        Only such runs are ranked.
        """
        return self.experiment is None or self.experiment.has_standard_rules_and_no_study_options

    @property
    def sort_key(self) -> tuple[int, int, str, int, str, str]:
        """Sort key of runs; unknown domains come last."""
        names_of_domains = list_benchmarks()
        position = (
            names_of_domains.index(self.domain) if self.domain in names_of_domains else len(names_of_domains)
        )
        protocols = [*Protocol.list_names()]
        return (
            protocols.index(self.protocol),
            position,
            self.domain,
            get_ability_sort_key(self.ability),
            self.model,
            "" if self.experiment is None else self.experiment.label,
        )

    def __str__(self) -> str:
        return f"{self.name}, {self.domain} {self.ability.value}, protocol {self.protocol.value}"


@dataclass(frozen=True, slots=True)
class Run:
    """The records (scored answers) of a run, at least one, in the order of the data set.

    Attributes:
        key: identity of the run.
        records: the records.
        log: the file name of Inspect's log and the epoch of its samples, as in `LogSamples`; None if unknown.
    """

    key: RunKey
    records: tuple[Record, ...]
    log: LogSamples | None = None


def recount_goals_as_in_paper(run: Run) -> Run:
    """Return a copy of a run in which only goals count that the prompts stated, as in the paper's runs.

    Some of the paper's prompts left out goals of their task.
    """
    name = read_paper_protocol_and_tables().protocol
    protocol = find_implementation(name) if run.key.protocol.value == name else None
    if protocol is None:
        return run

    def judge_by_goals_stated_in_prompt(record: Record) -> Record:
        task = TaskReference(record.domain, record.ability, record.task_id)
        verdict = protocol.judge_by_goals_in_prompt(task, record.verdict)
        return record if verdict is record.verdict else replace(record, verdict=verdict)

    return replace(run, records=tuple(map(judge_by_goals_stated_in_prompt, run.records)))


def recount_errors_as_in_paper(run: Run) -> Run:
    """Return a copy of a run with several attempts at a task. Errors are counted as by the paper's script."""
    protocol = find_implementation(read_paper_protocol_and_tables().protocol)
    if protocol is None:
        return run

    def recount_errors_of_record_as_in_paper(record: Record) -> Record:
        options = ReplanningOptions.from_experiment(record.experiment)
        if options is None or not record.attempts:
            return record
        verdicts = [attempt.verdict for attempt in record.attempts]
        counted = protocol.count_errors_as_published(verdicts, options.replans)
        pairs = zip(record.attempts, counted, strict=True)
        attempts = tuple([replace(attempt, verdict=verdict) for attempt, verdict in pairs])
        return replace(record, attempts=attempts, verdict=counted[-1])

    return replace(run, records=tuple(map(recount_errors_of_record_as_in_paper, run.records)))


def find_record_files(paths: Iterable[Path]) -> list[Path]:
    """Return the files of records (scored answers) at paths or below folders, each once.

    Links to folders are followed, each folder once.

    Raises:
        InputError: a path does not exist, or there is no such file below it.
    """
    record_files: dict[Path, None] = {}
    for path in paths:
        if path.is_dir():
            files = find_files_below(path, RECORDS)
            if not files:
                raise InputError(
                    f"{path}: expected a folder with {RECORDS} somewhere below, found none; eai score writes "
                    "this file, and eai run at its end"
                )
            record_files |= dict.fromkeys(files)
        elif path.exists():
            record_files[path] = None
        else:
            raise InputError(f"{path}: no such file or folder")
    return list(record_files)


def read_runs(paths: Iterable[Path]) -> Iterator[Run]:
    """Yield the runs in files of records, file by file, so that only one file's records are in memory.

    Raises:
        InputError: a file contains no records, or lines that are not records; two files have the same run; or
            a file has two records of a task.
    """
    sources: dict[RunKey, Path] = {}
    for path in find_record_files(paths):
        runs = group_pairs((_make_run_key(record), record) for record in read_records(path))
        if not runs:
            raise InputError(f"{path}: expected at least one record, found none")
        for key, records in runs.items():
            if key in sources:
                raise InputError(f"{path}: the run {key} is also in {sources[key]}; give one of them")
            sources[key] = path
            task_id, times = Counter(record.task_id for record in records).most_common(1)[0]
            if times > 1 and records[0].sample is not None:
                raise InputError(
                    f"{path}: {key} has several answers to a task; give records with one answer to each task"
                )
            if times > 1:
                raise InputError(f"{path}: the run {key} has {times} records of task {task_id}; keep one")
            yield Run(key, tuple(records), _read_inspect_log_names_and_epoch(path))


def write_inspect_log_names_and_epoch(
    folder: Path, logs: Mapping[str, Path], epoch: int | Mapping[str, int]
) -> None:
    """Write a file beside records that names Inspect's log of the answers, and the epoch (round of answers).

    Args:
        folder: the folder of the records.
        logs: mapping from each asked task to its log. The file has this mapping if there are several logs.
        epoch: the epoch, or a mapping from each task to its epoch.

    Raises:
        InputError: the folder cannot be written.
    """
    names = {task_id: log.name for task_id, log in logs.items()}
    log: Json = names if len(set(names.values())) > 1 else next(iter(names.values()), "")
    write_files_atomically({folder / _LOG_FILE: json.dumps({"log": log, "epoch": epoch}) + "\n"})


def _read_inspect_log_names_and_epoch(record_file: Path) -> LogSamples | None:
    path = record_file.with_name(_LOG_FILE)
    try:
        content = json.loads(read_content(path)) if path.exists() else None
        if content is None:
            return None
        log, epoch = content["log"], content["epoch"]
        return (
            {i: str(log[i]) for i in log} if isinstance(log, dict) else str(log),
            {i: int(epoch[i]) for i in epoch} if isinstance(epoch, dict) else int(epoch),
        )
    except (OSError, ValueError, TypeError, KeyError) as error:
        raise InputError(f'{path}: expected a JSON object {{"log": ..., "epoch": ...}}') from error


def make_explorer_url_fragment(record: Record) -> str:
    """Return the fragment of a web address that shows a record in the explorer of a report."""
    agent = get_declaration(record.ability).read_episode_settings(record.response)
    key = _make_run_key(record if agent is None else record.add_experiment(agent))
    run = f"{key.domain}/{key.ability.value}/{key.protocol.value}/{key.name}"
    return f"explorer.html#{urlencode({'run': run, 'task': record.task_id})}"


def _make_run_key(record: Record) -> RunKey:
    return RunKey(record.protocol, record.domain, record.ability, record.model, record.experiment)
