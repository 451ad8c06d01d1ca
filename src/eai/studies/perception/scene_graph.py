"""Scene graphs: what there is to perceive of a scene, over names, and how answers write it."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import eai.logic.formula as f
from eai.abilities.answer_text import AnswerForm, JsonObject, holds_strings, read_json
from eai.abilities.verdict import Unreadable
from eai.planning.role import spatial_predicates
from eai.tasks.task import Task
from eai.tasks.wording import Wording, prompt_objects
from eai.world.derived import find_definition
from eai.world.state import Fact, State
from eai.world.vocabulary import Vocabulary

SCENE = "scene"
"""The field of a question's metadata that has the scene graph which it tells of instead of the scene."""


class NamedFact(NamedTuple):
    """A fact by the names that answers use."""

    predicate: str
    arguments: tuple[str, ...]

    def __str__(self) -> str:
        return f"{self.predicate}({', '.join(self.arguments)})"


@dataclass(frozen=True, slots=True)
class SceneGraph:
    """A perceived scene: objects by name, and facts about them, each once and in order.

    Attributes:
        objects: the objects.
        facts: the facts.
        ill_formed: the entries of an answer that are left out, as texts.
        repairs: what it took to find it in the answer.
        unreadable: why there is none in the answer; None if there is one.
    """

    objects: tuple[str, ...] = ()
    facts: tuple[NamedFact, ...] = ()
    ill_formed: tuple[str, ...] = ()
    repairs: tuple[str, ...] = ()
    unreadable: str | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """All names in it, each once."""
        return tuple(
            dict.fromkeys([*self.objects, *(name for fact in self.facts for name in fact.arguments)])
        )

    @property
    def text(self) -> str:
        """It as an answer writes it: ``{"objects": ["a", ...], "facts": [["inside", "a", "b"], ...]}``."""
        return json.dumps(
            {"objects": self.objects, "facts": [[fact.predicate, *fact.arguments] for fact in self.facts]}
        )


def read_scene_graph(text: str, arities: Mapping[str, int]) -> SceneGraph:
    """The scene graph in an answer.

    Args:
        text: the answer.
        arities: how many objects each predicate is said of, by its name in answers.
    """
    reading = read_json(text, _FORM)
    if isinstance(reading, Unreadable):
        return SceneGraph(unreadable=reading.reason)
    objects, entries = reading.value
    names = [name for name in objects if isinstance(name, str)]
    facts: list[NamedFact] = []
    ill_formed = [str(name) for name in objects if not isinstance(name, str)]
    for entry in entries:
        fact = _fact(entry, arities)
        if fact is None:
            ill_formed.append(json.dumps(entry))
        else:
            facts.append(fact)
    return replace(graph_of(names, facts), ill_formed=tuple(ill_formed), repairs=reading.repairs)


def _sections(value: object) -> tuple[list[object], list[object]] | None:
    """The objects and facts of a JSON value that has a list of facts."""
    if not isinstance(value, JsonObject):
        return None
    members = dict(value.members)
    objects, facts = members.get("objects", []), members.get("facts")
    return (objects, facts) if isinstance(objects, list) and isinstance(facts, list) else None


_FORM = AnswerForm('JSON object with "objects" and "facts", lists', _sections, is_part=holds_strings)


def _fact(entry: object, arities: Mapping[str, int]) -> NamedFact | None:
    if not isinstance(entry, list) or not entry or not all(isinstance(part, str) for part in entry):
        return None
    predicate, *arguments = entry
    return NamedFact(predicate, tuple(arguments)) if arities.get(predicate) == len(arguments) else None


def graph_of(objects: Iterable[str], facts: Iterable[NamedFact]) -> SceneGraph:
    """The scene graph of objects and facts, each once."""
    return SceneGraph(tuple(dict.fromkeys(objects)), tuple(dict.fromkeys(facts)))


class Supports:
    """The supports of objects, while facts are added.

    Args:
        predicates: what says so, by the names that scene graphs use.
    """

    def __init__(self, predicates: frozenset[str]) -> None:
        self._predicates = predicates
        self._below: dict[str, list[str]] = {}

    def add(self, fact: NamedFact) -> None:
        """Take a fact into account, if it is of a support."""
        if fact.predicate in self._predicates:
            self._below.setdefault(fact.arguments[0], []).append(fact.arguments[1])

    def rests(self, fact: NamedFact) -> bool:
        """Whether a fact gives a support to something that has one."""
        return fact.predicate in self._predicates and fact.arguments[0] in self._below

    def closes(self, fact: NamedFact) -> bool:
        """Whether a fact would close a circle of supports."""
        if fact.predicate not in self._predicates:
            return False
        first, second = fact.arguments
        pending, seen = [second], set[str]()
        while pending:
            name = pending.pop()
            if name == first:
                return True
            if name not in seen:
                seen.add(name)
                pending += self._below.get(name, ())
        return False


class SceneWords:
    """How scene graphs of one domain say what is so.

    Args:
        wording: what facts and objects are called.

    Attributes:
        wording: the same.
        stored: by described predicate, the stored predicate that alone makes it true of the same objects.
    """

    def __init__(self, wording: Wording) -> None:
        vocabulary = wording.domain.vocabulary
        self.wording = wording
        forms = {name: stored_form(vocabulary, name) for name in wording.predicates}
        self.stored: Mapping[str, str] = {name: form for name, form in forms.items() if form is not None}

    @cached_property
    def held(self) -> tuple[str, ...]:
        """The described predicates that say what is in a hand."""
        return self._described(spatial_predicates(self.wording.domain)[0])

    @cached_property
    def supports(self) -> tuple[str, ...]:
        """The described predicates that say in, on or under what things are."""
        return self._described(spatial_predicates(self.wording.domain)[1])

    @cached_property
    def arities(self) -> Mapping[str, int]:
        """How many objects each predicate is said of, by its name in scene graphs."""
        arity = self.wording.domain.vocabulary.arity
        return {self.spelling(name): arity(name) or 0 for name in self.wording.predicates}

    @cached_property
    def predicates(self) -> Mapping[str, str]:
        """The described predicates by their names in scene graphs."""
        return {self.spelling(name): name for name in self.wording.predicates}

    def spelling(self, predicate: str) -> str:
        """The name of a predicate in scene graphs."""
        return self.wording.answer_names.get(predicate, predicate)

    def names(self, task: Task) -> list[str]:
        """The name of each object of the scene."""
        return [self.wording.object_name(task, index) for index in range(len(task.scene.objects))]

    def holding(self, state: State, objects: Sequence[int]) -> Iterator[Fact]:
        """All facts about some objects, those included that follow from others."""
        for each in self.wording.goal_listings:
            yield from each.facts(state, objects)

    def elementary(self, state: State, objects: Sequence[int]) -> Iterator[Fact]:
        """The facts about some objects from which the others follow."""
        for fact in self.holding(state, objects):
            form = self.stored.get(fact.predicate)
            if form is not None and state.has(form, *fact.arguments):
                yield fact

    def describe(self, task: Task, objects: Sequence[int] | None = None) -> SceneGraph:
        """The scene graph of a task: of the objects that a prompt speaks of, or of these."""
        names, chosen = self.names(task), prompt_objects(task) if objects is None else objects
        facts = self.elementary(task.initial, chosen)
        return graph_of([names[index] for index in chosen], [self.named(fact, names) for fact in facts])

    def named(self, fact: Fact, names: Sequence[str]) -> NamedFact:
        """A fact by names."""
        return NamedFact(self.spelling(fact.predicate), tuple([names[index] for index in fact.arguments]))

    def _described(self, stored: Iterable[str]) -> tuple[str, ...]:
        wanted = set(stored)
        return tuple([name for name, form in self.stored.items() if form in wanted])


def stored_form(vocabulary: Vocabulary, predicate: str) -> str | None:
    """The stored predicate that says the same of the same objects in the simplest case; None if none does.

    That is the first one in the definition which changes and is said there, not denied, of all parameters.
    """
    if (own := vocabulary.find_stored(predicate)) is not None:
        return None if own.static else predicate
    derived = vocabulary.derived_by_name.get(predicate)
    defined = None if derived is None else find_definition(derived)
    if defined is None:
        return None
    for atom in _asserted(defined.definition):
        if atom.predicate != predicate and atom.arguments == defined.parameters:
            form = stored_form(vocabulary, atom.predicate)
            if form is not None:
                return form
    return None


def _asserted(formula: f.Formula) -> Iterator[f.Atom]:
    """The atoms of a formula that are not denied, left to right."""
    match formula:
        case f.Atom():
            yield formula
        case f.And(parts) | f.Or(parts):
            for part in parts:
                yield from _asserted(part)
        case _:
            return
