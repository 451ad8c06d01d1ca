"""The features of a task that stand in its records."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from eai.tasks.task import Task


@dataclass(frozen=True, slots=True)
class TaskFeatures:
    """The features of a task, whatever was answered: what success may be set against, as an outcome may not.

    Attributes:
        name: the name that tasks of a kind share; tasks of one name are near copies of each other.
        annotated_steps: how many steps the data set's own plan has; None if it has none.
        goals: how many goals it has.
        hazards: what the last of them keep from happening (`eai.tasks.task.Task`).
        missing: the facts for want of which no plan reaches them, where an answer may say so.
        fits: the objects that the instruction may mean, where an answer may ask.
    """

    name: str
    annotated_steps: int | None
    goals: int
    hazards: tuple[str, ...] = ()
    missing: tuple[str, ...] | None = None
    fits: tuple[str, ...] | None = None

    @property
    def is_to_decline(self) -> bool:
        """Whether it is right to decline: nothing leads to the goals, or words fit several objects."""
        return bool(self.missing) or len(self.fits or ()) > 1

    @staticmethod
    def of(task: Task) -> TaskFeatures:
        """The features of a task."""
        script, goals = len(task.script) or None, len(task.goals)
        return TaskFeatures(task.title, script, goals, task.hazards, task.missing, task.fits)
