"""``eai run``: obtain a model's answers and score them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated

import typer

from eai.abilities.declarations import DECLARATIONS
from eai.abilities.experiment import FeedbackForm, World, chosen_experiment
from eai.benchmark.prompt_library import Library
from eai.benchmark.registry import registered
from eai.benchmark.suite import DEFAULT_PROTOCOL, Suite, open_suite
from eai.cli.adaptive import adaptive_suites, obtain_adaptively
from eai.cli.arm import Arm
from eai.cli.asked import (
    Abilities,
    Adaptive,
    Batch,
    Domains,
    Limit,
    MaxConnections,
    MaxRetries,
    OfSet,
    Prices,
    PromptName,
    Prompts,
    Tasks,
    Timeout,
)
from eai.cli.chosen_tasks import chosen_prompts, tasks_of
from eai.cli.console import (
    counted,
    data_progress,
    need_inspect,
    note_planner,
    output,
    print_errata,
    print_remark,
    say,
)
from eai.cli.experiment import (
    Ending,
    Goals,
    InForm,
    InWorld,
    OfFeedback,
    OfNotice,
    Preset,
    Replans,
    Slip,
    SlipSeed,
)
from eai.cli.first_stage import FirstStage
from eai.cli.models import (
    Epochs,
    MaxTokens,
    ModelArguments,
    Models,
    ModelUrl,
    ReasoningEffort,
    ReasoningTokens,
    Seed,
    Stop,
    Structured,
    Temperature,
    TopP,
    check_models,
    check_replay,
    eyes,
    pair,
    sampling,
)
from eai.cli.options import (
    OUTPUT,
    AllowMissing,
    AsJson,
    Errata,
    Explanations,
    Planner,
    PlannerMemory,
    PlannerSeconds,
    Rules,
    Wide,
    Workers,
)
from eai.cli.order import Order, obtain_and_score, tell
from eai.cli.planning import planner_terms
from eai.cli.progress import resumable
from eai.cli.scene import (
    InClutter,
    InScene,
    SceneImages,
    SceneModel,
    SceneModelArgument,
    SceneModelUrl,
    SceneNoise,
)
from eai.cli.scene_stage import Scenes
from eai.cli.store import DataFolder, store
from eai.cli.table import Result, print_rates
from eai.pddl.planning import PlannerChoice
from eai.prompts.prompt import Prompt, PromptSet
from eai.reference.replanning import preset_experiment
from eai.results.errata_effect import errata_effect
from eai.run.job import Decoding, Endpoint, Pace
from eai.scoring.batch import Settings
from eai.studies.perception.noise import noise_of
from eai.studies.perception.showing import Scene, SceneChoice
from eai.tasks.source import ErrataChoice, Source
from eai.world.episode import Notice


@resumable
def run(
    context: typer.Context,
    model: Models,
    model_arg: ModelArguments = None,
    model_base_url: ModelUrl = None,
    temperature: Temperature = 0.0,
    max_tokens: MaxTokens = None,
    top_p: TopP = None,
    seed: Seed = None,
    reasoning_effort: ReasoningEffort = None,
    reasoning_tokens: ReasoningTokens = None,
    stop: Stop = True,
    structured: Structured = False,
    epochs: Epochs = 1,
    domain: Domains = None,
    ability: Abilities = None,
    tasks: Tasks = "",
    limit: Limit = None,
    adaptive: Adaptive = None,
    prompt_set: OfSet = PromptSet.OFFICIAL,
    prompts: Prompts = None,
    prompt_name: PromptName = None,
    max_connections: MaxConnections = None,
    max_retries: MaxRetries = 5,
    timeout: Timeout = None,
    batch: Batch = False,
    prices: Prices = None,
    replans: Replans = 0,
    world: InWorld = World.RESTART,
    feedback: OfFeedback = None,
    feedback_form: InForm = FeedbackForm.PROMPT,
    slip: Slip = 0.0,
    slip_seed: SlipSeed = 0,
    slip_notice: OfNotice = Notice.DETECTED,
    until: Ending = None,
    preset: Preset = "",
    goals: Goals = None,
    scene: InScene = Scene.TEXT,
    noise: SceneNoise = None,
    images: SceneImages = None,
    clutter: InClutter = None,
    scene_model: SceneModel = None,
    scene_arg: SceneModelArgument = None,
    scene_base_url: SceneModelUrl = None,
    protocol: Rules = DEFAULT_PROTOCOL,
    planner: Planner = PlannerChoice.AUTO,
    errata: Errata = ErrataChoice.CURRENT,
    planner_seconds: PlannerSeconds = None,
    planner_memory: PlannerMemory = None,
    workers: Workers = 1,
    explanations: Explanations = True,
    allow_missing: AllowMissing = False,
    out: Annotated[
        Path,
        typer.Option(help="Where answers, logs, records, summaries go.", rich_help_panel=OUTPUT),
    ] = Path("runs"),
    quiet: Annotated[
        bool,
        typer.Option("--quiet", help="Print nothing but what went wrong.", rich_help_panel=OUTPUT),
    ] = False,
    as_json: AsJson = False,
    wide: Wide = False,
    data: DataFolder = None,
) -> None:
    """Obtain answers through Inspect and score them. The same command goes on where it was interrupted.

    Exit status 1 if some tasks were not answered; until they are, they count as failed.

    With --limit, --tasks or --adaptive the numbers are of these tasks alone, and the run is not ranked.

    Example: eai run --model eai/noisy -M rate=0.2 --domain virtualhome --ability action_sequencing
    """
    need_inspect()
    check_models(model)
    how = (replans, world, feedback, feedback_form, slip, slip_seed, slip_notice, until)
    experiment = preset_experiment(preset, slip, slip_seed, replans) or chosen_experiment(*how)
    seeing = eyes(scene_model, scene_arg, scene_base_url, prices)
    seen_with = None if seeing is None else seeing.model
    shown = SceneChoice(scene, images, clutter, seen_with, noise_of(noise) if noise else None)
    arm = Arm(experiment, goals, adaptive, shown, seeing)
    wanted = arm.wanted(ability)
    arguments = dict(pair(text) for text in model_arg or ())
    order = Order(
        endpoints=[Endpoint(name, arguments, model_base_url, prices) for name in model],
        epochs=epochs,
        decoding=Decoding(
            temperature,
            max_tokens,
            stop,
            structured,
            sampling(top_p, seed, reasoning_effort, reasoning_tokens),
        ),
        pace=Pace(max_connections, max_retries, timeout, batch),
        settings=Settings(workers, explanations, allow_missing),
        out=out,
        quiet=quiet or as_json,
        prompt_name=prompt_name,
    )
    with data_progress() as report:
        terms = planner_terms(context, planner_seconds, planner_memory)
        source = Source(store(data), report, planner, errata, terms)
        suites = [
            open_suite(name, each, protocol, source=source)
            for name in domain or registered()
            for each in wanted
        ]
        suites = suites if adaptive is None else adaptive_suites(suites, ability)
        library = Library(prompt_set, prompts, source)
        chosen = []
        for suite, named in zip(suites, tasks_of(tasks, suites), strict=True):
            asked = chosen_prompts(suite, library, named, limit)
            if asked:
                chosen.append((suite, asked))
    check_replay(order.endpoints, [suite for suite, _ in chosen])
    note_planner([suite for suite, _ in chosen])
    first = arm.first(library, order, chosen)
    outcomes = []
    for suite, asked in chosen:
        trials = arm.trials(library, suite, asked)
        of_suite = [
            obtain_and_score(order, endpoint, asked, suite, trials, first)
            if adaptive is None
            else obtain_adaptively(order, endpoint, asked, suite, adaptive)
            for endpoint in order.endpoints
        ]
        if not order.quiet:
            results = {outcome.model: Result(outcome.rates, outcome.coverage) for outcome in of_suite}
            terminal = DECLARATIONS[suite.ability].terminal
            print_rates(output(), arm.title(suite), terminal, results, wide=wide)
            for name, result in results.items():
                print_remark(name, result.coverage)
            print_errata(errata_effect(outcome.records) for outcome in of_suite)
            _tell_corrected(library, suite, asked)
        outcomes += of_suite
    before = first.outcomes if isinstance(first, FirstStage) else ()
    tell([*before, *outcomes], order, first.told if isinstance(first, Scenes) else (), as_json=as_json)


def _tell_corrected(library: Library, suite: Suite, prompts: Mapping[str, Prompt]) -> None:
    """Say how many of the data set's questions were not asked as they are published."""
    corrected = library.corrected(suite.benchmark, suite.ability, prompts)
    if corrected:
        told = (
            f"{counted(corrected, 'question')} asked as corrected by errata; --errata none asks as published."
        )
        say(told)
