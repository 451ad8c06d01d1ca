"""Adaptive runs: ask the most informative tasks until the standard error of a model's ability is small."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TypeAlias

from eai.abilities.protocol import DEFAULT_PROTOCOL, Ability
from eai.abilities.verdict import PlanVerdict
from eai.base.errors import InputError
from eai.benchmarks.suite import Suite
from eai.extensions.adaptive.difficulties import (
    choose_most_informative_tasks,
    estimate_ability,
    load_ability_variance_between_task_groups,
    load_task_difficulties,
)
from eai.results.epochs import SuiteResult
from eai.results.paper_tables import is_trivial_baseline
from eai.results.runs import read_runs
from eai.results.table_files import write_files
from eai.results.tidy import TidyTables
from eai.results.totals import RunTotals
from eai.tasks.prompts.prompt import Prompt

TASKS_PER_ROUND = 5
"""Number of tasks that a model answers between two estimates of its ability.

To estimate after each task would save almost no tasks in total.
"""

_FILE = "adaptive.json"


_Difficulties: TypeAlias = tuple[Mapping[str, float], float, str]
"""Difficulties by task, the variance of a model's ability, and a text that names the models.

The answers of these models gave the difficulties. See `_estimate_difficulties`.
"""


def prepare_adaptive_runs(
    suites: Sequence[Suite], chosen_abilities: Sequence[Ability], runs_folder: Path | None
) -> tuple[list[Suite], Callable[..., tuple[SuiteResult, str]]]:
    """Return suites (abilities of benchmarks) with known difficulties, and a function that runs such a suite.

    The function asks a model the tasks that tell most about its ability
    (`ask_informative_tasks_and_describe_ability`).

    Args:
        suites: the suites that the user asks for.
        chosen_abilities: abilities that the user chose with an option; empty if all were taken by default.
        runs_folder: runs from which difficulties are estimated; None for the published difficulties.

    Raises:
        InputError: a suite of an ability that the user chose has no difficulties, or no suite has any.
    """
    if runs_folder is None and any(suite.protocol is not DEFAULT_PROTOCOL for suite in suites):
        raise InputError(
            f"--adaptive: difficulties are only known under the protocol {DEFAULT_PROTOCOL.value}; "
            "take this protocol, or give runs of several models with --with tasks.calibration=DIR"
        )
    difficulties = {
        (suite.domain, suite.ability): estimate
        for suite in suites
        if suite.answers_are_plans and (estimate := _estimate_difficulties(suite, runs_folder))[0]
    }
    known = [suite for suite in suites if (suite.domain, suite.ability) in difficulties]
    unknown = [suite for suite in suites if suite not in known]
    if unknown and (chosen_abilities or not known):
        asked = f"{unknown[0].domain} {unknown[0].ability.value}"
        hint = "; --with tasks.calibration=DIR takes them from runs of several models"
        raise InputError(f"--adaptive: the tasks of {asked} have no known difficulties{hint}")
    return known, partial(ask_informative_tasks_and_describe_ability, difficulties)


def _estimate_difficulties(suite: Suite, folder: Path | None) -> _Difficulties:
    """Return the difficulties of a suite's tasks: published values, or estimates from runs of all tasks.

    Null models (baselines such as an empty answer) are left out.

    Returns:
        the difficulty by task, in logits from the mean ability of the models used (empty if unknown); the
        variance of a model's ability between groups of tasks, in squared logits; a phrase that names these
        models. Tasks with the same name are a group: near copies.

    Raises:
        InputError: the folder has too few runs of the suite.
    """
    if folder is None:
        place = suite.domain, suite.ability
        return (
            load_task_difficulties(*place),
            load_ability_variance_between_task_groups(*place),
            "nine models of 2024",
        )
    from eai.extensions.adaptive.rasch import (
        estimate_ability_variance_between_task_groups,
        fit_rasch,
    )  # needs numpy
    from eai.extensions.adaptive.study import MIN_MODELS, collect_scores

    tables, of_suite = TidyTables(suite.source, features=False), (suite.protocol, suite.domain, suite.ability)
    for run in read_runs([folder]):
        if (
            run.key[:3] == of_suite
            and not is_trivial_baseline(run.key.model)
            and run.key.has_standard_rules_and_no_study_options
            and RunTotals.from_records(run.records).coverage.is_complete_enough_for_ranking
        ):
            tables.add_records(run.records)
    scores = collect_scores(tables.answers)
    if not scores.has_enough_models_and_tasks:
        answers = f"all answers to {suite.domain} {suite.ability.value} under {suite.protocol.value}"
        found = f"found {len(scores.models)} models"
        raise InputError(f"{folder}: expected runs of at least {MIN_MODELS} models with {answers}; {found}")
    fitted = fit_rasch(scores.matrix)
    values = map(float, fitted.difficulties - fitted.abilities.mean())
    by_task = dict(zip(scores.tasks, values, strict=True))
    variance = estimate_ability_variance_between_task_groups(scores.matrix, fitted, scores.names)
    return by_task, variance, f"the {len(scores.models)} models in {folder}"


def ask_informative_tasks_and_describe_ability(
    difficulties_by_suite: Mapping[tuple[str, Ability], _Difficulties],
    ask: Callable[[Mapping[str, Prompt]], SuiteResult],
    prompts: Mapping[str, Prompt],
    suite: Suite,
    target: float,
) -> tuple[SuiteResult, str]:
    """Ask the most informative tasks until the standard error of the model's ability is at most ``target``.

    The model's ability is a number in logits (`estimate_ability`). It is no `Ability`, which is a kind of
    questions. Every round is a run of all tasks chosen so far. Tasks with answers are not asked again, so an
    interrupted run resumes. Rounds end early if a task cannot be answered, or if no task is left.

    Args:
        difficulties_by_suite: the results of `_estimate_difficulties`, by domain and kind of questions.
        ask: a function that asks a model the questions (prompts by task id) and scores the answers.
        prompts: the questions of all tasks that may be asked, by task id.
        suite: the suite.
        target: the standard error at which to stop, in logits.

    Returns:
        the result of the last round, and sentences that report the model's ability.
    """
    known, variance, models = difficulties_by_suite[suite.domain, suite.ability]
    difficulties = {task_id: known[task_id] for task_id in prompts if task_id in known}
    tasks = suite.benchmark.tasks(suite.source)
    names = {task_id: tasks[task_id].title for task_id in difficulties}
    chosen: list[str] = []
    scores: dict[str, float] = {}
    while True:
        left = {task: difficulties[task] for task in difficulties if task in scores or task not in chosen}
        chosen += choose_most_informative_tasks(TASKS_PER_ROUND, scores, left, names)
        result = ask({task_id: prompts[task_id] for task_id in prompts if task_id in chosen})
        scores = {
            record.task_id: float(bool(record.verdict.success))
            for record in result.records
            if isinstance(record.verdict, PlanVerdict) and record.unanswered is None
            if record.verdict.excluded is None
        }
        ability, error = estimate_ability(scores, difficulties, names, variance)
        if error <= target or result.task_ids_by_failure_reason or len(chosen) == len(difficulties):
            break
    content = {"ability": ability, "error": error, "target": target, "tasks": chosen, "zero": models}
    write_files(result.folder, {_FILE: json.dumps(content, indent=1) + "\n"})
    remark = (
        f"{result.model}, {suite.domain} {suite.ability.value}: ability {ability:+.2f} logits, "
        f"standard error {error:.2f}, from {len(chosen)} of {len(suite.task_ids)} tasks. 0 is the mean "
        f"of {models}; percentages are of tasks that were chosen to be neither easy nor hard for this "
        "model."
    )
    return result, remark
