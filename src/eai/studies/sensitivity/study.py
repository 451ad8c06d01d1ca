"""Find the operators that break plans (paper, "Sensitivity analysis" of transition modeling).

For each task, one gold operator (of the data set) at a time is replaced by the answer's operator, and a
planner tries to solve the problem. Solved tasks are counted by operator and by category of the task, out of
all tasks that ask for the operator. A missing operator counts as a failure.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import astuple, dataclass, fields, replace
from functools import cache, partial
from itertools import product
from typing import Annotated, get_args

from pydantic import BeforeValidator

from eai.abilities.protocol import Ability
from eai.abilities.transition_modeling.rules import ReplacedPart
from eai.abilities.transition_modeling.scorer import TransitionModelingScorer
from eai.abilities.transition_modeling.verdict import OperatorVerdict
from eai.abilities.verdict import make_rate_contribution_of_answer
from eai.base.errors import InputError
from eai.base.grouping import group_pairs
from eai.benchmarks.suite import open_suite
from eai.pddl.planning import PlannerChoice, PlannerOutcome
from eai.results.certainty import TaskRateContribution
from eai.results.lines import (
    MODEL,
    SUITE,
    TidyTableLine,
    group_by_model,
    group_by_suite,
    make_task_rate_contribution,
)
from eai.results.plots import draw_rate_matrix, get_numerator_of_cell, group_rows_by_suite
from eai.results.record import Record
from eai.results.table import Estimate, Row, Table, collect_rows_in_table
from eai.results.tidy import make_identifying_columns
from eai.studies.records import StudyRecords
from eai.studies.study import (
    Analysis,
    Figures,
    Study,
    make_file_name_and_titled_suite_figure,
    split_option_at_commas,
)
from eai.tasks.options import Options
from eai.tasks.source import Source
from eai.tasks.task import PredicateCategory

OVERALL = "overall"
"""Name of the category of tasks that contains all tasks."""

NOT_WRITTEN = "not_written"
"""Outcome for an operator that the task asks for and the answer lacks."""

_SOLVED = PlannerOutcome.SOLVED.value
_OUTCOMES = (*(o.value for o in PlannerOutcome if o is not PlannerOutcome.NOT_RUN), NOT_WRITTEN)


@dataclass(frozen=True, slots=True, kw_only=True)
class OperatorReplacementTrial(TidyTableLine):
    """The outcome of planning with gold operators, one of which is replaced by an answer's operator.

    Attributes:
        replaced: the replaced part: the whole gold operator, its precondition or its effect.
        operator: name of the operator.
        outcome: the planner's outcome (`PlannerOutcome`), or `NOT_WRITTEN`.
        categories: categories of the task, separated by blanks.
        errors: errors of the operator, as ``side:verdict:predicate``, separated by blanks. The side is
            precondition or effect, the verdict missing or additional. Equal errors are listed once.
    """

    replaced: str
    operator: str
    outcome: str
    categories: str
    errors: str


def generate_operator_replacement_trials(
    records: Sequence[Record],
    source: Source,
    replaced_parts: Sequence[ReplacedPart],
    report_done: Callable[[int], None],
) -> Iterator[OperatorReplacementTrial]:
    """Yield the results of planning with one gold operator replaced by the operator of a record.

    Records are stored verdicts on answers. Each suite is opened only once, so that the planner is called only
    once for equal operators of several models.
    """
    opened = cache(partial(open_suite, ability=Ability.TRANSITION_MODELING, source=source))
    for number, record in enumerate(records, 1):
        scorer = opened(record.domain, protocol=record.protocol).scorer(record.task_id)
        if isinstance(scorer, TransitionModelingScorer):
            for replaced in replaced_parts:
                yield from replace_gold_operators_one_by_one(scorer, record, replaced)
        report_done(number)


def replace_gold_operators_one_by_one(
    scorer: TransitionModelingScorer, record: Record, replaced: ReplacedPart = "operator"
) -> Iterator[OperatorReplacementTrial]:
    """Yield a trial for each operator that a task asks for: planning with the answer's operator.

    All other operators are gold operators. ``replaced`` is the part of the gold operator that the answer
    replaces. An answer that counts in no rate has no trials. A missing answer has no operators, so all of its
    trials fail.
    """
    errors = _map_operators_to_errors_in_replaced_part(record, replaced)
    results = scorer.plan_with_each_operator_of_answer(record.response, replaced)
    if record.unanswered is not None:
        results = dict.fromkeys(scorer.task.operators)
    for operator, result in results.items():
        yield OperatorReplacementTrial(
            **make_identifying_columns(record),
            replaced=replaced,
            operator=operator,
            outcome=NOT_WRITTEN if result is None else result.outcome.value,
            categories=" ".join(category.value for category in scorer.task.categories),
            errors=" ".join(errors.get(operator, ())),
        )


def _map_operators_to_errors_in_replaced_part(
    record: Record, replaced: ReplacedPart
) -> dict[str, tuple[str, ...]]:
    """Return a mapping from each operator of an answer to its errors, as texts.

    ``replaced`` is the part of the gold operator that a trial replaces by the answer's: precondition, effect,
    or both. Only errors in this part are listed.
    """
    if not isinstance(record.verdict, OperatorVerdict):
        return {}
    sides = [side for side in ("precondition", "effect") if replaced in (side, "operator")]
    return {
        report.name: tuple(
            dict.fromkeys(
                f"{side}:{verdict}:{predicate}"
                for side in sides
                for verdict in ("missing", "additional")
                for clause in getattr(getattr(report, side), verdict)
                for predicate in record.verdict.clauses[clause].predicates
            )
        )
        for report in record.verdict.operators
    }


def make_operator_sensitivity_tables(trials: Sequence[OperatorReplacementTrial]) -> list[Table]:
    """Return the tables that show which operators, as answers define them, break plans."""
    return [
        _make_solved_tasks_by_operator_table(trials),
        _make_outcomes_table(trials),
        _make_errors_table(trials),
        _make_trials_table(trials),
    ]


def group_successes_by_operator_and_category(
    trials: Iterable[OperatorReplacementTrial],
) -> dict[tuple[str, str], list[TaskRateContribution]]:
    """Return a mapping from operator and category of tasks to the successes and failures of trials.

    For each operator, the category `OVERALL` comes first.
    """
    return group_pairs(
        (
            (trial.operator, category),
            make_task_rate_contribution(trial, make_rate_contribution_of_answer(trial.outcome == _SOLVED)),
        )
        for trial in trials
        for category in (OVERALL, *trial.categories.split())
    )


def _group_trials_by_replaced_part(
    trials: Sequence[OperatorReplacementTrial],
) -> Iterator[tuple[tuple[str, ...], list[OperatorReplacementTrial], list[str]]]:
    """Group trials by suite, model and replaced part of the gold operator (such as its precondition).

    Yield for each group the key, the trials, and the names of all operators in trials of the suite. The names
    are sorted by the share of solved trials in the suite, lowest first.
    """
    for suite, lines in group_by_suite(trials).items():
        tried = Counter(trial.operator for trial in lines)
        solved = Counter(trial.operator for trial in lines if trial.outcome == _SOLVED)
        order = sorted(tried, key=lambda name: (solved[name] / tried[name], name))
        for model, of_model in group_by_model(lines).items():
            for replaced in get_args(ReplacedPart):
                of_part = [trial for trial in of_model if trial.replaced == replaced]
                if of_part:
                    yield (*suite, model, replaced), of_part, order


_KEY = (*SUITE, MODEL, "replaced")


@collect_rows_in_table("sensitivity", (*_KEY, "operator", "category", "solved"))
def _make_solved_tasks_by_operator_table(trials: Sequence[OperatorReplacementTrial]) -> Iterator[Row]:
    """Tasks solved with one operator of the model.

    solved: percentage of the tasks that a planner solves with the model's operator, out of all tasks that ask
    for this operator. All other operators come from the data set. Under protocol strict they are the
    operators that the task asks for, under eai-1.0.5 all operators of the benchmark. A missing operator
    solves no task. replaced: the part that comes from the model: the whole operator, or only its precondition
    or effect, with parameters from the data set. A task counts in each of its categories. Operators that
    break most plans come first. Intervals count all tasks of one name as one unit.
    """
    categories = (OVERALL, *(category.value for category in PredicateCategory))
    for key, of_key, order in _group_trials_by_replaced_part(trials):
        cells = group_successes_by_operator_and_category(of_key)
        for cell in product(order, categories):
            if cell in cells:
                yield (*key, *cell, Estimate.from_task_rate_contributions(cells[cell]))


@collect_rows_in_table("outcomes", (*_KEY, "operator", *_OUTCOMES))
def _make_outcomes_table(trials: Sequence[OperatorReplacementTrial]) -> Iterator[Row]:
    """How trials ended.

    Trials of each operator by the planner's result: a plan, no plan, an operator that is not acceptable PDDL,
    a limit that was reached, or an operator that the answer does not have.
    """
    for key, of_key, order in _group_trials_by_replaced_part(trials):
        counts = Counter((trial.operator, trial.outcome) for trial in of_key)
        for name in order:
            row = [counts[name, outcome] for outcome in _OUTCOMES]
            if any(row):
                yield (*key, name, *row)


@collect_rows_in_table(
    "errors",
    (*_KEY, "operator", "side", "verdict", "predicate", "unsolved_with", "unsolved_without"),
    max_shown_rows=20,
)
def _make_errors_table(trials: Sequence[OperatorReplacementTrial]) -> Iterator[Row]:
    """Which error breaks plans.

    An error is a predicate that is missing or additional (verdict) in an operator's precondition or effect
    (side). unsolved_with: percentage of tasks that are not solved with operators that have the error.
    unsolved_without: this percentage for operators of the same name without the error. Errors often occur
    together, so an error with many failures is not always their cause. Errors with most failures come first.
    """
    for key, of_key, order in _group_trials_by_replaced_part(
        [trial for trial in trials if trial.outcome != NOT_WRITTEN]
    ):
        of_operators = group_pairs((trial.operator, trial) for trial in of_key)
        rows = [(name, *row) for name in order for row in _make_error_rows(of_operators.get(name, ()))]
        yield from [(*key, *row) for row in sorted(rows, key=lambda row: -get_numerator_of_cell(row[-2]))]


def _make_error_rows(trials: Sequence[OperatorReplacementTrial]) -> Iterator[Row]:
    """Yield each error of an operator, most frequent first, with the failure rates with and without it."""
    errors = [frozenset(trial.errors.split()) for trial in trials]
    cases = [
        make_task_rate_contribution(trial, make_rate_contribution_of_answer(trial.outcome != _SOLVED))
        for trial in trials
    ]
    counts = Counter(error for of_trial in errors for error in of_trial)
    for error in sorted(counts, key=lambda error: (-counts[error], error)):
        split = list(zip(cases, errors, strict=True))
        yield (
            *error.split(":", 2),
            Estimate.from_task_rate_contributions([case for case, of_trial in split if error in of_trial]),
            Estimate.from_task_rate_contributions(
                [case for case, of_trial in split if error not in of_trial]
            ),
        )


@collect_rows_in_table(
    "trials", tuple([column.name for column in fields(OperatorReplacementTrial)]), max_shown_rows=0
)
def _make_trials_table(trials: Sequence[OperatorReplacementTrial]) -> Iterable[Row]:
    """Every trial.

    One line for each operator of an answer: how the planner ended, the categories of the task, and the errors
    of the operator. An error is written as ``side:verdict:predicate``, where the side is precondition or
    effect, and the verdict missing or additional.
    """
    return map(astuple, trials)


class _SensitivityAnalysisOptions(Options):
    """Options of the analysis that puts one operator of an answer among gold operators, and plans with them.

    Attributes:
        replace: The replaced part of a gold operator: operator, precondition or effect; several with commas.
        planner: The planner: auto, fast_downward or built_in.
    """

    replace: Annotated[tuple[ReplacedPart, ...], BeforeValidator(split_option_at_commas)] = ("operator",)
    planner: PlannerChoice = PlannerChoice.AUTO


def _analyze_operator_sensitivity(
    records: StudyRecords, chosen: _SensitivityAnalysisOptions
) -> Iterator[Analysis]:
    """Replace one gold operator at a time by a model's operator, and plan. This takes minutes for a model.

    Raises:
        InputError: there are no operators, or no planner is chosen.
    """
    if chosen.planner is PlannerChoice.NONE:
        raise InputError("planner=none: this analysis tries operators with a planner; give another planner")
    runs = [run for run in records.read_runs() if run.key.ability is Ability.TRANSITION_MODELING]
    answers = [record for run in runs for record in run.records]
    if not answers:
        raise InputError("the records have no answers to transition modeling; choose runs of this ability")
    replaced_parts = tuple(dict.fromkeys(chosen.replace))
    source = replace(records.source, planner=chosen.planner)
    with records.progress("trying operators", len(answers)) as done:
        tables = make_operator_sensitivity_tables(
            list(generate_operator_replacement_trials(answers, source, replaced_parts, done))
        )
    yield Analysis(tables, _draw_percent_solved_by_operator_figures(tables, replaced_parts))


def _draw_percent_solved_by_operator_figures(
    tables: Sequence[Table], replaced_parts: Sequence[ReplacedPart]
) -> Figures:
    for suite, rows in group_rows_by_suite(tables[0]).items():
        for replaced in replaced_parts:
            of_part = [row for row in rows if row["replaced"] == replaced]
            label = f"percent solved with the model's {replaced}"
            shown = [row for row in of_part if row["category"] == OVERALL]
            models = draw_rate_matrix(shown, ("operator",), "solved", label, shows_zero_rates=True)
            yield make_file_name_and_titled_suite_figure(suite, replaced, models)
            shown = [row for row in of_part if row["model"] == of_part[0]["model"]]
            categories = draw_rate_matrix(
                shown, ("operator",), "solved", label, other_axis_column="category", shows_zero_rates=True
            )
            yield make_file_name_and_titled_suite_figure(suite, f"{replaced}-categories", categories)


SENSITIVITY = Study(
    "sensitivity",
    "Each operator of the answers alone among gold operators: which one breaks plans (transition modeling).",
    choices=_SensitivityAnalysisOptions,
    analyze=_analyze_operator_sensitivity,
)
