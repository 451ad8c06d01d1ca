"""Why a task is not to be asked: it is none, does not say what it means, or is too near a public one."""

from __future__ import annotations

from collections.abc import Sequence

from eai.abilities.goal_test import GoalTest, solves
from eai.abilities.task import Task
from eai.benchmark.lookup import LookupTable
from eai.errors import InputError
from eai.generator import fingerprint
from eai.generator.outcome import Reason
from eai.generator.reader import Reader
from eai.generator.words import Words
from eai.logic.traversal import objects
from eai.world.domain import Domain


class Objections:
    """Finds objections to tasks.

    Args:
        domain: whose world they are in.
        public: its benchmark's own tasks.
        by_place: whether instructions are to name nothing.
    """

    def __init__(self, domain: Domain, public: Sequence[Task], *, by_place: bool) -> None:
        self._domain, self._by_place = domain, by_place
        self._public = {
            fingerprint.of_goals([goal.formula for goal in task.goals], task.scene) for task in public
        }
        self._table = LookupTable(public, domain)

    def to(self, task: Task, words: Words, least: int, most: int) -> Reason | None:
        """Why a task in these words, with a certificate that is to be about so long, is not to be asked."""
        if len(task.script) < least:
            return Reason.TOO_SHORT
        if len(task.script) > most:
            return Reason.TOO_LONG
        reached = zip(task.goals, GoalTest(task).reached(task.initial, ()), strict=True)
        if any(holds for each, holds in reached if not each.is_over_time):
            return Reason.HOLDS_ALREADY
        if not solves(self._domain, task, task.script):
            return Reason.NO_CERTIFICATE
        if (reason := self._objection_to_words(task, words)) is not None:
            return reason
        if fingerprint.of_task(task)[0] in self._public:
            return Reason.PUBLIC
        if solves(self._domain, task, self._table.plan(task)):
            return Reason.PUBLIC_PLAN
        return None

    def _objection_to_words(self, task: Task, words: Words) -> Reason | None:
        """The instruction names what it is not to name, or, read again, does not give the goals back."""
        goals = tuple([goal.formula for goal in task.goals])
        named = (name for goal in goals for name in objects(goal))
        if self._by_place and not all(map(words.is_told, named)):
            return Reason.NAMELESS
        try:
            return None if Reader(words).goals(task.instruction) == goals else Reason.AMBIGUOUS
        except InputError:
            return Reason.AMBIGUOUS
