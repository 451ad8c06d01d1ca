"""Which operators make an atom true or false: the effects of a domain, by predicate."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

from eai.logic.formula import Atom, Constant, Formula, Not
from eai.world.domain import Domain
from eai.world.effect import ANYTHING, Add, Delete, Effect, ForEach, Let, When
from eai.world.frame import AGENT
from eai.world.operator import Operator
from eai.world.reading import free_variables

_NO_ATOM = Atom("")


class Achiever(NamedTuple):
    """One written change of an operator.

    Attributes:
        operator: the operator.
        atom: what it adds or deletes; its variables are parameters of the operator or bound by the effects
            around it.
        variables: the operator's parameters, then the variables of the effects around the change.
        conditions: what must hold for the change to be made and is about the parameters alone, the operator's
            own checks first.
        given: what must hold besides, about the other variables: it decides what else the action changes by
            the way.
    """

    operator: Operator
    atom: Atom
    variables: tuple[str, ...]
    conditions: tuple[Formula, ...]
    given: tuple[Formula, ...]

    def match(self, arguments: tuple[int, ...], agent: int | None) -> dict[str, int] | None:
        """The variables' objects that make this a change of the atom with these arguments, or None."""
        found: dict[str, int] = {}
        for term, index in zip(self.atom.arguments, arguments, strict=True):
            if term == ANYTHING:
                continue
            if isinstance(term, Constant):
                if term != AGENT or index != agent:
                    return None
            elif found.setdefault(term.name, index) != index:
                return None
        return found


class Achievers:
    """All written changes of a domain."""

    def __init__(self, domain: Domain) -> None:
        self._by_change: dict[tuple[str, bool], list[Achiever]] = {}
        self._writers: dict[str, dict[str, Operator]] = {}
        for operator in domain.operators:
            for achiever, adds in _of_operator(operator):
                predicate = achiever.atom.predicate
                self._by_change.setdefault((predicate, adds), []).append(achiever)
                self._writers.setdefault(predicate, {})[operator.name] = operator
        for changes in self._by_change.values():
            changes.sort(key=lambda each: (len(each.given), len(each.conditions)))

    def of(self, predicate: str, *, adding: bool) -> list[Achiever]:
        """The changes that make atoms of a predicate true, or false; those that need least come first."""
        return self._by_change.get((predicate, adding), [])

    def writers(self, predicates: Iterable[str]) -> list[Operator]:
        """The operators that change any of these predicates, in a fixed order."""
        found = {name: op for p in predicates for name, op in self._writers.get(p, {}).items()}
        return list(found.values())


def taking(operator: Operator) -> Achiever:
    """The operator as it is taken for its own sake, whatever it changes."""
    names = tuple(p.name for p in operator.parameters)
    return Achiever(operator, _NO_ATOM, names, tuple(check.condition for check in operator.checks), ())


def _of_operator(operator: Operator) -> Iterator[tuple[Achiever, bool]]:
    taken = taking(operator)
    yield from _changes(operator.effects, taken)
    for each in operator.tries:
        own = (each.condition, *(check.condition for check in each.checks))
        yield from _changes(each.effects, taken._replace(conditions=(*taken.conditions, *own)))


def _changes(effects: Iterable[Effect], around: Achiever) -> Iterator[tuple[Achiever, bool]]:
    """The changes that effects make, where all that is ``around`` them holds, and whether they add."""
    for effect in effects:
        match effect:
            case Add(atom) | Delete(atom):
                yield around._replace(atom=atom), isinstance(effect, Add)
            case When(condition, inner, otherwise):
                yield from _changes(inner, _given(around, condition))
                yield from _changes(otherwise, _given(around, Not(condition)))
            case ForEach(variable, condition, inner) | Let(variable, condition, inner):
                # Where the variable hides another one, the change is left out: estimates can do without it.
                if variable.name not in around.variables:
                    wider = around._replace(variables=(*around.variables, variable.name))
                    yield from _changes(inner, _given(wider, condition))


def _given(around: Achiever, condition: Formula) -> Achiever:
    parameters = {p.name for p in around.operator.parameters}
    if free_variables(condition) <= parameters:
        return around._replace(conditions=(*around.conditions, condition))
    return around._replace(given=(*around.given, condition))
