"""Adds up a run's totals, answer by answer or in groups; memory grows only with the number of tasks."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

from eai.abilities.declaration import get_declaration
from eai.abilities.verdict import RAISED
from eai.results.coverage import TaskCoverageByAnswers, TasksChangedByErrata
from eai.results.rate import NOTHING, Exact, Rate, add_numerators_and_denominators_to_sums, make_rates
from eai.results.record import NOT_ANSWERED, Record

_ANSWERED, _SCORED, _LEFT_OUT, _CORRECTED_OR_LEFT_OUT, _RAISED, _CUT_OFF = 1, 2, 4, 8, 16, 32
"""Bits of a task's status. A task with several answers has the bits of all these answers."""


def _encode_record_status_as_bits(record: Record) -> int:
    excluded, errata, error = record.verdict.excluded, record.errata, record.verdict.error
    return (
        _ANSWERED * (record.unanswered is None)
        | _SCORED * (excluded is None)
        | _LEFT_OUT * (excluded == NOT_ANSWERED)
        | _CORRECTED_OR_LEFT_OUT * (errata is not None and bool(errata.entries))
        | _RAISED * (error is not None and error.check == RAISED)
        | _CUT_OFF * record.is_cut_off
    )


@dataclass(slots=True)
class RunTotals:
    """Counts from which the rates and the coverage of a run are computed.

    The records (scored answers) of the run can be added in groups, in any order.

    Attributes:
        record_count: number of records.
        head: first record, without explanations and texts.
        sums_by_metric: numerator and denominator of each metric.
        status_by_task: status of each task as bits, such as `_ANSWERED`; in the order of the records.
        stated_suite_sizes: numbers of tasks that records state for their suite. All should state the same
            number.
        errata_versions: versions of the errata, the known errors of the data set.
        metrics_without_value: names of metrics without a value in this run. The ability's `missing_metrics`
            returns them.
        answer_counts_by_planner: mapping from the name of each planner to the number of answers whose
            operators it tested.
        second_planner_outcomes: mapping from outcomes of the second planner to numbers of answers. The second
            planner decides on the answers that the first planner left undecided.
    """

    record_count: int = 0
    head: Record | None = None
    sums_by_metric: dict[str, tuple[Exact, Exact]] = field(default_factory=dict)
    status_by_task: dict[str, int] = field(default_factory=dict)
    stated_suite_sizes: set[int | None] = field(default_factory=set)
    errata_versions: dict[str, None] = field(default_factory=dict)
    metrics_without_value: set[str] = field(default_factory=set)
    answer_counts_by_planner: Counter[str] = field(default_factory=Counter)
    second_planner_outcomes: Counter[str] = field(default_factory=Counter)

    @staticmethod
    def from_records(records: Iterable[Record]) -> RunTotals:
        """Return the totals of some records (scored answers) of a run."""
        totals = RunTotals()
        for record in records:
            totals.add_record(record)
        return totals

    def add_record(self, record: Record) -> None:
        """Add a record, which is one scored answer."""
        verdict = record.verdict
        if self.head is None:
            self.head = replace(record, response="", explanation=None, attempts=())
        self.record_count += 1
        self.stated_suite_sizes.add(record.suite_size)
        if record.errata is not None:
            self.errata_versions[record.errata.version] = None
        if verdict.name_of_used_planner is not None:
            self.answer_counts_by_planner[verdict.name_of_used_planner] += 1
        if verdict.outcome_of_fallback_planner is not None:
            self.second_planner_outcomes[verdict.outcome_of_fallback_planner] += 1
        self._add_task_statuses({record.task_id: _encode_record_status_as_bits(record)})
        if verdict.excluded is None:
            declared = get_declaration(record.ability)
            self.metrics_without_value.update(declared.missing_metrics(verdict))
            add_numerators_and_denominators_to_sums(self.sums_by_metric, declared.contributions(verdict))

    def add_totals_of_later_records(self, later_totals: RunTotals) -> None:
        """Add the totals of later records of the run to these totals."""
        self.head = self.head or later_totals.head
        self.record_count += later_totals.record_count
        self.stated_suite_sizes |= later_totals.stated_suite_sizes
        self.errata_versions |= later_totals.errata_versions
        self.metrics_without_value |= later_totals.metrics_without_value
        self.answer_counts_by_planner += later_totals.answer_counts_by_planner
        self.second_planner_outcomes += later_totals.second_planner_outcomes
        self._add_task_statuses(later_totals.status_by_task)
        add_numerators_and_denominators_to_sums(self.sums_by_metric, later_totals.sums_by_metric)

    def _add_task_statuses(self, statuses: Mapping[str, int]) -> None:
        for task_id, status in statuses.items():
            self.status_by_task[task_id] = self.status_by_task.get(task_id, 0) | status

    @property
    def first_record(self) -> Record:
        """First record of the run, without explanations and texts.

        Raises:
            ValueError: there are no records.
        """
        if self.head is None:
            raise ValueError("no record was added yet, so there is no first one")
        return self.head

    @property
    def rates_of_applicable_metrics(self) -> dict[str, Rate]:
        """Rate of each metric to which verdicts contribute; empty if all records are excluded.

        The rate is 0 of 0 for `metrics_without_value`. All rates are 0 of 0 if no task has an answer.
        """
        if not self.coverage.answered:
            return dict.fromkeys(self.sums_by_metric, NOTHING)
        return {**make_rates(self.sums_by_metric), **dict.fromkeys(self.metrics_without_value, NOTHING)}

    @property
    def rates(self) -> dict[str, Rate]:
        """Rates of all metrics of the ability. A metric to which no record adds anything is 0 of 0."""
        declared = get_declaration(self.first_record.ability)
        return {
            **dict.fromkeys(declared.contributions(declared.verdict()), NOTHING),
            **self.rates_of_applicable_metrics,
        }

    @property
    def agent_labels(self) -> tuple[str, ...]:
        """Labels of the run's settings that are not standard: harness, reasoning effort and game rules."""
        experiment = self.first_record.experiment
        if experiment is None:
            return ()
        return tuple(filter(None, (experiment.harness, experiment.effort, experiment.game_rules_text)))

    @property
    def planners(self) -> tuple[str, ...]:
        """Names of the planners that tested operators in answers: usually one. Older records name none."""
        return tuple(sorted(self.answer_counts_by_planner))

    @property
    def coverage(self) -> TaskCoverageByAnswers:
        """Numbers of tasks of the suite that the run asked, answered, failed or left out."""
        unanswered = [status for status in self.status_by_task.values() if not status & _ANSWERED]
        return TaskCoverageByAnswers(
            asked=len(self.status_by_task),
            answered=len(self.status_by_task) - len(unanswered),
            failed=sum(bool(status & _SCORED) for status in unanswered),
            left_out=sum(bool(status & _LEFT_OUT) for status in unanswered),
            tasks=next(iter(self.stated_suite_sizes)) if len(self.stated_suite_sizes) == 1 else None,
            raised=sum(bool(status & _RAISED) for status in self.status_by_task.values()),
            cut_off=sum(bool(status & _CUT_OFF) for status in self.status_by_task.values()),
        )

    @property
    def errata(self) -> TasksChangedByErrata | None:
        """Tasks that errata (errors of the data set) left out or corrected; None if no errata were used."""
        if not self.errata_versions:
            return None
        affected = {
            task_id: status & _SCORED
            for task_id, status in self.status_by_task.items()
            if status & _CORRECTED_OR_LEFT_OUT
        }
        return TasksChangedByErrata(
            version=", ".join(self.errata_versions),
            tasks=len(self.status_by_task),
            scored=sum(bool(status & _SCORED) for status in self.status_by_task.values()),
            left_out=tuple(task_id for task_id, scored in affected.items() if not scored),
            corrected=tuple(task_id for task_id, scored in affected.items() if scored),
        )
