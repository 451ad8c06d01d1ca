"""``eai run``: obtain a model's answers and score them.

With ``--adaptive``, each task is chosen by the answers so far. The run ends when the model's skill is known
precisely.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from eai.abilities.declaration import get_declaration
from eai.abilities.experiment import Experiment
from eai.abilities.protocol import Ability, Protocol
from eai.agents.setting import STANDARD
from eai.agents.verdict import EpisodeVerdict
from eai.base.entry_points import load_from_extension
from eai.base.errors import InputError
from eai.base.files import lock_run_folder, to_file_name
from eai.base.grouping import group_pairs
from eai.benchmarks.prompt_library import PromptLibrary
from eai.benchmarks.registry import find_benchmark, list_paper_benchmarks
from eai.benchmarks.suite import Suite, open_suite
from eai.cli import console, flags, options
from eai.cli.flags import make_run_flag
from eai.cli.options import OUTPUT, SCORING, AsJson, DataFolder, Wide, make_flag
from eai.cli.progress import make_command_print_how_to_resume, show_run_progress, show_scoring_progress
from eai.cli.prompts import select_tasks_of_suites
from eai.cli.table import print_results, result_to_json
from eai.pddl.planning import PlannerChoice
from eai.results.collector import set_low_garbage_collection_threshold
from eai.results.epochs import SuiteResult, score_answers
from eai.results.repeats import make_pass_at_k_table
from eai.results.runs import write_inspect_log_names_and_epoch
from eai.results.terminal import print_table
from eai.run.job import KEPT_TASKS, QuestionJob, can_model_answer
from eai.run.journal import JOURNAL
from eai.run.spec import RunSpec, save_spec
from eai.studies.prompts.choice import make_experiment_with_prompt_name
from eai.studies.registry import add_study_summaries
from eai.studies.variation import ModelEndpoint, StageThatObtainsGoalsOrScenes
from eai.tasks.prompts.prompt import Prompt, PromptSet, make_memory_saving_prompt_mapping
from eai.tasks.source import ErrataChoice, find_errata_choice, find_planner_choice

LOGS = "logs"
SHOWN_TASKS = 5

_NUMBER = re.compile(r"\d[\d,.]*")


@dataclass(frozen=True, slots=True)
class _RunRequest:
    """Specification and output folder of a run of several suites (abilities in benchmarks).

    Attributes:
        spec: Specification of the run.
        library: Source of prompts.
        out: Folder of the results.
        quiet: Whether only errors are printed.
    """

    spec: RunSpec
    library: PromptLibrary
    out: Path
    quiet: bool


_WHO, _WHAT, _ALL = "Who is asked", "What is asked", "All options"
"""Titles of the panels of options in the help of ``eai run``."""


@make_command_print_how_to_resume
def run(
    context: typer.Context,
    file: Annotated[Path | None, typer.Argument(metavar="FILE.toml")] = None,
    model: Annotated[list[str] | None, make_run_flag("model", _WHO)] = None,
    model_arg: Annotated[list[str] | None, make_flag("-M", panel=_WHO, metavar="KEY=VALUE")] = None,
    model_base_url: Annotated[str | None, make_run_flag("model_base_url", _WHO)] = None,
    temperature: Annotated[float | None, make_run_flag("temperature", _WHO, metavar="T")] = None,
    max_tokens: Annotated[int | None, make_run_flag("max_tokens", _WHO)] = None,
    seed: Annotated[int | None, make_run_flag("seed", _WHO)] = None,
    epochs: Annotated[int | None, make_run_flag("epochs", _WHO)] = None,
    max_connections: Annotated[int | None, make_run_flag("max_connections", _WHO)] = None,
    domain: Annotated[list[str] | None, make_run_flag("domain", _WHAT)] = None,
    ability: Annotated[
        list[Ability] | None, make_run_flag("ability", _WHAT, parser=Ability.from_name)
    ] = None,
    tasks: Annotated[str | None, make_run_flag("tasks", _WHAT)] = None,
    limit: Annotated[int | None, make_run_flag("limit", _WHAT)] = None,
    adaptive: Annotated[float | None, make_run_flag("adaptive", _WHAT, metavar="S")] = None,
    prompt_set: Annotated[PromptSet | None, make_run_flag("prompt_set", _WHAT, "--set")] = None,
    prompts: Annotated[Path | None, make_run_flag("prompts", _WHAT)] = None,
    settings: Annotated[
        list[str] | None,
        make_flag(
            options.SETTING,
            help="Any option of a run, such as replanning.replans=3 or generation.top_p=0.9; "
            f"{options.SETTING} {flags.HELP} lists them all.",
            panel=_ALL,
            metavar="OPTION=VALUE",
        ),
    ] = None,
    protocol: Annotated[
        Protocol | None, make_run_flag("protocol", SCORING, parser=Protocol.from_name)
    ] = None,
    planner: Annotated[
        PlannerChoice | None, make_run_flag("planner", SCORING, parser=find_planner_choice)
    ] = None,
    errata: Annotated[
        ErrataChoice | None, make_run_flag("errata", SCORING, parser=find_errata_choice)
    ] = None,
    workers: Annotated[int | None, make_run_flag("workers", SCORING)] = None,
    out: Annotated[Path, make_flag(panel=OUTPUT)] = Path("runs"),
    quiet: Annotated[bool, make_flag(panel=OUTPUT)] = False,
    as_json: AsJson = False,
    wide: Wide = False,
    data: DataFolder = None,
) -> None:
    """Obtain answers through Inspect and score them. The same command resumes where it was interrupted.

    The options of a run are written to run.toml beside its results. FILE can be such a file.

    Exit status 1 if some tasks were not answered; until they are, they count as failed. A built-in model
    skips abilities that it has no answer to.

    With --limit, --tasks or --adaptive the results cover only these tasks, and the run is not ranked.

    Example: eai run --model eai/noisy -M rate=0.2 --domain virtualhome --ability action_sequencing

    Options:
        file: Options from a file; flags replace them.
        model_arg: An argument of the model.
        out: Folder of answers, logs, records and summaries.
        quiet: Print only errors.
    """
    if settings == [flags.HELP]:
        console.print_markdown("\n".join(flags.list_run_options()))
        return
    console.require_inspect_package()
    set_low_garbage_collection_threshold()
    spec = flags.read_run_specification(context, file, model_arg or (), settings or ())
    if not spec.model.name:
        raise InputError("expected --model NAME, or a FILE.toml with names of models in model.name")
    scoring = spec.scoring
    wanted = spec.combined_options_of_studies.select_abilities(spec.tasks.ability)
    flags.check_model_names(spec.model.name, wanted)
    terms = options.make_planner_limits_of_command(context, scoring.planner_seconds, scoring.planner_memory)
    with options.open_data_source(data, scoring.planner, scoring.errata, terms) as opened_source:
        source = replace(opened_source, kept=KEPT_TASKS)
        suites = [
            open_suite(name, each, scoring.protocol, source=source)
            for name in spec.tasks.domain or list_paper_benchmarks()
            for each in (
                wanted
                if spec.tasks.ability
                else console.select_default_abilities(find_benchmark(name), wanted)
            )
        ]
        obtain, about = None, spec.tasks
        if about.adaptive is not None:
            prepare_adaptive_runs = load_from_extension("adaptive_runs", "--adaptive")
            suites, obtain = prepare_adaptive_runs(suites, about.ability, about.calibration)
        library = PromptLibrary(spec.prompts.set, spec.prompts.folder, source)
        request = _RunRequest(spec, library, out, quiet or as_json)
        chosen = []
        for suite, ids in zip(
            suites, select_tasks_of_suites(spec.tasks.ids, suites, spec.tasks.limit), strict=True
        ):
            if ids:
                chosen.append((suite, _make_compact_prompts_by_task_id(library, suite, ids)))
    endpoints = spec.model.endpoints
    remarks = flags.describe_unsupported_abilities_of_models(
        spec.model.name, [suite.ability for suite, _ in chosen]
    )
    flags.check_replayed_files_match_suites(endpoints, [suite for suite, _ in chosen])
    console.print_note_if_planner_missing([suite for suite, _ in chosen])
    first = _make_stage_that_asks_for_goals_or_scenes(request, chosen)
    fitting = {endpoint.model: _leave_out_long_tasks(request, endpoint, chosen) for endpoint in endpoints}
    save_spec(spec, out)
    outcomes = []
    for position, (suite, asked) in enumerate(chosen):
        of_suite = [
            _request_answers_and_score(request, endpoint, fitting_prompts, suite, first, studied=True)
            if obtain is None
            else _ask_until_ability_estimate_is_precise(request, endpoint, fitting_prompts, suite, obtain)
            for endpoint in endpoints
            if can_model_answer(endpoint.model, suite.ability)
            and (fitting_prompts := fitting[endpoint.model][position])
        ]
        if of_suite and not request.quiet:
            _print_suite_results(spec, of_suite, wide=wide)
            _print_number_of_corrected_questions(library, suite, asked)
        outcomes += of_suite
    before = () if first is None else first.all_results
    if spec.combined_options_of_studies.captioning_model is not None and not request.quiet:
        for outcome in before:
            _print_suite_results(spec, [outcome], wide=wide)
    for remark in remarks:
        console.print_note(remark)
    _print_failures_and_token_usage([*before, *outcomes], request, as_json=as_json)


def _make_compact_prompts_by_task_id(
    library: PromptLibrary, suite: Suite, task_ids: Sequence[str]
) -> Mapping[str, Prompt]:
    """Return the prompts of some tasks in a form that takes little memory."""
    opened = library.open(suite.benchmark, suite.ability)
    return make_memory_saving_prompt_mapping((task_id, opened[task_id]) for task_id in task_ids)


def _leave_out_long_tasks(
    request: _RunRequest, endpoint: ModelEndpoint, chosen: Sequence[tuple[Suite, Mapping[str, Prompt]]]
) -> Sequence[Mapping[str, Prompt]]:
    """Return the prompts of suites (abilities in benchmarks) without tasks that exceed the model's context.

    Raises:
        InputError: some tasks do not fit, and they may not be left out.
    """
    from eai.run.context import (
        REMEDIES,
        describe_long_tasks,
        find_long_tasks,
        is_endpoint_on_server_of_user,
        read_context_length,
    )
    from eai.run.tasks import open_model_at_endpoint

    prompts, handling = [asked for _, asked in chosen], request.spec.requests.too_long
    if handling == "ask" or not is_endpoint_on_server_of_user(endpoint):
        return prompts
    context = read_context_length(open_model_at_endpoint(endpoint))
    if context is None:
        return prompts
    max_tokens = request.spec.generation.max_tokens
    long_tasks = [find_long_tasks(suite, asked, max_tokens, context) for suite, asked in chosen]
    fitting = [
        make_memory_saving_prompt_mapping(
            (task_id, asked[task_id]) for task_id in asked if task_id not in long.needs
        )
        for asked, long in zip(prompts, long_tasks, strict=True)
    ]
    if any(long.needs for long in long_tasks):
        message = f"{endpoint.model}: {describe_long_tasks(context, long_tasks)}"
        if handling == "stop" or not any(fitting):
            raise InputError(f"the prompts do not fit: {message}, {REMEDIES}")
        console.print_note(f"{message}; they are not asked")
    return fitting


def _print_suite_results(spec: RunSpec, outcomes: Sequence[SuiteResult], *, wide: bool) -> None:
    """Print the results of several models in one suite: the tasks of a benchmark for one ability."""
    print_results(
        {each.model: each.totals for each in outcomes},
        spec.combined_options_of_studies.results_heading,
        wide=wide,
    )
    repeated = {
        each.model: each.success_rate_contributions_by_epoch
        for each in outcomes
        if each.success_rate_contributions_by_epoch
    }
    if repeated:
        print_table(console.get_output_console(), make_pass_at_k_table(repeated), wide=wide)


def _make_stage_that_asks_for_goals_or_scenes(
    request: _RunRequest, suites_and_prompts: Sequence[tuple[Suite, Mapping[str, Prompt]]]
) -> StageThatObtainsGoalsOrScenes | None:
    """Return the first part of a run, in which a model interprets goals or perceives scenes.

    Return None if the run has no such part.
    """
    wanted: dict[str, set[str]] = {}
    for suite, asked in suites_and_prompts:
        wanted.setdefault(suite.domain, set()).update(asked)
    ask, variation = partial(_request_answers_and_score, request), request.spec.combined_options_of_studies
    if variation.captioning_model is not None:
        flags.check_captioning_model(variation.captioning_model)
    return variation.make_stage_that_obtains_goals_or_scenes(request.library, wanted, ask)


def _print_number_of_corrected_questions(
    library: PromptLibrary, suite: Suite, prompts: Mapping[str, Prompt]
) -> None:
    """Print how many questions of the data set were corrected."""
    corrected = library.count_questions_corrected_by_errata(suite.benchmark, suite.ability, prompts)
    if corrected:
        rest = "asked as corrected by errata; --errata none asks as published."
        console.print_result_line(f"{console.format_count(corrected, 'question')} {rest}")


def _request_answers_and_score(
    request: _RunRequest,
    endpoint: ModelEndpoint,
    prompts: Mapping[str, Prompt],
    suite: Suite,
    first: StageThatObtainsGoalsOrScenes | None = None,
    epochs: int | None = None,
    *,
    studied: bool = False,
) -> SuiteResult:
    """Obtain one model's answers to one suite (ability in a benchmark) through Inspect, and score them.

    Inspect is imported only here. The stage ``first`` may ask a model for the tasks' goals or scenes before
    the questions. The questions then state these goals or scenes, and a task without them gets no question.
    The number of answers for each task is ``epochs``, or else the number in the specification. If ``studied``
    is true, records contain the options of the run's studies (variations around benchmarks and abilities).
    """
    from eai.run.context import choose_default_max_answer_tokens
    from eai.run.log_scores import write_scores
    from eai.run.remarks import describe_unfulfilled_requests
    from eai.run.tasks import combine_experiments, make_suite_conversations, request_missing_answers

    spec, epochs = request.spec, epochs or request.spec.tasks.epochs
    asked, beliefs = (
        (prompts, None)
        if first is None
        else first.make_prompts_with_goals_and_scenes(endpoint, prompts, suite)
    )
    about = {} if beliefs is None else beliefs.metadata
    harness, effort = None, spec.generation.reasoning_effort
    rules: str | None = None
    prompts_name = spec.prompts.prompt_label
    if get_declaration(suite.ability).takes_turns:
        from eai.agents.play import make_episode_prompts_and_metadata

        asked, about = make_episode_prompts_and_metadata(spec.setting, asked, suite)
        rules, prompts_name = spec.setting.label or None, spec.prompts.name
        harness = None if spec.agent.harness == STANDARD.harness else spec.agent.harness
    trials = make_suite_conversations(
        spec.combined_options_of_studies.replanning if studied else None,
        request.library,
        suite,
        asked,
        beliefs,
    )
    of_studies = spec.experiment if studied else Experiment()
    parts = [
        of_studies,
        None if beliefs is None else beliefs.experiment,
        make_experiment_with_prompt_name(prompts_name),
    ]
    parts += [Experiment(rules=rules), Experiment(harness=harness, effort=effort)]
    job = QuestionJob(
        *(endpoint, suite, asked, epochs, spec.generation, spec.requests, trials, about),
        experiment=combine_experiments([*parts[:-1], Experiment(effort=effort)]),
        answer_limit=choose_default_max_answer_tokens(endpoint.model, suite, spec.generation),
    )
    place = suite.domain, suite.ability.value, to_file_name(endpoint.model)
    folder = request.out.joinpath(*place, *(each.label for each in parts if each is not None))
    title = f"{suite.domain} {suite.ability.value} {endpoint.model}"
    with lock_run_folder(folder):
        with show_run_progress(title, quiet=request.quiet) as watch:
            answers = request_missing_answers(job, folder / JOURNAL, request.out / LOGS, watch=watch)
        unasked = [(task, epoch + 1) for task in prompts if task not in asked for epoch in range(epochs)]
        lacking = dict.fromkeys(unasked, "" if beliefs is None else beliefs.missing_reason)
        obtained = replace(
            answers,
            failures={**answers.failures, **lacking},
            beliefs=beliefs,
            experiment=combine_experiments([of_studies, *parts[2:-1], Experiment(effort=effort)]),
            summarize=lambda record: add_study_summaries(record, suite, about.get(record.task_id, {})),
        )
        with show_scoring_progress(f"scoring {title}", len(answers.answers), quiet=request.quiet) as report:
            result = score_answers(obtained, folder, suite, spec.scoring, report)
        write_scores(answers.logs, result)
        for epoch, one in enumerate(result.by_epoch or (result,), 1):
            write_inspect_log_names_and_epoch(one.folder, answers.logs, epoch)
        if result.by_epoch:
            write_inspect_log_names_and_epoch(
                folder, answers.logs, result.map_tasks_to_epoch_of_recorded_answer()
            )
    return replace(result, remarks=describe_unfulfilled_requests(job, answers.answers))


def _print_failures_and_token_usage(
    outcomes: Sequence[SuiteResult], request: _RunRequest, *, as_json: bool
) -> None:
    """Print errors, used tokens and the folder of results. Exit with status 1 if answers are missing."""
    if as_json:
        known = [(each, result_to_json(each.totals, each.folder)) for each in outcomes]
        console.print_json(
            [
                {**found, "model": each.model, **each.make_summary_fields_except_metrics()}
                for each, found in known
            ]
        )
    for outcome in outcomes:
        for why, task_ids in _merge_similar_failures(outcome.task_ids_by_failure_reason):
            shown = ", ".join(task_ids[:SHOWN_TASKS]) + (", ..." if len(task_ids) > SHOWN_TASKS else "")
            console.print_note(
                f"{outcome.model}, {outcome.suite.domain} {outcome.suite.ability.value}: "
                f"{console.format_count(len(task_ids), 'task')} not answered ({shown}): {why}"
            )
        verdicts = [record.verdict for record in outcome.records]
        for remark in outcome.remarks:
            console.print_note(
                f"{outcome.model}, {outcome.suite.domain} {outcome.suite.ability.value}: {remark}"
            )
        again = sum(isinstance(verdict, EpisodeVerdict) and verdict.begun > 1 for verdict in verdicts)
        if again:
            console.print_note(
                f"{outcome.model}: {console.format_count(again, 'episode')} interrupted before, begun again"
            )
    if not request.quiet:
        for line in map(_describe_answers_and_cost, outcomes):
            console.print_result_line(line)
    if any(outcome.task_ids_by_failure_reason for outcome in outcomes):
        raise typer.Exit(1)


def _merge_similar_failures(failures: Mapping[str, Sequence[str]]) -> Iterator[tuple[str, list[str]]]:
    """Yield reasons for missing answers, each with its tasks. Merge reasons that differ only in numbers."""
    by_kind = group_pairs([(_NUMBER.sub("#", reason), reason) for reason in failures])
    for reasons in by_kind.values():
        yield reasons[0], list(dict.fromkeys([task_id for why in reasons for task_id in failures[why]]))


def _describe_answers_and_cost(result: SuiteResult) -> str:
    """Return one line on a run: numbers of answers and tokens, cost, and folder of the results."""
    usage = result.usage
    parts = [console.format_count(result.totals.coverage.answered, "answer")]
    if usage.input_tokens is not None and usage.output_tokens is not None:
        parts.append(f"{usage.input_tokens:,} + {usage.output_tokens:,} tokens")
    if usage.cost is not None:
        parts.append(console.format_dollars(usage.cost))
    if result.truncated_answer_count:
        parts.append(f"{result.truncated_answer_count} cut off")
    empty = sum(record.unanswered is None and not record.response.strip() for record in result.records)
    if empty:
        parts.append(f"{empty} empty")
    return f"{', '.join(parts)}; records in {result.folder}"


def _ask_until_ability_estimate_is_precise(
    request: _RunRequest,
    endpoint: ModelEndpoint,
    prompts: Mapping[str, Prompt],
    suite: Suite,
    ask_in_rounds: Callable[..., tuple[SuiteResult, str]],
) -> SuiteResult:
    """Ask tasks in rounds until the estimate of the model's ability is precise, and print the estimate."""
    ask = partial(_request_answers_and_score, request, endpoint, suite=suite)
    result, remark = ask_in_rounds(ask, prompts, suite, request.spec.tasks.adaptive)
    if not request.quiet:
        console.print_result_line(remark)
    return result
