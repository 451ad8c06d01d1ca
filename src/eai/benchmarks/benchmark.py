"""The class of benchmarks: a domain, its tasks, a notation of answers, and published data."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from eai.abilities.declaration import DomainAndNotation, get_declaration
from eai.abilities.notation.notation import Notation
from eai.abilities.protocol import Ability, find_ability_entry_points
from eai.abilities.scorer import Scorer
from eai.base.errors import InputError
from eai.base.store import ReportProgress
from eai.benchmarks.errata import NO_ERRATA, Errata
from eai.logic.formula import Formula
from eai.tasks.source import ErrataChoice, OpenTasks, Source, TaskSet
from eai.tasks.task import Task
from eai.world.domain import Domain
from eai.world.state import Fact

if TYPE_CHECKING:
    from eai.abilities.notation.subgoals import SubgoalNotation
    from eai.pddl.planning import PddlPlanner
    from eai.tasks.operator_task import TransitionTask
    from eai.tasks.problem_world import DomainAndProblemReader
    from eai.tasks.prompts.prompt import GoalSection, Prompt, PromptFiles
    from eai.tasks.wording import PromptAndAnswerWording

FOLDER = "formats"


def read_answer_formats(package: str) -> Mapping[Ability, str]:
    """Return a mapping from abilities to texts that describe forms of answers.

    The texts are files in the folder ``formats`` of a package. An ability without a file has no entry.
    """
    folder = files(package) / FOLDER
    files_by_ability = {ability: folder / f"{ability.value}.txt" for ability in find_ability_entry_points()}
    return {
        ability: file.read_text(encoding="utf-8").removesuffix("\n")
        for ability, file in files_by_ability.items()
        if file.is_file()
    }


def read_texts_for_short_prompts(package: str) -> Mapping[str, str]:
    """Return the texts in the folder ``formats/short`` of a package, by file name without ``.txt``."""
    folder = files(package) / FOLDER / "short"
    return {
        file.name.removesuffix(".txt"): file.read_text(encoding="utf-8").removesuffix("\n")
        for file in folder.iterdir()
    }


Opener: TypeAlias = Callable[["Benchmark", Ability, Source], TaskSet[Scorer]]
"""Function that returns the scorers of a benchmark's tasks for an ability: task id -> scorer.

The function can be pickled.
"""

OpenDemonstrations: TypeAlias = Callable[[Path, ReportProgress], TaskSet[Task]]
"""Function that returns the demonstrations (plans that people wrote) in an archive as tasks.

Raises DataError if the archive is absent or damaged.
"""

ProblemOf: TypeAlias = Callable[[Task, Sequence[Formula]], str]
"""Returns the text of a PDDL problem for a task. The goals of the problem are the given ground conditions."""

PublishedPrompts: TypeAlias = Callable[[Ability, Source], "PromptFiles"]
"""Returns the data set's prompts for an ability, such as action sequencing.

Raises DataError if the prompts cannot be obtained.
"""

AdditionalCounts: TypeAlias = Callable[[Source], Mapping[str, tuple[int, str]]]
"""Returns additional counts of a data set: label -> count, and a note on the meaning of the count."""

OpenWorld: TypeAlias = Callable[[Source], "DomainAndProblemReader"]
"""Function that returns two values, with which tasks are made from problem files (BDDL or PDDL).

The first is a PDDL domain with the names that the files may use. The second is a function that reads a file.
"""

TaskObject: TypeAlias = tuple[Task, int]
"""An object of a task: the task, and the index of the object in its scene."""

CompareObjects: TypeAlias = Callable[[Sequence[TaskObject]], Iterable[Fact]]
"""Returns static facts about objects, such as which object is larger, for a new scene with these objects.

The argument is a sequence of objects, which may be from several tasks. Facts name an object by its position
in this sequence.
"""


@dataclass(frozen=True, eq=False, slots=True)
class DataSet:
    """The published data of a benchmark. A benchmark that a user declares in a program has no such data.

    Attributes:
        title: name in tables and on pages; by default the name of the benchmark.
        errata: the errors in the data, and their corrections.
        prompts: returns published prompts; None if the benchmark has none.
        goal_sections: ability -> the section of published prompts that states the goals. Prompts with other
            goals replace it.
        task_id_of: returns the task id for an identifier in a file of answers; None if the task is known not
            to be in the data set.
        own_tasks: ability -> function that returns the tasks of this ability, for abilities with other tasks
            than the benchmark. By default, the tasks of transition modeling are operators of the domain.
        asks: ability -> function that tells whether a task is asked for this ability. By default, all tasks
            are.
        only_by_name: ability -> reason why commands leave the ability out unless the user names it.
        own_figures: returns counts for `eai data stats` that cannot be computed from the tasks.
        open_public: returns the tasks with published right answers; by default all tasks of the benchmark.
        open_demonstrations: returns the demonstrations (plans that people wrote) in an archive; None if the
            benchmark reads no such archive.
        problem_of: returns a problem of the published planning domain, with ground goals of a task as its
            goals; None if problems are exported from the domain's declaration.
        open_bddl: returns the names in BDDL problems and a reader of them; by default those of `domain`.
        planner_seconds: maximum CPU seconds of a planner for a task of transition modeling.
        labels: goal predicate or action -> labels of tasks with such a goal, such as ``transport``, separated
            by spaces (`eai.benchmarks.labels`). A key may add a word of the first argument's category, as in
            ``real half``. It then replaces the labels of the key without the word.
        compare_objects: returns the static facts about objects of several tasks. With it, generated tasks
            have objects of several tasks even if goals of the data set have quantifiers.
        model_of: returns the model of an object, such as a coffee table. In generated tasks, another object
            of this model can be the place of objects. By default, any object of the category can.
    """

    title: str = ""
    errata: Errata = NO_ERRATA
    prompts: PublishedPrompts | None = None
    goal_sections: Mapping[Ability, GoalSection] = field(default_factory=dict)
    task_id_of: Callable[[str], str | None] = str
    own_tasks: Mapping[Ability, OpenTasks[Any]] = field(default_factory=dict)
    asks: Mapping[Ability, Callable[[Task], bool]] = field(default_factory=dict)
    only_by_name: Mapping[Ability, str] = field(default_factory=dict)
    own_figures: AdditionalCounts | None = None
    open_public: OpenTasks[Task] | None = None
    open_demonstrations: OpenDemonstrations | None = None
    problem_of: ProblemOf | None = None
    open_bddl: OpenWorld | None = None
    planner_seconds: int = 100
    labels: Mapping[str, str] = field(default_factory=dict)
    compare_objects: CompareObjects | None = None
    model_of: Callable[[Task, int], str] | None = None


@dataclass(frozen=True, eq=False)
class Benchmark:
    """A domain with its tasks, the form of answers (notation), and published data.

    Attributes:
        name: name of the benchmark in stored verdicts.
        domain: the domain, with the rules that the paper describes.
        open_tasks: returns the tasks. `eai.use_tasks` makes this function for tasks declared in
            a program.
        notation: how answers are written, and the names of objects and predicates.
        data: the published data.
        reference: text for which `eai.benchmarks.registry.find_benchmark` returns the benchmark; may be
            empty.
    """

    name: str
    domain: Domain
    open_tasks: OpenTasks[Task]
    notation: Notation = field(default_factory=Notation)
    data: DataSet = field(default_factory=DataSet)
    reference: str = ""

    def __post_init__(self) -> None:
        if not callable(self.open_tasks):
            type_name = type(self.open_tasks).__name__
            raise InputError(
                f"benchmark {self.name}: expected a function that returns tasks, such as "
                f"eai.use_tasks(task, ...), found a value of the type {type_name}"
            )

    @property
    def title(self) -> str:
        """Name of the benchmark in tables and on pages."""
        return self.data.title or self.name

    @property
    def uses_declared_names_in_prompts(self) -> bool:
        """Whether the names in prompts come from the benchmark's declaration, not from published data."""
        return self.notation.wordings is None

    def get_errata(self, source: Source) -> Errata:
        """Return the corrections of data errors (errata) that apply to tasks opened with `source`.

        There are none if `source` asks for the tasks without corrections.
        """
        return NO_ERRATA if source.errata is ErrataChoice.NONE else self.data.errata

    def tasks(self, source: Source) -> TaskSet[Task]:
        """Return all tasks in the order of the data set."""
        return self.get_errata(source).correct_tasks(self.open_tasks(source))

    def with_changed_tasks(self, change: Callable[[Task], Task]) -> Benchmark:
        """Return a copy of the benchmark in which a function has changed each task.

        Before that, the errata (known errors) of the data set are corrected.
        """

        def open_tasks(source: Source) -> TaskSet[Task]:
            tasks = self.tasks(source)
            return TaskSet(tasks, lambda task_id: change(tasks[task_id]), tasks.sha256)

        return replace(self, open_tasks=open_tasks, data=replace(self.data, errata=NO_ERRATA))

    def tasks_for(self, ability: Ability, source: Source) -> TaskSet[Any]:
        """Return the tasks of an ability, in the order of the data set.

        Each task of transition modeling asks for operators. A benchmark can have separate tasks for an
        ability (`DataSet.own_tasks`).

        Raises:
            InputError: the benchmark has no tasks for this ability.
        """
        own_tasks = self.data.own_tasks
        if ability in own_tasks and ability is not Ability.TRANSITION_MODELING:
            return own_tasks[ability](source)
        if own_tasks and not self.open_tasks(source):
            abilities = " or ".join(own_tasks)
            raise InputError(
                f"--domain {self.reference}: it has no tasks for {ability}; give --ability {abilities}"
            )
        interaction = get_declaration(ability).interaction if ability in find_ability_entry_points() else None
        if interaction is not None and interaction.task_command:
            wanted = f"a file that {interaction.task_command} writes"
            raise InputError(f"--domain {self.reference}: expected {wanted}, for --ability {ability}")
        if interaction is not None and interaction.uses_operator_tasks:
            return self.operator_tasks(source)
        tasks, asks = self.tasks(source), self.data.asks.get(ability)
        if asks is None:
            return tasks
        chosen = [task_id for task_id, task in tasks.items() if asks(task)]
        return TaskSet(chosen, tasks.__getitem__, tasks.sha256, source.kept)

    def operator_tasks(self, source: Source) -> TaskSet[TransitionTask]:
        """Return the tasks of transition modeling in the order of the data set."""
        if Ability.TRANSITION_MODELING in self.data.own_tasks:
            return self.get_errata(source).correct_operators(
                self.data.own_tasks[Ability.TRANSITION_MODELING](source)
            )
        from eai.tasks.operator_task import make_transition_tasks

        tasks = self.open_tasks(source)
        if tasks.sha256 not in self._operator_tasks:
            declared = make_transition_tasks(self.domain, tasks)
            self._operator_tasks[tasks.sha256] = TaskSet(declared, declared.__getitem__, tasks.sha256)
        return self._operator_tasks[tasks.sha256]

    @cached_property
    def _operator_tasks(self) -> dict[str, TaskSet[TransitionTask]]:
        """The tasks of transition modeling by the digest of the data. Making them calls the planner."""
        return {}

    def collect_domain_and_notation(self, source: Source) -> DomainAndNotation:
        """Return the parts of the benchmark that abilities use, such as the domain and the notation.

        The parts include the planner that the user chose (`Source.planner`).
        """

        def planner() -> PddlPlanner | None:
            from eai.pddl.planners import make_planner

            return make_planner(source.planner, self.data.planner_seconds, source.terms)

        words, seen = self.wording, self.observation_wording
        return DomainAndNotation(
            self.domain, self.notation, self.subgoal_notation, planner, words, seen, self
        )

    def official_prompts(self, ability: Ability, source: Source) -> Mapping[str, Prompt] | None:
        """Return a mapping from task id to corrected official prompt, or None if the ability has no prompts.

        Raises:
            DataError: the prompts cannot be obtained.
        """
        files = self.official_files(ability, source)
        return None if files is None else files.read_prompts(self.data.task_id_of)

    def official_files(self, ability: Ability, source: Source) -> PromptFiles | None:
        """Return the data set's prompt files with errata corrected, or None if the data set has no prompts.

        Files without a correction are equal to the published files byte for byte.

        Raises:
            DataError: the files cannot be obtained.
        """
        if self.data.prompts is None or get_declaration(ability).interaction.make_question is not None:
            return None
        files = self.data.prompts(ability, source)
        correct = self.get_errata(source).make_corrector_of_official_questions(
            ability, lambda: self.operator_tasks(source)
        )
        if correct is None:
            return files
        return files.rewrite_questions(
            lambda name, question: correct(self.data.task_id_of(name) or name, question)
        )

    def wording(self, ability: Ability) -> PromptAndAnswerWording:
        """Return the names of objects and predicates that prompts of an ability use."""
        if self.notation.wordings is not None:
            return self.notation.wordings(ability)
        from eai.tasks.wording import PromptAndAnswerWording  # not needed for scoring

        return PromptAndAnswerWording.from_domain(self.domain)

    def subgoal_notation(self) -> SubgoalNotation:
        """Return the notation (format) in which answers write subgoals."""
        from eai.abilities.notation.subgoals import SubgoalNotation  # not needed for plans

        return self.notation.subgoals or SubgoalNotation(self.domain)

    def observation_wording(self) -> PromptAndAnswerWording:
        """Return the names of objects and predicates that observations use.

        Observations use the names in prompts for plans, and also names of some further predicates.
        """
        words = self.wording(Ability.ACTION_SEQUENCING)
        return replace(words, predicates=(*words.predicates, *self.notation.also_observed))
