"""A policy that is a table of weights: the score of a command is the sum of the weights of its features.

It reads the observations of any agent in these environments and has no knowledge of households. At first it
takes every admissible command with equal probability.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from eai.tasks.short_lists import spell_out

Vector: TypeAlias = "NDArray[np.float64]"

_ATOM = re.compile(r"(not )?([\w-]+)\(([^()]*)\)")
_OBJECT = re.compile(r"^(\S+) \[([^\]]*)\]:", re.MULTILINE)
_VARIABLE = re.compile(r"(?:forall|exists|forn \d+|forpairs)? ?(\w+): ([\w.-]+)")


class Atom(NamedTuple):
    """A predicate of objects, or an action on objects."""

    name: str
    arguments: tuple[str, ...]
    negated: bool = False


def atoms(text: str) -> list[Atom]:
    """Return all parts of a text that have the form of an atom."""
    return [
        Atom(name, tuple(filter(None, map(str.strip, arguments.split(",")))), bool(negated))
        for negated, name, arguments in _ATOM.findall(text)
    ]


class Reader:
    """Makes features of commands from the observations of an episode.

    Args:
        opening: The first observation.
    """

    def __init__(self, opening: str) -> None:
        goals = opening.partition("Goals:\n")[2].partition("\n\n")[0]
        self._goals = atoms(goals)
        self._kinds = dict(_OBJECT.findall(spell_out(opening)))
        self._kind_of_variable = dict(_VARIABLE.findall(goals))
        self._past: list[str] = []
        self._facts: list[Atom] = []
        self.see(opening)

    def see(self, observation: str, command: str | None = None) -> None:
        """Read an observation, and the command that led to it."""
        observation = spell_out(observation)
        self._facts = atoms(observation.partition("Now:\n")[2])
        if command is not None:
            self._past.append(command)

    def features(self, commands: Sequence[str]) -> list[list[str]]:
        """Return the features of each command as words."""
        holds = set(self._facts)
        met = [goal._replace(negated=False) in holds for goal in self._goals]
        met = [now != goal.negated for now, goal in zip(met, self._goals, strict=True)]
        about: dict[str, list[str]] = {}
        for fact in self._facts:
            for place, argument in enumerate(fact.arguments):
                about.setdefault(argument, []).append(f"{fact.name}/{place}")
        return [self._of(command, atoms(command)[0], met, about) for command in commands]

    def _of(self, text: str, command: Atom, met: Sequence[bool], about: dict[str, list[str]]) -> list[str]:
        action, said = command.name, [command.name]
        for place, thing in enumerate(command.arguments):
            wanted = [
                f"{'met' if is_met else 'open'} {'not ' * goal.negated}{goal.name}/{at}"
                for goal, is_met in zip(self._goals, met, strict=True)
                for at, argument in enumerate(goal.arguments)
                if argument == thing or self._kind_of_variable.get(argument) == self._kinds.get(thing)
            ] or ["unwanted"]
            said += [f"{action}/{place} {each}" for each in wanted]
            said += [f"{action}/{place} {fact} {wanted[0]}" for fact in about.get(thing, ())]
        if self._past:
            before = atoms(self._past[-1])[0]
            shared = [i for i, thing in enumerate(command.arguments) if thing in before.arguments]
            said.append(f"{action} after {before.name} sharing {shared}")
        said.append(f"again {min(self._past.count(text), 2)}")
        return said


@dataclass(frozen=True)
class Choice:
    """One decision: the features of all commands, their probabilities, and the index of the chosen one."""

    features: list[list[int]]
    probabilities: Vector
    taken: int


class Table:
    """The policy: a weight for each feature, learned by policy gradient.

    Args:
        seed: Seed of its choices.
        rate: Learning rate (Adagrad).
    """

    def __init__(self, seed: int, rate: float = 1.2) -> None:
        self._random = np.random.default_rng(seed)
        self._rate = rate
        self._places: dict[str, int] = {}
        self._weights = np.zeros(1 << 16)
        self._squares = np.full(1 << 16, 1e-6)

    def choose(self, reader: Reader, commands: Sequence[str]) -> Choice:
        """Choose a command at random, with probabilities from the scores."""
        features = [[self._place(word) for word in words] for words in reader.features(commands)]
        scores = np.array([self._weights[places].sum() for places in features])
        likely = np.exp(scores - scores.max())
        likely /= likely.sum()
        return Choice(features, likely, int(self._random.choice(len(commands), p=likely)))

    def learn(self, choices: Sequence[Choice], advantages: Sequence[float]) -> None:
        """Make choices with a positive advantage more probable, and the others less (REINFORCE)."""
        slope = np.zeros_like(self._weights)
        for choice, advantage in zip(choices, advantages, strict=True):
            np.add.at(slope, choice.features[choice.taken], advantage)
            for places, likely in zip(choice.features, choice.probabilities, strict=True):
                np.add.at(slope, places, -advantage * likely)
        self._squares += slope**2
        self._weights += self._rate * slope / np.sqrt(self._squares)

    def _place(self, word: str) -> int:
        return self._places.setdefault(word, len(self._places) % len(self._weights))
