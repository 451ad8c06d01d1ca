"""Repair: how many edits failed answers are from right ones, and of which kinds."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from eai.abilities.options import Options
from eai.errors import InputError
from eai.studies.study import Analysis, Study

if TYPE_CHECKING:
    from eai.studies.records import Records


def _analyze(records: Records, chosen: Options) -> Iterator[Analysis]:
    from eai.studies.repair.analysis import repair_tables

    found = repair_tables(records.runs())
    if not found[0].rows:
        raise InputError(
            "no record has a repair; eai score --look-back 20000 puts one into each failed answer"
        )
    yield Analysis(found, shown=found[:1])


REPAIR = Study(
    "repair",
    "The fewest edits that make failed answers right, of records scored with --look-back.",
    analyze=_analyze,
)
