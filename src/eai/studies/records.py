"""Read the records (stored verdicts on answers) that a study analyses, only when an analysis uses them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, MutableMapping
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TypeAlias

from eai.base.errors import InputError
from eai.base.grouping import group_pairs
from eai.results.runs import Run, read_runs
from eai.results.tidy import TidyTables
from eai.tasks.source import ErrataChoice, Source

ReportDone: TypeAlias = Callable[[int], None]
"""Function that a long analysis calls with the number of finished steps, to show progress."""


def _show_no_progress(title: str, total: int) -> AbstractContextManager[ReportDone]:
    return nullcontext(lambda done: None)


def _ignore_note(line: str) -> None:
    """Drop a note to the user: by default, notes are not shown."""


@dataclass(frozen=True, slots=True)
class StudyRecords:
    """Records (stored verdicts on answers) for an analysis, with functions that report progress and notes.

    They are read as runs, or as tidy tables: a line for each answer, step, goal or clause.

    Attributes:
        paths: files of records, or folders with records.jsonl somewhere below.
        folder: folder of the results.
        source: source of the data sets of the records' benchmarks.
        note: function that prints a line for the user, outside of the results.
        progress: function that shows the progress of a long analysis, given a title and the number of steps.
    """

    paths: tuple[Path, ...]
    folder: Path = Path()
    source: Source = field(default_factory=Source)
    note: Callable[[str], None] = _ignore_note
    progress: Callable[[str, int], AbstractContextManager[ReportDone]] = _show_no_progress
    _cached_tables: MutableMapping[bool, TidyTables] = field(default_factory=dict)

    def read_runs(self) -> Iterator[Run]:
        """Yield the runs file by file, so that memory holds the records of one file at a time.

        Raises:
            InputError: there are no records, or a record is unusable.
        """
        return read_runs(self.paths)

    def make_tidy_tables_of_comparable_runs(self, *, features: bool = True) -> TidyTables:
        """Return tidy tables (a line for each answer, step, goal or clause) of runs that can be compared.

        These are the runs without study options (plain runs), if there are any. Other runs are then left out,
        and the user gets a note. Without plain runs, all runs must have the same study options.

        Args:
            features: whether lines have features of tasks and reasons for wrong goals, from the data set.

        Raises:
            InputError: there are no records, a record is unusable, or there are several experiments and no
                plain run.
        """
        if True in self._cached_tables or features in self._cached_tables:
            return self._cached_tables.get(True) or self._cached_tables[features]
        by_label: dict[str, TidyTables] = {}
        for run in self.read_runs():
            label = "" if run.key.experiment is None else run.key.experiment.study_label
            if label not in by_label:
                by_label[label] = self._make_empty_tables(features=features)
            by_label[label].add_records(run.records)
        labels = sorted(by_label)
        if "" in by_label and len(labels) > 1:
            self.note(f"left out because they are experiments: runs with {', '.join(labels[1:])}")
        elif len(labels) > 1:
            raise InputError(
                "runs of several experiments cannot be compared in one table; give records of "
                f"one of them: {', '.join(labels)}"
            )
        self._cached_tables[features] = by_label[labels[0]]
        return self._cached_tables[features]

    def make_all_tables(self) -> TidyTables:
        """Return tidy tables (a line for each answer, step, goal or clause) of all runs.

        Raises:
            InputError: there are no records, or a record is unusable.
        """
        made = self._make_empty_tables(features=True)
        for run in self.read_runs():
            made.add_records(run.records)
        return made

    def _make_empty_tables(self, *, features: bool) -> TidyTables:
        return TidyTables(replace(self.source, errata=ErrataChoice.NONE), features=features)

    def change_to_subfolder(self, name: str) -> StudyRecords:
        """Return a copy whose results go into a subfolder of the present folder for results."""
        return replace(self, folder=self.folder / name)


def group_runs_by_suite_and_model(runs: Iterator[Run]) -> Mapping[tuple[str, ...], list[Run]]:
    """Return a mapping from protocol (scoring rules), domain, ability and model to the sorted runs."""
    ordered = sorted(runs, key=lambda run: run.key.sort_key)
    return group_pairs(((*run.key.suite, run.key.model), run) for run in ordered)
