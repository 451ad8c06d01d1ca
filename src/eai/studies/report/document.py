"""Write the report as one Markdown page: tables, certainty of main results, and agreement with the paper.

Certainty is shown by confidence intervals. They count all tasks with the same name as one unit, or each task
as one unit. Agreement is shown, cell by cell, by the difference between our rate and the paper's rate.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import groupby
from operator import itemgetter

from eai.abilities.declaration import AnswerOutcome, get_declaration, get_display_name
from eai.base.grouping import group_pairs
from eai.benchmarks.registry import get_title
from eai.results.certainty import Interval, TaskRateContributions, compute_mean_rate_over_task_names
from eai.results.markdown import escape_markdown, format_markdown_table, format_text_grid
from eai.results.model_cards import make_model_table
from eai.results.paper_tables import (
    PaperTable,
    map_files_to_paper_models,
    read_paper_protocol_and_tables,
    read_paper_table,
)
from eai.results.rate import NOTHING, Rate, compute_rate
from eai.results.repeats import find_success_metric, make_pass_at_k_table, strip_epoch
from eai.results.runs import RunKey
from eai.studies.report.rankings import Ranking
from eai.studies.report.run_summary import RunSummary, select_runs_with_standard_rules_and_no_study
from eai.studies.report.table_specs import format_suite_title

STRATA: Mapping[str, range] = {
    **{f"{steps[0]} to {steps[-1]} steps": steps for steps in map(range, (1, 4, 9, 17), (4, 9, 17, 33))},
    "33 steps or more": range(33, 1_000_000),
}
"""Ranges of the number of steps in annotated plans, by the label of the table's row."""

ROUNDING_DIFFERENCE = 0.056
"""Maximum difference from the paper that rounding explains, in percentage points.

The paper rounds to two digits, then to one."""


def compare_with_paper(runs: Sequence[RunSummary]) -> list[dict[str, str]]:
    """Return rows that compare our runs of the paper's models with each table of the paper.

    Compared runs use the paper's protocol and have the name of a published response file. Runs that
    answered too few tasks to be ranked are left out.
    """
    setting = read_paper_protocol_and_tables()
    ours = [
        item
        for item in runs
        if item.key.protocol.value == setting.protocol
        and item.key.model in map_files_to_paper_models()
        and item.coverage.is_complete_enough_for_ranking
    ]
    by_table = group_pairs(
        ((table.title, format_suite_title(item.key.domain, item.key.ability)), pair)
        for table in map(read_paper_table, setting.names_of_tables_with_all_models)
        for item in ours
        for pair in _list_differences_from_paper_rates(table, item)
    )
    return [_make_paper_agreement_row(table, suite, pairs) for (table, suite), pairs in by_table.items()]


def _make_paper_agreement_row(
    table: str, suite: str, differences_with_rate_texts: Sequence[tuple[float, str]]
) -> dict[str, str]:
    largest, where = max(differences_with_rate_texts, key=itemgetter(0))
    bounds = {"to the digit": ROUNDING_DIFFERENCE, "within 1": 1, "within 2": 2}
    return {
        "table": table,
        "suite": suite,
        "cells": str(len(differences_with_rate_texts)),
        **{
            label: str(sum(difference <= points + 1e-9 for difference, _ in differences_with_rate_texts))
            for label, points in bounds.items()
        },
        "largest": f"{largest:.1f}",
        "where": where,
    }


def _list_differences_from_paper_rates(table: PaperTable, summary: RunSummary) -> Iterator[tuple[float, str]]:
    """Yield each absolute difference between a rate and the paper's rate, and a text with both rates.

    Differences are in percentage points.
    """
    model = map_files_to_paper_models()[summary.key.model]
    for column in table.columns:
        if (column.ability, column.domain) == (summary.key.ability.value, summary.key.domain):
            printed, rate = table.find_printed_number(model, column), summary.rates.get(column.metric)
            if printed is not None and rate is not None and rate.percent is not None:
                named = f"{escape_markdown(summary.key.model)}, {escape_markdown(column.metric)}"
                yield abs(rate.percent - printed), f"{named}: {rate.percent:.1f} for {printed:.1f}"


_INTRODUCTION = """\
All numbers are in percent. Under each run stand its 95 % intervals; they treat tasks of one name as the near
copies that they are ([how sure the numbers are](#how-sure-the-numbers-are)). Bold is the best of a column. A
task without an answer counts as a failure, unless a footnote says otherwise; a run that leaves tasks out is
neither ranked nor in bold. Rows marked *floor* are null models: what is earned without deciding anything. A
protocol says what the numbers mean: `strict` is what the paper defines, `eai-1.0.5` gives the verdicts of the
reference package, defects included, and is the one to set beside published numbers. Each has tables of its
own."""
_OTHER_PAPER_TABLES = """\
The paper's tables of a few models, or of other ways to ask, in percent and in the paper's order. A run
stands above the paper's rows where it measures the same: under `eai-1.0.5`, each answer asked for once."""
_EXPERIMENTS = """\
Runs that did more than ask each question once: several attempts, actions that slip, goals of a model's own.
The plain run of the same model, if there is one, stands above them. What counts is the last attempt. Nothing
here is ranked or set beside single answers: whoever is asked more often succeeds more often."""
_AGREEMENT = """\
Runs under `eai-1.0.5` that have the name of a published response file, beside the paper's figures for that
model."""


def make_report_markdown(
    runs: Sequence[RunSummary],
    tables: Sequence[Ranking],
    experiments: Sequence[Ranking],
    other_paper_tables: Sequence[Ranking],
    cost: str,
    *,
    with_paper: bool,
) -> str:
    """Return the page as Markdown. The section on cost is added at the end if it is not empty."""
    plain = select_runs_with_standard_rules_and_no_study(runs)
    blocks = [
        "# Results\n",
        _INTRODUCTION + "\n",
        *_write_main_tables(tables),
        *_write_tables_section("Experiments", _EXPERIMENTS, experiments),
        *_write_tables_section("What the paper reports besides", _OTHER_PAPER_TABLES, other_paper_tables),
        *(_write_table_of_paper_models() if with_paper else ()),
        *_write_sections_by_plan_length_and_predicate(plain),
        *_write_section(
            "How sure the numbers are",
            _make_confidence_interval_rows(plain),
            _CERTAINTY,
            make_remark_on_missing_task_names(plain),
        ),
        *_write_epochs_section(runs),
        *_write_protocols_section(plain),
        *_write_section(
            "Against the paper, cell by cell", compare_with_paper(plain) if with_paper else (), _AGREEMENT
        ),
        *_write_outcomes_section(plain),
        *_write_runs_section(runs),
        *([cost] if cost else []),
    ]
    return "\n".join(blocks)


def _write_main_tables(tables: Sequence[Ranking]) -> Iterator[str]:
    for (protocol, domain), group in groupby(tables, key=lambda table: (table.protocol, table.domain)):
        yield f"## {get_title(domain)}, protocol {protocol.value}\n"
        for table in group:
            yield f"### {table.title}\n"
            yield format_markdown_table(table.make_table())


def _write_tables_section(title: str, introduction: str, tables: Sequence[Ranking]) -> Iterator[str]:
    """Yield the text of a section of tables.

    If tables of several protocols have the same title, their headings also name the protocol.
    """
    if tables:
        yield f"## {title}\n"
        yield f"{introduction}\n"
    for table in tables:
        protocols = [
            other.protocol for other in tables if (other.title, other.domain) == (table.title, table.domain)
        ]
        suffix = f", protocol {table.protocol.value}" if len(protocols) > 1 else ""
        yield f"### {table.title}, {get_title(table.domain)}{suffix}\n"
        yield format_markdown_table(table.make_table())


def _write_table_of_paper_models() -> Iterator[str]:
    cards = make_model_table()
    yield f"## {cards.title}\n"
    yield f"{cards.definition}\n"
    yield format_markdown_table(cards)


def _write_section(title: str, rows: Iterable[Mapping[str, str]], *paragraphs: str) -> Iterator[str]:
    """Yield the text of a section with paragraphs and a table; nothing if the table has no rows.

    Each row maps headings to cells.
    """
    written = list(rows)
    if written:
        yield f"## {title}\n"
        yield from (f"{paragraph}\n" for paragraph in paragraphs if paragraph)
        yield "\n".join(format_text_grid([*written[0]], [[*row.values()] for row in written])) + "\n"


def _write_epochs_section(runs: Sequence[RunSummary]) -> Iterator[str]:
    """Yield the section on runs with several answers per task: how often is one right, how often are all?"""
    groups = group_pairs(pair for item in runs for pair in _list_epoch_successes_with_run_key(item))
    if not groups:
        return
    table = make_pass_at_k_table(
        {f"{key.name}, {format_suite_title(key.domain, key.ability)}": cases for key, cases in groups.items()}
    )
    yield f"## {table.title}\n"
    yield f"{table.definition}.\n"
    yield format_markdown_table(table)


def _list_epoch_successes_with_run_key(summary: RunSummary) -> Iterator[tuple[RunKey, TaskRateContributions]]:
    """Yield the run's key and the successes of its answers, if the summary is that of an epoch.

    A run can ask every question several times. Each time is an epoch, which has a summary of its own. The
    key is without the epoch's number.
    """
    metric, model = find_success_metric(summary.key.ability), strip_epoch(summary.key.model)
    if metric is not None and model != summary.key.model:
        yield summary.key._replace(model=model), summary.cases.get(metric, ())


def _write_protocols_section(runs: Sequence[RunSummary]) -> Iterator[str]:
    """Yield the section on runs with scores under all protocols (sets of scoring rules) in the report."""
    by_key = {item.key: item for item in runs}
    used = {key.protocol for key in by_key}
    protocols = sorted(
        used, key=lambda item: (item.value != read_paper_protocol_and_tables().protocol, item.value)
    )
    rows = []
    for key in by_key:
        by_protocol = [by_key.get(key._replace(protocol=protocol)) for protocol in protocols]
        scored = [run for run in by_protocol if run is not None]
        if key.protocol is protocols[0] and len(scored) == len(protocols) > 1:
            answered = " ".join(dict.fromkeys(str(run.coverage) for run in scored))
            for metric in get_declaration(key.ability).overview_headings:
                row = {
                    "model": escape_markdown(key.name),
                    "suite": format_suite_title(key.domain, key.ability),
                }
                row |= {"answered": answered, "metric": get_display_name(metric)}
                row |= {
                    run.key.protocol.value: _format_percent(run.rates.get(metric, NOTHING).percent)
                    for run in scored
                }
                rows.append(row)
    yield from _write_section("Both protocols", rows)


def _write_outcomes_section(runs: Sequence[RunSummary]) -> Iterator[str]:
    kinds = [kind for kind in AnswerOutcome if any(kind in item.breakdown.outcomes for item in runs)]
    rows = (
        _make_model_and_suite_cells(item)
        | {get_display_name(kind.value): str(item.breakdown.outcomes.get(kind, "")) for kind in kinds}
        for item in runs
    )
    yield from _write_section("Outcomes of answers", rows)


def _write_sections_by_plan_length_and_predicate(runs: Sequence[RunSummary]) -> Iterator[str]:
    """Yield the sections on success by length of the annotated plan, and on goals by predicate."""
    for suite, items in group_pairs((_format_suite_and_protocol(item), item) for item in runs).items():
        if items[0].breakdown.flow is not None:
            names = [escape_markdown(item.key.name) for item in items]
            rows = [
                {"tasks or goals": label, **dict(zip(names, map(_format_rate, rates), strict=True))}
                for label, rates in (*_make_plan_length_rows(items), *_make_predicate_rows(items))
            ]
            yield from _write_section(f"By length of plan and kind of goal: {suite}", rows, _STRATA)


def _make_plan_length_rows(summaries: Sequence[RunSummary]) -> Iterator[tuple[str, list[Rate]]]:
    """Yield a row for each range of plan lengths, with the success of each run."""
    for label, steps in STRATA.items():
        shares = [
            [case.share for n, cases in summary.breakdown.by_length.items() if n in steps for case in cases]
            for summary in summaries
        ]
        if any(shares):
            yield f"plan of {label}", [*map(compute_rate, shares)]


def _make_predicate_rows(summaries: Sequence[RunSummary]) -> Iterator[tuple[str, list[Rate]]]:
    """Yield a row for each predicate, with the share of the predicate's goals that each run meets."""
    tables = [summary.breakdown.by_predicate for summary in summaries]
    for name in sorted({name for table in tables for name in table}):
        yield f"goals on {escape_markdown(name)}", [table.get(name, NOTHING) for table in tables]


def _format_rate(rate: Rate) -> str:
    if not rate.denominator:
        return "–"
    return f"{_format_percent(rate.percent)} ({round(rate.numerator, 1):g}/{rate.denominator:g})"


def _write_runs_section(runs: Sequence[RunSummary]) -> Iterator[str]:
    has_cut_answers = any(item.coverage.cut_off for item in runs)
    rows = [
        _make_model_and_suite_cells(item)
        | {
            "answered": str(item.coverage),
            **({"cut off": str(item.coverage.cut_off)} if has_cut_answers else {}),
            "excluded": str(sum(item.excluded.values())),
            "repaired": str(item.repaired),
            "planner": ", ".join(item.planners),
            "data": " ".join(digest[:12] for digest in item.data_sha256),
        }
        for item in runs
    ]
    yield from _write_section("Runs", rows)
    remarks = dict.fromkeys(
        f"{_format_suite_and_protocol(item)}, errata {item.errata.version}: {item.errata.remark_on_errata}"
        for item in runs
        if item.errata is not None and item.errata.remark_on_errata is not None
    )
    if remarks:
        yield "\n".join(f"* {remark}" for remark in remarks) + "\n"
    reasons = {reason for item in runs for reason in item.excluded}
    if reasons:
        yield "Excluded: " + "; ".join(escape_markdown(reason) for reason in sorted(reasons)) + ".\n"


def _make_model_and_suite_cells(summary: RunSummary) -> dict[str, str]:
    return {"model": escape_markdown(summary.key.name), "suite": _format_suite_and_protocol(summary)}


def _format_suite_and_protocol(summary: RunSummary) -> str:
    return f"{format_suite_title(summary.key.domain, summary.key.ability)}, {summary.key.protocol.value}"


def _format_percent(percent: float | None) -> str:
    return "–" if percent is None else f"{percent:.1f}"


_STRATA = "Success by steps of the data set's own plan, and goals met by the predicates that they mention."
_CERTAINTY = """\
Tasks of one name are near copies: who solves one mostly solves the others. The intervals of this report
therefore have names, not tasks, as their units; those of independent tasks stand beside them. The design
effect is how many times larger the variance is with names, and tasks divided by it are the independent
tasks that would say as much. Intervals also allow for names being few."""
_UNNAMED = (
    "{runs} of {all} runs have older records, which do not say what their tasks are like. Each of the tasks "
    "counts as independent, which makes intervals too narrow where there are near copies, and success by "
    "number of goals and by length of plan is not known. Score the answers again to know both."
)


def make_remark_on_missing_task_names(runs: Sequence[RunSummary]) -> str:
    """Return a remark on runs whose records lack the names of their tasks; empty without such runs."""
    unnamed = sum(bool(item.unnamed) for item in runs)
    return _UNNAMED.format(runs=unnamed, all=len(runs)) if unnamed else ""


def _make_confidence_interval_rows(runs: Sequence[RunSummary]) -> Iterator[dict[str, str]]:
    for item in runs:
        for metric in get_declaration(item.key.ability).overview_headings:
            certainty = item.certainties.get(metric)
            if certainty is not None:
                effective = certainty.effective_task_count
                yield _make_model_and_suite_cells(item) | {
                    "metric": get_display_name(metric),
                    "percent": _format_percent(item.rates[metric].percent),
                    "mean over names": _format_percent(compute_mean_rate_over_task_names(item.cases[metric])),
                    "95 %": _format_interval_bounds(certainty.interval),
                    "95 % if independent": _format_interval_bounds(certainty.by_task),
                    "tasks": str(certainty.tasks),
                    "names": str(certainty.names),
                    "design effect": _format_percent(certainty.design_effect),
                    "effective tasks": "–" if effective is None else f"{effective:.0f}",
                }


def _format_interval_bounds(interval: Interval) -> str:
    return f"{interval.low:.1f}–{interval.high:.1f}"
