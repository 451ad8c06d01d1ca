"""Sort errors by the paper's taxonomy, and count the preconditions that plans overlook."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple
from urllib.parse import quote, urlencode

from pydantic import Field

from eai.abilities.declaration import RUNTIME_FAULTS, AnswerOutcome
from eai.abilities.experiment import SEPARATOR, Experiment
from eai.abilities.verdict import make_rate_contribution_of_answer
from eai.base.errors import InputError
from eai.base.grouping import group_pairs
from eai.results.certainty import TaskRateContribution
from eai.results.lines import (
    MODEL,
    SUITE,
    AnswerTableLine,
    OperatorClauseTableLine,
    estimate_share_of_each_kind,
    group_by_model,
    group_by_run,
    group_by_suite,
    make_task_rate_contribution,
)
from eai.results.plots import (
    COLUMN,
    INK,
    MUTED,
    OUTCOME_COLORS,
    clip_label,
    draw_flow_band,
    draw_rate_matrix,
    draw_rates_by_name,
    get_denominator_of_cell,
    get_value_of_cell,
    group_rows_by_suite,
    make_figure,
)
from eai.results.table import Cell, Estimate, Row, Table, TextCell, collect_rows_in_table
from eai.studies.errors.overview import draw_sankey_diagrams_of_outcomes, make_outcome_counts_table
from eai.studies.records import StudyRecords
from eai.studies.study import Analysis, Figures, Study, make_file_name_and_titled_suite_figure
from eai.tasks.options import Options
from eai.tasks.share import Share

if TYPE_CHECKING:
    from matplotlib.figure import Figure


_KINDS = ("state", "relation", "action")
_VERDICTS = ("matched", "additional", "missing")


class _ErrorCategory(NamedTuple):
    """A leaf of the paper's taxonomy of errors: the stage at which an answer fails, the kind, and a detail.

    The stages are the check of the answer's grammar, its execution, and the check of its goals.
    """

    stage: str
    kind: str = ""
    detail: str = ""


def find_error_category(answer: AnswerTableLine) -> _ErrorCategory:
    """Return the leaf of the paper's taxonomy of errors to which an answer belongs: exactly one."""
    match AnswerOutcome(answer.outcome):
        case AnswerOutcome.PARSING:
            return _ErrorCategory("grammar", answer.outcome, answer.error_check or "")
        case AnswerOutcome.ARGUMENT_NUMBER:
            return _ErrorCategory("grammar", answer.outcome)
        case AnswerOutcome.HALLUCINATION:
            unknown = (answer.error_check or "").removeprefix("unknown_")
            return _ErrorCategory("grammar", answer.outcome, unknown)
        case AnswerOutcome.GOAL_MISSED if answer.executable:
            return _ErrorCategory("goal", answer.outcome, "+".join(_list_unmet_goal_kinds(answer)))
        case _ if answer.outcome in RUNTIME_FAULTS:
            return _ErrorCategory("runtime", answer.outcome)
        case _:
            return _ErrorCategory(answer.outcome)


def _list_unmet_goal_kinds(answer: AnswerTableLine) -> Iterator[str]:
    for kind in _KINDS:
        met, total = getattr(answer, f"{kind}_met"), getattr(answer, f"{kind}_total")
        if met is not None and met < total:
            yield kind


def make_error_tables(
    answers: Sequence[AnswerTableLine],
    clauses: Sequence[OperatorClauseTableLine],
    *,
    examples: int,
    explorer: str | None,
) -> list[Table]:
    """Return the tables that count errors of answers and of operators.

    Args:
        answers: the answers, one line each.
        clauses: the clauses (conditions and effects) of operators that are right, wrong or missing.
        examples: number of example answers for each kind of error and suite.
        explorer: address of an explorer page of the same records, to which examples link; None for no links.
    """
    counted = [answer for answer in answers if answer.outcome != AnswerOutcome.EXCLUDED.value]
    return [
        _make_outcomes_table(counted),
        _make_failed_checks_table(counted),
        _make_unnecessary_steps_table(counted),
        _make_clauses_table(clauses),
        _make_predicates_table(clauses),
        _make_examples_table(counted, examples, explorer),
        _make_errors_table(counted),
        make_outcome_counts_table(counted),
    ]


@collect_rows_in_table("leaves", (*SUITE, MODEL, *_ErrorCategory._fields, "answers"))
def _make_outcomes_table(answers: Sequence[AnswerTableLine]) -> Iterator[Row]:
    """Outcomes of answers.

    Each answer belongs to one leaf of the paper's taxonomy: that of the error that ended the answer. Answers
    at each leaf are in percent of all answers but excluded ones. For a missed goal, the detail names the
    kinds of goals that are not reached.
    """
    for suite, of_suite in group_by_suite(answers).items():
        leaves = sorted({find_error_category(answer) for answer in of_suite}, key=_make_category_sort_key)
        for model, lines in group_by_model(of_suite).items():
            shares = estimate_share_of_each_kind(lines, [find_error_category(line) for line in lines], leaves)
            yield from [(*suite, model, *leaf, share) for leaf, share in shares]


_STAGES = ("success", "partly_right", "goal", "goal_missed", "grammar", "runtime")


def _make_category_sort_key(leaf: _ErrorCategory) -> tuple[int, _ErrorCategory]:
    return (_STAGES.index(leaf.stage) if leaf.stage in _STAGES else len(_STAGES), leaf)


@collect_rows_in_table("why", (*SUITE, MODEL, "check", "share"), max_shown_rows=15)
def _make_failed_checks_table(answers: Sequence[AnswerTableLine]) -> Iterator[Row]:
    """Which precondition is overlooked.

    Runtime errors (affordance, missing step, wrong order) by the precondition that was checked and did not
    hold, in percent of the model's runtime errors in the suite.
    """
    for key, lines in group_by_run([a for a in answers if a.outcome in RUNTIME_FAULTS]):
        checks = [line.error_check or "" for line in lines]
        times = Counter(checks)
        shares = estimate_share_of_each_kind(
            lines, checks, sorted(times, key=lambda check: (-times[check], check))
        )
        yield from [(*key, check, share) for check, share in shares]


@collect_rows_in_table("additional", (*SUITE, MODEL, "answers", "steps"))
def _make_unnecessary_steps_table(answers: Sequence[AnswerTableLine]) -> Iterator[Row]:
    """Additional steps.

    Answers with at least one unnecessary step, in percent, and the number of unnecessary steps. An
    unnecessary step does not end a plan, so the table of outcomes counts these answers by their other errors,
    or as right.
    """
    for key, lines in group_by_run([a for a in answers if a.additional_steps is not None]):
        cases = [
            make_task_rate_contribution(line, make_rate_contribution_of_answer(bool(line.additional_steps)))
            for line in lines
        ]
        yield (
            *key,
            Estimate.from_task_rate_contributions(cases),
            sum(a.additional_steps or 0 for a in lines),
        )


@collect_rows_in_table("clauses", (*SUITE, MODEL, "side", "category", *_VERDICTS, "written"))
def _make_clauses_table(clauses: Sequence[OperatorClauseTableLine]) -> Iterator[Row]:
    """Clauses of operators that are right, wrong or missing.

    Clauses (conditions and effects) by side (precondition or effect) and category. matched: right clauses in
    answers. additional: wrong clauses in answers. missing: right clauses that answers lack. written: number
    of clauses in answers for each hundred clauses of the data set's own operators. Above 100, the model
    states too much, and below 100 too little.
    """
    for key, lines in group_by_run(clauses):
        groups = group_pairs(
            ((line.side, category), line) for line in lines for category in line.categories.split()
        )
        for side_and_category, of_group in sorted(groups.items()):
            counts = [sum(line.verdict == verdict for line in of_group) for verdict in _VERDICTS]
            yield (*key, *side_and_category, *counts, _estimate_clause_count_ratio_to_gold(of_group))


def _estimate_clause_count_ratio_to_gold(lines: Iterable[OperatorClauseTableLine]) -> Estimate:
    """Return the number of clauses in answers, in percent of the number in the data set's operators."""
    by_task = group_pairs(((line.task, line.name), line.verdict) for line in lines)
    cases = []
    for (task, name), verdicts in by_task.items():
        written, gold = (len(verdicts) - verdicts.count(left_out) for left_out in ("missing", "additional"))
        cases.append(TaskRateContribution(task, name, Share(written, gold)))
    return Estimate.from_task_rate_contributions(cases)


@collect_rows_in_table(
    "predicates", (*SUITE, MODEL, "side", "verdict", "predicate", "clauses"), max_shown_rows=12
)
def _make_predicates_table(clauses: Sequence[OperatorClauseTableLine]) -> Iterator[Row]:
    """Predicates in wrong and missing clauses of operators.

    Clauses (conditions and effects) that answers lack or state wrongly, counted by the predicates in them.
    """
    for key, lines in group_by_run([c for c in clauses if c.verdict != "matched"]):
        counts = Counter(
            (line.side, line.verdict, name) for line in lines for name in line.predicates.split()
        )
        ordered = sorted(counts.items(), key=lambda pair: (-pair[1], pair[0]))
        yield from [(*key, *cells, count) for cells, count in ordered]


@collect_rows_in_table(
    "examples", (*SUITE, *_ErrorCategory._fields, "answered_by", "task", "check", "objects")
)
def _make_examples_table(
    answers: Sequence[AnswerTableLine], number: int, explorer: str | None
) -> Iterator[Row]:
    """Examples.

    The first answers of each kind of error, in the order of the records. `eai explain` shows such an answer
    step by step.
    """
    for suite, of_suite in group_by_suite(answers).items():
        by_leaf = group_pairs((find_error_category(answer), answer) for answer in of_suite)
        for leaf in sorted(by_leaf, key=_make_category_sort_key):
            yield from [
                (
                    *suite,
                    *leaf,
                    a.model_harness_and_effort,
                    _link_task_to_explorer(a, explorer),
                    a.error_check,
                    a.error_objects,
                )
                for a in by_leaf[leaf][:number]
            ]


def _link_task_to_explorer(answer: AnswerTableLine, explorer_address: str | None) -> Cell:
    """Return a task's id with a link to its answer in an explorer. ``explorer/state.js`` reads the link."""
    if explorer_address is None:
        return answer.task
    agent = Experiment(harness=answer.harness, effort=answer.effort).label
    options = SEPARATOR.join(filter(None, (answer.experiment, agent)))
    name = f"{answer.model}, {options}" if options else answer.model
    run = "/".join((answer.domain, answer.ability, answer.protocol, name))
    return TextCell(answer.task, f"{explorer_address}#{urlencode({'run': run, 'task': answer.task})}")


@collect_rows_in_table(
    "errors",
    (*SUITE, MODEL, "task", "name", *_ErrorCategory._fields, "check", "objects", "step", "annotated_steps"),
    max_shown_rows=0,
)
def _make_errors_table(answers: Sequence[AnswerTableLine]) -> Iterator[Row]:
    """Every error.

    One line for each answer that an error ended: its leaf of the taxonomy, the failed check, the objects, the
    number of the step (from 0), and the number of steps of the data set's own plan.
    """
    for answer in answers:
        if answer.error_kind is not None:
            key = (
                answer.protocol,
                answer.domain,
                answer.ability,
                answer.model_harness_and_effort,
                answer.task,
                answer.name,
            )
            of_error = (answer.error_check, answer.error_objects, answer.error_step)
            yield (*key, *find_error_category(answer), *of_error, answer.annotated_steps)


class _ErrorAnalysisOptions(Options):
    """How many examples the tables of errors show, and to which page they link.

    Attributes:
        examples: Number of example answers of each kind.
        explorer: An explorer.html by eai report, to which examples link.
    """

    examples: int = Field(default=3, ge=0)
    explorer: Path | None = None


def _analyze_errors(records: StudyRecords, chosen: _ErrorAnalysisOptions) -> Iterator[Analysis]:
    explorer = _make_relative_link_to_explorer_page(chosen.explorer, records.folder)
    tidy = records.make_tidy_tables_of_comparable_runs(features=False)
    tables = make_error_tables(tidy.answers, tidy.clauses, examples=chosen.examples, explorer=explorer)
    yield Analysis(tables, _draw_error_figures(tables))


def _make_relative_link_to_explorer_page(explorer: Path | None, folder: Path) -> str | None:
    """Return the address of an explorer page, relative to a folder.

    Raises:
        InputError: the file does not exist.
    """
    if explorer is None:
        return None
    if not explorer.is_file():
        raise InputError(f"explorer={explorer}: no such file; eai report writes explorer.html")
    return quote(Path(os.path.relpath(explorer, folder)).as_posix())


def _draw_error_figures(tables: Sequence[Table]) -> Figures:
    leaves, checks = tables[:2]
    yield from draw_sankey_diagrams_of_outcomes(tables[-1])
    for suite, rows in group_rows_by_suite(leaves).items():
        yield make_file_name_and_titled_suite_figure(suite, "flow", draw_answer_outcomes(rows))
        levels = ("stage", "kind", "detail")
        yield make_file_name_and_titled_suite_figure(
            suite, "leaves", draw_rate_matrix(rows, levels, "answers", "percent of answers")
        )
    for suite, rows in group_rows_by_suite(checks).items():
        yield make_file_name_and_titled_suite_figure(
            suite, "why", draw_rates_by_name(rows, "check", "share", "share of runtime errors")
        )


_GAP = 4.0
"""Distance between two bars of the figure, in percent of all answers."""

_MIN_NAMED_PERCENT = 0.5
"""Minimum share of a kind of error, in percent of all answers, for a label in the figure."""

_LINE = 5.6
"""Height of a line of text, in units of the vertical axis (percent of all answers)."""

_COLORS: Mapping[str, str] = {
    "success": OUTCOME_COLORS[AnswerOutcome.SUCCESS],
    "grammar": OUTCOME_COLORS[AnswerOutcome.PARSING],
    "runtime": OUTCOME_COLORS[AnswerOutcome.MISSING_STEP],
    "goal": OUTCOME_COLORS[AnswerOutcome.GOAL_MISSED],
}


def draw_answer_outcomes(rows: Sequence[Mapping[str, Cell]]) -> Figure | None:
    """Draw the share of answers with each outcome, over all models of a suite; None without answers.

    Args:
        rows: the rows of one suite in the table `leaves` (shares of answers by outcome).
    """
    first = rows[0]["model"] if rows else None
    cells = {
        _read_error_stage_and_label_from_row(row): row["answers"] for row in rows if row["model"] == first
    }
    shares = {leaf: get_value_of_cell(cell) for leaf, cell in cells.items()}
    shares = {leaf: share for leaf, share in shares.items() if share > 0}
    if not shares:
        return None
    stages = list(dict.fromkeys(stage for stage, _ in shares))
    named = [leaf for leaf, share in shares.items() if share >= _MIN_NAMED_PERCENT]
    figure = make_figure(COLUMN, 1.2 + 0.13 * len(named))
    panel = figure.subplots()
    panel.set_axis_off()
    answers = max(map(get_denominator_of_cell, cells.values()))
    panel.set_title(f"{clip_label(str(first))}, percent of {answers:,} answers", fontsize=7.5)
    top, stage_top, text_top = 100.0, 100.0 + _GAP * (len(stages) - 1) / 2, 104.0
    for stage in stages:
        leaves = {leaf: share for leaf, share in shares.items() if leaf[0] == stage}
        whole, color = sum(leaves.values()), _COLORS.get(stage, MUTED)
        draw_flow_band(panel, 0, (top - whole, stage_top - whole, whole), color)
        at = stage_top
        for leaf, share in leaves.items():
            middle = at - share / 2
            panel.fill_between([1, 1.12], at - share, at, facecolor=color, edgecolor="white", linewidth=0.5)
            if share >= _MIN_NAMED_PERCENT:
                name = leaf[1] or stage.replace("_", " ")
                text_top = min(middle, text_top - _LINE)
                panel.plot([1.12, 1.2], [middle, text_top], color=MUTED, linewidth=0.6)
                panel.text(1.22, text_top, f"{name} {share:.1f}", fontsize=6.5, va="center", color=INK)
            at -= share
        top -= whole
        stage_top -= whole + _GAP
    panel.set_xlim(-0.02, 2.2)
    panel.set_ylim(min(stage_top, text_top) - _GAP, 104 + _GAP)
    return figure


def _read_error_stage_and_label_from_row(row: Mapping[str, Cell]) -> tuple[str, str]:
    parts = [str(row[level]).replace("_", " ") for level in ("kind", "detail") if row[level]]
    return str(row["stage"]), ": ".join(parts)


ERRORS = Study(
    "errors",
    "Errors by the paper's taxonomy, and which check failed how often.",
    choices=_ErrorAnalysisOptions,
    analyze=_analyze_errors,
    included_in_all=True,
)
