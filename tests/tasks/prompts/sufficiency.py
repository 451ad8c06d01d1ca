"""Reads a prompt as a person does, and replays a plan in the world that its text alone describes.

Whatever a prompt does not state is false there. A prompt that leaves out facts which a plan needs is noticed.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import TypeAlias

from eai.logic.ltl_printer import format_ltl
from eai.tasks.goal_test import GoalTest
from eai.tasks.short_lists import expand_shortened_lists
from eai.tasks.task import Task
from eai.world.action import Action
from eai.world.domain import Domain
from eai.world.execution import execute_plan
from eai.world.state import Scene, State, WorldObject

Statement: TypeAlias = tuple[str, ...]
"""A predicate with the names of its objects."""

_OBJECT = re.compile(r"(\S+) \[([^\]]*)\]: (.+)")
_FACT = re.compile(r"([\w.-]+)\(([^()]*)\)")
_AGENT = re.compile(r"(?:The agent is|You are) (\S+)\.")
_OBJECTS, _FACTS = "Objects [kind]: properties\n", ("Initial state:\n", "Now:\n")


@dataclass
class Told:
    """The world as a prompt states it.

    Attributes:
        kinds: kind of each object by name, in the order of the text.
        statements: properties, facts, and facts that conventions state, in the order of the text.
        parents: the wider kind of a kind, if the text lists both for an object.
        agent: name of the agent; None if the prompt does not state it.
        unread: lines that the reader does not understand.
    """

    kinds: dict[str, str] = field(default_factory=dict)
    statements: dict[Statement, None] = field(default_factory=dict)
    parents: dict[str, str] = field(default_factory=dict)
    agent: str | None = None
    unread: list[str] = field(default_factory=list)

    def state(self, predicate: str, *names: str) -> None:
        """Add a statement."""
        statement: Statement = (predicate, *names)
        self.statements[statement] = None


ReadLine: TypeAlias = Callable[[str, Told], bool]
"""Reads a line that is neither an object nor a fact; False if the line is not understood."""

StoredFacts: TypeAlias = Callable[[Told], Iterator[Statement]]
"""Yields the stored facts of a world that statements mean."""

ReadWorld: TypeAlias = Callable[[str], Told]
"""Reads the world of a prompt."""


def _as_stated(told: Told) -> Iterator[Statement]:
    yield from told.statements


@dataclass(frozen=True)
class ListingReader:
    """Reads the objects, conventions and facts of our own prompts.

    Attributes:
        decoded: turns a line into the words of the declaration.
        convention: reads a line of conventions.
    """

    decoded: Callable[[str], str] = str
    convention: ReadLine = lambda line, told: False

    def __call__(self, prompt: str) -> Told:
        """Return the world of the last task in a prompt."""
        before, _, after = expand_shortened_lists(prompt).rpartition(_OBJECTS)
        told, is_fact = Told(), False
        for line in after.splitlines():
            if f"{line}\n" in _FACTS:
                is_fact = True
            elif line.startswith("Goals:"):
                break
            elif is_fact or not self._read_object(line, told):
                self._read_fact(line, told)
        unread = list(told.unread)
        for line in _before_objects(before):
            self._read_fact(line, told)
        told.unread = unread  # the lines before the objects also explain goals
        return told

    def _read_object(self, line: str, told: Told) -> bool:
        described = _OBJECT.fullmatch(line) and _OBJECT.fullmatch(self.decoded(line))
        if not described:
            return False
        name, kinds, properties = described.groups()
        told.kinds[name], *wider = kinds.split(", ")
        told.parents |= zip(kinds.split(", "), wider, strict=False)
        for each in properties.split(", ") if properties != "-" else ():
            told.state(each, name)
        return True

    def _read_fact(self, line: str, told: Told) -> None:
        fact, agent = _FACT.fullmatch(self.decoded(line)), _AGENT.search(line)
        if fact is not None:
            told.state(fact[1], *filter(None, fact[2].split(", ")))
        elif agent is not None:
            told.agent = self.decoded(agent[1])
        elif line not in ("", "-") and not self.convention(line, told):
            told.unread.append(line)


def _before_objects(text: str) -> list[str]:
    """Return the lines between the goals and the objects, which in an episode's opening are conventions."""
    _, heading, after = text.rpartition("Goals:\n")
    paragraphs = after.split("\n\n")[1:] if heading else []
    return [line for paragraph in paragraphs for line in paragraph.splitlines()]


@dataclass(frozen=True)
class Reader:
    """Makes worlds of the prompts of a benchmark.

    Attributes:
        domain: the declaration.
        read: reads a prompt.
        stored: turns statements into stored facts.
        renamed: declared name of a predicate or object by its name in prompts, if they differ.
    """

    domain: Domain
    read: ReadWorld
    stored: StoredFacts = _as_stated
    renamed: Mapping[str, str] = field(default_factory=dict)

    def world(self, prompt: str) -> State:
        """Return the state in which exactly the facts hold that a prompt states.

        Raises:
            ValueError: the prompt has lines that are not understood.
        """
        told = self.read(prompt)
        if told.unread:
            raise ValueError(f"not understood: {'; '.join(told.unread[:3])}")
        new = self.renamed
        told.kinds = {new.get(name, name): kind for name, kind in told.kinds.items()}
        told.statements = {tuple([new.get(word, word) for word in each]): None for each in told.statements}
        facts = list(self.stored(told))
        for _, *names in facts:
            told.kinds |= {name: "" for name in names if name not in told.kinds}
        objects = [WorldObject(name, kind) for name, kind in told.kinds.items()]
        vocabulary = replace(self.domain.vocabulary, parents=told.parents)
        scene = Scene(vocabulary, objects, told.agent and new.get(told.agent, told.agent))
        return scene.state([(predicate, names) for predicate, *names in facts])


def insufficiency(reader: Reader, prompt: str, task: Task, plan: Iterable[Action]) -> str | None:
    """Return why a plan fails in the world that a prompt states, or None if it reaches all goals there.

    Args:
        reader: the reader of the prompt.
        prompt: the text.
        task: the task; only its goals and the names of its objects are used.
        plan: a plan that reaches all goals in the true world.
    """
    world = reader.world(prompt)
    named = [(action.operator, [task.scene.objects[i].name for i in action.arguments]) for action in plan]
    missing = {name for _, names in named for name in names} - world.scene.index.keys()
    if missing:
        return f"not listed: {', '.join(sorted(missing))}"
    actions = [Action(operator, tuple([world.scene.index[n] for n in names])) for operator, names in named]
    trajectory = execute_plan(reader.domain, world, actions)
    if trajectory.failure is not None:
        operator, names = named[len(trajectory.steps) - 1]
        return f"{operator}({', '.join(names)}): {trajectory.failure.check.reason}"
    goals = GoalTest(replace(task, initial=world))
    reached = goals.evaluate_each_goal(
        trajectory.final_state, [operator for operator, _ in named], trajectory
    )
    missed = [format_ltl(goal.formula) for goal, holds in zip(task.goals, reached, strict=True) if not holds]
    return f"not reached: {'; '.join(missed)}" if missed else None
