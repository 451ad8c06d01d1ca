"""Facts of the data set about the tasks of records: their features, and where wrong goals come from.

The paper says that models report what is on the way to a goal, or at the start, instead of the goal (section
"Goal interpretation"). A stated goal that is none is followed along the data set's own plan, as far as that
runs, and the first `Reason` that fits is the one.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import asdict
from enum import Enum
from functools import cached_property
from itertools import product

from eai.abilities.explanation import Statement
from eai.abilities.goal_interpretation.lexicon import GoalLexicon
from eai.abilities.goal_interpretation.notation import Word
from eai.abilities.goal_test import alternatives
from eai.abilities.task import GoalKind, Task
from eai.benchmark.benchmark import Benchmark
from eai.benchmark.features import features_of
from eai.logic.formula import Atom, Constant
from eai.tasks.source import Source
from eai.world.condition import Conditions
from eai.world.domain import Domain
from eai.world.execution import Action, execute
from eai.world.frame import Frame
from eai.world.state import State


class Reason(str, Enum):
    """Why a stated goal may be stated though it is none."""

    UNKNOWN = "unknown"
    """Its predicate or action is none of the benchmark's."""
    PROCEDURAL = "procedural"
    """It is an action that is a goal of no task."""
    INITIAL = "initial"
    """It holds at the start."""
    FINAL = "final"
    """It holds at the end of the data set's own plan, and nobody asked for it."""
    INTERMEDIATE = "intermediate"
    """It holds at some time on the way there, neither at the start nor at the end."""
    OTHER = "other"


class _History:
    """A task with the states along the data set's own plan."""

    def __init__(self, benchmark: Benchmark, task: Task) -> None:
        self.lexicon = GoalLexicon(task, benchmark.domain, benchmark.goals)
        self._task = task
        self._states = _states(benchmark.domain, task)
        self._predicates = benchmark.goals.words(benchmark.domain)
        self._names = benchmark.goals.names(task)

    def holds(self, call: Statement) -> list[bool]:
        """In which states it holds of some objects of these names; nowhere if the domain cannot say."""
        scene, vocabulary, arguments = self._task.scene, self._task.scene.vocabulary, call.arguments or ()
        predicate = self._predicates.get(Word(call.name, len(arguments)))
        held = [False] * len(self._states)
        if predicate is None or vocabulary.arity(predicate) != len(arguments):
            return held
        for objects in product(*map(self._called, arguments)):
            frame = Frame()
            truth = Conditions(vocabulary, frame).truth(Atom(predicate, objects), wanted=call.positive)
            binding = frame.bind(scene, ())
            held = [before or truth(s, binding.copy()) for before, s in zip(held, self._states, strict=True)]
        return held

    def _called(self, name: str) -> Iterator[Constant]:
        """The objects of the task that answers call so, or of which this is the full name."""
        for index in self._task.relevant:
            full_name = self._task.scene.objects[index].name
            if name in (self._names[index], full_name):
                yield Constant(full_name)


def _states(domain: Domain, task: Task) -> tuple[State, ...]:
    """The states along the data set's own plan, up to its first step that is wrong."""
    return execute(domain, task.initial, _runnable(domain, task)).states


def _runnable(domain: Domain, task: Task) -> Iterator[Action]:
    """The steps up to the first that the domain does not have."""
    for step in task.script:
        if domain.arities.get(step.operator) != len(step.arguments):
            return
        yield step


class TaskBook:
    """The knowledge of the tasks of a benchmark, found when it is asked for."""

    def __init__(self, benchmark: Benchmark, source: Source) -> None:
        self._benchmark = benchmark
        self.tasks = benchmark.tasks(source)
        self._columns: dict[str, Mapping[str, int | None]] = {}
        self._histories: dict[str, _History] = {}
        self._reasons: dict[tuple[str, Statement], Reason] = {}

    def features_of(self, task: Task) -> Mapping[str, int | None]:
        """The features of a task, by column."""
        if task.id not in self._columns:
            self._columns[task.id] = asdict(features_of(task, self._benchmark))
        return self._columns[task.id]

    def reason(self, task: Task, atom: Statement) -> Reason:
        """Why a goal that is none may be stated.

        Args:
            task: the task.
            atom: what is stated, in the words of answers.
        """
        key = (task.id, atom)
        if key not in self._reasons:
            if task.id not in self._histories:
                self._histories[task.id] = _History(self._benchmark, task)
            self._reasons[key] = self._reason(self._histories[task.id], atom)
        return self._reasons[key]

    @cached_property
    def _requested(self) -> frozenset[str]:
        """The actions that are goals of some task."""
        goals = (goal for task in self.tasks.values() for goal in task.goals_of(GoalKind.ACTION))
        return frozenset(action for goal in goals for action in alternatives(goal))

    def _reason(self, history: _History, call: Statement) -> Reason:
        if call.arguments is None:
            if call.name not in history.lexicon.actions:
                return Reason.UNKNOWN
            return Reason.OTHER if call.name in self._requested else Reason.PROCEDURAL
        if not any(word.spelling == call.name for word in history.lexicon.words):
            return Reason.UNKNOWN
        held = history.holds(call)
        if not any(held):
            return Reason.OTHER
        if held[0]:
            return Reason.INITIAL
        return Reason.FINAL if held[-1] else Reason.INTERMEDIATE
