"""What ``eai run`` orders: answers of models to suites, obtained, scored and told."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import typer

from eai.abilities.experiment import Experiment
from eai.abilities.responses import file_name
from eai.benchmark.suite import Suite
from eai.cli.console import counted, dollars, note, print_json, say, without_inspect
from eai.cli.first_stage import FirstStage
from eai.cli.progress import run_progress, scoring_progress
from eai.cli.scene_stage import Scenes
from eai.prompts.prompt import Prompt
from eai.run.job import Endpoint, Job
from eai.run.journal import JOURNAL, sole_run
from eai.run.spec import RunSpec
from eai.scoring.collector import collecting_seldom
from eai.scoring.epochs import SuiteResult, settle
from eai.scoring.trials import Trials

LOGS = "logs"
SHOWN_TASKS = 5


@dataclass(frozen=True, slots=True)
class Order:
    """A run of all suites: its specification, the folder of its results, and whether it prints none."""

    spec: RunSpec
    out: Path
    quiet: bool


def obtain_and_score(
    order: Order,
    endpoint: Endpoint,
    prompts: Mapping[str, Prompt],
    suite: Suite,
    trials: Trials | None = None,
    first: FirstStage | Scenes | None = None,
    epochs: int | None = None,
) -> SuiteResult:
    """Obtain one model's answers to one suite, through Inspect, which is imported only here; score them.

    In a pipeline, and where a scene is perceived, they are answers to other prompts about the same tasks; a
    task without a first stage has no second one. There are as many answers to each task as the order asks
    for, or ``epochs``.
    """
    try:
        from eai.run.evaluation import obtain_answers, write_scores
    except ImportError as error:
        raise without_inspect(error) from error
    spec, epochs = order.spec, epochs or order.spec.tasks.epochs
    asked, believed = (prompts, None) if first is None else first.second(endpoint, prompts, suite)
    about = {} if believed is None else believed.about
    job = Job(
        endpoint,
        asked,
        epochs,
        spec.generation,
        spec.requests,
        trials,
        benchmark=suite.benchmark,
        ability=suite.ability,
        source=suite.source,
        about=about,
    )
    name = file_name(endpoint.model)
    folder = order.out / suite.domain / suite.ability.value / name
    if trials is not None:
        folder /= trials.experiment.label
    if believed is not None:
        folder /= believed.experiment.label
    if spec.prompts.name is not None:
        folder /= Experiment(prompt_name=spec.prompts.name).label
    title = f"{suite.domain} {suite.ability.value} {endpoint.model}"
    with sole_run(folder):
        with run_progress(title, quiet=order.quiet) as watch:
            answers = obtain_answers(job, folder / JOURNAL, order.out / LOGS, watch=watch)
        unasked = [
            (task_id, epoch) for task_id in prompts if task_id not in asked for epoch in range(1, epochs + 1)
        ]
        lacking = dict.fromkeys(unasked, "" if believed is None else believed.lacking)
        obtained = replace(
            answers,
            failures={**answers.failures, **lacking},
            believed=believed,
            prompt_name=spec.prompts.name,
        )
        with collecting_seldom():
            with scoring_progress(f"scoring {title}", len(answers.given), quiet=order.quiet) as told:
                outcome = settle(obtained, folder, suite, spec.scoring.settings, told)
            write_scores(answers.log, outcome.by_place(), suite.source)
    return outcome


def tell(outcomes: Sequence[SuiteResult], order: Order, *, as_json: bool) -> None:
    """Say what went wrong, what it took and where results are; end with status 1 if answers are missing."""
    if as_json:
        print_json([outcome.to_json() for outcome in outcomes])
    for outcome in outcomes:
        for why, task_ids in outcome.failures.items():
            shown = ", ".join(task_ids[:SHOWN_TASKS]) + (", ..." if len(task_ids) > SHOWN_TASKS else "")
            note(
                f"{outcome.model}, {outcome.suite.domain} {outcome.suite.ability.value}: "
                f"{counted(len(task_ids), 'task')} not answered ({shown}): {why}"
            )
    if not order.quiet:
        for line in map(_effort, outcomes):
            say(line)
    if any(outcome.failures for outcome in outcomes):
        raise typer.Exit(1)


def _effort(outcome: SuiteResult) -> str:
    """One line on what an outcome took and where it is."""
    usage = outcome.usage
    parts = [
        counted(outcome.coverage.answered, "answer"),
        f"{usage.input_tokens:,} + {usage.output_tokens:,} tokens",
    ]
    if usage.cost is not None:
        parts.append(dollars(usage.cost))
    if outcome.truncated:
        parts.append(f"{outcome.truncated} cut off")
    empty = sum(record.unanswered is None and not record.response.strip() for record in outcome.records)
    if empty:
        parts.append(f"{empty} empty")
    return f"{', '.join(parts)}; records in {outcome.folder}"
