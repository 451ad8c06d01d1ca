"""Sensitivity: which operator of a model breaks plans."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated

from pydantic import BeforeValidator

from eai.abilities.options import Options, option
from eai.abilities.protocol import Ability
from eai.abilities.transition_modeling.rules import Replaced
from eai.errors import InputError
from eai.pddl.planning import PlannerChoice
from eai.studies.study import Analysis, Figures, Study, of_suite, several

if TYPE_CHECKING:
    from eai.results.table import Table
    from eai.studies.records import Records


class _Choices(Options):
    """How operators are tried."""

    replace: Annotated[tuple[Replaced, ...], BeforeValidator(several)] = option(
        "What of a gold operator is the model's: operator, precondition or effect; several with commas.",
        (Replaced.OPERATOR,),
    )
    planner: PlannerChoice = option("What finds plans: auto, fast_downward or built_in.", PlannerChoice.AUTO)


def _analyze(records: Records, chosen: _Choices) -> Iterator[Analysis]:
    """Operators are tried one by one, which takes a planner minutes a model.

    Raises:
        InputError: there are no operators, or no planner is to try them.
    """
    from eai.studies.sensitivity.analysis import sensitivity_tables, tried

    if chosen.planner is PlannerChoice.NONE:
        raise InputError("planner=none: operators are tried by a planner")
    runs = [run for run in records.runs() if run.key.ability is Ability.TRANSITION_MODELING]
    found = [record for run in runs for record in run.records]
    if not found:
        raise InputError("expected records of transition modeling, found none")
    ways = tuple(dict.fromkeys(chosen.replace))
    source = replace(records.source, planner=chosen.planner)
    with records.progress("trying operators", len(found)) as done:
        tables = sensitivity_tables(list(tried(found, source, ways, done)))
    yield Analysis(tables, _figures(tables, ways))


def _figures(tables: Sequence[Table], ways: Sequence[Replaced]) -> Figures:
    from eai.results.plots import draw_matrix, rows_of
    from eai.studies.sensitivity.analysis import OVERALL

    for suite, rows in rows_of(tables[0]).items():
        for way in ways:
            of_way = [row for row in rows if row["replaced"] == way.value]
            label = f"percent solved with the model's {way.value}"
            shown = [row for row in of_way if row["category"] == OVERALL]
            models = draw_matrix(shown, ("operator",), "solved", label, zeros=True)
            yield of_suite(suite, way.value, models)
            shown = [row for row in of_way if row["model"] == of_way[0]["model"]]
            categories = draw_matrix(shown, ("operator",), "solved", label, across="category", zeros=True)
            yield of_suite(suite, f"{way.value}-categories", categories)


SENSITIVITY = Study(
    "sensitivity",
    "Each operator of the answers alone among gold operators: which one breaks plans (transition modeling).",
    choices=_Choices,
    analyze=_analyze,
)
