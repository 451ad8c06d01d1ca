"""Benchmarks: all that the abilities need of a domain and cannot guess, in one value."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from eai.abilities.declaration import AbilityWorld, declaration_of
from eai.abilities.notation.goals import GoalNotation, JsonGoals
from eai.abilities.notation.plans import JsonPlans, PlanNotation
from eai.abilities.protocol import Ability, find_abilities
from eai.abilities.scorer import Scorer
from eai.base.errors import InputError
from eai.base.store import ReportProgress
from eai.benchmarks.errata import NO_ERRATA, Errata
from eai.logic.formula import Formula
from eai.tasks.english import PLAIN, English
from eai.tasks.source import ErrataChoice, OpenTasks, Source, TaskSet
from eai.tasks.task import Task
from eai.world.domain import Domain

if TYPE_CHECKING:
    from eai.abilities.notation.subgoals import SubgoalNotation
    from eai.pddl.planning import PddlPlanner
    from eai.tasks.operator_task import TransitionTask
    from eai.tasks.problem_world import ProblemWorld
    from eai.tasks.prompts.prompt import GoalSection, Prompt, PromptFiles
    from eai.tasks.wording import Wording

FOLDER = "formats"


def formats_of(package: str) -> Mapping[Ability, str]:
    """The texts in the folder ``formats`` of a package, by ability; an ability without one has no entry."""
    folder = files(package) / FOLDER
    found = {ability: folder / f"{ability.value}.txt" for ability in find_abilities()}
    return {
        ability: file.read_text(encoding="utf-8").removesuffix("\n")
        for ability, file in found.items()
        if file.is_file()
    }


@dataclass(frozen=True, slots=True)
class Figure:
    """One figure of a data set.

    Attributes:
        note: what is counted.
        printed: the figure as the paper prints it; None if it does not have this one.
        remark: why the paper prints another number, or how it comes to this one; empty if there is nothing
            to say.
    """

    label: str
    value: int | float
    note: str
    printed: int | float | None = None
    remark: str = ""


Opener: TypeAlias = Callable[["Benchmark", Ability, Source], TaskSet[Scorer]]
"""Opens the scorers of a benchmark and an ability, by task. It can be pickled."""

OpenDemonstrations: TypeAlias = Callable[[Path, ReportProgress], TaskSet[Task]]
"""Opens demonstrations that an archive holds; DataError if it is not there, or damaged."""

ProblemOf: TypeAlias = Callable[[Task, Sequence[Formula]], str]
"""From a task and some ground conditions to the PDDL problem of reaching them."""

PublishedPrompts: TypeAlias = Callable[[Ability, Source], "PromptFiles"]
"""Gives the prompts that a data set has for an ability; DataError if they cannot be obtained."""

OpenWorld: TypeAlias = Callable[[Source], "ProblemWorld"]
"""Opens what problems in a language of the data set's own may speak of."""


@dataclass(frozen=True, eq=False)
class Benchmark:
    """A domain with its tasks, and how its answers are written.

    Attributes:
        name: as records have it.
        domain: the declaration, as it is meant.
        open_tasks: opens the tasks; `eai.tasks.source.given` for tasks written down in a program.
        title: what tables and pages call it; the name if empty.
        plans: how plans are written; by default as a JSON list of actions with their objects.
        goals: how goals are stated; by default as JSON lists of conditions.
        subgoals: how subgoals are written; by default as formulas with the declared names.
        subgoal_domain: makes the world in which subgoals are carried out, where that takes actions which
            plans do not name; otherwise it is the declaration.
        open_operators: opens the tasks of transition modeling; exported from the declaration if None.
        own_tasks: opens what an ability is asked of, for one that is not asked of the tasks.
        asks: for an ability that is not asked for in all tasks, whether it is in one.
        only_by_name: for an ability that commands leave out where none is named, why.
        wordings: how prompts name things, by ability; by default as declared.
        also_observed: what observations of an environment tell besides that of which prompts of action
            sequencing speak: predicates by name.
        formats: how an answer is written, in words, by ability; by default that of the default notation.
        published_prompts: the prompts of the data set; None if it has none.
        errata: what is wrong in the data set, and how it is corrected.
        goal_sections: where these state the goals of a task, by ability, so that they can state others.
        task_id_of: from an identifier, as files of answers have it, to the id of its task; None for one of
            a task that is known not to be in the data set.
        own_figures: counts the figures of the data set that are not counted from its tasks; None if all are.
        open_public: opens the tasks whose answers everybody has seen; None if they are its own.
        open_demonstrations: opens demonstrations in an archive that are no tasks; None if it reads none.
        problem_of: the planning problem that some ground goals of a task make with its published operators;
            None where it is exported from the declaration.
        open_bddl: opens what problems in BDDL may speak of; by default what the declaration does.
        english: how its tasks are put into English, and what nobody would ask for; by default made of names.
        role: who carries out what is asked for, as in ``a household robot``.
        planner_seconds: how long a planner may take for one task of transition modeling, in CPU seconds.
        reference: what `eai.benchmarks.registry.find_benchmark` finds it by; empty if by nothing.
    """

    name: str
    domain: Domain
    open_tasks: OpenTasks[Task]
    title: str = ""
    plans: PlanNotation = field(default_factory=JsonPlans)
    goals: GoalNotation = field(default_factory=JsonGoals)
    subgoals: SubgoalNotation | None = None
    subgoal_domain: Callable[[], Domain] | None = None
    open_operators: OpenTasks[TransitionTask] | None = None
    own_tasks: Mapping[Ability, OpenTasks[Any]] = field(default_factory=dict)
    asks: Mapping[Ability, Callable[[Task], bool]] = field(default_factory=dict)
    only_by_name: Mapping[Ability, str] = field(default_factory=dict)
    wordings: Callable[[Ability], Wording] | None = None
    also_observed: tuple[str, ...] = ()
    formats: Mapping[Ability, str] = field(default_factory=dict)
    published_prompts: PublishedPrompts | None = None
    errata: Errata = NO_ERRATA
    goal_sections: Mapping[Ability, GoalSection] = field(default_factory=dict)
    task_id_of: Callable[[str], str | None] = str
    own_figures: Callable[[Source], Sequence[Figure]] | None = None
    open_public: OpenTasks[Task] | None = None
    open_demonstrations: OpenDemonstrations | None = None
    problem_of: ProblemOf | None = None
    open_bddl: OpenWorld | None = None
    english: English = PLAIN
    role: str = "an agent"
    planner_seconds: int = 100
    reference: str = ""

    def __post_init__(self) -> None:
        if not callable(self.open_tasks):
            found = type(self.open_tasks).__name__
            raise InputError(f"benchmark {self.name}: expected tasks as eai.given(task, ...), found {found}")

    def errata_for(self, source: Source) -> Errata:
        """The errata that tasks are opened with."""
        return NO_ERRATA if source.errata is ErrataChoice.NONE else self.errata

    def tasks(self, source: Source) -> TaskSet[Task]:
        """All tasks in the order of the data set."""
        return self.errata_for(source).tasks(self.open_tasks(source))

    def tasks_for(self, ability: Ability, source: Source) -> TaskSet[Any]:
        """The tasks that an ability is asked of, in the same order, published operators, or tasks of its own.

        Raises:
            InputError: the ability is asked of tasks of its own, and there are none, or of no such tasks.
        """
        if ability in self.own_tasks:
            return self.own_tasks[ability](source)
        if self.own_tasks:
            known = f"give --ability {' or '.join(self.own_tasks)}"
            raise InputError(f"--domain {self.reference}: {known}, as {ability} is not asked of this file")
        asked = declaration_of(ability).interaction if ability in find_abilities() else None
        if asked is not None and asked.task_command:
            wanted = f"a file that {asked.task_command} writes"
            raise InputError(f"--domain {self.reference}: expected {wanted}, for --ability {ability}")
        if asked is not None and asked.uses_operator_tasks:
            return self.operators(source)
        tasks, asks = self.tasks(source), self.asks.get(ability)
        if asks is None:
            return tasks
        chosen = [task_id for task_id, task in tasks.items() if asks(task)]
        return TaskSet(chosen, tasks.__getitem__, tasks.sha256)

    def operators(self, source: Source) -> TaskSet[TransitionTask]:
        """The tasks of transition modeling in the order of the data set."""
        if self.open_operators is not None:
            return self.errata_for(source).operators(self.open_operators(source))
        from eai.tasks.operator_task import declared_tasks

        tasks = self.open_tasks(source)
        declared = declared_tasks(self.domain, tasks)
        return TaskSet(declared, declared.__getitem__, tasks.sha256)

    def world(self, source: Source) -> AbilityWorld:
        """The world as abilities see it; a planner of operators is the one that the source asks for."""

        def planner() -> PddlPlanner | None:
            from eai.pddl.planners import make_planner

            return make_planner(source.planner, self.planner_seconds, source.terms)

        return AbilityWorld(
            self.domain,
            self.plans,
            self.goals,
            self.subgoals,
            self.subgoal_domain or (lambda: self.domain),
            planner,
            self.wording,
            self.observed_wording,
            self,
        )

    def official_prompts(self, ability: Ability, source: Source) -> Mapping[str, Prompt] | None:
        """The prompts of the data set by task id, corrected; None if it has none of the ability.

        Raises:
            DataError: they cannot be obtained.
        """
        files = self.official_files(ability, source)
        return None if files is None else files.by_task(self.task_id_of)

    def official_files(self, ability: Ability, source: Source) -> PromptFiles | None:
        """The same as files, byte for byte where none is corrected.

        Raises:
            DataError: they cannot be obtained.
        """
        if self.published_prompts is None or declaration_of(ability).interaction.make_question is not None:
            return None
        files = self.published_prompts(ability, source)
        correct = self.errata_for(source).questions(ability, lambda: self.operators(source))
        if correct is None:
            return files
        return files.corrected(lambda name, question: correct(self.task_id_of(name) or name, question))

    def wording(self, ability: Ability) -> Wording:
        """How prompts of an ability name things."""
        if self.wordings is not None:
            return self.wordings(ability)
        from eai.tasks.wording import Wording  # which scoring does not need

        return Wording.of(self.domain)

    @property
    def subgoal_notation(self) -> SubgoalNotation:
        """How subgoals are written, be it said or not."""
        from eai.abilities.notation.subgoals import SubgoalNotation  # which plans do not need

        return self.subgoals or SubgoalNotation(self.domain)

    def observed_wording(self) -> Wording:
        """How observations name things: as prompts of action sequencing do, with what else is observed."""
        words = self.wording(Ability.ACTION_SEQUENCING)
        return replace(words, predicates=(*words.predicates, *self.also_observed))
