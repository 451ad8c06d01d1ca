"""Read and write the commands of agents: actions as lines of text, or in the benchmark's plan notation."""

from __future__ import annotations

import json
import re
from collections.abc import Collection
from typing import TypeAlias

from eai.abilities.notation.plan_form import WrittenPlan, WrittenStep
from eai.abilities.notation.plans import resolve_plan
from eai.abilities.verdict import ErrorReport, Unreadable
from eai.benchmarks.benchmark import Benchmark
from eai.tasks.task import Task
from eai.world.action import Action
from eai.world.domain import Domain
from eai.world.fault import FaultKind

DONE = "DONE"
"""The command that ends the episode, in games that end when the agent says so."""

LOOK = "LOOK"
"""The command that lists all visible facts, for games whose turns report only changes."""

MAX_LENGTH = 10_000
"""Maximum number of characters of a command; longer commands are not parsed."""

_LINE = re.compile(r"\s*([\w-]+)(?:\s*\(([^()\n]*)\))?\s*")


def convert_command_to_text(command: object) -> str:
    """Return a command as text. Models may call a tool with any JSON value, which becomes JSON text."""
    return command if isinstance(command, str) else json.dumps(command, default=str)


def is_look_command(text: str, domain: Domain) -> bool:
    """Whether a text is the command `LOOK`, and the domain has no action of that name."""
    line = _LINE.fullmatch(text[:MAX_LENGTH])
    return line is not None and line[1] == LOOK and not line[2] and LOOK not in domain.operator_arities


ParsedCommand: TypeAlias = Action | ErrorReport | None
"""The meaning of a command: an action, the error in an invalid command, or None for `DONE`."""


class CommandNotation:
    """Reads and writes the commands of one task.

    Args:
        task: the task.
        benchmark: the benchmark of the task. Commands may name objects as in observations or as in answers.
    """

    def __init__(self, task: Task, benchmark: Benchmark) -> None:
        self._domain, self._notation = benchmark.domain, benchmark.notation.plans
        object_name = benchmark.observation_wording().object_name
        self._names = [object_name(task, i) for i in range(len(task.scene.objects))]
        self._index = {name: i for i, name in reversed(list(enumerate(self._names)))}
        self._by_notation = self._notation.make_object_lookup(task)

    @property
    def usage_hint(self) -> str:
        """The sentence that explains how to write a command."""
        example = self._domain.operators[0]
        names = [parameter.name for parameter in example.parameters]
        return f"Write one action, such as {self._notation.write_command(example.name, names)}."

    def write_command(self, action: Action) -> str:
        """Return an action as a line, such as ``OPEN(jar_0)``."""
        return self._notation.write_command(action.operator, [self._names[i] for i in action.arguments])

    def read_command_and_repairs(
        self, text: str, allowed_objects: Collection[int], *, may_end_episode: bool
    ) -> tuple[ParsedCommand, tuple[str, ...]]:
        """Read a text as a command. Return its meaning, and the names of the corrections of malformed text.

        Args:
            text: the text.
            allowed_objects: indices of the objects that the agent may act on.
            may_end_episode: whether the text may end the episode.
        """
        plan = self._read_steps_of_command(text)
        if isinstance(plan, Unreadable):
            return ErrorReport(FaultKind.PARSING, None, plan.reason), ()
        if may_end_episode and plan.steps == (WrittenStep(DONE, ()),):
            return None, plan.repairs
        if len(plan.steps) != 1:
            reason = f"one action at a time, not {len(plan.steps)}"
            return ErrorReport(FaultKind.PARSING, None, reason), plan.repairs

        def find_object(word: object) -> int | None:
            index = self._index.get(word) if isinstance(word, str) else None
            if index is None:
                index = self._by_notation(word)
            return index if index in allowed_objects else None

        everything = len(allowed_objects) == len(self._names)
        stranger = "there is no" if everything else "you have not yet seen"
        meant = resolve_plan(plan, self._domain, self._notation, find_object, stranger)
        return meant if isinstance(meant, ErrorReport) else meant[0], plan.repairs

    def _read_steps_of_command(self, text: str) -> WrittenPlan | Unreadable:
        """Return the steps in a command's text: one line, a whole answer, or one step of an answer."""
        if len(text) > MAX_LENGTH:
            return Unreadable(f"it is longer than {MAX_LENGTH:,} characters")
        line = _LINE.fullmatch(text)
        if line is not None:
            objects = line[2].split(",") if line[2] and line[2].strip() else []
            return WrittenPlan((WrittenStep(line[1], tuple(map(str.strip, objects))),))
        plan = self._notation.read(text)
        if isinstance(plan, WrittenPlan) and plan.steps:
            return plan
        part = self._notation.read(self._notation.join((text,)))
        if isinstance(part, WrittenPlan):
            return part
        return Unreadable("no action was found") if isinstance(plan, Unreadable) else plan
