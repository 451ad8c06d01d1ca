"""Prompts: how much depends on how one asks."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING

from eai.abilities.options import Options
from eai.abilities.responses import file_name
from eai.errors import InputError
from eai.results.plots import draw_matrix, entitle
from eai.studies.study import Analysis, Figures, Study, metric_of

if TYPE_CHECKING:
    from eai.results.table import Table
    from eai.scoring.runs import Run
    from eai.studies.records import Records


class _Choices(Options):
    """How prompts are compared.

    Attributes:
        metric: Which metric of the ability's main table; its first if not given.
        reference: The prompts that gains are measured from; the first if not given.
    """

    metric: str | None = None
    reference: str | None = None


def _analyze(records: Records, chosen: _Choices) -> Iterator[Analysis]:
    from eai.studies.prompts.analysis import prompt_tables

    for suite, runs in _by_suite(records.runs()).items():
        named, metric = [(_name(run), run) for run in runs], metric_of(runs[0].key.ability, chosen.metric)
        tables = prompt_tables([(name, run.records) for name, run in named], metric, chosen.reference)
        yield Analysis(
            tables,
            _figures(tables[0], metric, suite),
            folder=file_name(suite),
            facts={
                "suite": suite,
                "prompts": list(dict.fromkeys(name for name, _ in named)),
                "models": list(dict.fromkeys(run.key.model for _, run in named)),
            },
        )


def _figures(cells: Table, metric: str, suite: str) -> Figures:
    label = f"{metric}, percent"
    figure = draw_matrix(cells.by_name(), ("prompt",), "value", label, across="answered_by", zeros=True)
    if figure is not None:
        entitle(figure, suite.replace("-", ", "))
    yield "prompts", figure


def _name(run: Run) -> str:
    from eai.studies.prompts.analysis import PLAIN

    experiment = run.key.experiment
    return PLAIN if experiment is None or experiment.prompt_name is None else experiment.prompt_name


def _by_suite(runs: Iterable[Run]) -> dict[str, list[Run]]:
    """The runs of each suite and protocol; those of other experiments are refused."""
    suites: dict[str, list[Run]] = {}
    for run in runs:
        experiment = run.key.experiment
        if experiment is not None and (experiment.acts or experiment.goals_from is not None):
            raise InputError(f"{run.key}: expected runs that differ in their prompts alone")
        suites.setdefault(run.key.suite.file_name, []).append(run)
    return suites


PROMPTS = Study(
    "prompts",
    "Runs of models with several prompts (prompts.name) side by side, suite by suite.",
    choices=_Choices,
    analyze=_analyze,
)
