"""Converts records (scored answers) to tidy tables, from which all analyses are made."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields
from functools import cache, partial
from typing import TYPE_CHECKING, Any, TypeAlias, cast

from eai.abilities.declaration import AnswerOutcome, get_declaration
from eai.abilities.explanation import parse_statement
from eai.abilities.protocol import Ability
from eai.abilities.verdict import EMPTY_SHARE, PlanVerdict, ShareByMetric
from eai.benchmarks.registry import find_benchmark, list_benchmarks
from eai.results.lines import (
    AnswerTableLine,
    InterpretedGoalTableLine,
    OperatorClauseTableLine,
    PlanStepTableLine,
    TaskGoalTableLine,
)
from eai.results.record import Record
from eai.results.summary import (
    compute_metric_contributions_by_task,
    find_answer_outcome,
    find_task_name,
    list_goals_and_whether_reached,
    list_reported_steps,
)

if TYPE_CHECKING:
    from eai.abilities.goal_interpretation.verdict import GoalVerdict
    from eai.abilities.transition_modeling.verdict import OperatorVerdict
    from eai.results.task_book import TaskLookup
    from eai.tasks.source import Source


class TidyTables:
    """The tidy tables of any number of runs, in their order.

    Features of tasks are looked up in the data set if the benchmark is registered; otherwise they come from
    records.

    Args:
        source: the folder and the options of the data set.
        features: whether lines have features of tasks and reasons for wrong goals; both need the data set.
    """

    def __init__(self, source: Source, *, features: bool = True) -> None:
        self.answers: list[AnswerTableLine] = []
        self.steps: list[PlanStepTableLine] = []
        self.goals: list[TaskGoalTableLine] = []
        self.atoms: list[InterpretedGoalTableLine] = []
        self.clauses: list[OperatorClauseTableLine] = []
        self._source = source
        self._features = features
        self._open_cached_lookup = cache(self._open_task_lookup)

    def add_records(self, records: Sequence[Record]) -> None:
        """Add the records (scored answers) of one run, all of one model, ability, domain and protocol."""
        task_lookup = self._open_cached_lookup(records[0].domain) if self._features else None
        shares = compute_metric_contributions_by_task(records)
        for record in records:
            key = make_identifying_columns(record)
            self.answers.append(_make_answer_line(record, key, shares.get(record.task_id, {}), task_lookup))
            if record.verdict.excluded is not None or record.unanswered is not None:
                continue
            self.steps.extend(_make_step_lines(record, key))
            self.goals.extend(_make_goal_lines(record, key))
            self.atoms.extend(_make_interpreted_goal_lines(record, key, task_lookup))
            self.clauses.extend(_make_clause_lines(record, key))

    def _open_task_lookup(self, domain: str) -> TaskLookup | None:
        from eai.results.task_book import TaskLookup

        return TaskLookup(find_benchmark(domain), self._source) if domain in list_benchmarks() else None


_COLUMNS = tuple(column.name for column in fields(AnswerTableLine))

IdentifyingColumns: TypeAlias = dict[str, Any]
"""Mapping from the names of the columns that every line has (`TidyTableLine`) to their values."""


def make_identifying_columns(record: Record) -> IdentifyingColumns:
    """Return the columns that each table line of a record begins with, such as domain, model and task."""
    rules = "" if record.experiment is None else record.experiment.game_rules_text
    return {
        "protocol": record.protocol.value,
        "domain": record.domain,
        "ability": record.ability.value,
        "model": ", ".join(filter(None, (record.model, rules))),
        "harness": None if record.experiment is None else record.experiment.harness,
        "effort": None if record.experiment is None else record.experiment.effort,
        "experiment": None if record.experiment is None else record.experiment.study_label or None,
        "task": record.task_id,
        "name": find_task_name(record),
    }


def _make_answer_line(
    record: Record, key: IdentifyingColumns, share_by_metric: ShareByMetric, task_lookup: TaskLookup | None
) -> AnswerTableLine:
    verdict, error = record.verdict, record.verdict.error
    usage = None if record.origin is None else record.origin.usage
    is_explained = record.explanation is not None and _has_plans(record)
    values: dict[str, Any] = {
        **key,
        "outcome": find_answer_outcome(record).value,
        "success": _is_success_by_main_yes_no_metric(record, share_by_metric),
        "error_kind": None if error is None else error.kind.value,
        "error_check": None if error is None else error.check,
        "error_step": None if error is None else error.step,
        "error_objects": None if error is None else " ".join(error.objects),
        "steps_tried": len(list(list_reported_steps(record))) if is_explained else None,
        **_count_right_wrong_and_missing_items(record.ability, share_by_metric),
        "cut_off": None if record.origin is None else record.origin.truncated,
        "characters": len(record.response),
        "output_tokens": None if usage is None else usage.output_tokens,
        "cost": None if usage is None else usage.cost,
        **_read_task_features(record, task_lookup),
        **verdict.values_by_column,
    }
    columns: dict[str, Any] = {name: values.get(name) for name in _COLUMNS}
    return AnswerTableLine(**columns)


def _has_plans(record: Record) -> bool:
    return get_declaration(record.ability).answers_are_plans


def _is_success_by_main_yes_no_metric(record: Record, share_by_metric: ShareByMetric) -> bool | None:
    """Return whether an answer is a success by the main yes-or-no metric of its ability.

    The main metric is the first yes-or-no metric in the ability's overview table that has a value for the
    answer. Return None if no such metric has a value.
    """
    declared = get_declaration(record.ability)
    candidates = (
        share_by_metric.get(metric, EMPTY_SHARE)
        for metric in declared.overview_headings
        if metric in declared.yes_no_metrics
    )
    share = next((share for share in candidates if share.denominator), None)
    if share is None:
        return None
    yes_no = (0, share.denominator)
    if share.numerator in yes_no:
        return bool(share.numerator)
    return find_answer_outcome(record) is AnswerOutcome.SUCCESS


def _count_right_wrong_and_missing_items(ability: Ability, share_by_metric: ShareByMetric) -> dict[str, int]:
    """Return the numbers of right, wrong and missing items that an answer adds to precision and recall."""
    for metric in get_declaration(ability).overview_headings:
        prefix, dot, measure = metric.rpartition(".")
        if dot and measure == "f1" and share_by_metric:
            hits, stated = share_by_metric[f"{prefix}.precision"]
            _, expected = share_by_metric[f"{prefix}.recall"]
            return {"hits": int(hits), "extras": int(stated - hits), "misses": int(expected - hits)}
    return {}


def _read_task_features(record: Record, task_lookup: TaskLookup | None) -> Mapping[str, int | str | None]:
    """Return the features of a record's task from the data set; features in the record replace them."""
    features = {} if task_lookup is None else task_lookup.features(record.task_id)
    if record.task is None:
        return features
    return {**features, "annotated_steps": record.task.annotated_steps, "goals": record.task.goals}


def _make_step_lines(record: Record, key: IdentifyingColumns) -> Iterator[PlanStepTableLine]:
    if not _has_plans(record):
        return
    for number, step in list_reported_steps(record):
        call = step.call
        yield PlanStepTableLine(
            **key,
            step=number,
            operator=call.name,
            objects=" ".join(call.arguments or ()),
            outcome=step.outcome,
            reason=step.reason,
        )


def _make_goal_lines(record: Record, key: IdentifyingColumns) -> Iterator[TaskGoalTableLine]:
    if not isinstance(record.verdict, PlanVerdict):
        return
    for number, (report, satisfied) in enumerate(list_goals_and_whether_reached(record)):
        names = " ".join(report.predicates)
        yield TaskGoalTableLine(
            **key, goal=number, kind=report.kind, text=report.goal, predicates=names, satisfied=satisfied
        )


def _make_interpreted_goal_lines(
    record: Record, key: IdentifyingColumns, task_lookup: TaskLookup | None
) -> Iterator[InterpretedGoalTableLine]:
    if record.ability is not Ability.GOAL_INTERPRETATION:
        return
    verdict = cast("GoalVerdict", record.verdict)
    for status in ("matched", "wrong", "missing"):
        for atom in getattr(verdict, status):
            call = (
                parse_statement(atom)
                if record.explanation is None
                else record.explanation.get_atom_or_action(atom)
            )
            reason = (
                task_lookup.reason(record.task_id, call)
                if status == "wrong" and task_lookup is not None
                else None
            )
            yield InterpretedGoalTableLine(
                **key, verdict=status, atom=atom, predicate=call.name, positive=call.positive, reason=reason
            )


def _make_clause_lines(record: Record, key: IdentifyingColumns) -> Iterator[OperatorClauseTableLine]:
    if not get_declaration(record.ability).interaction.uses_operator_tasks:
        return
    from eai.abilities.transition_modeling.verdict import OTHER

    verdict = cast("OperatorVerdict", record.verdict)
    for report in verdict.operators:
        line = partial(OperatorClauseTableLine, **key, operator=report.name, status=report.status.value)
        for side in ("precondition", "effect"):
            for status in ("matched", "additional", "missing"):
                for clause in getattr(getattr(report, side), status):
                    names, kinds = verdict.clauses[clause]
                    yield line(
                        side=side,
                        verdict=status,
                        clause=clause,
                        predicates=" ".join(names),
                        categories=" ".join(kind for kind in kinds if kind != OTHER),
                    )
