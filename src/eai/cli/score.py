"""``eai score``: from response files to records and summaries."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from itertools import groupby
from pathlib import Path
from typing import Annotated

import typer

from eai.abilities.declaration import declaration_of
from eai.abilities.protocol import DEFAULT_PROTOCOL, Ability
from eai.abilities.record import Record
from eai.abilities.responses import Response, ResponseFile, find_response_files, read_responses
from eai.abilities.verdict import Json
from eai.benchmark.answer_files import SuiteFile, files_of_suite, suite_files, unpacked
from eai.benchmark.suite import Suite, open_suite
from eai.cli.console import (
    counted,
    data_progress,
    note,
    note_planner,
    output,
    print_errata,
    print_json,
    print_remark,
    say,
    without_inspect,
)
from eai.cli.options import (
    ABILITY,
    ANSWERS,
    DOMAIN,
    OUTPUT,
    SCORING,
    AllowMissing,
    AsJson,
    Errata,
    Explanations,
    Planner,
    PlannerMemory,
    PlannerSeconds,
    Ray,
    Rules,
    Wide,
    Workers,
)
from eai.cli.planning import planner_terms, tell_authority
from eai.cli.progress import scoring_progress
from eai.cli.store import DataFolder, store
from eai.cli.table import Result, print_rates, result_json
from eai.errors import InputError, InterruptError, how_to_install
from eai.pddl.planning import PlannerChoice
from eai.results.coverage import ErrataEffect, coverage_of, errata_effect
from eai.results.summary import summarise
from eai.run.journal import sole_run
from eai.scoring.batch import NO_ROW, Scoring, Settings, score_run
from eai.scoring.collector import collecting_seldom
from eai.scoring.epochs import Believed
from eai.scoring.records import RECORDS, Shard, read_records, write_results, write_shard
from eai.studies.pipeline.stage_one import read_believed, refuse_no_stage_two
from eai.tasks.source import ErrataChoice, Source

Goals = Annotated[
    Path | None,
    typer.Option(
        "--goals",
        help="Of a pipeline: the answers to goal interpretation whose goals the questions stated.",
        rich_help_panel=ANSWERS,
    ),
]

OneShard = Annotated[
    Shard | None,
    typer.Option(
        "--shard",
        parser=Shard.parse,
        metavar="I/N",
        help="Score the I-th of N parts, as a job of its own; eai merge puts them together.",
        rich_help_panel=SCORING,
    ),
]

LOG_SUFFIX = ".eval"
"""How the names of Inspect's logs end."""


@dataclass(frozen=True, slots=True)
class _Share:
    """The answers of one model to one suite, and where its results go."""

    suite: Suite
    answers: ResponseFile
    out: Path | None
    prompt_name: str | None = None


def score(
    context: typer.Context,
    paths: Annotated[
        list[Path],
        typer.Argument(
            help="Response files (JSON, JSONL, Parquet), folders or zips of them, or logs of Inspect's.",
            metavar="PATH",
        ),
    ],
    domain: Annotated[str | None, DOMAIN] = None,
    ability: Annotated[Ability | None, ABILITY] = None,
    protocol: Rules = DEFAULT_PROTOCOL,
    planner: Planner = PlannerChoice.AUTO,
    errata: Errata = ErrataChoice.CURRENT,
    planner_seconds: PlannerSeconds = None,
    planner_memory: PlannerMemory = None,
    workers: Workers = 1,
    ray: Ray = None,
    explanations: Explanations = True,
    allow_missing: AllowMissing = False,
    goals: Goals = None,
    prompt_name: Annotated[
        str | None,
        typer.Option(help="What their prompts were called.", rich_help_panel=ANSWERS),
    ] = None,
    shard: OneShard = None,
    out: Annotated[
        Path | None,
        typer.Option(help="Where records and summaries go.", rich_help_panel=OUTPUT),
    ] = None,
    as_json: AsJson = False,
    wide: Wide = False,
    data: DataFolder = None,
) -> None:
    """Score answers: verdicts to OUT/records.jsonl, rates to OUT/summary.json, the main table to the screen.

    A task without an answer counts as failed. With several files each model gets a folder of its own in OUT.

    Without --domain and --ability all suites are scored that files name by their places, as in
    <domain>/<ability>/<model>_outputs.json or <domain>_<ability>_outputs.json; each gets a folder of OUT.

    Example: eai score gpt-4o_outputs.json --domain virtualhome --ability action_sequencing --out scores

    Example: eai score submission.zip --out scores

    Example: eai score answers --shard $SLURM_ARRAY_TASK_ID/8 --out scores   (then: eai merge scores)
    """
    for path in paths:
        find_response_files(path)  # what is not there is said before the data set is fetched
    settings = Settings(workers, explanations, allow_missing, shard)
    if shard is not None and out is None:
        raise InputError("--shard writes records to be merged: say where, with --out")
    if goals is not None and ability is not None:
        refuse_no_stage_two(ability)
    with ExitStack() as stack:
        places = [stack.enter_context(unpacked(path)) for path in paths]
        with data_progress() as report:
            terms = planner_terms(context, planner_seconds, planner_memory)
            source = Source(store(data), report, planner, errata, terms)
            if domain is not None and ability is not None:
                suite = open_suite(domain, ability, protocol, source=source)
                shares = _shares_of_suite(places, suite, out)
            else:
                found = _named(places, domain, ability)
                opened = {
                    place: open_suite(*place, protocol, source=source)
                    for place in dict.fromkeys((file.domain, file.ability) for file in found)
                }
                shares = [_share(file, opened[file.domain, file.ability], out) for file in found]
    shares = [replace(share, prompt_name=prompt_name) for share in shares]
    note_planner([share.suite for share in shares])
    for share in shares:
        _note_elsewhere(share)
    printed: list[Json] = []
    with collecting_seldom(), _opened(workers, ray) as scoring, ExitStack() as stack:
        for folder in {share.out: None for share in shares if shard is None}:
            if folder is not None:
                stack.enter_context(sole_run(folder))
        if shard is not None:
            for share in shares:
                records = _records(share, settings, goals, scoring, quiet=as_json)
                write_shard(share.out or Path(), shard, records)
        else:
            printed = _score_all(shares, settings, goals, scoring, as_json=as_json, wide=wide)
    if as_json:
        print_json(printed)
    elif out is not None:
        say(f"written to {out}")


def _opened(workers: int, ray: str | None) -> Scoring:
    """The workers that score: processes of this machine, or a cluster of Ray's."""
    if ray is None:
        return Scoring(workers)
    try:
        from eai.envs.ray_scoring import RayScoring
    except ImportError as error:
        raise InputError(f"--ray needs Ray: {how_to_install('ray')}") from error
    return RayScoring(ray, workers)


def _score_all(
    shares: Sequence[_Share],
    settings: Settings,
    goals: Path | None,
    scoring: Scoring,
    *,
    as_json: bool,
    wide: bool,
) -> list[Json]:
    """Score everything, write the results, and print a table a suite, unless all is printed as JSON."""
    printed: list[Json] = []
    try:
        for suite, group in groupby(shares, key=lambda share: share.suite):
            results: dict[str, Result] = {}
            effects: list[ErrataEffect | None] = []
            for share in group:
                records = _records(share, settings, goals, scoring, quiet=as_json)
                effects.append(errata_effect(records))
                rates = summarise([record.verdict for record in records], suite.ability)
                results[share.answers.model] = Result(rates, coverage_of(records))
                if share.out is not None:
                    _note_replaced(share.out / RECORDS, records[0])
                    write_results(share.out, records, rates)
                tell_authority(share.answers.model, records)
                printed.append(result_json(records, results[share.answers.model], effects[-1], share.out))
            if not as_json:
                _print(suite, results, wide=wide)
                print_errata(effects)
    except KeyboardInterrupt:
        raise InterruptError(_interrupted(shares, len(printed))) from None
    return printed


def _interrupted(shares: Sequence[_Share], done: int) -> str:
    """The message to whom interrupts scoring."""
    if not done or shares[0].out is None:
        return "interrupted; nothing is written"
    left = shares[done]
    names = f"{left.suite.domain} {left.suite.ability.value} {left.answers.model}"
    return f"interrupted; {done} of {len(shares)} files are scored and written; go on with those from {names}"


def _print(suite: Suite, results: dict[str, Result], *, wide: bool) -> None:
    title = f"{suite.domain}, {suite.ability.value}, protocol {suite.protocol.value}"
    print_rates(output(), title, declaration_of(suite.ability).terminal, results, wide=wide)
    for model, result in results.items():
        print_remark(model, result.coverage)


def _records(
    share: _Share, settings: Settings, goals: Path | None, scoring: Scoring, *, quiet: bool
) -> list[Record]:
    suite, answers = share.suite, share.answers
    answered = {response.task_id for response in answers.responses}
    missing = {task_id: NO_ROW for task_id in suite.task_ids if task_id not in answered}
    title = f"scoring {suite.domain} {suite.ability.value} {answers.model}"
    with scoring_progress(title, len(answered), quiet=quiet) as told:
        records = score_run(suite, answers, missing, settings, told, scoring)
    if goals is not None:
        believed = _believed(goals, share)
        records = [believed.marked(record) for record in records]
    if share.prompt_name is not None:
        records = [record.with_prompt_name(share.prompt_name) for record in records]
    return records


def _believed(goals: Path, share: _Share) -> Believed:
    """The goals that the questions stated whose answers these are."""
    suite = share.suite
    return read_believed(goals, suite.benchmark, suite.ability, suite.source, share.answers.model)


def _note_elsewhere(share: _Share) -> None:
    """Say on standard error how many rows are about tasks that the data set does not have, if any are."""
    if share.answers.elsewhere:
        rows = counted(share.answers.elsewhere, "answer")
        what = f"{rows} left out, to tasks that are not in the data set"
        note(f"{share.suite.domain}, {share.suite.ability.value}, {share.answers.model}: {what}")


def _note_replaced(file: Path, first: Record) -> None:
    """Say on standard error that a file of records is replaced, if it is of another run."""
    if not file.is_file():
        return
    try:
        before = next(read_records(file), first)
    except InputError as error:
        note(f"{error}; the file is replaced")
        return
    if (before.model, before.domain, before.ability) != (first.model, first.domain, first.ability):
        note(f"{file}: the records of {before.model}, {before.domain} {before.ability.value} are replaced")


def _shares_of_suite(places: Sequence[Path], suite: Suite, out: Path | None) -> list[_Share]:
    """The records of one suite; with several files each model has a folder of its own."""
    files = [file for place in places for file in files_of_suite(place, suite.domain, suite.ability)]
    given = [_in_order(_read(file, suite), suite.task_ids) for file in files]
    _refuse_twins([answers.model for answers in given])
    several = len(files) > 1
    return [_Share(suite, each, out / each.model if out and several else out) for each in given]


def _named(places: Sequence[Path], domain: str | None, ability: Ability | None) -> list[SuiteFile]:
    """The files at the places by suite, of one benchmark or ability where one is given.

    Raises:
        InputError: there is none, or two are of one model and one suite.
    """
    every = sorted((f for place in places for f in suite_files(place)), key=lambda file: file.order)
    found = [f for f in every if domain in (None, f.domain) and ability in (None, f.ability)]
    if not found:
        asked = " ".join([domain or "", ability.value if ability else ""]).strip()
        raise InputError(f"{places[0]}: no file with answers to {asked}")
    for suite, group in groupby(found, key=lambda file: (file.domain, file.ability)):
        _refuse_twins([f"{suite[0]} {suite[1].value} {file.model}" for file in group])
    return found


def _share(file: SuiteFile, suite: Suite, out: Path | None) -> _Share:
    answers = _in_order(_read(file.path, suite), suite.task_ids)
    folder = None if out is None else out / file.domain / file.ability.value / file.model
    return _Share(suite, replace(answers, model=file.model), folder)


def _read(file: Path, suite: Suite) -> ResponseFile:
    """The answers in a response file or a log; Inspect, which reads logs, is imported only for one."""
    if file.suffix != LOG_SUFFIX:
        return read_responses(file, suite.task_ids, suite.benchmark.task_id_of)
    try:
        from eai.run.evaluation import read_answers
    except ImportError as error:
        raise without_inspect(error) from error
    return read_answers(file, suite)


def _in_order(answers: ResponseFile, task_ids: tuple[str, ...]) -> ResponseFile:
    """The answers in the order of the data set."""
    by_id: dict[str, Response] = {response.task_id: response for response in answers.responses}
    return replace(answers, responses=tuple(by_id[i] for i in task_ids if i in by_id))


def _refuse_twins(names: Sequence[str]) -> None:
    """Raise if two files are of one model, because their results would overwrite each other."""
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"{name}: two files are of this model; score them one at a time")
