"""Noise: a scene graph with seeded errors, as if someone had looked and seen wrong."""

from __future__ import annotations

import hashlib
import random
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields

from eai.base.errors import InputError, did_you_mean
from eai.studies.perception.scene_graph import NamedFact, SceneGraph, SceneWords, Supports, graph_of
from eai.tasks.task import Task

_NUMBER = re.compile(r"\d+$")

_TRIES = 100
"""How often a fact is made up until one is possible."""


@dataclass(frozen=True, slots=True)
class Noise:
    """How often what error is made, each of its own occasions.

    Attributes:
        missing: the probability that a described fact is lost.
        misplaced: that a described relation gets another second object.
        unnecessary: that a fact is added which does not hold, once for each described fact.
        invented: that an object is seen twice, once under a name that there is not.
        unseen: that an object is not seen, nor any fact about it. The agent is always seen.
        seed: of the draws. Each occasion has its own, so that the errors of a rate are among those of a
            higher one with the same seed.

    Raises:
        InputError: a probability is not between 0 and 1, or a fact would be lost and misplaced.
    """

    missing: float = 0.0
    misplaced: float = 0.0
    unnecessary: float = 0.0
    invented: float = 0.0
    unseen: float = 0.0
    seed: int = 0

    def __post_init__(self) -> None:
        for name, rate in self.rates.items():
            if not 0 <= rate <= 1:
                raise InputError(f"noise: expected {name} from 0 to 1, not {rate:g}")
        if self.missing + self.misplaced > 1:
            raise InputError("noise: missing and misplaced come to more than 1")

    @property
    def rates(self) -> dict[str, float]:
        """The probabilities by name."""
        return {field.name: getattr(self, field.name) for field in fields(self) if field.name != "seed"}

    @property
    def label(self) -> str:
        """A short text that tells it from every other noise."""
        parts = [f"{name}-{rate:g}" for name, rate in self.rates.items() if rate]
        return "-".join([*parts, f"seed-{self.seed}"])


def noise_of(settings: Sequence[str]) -> Noise:
    """The noise that texts such as ``missing=0.1`` describe.

    Raises:
        InputError: one is no setting of noise.
    """
    known = [field.name for field in fields(Noise)]
    values: dict[str, float] = {}
    for setting in settings:
        name, separator, text = setting.partition("=")
        if name not in known or not separator:
            hint = did_you_mean(name, known)
            raise InputError(f"noise {setting}: expected NAME=NUMBER, NAME one of {', '.join(known)}{hint}")
        try:
            values[name] = float(text)
        except ValueError as error:
            raise InputError(f"noise {setting}: expected a number, not {text!r}") from error
    seed = values.pop("seed", 0)
    if seed != int(seed):
        raise InputError(f"noise seed={seed:g}: expected a whole number")
    return Noise(**values, seed=int(seed))


def perceive(task: Task, words: SceneWords, noise: Noise, stream: str = "") -> SceneGraph:
    """Return what is seen of a task's scene: a pure function of the arguments.

    No circle of supports is seen where there is none, and nothing is where something that nothing is said
    about is, such as a half of what has not been cut. A relation for which there is no other place stays.

    Args:
        task: the task.
        words: how scene graphs say what is so.
        noise: how often what error is made.
        stream: which of several independent repetitions this is.
    """
    return _Look(task, words, noise, stream).graph()


class _Look:
    """One look at one scene."""

    def __init__(self, task: Task, words: SceneWords, noise: Noise, stream: str) -> None:
        self._words = words
        self._noise = noise
        self._key = f"{noise.seed} {task.id} {stream}"
        self._truth = words.describe(task)
        self._names = words.names(task)
        agent = None if task.scene.agent is None else self._names[task.scene.agent]
        objects = [name for name in self._truth.objects if name != agent]
        self._blind = {name for name in objects if self._draw("unseen", name).random() < noise.unseen}
        self._seen = [name for name in self._truth.objects if name not in self._blind]
        described = {name for fact in self._truth.facts for name in fact.arguments}
        self._places = [name for name in objects if name in described and name not in self._blind]
        true_of_these = [index for index, name in enumerate(self._names) if name in set(self._truth.objects)]
        self._holding = {
            words.named(fact, self._names) for fact in words.holding(task.initial, true_of_these)
        }
        supports = [words.spelling(name) for name in words.supports]
        self._supports = Supports(frozenset(supports))

    def graph(self) -> SceneGraph:
        visible = [fact for fact in self._truth.facts if self._blind.isdisjoint(fact.arguments)]
        fates = {fact: self._draw("fact", str(fact)).random() for fact in visible}
        kept = [fact for fact in visible if fates[fact] >= self._noise.missing]
        moved = [
            fact for fact in kept if fates[fact] >= 1 - self._noise.misplaced and len(fact.arguments) == 2
        ]
        facts: dict[NamedFact, NamedFact] = {fact: fact for fact in kept if fact not in moved}
        for fact in facts:
            self._supports.add(fact)
        for fact in moved:
            facts[fact] = self._misplaced(fact, facts)
            self._supports.add(facts[fact])
        in_order = [facts[fact] for fact in kept]
        in_order += self._unnecessary(visible, in_order)
        strangers = dict(self._invented())
        in_order += [each for name in strangers if (each := self._again(name, strangers[name])) is not None]
        return graph_of([*self._seen, *strangers.values()], in_order)

    def _misplaced(self, fact: NamedFact, facts: dict[NamedFact, NamedFact]) -> NamedFact:
        """The relation with another second object, the first one possible; as it is where there is none."""
        known, places = set(facts.values()), list(self._places)
        self._draw("place", str(fact)).shuffle(places)
        others = (fact._replace(arguments=(fact.arguments[0], place)) for place in places)
        return next((each for each in others if self._is_new(each, known)), fact)

    def _unnecessary(self, visible: Sequence[NamedFact], seen: Sequence[NamedFact]) -> list[NamedFact]:
        """Facts that do not hold, about objects of which something is said; what is in a hand is felt."""
        known, added = set(seen), list[NamedFact]()
        words = self._words
        predicates = [words.spelling(name) for name in words.stored if name not in words.held]
        for fact in visible:
            draw = self._draw("more", str(fact))
            if draw.random() >= self._noise.unnecessary:
                continue
            made = (self._made(draw, predicates) for _ in range(_TRIES))
            possible = (each for each in made if self._is_new(each, known) and not self._supports.rests(each))
            chosen = next(possible, None)
            if chosen is not None:
                known.add(chosen)
                self._supports.add(chosen)
                added.append(chosen)
        return added

    def _made(self, draw: random.Random, predicates: Sequence[str]) -> NamedFact:
        """Some fact about things of which something is said."""
        predicate = draw.choice(predicates)
        arity = self._words.arities[predicate]
        return NamedFact(predicate, tuple([draw.choice(self._places) for _ in range(arity)]))

    def _is_new(self, fact: NamedFact, known: set[NamedFact]) -> bool:
        """Whether a fact neither holds nor is seen, and is possible."""
        is_known = fact in self._holding or fact in known
        return (
            not is_known and len({*fact.arguments}) == len(fact.arguments) and not self._supports.closes(fact)
        )

    def _invented(self) -> Iterator[tuple[str, str]]:
        """Each object that is seen twice, with the name of its double."""
        taken = set(self._names)
        for name in self._seen:
            if name in self._places and self._draw("double", name).random() < self._noise.invented:
                double = _next_name(name, taken)
                taken.add(double)
                yield name, double

    def _again(self, name: str, double: str) -> NamedFact | None:
        """The fact about a double: one of those that hold of the object, if any does."""
        own = [fact for fact in self._truth.facts if fact.arguments[:1] == (name,)]
        own = [fact for fact in own if self._blind.isdisjoint(fact.arguments)]
        if not own:
            return None
        chosen = self._draw("of double", name).choice(own)
        return chosen._replace(arguments=(double, *chosen.arguments[1:]))

    def _draw(self, kind: str, what: str) -> random.Random:
        """The draws of one occasion."""
        digest = hashlib.sha256(f"{self._key} {kind} {what}".encode()).digest()
        return random.Random(digest)  # noqa: S311 - noise, not secrets


def _next_name(name: str, taken: set[str]) -> str:
    """A name of the same form with a number that is not taken."""
    found = _NUMBER.search(name)
    stem, number = (f"{name}_", 1) if found is None else (name[: found.start()], int(found.group()))
    while f"{stem}{number}" in taken:
        number += 1
    return f"{stem}{number}"
