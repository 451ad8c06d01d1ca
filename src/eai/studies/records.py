"""The records that a study analyses, read when they are asked for."""

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

Done: TypeAlias = Callable[[int], None]
"""Is given how much of a long analysis is done."""


def _unseen(title: str, total: int) -> AbstractContextManager[Done]:
    return nullcontext(lambda done: None)


def _unheard(line: str) -> None:
    """Nobody listens."""


@dataclass(frozen=True, slots=True)
class Records:
    """Records, as runs or as tidy tables, and what else an analysis may use.

    Attributes:
        paths: files of records, or folders with records.jsonl somewhere below.
        folder: where the results will be.
        source: where the data set is.
        note: tells the user a line that is no result.
        progress: shows how far a long analysis is: given a title and a total.
    """

    paths: tuple[Path, ...]
    folder: Path = Path()
    source: Source = field(default_factory=Source)
    note: Callable[[str], None] = _unheard
    progress: Callable[[str, int], AbstractContextManager[Done]] = _unseen
    _made: MutableMapping[bool, TidyTables] = field(default_factory=dict)

    def runs(self) -> Iterator[Run]:
        """The runs, file by file, so that only one file's records are in memory.

        Raises:
            InputError: there are no records, or one is unusable.
        """
        return read_runs(self.paths)

    def tables(self, *, features: bool = True) -> TidyTables:
        """The tidy tables of runs that can be compared, made once: the plain runs, if there are any.

        Runs of experiments are left out beside plain runs, with a note.

        Args:
            features: whether lines say what tasks are like, for which these are built.

        Raises:
            InputError: there are no records, or one is unusable, or there are several experiments and no
                plain run.
        """
        if True in self._made or features in self._made:
            return self._made.get(True) or self._made[features]
        by_label: dict[str, TidyTables] = {}
        for run in self.runs():
            label = "" if run.key.experiment is None else run.key.experiment.study_label
            if label not in by_label:
                by_label[label] = self._empty_tables(features=features)
            by_label[label].add(run.records)
        labels = sorted(by_label)
        if "" in by_label and len(labels) > 1:
            self.note(f"left out, as they are of experiments: runs with {', '.join(labels[1:])}")
        elif len(labels) > 1:
            raise InputError(f"expected plain runs, or runs of one experiment, found {', '.join(labels)}")
        self._made[features] = by_label[labels[0]]
        return self._made[features]

    def all_tables(self) -> TidyTables:
        """The tidy tables of all runs, of experiments too.

        Raises:
            InputError: there are no records, or one is unusable.
        """
        made = self._empty_tables(features=True)
        for run in self.runs():
            made.add(run.records)
        return made

    def _empty_tables(self, *, features: bool) -> TidyTables:
        return TidyTables(replace(self.source, errata=ErrataChoice.NONE), features=features)

    def below(self, name: str) -> Records:
        """The same records for another analysis, whose results are in a folder of their own."""
        return replace(self, folder=self.folder / name)


def by_place(runs: Iterator[Run]) -> Mapping[tuple[str, ...], list[Run]]:
    """Runs of one model, domain, ability and protocol together, all sorted."""
    ordered = sorted(runs, key=lambda run: run.key.order)
    return group_pairs(((*run.key.suite, run.key.model), run) for run in ordered)
