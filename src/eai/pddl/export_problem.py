"""The problem of an export: objects with their types, the facts of a state, and what the domain adds."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

from eai.errors import DomainError
from eai.logic.formula import Atom, Constant, Formula, Variable
from eai.pddl.glossary import Glossary
from eai.pddl.model import PddlDomain, PddlProblem, TypedName
from eai.pddl.names import PddlNames
from eai.world.derived import Computed, Lookup
from eai.world.frame import AGENT
from eai.world.relation import bits
from eai.world.state import Scene, State
from eai.world.vocabulary import DerivedPredicate


def object_key(scene: Scene, index: int) -> str:
    """What the table of names knows an object by: the agent, which conditions name, is known as that."""
    name = scene.objects[index].name
    if index == scene.agent:
        return AGENT.name
    return f"{name} " if name == AGENT.name else name


def order_name(glossary: Glossary) -> str:
    """The predicate of the order of the objects."""
    one, other = Variable("x"), Variable("y")
    return glossary.precedes(one, other).predicate


class ProblemWriter:
    """Writes problems of an exported domain.

    Args:
        glossary: the names of the export.
        names: those of the objects of the scene.
        header: the domain, operators apart.
        initial: the state at the start.
        kept: the objects that the problem is about, as a mask.
    """

    def __init__(
        self, glossary: Glossary, names: PddlNames, header: PddlDomain, initial: State, kept: int
    ) -> None:
        self._glossary = glossary
        self._initial = initial
        self._scene = initial.scene
        self._kept = dict.fromkeys(bits(kept))
        self._names = [names[object_key(self._scene, i)] for i in range(len(self._scene.objects))]
        self._header = header

    def write(self, name: str, goal: Formula) -> PddlProblem:
        """The problem with this name and goal."""
        constants = {item.name for item in self._header.constants}
        return PddlProblem(
            name=PddlNames()[name],
            domain=self._header.name,
            objects=tuple(
                [
                    TypedName(self._names[i], self._type(i))
                    for i in self._kept
                    if self._names[i] not in constants
                ]
            ),
            initial=tuple(self._facts()),
            denied=(),
            goal=goal,
        )

    def _type(self, index: int) -> str:
        return self._glossary.types[self._scene.objects[index].category]

    def _facts(self) -> Iterator[Atom]:
        declared = {predicate.name for predicate in self._header.predicates}
        for predicate, arguments in self._initial.facts():
            name = self._glossary.predicates[predicate]
            if name in declared and all(i in self._kept for i in arguments):
                yield self._atom(name, *arguments)
        for category, kind in self._glossary.kinds.items():
            for i in bits(self._scene.category(category)):
                if i in self._kept:
                    yield self._atom(kind, i)
        for derived in self._glossary.frozen.values():
            for arguments in product(self._kept, repeat=derived.arity):
                if _holds(derived, self._initial, arguments):
                    yield self._atom(self._glossary.predicates[derived.name], *arguments)
        if self._glossary.ordered:
            order = order_name(self._glossary)
            kept = list(self._kept)
            for place, i in enumerate(kept):
                yield from (self._atom(order, i, j) for j in kept[place + 1 :])

    def _atom(self, predicate: str, *arguments: int) -> Atom:
        return Atom(predicate, tuple([Constant(self._names[i]) for i in arguments]))


def _holds(derived: DerivedPredicate, state: State, arguments: tuple[int, ...]) -> bool:
    """Whether a derived predicate that has a function holds in a state."""
    match derived:
        case Lookup(values=values):
            return bool(values(state, arguments[:-1]) >> arguments[-1] & 1)
        case Computed(test=test):
            return test(state, arguments)
        case _:
            raise DomainError(f"{derived.name} has no function")
