"""``eai analyze contamination``: success on public tasks beside fresh ones that are like them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Annotated

import typer

from eai.abilities.declaration import declaration_of
from eai.cli.analyzed import Records, Written, say
from eai.cli.options import AsJson
from eai.errors import InputError
from eai.report.runs import Run, read_runs
from eai.results.table_files import write_tables
from eai.studies.contamination.analysis import REMARKS, Pair, contamination_table


def contamination(
    records: Records,
    out: Annotated[Path, typer.Option(help="The folder for the results.")] = Path("contamination"),
    as_json: AsJson = False,
) -> None:
    """Set success on public tasks beside fresh ones: the difference where tasks are alike, with its interval.

    A run of a benchmark is paired with the runs of the same model on task files of its world, which are named
    after it: lamps with lamps-tasks.

    Example: eai analyze contamination runs
    """
    pairs = list(_pairs(list(read_runs(records))))
    if not pairs:
        raise InputError("expected runs of a model on a benchmark and on generated tasks of its world")
    table = contamination_table(pairs)
    write_tables(out, "contamination", [table], REMARKS)
    say(Written((table.name,), 0, out), as_json=as_json)


def _pairs(runs: Sequence[Run]) -> Iterator[Pair]:
    for public in runs:
        for fresh in runs:
            one, other = public.key, fresh.key
            alike = one._replace(domain=other.domain) == other and declaration_of(one.ability).has_plans
            if alike and other.domain.startswith(f"{one.domain}-"):
                suite = f"{other.domain} {one.ability.value}"
                yield Pair(one.name, suite, public.records, fresh.records)
