"""``eai score``: write records and summaries from response files."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from functools import partial
from itertools import groupby
from pathlib import Path
from typing import Annotated

import typer

from eai.abilities.declaration import get_declaration
from eai.abilities.experiment import Experiment
from eai.abilities.protocol import DEFAULT_PROTOCOL, Ability, Protocol
from eai.base.entry_points import load_from_extension
from eai.base.errors import InputError, InterruptError, require_extra
from eai.base.files import lock_run_folder
from eai.base.json_value import Json
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.suite import Suite, open_suite
from eai.cli import options
from eai.cli.console import (
    DOMAIN_HELP,
    format_count,
    inspect_needed,
    print_json,
    print_note,
    print_note_if_planner_missing,
    print_result_line,
)
from eai.cli.options import ANSWERS, OUTPUT, SCORING, make_flag, make_scoring_flag
from eai.cli.progress import show_scoring_progress
from eai.cli.table import print_note_if_incomplete, print_results, result_to_json
from eai.pddl.planning import PlannerChoice, PlannerOutcome
from eai.results import records
from eai.results.answer_files import (
    find_benchmarks_of_runs,
    find_files_of_suite,
    find_suite_files,
    unpack_answers,
)
from eai.results.batch import (
    OTHER_RULES,
    Scoring,
    map_unanswered_tasks_to_reason,
    score_run,
    split_answers_by_game_rules,
)
from eai.results.options import ScoringOptions
from eai.results.record import Record
from eai.results.records import RecordBatch, RunShard, read_records
from eai.results.responses import ResponseFile, find_response_files, read_responses
from eai.results.totals import RunTotals
from eai.tasks.source import ErrataChoice, Source

_AT_A_LIMIT = (PlannerOutcome.TIME, PlannerOutcome.MEMORY)

LOG_SUFFIX = ".eval"
"""File extension of Inspect's logs."""


@dataclass(frozen=True, slots=True)
class _AnswersToScore:
    """The answers of one model to one suite, with the folder for the results.

    Attributes:
        rules: Rules of the episodes in which the model answered; None for the standard rules.
        elsewhere: Ids of tasks that the model answered in episodes with other rules.
        logged: Function that adds, to a record, the options of studies that its Inspect log contains; None if
            there are no such options.
    """

    suite: Suite
    answers: ResponseFile
    out: Path | None
    rules: str | None = None
    elsewhere: Collection[str] = ()
    goals: Path | None = None
    prompt_name: str | None = None
    shard: RunShard | None = None
    logged: Callable[[Record], Record] | None = None

    @property
    def name(self) -> str:
        """The name of the model, followed by its game rules if they are not standard."""
        return ", ".join(filter(None, (self.answers.model, Experiment(rules=self.rules).game_rules_text)))


def score(
    context: typer.Context,
    paths: Annotated[list[Path], typer.Argument(metavar="PATH")],
    domain: Annotated[str | None, make_flag(help=DOMAIN_HELP, panel=ANSWERS)] = None,
    ability: Annotated[
        Ability | None, make_flag(help=f"{options.ABILITIES}.", panel=ANSWERS, parser=Ability.from_name)
    ] = None,
    protocol: Annotated[
        Protocol, make_scoring_flag("protocol", parser=Protocol.from_name)
    ] = DEFAULT_PROTOCOL,
    planner: options.Planner = PlannerChoice.AUTO,
    errata: options.Errata = ErrataChoice.CURRENT,
    planner_seconds: Annotated[int | None, make_scoring_flag("planner_seconds")] = None,
    planner_memory: Annotated[int | None, make_scoring_flag("planner_memory", metavar="MIB")] = None,
    workers: Annotated[int, make_scoring_flag("workers")] = 1,
    ray: Annotated[str | None, make_flag(panel=SCORING, metavar="ADDRESS")] = None,
    explanations: Annotated[bool, make_scoring_flag("explanations")] = True,
    allow_missing: Annotated[bool, make_scoring_flag("allow_missing")] = False,
    look_back: Annotated[int | None, make_scoring_flag("look_back", metavar="STATES")] = None,
    goals: Annotated[Path | None, make_flag(panel=ANSWERS)] = None,
    prompt_name: Annotated[str | None, make_flag(panel=ANSWERS)] = None,
    shard: Annotated[RunShard | None, make_flag(panel=SCORING, parser=RunShard.parse, metavar="I/N")] = None,
    merge: Annotated[bool, make_flag(panel=SCORING)] = False,
    out: Annotated[Path | None, make_flag(panel=OUTPUT)] = None,
    as_json: options.AsJson = False,
    wide: options.Wide = False,
    data: options.DataFolder = None,
) -> None:
    """Score answers: write verdicts to OUT/records.jsonl and rates to OUT/summary.json, print the main table.

    A task without an answer counts as failed. With several files, each model has its own folder in OUT.

    Without --domain or --ability, suites are taken from the paths of files, as in
    <domain>/<ability>/<model>_outputs.json or <domain>_<ability>_outputs.json. Each suite has a folder in
    OUT.

    Example: eai score gpt-4o_outputs.json --domain virtualhome --ability action_sequencing --out scores

    Example: eai score submission.zip --out scores

    Example: eai score answers --shard $SLURM_ARRAY_TASK_ID/8 --out scores; eai score scores --merge

    Options:
        paths: Response files (JSON, JSONL, Parquet), folders or zips of such files, or Inspect logs.
        ray: Score with --workers on a Ray cluster: auto, HOST:PORT, or local.
        goals: For pipelines: the answers to goal interpretation whose goals the questions stated.
        prompt_name: Name of the prompts.
        shard: Score the I-th of N parts as a separate job; --merge merges the parts.
        merge: Merge the shards in the folders PATH into the results of one process.
        out: Folder of records and summaries.
    """
    if merge:
        _merge_shards_and_print(paths, wide=wide, as_json=as_json)
        return
    for path in paths:
        find_response_files(path)  # report missing files before the data set is fetched
    settings = ScoringOptions(
        workers=workers, explanations=explanations, allow_missing=allow_missing, look_back=look_back
    )
    if shard is not None and out is None:
        raise InputError("--shard: also give --out, the folder in which the shards are merged")
    if goals is not None and ability is not None:
        from eai.studies.pipeline.stage_one import require_questions_state_goals

        require_questions_state_goals(ability)
    with ExitStack() as unpacking:
        places = [unpacking.enter_context(unpack_answers(path)) for path in paths]
        terms = options.open_planner_limits(context, planner_seconds, planner_memory)
        with options.open_data_source(data, planner, errata, terms) as source:
            if domain is not None and ability is not None:
                suite = open_suite(domain, ability, protocol, source=source)
                shares = _find_answers_of_suite(places, suite, out)
            else:
                shares = _find_answers_by_path(places, domain, ability, protocol, source, out)
        shares = [part for share in shares for part in _split_answers_by_game_rules(share)]
        shares = [replace(share, goals=goals, prompt_name=prompt_name, shard=shard) for share in shares]
        print_note_if_planner_missing([share.suite for share in shares])
        _print_note_on_unknown_tasks(shares)
        with _open_scoring(workers, ray) as workplace, ExitStack() as stack:
            for folder in {share.out: None for share in shares if shard is None}:
                if folder is not None:
                    stack.enter_context(lock_run_folder(folder))
            parts_of = partial(_score_in_batches, settings=settings, workplace=workplace, quiet=as_json)
            if shard is not None:
                for share in shares:
                    records.write_shard(share.out or Path(), shard, parts_of(share))
            printed = (
                _score_all_answers(shares, parts_of, as_json=as_json, wide=wide) if shard is None else []
            )
        if as_json:
            print_json(printed)
        elif out is not None:
            print_result_line(f"written to {out}")


def _split_answers_by_game_rules(answers_to_score: _AnswersToScore) -> list[_AnswersToScore]:
    """Split answers by their game rules. If there are several rules, each has a separate folder."""
    parts = split_answers_by_game_rules(answers_to_score.suite.ability, answers_to_score.answers)
    shares = []
    for rules, answers in parts.items():
        out = answers_to_score.out
        if len(parts) > 1 and rules is not None:
            out = None if out is None else out / Experiment(rules=rules).label
            number = format_count(len(answers.responses), "answer")
            words = Experiment(rules=rules).game_rules_text
            print_note(
                f"{answers.model}: {number} by other rules than the standard setting, scored apart: {words}"
            )
        others = {task for other in parts if other != rules for task in parts[other].answered_task_ids}
        shares.append(replace(answers_to_score, answers=answers, out=out, rules=rules, elsewhere=others))
    return shares


def _print_note_on_unknown_tasks(shares: Sequence[_AnswersToScore]) -> None:
    """Print a note on standard error if answers are to tasks outside the data set."""
    for share in shares:
        if share.answers.skipped_rows:
            title = f"{share.suite.domain}, {share.suite.ability.value}, {share.answers.model}"
            rows = format_count(share.answers.skipped_rows, "answer")
            print_note(f"{title}: {rows} left out, to tasks that are not in the data set")


def _open_scoring(workers: int, ray: str | None) -> Scoring:
    """Open the processes that score, on this machine or on a Ray cluster, for the time of a block."""
    if ray is None:
        return Scoring(workers)
    with require_extra("ray", "--ray needs"):
        on_cluster: Callable[[str, int], Scoring] = load_from_extension("scoring_on_ray", "--ray")
    return on_cluster(ray, workers)


def _score_all_answers(
    shares: Sequence[_AnswersToScore],
    parts_of: Callable[[_AnswersToScore], Iterable[RecordBatch]],
    *,
    as_json: bool,
    wide: bool,
) -> list[Json]:
    """Score all answers, write the results, and print a table for each suite or everything as JSON."""
    printed: list[Json] = []
    try:
        for _, group in groupby(shares, key=lambda share: share.suite):
            results: dict[str, RunTotals] = {}
            for share in group:
                totals = results[share.name] = _score_suite(share, parts_of(share))
                _print_note_on_fast_downward(share.answers.model, totals)
                printed.append(result_to_json(totals, share.out))
            if not as_json:
                print_results(results, wide=wide)
    except KeyboardInterrupt:
        raise InterruptError(_write_interrupt_message(shares, len(printed))) from None
    return printed


def _score_suite(share: _AnswersToScore, parts: Iterable[RecordBatch]) -> RunTotals:
    """Score a model's answers to a suite, write its records, and return its totals."""
    if share.out is not None:
        _print_note_on_replaced_records(share.out / records.RECORDS, share)
        return records.write_record_batches(share.out, parts)
    totals = RunTotals()
    for _, part in parts:
        totals.add_later_totals(part)
    return totals


def _write_interrupt_message(shares: Sequence[_AnswersToScore], scored: int) -> str:
    """Return the message after an interrupt, which names the files that are still to be scored."""
    if not scored or shares[0].out is None:
        return "interrupted; nothing is written"
    left = shares[scored]
    names = f"{left.suite.domain} {left.suite.ability.value} {left.answers.model}"
    return (
        f"interrupted; {scored} of {len(shares)} files are scored and written; go on with those from {names}"
    )


def _score_in_batches(
    share: _AnswersToScore, settings: ScoringOptions, workplace: Scoring, *, quiet: bool
) -> Iterable[RecordBatch]:
    """Return the records of all answers in batches.

    If the answers have several epochs, each task has one record with the means of its metrics over the
    epochs.
    """
    averaged = get_declaration(share.suite.ability).combine_epochs
    if averaged is None or not share.answers.further_epochs:
        return _score_and_show_progress(share, settings, workplace, quiet=quiet)
    # imported late, because answers of one epoch do not need it
    from eai.results.epochs import average_records_over_epochs

    suite = share.suite
    of_epochs = [
        score_run(suite, answers, map_unanswered_tasks_to_reason(suite, answers), settings)
        for answers in (share.answers, *share.answers.further_epochs)
    ]
    by_task = {record.task_id: record for record in average_records_over_epochs(of_epochs, averaged)}
    finish = _make_adder_of_study_fields(share) or replace
    means = [finish(by_task[task_id]) for task_id in suite.task_ids if task_id in by_task]
    return [records.make_record_batch(means if share.shard is None else [*share.shard.select(means)])]


def _score_and_show_progress(
    share: _AnswersToScore, settings: ScoringOptions, workplace: Scoring, *, quiet: bool
) -> Iterator[RecordBatch]:
    suite, answers = share.suite, share.answers
    missing = map_unanswered_tasks_to_reason(suite, answers)
    missing |= dict.fromkeys(missing.keys() & set(share.elsewhere), OTHER_RULES)
    title = f"scoring {suite.domain} {suite.ability.value} {answers.model}"
    with show_scoring_progress(title, len(answers.responses) + len(missing), quiet=quiet) as report:
        done = 0
        for part in workplace.score_in_batches(
            suite, answers, missing, settings, _make_adder_of_study_fields(share), share.shard
        ):
            yield part
            done += part[1].number
            report(done)


def _make_adder_of_study_fields(share: _AnswersToScore) -> Callable[[Record], Record] | None:
    """Return a function that adds to a record how its prompt was made, or None if nothing is to be added.

    It adds the options of studies from a log, the goals that a model's interpretation stated, and the
    prompt's name.
    """
    if share.goals is None and share.prompt_name is None:
        return share.logged
    from eai.results.epochs import add_beliefs_and_experiment
    from eai.studies.prompts.choice import make_prompt_name_experiment

    beliefs, suite = None, share.suite
    if share.goals is not None:
        from eai.studies.pipeline.stage_one import read_goal_beliefs

        goals = (suite.benchmark, suite.ability, suite.source, share.answers.model)
        beliefs = replace(read_goal_beliefs(share.goals, *goals), beliefs={}, metadata={})
    mark = partial(
        add_beliefs_and_experiment, beliefs=beliefs, experiment=make_prompt_name_experiment(share.prompt_name)
    )
    return mark if share.logged is None else partial(_apply_both, share.logged, mark)


def _apply_both(
    first: Callable[[Record], Record], second: Callable[[Record], Record], record: Record
) -> Record:
    return second(first(record))


def _print_note_on_fast_downward(name: str, totals: RunTotals) -> None:
    """Print a note on standard error if Fast Downward decided problems that the built-in search left open."""
    left = totals.left.total()
    if not left:
        return
    ended = sum(totals.left[outcome.value] for outcome in _AT_A_LIMIT)
    limits = f", {ended} of them to the end of its time or memory" if ended else ""
    print_note(
        f"{name}: {left} of {format_count(totals.judges.total(), 'problem')} went to Fast Downward{limits}"
    )


def _print_note_on_replaced_records(file: Path, share: _AnswersToScore) -> None:
    """Print a note on standard error if scoring replaces a file with records of another run."""
    if not file.is_file():
        return
    try:
        before = next(read_records(file), None)
    except InputError as error:
        print_note(f"{error}; the file is replaced")
        return
    run = share.answers.model, share.suite.domain, share.suite.ability
    if before is not None and (before.model, before.domain, before.ability) != run:
        print_note(
            f"{file}: the records of {before.model}, {before.domain} {before.ability.value} are replaced"
        )


def _find_answers_of_suite(places: Sequence[Path], suite: Suite, out: Path | None) -> list[_AnswersToScore]:
    """Return the answers to one suite. If there are several files, each model gets a folder for results."""
    files = [file for place in places for file in find_files_of_suite(place, suite.domain, suite.ability)]
    answers_by_file = [_read_answers_and_experiment_adder(file, suite) for file in files]
    _require_different_models([answers.model for answers, _ in answers_by_file])
    several = len(files) > 1
    return [
        _AnswersToScore(suite, answers, out / answers.model if out and several else out, logged=logged)
        for answers, logged in answers_by_file
    ]


def _find_answers_by_path(
    paths: Sequence[Path],
    domain: str | None,
    ability: Ability | None,
    protocol: Protocol,
    source: Source,
    out: Path | None,
) -> list[_AnswersToScore]:
    """Yield the answers in files whose paths name their suites, of one benchmark or ability if given.

    Raises:
        InputError: No file names a suite, or two files have the same model and suite.
    """
    own = find_benchmarks_of_runs(paths)
    named = None
    if domain is not None:
        benchmark = find_benchmark(domain)
        named, own = benchmark.name, {**own, benchmark.name: benchmark}
    every = sorted(
        (f for place in paths for f in find_suite_files(place, own)), key=lambda file: file.sort_key
    )
    files_of_suite = [f for f in every if named in (None, f.domain) and ability in (None, f.ability)]
    if not files_of_suite:
        asked = " ".join([domain or "", ability.value if ability else ""]).strip()
        raise InputError(f"{paths[0]}: no file with answers to {asked}")
    _require_different_models([f"{file.domain} {file.ability.value} {file.model}" for file in files_of_suite])
    shares = []
    for (name, each), files in groupby(files_of_suite, key=lambda file: (file.domain, file.ability)):
        suite = open_suite(own.get(name, name), each, protocol, source=source)
        for file in files:
            folder = None if out is None else out / name / each.value / file.model
            answers, logged = _read_answers_and_experiment_adder(file.path, suite)
            shares.append(_AnswersToScore(suite, replace(answers, model=file.model), folder, logged=logged))
    return shares


def _read_answers_and_experiment_adder(
    file: Path, suite: Suite
) -> tuple[ResponseFile, Callable[[Record], Record] | None]:
    """Return the answers in a file, and a function that adds the options of studies in the file to records.

    The function is None if the file contains no such options, as in a response file. Inspect is imported only
    for logs.
    """
    if file.suffix != LOG_SUFFIX:
        return read_responses(file, suite.task_ids, suite.benchmark.data.task_id_of, samples=True), None
    with inspect_needed():
        from eai.run.tasks import make_experiment_adder, read_answers
    return read_answers(file, suite), make_experiment_adder(file, suite)


def _require_different_models(names: Sequence[str]) -> None:
    """Raise if two files belong to one model, because their results would overwrite each other."""
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"{name}: two files are of this model; score them one at a time")


def _merge_shards_and_print(paths: Sequence[Path], *, wide: bool, as_json: bool) -> None:
    """Merge shards into records and summaries equal to those of one process."""
    printed: list[Json] = []
    for folder, files in [found for path in paths for found in records.find_shards(path).items()]:
        totals = records.merge_shards(folder, files)
        first = totals.first_record
        printed.append(result_to_json(totals, folder))
        if as_json:
            print_note_if_incomplete(first.model, totals.coverage)
        else:
            print_results({first.model: totals}, wide=wide)
            print_result_line(
                f"{format_count(len(files), 'shard')} of "
                f"{format_count(totals.number, 'record')} written to {folder}"
            )
    if as_json:
        print_json(printed)
