"""What there is to perceive of a task's scene: the facts that its prompt tells, over names."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cached_property

import eai.logic.formula as f
from eai.abilities.task import Task
from eai.abilities.wording import Wording, subjects
from eai.planning.role import SpatialRoles, spatial_roles
from eai.studies.perception.scene_graph import NamedFact, SceneGraph, graph_of
from eai.world.derived import meaning
from eai.world.state import Fact, State
from eai.world.vocabulary import Vocabulary


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
    def roles(self) -> SpatialRoles:
        """What says where things are, by described predicate."""
        roles = spatial_roles(self.wording.domain)
        return SpatialRoles(self._said(roles.held), self._said(roles.supports))

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
        """What scene graphs call a predicate."""
        return self.wording.written_as.get(predicate, predicate)

    def names(self, task: Task) -> list[str]:
        """What each object of the scene is called."""
        return [self.wording.object_name(task, index) for index in range(len(task.scene.objects))]

    def holding(self, state: State, objects: Sequence[int]) -> Iterator[Fact]:
        """All facts about some objects, those included that follow from others."""
        for each in self.wording.listings:
            yield from each.facts(state, objects)

    def elementary(self, state: State, objects: Sequence[int]) -> Iterator[Fact]:
        """The facts about some objects from which the others follow."""
        for fact in self.holding(state, objects):
            form = self.stored.get(fact.predicate)
            if form is not None and state.has(form, *fact.arguments):
                yield fact

    def describe(self, task: Task, objects: Sequence[int] | None = None) -> SceneGraph:
        """What there is to perceive: of the objects that a prompt speaks of, or of these."""
        names, chosen = self.names(task), subjects(task) if objects is None else objects
        facts = self.elementary(task.initial, chosen)
        return graph_of([names[index] for index in chosen], [self.named(fact, names) for fact in facts])

    def named(self, fact: Fact, names: Sequence[str]) -> NamedFact:
        """A fact by names."""
        return NamedFact(self.spelling(fact.predicate), tuple([names[index] for index in fact.arguments]))

    def _said(self, stored: Iterable[str]) -> tuple[str, ...]:
        wanted = set(stored)
        return tuple([name for name, form in self.stored.items() if form in wanted])


def stored_form(vocabulary: Vocabulary, predicate: str) -> str | None:
    """The stored predicate that says the same of the same objects in the simplest case; None if none does.

    That is the first one in the definition which changes and is said there, not denied, of all parameters.
    """
    if (own := vocabulary.stored(predicate)) is not None:
        return None if own.static else predicate
    derived = vocabulary.derived_by_name.get(predicate)
    defined = None if derived is None else meaning(derived)
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
