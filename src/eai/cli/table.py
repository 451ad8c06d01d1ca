"""Print rates on a terminal, and make their JSON for ``--json``."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from eai.abilities.declaration import get_declaration
from eai.base.grouping import group_pairs
from eai.base.json_value import Json
from eai.benchmarks.registry import get_title
from eai.cli.console import get_output_console, print_note, print_result_line
from eai.results.coverage import TaskCoverageByAnswers
from eai.results.table import Column, Estimate, NamedCells, Table
from eai.results.terminal import print_table
from eai.results.totals import RunTotals

_SHORT = {"precision": "P", "recall": "R", "f1": "F1", "planner_success": "planner"}
_GROUPED = re.compile(r"\.(?=\D)")
"""Pattern of a point that separates a metric's group from its name; the point in 1.5 does not match."""

PERCENT = Column("percent", digits=1, is_number=True)
"""Style of a column of rates in percent."""


def _add_nonstandard_settings_to_model_name(model: str, run_totals: RunTotals) -> str:
    """Return a model's name with its harness (program that lets it act), effort and game rules."""
    return ", ".join([model, *(part for part in run_totals.agent_labels if not model.endswith(f", {part}"))])


def print_results(results: Mapping[str, RunTotals], text_below: str = "", *, wide: bool) -> None:
    """Print the rates of models for one ability in a benchmark, with remarks on missing and corrected tasks.

    Args:
        results: Results by model.
        text_below: Line below the name of the suite; if empty, the study options of the first model's run.
        wide: Whether all columns stand side by side, however wide the table is.
    """
    first = next(iter(results.values())).first_record
    declared = get_declaration(first.ability)
    if not text_below and first.experiment is not None:
        text_below = first.experiment.study_label
    title = (
        f"{get_title(first.domain)}, {declared.title.lower()}, protocol {first.protocol.value}\n{text_below}"
    )
    print_table(
        get_output_console(), make_rates_table(title.rstrip(), declared.terminal_metrics, results), wide=wide
    )
    for coverage, models in group_pairs(
        (totals.coverage, model) for model, totals in results.items()
    ).items():
        print_note_if_incomplete(", ".join(models), coverage)
    for remark in dict.fromkeys(
        each.errata.remark_on_errata for each in results.values() if each.errata is not None
    ):
        if remark is not None:
            print_result_line(remark)


def print_note_if_incomplete(suite_name: str, coverage: TaskCoverageByAnswers) -> None:
    """Print a remark on standard error if not all tasks are answered and scored."""
    if coverage.remark_on_missing_answers is not None:
        print_note(f"{suite_name}: {coverage.remark_on_missing_answers}")


def make_rates_table(title: str, metrics: Sequence[str], results: Mapping[str, RunTotals]) -> Table:
    """Return a table of percentages with one decimal.

    With one model, each row is a metric; with several models, each row is a model.

    Args:
        title: Title of the table.
        metrics: Names of the metrics.
        results: Results by model.
    """
    rates_by_model = {model: totals.rates for model, totals in results.items()}
    shown = [
        metric for metric in metrics if any(rates[metric].denominator for rates in rates_by_model.values())
    ]
    if len(results) == 1:
        (model, totals), *_ = results.items()
        answered = f"{totals.coverage} answered" if totals.coverage.answered else "no answer"
        whole = f"{title}: {_add_nonstandard_settings_to_model_name(model, totals)}, {answered}"
        rates = [rates_by_model[model][metric] for metric in shown]
        columns: list[NamedCells] = [
            ("", [", ".join(_GROUPED.split(metric)).replace("_", " ") for metric in shown]),
            (PERCENT, [Estimate.from_rate(rate) for rate in rates]),
            (Column("of", is_number=True), [f"{round(r.numerator, 1):g} / {r.denominator:g}" for r in rates]),
        ]
        return Table.from_columns(whole, columns)
    columns = [
        ("percent", [_add_nonstandard_settings_to_model_name(*each) for each in results.items()]),
        (Column("answered", is_number=True), [str(totals.coverage) for totals in results.values()]),
    ]
    if any(totals.coverage.cut_off for totals in results.values()):
        cut_off = [totals.coverage.cut_off for totals in results.values()]
        columns.append((Column("cut off", "cut\noff", is_number=True), cut_off))
    for metric in shown:
        cells = [Estimate.from_rate(rates[metric]) for rates in rates_by_model.values()]
        columns.append((replace(PERCENT, heading=format_heading(metric)), cells))
    return Table.from_columns(title, columns)


def result_to_json(totals: RunTotals, folder: Path | None) -> dict[str, Json]:
    """Return one model's results in one suite as JSON, with the folder of its records if it has one."""
    first, planners, errata = totals.first_record, totals.planners, totals.errata
    return {
        "model": first.model,
        "domain": first.domain,
        "ability": first.ability.value,
        "protocol": first.protocol.value,
        **(
            {}
            if first.experiment is None or first.experiment.rules is None
            else {"rules": first.experiment.rules}
        ),
        "folder": None if folder is None else str(folder),
        "coverage": totals.coverage.to_json(),
        "errata": None if errata is None else errata.to_json(),
        **({"planner": ", ".join(planners)} if planners else {}),
        "metrics": {name: rate.to_json() for name, rate in totals.rates.items()},
    }


def format_heading(metric: str) -> str:
    """Return a metric's name as a column heading: broken into short lines."""
    *groups, measure = _GROUPED.split(metric)
    words = [word for group in groups for word in group.split("_")]
    last = [_SHORT[measure]] if measure in _SHORT else measure.split("_")
    return "\n".join([*words, *last])
