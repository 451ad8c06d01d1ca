"""Cofactors: what success depends on."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from eai.abilities.options import Options, option
from eai.results.lines import Measure
from eai.studies.study import Analysis, Figures, Study, of_suite

if TYPE_CHECKING:
    from eai.results.table import Table
    from eai.studies.records import Records


class _Choices(Options):
    """How success is set against features of tasks."""

    bins: int = option("How many lengths of annotated plans stand together.", 10, ge=1)
    measure: Measure = option(
        "What features of tasks are set against: score, executable or goals.", Measure.SCORE
    )


def _analyze(records: Records, chosen: _Choices) -> Iterator[Analysis]:
    from eai.studies.cofactors.analysis import cofactor_tables

    found = cofactor_tables(records.tables(), width=chosen.bins, measure=chosen.measure)
    yield Analysis(found, _figures(found, chosen.measure))


def _figures(found: Sequence[Table], measure: Measure) -> Figures:
    from eai.results.plots import draw_names, rows_of
    from eai.studies.cofactors import plots

    adjusted, _, curves, by_action, by_predicate = found
    for suite, rows in rows_of(curves).items():
        yield of_suite(suite, "curves", plots.draw_curves(rows, f"{measure.value}, percent"))
    for suite, rows in rows_of(adjusted).items():
        yield of_suite(suite, "adjusted", plots.draw_effects(rows))
    for suite, rows in rows_of(by_action).items():
        figure = draw_names(rows, "action", "executed", "executed of the steps tried")
        yield of_suite(suite, "by_action", figure)
    for suite, rows in rows_of(by_predicate).items():
        figure = draw_names(rows, "predicate", "reached", "reached of the goals that mention it")
        yield of_suite(suite, "by_predicate", figure)


COFACTORS = Study(
    "cofactors",
    "Success against what tasks are like, and what is left of each feature beside the others.",
    choices=_Choices,
    analyze=_analyze,
    together=True,
)
