"""How sure the main results of a report are, with and without regard to near copies."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from eai.abilities.declaration import declaration_of, label_of
from eai.report.run_summary import RunSummary
from eai.report.table_specs import ability_title, domain_title
from eai.results.certainty import Interval, mean_over_names
from eai.results.markdown import escaped, grid

_INTRODUCTION = """\
Tasks of one name are near copies: who solves one mostly solves the others. The intervals of this report
therefore have names, not tasks, as their units; those of independent tasks stand beside them. The design
effect is how many times larger the variance is with names, and tasks divided by it are the independent
tasks that would say as much. Intervals also allow for names being few."""
_UNNAMED = (
    "{runs} of {all} runs have older records, which do not say what their tasks are like. Each of the tasks "
    "counts as independent, which makes intervals too narrow where there are near copies, and success by "
    "number of goals and by length of plan is not known. Score the answers again to know both."
)
_HEADER = (
    "model",
    "suite",
    "metric",
    "percent",
    "mean over names",
    "95 %",
    "95 % if independent",
    "tasks",
    "names",
    "design effect",
    "effective tasks",
)


def certainty_section(runs: Sequence[RunSummary]) -> Iterator[str]:
    """The section of the page."""
    rows = [row for item in runs for row in _rows(item)]
    if not rows:
        return
    yield "## How sure the numbers are\n"
    yield _INTRODUCTION + "\n"
    remark = unnamed_remark(runs)
    if remark:
        yield f"{remark}\n"
    yield "\n".join(grid(_HEADER, rows)) + "\n"


def unnamed_remark(runs: Sequence[RunSummary]) -> str:
    """What a reader must know of runs whose records do not describe their tasks; empty if there are none."""
    unnamed = sum(bool(item.unnamed) for item in runs)
    return _UNNAMED.format(runs=unnamed, all=len(runs)) if unnamed else ""


def _rows(item: RunSummary) -> Iterator[list[str]]:
    for metric in declaration_of(item.key.ability).main:
        certainty = item.certainties.get(metric)
        if certainty is not None:
            yield [
                escaped(item.key.model),
                f"{domain_title(item.key.domain)}, {ability_title(item.key.ability).lower()}, "
                f"{item.key.protocol.value}",
                label_of(metric),
                _number(item.rates[metric].percent),
                _number(mean_over_names(item.cases[metric])),
                _interval(certainty.interval),
                _interval(certainty.by_task),
                str(certainty.tasks),
                str(certainty.names),
                _number(certainty.design_effect),
                "–" if certainty.effective_tasks is None else f"{certainty.effective_tasks:.0f}",
            ]


def _number(number: float | None) -> str:
    return "–" if number is None else f"{number:.1f}"


def _interval(interval: Interval) -> str:
    return f"{interval.low:.1f}–{interval.high:.1f}"
