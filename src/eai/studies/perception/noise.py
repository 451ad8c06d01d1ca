"""Add random errors (noise) to the scene graph of a task. Equal seeds give equal errors."""

from __future__ import annotations

import hashlib
import random
import re
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, fields
from typing import Any

from eai.base.errors import InputError, did_you_mean
from eai.studies.perception.scene_graph import (
    SceneGraph,
    SceneGraphFact,
    SceneGraphVocabulary,
    SupportRelation,
    make_scene_graph,
)
from eai.tasks.task import Task

_NUMBER = re.compile(r"\d+$")

_MAX_DRAWS = 100
"""Maximum number of random draws to find one untrue fact that is possible in the scene."""


@dataclass(frozen=True, slots=True)
class PerceptionNoise:
    """Probabilities of the errors in a perceived scene.

    Attributes:
        missing: probability that a described fact is lost.
        misplaced: probability that the second object of a described relation is replaced by another object.
        unnecessary: probability, for each described fact, that an untrue fact is added.
        invented: probability that an object is seen twice, the second time under an invented name.
        unseen: probability that an object and all facts about it are missed. The agent is always seen.
        seed: seed of the draws. Each possible error has its own draw, so the errors of a lower rate are also
            made at a higher rate with the same seed.

    Raises:
        InputError: a probability is not between 0 and 1, or ``missing`` and ``misplaced`` exceed 1 together.
    """

    missing: float = 0.0
    misplaced: float = 0.0
    unnecessary: float = 0.0
    invented: float = 0.0
    unseen: float = 0.0
    seed: int = 0

    def __post_init__(self) -> None:
        for name, rate in self.error_rates.items():
            if not 0 <= rate <= 1:
                raise InputError(f"noise: expected {name} from 0 to 1, not {rate:g}")
        if self.missing + self.misplaced > 1:
            raise InputError("noise: the sum of missing and misplaced must be at most 1")

    @property
    def error_rates(self) -> dict[str, float]:
        """Probabilities of errors, by kind of error."""
        return {field.name: getattr(self, field.name) for field in fields(self) if field.name != "seed"}

    @property
    def label(self) -> str:
        """Short text with the probabilities and the seed; different settings have different texts."""
        parts = [f"{name}-{str(rate).removesuffix('.0')}" for name, rate in self.error_rates.items() if rate]
        return "-".join([*parts, f"seed-{self.seed}"])


def parse_noise(settings: Sequence[str]) -> PerceptionNoise:
    """Read probabilities of errors from settings such as ``missing=0.1``.

    Raises:
        InputError: a text is not such a setting.
    """
    names = [field.name for field in fields(PerceptionNoise)]
    values: dict[str, Any] = {}
    for setting in settings:
        name, separator, text = setting.partition("=")
        if name not in names or not separator:
            hint = did_you_mean(name, names)
            raise InputError(f"noise {setting}: expected NAME=NUMBER, NAME one of {', '.join(names)}{hint}")
        try:
            values[name] = int(text) if name == "seed" else float(text)
        except ValueError as error:
            kind = "whole number" if name == "seed" else "number"
            raise InputError(f"noise {setting}: expected a {kind}, not {text!r}") from error
    return PerceptionNoise(**values)


def perceive_with_noise(
    task: Task, words: SceneGraphVocabulary, noise: PerceptionNoise, repetition: str = ""
) -> SceneGraph:
    """Return the scene graph of a task with errors added by noise. Equal arguments give equal graphs.

    The noise never creates a cycle of objects that support each other. It never places an object in relation
    to an object without facts in the true scene graph, such as half of an uncut apple. A relation without a
    possible replacement is kept.

    Args:
        task: the task.
        words: the names of predicates and objects in scene graphs.
        noise: the probabilities of errors.
        repetition: name of a repetition, such as the number of an attempt at the task. Repetitions with
            different names have independent errors.
    """
    return _NoisySceneGraphMaker(task, words, noise, repetition).perceive_scene()


class _NoisySceneGraphMaker:
    """Makes the scene graph of one scene, with random errors."""

    def __init__(self, task: Task, words: SceneGraphVocabulary, noise: PerceptionNoise, stream: str) -> None:
        self._words = words
        self._noise = noise
        self._key = f"{noise.seed} {task.id} {stream}"
        self._truth = words.make_true_graph(task)
        self._names = words.list_object_names(task)
        agent = None if task.scene.agent is None else self._names[task.scene.agent]
        objects = [name for name in self._truth.objects if name != agent]
        self._unseen = {
            name for name in objects if self._make_seeded_random("unseen", name).random() < noise.unseen
        }
        self._seen_names = [name for name in self._truth.objects if name not in self._unseen]
        described = {name for fact in self._truth.facts for name in fact.arguments}
        self._described_names = [name for name in objects if name in described and name not in self._unseen]
        true_of_these = [index for index, name in enumerate(self._names) if name in set(self._truth.objects)]
        self._true_facts = {
            words.to_named_fact(fact, self._names) for fact in words.list_facts(task.initial, true_of_these)
        }
        supports = [words.find_predicate_name_in_graphs(name) for name in words.placement_predicate_names]
        self._supports = SupportRelation(frozenset(supports))

    def perceive_scene(self) -> SceneGraph:
        visible = [fact for fact in self._truth.facts if self._unseen.isdisjoint(fact.arguments)]
        draws = {fact: self._make_seeded_random("fact", str(fact)).random() for fact in visible}
        kept = [fact for fact in visible if draws[fact] >= self._noise.missing]
        moved = [
            fact for fact in kept if draws[fact] >= 1 - self._noise.misplaced and len(fact.arguments) == 2
        ]
        facts: dict[SceneGraphFact, SceneGraphFact] = {fact: fact for fact in kept if fact not in moved}
        for fact in facts:
            self._supports.add_fact(fact)
        for fact in moved:
            facts[fact] = self._misplace_object(fact, facts.values())
            self._supports.add_fact(facts[fact])
        in_order = [facts[fact] for fact in kept]
        in_order += self._sample_untrue_facts_for_noisy_graph(visible, in_order)
        doubles = dict(self._sample_objects_to_duplicate_with_new_names())
        in_order += [
            extra
            for name in doubles
            if (extra := self._sample_fact_about_duplicate(name, doubles[name])) is not None
        ]
        return make_scene_graph([*self._seen_names, *doubles.values()], in_order)

    def _misplace_object(
        self, fact: SceneGraphFact, facts_already_in_graph: Collection[SceneGraphFact]
    ) -> SceneGraphFact:
        """Return the relation with its second object replaced; unchanged if no other object is possible."""
        seen, objects = set(facts_already_in_graph), list(self._described_names)
        self._make_seeded_random("place", str(fact)).shuffle(objects)
        others = (fact._replace(arguments=(fact.arguments[0], name)) for name in objects)
        return next((other for other in others if self._is_new_untrue_fact(other, seen)), fact)

    def _sample_untrue_facts_for_noisy_graph(
        self, visible_true_facts: Sequence[SceneGraphFact], facts_already_in_graph: Sequence[SceneGraphFact]
    ) -> list[SceneGraphFact]:
        """Return random untrue facts for a scene graph, at most as many as there are visible facts.

        They are about visible objects with facts in the true graph. None states what the agent's hand holds.
        """
        all_seen, added = set(facts_already_in_graph), list[SceneGraphFact]()
        words = self._words
        predicates = [
            words.find_predicate_name_in_graphs(name)
            for name in words.stored_forms
            if name not in words.holding_predicate_names
        ]
        for fact in visible_true_facts if predicates and self._described_names else ():
            generator = self._make_seeded_random("more", str(fact))
            if generator.random() >= self._noise.unnecessary:
                continue
            drawn = (self._sample_random_fact(generator, predicates) for _ in range(_MAX_DRAWS))
            possible = (
                new
                for new in drawn
                if self._is_new_untrue_fact(new, all_seen)
                and not self._supports.would_add_second_support(new)
            )
            chosen = next(possible, None)
            if chosen is not None:
                all_seen.add(chosen)
                self._supports.add_fact(chosen)
                added.append(chosen)
        return added

    def _sample_random_fact(self, generator: random.Random, predicates: Sequence[str]) -> SceneGraphFact:
        predicate = generator.choice(predicates)
        arity = self._words.arity_by_predicate_name_in_graphs[predicate]
        return SceneGraphFact(
            predicate, tuple([generator.choice(self._described_names) for _ in range(arity)])
        )

    def _is_new_untrue_fact(self, fact: SceneGraphFact, facts_already_in_graph: set[SceneGraphFact]) -> bool:
        """Whether a fact is possible, untrue, and not yet in the graph.

        A possible fact names each object once, and makes no object support itself through other objects.
        """
        is_known = fact in self._true_facts or fact in facts_already_in_graph
        return (
            not is_known
            and len({*fact.arguments}) == len(fact.arguments)
            and not self._supports.would_close_cycle(fact)
        )

    def _sample_objects_to_duplicate_with_new_names(self) -> Iterator[tuple[str, str]]:
        """Yield the name of each object to which noise adds a duplicate, with the name of the duplicate."""
        taken = set(self._names)
        for name in self._seen_names:
            if (
                name in self._described_names
                and self._make_seeded_random("double", name).random() < self._noise.invented
            ):
                duplicate = _make_unused_name(name, taken)
                taken.add(duplicate)
                yield name, duplicate

    def _sample_fact_about_duplicate(self, object_name: str, duplicate_name: str) -> SceneGraphFact | None:
        """Return a random visible fact about an object, with the name of the object's duplicate instead.

        The duplicate is an invented object that the model sees beside the true object. The result is None if
        no fact about the object is visible.
        """
        facts = [fact for fact in self._truth.facts if fact.arguments[:1] == (object_name,)]
        facts = [fact for fact in facts if self._unseen.isdisjoint(fact.arguments)]
        if not facts:
            return None
        chosen = self._make_seeded_random("of double", object_name).choice(facts)
        return chosen._replace(arguments=(duplicate_name, *chosen.arguments[1:]))

    def _make_seeded_random(self, error_kind: str, fact_or_object: str) -> random.Random:
        """Return the random generator for one possible error, seeded by its kind and its fact or object."""
        digest = hashlib.sha256(f"{self._key} {error_kind} {fact_or_object}".encode()).digest()
        return random.Random(digest)  # noqa: S311 - noise, not secrets


def _make_unused_name(name: str, taken: set[str]) -> str:
    match = _NUMBER.search(name)
    stem, number = (f"{name}_", 1) if match is None else (name[: match.start()], int(match.group()))
    while f"{stem}{number}" in taken:
        number += 1
    return f"{stem}{number}"
