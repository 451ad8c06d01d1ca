"""Errata: what is wrong in published data, and what is done about it, as a versioned overlay."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cache, cached_property
from importlib import resources
from itertools import product
from typing import TYPE_CHECKING, TypeVar

from pydantic import TypeAdapter, ValidationError

from eai.abilities.protocol import Ability
from eai.base.errors import DataError
from eai.base.files import parse_toml
from eai.base.grouping import group_pairs
from eai.benchmarks.errata_use import ErrataUse
from eai.tasks.options import Options, misfit
from eai.tasks.source import TaskSet
from eai.tasks.task import Task
from eai.world.action import Action
from eai.world.state import Scene

if TYPE_CHECKING:
    from eai.tasks.operator_task import OperatorLibrary, TransitionTask

_BEFORE, _BEHIND = "Action to be finished:\n", "\nOutput:"


TaskT = TypeVar("TaskT", bound=Task)

_FILE = "errata.toml"


def asking_for_scored(task: TransitionTask, question: str) -> str:
    """The question with the heads of the operators of its task in the place of those that it asks for."""
    before, mark, rest = question.rpartition(_BEFORE)
    _, end, behind = rest.partition(_BEHIND)
    return "".join((before, mark, *(_head(task, name) for name in task.operators), end, behind))


def _head(task: TransitionTask, name: str) -> str:
    """An operator to be finished as the other questions have it, the bracket behind its name included."""
    parameters = task.domain.operators[name].parameters
    return f"(:action {name})\n:parameters {parameters}\n:precondition ()\n:effect ()\n)\n"


class _Replacement(Options):
    """A passage of the data, and the one that is read in its place."""

    was: str
    now: str


class _StepEdit(Options):
    """Steps of a plan as they stand in the data from one on, counted from 0, and what is read instead."""

    step: int
    was: tuple[str, ...]
    now: tuple[str, ...]


class _Erratum(Options):
    """One thing that is wrong in the data of a benchmark, and one correction of it.

    Attributes:
        id: its name.
        domain: the benchmark, by name.
        abilities: in which it matters.
        tasks: the ids of the tasks that it is about.
        since: the version of the table in which it came.
        wrong: what is wrong.
        evidence: how anybody can see it.
        exclude: the tasks are in no statistics of plans; why, as their records say it.
        renamed: the name of an operator in the data -> the one that was asked for.
        problem: in the planning problem.
        plan: in the data set's own plan.
        question: in the question that the data set asks.
        asks_scored: the question is made to ask for the operators that are scored.
    """

    id: str
    domain: str
    abilities: tuple[Ability, ...]
    tasks: tuple[str, ...]
    since: int
    wrong: str
    evidence: str
    exclude: str | None = None
    renamed: Mapping[str, str] | None = None
    problem: _Replacement | None = None
    plan: tuple[_StepEdit, ...] = ()
    question: _Replacement | None = None
    asks_scored: bool = False

    @property
    def corrections(self) -> tuple[str, ...]:
        """The names of the fields that say how it is mended."""
        names = ("exclude", "renamed", "problem", "plan", "question", "asks_scored")
        return tuple(name for name in names if getattr(self, name))

    @property
    def about_questions(self) -> bool:
        """Whether it is a matter of what is asked, and not of what is right."""
        return self.question is not None or self.asks_scored


@dataclass(frozen=True)
class Errata:
    """The errata of a benchmark.

    Attributes:
        version: of the table that they stand in, and after a plus the first digits of the digest of all its
            corrections, so that two tables of one version are distinguished; empty where there is none.
        entries: in the order of the table.
    """

    version: str = ""
    entries: tuple[_Erratum, ...] = ()

    def use(self, ability: Ability, task_id: str) -> ErrataUse | None:
        """The version, and the errata that decide verdicts on a task, for its record."""
        return ErrataUse(self.version, self._deciding.get((ability, task_id), ())) if self.version else None

    @cached_property
    def _deciding(self) -> Mapping[tuple[Ability, str], tuple[str, ...]]:
        """The ids of errata that decide verdicts, by ability and task: neither questions nor plans do."""
        deciding = [entry for entry in self.entries if not entry.about_questions and not entry.plan]
        places = ((place, entry.id) for entry in deciding for place in product(entry.abilities, entry.tasks))
        return {place: tuple(ids) for place, ids in group_pairs(places).items()}

    def tasks(self, tasks: TaskSet[TaskT]) -> TaskSet[TaskT]:
        """The tasks of plans and goals, corrected."""
        by_task = self._by_task(Ability.ACTION_SEQUENCING)

        def corrected(task_id: str) -> TaskT:
            task = tasks[task_id]
            for entry in by_task.get(task_id, ()):
                if entry.exclude is not None:
                    task = replace(task, unsolvable=entry.exclude)
                task = replace(task, script=_edited(task.script, entry, task.scene))
            return task

        return TaskSet(tasks, corrected, tasks.sha256) if by_task else tasks

    def operators(self, tasks: TaskSet[TransitionTask]) -> TaskSet[TransitionTask]:
        """The tasks of transition modeling, corrected."""
        by_task = self._by_task(Ability.TRANSITION_MODELING)
        names = {was: now for entry in self.entries for was, now in (entry.renamed or {}).items()}

        @cache
        def library() -> OperatorLibrary:
            return _renamed(next(iter(tasks.values())).domain, names)

        def corrected(task_id: str) -> TransitionTask:
            task, problem = tasks[task_id], tasks[task_id].problem_text
            for entry in by_task.get(task_id, ()):
                if entry.problem is not None:
                    problem = _replaced(problem, entry.problem, entry.id)
            operators = tuple([names.get(name, name) for name in task.operators])
            return replace(task, domain=library(), operators=operators, problem_text=problem)

        return TaskSet(tasks, corrected, tasks.sha256) if by_task else tasks

    def questions(
        self, ability: Ability, operators: Callable[[], Mapping[str, TransitionTask]]
    ) -> Callable[[str, str], str] | None:
        """From the id of a task and the data set's question to the question that is asked; None if all stand.

        Args:
            ability: what is asked for.
            operators: opens the tasks of transition modeling, where questions must ask for theirs.
        """
        if not self.questioned(ability):
            return None
        by_task = self._by_task(ability)

        def corrected(task_id: str, question: str) -> str:
            for entry in by_task.get(task_id, ()):
                if entry.question is not None:
                    question = _replaced(question, entry.question, entry.id)
                if entry.asks_scored:
                    question = asking_for_scored(operators()[task_id], question)
            return question

        return corrected

    def questioned(self, ability: Ability) -> frozenset[str]:
        """The tasks whose official questions are corrected."""
        entries = [entry for entry in self.entries if entry.about_questions and ability in entry.abilities]
        return frozenset(task_id for entry in entries for task_id in entry.tasks)

    def _by_task(self, ability: Ability) -> Mapping[str, list[_Erratum]]:
        entries = [entry for entry in self.entries if ability in entry.abilities]
        return group_pairs((task_id, entry) for entry in entries for task_id in entry.tasks)


NO_ERRATA = Errata()
"""Those of a benchmark that has none, and of whoever switches them off."""


def errata_of(domain: str) -> Errata:
    """The errata of a benchmark that comes with the package."""
    found = published_errata()
    return replace(found, entries=tuple(entry for entry in found.entries if entry.domain == domain))


@cache
def published_errata() -> Errata:
    """The table of the package."""
    return read_errata((resources.files("eai.benchmarks") / _FILE).read_text(encoding="utf-8"))


def read_errata(text: str) -> Errata:
    """The errata in a text of TOML.

    Raises:
        DataError: an entry is not as the head of the package's table says.
    """
    values = parse_toml(text)
    number = values["version"]
    try:
        entries = TypeAdapter(tuple[_Erratum, ...]).validate_python(values.get("erratum", []))
    except ValidationError as error:
        raise DataError(f"errata: {misfit(error)}") from error
    for entry in entries:
        if entry.since > number:
            raise DataError(f"errata: {entry.id} is of version {entry.since}, the table of {number}")
        if len(entry.corrections) != 1:
            found = ", ".join(entry.corrections) or "none"
            raise DataError(f"errata: {entry.id}: expected one correction, found {found}")
    corrections = [{**entry.model_dump(mode="json"), "wrong": "", "evidence": ""} for entry in entries]
    digest = hashlib.sha256(json.dumps(corrections, sort_keys=True).encode()).hexdigest()
    return Errata(f"{number}+{digest[:8]}", entries)


def _edited(script: tuple[Action, ...], entry: _Erratum, scene: Scene) -> tuple[Action, ...]:
    """A plan with the corrections of an erratum, the last one first, so that steps keep their numbers."""
    steps = list(script)
    for edit in sorted(entry.plan, key=lambda each: -each.step):
        stretch = slice(edit.step, edit.step + len(edit.was))
        if steps[stretch] != [_action(text, scene) for text in edit.was]:
            raise DataError(
                f"erratum {entry.id}: the plan has another step {edit.step}; run `eai data fetch`"
            )
        steps[stretch] = [_action(text, scene) for text in edit.now]
    return tuple(steps)


def _action(text: str, scene: Scene) -> Action:
    operator, *names = text.split()
    return Action(operator, tuple(scene.index[name] for name in names))


def _replaced(text: str, change: _Replacement, entry: str) -> str:
    if text.count(change.was) != 1:
        raise DataError(f"erratum {entry}: does not fit the data; run `eai data fetch`")
    return text.replace(change.was, change.now)


def _renamed(library: OperatorLibrary, names: Mapping[str, str]) -> OperatorLibrary:
    operators = {
        names.get(name, name): replace(text, name=names.get(name, name))
        for name, text in library.operators.items()
    }
    return replace(library, operators=operators)
