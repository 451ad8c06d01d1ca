"""``eai export``: data sets for training."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterable, Iterator
from contextlib import ExitStack
from enum import Enum
from functools import cache
from pathlib import Path
from typing import Annotated, ClassVar, TextIO

import typer

from eai.abilities.protocol import FOUR, Ability, ability_of
from eai.abilities.record import Record
from eai.abilities.verdict import Json
from eai.benchmark.prompt_library import Library
from eai.benchmark.registry import find_benchmark, registered
from eai.benchmark.suite import open_suite
from eai.cli.console import DOMAIN_HELP, counted, data_progress, tell
from eai.cli.lazily import LazyGroup, Place
from eai.cli.options import ABILITIES, AsJson
from eai.cli.store import DataFolder, store
from eai.errors import InputError
from eai.pddl.planning import PlannerChoice
from eai.prompts.prompt import PromptSet
from eai.scoring.records import read_records
from eai.scoring.reward import Reward, Shaping
from eai.scoring.runs import find_record_files
from eai.scoring.training_data import (
    LeftOut,
    Rewarded,
    Row,
    preference_rows,
    prompt_rows,
    rewarded,
    verified_rows,
)
from eai.tasks.source import Source
from eai.tasks.task_files import task_files_in


class _Exports(LazyGroup):
    """What is written for others to use."""

    places: ClassVar = {
        "prompts": Place("export", "prompts"),
        "sft": Place("export", "sft"),
        "preference": Place("export", "preference"),
        "questions": Place("questions", "questions"),
        "pictures": Place("pictures", "pictures"),
        "submission": Place("submission", "submission"),
    }


app = typer.Typer(
    cls=_Exports,
    help="Data sets for training, world-model questions, pictures of tasks, challenge files.",
    no_args_is_help=True,
)


@app.callback()
def export() -> None:
    """Data sets for training, world-model questions, pictures of tasks, challenge files."""


class Format(str, Enum):
    """How a data set is written: one file of JSON Lines, or a folder that Hugging Face's datasets open."""

    JSONL = "jsonl"
    HF = "hf"


_Out = Annotated[Path, typer.Option(metavar="FILE", help="The file to write; of --format hf, the folder.")]
_Format = Annotated[
    Format, typer.Option("--format", help="One file of JSON Lines, or a folder for datasets.load_dataset.")
]
_Set = Annotated[PromptSet, typer.Option("--set", help="The data set's prompts, or ours.")]
_Records = Annotated[
    list[Path], typer.Argument(help="Files of records, or folders of them.", metavar="RECORDS")
]
_Domains = Annotated[
    list[str] | None,
    typer.Option("--domain", help="Where the benchmark of records is that is not known by its name alone."),
]
_Shaping = Annotated[
    Shaping, typer.Option(metavar="HOW", help=f"What answers are worth: by {', '.join(Shaping)}.")
]

TRAIN = "train"
"""The split of what is not split."""

_CARD = """\
---
configs:
- config_name: default
  data_files:
{files}---
Made by `eai export`. The prompts hold text of the benchmarks they are of, which have licences of their own.
"""


def prompts(
    domain: Annotated[list[str], typer.Option(help=DOMAIN_HELP)],
    out: _Out,
    ability: Annotated[
        list[Ability] | None, typer.Option(parser=ability_of, help=f"{ABILITIES}. All if not given.")
    ] = None,
    prompt_set: _Set = PromptSet.OFFICIAL,
    form: _Format = Format.JSONL,
    as_json: AsJson = False,
    data: DataFolder = None,
) -> None:
    """Write the prompts of all tasks in which something is to be earned, for TRL, verl, SkyRL and OpenRLHF.

    Each file of a folder of task files is a split.

    Example: eai export prompts --domain tasks/ --ability action_sequencing --out train.jsonl
    """

    def rows() -> Iterator[Row]:
        with data_progress() as report:
            source = Source(store(data), report, PlannerChoice.NONE)
            for split, name in [each for given in domain for each in _splits(given)]:
                for each in ability or FOUR:
                    asked = Library(prompt_set, None, source).open(find_benchmark(name), each)
                    for row in prompt_rows(Reward(open_suite(name, each, source=source)), asked):
                        yield {**row, "split": split}

    _tell(out, _write(rows(), out, form), Counter(), as_json=as_json)


def sft(
    records: _Records,
    out: _Out,
    domain: _Domains = None,
    least: Annotated[float, typer.Option(min=0, max=1, help="The least that an answer must be worth.")] = 1.0,
    shaping: _Shaping = Shaping.SUCCESS,
    prompt_set: _Set = PromptSet.OFFICIAL,
    form: _Format = Format.JSONL,
    as_json: AsJson = False,
    data: DataFolder = None,
) -> None:
    """Write verified answers, each with its prompt: those that are right when they are scored again.

    Example: eai export sft runs --out sft.jsonl

    Example: eai export sft scores --domain lamps:lamps --out sft.jsonl
    """
    left_out = Counter[LeftOut]()
    answers = _answers(records, domain or [], shaping, prompt_set, data, left_out)
    _tell(out, _write(verified_rows(answers, least), out, form), left_out, as_json=as_json)


def preference(
    records: _Records,
    out: _Out,
    domain: _Domains = None,
    margin: Annotated[
        float, typer.Option(min=0, help="By more than how much the chosen one must be worth more.")
    ] = 0.0,
    shaping: _Shaping = Shaping.PROGRESS,
    prompt_set: _Set = PromptSet.OFFICIAL,
    form: _Format = Format.JSONL,
    as_json: AsJson = False,
    data: DataFolder = None,
) -> None:
    """Write pairs of answers to one prompt: of each task the best one, and every one that is worth less.

    Example: eai export preference runs --out preference.jsonl
    """
    left_out = Counter[LeftOut]()
    answers = _answers(records, domain or [], shaping, prompt_set, data, left_out)
    _tell(out, _write(preference_rows(answers, margin), out, form), left_out, as_json=as_json)


def _answers(
    paths: list[Path],
    domains: list[str],
    shaping: Shaping,
    prompt_set: PromptSet,
    data: Path | None,
    left_out: Counter[LeftOut],
) -> Iterator[Rewarded]:
    """All answers in files of records with what they are worth, those to one suite together."""
    named = {benchmark.name: benchmark for benchmark in map(find_benchmark, domains)}
    by_suite: dict[tuple[str, Ability], list[Record]] = {}
    for file in find_record_files(paths):
        for record in read_records(file):
            by_suite.setdefault((record.domain, record.ability), []).append(record)
    with data_progress() as report:
        source = Source(store(data), report, PlannerChoice.NONE)
        for (domain, ability), of_suite in by_suite.items():
            if domain not in named and domain not in registered():
                raise InputError(
                    f"{domain}: expected --domain to say where the benchmark of these records is"
                )
            benchmark = named.get(domain) or find_benchmark(domain)
            asked = Library(prompt_set, None, source).open(benchmark, ability)
            paid = Reward(open_suite(benchmark, ability, source=source), shaping)
            yield from rewarded(of_suite, paid, asked, left_out)


def _splits(domain: str) -> list[tuple[str, str]]:
    """The splits of a domain, each with the domain that it is: the files of a folder of tasks, or all."""
    folder = Path(domain)
    if not folder.is_dir():
        return [(TRAIN, domain)]
    return [(file.name.partition(".")[0].replace("-", "_"), str(file)) for file in task_files_in(folder)]


def _write(rows: Iterable[Row], out: Path, form: Format) -> int:
    """Write a data set of so many rows; nothing is there under its name before it is whole."""
    parts: dict[Path, Path] = {}
    number = 0
    try:
        with ExitStack() as stack:

            @cache
            def opened(split: object) -> TextIO:
                file = out / f"{split}.jsonl" if form is Format.HF else out
                file.parent.mkdir(parents=True, exist_ok=True)
                parts[file] = file.with_name(f"{file.name}.part")
                return stack.enter_context(parts[file].open("w", encoding="utf-8"))

            for row in rows:
                split = row.get("split", TRAIN) if form is Format.HF else TRAIN
                opened(split).write(json.dumps(row) + "\n")
                number += 1
            if not number:
                opened(TRAIN)
        for file, part in parts.items():
            part.replace(file)
        if form is Format.HF:
            files = [f"  - split: {file.stem}\n    path: {file.name}\n" for file in parts]
            (out / "README.md").write_text(_CARD.format(files="".join(files)), encoding="utf-8")
    except OSError as error:
        raise InputError(f"{out}: cannot be written ({error.strerror})") from error
    finally:
        for part in parts.values():
            part.unlink(missing_ok=True)
    return number


def _tell(out: Path, number: int, left_out: Counter[LeftOut], *, as_json: bool) -> None:
    lines = [f"left out: {counted(times, 'record')} {why.value}" for why, times in left_out.items()]
    made: Json = {"path": str(out), "rows": number, "left_out": {why.value: n for why, n in left_out.items()}}
    tell(f"{counted(number, 'row')} written to {out}", *lines, value=made, as_json=as_json)
