"""The totals of a run, added up record by record or part by part; memory grows with its tasks alone."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

from eai.abilities.declaration import declaration_of
from eai.abilities.verdict import RAISED
from eai.results.coverage import Coverage, ErrataEffect
from eai.results.rate import NOTHING, Exact, Rate, add_up, rates_of
from eai.results.record import NOT_ANSWERED, Record

_ANSWERED, _SCORED, _LEFT_OUT, _IN_ERRATA, _RAISED = 1, 2, 4, 8, 16
"""The bits of the fate of a task, of its answers together where it has several."""


def _fate(record: Record) -> int:
    """The fate of a task by one of its records alone, as bits."""
    excluded, errata, error = record.verdict.excluded, record.errata, record.verdict.error
    return (
        _ANSWERED * (record.unanswered is None)
        | _SCORED * (excluded is None)
        | _LEFT_OUT * (excluded == NOT_ANSWERED)
        | _IN_ERRATA * (errata is not None and bool(errata.entries))
        | _RAISED * (error is not None and error.check == RAISED)
    )


@dataclass(slots=True)
class Totals:
    """The rates and the coverage of a run; it makes no difference in which parts it is added up.

    Attributes:
        number: how many records it has.
        head: the first one, without its words.
        sums: by metric its numerator and its denominator.
        fates: what became of each task, in the order of the records.
        sizes: how many tasks the suite has, as the records say it.
        versions: those of the errata.
        void: the metrics of which a run has nothing, as a record says.
        judges: by planner how many answers it judged.
        left: by outcome of the second of two planners how many answers the first one left to it.
    """

    number: int = 0
    head: Record | None = None
    sums: dict[str, tuple[Exact, Exact]] = field(default_factory=dict)
    fates: dict[str, int] = field(default_factory=dict)
    sizes: set[int | None] = field(default_factory=set)
    versions: dict[str, None] = field(default_factory=dict)
    void: set[str] = field(default_factory=set)
    judges: Counter[str] = field(default_factory=Counter)
    left: Counter[str] = field(default_factory=Counter)

    @staticmethod
    def from_records(records: Iterable[Record]) -> Totals:
        """Those of some records of a run."""
        totals = Totals()
        for record in records:
            totals.add(record)
        return totals

    def add(self, record: Record) -> None:
        """Add a record."""
        verdict = record.verdict
        if self.head is None:
            self.head = replace(record, response="", explanation=None, attempts=())
        self.number += 1
        self.sizes.add(record.suite_size)
        if record.errata is not None:
            self.versions[record.errata.version] = None
        if verdict.planner_used is not None:
            self.judges[verdict.planner_used] += 1
        if verdict.second_planner_outcome is not None:
            self.left[verdict.second_planner_outcome] += 1
        self._became({record.task_id: _fate(record)})
        if verdict.excluded is None:
            declared = declaration_of(record.ability)
            self.void.update(declared.missing_metrics(verdict))
            add_up(self.sums, declared.contributions(verdict))

    def merge(self, later: Totals) -> None:
        """Add those of a later part of the run."""
        self.head = self.head or later.head
        self.number += later.number
        self.sizes |= later.sizes
        self.versions |= later.versions
        self.void |= later.void
        self.judges += later.judges
        self.left += later.left
        self._became(later.fates)
        add_up(self.sums, later.sums)

    def _became(self, fates: Mapping[str, int]) -> None:
        for task_id, fate in fates.items():
            self.fates[task_id] = self.fates.get(task_id, 0) | fate

    @property
    def first(self) -> Record:
        """The first record, without its words.

        Raises:
            ValueError: there is none.
        """
        if self.head is None:
            raise ValueError("a run has at least one record")
        return self.head

    @property
    def counted(self) -> dict[str, Rate]:
        """The metrics, if any record counts."""
        return {**rates_of(self.sums), **dict.fromkeys(self.void, NOTHING)}

    @property
    def rates(self) -> dict[str, Rate]:
        """All metrics of the ability, also those of nothing."""
        declared = declaration_of(self.first.ability)
        return {**dict.fromkeys(declared.contributions(declared.verdict()), NOTHING), **self.counted}

    @property
    def agent(self) -> tuple[str, ...]:
        """The harness and the effort of who answered, and the rules of the game, if they are not standard."""
        experiment = self.first.experiment
        if experiment is None:
            return ()
        return tuple(filter(None, (experiment.harness, experiment.effort, experiment.rules_text)))

    @property
    def planners(self) -> tuple[str, ...]:
        """The planners that judged operators, by name; usually one, none where older records do not say."""
        return tuple(sorted(self.judges))

    @property
    def coverage(self) -> Coverage:
        """How much of the suite, of which all records are, it answers."""
        lacking = [fate for fate in self.fates.values() if not fate & _ANSWERED]
        return Coverage(
            asked=len(self.fates),
            answered=len(self.fates) - len(lacking),
            failed=sum(bool(fate & _SCORED) for fate in lacking),
            left_out=sum(bool(fate & _LEFT_OUT) for fate in lacking),
            tasks=next(iter(self.sizes)) if len(self.sizes) == 1 else None,
            raised=sum(bool(fate & _RAISED) for fate in self.fates.values()),
        )

    @property
    def errata(self) -> ErrataEffect | None:
        """The effect of errata; None if none were used."""
        if not self.versions:
            return None
        touched = {task_id: fate & _SCORED for task_id, fate in self.fates.items() if fate & _IN_ERRATA}
        return ErrataEffect(
            version=", ".join(self.versions),
            tasks=len(self.fates),
            scored=sum(bool(fate & _SCORED) for fate in self.fates.values()),
            left_out=tuple(task_id for task_id, scored in touched.items() if not scored),
            corrected=tuple(task_id for task_id, scored in touched.items() if scored),
        )
