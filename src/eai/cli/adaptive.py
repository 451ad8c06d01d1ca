"""``eai run --adaptive``: tasks are chosen as answers come, until the ability is known well enough."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence

from eai.abilities.protocol import DEFAULT_PROTOCOL, Ability
from eai.abilities.verdict import PlanVerdict
from eai.benchmark.suite import Suite
from eai.cli.console import say
from eai.cli.order import Order, obtain_and_score
from eai.errors import InputError
from eai.prompts.prompt import Prompt
from eai.results.table_files import write_files
from eai.run.job import Endpoint
from eai.scoring.epochs import SuiteResult
from eai.studies.items.adaptive import ability_of, item_difficulties, next_tasks, variance_between_names

ROUND = 5
"""How many tasks are asked at a time, which costs hardly a task more than one by one."""

FILE = "adaptive.json"


def adaptive_suites(suites: Sequence[Suite], named: Sequence[Ability] | None) -> list[Suite]:
    """The suites whose tasks have known difficulties.

    Args:
        suites: those that are asked for.
        named: the abilities that the user named, if any.

    Raises:
        InputError: one that was named has none, or none has any.
    """
    for suite in suites:
        if suite.protocol is not DEFAULT_PROTOCOL:
            raise InputError(f"--adaptive: difficulties are known under {DEFAULT_PROTOCOL.value} alone")
        if named and not item_difficulties(suite.domain, suite.ability):
            asked = f"{suite.domain} {suite.ability.value}"
            raise InputError(f"--adaptive: the tasks of {asked} have no known difficulties")
    known = [suite for suite in suites if item_difficulties(suite.domain, suite.ability)]
    if not known:
        raise InputError("--adaptive: the tasks of these suites have no known difficulties")
    return known


def obtain_adaptively(
    order: Order, endpoint: Endpoint, prompts: Mapping[str, Prompt], suite: Suite, target: float
) -> SuiteResult:
    """Ask in rounds what tells most, until the standard error of the ability is at most the target.

    Every round is a run of all tasks so far, of which what is answered is not asked again, so that a run that
    was interrupted goes on. It ends early where a task cannot be answered, and where there is none left.
    """
    known = item_difficulties(suite.domain, suite.ability)
    difficulties = {task_id: known[task_id] for task_id in prompts if task_id in known}
    tasks = suite.benchmark.tasks(suite.source)
    names = {task_id: tasks[task_id].title for task_id in difficulties}
    variance = variance_between_names(suite.domain, suite.ability)
    chosen: list[str] = []
    scores: dict[str, float] = {}
    while True:
        left = {task: difficulties[task] for task in difficulties if task in scores or task not in chosen}
        chosen += next_tasks(ROUND, scores, left, names)
        asked = {task_id: prompts[task_id] for task_id in prompts if task_id in chosen}
        result = obtain_and_score(order, endpoint, asked, suite)
        scores = {
            record.task_id: float(bool(record.verdict.success))
            for record in result.records
            if isinstance(record.verdict, PlanVerdict) and record.unanswered is None
            if record.verdict.excluded is None
        }
        found = ability_of(scores, difficulties, names, variance)
        if found.error <= target or result.failures or len(chosen) == len(difficulties):
            break
    _write(result, found, target, chosen)
    if not order.quiet:
        say(_told(result, found, len(chosen)))
    return result


def _write(result: SuiteResult, found: tuple[float, float], target: float, chosen: Sequence[str]) -> None:
    ability, error = found
    content = {"ability": ability, "error": error, "target": target, "tasks": list(chosen)}
    write_files(result.folder, {FILE: json.dumps(content, indent=1) + "\n"})


def _told(result: SuiteResult, found: tuple[float, float], tasks: int) -> str:
    suite, (ability, error) = result.suite, found
    return (
        f"{result.model}, {suite.domain} {suite.ability.value}: ability {ability:+.2f} logits, standard "
        f"error {error:.2f}, from {tasks} of {len(suite.task_ids)} tasks. 0 is the mean of nine models "
        "of 2024; percentages are of tasks that were chosen to be neither easy nor hard for this model."
    )
