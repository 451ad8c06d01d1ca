"""Study goals that models state rightly, miss or invent (reporting bias; paper, "Goal interpretation")."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from typing import get_args

from eai.abilities.verdict import make_rate_contribution_of_answer
from eai.base.grouping import group_pairs
from eai.results.certainty import TaskRateContribution
from eai.results.lines import (
    MODEL,
    SUITE,
    InterpretedGoalTableLine,
    WrongGoalReason,
    estimate_share_of_each_kind,
    group_by_run,
    group_by_suite,
    make_task_rate_contribution,
)
from eai.results.plots import draw_rate_matrix, draw_rates_by_name, group_rows_by_suite
from eai.results.table import Estimate, Row, Table, collect_rows_in_table
from eai.studies.records import StudyRecords
from eai.studies.study import Analysis, Figures, Study, make_file_name_and_titled_suite_figure
from eai.tasks.options import Options

MATCHED, WRONG, MISSING = "matched", "wrong", "missing"
_VERDICTS = (MATCHED, WRONG, MISSING)


def _analyze_goals(records: StudyRecords, chosen: Options) -> Iterator[Analysis]:
    tables = make_goal_tables(records.make_tidy_tables_of_comparable_runs().atoms)
    yield Analysis(tables, _draw_goal_score_figures(tables))


def make_goal_tables(atoms: Sequence[InterpretedGoalTableLine]) -> list[Table]:
    """Return the tables that compare the goals in answers with the goals of tasks."""
    return [
        _make_predicates_table(atoms),
        _make_table_of_reasons_for_wrong_goals(atoms),
        _make_wrong_goals_table(atoms),
        _make_models_stating_or_missing_goal_table(atoms),
    ]


@collect_rows_in_table(
    "by_predicate", (*SUITE, MODEL, "predicate", *_VERDICTS, "precision", "recall"), max_shown_rows=30
)
def _make_predicates_table(atoms: Sequence[InterpretedGoalTableLine]) -> Iterator[Row]:
    """Goals by predicate.

    Conditions of the tasks that are stated (matched) or not stated (missing), and stated goals that no task
    has (wrong), by predicate or action. A negated goal counts for its predicate. Precision is the share of
    stated goals that are matched; recall is the share of conditions that are matched. Stated goals with
    unknown names are in neither share if the protocol ignores them.
    """
    for key, lines in group_by_run(atoms):
        names = group_pairs((line.predicate, line) for line in lines)
        wanted = {name: sum(line.verdict != WRONG for line in of_name) for name, of_name in names.items()}
        for name, of_name in sorted(names.items(), key=lambda pair: (-wanted[pair[0]], pair[0])):
            counts = Counter(line.verdict for line in of_name)
            yield (*key, name, *(counts[v] for v in _VERDICTS), *_estimate_precision_and_recall(of_name))


def _estimate_precision_and_recall(lines: Sequence[InterpretedGoalTableLine]) -> tuple[Estimate, Estimate]:
    return (
        Estimate.from_task_rate_contributions(
            [_score_goal_as_matched_or_not(line) for line in lines if line.verdict != MISSING]
        ),
        Estimate.from_task_rate_contributions(
            [_score_goal_as_matched_or_not(line) for line in lines if line.verdict != WRONG]
        ),
    )


def _score_goal_as_matched_or_not(line: InterpretedGoalTableLine) -> TaskRateContribution:
    return make_task_rate_contribution(line, make_rate_contribution_of_answer(line.verdict == MATCHED))


@collect_rows_in_table("reasons", (*SUITE, MODEL, "reason", "share"))
def _make_table_of_reasons_for_wrong_goals(atoms: Sequence[InterpretedGoalTableLine]) -> Iterator[Row]:
    """Where wrong goals come from.

    Wrong goals by the first of these reasons that fits, in percent of all wrong goals. unknown: the benchmark
    does not have the predicate or action; procedural: an action that is a goal of no task; initial: the goal
    holds at the start; final: it holds at the end of the data set's own plan, but is no condition of the
    task; intermediate: it holds only during the plan.
    """
    for key, lines in group_by_run([a for a in atoms if a.reason is not None]):
        reasons = [str(line.reason) for line in lines]
        shares = estimate_share_of_each_kind(lines, reasons, get_args(WrongGoalReason))
        yield from [(*key, reason, share) for reason, share in shares]


@collect_rows_in_table(
    "wrong", (*SUITE, MODEL, "predicate", "reason", "goals"), title="What is made up most", max_shown_rows=15
)
def _make_wrong_goals_table(atoms: Sequence[InterpretedGoalTableLine]) -> Iterator[Row]:
    """Wrong goals, the most frequent first.

    Wrong goals (stated in answers, but no goals of the task), counted by predicate or action and by reason.
    """
    for key, lines in group_by_run([a for a in atoms if a.verdict == WRONG]):
        counts = Counter((line.predicate, line.reason) for line in lines)
        for (predicate, reason), count in sorted(counts.items(), key=lambda pair: (-pair[1], str(pair[0]))):
            yield (*key, predicate, reason, count)


@collect_rows_in_table(
    "shared",
    (*SUITE, "task", "goal", *_VERDICTS, "models"),
    title="What many models do alike",
    max_shown_rows=15,
)
def _make_models_stating_or_missing_goal_table(atoms: Sequence[InterpretedGoalTableLine]) -> Iterator[Row]:
    """Goals, by how many models state or miss each.

    For each condition and each stated goal: how many models state it rightly, state it wrongly, or miss it,
    of all models with answers in the suite. Goals that most models miss or make up come first.
    """
    for suite, lines in group_by_suite(atoms).items():
        models = len({line.model_harness_and_effort for line in lines})
        rows = sorted(
            _count_models_right_wrong_missing_by_goal(lines),
            key=lambda row: (-row[3] - row[4], row[3], row[0], row[1]),
        )
        yield from [(*suite, *row, models) for row in rows]


def _count_models_right_wrong_missing_by_goal(
    lines: Sequence[InterpretedGoalTableLine],
) -> Iterator[tuple[str, str, int, int, int]]:
    """Yield for each goal: task, goal, and how many models state it rightly, state it wrongly or miss it."""
    by_goal = group_pairs(
        ((line.task, line.atom), (line.verdict, line.model_harness_and_effort)) for line in lines
    )
    for (task, goal), pairs in by_goal.items():
        right, wrong, missing = (len({a for v, a in pairs if v == verdict}) for verdict in _VERDICTS)
        yield task, goal, right, wrong, missing


def _draw_goal_score_figures(tables: Sequence[Table]) -> Figures:
    by_predicate, reasons = tables[:2]
    for suite, rows in group_rows_by_suite(by_predicate).items():
        for score in ("precision", "recall"):
            yield make_file_name_and_titled_suite_figure(
                suite, score, draw_rates_by_name(rows, "predicate", score, score)
            )
    for suite, rows in group_rows_by_suite(reasons).items():
        yield make_file_name_and_titled_suite_figure(
            suite, "reasons", draw_rate_matrix(rows, ("reason",), "share", "percent of wrong goals")
        )


GOALS = Study(
    "goals",
    "Goal interpretation by predicate: found, missed and made up, and where wrong goals come from.",
    analyze=_analyze_goals,
    included_in_all=True,
)
