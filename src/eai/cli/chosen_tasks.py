"""The tasks that a command names, and what models are asked about them."""

from __future__ import annotations

from collections.abc import Sequence, Set

from eai.benchmark.prompt_library import Library
from eai.benchmark.suite import Suite
from eai.cli.options import listed
from eai.errors import InputError, did_you_mean
from eai.prompts.prompt import Prompt
from eai.studies.items.adaptive import SHORT, short_test


def _named(tasks: str, suites: Sequence[Suite]) -> frozenset[str]:
    """The tasks that the command line names; none if it asks for all.

    Raises:
        InputError: no suite has a task of this name.
    """
    named = listed(tasks)
    for task_id in named:
        if not any(task_id in suite.task_ids for suite in suites):
            only = f"{suites[0].domain} {suites[0].ability.value}"
            known = {each for suite in suites for each in suite.task_ids}
            raise InputError(
                f"--tasks: {task_id!r} is not a task of {only if len(suites) == 1 else 'any suite'}"
                f"{did_you_mean(task_id, sorted(known))}"
            )
    return frozenset(named)


def tasks_of(tasks: str, suites: Sequence[Suite]) -> list[frozenset[str]]:
    """For each suite the tasks that are asked for; none if all are."""
    return [_short(suite) for suite in suites] if tasks == SHORT else [_named(tasks, suites)] * len(suites)


def _short(suite: Suite) -> frozenset[str]:
    """The tasks of a suite's short test.

    Raises:
        InputError: it has none.
    """
    found = short_test(suite.domain, suite.ability)
    if not found:
        raise InputError(f"--tasks {SHORT}: {suite.domain} {suite.ability.value} has no short test")
    return frozenset(found)


def chosen_prompts(suite: Suite, library: Library, named: Set[str], limit: int | None) -> dict[str, Prompt]:
    """The prompts of the named tasks, or of all if none is, in the order of the data set."""
    chosen = [task_id for task_id in suite.task_ids if not named or task_id in named]
    prompts = library.open(suite.benchmark, suite.ability) if chosen else {}
    return {task_id: prompts[task_id] for task_id in chosen[:limit]}
