"""A versioned table of errors in published data, with their corrections (errata)."""

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
from eai.benchmarks.errata_use import ApplicableErrata
from eai.tasks.options import Options, describe_validation_error
from eai.tasks.source import TaskSet
from eai.tasks.task import Task
from eai.world.action import Action
from eai.world.state import Scene

if TYPE_CHECKING:
    from eai.tasks.operator_task import OperatorLibrary, TransitionTask

_HEADS_START, _HEADS_END = "Action to be finished:\n", "\nOutput:"


TaskT = TypeVar("TaskT", bound=Task)

_FILE = "errata.toml"


def correct_requested_operators_in_question(task: TransitionTask, question: str) -> str:
    """Return a copy of a question that asks for the operators that are scored.

    A few official questions ask for other operators.
    """
    before, mark, rest = question.rpartition(_HEADS_START)
    _, end, behind = rest.partition(_HEADS_END)
    return "".join(
        (before, mark, *(_write_operator_head(task, name) for name in task.operators), end, behind)
    )


def _write_operator_head(task: TransitionTask, name: str) -> str:
    """Return the PDDL text of an operator with empty precondition and effect, for a model to complete."""
    parameters = task.domain.operators[name].parameters
    return f"(:action {name})\n:parameters {parameters}\n:precondition ()\n:effect ()\n)\n"


class _TextReplacement(Options):
    """A passage of the data (`was`), and its replacement (`now`)."""

    was: str
    now: str


class _PlanCorrection(Options):
    """Steps of the data set's plan (`was`, from index `step` on), and the steps that replace them (`now`)."""

    step: int
    was: tuple[str, ...]
    now: tuple[str, ...]


class _Erratum(Options):
    """An error in the data of a benchmark, and its correction.

    Attributes:
        id: name of the erratum.
        domain: name of the benchmark.
        abilities: the affected abilities.
        tasks: ids of the affected tasks.
        since: first version of the table with this erratum.
        wrong: description of the error.
        evidence: how anybody can verify the error.
        exclude: reason for excluding the tasks from statistics of plans; it becomes `Task.unsolvable`.
        renamed: name of an operator in the data -> name of this operator in the question.
        problem: replacement of a part of the planning problem's text.
        plan: corrections of the data set's own plan: some steps replaced by others.
        question: replacement of a part of the data set's official question.
        asks_scored: whether the question is changed so that it asks for the scored operators.
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
    problem: _TextReplacement | None = None
    plan: tuple[_PlanCorrection, ...] = ()
    question: _TextReplacement | None = None
    asks_scored: bool = False

    @property
    def corrections(self) -> tuple[str, ...]:
        """Names of the fields of this erratum that contain a correction."""
        names = ("exclude", "renamed", "problem", "plan", "question", "asks_scored")
        return tuple(name for name in names if getattr(self, name))

    @property
    def changes_only_question(self) -> bool:
        """Whether the erratum changes only the question of a task, and not the right answer."""
        return self.question is not None or self.asks_scored


@dataclass(frozen=True)
class Errata:
    """The errata of a benchmark.

    Attributes:
        version: version of the table, a plus, and the first digits of a digest of all corrections, which
            distinguishes two tables of one version. Empty if there is no table.
        entries: the errata in the order of the table.
    """

    version: str = ""
    entries: tuple[_Erratum, ...] = ()

    def find_errata_of_task(self, ability: Ability, task_id: str) -> ApplicableErrata | None:
        """Return the version of the table, and ids of the errata that can change verdicts on a task.

        Stored verdicts contain this value. Returns None if there is no table of errata.
        """
        if self.version:
            return ApplicableErrata(
                self.version, self._ids_of_errata_changing_verdicts.get((ability, task_id), ())
            )
        return None

    @cached_property
    def _ids_of_errata_changing_verdicts(self) -> Mapping[tuple[Ability, str], tuple[str, ...]]:
        """Mapping from ability and task id to the ids of the errata that can change verdicts.

        Errata that change only questions or the data set's plans are left out.
        """
        deciding = [entry for entry in self.entries if not entry.changes_only_question and not entry.plan]
        pairs = ((key, entry.id) for entry in deciding for key in product(entry.abilities, entry.tasks))
        return {key: tuple(ids) for key, ids in group_pairs(pairs).items()}

    def correct_tasks(self, tasks: TaskSet[TaskT]) -> TaskSet[TaskT]:
        """Return the benchmark's tasks with their errors corrected."""
        by_task = self._group_errata_by_task(Ability.ACTION_SEQUENCING)

        def load_corrected_task(task_id: str) -> TaskT:
            task = tasks[task_id]
            for entry in by_task.get(task_id, ()):
                if entry.exclude is not None:
                    task = replace(task, unsolvable=entry.exclude)
                task = replace(task, script=_correct_script(task.script, entry, task.scene))
            return task

        return TaskSet(tasks, load_corrected_task, tasks.sha256) if by_task else tasks

    def correct_operators(self, tasks: TaskSet[TransitionTask]) -> TaskSet[TransitionTask]:
        """Return the tasks of transition modeling with their errors corrected."""
        by_task = self._group_errata_by_task(Ability.TRANSITION_MODELING)
        names = {was: now for entry in self.entries for was, now in (entry.renamed or {}).items()}

        @cache
        def load_corrected_operator_library() -> OperatorLibrary:
            return _rename_operators(next(iter(tasks.values())).domain, names)

        def load_corrected_operator_task(task_id: str) -> TransitionTask:
            task, problem = tasks[task_id], tasks[task_id].problem_text
            for entry in by_task.get(task_id, ()):
                if entry.problem is not None:
                    problem = _replace_once(problem, entry.problem, entry.id)
            operators = tuple([names.get(name, name) for name in task.operators])
            return replace(
                task, domain=load_corrected_operator_library(), operators=operators, problem_text=problem
            )

        return TaskSet(tasks, load_corrected_operator_task, tasks.sha256) if by_task else tasks

    def make_corrector_of_official_questions(
        self, ability: Ability, load_operator_tasks: Callable[[], Mapping[str, TransitionTask]]
    ) -> Callable[[str, str], str] | None:
        """Return a function that corrects a question, given its task id, or None if all questions are right.

        Args:
            ability: the ability of the questions.
            load_operator_tasks: returns the tasks of transition modeling, which name the operators for which
                questions must ask.
        """
        if not self.find_corrected_tasks(ability):
            return None
        by_task = self._group_errata_by_task(ability)

        def correct_question(task_id: str, question: str) -> str:
            for entry in by_task.get(task_id, ()):
                if entry.question is not None:
                    question = _replace_once(question, entry.question, entry.id)
                if entry.asks_scored:
                    question = correct_requested_operators_in_question(
                        load_operator_tasks()[task_id], question
                    )
            return question

        return correct_question

    def find_corrected_tasks(self, ability: Ability) -> frozenset[str]:
        """Return the ids of tasks whose official questions are corrected."""
        entries = [
            entry for entry in self.entries if entry.changes_only_question and ability in entry.abilities
        ]
        return frozenset(task_id for entry in entries for task_id in entry.tasks)

    def _group_errata_by_task(self, ability: Ability) -> Mapping[str, list[_Erratum]]:
        entries = [entry for entry in self.entries if ability in entry.abilities]
        return group_pairs((task_id, entry) for entry in entries for task_id in entry.tasks)


NO_ERRATA = Errata()
"""Errata without entries, for a benchmark without errata, or for a user who switches errata off."""


def load_errata(domain: str) -> Errata:
    """Return the errata of a benchmark from the table in this package."""
    errata = load_all_errata()
    return replace(errata, entries=tuple(entry for entry in errata.entries if entry.domain == domain))


@cache
def load_all_errata() -> Errata:
    """Return the errata of all benchmarks from the table in this package."""
    return read_errata((resources.files("eai.benchmarks") / _FILE).read_text(encoding="utf-8"))


def read_errata(text: str) -> Errata:
    """Return the errata in a TOML text.

    Raises:
        DataError: an entry lacks the form that the top of the package's file of errata describes.
    """
    values = parse_toml(text)
    number = values["version"]
    try:
        entries = TypeAdapter(tuple[_Erratum, ...]).validate_python(values.get("erratum", []))
    except ValidationError as error:
        raise DataError(f"{_FILE}: {describe_validation_error(error)}") from error
    for entry in entries:
        if entry.since > number:
            raise DataError(
                f"{_FILE}: {entry.id} is of version {entry.since}, above the version {number} of "
                "the table; raise `version` or lower `since`"
            )
        if len(entry.corrections) != 1:
            fields = ", ".join(entry.corrections) or "none"
            raise DataError(
                f"{_FILE}: {entry.id}: expected one correction, found {fields}; "
                "give exactly one of the fields that the top of the file lists"
            )
    corrections = [{**entry.model_dump(mode="json"), "wrong": "", "evidence": ""} for entry in entries]
    digest = hashlib.sha256(json.dumps(corrections, sort_keys=True).encode()).hexdigest()
    return Errata(f"{number}+{digest[:8]}", entries)


def _correct_script(script: tuple[Action, ...], entry: _Erratum, scene: Scene) -> tuple[Action, ...]:
    """Return a plan with the corrections of an erratum.

    The last correction is made first, because a correction may change the numbers of later steps.
    """
    steps = list(script)
    for edit in sorted(entry.plan, key=lambda step_edit: -step_edit.step):
        positions = slice(edit.step, edit.step + len(edit.was))
        if steps[positions] != [_parse_action(text, scene) for text in edit.was]:
            raise DataError(
                f"erratum {entry.id}: the data is of another version, because step {edit.step} of the plan "
                "differs from the steps that the erratum replaces; run `eai data fetch`"
            )
        steps[positions] = [_parse_action(text, scene) for text in edit.now]
    return tuple(steps)


def _parse_action(text: str, scene: Scene) -> Action:
    operator, *names = text.split()
    return Action(operator, tuple(scene.index[name] for name in names))


def _replace_once(text: str, change: _TextReplacement, entry: str) -> str:
    if text.count(change.was) != 1:
        raise DataError(
            f"erratum {entry}: expected the text to replace, {change.was!r}, once in the data, found it "
            f"{text.count(change.was)} times; run `eai data fetch`"
        )
    return text.replace(change.was, change.now)


def _rename_operators(library: OperatorLibrary, names: Mapping[str, str]) -> OperatorLibrary:
    operators = {
        names.get(name, name): replace(text, name=names.get(name, name))
        for name, text in library.operators.items()
    }
    return replace(library, operators=operators)
