"""Demonstrations by title, and what decisions make of them: candidates, concrete goals, what differs."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

from eai.abilities.task import Goal, Task
from eai.errors import InputError, did_you_mean
from eai.logic.ltl_printer import print_ltl
from eai.studies.annotation.abstract import concrete_goals
from eai.studies.annotation.choosing import refuse_unknown_name
from eai.studies.annotation.decisions import Decisions
from eai.studies.annotation.difference import Difference, difference
from eai.studies.annotation.pattern import Pattern
from eai.tasks.source import Finding
from eai.world.domain import Domain


@dataclass(frozen=True, slots=True)
class Annotation:
    """What decisions make of one demonstration.

    Attributes:
        found: what it changes.
        candidate: the number of the candidate that it meets, from 0; None if it meets none.
        goals: what follows for its task; empty if it meets none.
    """

    found: Difference
    candidate: int | None
    goals: tuple[Goal, ...]


def by_title(tasks: Mapping[str, Task], title: str | None = None) -> dict[str, list[Task]]:
    """The tasks with a plan by their titles, or those of one.

    Raises:
        InputError: there is no such title, or none has a plan.
    """
    found: dict[str, list[Task]] = {}
    for task in tasks.values():
        if task.script:
            found.setdefault(task.title, []).append(task)
    if title is not None and title not in found:
        raise InputError(f"no demonstration is called {title!r}{did_you_mean(title, tuple(found))}")
    if not found:
        raise InputError("no task has a plan, which is what a demonstration is")
    return found if title is None else {title: found[title]}


def differences(tasks: Iterable[Task], domain: Domain) -> list[Difference]:
    """What each demonstration changes.

    Raises:
        InputError: a plan cannot be carried out.
    """
    return [difference(task, domain) for task in tasks]


def annotate(
    titles: Mapping[str, Iterable[Task]], domain: Domain, decisions: Decisions
) -> Iterator[Annotation]:
    """What decisions make of each demonstration, title by title.

    Raises:
        InputError: a plan cannot be carried out, or what was decided is about what is not declared.
    """
    for name, tasks in titles.items():
        title = decisions.of(name)
        for candidate in title.candidates:
            for pattern in (each for entry in candidate.entries for each in entry):
                _refuse(name, pattern, domain)
        for found in differences(tasks, domain):
            number = title.assign(found)
            goals = () if number is None else concrete_goals(found, title.candidates[number])
            yield Annotation(found, number, goals)


def _refuse(title: str, pattern: Pattern, domain: Domain) -> None:
    try:
        refuse_unknown_name(pattern, domain)
    except InputError as error:
        raise InputError(f"title {title!r}: {pattern}: {error}") from error


def check(annotations: Iterable[Annotation]) -> Iterator[Finding]:
    """Where the goals of tasks are not those that follow from the decisions."""
    for each in annotations:
        task = each.found.task
        ours, theirs = set(each.goals), set(task.goals)
        if each.candidate is None and theirs:
            yield Finding(task.title, f"{task.id}: has goals, and meets no candidate")
        elif ours != theirs:
            lacks = [f"lacks {print_ltl(goal.formula)}" for goal in each.goals if goal not in theirs]
            more = [f"has {print_ltl(goal.formula)} besides" for goal in task.goals if goal not in ours]
            yield Finding(task.title, f"{task.id}: {', '.join([*lacks, *more])}")
