"""The features of a task that stand in its records."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from eai.tasks.task import Task


@dataclass(frozen=True, slots=True)
class TaskFeatures:
    """The features of a task that do not depend on the answer. Analyses compare success by them.

    Attributes:
        name: the name of the task. Tasks with the same name are near copies of each other.
        annotated_steps: number of steps of the data set's own plan; None if there is no plan.
        goals: number of goals.
        hazards: the hazards that the last goals forbid (`eai.tasks.task.Task`).
        missing: the missing facts that leave the goals out of reach, if an answer may say so; else None.
        fits: the objects that the instruction may mean, if an answer may ask; else None.
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
        special = {} if task.special is None else asdict(task.special)
        special.pop("untold", None)
        return TaskFeatures(task.title, len(task.script) or None, len(task.goals), **special)
