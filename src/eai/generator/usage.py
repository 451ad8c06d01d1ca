"""The world as it is used: every action is possible only with objects of categories that plans use it with.

A declaration allows more than anybody does: to wash anything, to put books into sinks. Certificates are found
in a copy of the domain in which each operator also asks of each argument that it be usual; operators that no
plan uses are left out.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

from eai.generator.prior import Prior
from eai.world.domain import Domain
from eai.world.operator import Operator, affordance
from eai.world.relation import bits
from eai.world.state import Fact, Scene, State
from eai.world.vocabulary import Predicate, Vocabulary


class Usage:
    """A domain restricted to what is usual; unrestricted if the data set has no plans to tell it from.

    Attributes:
        domain: the restricted domain.
    """

    def __init__(self, domain: Domain, prior: Prior) -> None:
        self._original = domain.vocabulary
        self._predicates: dict[tuple[str, int], Predicate] = {}
        self._categories: dict[tuple[str, int], list[str]] = {}
        if not prior.kinds:
            self.domain = domain
            return
        for kind in sorted(prior.kinds):
            key = kind.operator, kind.place
            self._predicates.setdefault(key, Predicate(f"usual {kind.operator} {kind.place}", 1, static=True))
            self._categories.setdefault(key, []).append(kind.category)
        vocabulary = Vocabulary(
            (*self._original.predicates, *self._predicates.values()), self._original.derived
        )
        used = [operator for operator in domain.operators if operator.name in prior.operators]
        self.domain = replace(domain, vocabulary=vocabulary, operators=tuple(map(self._restricted, used)))

    def _restricted(self, operator: Operator) -> Operator:
        checks = [
            affordance(self._predicates[operator.name, place](parameter), f"{{{parameter.name}}} is unusual")
            for place, parameter in enumerate(operator.parameters)
        ]
        return replace(operator, checks=(*checks, *operator.checks))

    def state(self, scene: Scene, facts: Iterable[Fact]) -> State:
        """A state of the restricted domain about the objects of a scene."""
        own = Scene(self.domain.vocabulary, scene.objects, scene.agent)
        return own.state((*self._known(facts), *self._usual(own)))

    def original(self, state: State) -> State:
        """A state of the restricted domain as one of the declared domain, which begins an episode."""
        scene = Scene(self._original, state.scene.objects, state.scene.agent)
        return scene.state(self._known(state.facts()))

    def _known(self, facts: Iterable[Fact]) -> Iterator[Fact]:
        return (fact for fact in facts if self._original.stored(fact.predicate) is not None)

    def _usual(self, scene: Scene) -> Iterator[Fact]:
        for key, predicate in self._predicates.items():
            for category in self._categories[key]:
                yield from (Fact(predicate.name, (i,)) for i in bits(scene.category(category)))
