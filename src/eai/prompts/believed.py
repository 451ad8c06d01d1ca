"""Questions about a task as the one who is asked believes it to be: with other goals or in another scene.

Our own prompts are rendered from the believed task. In published ones the section that states the goals is
another, and all else stays: objects and initial state are those that belong to the true task. How they tell
of a scene is their own way, so that they cannot tell of another one.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from eai.abilities.task import Task
from eai.errors import InputError
from eai.prompts.prompt import Image

TOLD = "$initial"
"""The place in questions for what holds at the start."""


@dataclass(frozen=True, slots=True)
class Belief:
    """The belief that someone has of a task.

    Attributes:
        task: the task with the believed goals, or the perceived scene, in place of its own.
        answer: the answer to goal interpretation that states the goals, word for word; else empty.
        initial: what a question says of the start; ``$initial`` stands for what holds there.
        images: the pictures that go with a question.
    """

    task: Task
    answer: str = ""
    initial: str = TOLD
    images: tuple[Image, ...] = ()


@dataclass(frozen=True, slots=True)
class GoalSection:
    """Where the published prompts of a suite state the goals of the task, and how.

    Attributes:
        before: what stands before the section; its last occurrence counts, as examples have goals too.
        after: what stands after it.
        write: the section for a belief.
    """

    before: str
    after: str
    write: Callable[[Belief], str]

    def find(self, question: str) -> str:
        """The section of a question.

        Raises:
            InputError: it has none.
        """
        start, end = self._place(question)
        return question[start:end]

    def replace(self, question: str, belief: Belief) -> str:
        """The question with the section for a belief in place of its own.

        Raises:
            InputError: it has none.
        """
        start, end = self._place(question)
        return question[:start] + self.write(belief) + question[end:]

    def _place(self, question: str) -> tuple[int, int]:
        start = question.rfind(self.before) + len(self.before)
        end = question.find(self.after, start)
        if start < len(self.before) or end < 0:
            raise InputError(f"a prompt has no goals between {self.before!r} and {self.after!r}")
        return start, end
