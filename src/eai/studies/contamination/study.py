"""Contamination: success on public tasks beside fresh ones that are like them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from eai.abilities.options import Options
from eai.errors import InputError
from eai.studies.study import Analysis, Study

if TYPE_CHECKING:
    from eai.scoring.runs import Run
    from eai.studies.contamination.analysis import Pair
    from eai.studies.records import Records


def _analyze(records: Records, chosen: Options) -> Iterator[Analysis]:
    """A run of a benchmark is paired with those of the same model on task files of its world.

    These are named after it: lamps with lamps-tasks.

    Raises:
        InputError: there is no such pair.
    """
    from eai.studies.contamination.analysis import REMARKS, contamination_table

    pairs = list(_pairs(list(records.runs())))
    if not pairs:
        raise InputError("expected runs of a model on a benchmark and on generated tasks of its world")
    yield Analysis([contamination_table(pairs)], remarks=REMARKS)


def _pairs(runs: Sequence[Run]) -> Iterator[Pair]:
    from eai.abilities.declaration import declaration_of

    for public in runs:
        for fresh in runs:
            one, other = public.key, fresh.key
            alike = one._replace(domain=other.domain) == other and declaration_of(one.ability).has_plans
            if alike and other.domain.startswith(f"{one.domain}-"):
                suite = f"{other.domain} {one.ability.value}"
                yield one.name, suite, public.records, fresh.records


CONTAMINATION = Study(
    "contamination",
    "Success on public tasks beside fresh ones: the difference where tasks are alike.",
    analyze=_analyze,
)
