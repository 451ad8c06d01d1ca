"""Facts of the data set about the tasks of records: their features, and where wrong goals come from.

The paper says that models report what is on the way to a goal, or at the start, instead of the goal (section
"Goal interpretation"). A stated goal that is none is followed along the data set's own plan, as far as that
runs, and the first `Reason` that fits is the one.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import asdict
from enum import Enum
from functools import cache, cached_property
from itertools import product, takewhile

from eai.abilities.explanation import Statement
from eai.abilities.goal_interpretation.lexicon import GoalLexicon
from eai.abilities.goal_test import alternatives
from eai.abilities.task import GoalKind, Task
from eai.benchmark.benchmark import Benchmark
from eai.benchmark.features import features_of
from eai.logic.formula import Atom, Constant
from eai.tasks.source import Source
from eai.world.condition import Conditions
from eai.world.execution import execute
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


class TaskFacts:
    """The knowledge of one task, found when it is asked for.

    Args:
        book: the book that it is from.
        task: the task.
    """

    def __init__(self, book: TaskBook, task: Task) -> None:
        self._book, self._benchmark, self._task = book, book.benchmark, task
        self._words = book.benchmark.goals.words(book.benchmark.domain)
        self._names = book.benchmark.goals.names(task)
        self.reason = cache(self._reason)

    @cached_property
    def features(self) -> Mapping[str, int | None]:
        """The features of the task, by column."""
        return asdict(features_of(self._task, self._benchmark))

    @cached_property
    def _lexicon(self) -> GoalLexicon:
        return GoalLexicon(self._task, self._benchmark.domain, self._benchmark.goals)

    @cached_property
    def _states(self) -> tuple[State, ...]:
        """The states along the data set's own plan, up to its first step that is wrong."""
        domain, arities = self._benchmark.domain, self._benchmark.domain.arities
        known = takewhile(lambda step: arities.get(step.operator) == len(step.arguments), self._task.script)
        return execute(domain, self._task.initial, known).states

    def _reason(self, call: Statement) -> Reason:
        """Why a goal that is none may be stated.

        Args:
            call: what is stated, in the words of answers.
        """
        if call.arguments is None:
            if call.name not in self._lexicon.actions:
                return Reason.UNKNOWN
            return Reason.OTHER if call.name in self._book.requested else Reason.PROCEDURAL
        if not any(word == call.name for word, _ in self._lexicon.words):
            return Reason.UNKNOWN
        held = self._holds(call)
        if not any(held):
            return Reason.OTHER
        if held[0]:
            return Reason.INITIAL
        return Reason.FINAL if held[-1] else Reason.INTERMEDIATE

    def _holds(self, call: Statement) -> list[bool]:
        """In which states it holds of some objects of these names; nowhere if the domain cannot say."""
        scene, vocabulary, arguments = self._task.scene, self._task.scene.vocabulary, call.arguments or ()
        predicate = self._words.get((call.name, len(arguments)))
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


class TaskBook:
    """The knowledge of the tasks of a benchmark."""

    def __init__(self, benchmark: Benchmark, source: Source) -> None:
        self.benchmark = benchmark
        self._tasks = benchmark.tasks(source)
        self.facts_of = cache(self._facts_of)

    def _facts_of(self, task_id: str) -> TaskFacts | None:
        """The knowledge of a task; None of one that the data set does not have."""
        return TaskFacts(self, self._tasks[task_id]) if task_id in self._tasks else None

    @cached_property
    def requested(self) -> frozenset[str]:
        """The actions that are goals of some task."""
        goals = (goal for task in self._tasks.values() for goal in task.goals_of(GoalKind.ACTION))
        return frozenset(action for goal in goals for action in alternatives(goal))
