"""Read and write scene graphs: objects of a scene by name, and the facts about them."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import eai.logic.formula as f
from eai.abilities.answer_text import AnswerFormat, JsonObject, contains_json_string, read_json
from eai.abilities.verdict import Unreadable
from eai.planning.role import find_holding_and_location_predicates
from eai.tasks.task import Task
from eai.tasks.wording import PromptAndAnswerWording, list_objects_in_prompt
from eai.world.derived import find_definition
from eai.world.state import Fact, State
from eai.world.vocabulary import Vocabulary

SCENE = "scene"
"""Field of a question's metadata: text of the scene graph that the question states instead of the scene."""


class SceneGraphFact(NamedTuple):
    """A fact of a scene graph: the names of its predicate and of its objects, as answers write them."""

    predicate: str
    arguments: tuple[str, ...]

    def __str__(self) -> str:
        return f"{self.predicate}({', '.join(self.arguments)})"


@dataclass(frozen=True, slots=True)
class SceneGraph:
    """A perceived scene: names of objects, and facts about these objects, each listed once and in order.

    Attributes:
        objects: names of the objects.
        facts: facts about the objects.
        ill_formed: entries of an answer that are not facts, as texts.
        repairs: names of the corrections that were made to the answer's text to read the graph.
        unreadable: why no scene graph can be read from the answer; None if it can be read.
    """

    objects: tuple[str, ...] = ()
    facts: tuple[SceneGraphFact, ...] = ()
    ill_formed: tuple[str, ...] = ()
    repairs: tuple[str, ...] = ()
    unreadable: str | None = None

    @property
    def mentioned_objects(self) -> tuple[str, ...]:
        """Names of all objects in the graph, including objects that only facts name, each once."""
        return tuple(
            dict.fromkeys([*self.objects, *(name for fact in self.facts for name in fact.arguments)])
        )

    @property
    def json_text(self) -> str:
        """The graph as answers write it: ``{"objects": ["a", ...], "facts": [["on", "a", "b"], ...]}``."""
        return json.dumps(
            {"objects": self.objects, "facts": [[fact.predicate, *fact.arguments] for fact in self.facts]}
        )


def read_scene_graph(text: str, arities: Mapping[str, int]) -> SceneGraph:
    """Read the scene graph in the text of an answer.

    Args:
        text: the answer.
        arities: number of objects of each predicate, by the predicate's name in answers.
    """
    reading = read_json(text, _FORM)
    if isinstance(reading, Unreadable):
        return SceneGraph(unreadable=reading.reason)
    objects, entries = reading.value
    names = [name for name in objects if isinstance(name, str)]
    facts: list[SceneGraphFact] = []
    ill_formed = [str(name) for name in objects if not isinstance(name, str)]
    for entry in entries:
        fact = _read_fact(entry, arities)
        if fact is None:
            ill_formed.append(json.dumps(entry, default=lambda item: dict(item.members)))
        else:
            facts.append(fact)
    return replace(make_scene_graph(names, facts), ill_formed=tuple(ill_formed), repairs=reading.repairs)


def _read_object_and_fact_lists(value: object) -> tuple[list[object], list[object]] | None:
    """Return the lists of objects and facts in a JSON object, or None for a value without a list of facts."""
    if not isinstance(value, JsonObject):
        return None
    members = dict(value.members)
    objects, facts = members.get("objects", []), members.get("facts")
    return (objects, facts) if isinstance(objects, list) and isinstance(facts, list) else None


_FORM = AnswerFormat(
    'JSON object with "objects" and "facts", lists', _read_object_and_fact_lists, is_part=contains_json_string
)


def _read_fact(entry: object, arities: Mapping[str, int]) -> SceneGraphFact | None:
    if not isinstance(entry, list) or not entry or not all(isinstance(part, str) for part in entry):
        return None
    predicate, *arguments = entry
    return SceneGraphFact(predicate, tuple(arguments)) if arities.get(predicate) == len(arguments) else None


def make_scene_graph(objects: Iterable[str], facts: Iterable[SceneGraphFact]) -> SceneGraph:
    """Return a scene graph with some objects and facts. Repeated objects or facts are kept once."""
    return SceneGraph(tuple(dict.fromkeys(objects)), tuple(dict.fromkeys(facts)))


class SupportRelation:
    """Which object supports which other objects, collected fact by fact.

    Args:
        predicates: names of the predicates that say that an object is in, on or under another, as scene
            graphs write them.
    """

    def __init__(self, predicates: frozenset[str]) -> None:
        self._predicates = predicates
        self._below: dict[str, list[str]] = {}

    def add_fact(self, fact: SceneGraphFact) -> None:
        """Add a fact; it is ignored unless its predicate says that an object supports another."""
        if fact.predicate in self._predicates:
            self._below.setdefault(fact.arguments[0], []).append(fact.arguments[1])

    def would_add_second_support(self, fact: SceneGraphFact) -> bool:
        """Whether adding a fact would give an object a second support."""
        return fact.predicate in self._predicates and fact.arguments[0] in self._below

    def would_close_cycle(self, fact: SceneGraphFact) -> bool:
        """Whether adding a fact would make an object support itself through other objects."""
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


class SceneGraphVocabulary:
    """The names of predicates and objects in scene graphs of one domain.

    Args:
        wording: how prompts of the domain write its facts.

    Attributes:
        wording: how prompts of the domain write its facts.
        stored_forms: predicate in prompts -> the stored predicate that implies it for the same arguments.
            States contain the facts of stored predicates; the facts of other predicates are derived.
    """

    def __init__(self, wording: PromptAndAnswerWording) -> None:
        vocabulary = wording.domain.vocabulary
        self.wording = wording
        forms = {
            name: find_implying_predicate_stored_in_states(vocabulary, name) for name in wording.predicates
        }
        self.stored_forms: Mapping[str, str] = {
            name: form for name, form in forms.items() if form is not None
        }

    @cached_property
    def holding_predicate_names(self) -> tuple[str, ...]:
        """Names in the domain of the predicates by which prompts state that a hand holds an object."""
        return self._list_predicates_implied_by(find_holding_and_location_predicates(self.wording.domain)[0])

    @cached_property
    def placement_predicate_names(self) -> tuple[str, ...]:
        """Names in the domain of the predicates by which prompts place an object in, on or under another."""
        return self._list_predicates_implied_by(find_holding_and_location_predicates(self.wording.domain)[1])

    @cached_property
    def arity_by_predicate_name_in_graphs(self) -> Mapping[str, int]:
        """Number of objects of each predicate, by the predicate's name in scene graphs."""
        arity = self.wording.domain.vocabulary.find_arity
        return {
            self.find_predicate_name_in_graphs(name): arity(name) or 0 for name in self.wording.predicates
        }

    @cached_property
    def predicate_by_name_in_graphs(self) -> Mapping[str, str]:
        """Name of each predicate in the domain, by its name in scene graphs."""
        return {self.find_predicate_name_in_graphs(name): name for name in self.wording.predicates}

    def find_predicate_name_in_graphs(self, predicate: str) -> str:
        """Return the name that scene graphs use for a predicate of the domain."""
        return self.wording.answer_names.get(predicate, predicate)

    def list_object_names(self, task: Task) -> list[str]:
        """Return the names of a scene's objects, in the order of the scene."""
        return [self.wording.object_name(task, index) for index in range(len(task.scene.objects))]

    def list_facts(self, state: State, objects: Sequence[int]) -> Iterator[Fact]:
        """Yield all facts about some objects, including facts that follow from others."""
        for listing in self.wording.fact_listers_of_goal_predicates:
            yield from listing.list_facts(state, objects)

    def list_facts_stored_in_state(self, state: State, objects: Sequence[int]) -> Iterator[Fact]:
        """Yield the facts about some objects that a state stores. All other facts follow from these."""
        for fact in self.list_facts(state, objects):
            form = self.stored_forms.get(fact.predicate)
            if form is not None and state.has(form, *fact.arguments):
                yield fact

    def make_true_graph(self, task: Task, objects: Sequence[int] | None = None) -> SceneGraph:
        """Return the true scene graph of some objects, by default of all objects in the task's prompt."""
        names = self.list_object_names(task)
        chosen = list_objects_in_prompt(task) if objects is None else objects
        facts = self.list_facts_stored_in_state(task.initial, chosen)
        return make_scene_graph(
            [names[index] for index in chosen], [self.to_named_fact(fact, names) for fact in facts]
        )

    def to_named_fact(self, fact: Fact, names: Sequence[str]) -> SceneGraphFact:
        """Return a fact with names of its predicate and objects as scene graphs write them."""
        return SceneGraphFact(
            self.find_predicate_name_in_graphs(fact.predicate),
            tuple([names[index] for index in fact.arguments]),
        )

    def _list_predicates_implied_by(self, stored_predicates: Iterable[str]) -> tuple[str, ...]:
        wanted = set(stored_predicates)
        return tuple([name for name, form in self.stored_forms.items() if form in wanted])


def find_implying_predicate_stored_in_states(vocabulary: Vocabulary, predicate: str) -> str | None:
    """Return a stored predicate that implies a predicate for the same arguments, or None.

    States contain the facts of stored predicates. A stored predicate that actions can change implies itself.
    For a derived predicate, the predicates of its definition are tried in order, if they are not negated and
    have all parameters as arguments.
    """
    if (stored := vocabulary.find_stored_predicate(predicate)) is not None:
        return None if stored.static else predicate
    derived = vocabulary.derived_by_name.get(predicate)
    defined = None if derived is None else find_definition(derived)
    if defined is None:
        return None
    for atom in _iterate_positive_atoms(defined.definition):
        if atom.predicate != predicate and atom.arguments == defined.parameters:
            form = find_implying_predicate_stored_in_states(vocabulary, atom.predicate)
            if form is not None:
                return form
    return None


def _iterate_positive_atoms(formula: f.Formula) -> Iterator[f.Atom]:
    """Yield the atoms (predicates with arguments) of a formula that are not negated, left to right."""
    match formula:
        case f.Atom():
            yield formula
        case f.And(parts) | f.Or(parts):
            for part in parts:
                yield from _iterate_positive_atoms(part)
        case _:
            return
