"""Items: how difficult tasks are, which tell models apart, and which are odd."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from eai.abilities.options import Options
from eai.errors import InputError
from eai.studies.study import Analysis, Figures, Study, of_suite

if TYPE_CHECKING:
    from eai.results.table import Table
    from eai.studies.records import Records


def _analyze(records: Records, chosen: Options) -> Iterator[Analysis]:
    from eai.studies.items.analysis import FEWEST_MODELS, item_tables
    from eai.studies.items.item_flags import ItemFlags

    found = item_tables(records.tables().answers, ItemFlags(records.source))
    if not found[0].rows:
        raise InputError(f"expected answers of at least {FEWEST_MODELS} models to one suite")
    yield Analysis(found, _figures(found))


def _figures(found: Sequence[Table]) -> Figures:
    from eai.results.plots import rows_of
    from eai.studies.items import plots

    abilities = rows_of(found[1])
    for suite, rows in rows_of(found[3]).items():
        yield of_suite(suite, "items", plots.draw(rows, abilities[suite]))


ITEMS = Study(
    "items",
    "Tasks by the answers of many models: difficulty, agreement with other tasks, and what is odd.",
    analyze=_analyze,
    together=True,
)
