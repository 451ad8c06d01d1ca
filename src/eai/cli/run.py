"""``eai run``: obtain a model's answers and score them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from eai.abilities.protocol import Ability, Protocol
from eai.benchmark.prompt_library import Library
from eai.benchmark.registry import find_benchmark, of_the_paper
from eai.benchmark.suite import Suite, open_suite
from eai.cli import console, flags, options
from eai.cli.flags import run_flag
from eai.cli.options import OUTPUT, SCORING, AsJson, DataFolder, Wide, flag
from eai.cli.order import Order, adaptive_suites, obtain_adaptively, obtain_and_score, tell
from eai.cli.progress import resumable
from eai.cli.prompts import chosen_prompts, tasks_of
from eai.cli.table import print_results, suite_title
from eai.errors import InputError
from eai.pddl.planning import PlannerChoice
from eai.prompts.prompt import Prompt, PromptSet
from eai.results.repeats import passes_table
from eai.results.terminal import print_table
from eai.run.job import answers
from eai.run.spec import RunSpec, save
from eai.scoring.epochs import SuiteResult
from eai.scoring.trials import open_trials
from eai.studies.variation import Stage
from eai.tasks.source import ErrataChoice, errata_choice, planner_choice

_WHO, _WHAT, _ALL = "Who is asked", "What is asked", "All options"
"""Panels of the help."""


@resumable
def run(
    context: typer.Context,
    file: Annotated[
        Path | None, typer.Argument(metavar="FILE.toml", help="Options from a file; flags replace them.")
    ] = None,
    model: Annotated[list[str] | None, run_flag("model", _WHO)] = None,
    model_arg: Annotated[
        list[str] | None, flag("An argument of the model.", "-M", panel=_WHO, metavar="KEY=VALUE")
    ] = None,
    model_base_url: Annotated[str | None, run_flag("model_base_url", _WHO)] = None,
    temperature: Annotated[float | None, run_flag("temperature", _WHO, metavar="T")] = None,
    max_tokens: Annotated[int | None, run_flag("max_tokens", _WHO)] = None,
    seed: Annotated[int | None, run_flag("seed", _WHO)] = None,
    epochs: Annotated[int | None, run_flag("epochs", _WHO)] = None,
    max_connections: Annotated[int | None, run_flag("max_connections", _WHO)] = None,
    domain: Annotated[list[str] | None, run_flag("domain", _WHAT)] = None,
    ability: Annotated[list[Ability] | None, run_flag("ability", _WHAT, parser=Ability.named)] = None,
    tasks: Annotated[str | None, run_flag("tasks", _WHAT)] = None,
    limit: Annotated[int | None, run_flag("limit", _WHAT)] = None,
    adaptive: Annotated[float | None, run_flag("adaptive", _WHAT, metavar="S")] = None,
    prompt_set: Annotated[PromptSet | None, run_flag("prompt_set", _WHAT, "--set")] = None,
    prompts: Annotated[Path | None, run_flag("prompts", _WHAT)] = None,
    settings: Annotated[
        list[str] | None,
        flag(
            "Any option of a run, such as attempts.replans=3 or generation.top_p=0.9; "
            f"{options.SETTING} {flags.HELP} lists them all.",
            options.SETTING,
            panel=_ALL,
            metavar="OPTION=VALUE",
        ),
    ] = None,
    protocol: Annotated[Protocol | None, run_flag("protocol", SCORING, parser=Protocol.named)] = None,
    planner: Annotated[PlannerChoice | None, run_flag("planner", SCORING, parser=planner_choice)] = None,
    errata: Annotated[ErrataChoice | None, run_flag("errata", SCORING, parser=errata_choice)] = None,
    workers: Annotated[int | None, run_flag("workers", SCORING)] = None,
    out: Annotated[Path, flag("Where answers, logs, records, summaries go.", panel=OUTPUT)] = Path("runs"),
    quiet: Annotated[bool, flag("Print nothing but what went wrong.", "--quiet", panel=OUTPUT)] = False,
    as_json: AsJson = False,
    wide: Wide = False,
    data: DataFolder = None,
) -> None:
    """Obtain answers through Inspect and score them. The same command resumes where it was interrupted.

    The options of a run are written to run.toml beside its results, and read from such a file.

    Exit status 1 if some tasks were not answered; until they are, they count as failed. A built-in model
    skips abilities that it has no answer to.

    With --limit, --tasks or --adaptive the numbers are of these tasks alone, and the run is not ranked.

    Example: eai run --model eai/noisy -M rate=0.2 --domain virtualhome --ability action_sequencing
    """
    if settings == [flags.HELP]:
        console.print_markdown("\n".join(flags.listing()))
        return
    console.need_inspect()
    spec = flags.specification(context, file, model_arg or (), settings or ())
    if not spec.model.name:
        raise InputError("expected --model NAME, or a file with the names of models")
    target, scoring = spec.tasks.adaptive, spec.scoring
    wanted = spec.variation.abilities(spec.tasks.ability)
    flags.check_models(spec.model.name, wanted)
    order = Order(spec, out, quiet or as_json)
    terms = options.planner_terms(context, scoring.planner_seconds, scoring.planner_memory)
    with options.opened_source(data, scoring.planner, scoring.errata, terms) as source:
        suites = [
            open_suite(name, each, scoring.protocol, source=source)
            for name in spec.tasks.domain or of_the_paper()
            for each in (
                wanted if spec.tasks.ability else console.asked_by_default(find_benchmark(name), wanted)
            )
        ]
        if target is not None:
            suites = adaptive_suites(suites, spec.tasks.ability, spec.tasks.calibration)
        library = Library(spec.prompts.set, spec.prompts.folder, source)
        chosen = []
        for suite, named in zip(suites, tasks_of(spec.tasks.ids, suites), strict=True):
            asked = chosen_prompts(suite, library, named, spec.tasks.limit)
            if asked:
                chosen.append((suite, asked))
    endpoints = spec.model.endpoints
    remarks = flags.skipped(spec.model.name, [suite.ability for suite, _ in chosen])
    flags.check_replay(endpoints, [suite for suite, _ in chosen])
    console.note_planner([suite for suite, _ in chosen])
    first = _first_stage(library, order, chosen)
    save(spec, out)
    outcomes, experiment = [], spec.variation.experiment
    for suite, asked in chosen:
        trials = None
        if experiment is not None:
            asker = library.asker(suite.benchmark, suite.ability, asked)
            trials = open_trials(suite, experiment, asker, asked)
        of_suite = [
            obtain_and_score(order, endpoint, asked, suite, trials, first)
            if target is None
            else obtain_adaptively(order, endpoint, asked, suite, target)
            for endpoint in endpoints
            if answers(endpoint.model, suite.ability)
        ]
        if of_suite and not order.quiet:
            _print(spec, of_suite, wide=wide)
            _tell_corrected(library, suite, asked)
        outcomes += of_suite
    before = () if first is None else first.outcomes
    if spec.variation.captioner is not None and not order.quiet:
        for outcome in before:
            _print(spec, [outcome], wide=wide)
    for remark in remarks:
        console.note(remark)
    tell([*before, *outcomes], order, as_json=as_json)


def _print(spec: RunSpec, outcomes: Sequence[SuiteResult], *, wide: bool) -> None:
    """Print the results of several models in one suite."""
    suite = outcomes[0].suite
    results = {each.model: each.totals for each in outcomes}
    title = f"{suite_title(suite.domain, suite.ability, suite.protocol)}\n{spec.variation.heading}".rstrip()
    print_results(title, suite.ability, results, wide=wide)
    repeated = {each.model: each.right_by_epoch for each in outcomes if each.right_by_epoch}
    if repeated:
        print_table(console.output(), passes_table(repeated), wide=wide)


def _first_stage(
    library: Library, order: Order, chosen: Sequence[tuple[Suite, Mapping[str, Prompt]]]
) -> Stage | None:
    """The stage before the questions, if there is one: goals are interpreted, or scenes are seen."""
    wanted: dict[str, set[str]] = {}
    for suite, asked in chosen:
        wanted.setdefault(suite.domain, set()).update(asked)
    ask, variation = partial(obtain_and_score, order), order.spec.variation
    if variation.captioner is not None:
        flags.check_captioner(variation.captioner)
    return variation.stage(library, wanted, ask)


def _tell_corrected(library: Library, suite: Suite, prompts: Mapping[str, Prompt]) -> None:
    """Say how many of the data set's questions were not asked as they are published."""
    corrected = library.corrected(suite.benchmark, suite.ability, prompts)
    if corrected:
        rest = "asked as corrected by errata; --errata none asks as published."
        console.say(f"{console.counted(corrected, 'question')} {rest}")
