"""``eai run``: obtain a model's answers and score them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial, wraps
from pathlib import Path
from typing import Annotated

import typer
from typing_extensions import ParamSpec

from eai.abilities.declarations import DECLARATIONS
from eai.abilities.experiment import Experiment, FeedbackForm, World, chosen_experiment
from eai.abilities.protocol import Ability, ability_of
from eai.benchmarks.prompt_library import Library
from eai.benchmarks.reference.replanning import preset_experiment
from eai.benchmarks.registry import registered
from eai.benchmarks.source import ErrataChoice, Source
from eai.benchmarks.suite import DEFAULT_PROTOCOL, Suite, open_suite
from eai.cli.adaptive import adaptive_suites, obtain_adaptively
from eai.cli.chosen_tasks import chosen_prompts, tasks_of
from eai.cli.console import (
    DOMAIN_HELP,
    counted,
    data_progress,
    note_planner,
    output,
    print_errata,
    print_remark,
)
from eai.cli.data import DataFolder, store
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
from eai.cli.first_stage import FirstStage, stage_two
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
    ABILITIES,
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
from eai.cli.order import Order, ask_for_scene_graphs, obtain_and_score, tell
from eai.cli.planning import planner_terms
from eai.cli.scene import (
    InClutter,
    InScene,
    Scene,
    SceneChoice,
    SceneImages,
    SceneModel,
    SceneModelArgument,
    SceneModelUrl,
    SceneNoise,
    refuse_besides,
    scene_abilities,
)
from eai.cli.scene_stage import Scenes
from eai.cli.table import Result, print_rates
from eai.errors import InputError, InterruptError
from eai.metrics.errata_effect import errata_effect
from eai.pddl.planning import PlannerChoice
from eai.perception.noise import noise_of
from eai.prompts.prompt import Prompt, PromptSet
from eai.run.job import Decoding, Endpoint, Pace
from eai.scoring.batch import Settings
from eai.scoring.trials import Trials, open_trials
from eai.world.episode import Notice

_ASKED, _PACE = "What is asked", "Requests"
"""Panels of the help."""


P = ParamSpec("P")


def resumable(command: Callable[P, None]) -> Callable[P, None]:
    """The command that says, wherever it is interrupted, how to go on."""

    @wraps(command)
    def interruptible(*arguments: P.args, **options: P.kwargs) -> None:
        try:
            command(*arguments, **options)
        except KeyboardInterrupt:
            raise InterruptError("interrupted; the same command goes on from here") from None

    return interruptible


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
    domain: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME", help=f"{DOMAIN_HELP} All if not given.", rich_help_panel=_ASKED),
    ] = None,
    ability: Annotated[
        list[Ability] | None,
        typer.Option(
            parser=ability_of,
            metavar="NAME",
            help=f"{ABILITIES}. All if not given.",
            rich_help_panel=_ASKED,
        ),
    ] = None,
    tasks: Annotated[
        str,
        typer.Option(
            metavar="ID,ID",
            help="Only these, in suites that have them; short: forty that stand for a suite.",
            rich_help_panel=_ASKED,
        ),
    ] = "",
    limit: Annotated[
        int | None,
        typer.Option(min=1, metavar="N", help="Tasks a suite, at most.", rich_help_panel=_ASKED),
    ] = None,
    adaptive: Annotated[
        float | None,
        typer.Option(
            min=0.05,
            metavar="S",
            help="Choose tasks by what they tell, until the ability's standard error is at most S logits.",
            rich_help_panel=_ASKED,
        ),
    ] = None,
    prompt_set: Annotated[
        PromptSet,
        typer.Option("--set", help="Which prompts: the data set's, or ours.", rich_help_panel=_ASKED),
    ] = PromptSet.OFFICIAL,
    prompts: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Prompts of your own.", rich_help_panel=_ASKED)
    ] = None,
    prompt_name: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="What these prompts are called.", rich_help_panel=_ASKED),
    ] = None,
    max_connections: Annotated[
        int | None, typer.Option(min=1, metavar="N", help="Requests at a time.", rich_help_panel=_PACE)
    ] = None,
    max_retries: Annotated[
        int, typer.Option(min=0, metavar="N", help="Repeat a failed one so often.", rich_help_panel=_PACE)
    ] = 5,
    timeout: Annotated[
        int | None,
        typer.Option(min=1, metavar="S", help="Seconds until one failed.", rich_help_panel=_PACE),
    ] = None,
    batch: Annotated[
        bool,
        typer.Option("--batch", help="Use the provider's batch service.", rich_help_panel=_PACE),
    ] = False,
    prices: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Prices of models, as Inspect reads them.", rich_help_panel=_PACE),
    ] = None,
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
        typer.Option(
            metavar="DIR", help="Where answers, logs, records, summaries go.", rich_help_panel=OUTPUT
        ),
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
    check_models(model)
    how = (replans, world, feedback, feedback_form, slip, slip_seed, slip_notice, until)
    experiment = preset_experiment(preset, slip, slip_seed, replans) or chosen_experiment(*how)
    if goals is not None and experiment is not None:
        raise InputError("--goals: not with attempts or slips; feedback would tell the goals of the task")
    if adaptive is not None and (goals is not None or experiment is not None):
        raise InputError("--adaptive: not with --goals, attempts or slips, which make tasks harder or easier")
    arguments = dict(pair(text) for text in model_arg or ())
    seeing = eyes(scene_model, scene_arg, scene_base_url, prices)
    choice = SceneChoice(scene, images, clutter, seeing, noise_of(noise) if noise else None)
    besides = {"--goals": goals, "--replans, --slip, --until": experiment, "--adaptive": adaptive}
    refuse_besides(choice, besides)
    wanted = _wanted(ability, experiment, goals, choice)
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
    scenes = _scenes(choice, library, order, chosen)
    first = _first_stage(goals, library, order, chosen)
    outcomes = []
    for suite, asked in chosen:
        trials = _trials(experiment, library, suite, asked)
        of_suite = [
            obtain_and_score(order, endpoint, asked, suite, trials, scenes or first)
            if adaptive is None
            else obtain_adaptively(order, endpoint, asked, suite, adaptive)
            for endpoint in order.endpoints
        ]
        if not order.quiet:
            title = _title(suite, experiment, goals, choice)
            results = {outcome.model: Result(outcome.rates, outcome.coverage) for outcome in of_suite}
            print_rates(output(), title, DECLARATIONS[suite.ability].terminal, results, wide=wide)
            for name, result in results.items():
                print_remark(name, result.coverage)
            print_errata(errata_effect(outcome.records) for outcome in of_suite)
            _tell_corrected(library, suite, asked)
        outcomes += of_suite
    tell(
        [*(first.outcomes if first else ()), *outcomes], order, scenes.told if scenes else (), as_json=as_json
    )


def _tell_corrected(library: Library, suite: Suite, prompts: Mapping[str, Prompt]) -> None:
    """Say how many of the data set's questions were not asked as they are published."""
    corrected = library.corrected(suite.benchmark, suite.ability, prompts)
    if corrected:
        told = (
            f"{counted(corrected, 'question')} asked as corrected by errata; --errata none asks as published."
        )
        output().print(told, markup=False, highlight=False, soft_wrap=True)


def _wanted(
    abilities: Sequence[Ability] | None, experiment: Experiment | None, goals: str | None, scene: SceneChoice
) -> list[Ability]:
    """The abilities that are asked for, in order: in an experiment those that it can be made with.

    Raises:
        InputError: one that is named is none of them.
    """
    if goals is not None:
        return stage_two(abilities)
    if scene.scene is not Scene.TEXT:
        return scene_abilities(abilities, scene.scene)
    if experiment is None:
        return [each for each in Ability if not abilities or each in abilities]
    for each in abilities or ():
        if each is not Ability.ACTION_SEQUENCING:
            raise InputError(f"--ability {each.value}: only plans are carried out, attempt by attempt")
    return [Ability.ACTION_SEQUENCING]


def _title(suite: Suite, experiment: Experiment | None, goals: str | None, scene: SceneChoice) -> str:
    """What stands above the results of a suite."""
    title = f"{suite.domain}, {suite.ability.value}, protocol {suite.protocol.value}"
    if experiment is not None:
        title += f"\n{experiment.label}"
    if goals is not None:
        title += f"\ngoals: {goals}"
    return title if scene.scene is Scene.TEXT else f"{title}\nscene: {scene.label}"


def _trials(
    experiment: Experiment | None, library: Library, suite: Suite, prompts: Mapping[str, Prompt]
) -> Trials | None:
    """How answers are carried out, in an experiment."""
    if experiment is None:
        return None
    return open_trials(suite, experiment, library.asker(suite.benchmark, suite.ability, prompts), prompts)


def _first_stage(
    goals: str | None,
    library: Library,
    order: Order,
    chosen: Sequence[tuple[Suite, Mapping[str, Prompt]]],
) -> FirstStage | None:
    """The first stage of a pipeline, if it is one."""
    if goals is None:
        return None
    return FirstStage(goals, library, partial(obtain_and_score, order), _tasks_by_domain(chosen))


def _scenes(
    choice: SceneChoice,
    library: Library,
    order: Order,
    chosen: Sequence[tuple[Suite, Mapping[str, Prompt]]],
) -> Scenes | None:
    """How questions show scenes, where they do not tell of them as they are."""
    if choice.scene is Scene.TEXT:
        return None
    return Scenes(choice, library, partial(ask_for_scene_graphs, order), _tasks_by_domain(chosen), order.out)


def _tasks_by_domain(chosen: Sequence[tuple[Suite, Mapping[str, Prompt]]]) -> dict[str, set[str]]:
    """The tasks that a run is about."""
    wanted: dict[str, set[str]] = {}
    for suite, asked in chosen:
        wanted.setdefault(suite.domain, set()).update(asked)
    return wanted
