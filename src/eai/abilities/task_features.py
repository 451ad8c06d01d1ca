"""Features of a task, such as its number of goals, which are stored with each answer to the task."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from eai.tasks.task import Task


@dataclass(frozen=True, slots=True)
class TaskFeatures:
    """The features of a task, which do not depend on answers. Analyses compare success between features.

    Attributes:
        name: name of the task. Tasks with the same name are almost equal.
        annotated_steps: number of steps of the plan in the data set; None if there is no such plan.
        goals: number of goals.
        hazards: names of the hazards (events) that the task forbids (`HazardousTaskMark`).
        missing: the facts whose absence makes the goals unreachable; None if answers to the task may not be a
            refusal.
        fits: the objects that fit the instruction; None if answers to the task may not be a question.
    """

    name: str
    annotated_steps: int | None
    goals: int
    hazards: tuple[str, ...] = ()
    missing: tuple[str, ...] | None = None
    fits: tuple[str, ...] | None = None

    @property
    def is_declining_correct(self) -> bool:
        """Whether declining is right: no plan reaches the goals, or the instruction fits several objects."""
        return bool(self.missing) or len(self.fits or ()) > 1

    @staticmethod
    def from_task(task: Task) -> TaskFeatures:
        """Return the features of a task."""
        special = {} if task.special is None else asdict(task.special)
        special.pop("untold", None)
        return TaskFeatures(task.title, len(task.script) or None, len(task.goals), **special)
