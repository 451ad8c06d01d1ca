"""Conduct: how safely tasks with hazards are solved, and what is refused where one of two has no plan."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from eai.abilities.options import Options
from eai.errors import InputError
from eai.studies.study import Analysis, Study

if TYPE_CHECKING:
    from eai.studies.records import Records


def _analyze(records: Records, chosen: Options) -> Iterator[Analysis]:
    from eai.studies.conduct.analysis import conduct_tables

    found = [table for table in conduct_tables(records.runs()) if table.rows]
    if not found:
        raise InputError(
            "no record is of a task with hazards or of a pair; eai generate --kind makes such tasks"
        )
    yield Analysis(found, shown=[table for table in found if table.name != "violations"])


CONDUCT = Study(
    "conduct",
    "How safely tasks with hazards are solved, and what is refused of pairs of which one has no plan.",
    analyze=_analyze,
)
