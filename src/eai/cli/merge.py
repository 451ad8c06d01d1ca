"""``eai merge``: the shards of runs, put together."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from eai.abilities.declarations import DECLARATIONS
from eai.cli.console import counted, output, print_errata, print_remark
from eai.cli.options import Wide
from eai.cli.table import Result, print_rates
from eai.metrics.coverage import coverage_of
from eai.metrics.errata_effect import errata_effect
from eai.metrics.summary import summarise
from eai.scoring.shards import find_shards, merge


def merge_shards(
    path: Annotated[Path, typer.Argument(help="The folder that eai score --shard wrote to.", metavar="DIR")],
    wide: Wide = False,
) -> None:
    """Put the shards of eai score --shard together: records and summaries as one process writes them.

    Example: eai score answers --shard 1/2 --out scores; eai score answers --shard 2/2 --out scores;
    eai merge scores
    """
    for folder, files in find_shards(path).items():
        records = merge(folder, files)
        first = records[0]
        result = Result(
            summarise([record.verdict for record in records], first.ability), coverage_of(records)
        )
        title = f"{first.domain}, {first.ability.value}, protocol {first.protocol.value}"
        columns = DECLARATIONS[first.ability].terminal
        print_rates(output(), title, columns, {first.model: result}, wide=wide)
        print_errata([errata_effect(records)])
        print_remark(first.model, result.coverage)
        told = f"{counted(len(files), 'shard')} of {counted(len(records), 'record')} written to {folder}"
        output().print(told, soft_wrap=True, highlight=False, markup=False)
