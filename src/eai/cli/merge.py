"""``eai merge``: the shards of runs, put together."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from eai.abilities.declaration import declaration_of
from eai.abilities.verdict import Json
from eai.cli.console import counted, output, print_errata, print_json, print_remark, say
from eai.cli.options import AsJson, Wide
from eai.cli.table import Result, print_rates, result_json
from eai.results.coverage import coverage_of, errata_effect
from eai.results.summary import summarise
from eai.scoring.records import find_shards, merge


def merge_shards(
    path: Annotated[Path, typer.Argument(help="The folder that eai score --shard wrote to.", metavar="DIR")],
    wide: Wide = False,
    as_json: AsJson = False,
) -> None:
    """Put the shards of eai score --shard together: records and summaries as one process writes them.

    Example: eai score answers --shard 1/2 --out scores; eai score answers --shard 2/2 --out scores;
    eai merge scores
    """
    printed: list[Json] = []
    for folder, files in find_shards(path).items():
        records = merge(folder, files)
        first, effect = records[0], errata_effect(records)
        result = Result(
            summarise([record.verdict for record in records], first.ability), coverage_of(records)
        )
        printed.append(result_json(records, result, effect, folder))
        if not as_json:
            title = f"{first.domain}, {first.ability.value}, protocol {first.protocol.value}"
            columns = declaration_of(first.ability).terminal
            print_rates(output(), title, columns, {first.model: result}, wide=wide)
            print_errata([effect])
            say(f"{counted(len(files), 'shard')} of {counted(len(records), 'record')} written to {folder}")
        print_remark(first.model, result.coverage)
    if as_json:
        print_json(printed)
