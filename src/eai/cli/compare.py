"""``eai compare``: compare two runs on the same tasks."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, NamedTuple

import typer
from rich.text import Text

from eai.abilities.declaration import get_declaration
from eai.base.errors import InputError
from eai.base.json_value import Json
from eai.benchmarks.names import remove_prompt_variant_endings
from eai.cli.console import format_count, get_output_console, print_json, print_note
from eai.cli.options import AsJson, make_flag
from eai.cli.table import PERCENT, print_note_if_incomplete
from eai.results.certainty import ConfidenceIntervals, Interval
from eai.results.comparison import MetricDifference, RunComparison
from eai.results.comparison import compare_runs as compare_runs
from eai.results.record import Record
from eai.results.runs import Run, RunKey, read_runs
from eai.results.table import Cell, Column, Estimate, Table, TextCell
from eai.results.terminal import print_table
from eai.results.totals import RunTotals

_SURE = 0.05
_UNNAMED = (
    "Older records do not say which tasks are near copies: each of theirs counts as independent. Score the "
    "answers again."
)


def compare(
    first: Annotated[Path, typer.Argument(metavar="A")],
    second: Annotated[Path, typer.Argument(metavar="B")],
    tasks: Annotated[int, make_flag(min=0, metavar="N")] = 10,
    as_json: AsJson = False,
) -> None:
    """Compare two runs task by task: exact McNemar for success, random exchanges for F1.

    Runs of the same domain, ability and protocol are compared; A and B each have at most one such run.
    If A and B have no such runs in common, eai compares runs on variants of a benchmark: the same tasks in
    other words, or with prompts that state exact rules. It also compares runs on abilities whose questions
    are the same for all benchmarks.

    Episodes are compared only if they had the same rules, such as a limit of actions.

    Tasks of one title, and questions about one task, are near copies and count as one cluster. A second line
    of results treats all tasks as independent.

    Example: eai compare scores/gpt-4o scores/o1-mini

    Options:
        first: Records of a run, or a folder of them.
        second: Records of another run, or a folder.
        tasks: Number of differing tasks to list.
    """
    before, after = _read_runs_by_suite(first), _read_runs_by_suite(second)
    if not before.keys() & after.keys():
        before = _give_suites_with_equal_tasks_one_name(before)
        after = _give_suites_with_equal_tasks_one_name(after)
    shared = [place for place in before if place in after]
    if not shared:
        hint = ", under the same game rules" if any(place.rules for place in (*before, *after)) else ""
        raise InputError(
            f"{first} and {second}: expected records of the same domain, ability and protocol{hint}"
        )
    for place in (*before, *after):
        if place not in shared:
            print_note(f"only one side has {place}")
    printed: list[Json] = []
    for place in shared:
        one, other = before[place], after[place]
        comparison = compare_runs(one.records, other.records)
        if not comparison.tasks:
            raise InputError(
                f"{first} and {second}: expected scored answers to the same tasks of {place}, found none"
            )
        if as_json:
            printed.append(_comparison_to_json(one, other, comparison))
            continue
        _print_comparison(place, one, other, comparison, tasks)
        if not all(record.task for record in (*one.records, *other.records)):
            print_note(_UNNAMED)
    if as_json:
        print_json(printed)


def _comparison_to_json(one: Run, other: Run, comparison: RunComparison) -> dict[str, Json]:
    """Return the ``--json`` output on two compared runs: unrounded percentages, and all differing tasks."""
    key = one.key
    return {
        "domain": key.domain,
        "ability": key.ability.value,
        "protocol": key.protocol.value,
        "a": one.key.name,
        "b": other.key.name,
        "tasks": comparison.tasks,
        "names": comparison.names,
        "differences": [
            {
                "metric": metric,
                "a": each.first.to_json(),
                "b": each.second.to_json(),
                "points": each.percentage_points,
                "interval": None if each.certainty is None else list(each.certainty.interval),
                "p": each.p_value,
                "p_by_task": each.p_by_task,
                "only_a": list(each.only_first),
                "only_b": list(each.only_second),
            }
            for metric, each in comparison.differences.items()
        ],
        "left_out_of_a": list(comparison.only_in_first),
        "left_out_of_b": list(comparison.only_in_second),
    }


def _print_note_on_different_planners(totals: Mapping[str, RunTotals]) -> None:
    """Print a note on standard error if different planners judged the operators in the two runs' answers."""
    planners = {side: ", ".join(each.planners) or "not known" for side, each in totals.items()}
    if len(set(planners.values())) > 1:
        named = "; ".join(f"{side}: {names}" for side, names in planners.items())
        print_note(f"operators are judged by different planners: {named}")


class _ComparedSuite(NamedTuple):
    """Key by which runs are matched: domain, ability, protocol (scoring rules), and game rules of episodes.

    The rules say, for example, how many actions an agent may take; None for the standard rules.
    """

    domain: str
    ability: str
    protocol: str
    rules: str | None = None

    @staticmethod
    def from_run_key(key: RunKey) -> _ComparedSuite:
        rules = None if key.experiment is None else key.experiment.rules
        return _ComparedSuite(key.domain, key.ability.value, key.protocol.value, rules)

    def __str__(self) -> str:
        rules = "" if self.rules is None else f", rules {self.rules}"
        return f"{self.domain} {self.ability}, protocol {self.protocol}{rules}".lstrip()


def _read_runs_by_suite(path: Path) -> Mapping[_ComparedSuite, Run]:
    """Return the runs in a folder by benchmark, ability, protocol and game rules.

    Raise InputError if two runs are equal in all four.
    """
    runs: dict[_ComparedSuite, Run] = {}
    for run in read_runs([path]):
        place = _ComparedSuite.from_run_key(run.key)
        before = runs.setdefault(place, run)
        if before is not run:
            both = f"{before.key.name} and {run.key.name}"
            raise InputError(
                f"{path}: expected one run for {place}, found {both}; give the folder of one run"
            )
    return dict(sorted(runs.items(), key=lambda item: item[1].key.sort_key))


def _give_suites_with_equal_tasks_one_name(
    runs: Mapping[_ComparedSuite, Run],
) -> Mapping[_ComparedSuite, Run]:
    """Return the runs by suite, where suites with equal tasks have one name. Their runs are then compared.

    A variant of a benchmark has the benchmark's tasks with other prompts, so its suites get the name of the
    benchmark. Some abilities have equal tasks in all benchmarks, so their suites get a name without a
    benchmark. A suite keeps its own name if two runs would otherwise have equal names.
    """
    places = {}
    for place, run in runs.items():
        is_apart = get_declaration(run.key.ability).interaction.task_command
        places[place] = place._replace(domain="" if is_apart else remove_prompt_variant_endings(place.domain))
    alone = Counter(places.values())
    return {places[place] if alone[places[place]] == 1 else place: run for place, run in runs.items()}


def _print_comparison(
    suite: _ComparedSuite, one: Run, other: Run, comparison: RunComparison, max_listed: int
) -> None:
    first, second = one.key, other.key
    totals = {"A": RunTotals.from_records(one.records), "B": RunTotals.from_records(other.records)}
    coverages = {side: each.coverage for side, each in totals.items()}
    number_of_tasks = format_count(comparison.tasks, "task")
    names = "" if comparison.names == comparison.tasks else f" of {comparison.names} names"
    title = (
        f"{suite}: {number_of_tasks}{names}\n"
        f"A {first.name}, {coverages['A']} answered\nB {second.name}, {coverages['B']} answered"
    )
    numbers = [replace(PERCENT, name=name) for name in ("A", "B")]
    texts = [Column(name, is_number=True) for name in ("B - A", "95 %", "p", "tasks")]
    rows = tuple(
        row for metric, each in comparison.differences.items() for row in _make_metric_rows(metric, each)
    )
    print_table(get_output_console(), Table("", title, "", ("percent", *numbers, *texts), rows))
    get_output_console().print(_make_comparison_caption(comparison), highlight=False, style="italic")
    for side, coverage in coverages.items():
        print_note_if_incomplete(side, coverage)
    named = {record.task_id: _format_task_name(record) for record in (*one.records, *other.records)}
    a, b = ("A", "B") if first.name == second.name else (first.name, second.name)
    for metric, difference in comparison.differences.items():
        for name, tasks in ((a, difference.only_first), (b, difference.only_second)):
            if tasks:
                heading = f"{_format_metric_name(metric)} only in {name} ({len(tasks)})"
                _print_tasks(heading, [named[task] for task in tasks], max_listed)
    for name, tasks in ((a, comparison.only_in_first), (b, comparison.only_in_second)):
        if tasks:
            heading = f"left out, because only {name} has a scored answer ({len(tasks)})"
            _print_tasks(heading, [named[task] for task in tasks], max_listed)
    _print_note_on_different_planners(totals)


def _make_comparison_caption(comparison: RunComparison) -> str:
    """Return the caption of the table of differences, which names the statistical tests of its p values."""
    kinds = {difference.yes_no for difference in comparison.differences.values()}
    named = ["exact McNemar"] * (True in kinds) + ["random exchanges for F1 and means"] * (False in kinds)
    together = " tasks of one name as one case; tasks: number of independent tasks with as much information"
    return f"p: {', '.join(named)}" + (f",{together}" if comparison.names < comparison.tasks else "")


def _format_task_name(record: Record) -> str:
    """Return a task's id. The name that similar tasks share follows, unless the id begins with it."""
    name = "" if record.task is None else record.task.name
    return f"{record.task_id} {name}" if name and not record.task_id.startswith(name) else record.task_id


def _print_tasks(heading: str, tasks: Sequence[str], max_listed: int) -> None:
    more = f" … and {len(tasks) - max_listed} more" if len(tasks) > max_listed else ""
    text = Text(f"{heading}: ", style="bold").append(", ".join(tasks[:max_listed]) + more, style="not bold")
    get_output_console().print(text)


def _make_metric_rows(metric: str, difference: MetricDifference) -> Iterator[tuple[Cell, ...]]:
    """Yield a metric's row, which counts near copies of a task (tasks with one title) as dependent.

    If there are near copies, a second row treats all tasks as independent.
    """
    certainty, points = difference.certainty, difference.percentage_points
    sure = difference.p_value is not None and difference.p_value < _SURE
    yield (
        _format_metric_name(metric),
        Estimate.from_rate(difference.first),
        Estimate.from_rate(difference.second),
        "-" if points is None else TextCell(f"{points:+.1f}", bold=sure),
        "-" if certainty is None else _format_interval_in_percentage_points(certainty.interval),
        _format_p_value(difference.p_value),
        _format_effective_sample_size(certainty),
    )
    if certainty is not None and certainty.names < certainty.tasks:
        below = [
            _format_interval_in_percentage_points(certainty.by_task),
            _format_p_value(difference.p_by_task),
            str(certainty.tasks),
        ]
        yield ("", None, None, *(TextCell(text, dim=True) for text in ("independent:", *below)))


def _format_effective_sample_size(intervals: ConfidenceIntervals | None) -> str:
    """Return the number of independent tasks that would give an interval of equal width, as text."""
    effective = None if intervals is None else intervals.effective_task_count
    return "-" if effective is None else f"{effective:.0f}"


def _format_interval_in_percentage_points(interval: Interval) -> str:
    return f"{interval.low:+.1f} to {interval.high:+.1f}"


def _format_p_value(p_value: float | None) -> str:
    if p_value is None:
        return "-"
    return "<0.001" if p_value < 0.001 else f"{p_value:.3f}"


def _format_metric_name(metric: str) -> str:
    return metric.replace("_", " ").replace(".", " ")
