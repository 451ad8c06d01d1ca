"""``eai score``: score answers in response files; write records (scored answers) and summaries."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from contextlib import AbstractContextManager, ExitStack
from dataclasses import dataclass, replace
from functools import partial
from itertools import groupby
from pathlib import Path
from typing import Annotated, TypeAlias

import typer

from eai import __version__
from eai.abilities.declaration import get_declaration
from eai.abilities.experiment import Experiment
from eai.abilities.protocol import DEFAULT_PROTOCOL, Ability, Protocol
from eai.abilities.verdict import Verdict
from eai.base.errors import InputError, UserInterruptError
from eai.base.files import LOCK_FILE, find_files_below, lock_run_folder
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
from eai.cli.logs import find_plugin_that_reads_log
from eai.cli.options import ANSWERS, OUTPUT, SCORING, make_flag, make_scoring_flag
from eai.cli.progress import make_scoring_progress_display
from eai.cli.table import print_note_if_incomplete, print_results, result_to_json
from eai.pddl.planners import resolve_automatic_choice
from eai.pddl.planning import PlannerChoice, PlannerOutcome
from eai.results import records
from eai.results.answer_files import (
    find_benchmarks_of_runs,
    find_files_of_suite,
    find_suite_files,
    read_domain_and_ability_from_path,
    unpack_answers_if_zipped,
)
from eai.results.batch import (
    OTHER_RULES,
    ProgressCallback,
    Scoring,
    map_unanswered_tasks_to_reason,
    score_run,
    split_answers_by_game_rules,
)
from eai.results.options import ScoringOptions
from eai.results.partial_records import (
    append_record_batches,
    count_kept_records,
    get_path_of_partial_file,
    publish_records,
    remove_partial_files,
)
from eai.results.record import Record
from eai.results.records import RecordBatch, RunShard, read_records
from eai.results.responses import SUFFIX, ResponseFile, find_response_files, read_responses
from eai.results.totals import RunTotals
from eai.tasks.source import ErrataChoice, Source

_AT_A_LIMIT = (PlannerOutcome.TIME, PlannerOutcome.MEMORY)

LOG_SUFFIX = ".eval"
"""File extension of Inspect's logs."""


@dataclass(frozen=True, slots=True)
class _ScoringJob:
    """A scoring job: one model's answers to one suite (ability in a benchmark), with the results' folder.

    Attributes:
        rules: Rules of the episodes in which the model answered; None for the standard rules.
        elsewhere: Ids of tasks that the model answered in episodes with other rules.
        logged: Function that adds to a record the options and results of studies in the Inspect log; None if
            the log has no such options. Studies are variations of questions.
        log: The Inspect log with the answers; None if they are in a response file.
        partial_file: File of the records until the command ends; None if nothing is written.
        kept: Number of records that an interrupted command wrote to the partial file.
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
    log: Path | None = None
    partial_file: Path | None = None
    kept: int = 0

    @property
    def records_file(self) -> Path:
        """The file of records in the folder of results, or in the working folder if no folder is given."""
        return (self.out or Path()) / (
            records.RECORDS if self.shard is None else self.shard.records_file_name
        )

    @property
    def reason_by_unanswered_task(self) -> dict[str, str]:
        """The tasks without an answer, each with the reason."""
        missing = map_unanswered_tasks_to_reason(self.suite, self.answers)
        return missing | dict.fromkeys(missing.keys() & set(self.elsewhere), OTHER_RULES)

    @property
    def combiner_of_epoch_verdicts(self) -> Callable[[Sequence[Verdict]], Verdict] | None:
        """Function that combines the verdicts of several epochs (rounds of answers); None with one epoch."""
        return get_declaration(self.suite.ability).combine_epochs if self.answers.further_epochs else None

    @property
    def record_count(self) -> int:
        """Number of records."""
        answers = len(self.answers.responses) + len(self.reason_by_unanswered_task)
        places = range(answers if self.combiner_of_epoch_verdicts is None else len(self.suite.task_ids))
        return len(places if self.shard is None else places[self.shard.number - 1 :: self.shard.of])

    @property
    def model_name_with_nonstandard_game_rules(self) -> str:
        """The name of the model, followed by the rules of its episodes if they are not standard."""
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
    workers: Annotated[int | None, make_scoring_flag("workers", show_default="1")] = None,
    ray: Annotated[str | None, options.make_ray_flag(SCORING)] = None,
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
    The same command resumes where it was interrupted.

    Without --domain or --ability, suites are taken from the paths of files, as in
    <domain>/<ability>/<model>_outputs.json or <domain>_<ability>_outputs.json. Each suite has a folder in
    OUT.

    Example: eai score gpt-4o_outputs.json --domain virtualhome --ability action_sequencing --out scores

    Example: eai score submission.zip --out scores

    Example: eai score answers --shard $SLURM_ARRAY_TASK_ID/8 --out scores; eai score scores --merge

    Options:
        paths: Response files (JSON, JSONL, Parquet), folders or zips of such files, Inspect logs, or logs of
            other projects and folders of these.
        goals: For pipelines: the answers to goal interpretation whose goals the questions stated.
        prompt_name: Name of the prompts.
        shard: Score the I-th of N parts as a separate job; --merge merges the parts.
        merge: Merge the shards in the folders PATH into the results of one process.
        out: Folder of records and summaries.
    """
    if merge:
        _merge_shards_and_print(paths, wide=wide, as_json=as_json)
        return
    if domain is None and ability is None and all(map(_is_log_of_other_project, paths)):
        find_plugin_that_reads_log(paths[0]).show_logs(context, paths, out, as_json=as_json)
        return
    for path in paths:
        find_response_files(path)  # report missing files before the data set is fetched
    settings = ScoringOptions(explanations=explanations, allow_missing=allow_missing, look_back=look_back)
    _check_options_with_shard_and_goals(shard, out, goals, ability)
    with ExitStack() as unpacking:
        places = [unpacking.enter_context(unpack_answers_if_zipped(path)) for path in paths]
        terms = options.make_planner_limits_of_command(context, planner_seconds, planner_memory)
        with options.open_data_source(data, planner, errata, terms) as source:
            if domain is not None and ability is not None:
                suite = open_suite(domain, ability, protocol, source=source)
                jobs = _list_scoring_jobs_of_suite(places, suite, out)
            else:
                jobs = _list_scoring_jobs_by_path(places, domain, ability, protocol, source, out)
        jobs = [part for job in jobs for part in _split_job_by_game_rules(job)]
        jobs = [replace(job, goals=goals, prompt_name=prompt_name, shard=shard) for job in jobs]
        print_note_if_planner_missing([job.suite for job in jobs])
        _print_note_on_unknown_tasks(jobs)
        with options.open_scoring_workers(workers, ray) as scoring, ExitStack() as stack:
            lock_file = LOCK_FILE if shard is None else f".{shard.records_file_name}.lock"
            for folder in {job.out: None for job in jobs}:
                if folder is not None:
                    stack.enter_context(lock_run_folder(folder, lock_file))
            jobs = [_add_partial_records_file_to_job(job, settings) for job in jobs]
            score_in_batches = partial(_score_in_batches, settings=settings, scoring=scoring)
            printed = _score_all_answers(jobs, score_in_batches, as_json=as_json, wide=wide)
        if as_json:
            print_json(printed)
        elif out is not None:
            print_result_line(f"written to {out}")


def _check_options_with_shard_and_goals(
    shard: RunShard | None, output_folder: Path | None, goals_file: Path | None, ability: Ability | None
) -> None:
    if shard is not None and output_folder is None:
        raise InputError("--shard: also give --out, the folder in which the shards are merged")
    if goals_file is not None and ability is not None:
        from eai.studies.pipeline.stage_one import require_ability_whose_questions_state_goals

        require_ability_whose_questions_state_goals(ability)


def _is_log_of_other_project(path: Path) -> bool:
    """Whether a path is a log that an extension can read, and that names no suite of this package.

    A folder counts if it contains such a log, and no file ``..._outputs.json``.
    """
    if path.is_dir():
        files = find_files_below(path, "[!.]*")
        return not any(f.name.endswith(SUFFIX) for f in files) and any(map(_is_log_of_other_project, files))
    if read_domain_and_ability_from_path(path) is not None or find_plugin_that_reads_log(path) is None:
        return False
    if path.suffix != LOG_SUFFIX:
        return True
    with inspect_needed():
        from eai.run.tasks import read_inspect_log
    return "ability" not in (read_inspect_log(path, header_only=True).eval.metadata or {})


def _split_job_by_game_rules(job: _ScoringJob) -> list[_ScoringJob]:
    """Split a job so that all episodes of each new job have equal game rules.

    If there are several jobs, those with other than the standard rules get their own folders.
    """
    parts = split_answers_by_game_rules(job.suite.ability, job.answers)
    jobs = []
    for rules, answers in parts.items():
        out = job.out
        if len(parts) > 1 and rules is not None:
            out = None if out is None else out / Experiment(rules=rules).label
            number = format_count(len(answers.responses), "answer")
            words = Experiment(rules=rules).game_rules_text
            print_note(
                f"{answers.model}: {number} by other rules than the standard setting, scored apart: {words}"
            )
        others = {
            task
            for other in parts
            if other != rules
            for epoch in (parts[other], *parts[other].further_epochs)
            for task in epoch.answered_task_ids
        }
        jobs.append(replace(job, answers=answers, out=out, rules=rules, elsewhere=others))
    return jobs


def _print_note_on_unknown_tasks(jobs: Sequence[_ScoringJob]) -> None:
    """Print a note on standard error if answers are to tasks outside the data set."""
    for job in jobs:
        if job.answers.skipped_rows:
            title = f"{job.suite.domain}, {job.suite.ability.value}, {job.answers.model}"
            rows = format_count(job.answers.skipped_rows, "answer")
            print_note(f"{title}: {rows} left out, to tasks that are not in the data set")


def _add_partial_records_file_to_job(job: _ScoringJob, settings: ScoringOptions) -> _ScoringJob:
    """Return the job with the file and the number of records that an interrupted command has kept."""
    if job.out is None:
        return job
    suite, source = job.suite, job.suite.source
    values = (
        __version__,
        *(suite.protocol.value, suite.benchmark.reference, suite.ability.value, suite.data_sha256),
        *(source.errata.value, resolve_automatic_choice(source.planner).value),
        *(source.terms.seconds, source.terms.memory_mib),
        *(settings.explanations, settings.allow_missing, settings.look_back),
        *(job.answers.model, job.rules, job.reason_by_unanswered_task, job.prompt_name, job.shard),
    )
    paths = [path for path in (job.log, job.goals) if path is not None]
    files = [file for path in paths for file in (find_files_below(path, "*") or [path]) if file.is_file()]
    file = get_path_of_partial_file(job.records_file, values, job.answers, files)
    return replace(job, partial_file=file, kept=count_kept_records(file))


_ScoreInBatches: TypeAlias = Callable[[_ScoringJob], Iterable[RecordBatch]]
_ShowFile: TypeAlias = Callable[[str], AbstractContextManager[ProgressCallback]]


def _score_all_answers(
    jobs: Sequence[_ScoringJob], score_in_batches: _ScoreInBatches, *, as_json: bool, wide: bool
) -> list[Json]:
    """Score all answers, write the results, and print a table for each suite or everything as JSON.

    Records of a shard (a part of a run) are only written.
    """
    number, kept = sum(job.record_count for job in jobs), sum(job.kept for job in jobs)
    if kept:
        print_note(
            f"{kept:,} of {number:,} answers are kept from an interrupted command; "
            "to score them again, give another --out"
        )
    show_file = make_scoring_progress_display(number, kept, quiet=as_json)
    printed: list[Json] = []
    try:
        for _, group in groupby(jobs, key=lambda job: job.suite):
            results: dict[str, RunTotals] = {}
            for job in group:
                totals = results[job.model_name_with_nonstandard_game_rules] = _score_suite(
                    job, score_in_batches, show_file
                )
                if job.shard is None:
                    _print_note_on_fast_downward(job.answers.model, totals)
                    printed.append(result_to_json(totals, job.out))
            if printed and not as_json:
                print_results(results, wide=wide)
    except KeyboardInterrupt:
        raise UserInterruptError(_make_message_for_interrupted_scoring(jobs, number)) from None
    for job in jobs:
        if job.partial_file is not None:
            remove_partial_files(job.records_file)
    return printed


def _score_suite(job: _ScoringJob, score_in_batches: _ScoreInBatches, show_file: _ShowFile) -> RunTotals:
    """Score a model's answers to a suite (ability in a benchmark), write records, and return the totals."""
    suite = job.suite
    if job.shard is None and job.out is not None and not job.kept:
        _print_note_on_replaced_records(job.records_file, job)
    with show_file(
        f"scoring {suite.domain} {suite.ability.value} {job.answers.model}"
    ) as add_to_answer_count:
        counted = _pass_batches_and_report_counts(score_in_batches(job), add_to_answer_count)
        if job.partial_file is None:
            totals = RunTotals()
            for _, batch_totals in counted:
                totals.add_totals_of_later_records(batch_totals)
            return totals
        totals = append_record_batches(job.partial_file, counted)
    publish_records(job.partial_file, job.records_file, totals)
    return totals


def _pass_batches_and_report_counts(
    batches: Iterable[RecordBatch], add_to_answer_count: ProgressCallback
) -> Iterator[RecordBatch]:
    for batch in batches:
        yield batch
        add_to_answer_count(batch[1].record_count)


def _make_message_for_interrupted_scoring(jobs: Sequence[_ScoringJob], answer_count: int) -> str:
    """Return the message after an interrupt, which states how many answers need not be scored again."""
    if jobs[0].partial_file is None:
        return "interrupted; nothing is written, because --out is not given"
    kept = sum(count_kept_records(job.partial_file) for job in jobs if job.partial_file)
    return f"interrupted; {kept:,} of {answer_count:,} answers are scored; the same command resumes from here"


def _score_in_batches(job: _ScoringJob, settings: ScoringOptions, scoring: Scoring) -> Iterable[RecordBatch]:
    """Score the answers, and return their records in batches.

    Records that an interrupted command has already written are not returned again. If each task has several
    answers, and the ability combines their verdicts, each task has one record with the means of its metrics.
    """
    if job.kept == job.record_count:
        return ()
    suite = job.suite
    finish = _make_prompt_origin_adder(job)
    combine_epochs = job.combiner_of_epoch_verdicts
    if combine_epochs is None:
        return scoring.score_in_batches(
            suite, job.answers, job.reason_by_unanswered_task, settings, finish, job.shard, job.kept
        )
    # imported late, because a single round of answers does not need it
    from eai.results.epochs import average_records_over_epochs

    of_epochs = [
        score_run(suite, answers, replace(job, answers=answers).reason_by_unanswered_task, settings)
        for answers in (job.answers, *job.answers.further_epochs)
    ]
    by_task = {record.task_id: record for record in average_records_over_epochs(of_epochs, combine_epochs)}
    means = [(finish or replace)(by_task[task_id]) for task_id in suite.task_ids if task_id in by_task]
    chosen = means if job.shard is None else [*job.shard.select_items_of_shard(means)]
    return [records.make_record_batch(chosen[job.kept :])]


def _make_prompt_origin_adder(job: _ScoringJob) -> Callable[[Record], Record] | None:
    """Return a function that adds to a record how its prompt was made, or None if nothing is to be added.

    The function adds the options of studies (variations of questions) from an Inspect log, the goals that a
    model stated in goal interpretation, and the prompt's name.
    """
    if job.goals is None and job.prompt_name is None:
        return job.logged
    from eai.results.epochs import add_experiment_and_belief_statistics
    from eai.studies.prompts.choice import make_experiment_with_prompt_name

    beliefs, suite = None, job.suite
    if job.goals is not None:
        from eai.studies.pipeline.stage_one import read_interpreted_goals_for_prompts

        goals = (suite.benchmark, suite.ability, suite.source, job.answers.model)
        beliefs = replace(read_interpreted_goals_for_prompts(job.goals, *goals), beliefs={}, metadata={})
    mark = partial(
        add_experiment_and_belief_statistics,
        beliefs=beliefs,
        experiment=make_experiment_with_prompt_name(job.prompt_name),
    )
    return mark if job.logged is None else partial(_apply_both, job.logged, mark)


def _apply_both(
    first: Callable[[Record], Record], second: Callable[[Record], Record], record: Record
) -> Record:
    return second(first(record))


def _print_note_on_fast_downward(name: str, totals: RunTotals) -> None:
    """Print a note on standard error if Fast Downward decided problems that the built-in search left open."""
    left = totals.second_planner_outcomes.total()
    if not left:
        return
    ended = sum(totals.second_planner_outcomes[outcome.value] for outcome in _AT_A_LIMIT)
    limits = f", {ended} of them to the end of its time or memory" if ended else ""
    problems = format_count(totals.answer_counts_by_planner.total(), "problem")
    print_note(f"{name}: {left} of {problems} went to Fast Downward{limits}")


def _print_note_on_replaced_records(file: Path, job: _ScoringJob) -> None:
    """Print a note on standard error if scoring replaces a file with records of another run."""
    if not file.is_file():
        return
    try:
        before = next(read_records(file), None)
    except InputError as error:
        print_note(f"{error}; the file is replaced")
        return
    run = job.answers.model, job.suite.domain, job.suite.ability
    if before is not None and (before.model, before.domain, before.ability) != run:
        print_note(
            f"{file}: the records of {before.model}, {before.domain} {before.ability.value} are replaced"
        )


def _list_scoring_jobs_of_suite(places: Sequence[Path], suite: Suite, out: Path | None) -> list[_ScoringJob]:
    """Return a scoring job for each file with answers to a suite (one ability in a benchmark).

    If there are several files, the results of each model get a folder.
    """
    files = [file for place in places for file in find_files_of_suite(place, suite.domain, suite.ability)]
    jobs = [_make_scoring_job(file, suite, out) for file in files]
    _require_different_models([job.answers.model for job in jobs])
    if out is None or len(jobs) == 1:
        return jobs
    return [replace(job, out=out / job.answers.model) for job in jobs]


def _list_scoring_jobs_by_path(
    paths: Sequence[Path],
    domain: str | None,
    ability: Ability | None,
    protocol: Protocol,
    source: Source,
    out: Path | None,
) -> list[_ScoringJob]:
    """Return a scoring job for each file whose path names its suite (one ability in a benchmark).

    Files of another benchmark or ability than the given one are left out.

    Raises:
        InputError: no path has the name of a suite, or two files have the same model and suite.
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
    jobs = []
    for (name, each), files in groupby(files_of_suite, key=lambda file: (file.domain, file.ability)):
        suite = open_suite(own.get(name, name), each, protocol, source=source)
        for file in files:
            folder = None if out is None else out / name / each.value / file.model
            job = _make_scoring_job(file.path, suite, folder)
            jobs.append(replace(job, answers=replace(job.answers, model=file.model)))
    return jobs


def _make_scoring_job(file: Path, suite: Suite, out: Path | None) -> _ScoringJob:
    """Return the job of scoring the answers in a file.

    From an Inspect log, the options of studies (variations of questions) are read, too.
    Inspect is imported only for logs.
    """
    if file.suffix != LOG_SUFFIX:
        answers = read_responses(file, suite.task_ids, suite.benchmark.data.task_id_of, samples=True)
        return _ScoringJob(suite, answers, out)
    with inspect_needed():
        from eai.run.tasks import make_function_adding_logged_study_results, read_answers
    answers, logged = read_answers(file, suite), make_function_adding_logged_study_results(file, suite)
    return _ScoringJob(suite, answers, out, logged=logged, log=file)


def _require_different_models(names: Sequence[str]) -> None:
    """Raise if two files belong to one model, because their results would overwrite each other."""
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"{name}: two files are of this model; score them one at a time")


def _merge_shards_and_print(paths: Sequence[Path], *, wide: bool, as_json: bool) -> None:
    """Merge the shards of runs (parts scored by separate jobs), as if one job had scored them."""
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
                f"{format_count(totals.record_count, 'record')} written to {folder}"
            )
    if as_json:
        print_json(printed)
