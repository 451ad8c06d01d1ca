"""The rules of a domain in words and formulas: what its actions need and do, exactly as they are declared.

A repertoire is all that a few ground actions can lead to: exhausted, so that what is out of reach is proved
to be.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import groupby
from typing import Protocol

import eai.logic.formula as f
from eai.errors import DomainError
from eai.logic.ltl_printer import print_ltl
from eai.logic.traversal import walk
from eai.planning.effect_schema import written
from eai.world.derived import Lookup, meaning, stored_sources
from eai.world.domain import Domain
from eai.world.effect import Add, Delete, Effect, ForEach, Let, When
from eai.world.execution import Action
from eai.world.operator import Operator
from eai.world.reading import Readings
from eai.world.state import Fact, State
from eai.world.vocabulary import DerivedPredicate

_INDENT = "  "
_BECOMES: Mapping[type[Effect], str] = {Add: "becomes true", Delete: "becomes false"}


@dataclass(frozen=True)
class Rules:
    """The rules of a domain without a word that no prompt may say: nothing of invisible memory.

    Operators that read what cannot be seen and changes, that try several things, or that need a predicate
    which no formula defines, cannot be shown; no question is about them.

    Attributes:
        domain: the declaration.
    """

    domain: Domain

    @cached_property
    def operators(self) -> tuple[Operator, ...]:
        """The operators that can be shown."""
        return tuple([each for each in self.domain.operators if self._can_be_shown(each)])

    @cached_property
    def names(self) -> frozenset[str]:
        """The names of these."""
        return frozenset([operator.name for operator in self.operators])

    @cached_property
    def readings(self) -> Readings:
        """Formulas as functions of states."""
        return Readings(self.domain.vocabulary)

    @cached_property
    def memory(self) -> frozenset[str]:
        """The stored predicates that change and are never shown."""
        predicates = self.domain.vocabulary.predicates
        return frozenset([p.name for p in predicates if not p.visible and not p.static])

    @cached_property
    def fluents(self) -> frozenset[str]:
        """The stored predicates that can be shown and can change."""
        predicates = self.domain.vocabulary.predicates
        return frozenset([p.name for p in predicates if p.visible and not p.static])

    def written(self, operator: str) -> frozenset[str]:
        """The predicates that an operator changes and that can be shown."""
        return self._written[operator]

    @cached_property
    def _written(self) -> Mapping[str, frozenset[str]]:
        return {each.name: frozenset(written(each.effects)) - self.memory for each in self.operators}

    def predicates(self, operators: Collection[str], formulas: Iterable[f.Formula] = ()) -> frozenset[str]:
        """The stored predicates that operators read or change, or that decide formulas."""
        decisive = stored_sources(_read(formulas), self.domain.vocabulary)
        return frozenset(decisive).union(*(self._about[name] for name in operators))

    @cached_property
    def _about(self) -> Mapping[str, frozenset[str]]:
        """The stored predicates that each operator reads or changes."""
        vocabulary = self.domain.vocabulary
        return {
            name: self.written(name).union(stored_sources(read, vocabulary))
            for name, read in self._reads.items()
        }

    def text(self, operators: Collection[str], formulas: Iterable[f.Formula] = ()) -> str:
        """The rules of some operators, and the definitions of what they and some formulas speak of."""
        shown = [each for each in self.operators if each.name in operators]
        named = list(
            dict.fromkeys([*_read(formulas), *(n for each in shown for n in self._reads[each.name])])
        )
        lines = [
            *(self._texts[each.name] for each in shown),
            *(self._definitions[name] for name in self._derived(named)),
        ]
        return "\n".join(lines)

    def heads(self, operators: Collection[str]) -> str:
        """Some operators with their parameters, and nothing about them."""
        return "\n".join([_head(each) for each in self.operators if each.name in operators])

    @cached_property
    def _texts(self) -> Mapping[str, str]:
        """The text of each operator, by name."""
        return {operator.name: self._operator(operator) for operator in self.operators}

    @cached_property
    def _reads(self) -> Mapping[str, Sequence[str]]:
        """The predicates that the conditions of each operator name."""
        return {operator.name: _read(_conditions(operator)) for operator in self.operators}

    def _can_be_shown(self, operator: Operator) -> bool:
        vocabulary = self.domain.vocabulary
        read = _read(_conditions(operator))
        derived = [vocabulary.derived_by_name[name] for name in self._derived(read)]
        undefined = any(meaning(each) is None for each in derived)
        reads_memory = not self.memory.isdisjoint(stored_sources(read, vocabulary))
        return not (operator.tries or undefined or reads_memory)

    def _derived(self, names: Iterable[str]) -> list[str]:
        """The derived predicates among these and in their definitions, each once."""
        found: dict[str, None] = {}
        pending = list(names)
        while pending:
            name = pending.pop(0)
            derived = self.domain.vocabulary.derived_by_name.get(name)
            if derived is None or name in found:
                continue
            found[name] = None
            defined = meaning(derived)
            pending += [] if defined is None else _read([defined.definition])
        return list(found)

    def _operator(self, operator: Operator) -> str:
        head = _head(operator)
        lines = [f"{head}: {operator.description}" if operator.description else head]
        names = {parameter.name: parameter.name for parameter in operator.parameters}
        for number, check in enumerate(operator.checks, 1):
            lines.append(
                f"{_INDENT}requirement {number}: {_text_of(check.condition)}"
                f'   [otherwise "{check.reason.format_map(names)}"]'
            )
        effects = list(self._effects(operator.effects, _INDENT))
        return "\n".join([*lines, *(effects or [f"{_INDENT}changes nothing"])])

    def _effects(self, effects: Sequence[Effect], indent: str) -> Iterator[str]:
        """The effects in order; what becomes true, or false, one after the other stands on one line."""
        for kind, run in groupby(effects, type):
            if kind in (Add, Delete):
                atoms = [each.atom for each in run if isinstance(each, Add | Delete)]
                shown = [_text_of(atom) for atom in atoms if atom.predicate not in self.memory]
                yield from [f"{indent}{_BECOMES[kind]}: {', '.join(shown)}"] if shown else []
                continue
            for effect in run:
                yield from self._compound(effect, indent)

    def _compound(self, effect: Effect, indent: str) -> Iterator[str]:
        match effect:
            case When(condition, effects, otherwise):
                yield from self._block(f"if {_text_of(condition)}", effects, indent)
                yield from self._block(f"if {_text_of(f.Not(condition))}", otherwise, indent)
            case ForEach(variable, condition, effects):
                yield from self._block(
                    f"for each {variable.name} with {_text_of(condition)}", effects, indent
                )
            case Let(variable, condition, effects):
                first = f"for the first {variable.name} with {_text_of(condition)}"
                yield from self._block(first, effects, indent)

    def _block(self, heading: str, effects: Sequence[Effect], indent: str) -> Iterator[str]:
        """A heading with the effects below it; neither where there is nothing to tell."""
        lines = list(self._effects(effects, indent + _INDENT))
        yield from [f"{indent}{heading}:", *lines] if lines else []

    @cached_property
    def _definitions(self) -> Mapping[str, str]:
        """The meaning of each derived predicate, as far as a formula says it."""
        derived = [each for each in self.domain.vocabulary.derived if meaning(each) is not None]
        return {each.name: _definition(each) for each in derived}


def _head(operator: Operator) -> str:
    return f"{operator.name}({', '.join([p.name for p in operator.parameters])})"


def _definition(derived: DerivedPredicate) -> str:
    defined = meaning(derived)
    if defined is None:
        raise DomainError(f"derived predicate {derived.name} has no formula")
    remark = derived.open_in_meaning if isinstance(derived, Lookup) else ""
    said = f"{derived.name}({', '.join([p.name for p in defined.parameters])}) means: "
    return f"{said}{_text_of(defined.definition)}{f' ({remark})' if remark else ''}"


def _conditions(operator: Operator) -> list[f.Formula]:
    return [*(check.condition for check in operator.checks), *_of_effects(operator.effects)]


def _of_effects(effects: Iterable[Effect]) -> Iterator[f.Formula]:
    for effect in effects:
        match effect:
            case When(condition, inner, otherwise):
                yield condition
                yield from _of_effects((*inner, *otherwise))
            case ForEach(_, condition, inner) | Let(_, condition, inner):
                yield condition
                yield from _of_effects(inner)


def _read(formulas: Iterable[f.Formula]) -> list[str]:
    """The predicates that formulas name, each once."""
    parts = (part for formula in formulas for part in walk(formula))
    return list(dict.fromkeys([part.predicate for part in parts if isinstance(part, f.Atom)]))


def _text_of(formula: f.Formula) -> str:
    """A formula as text, in which a membership reads ``is_a(x, lamp)``, without what says nothing."""
    return print_ltl(_simplified(formula))


def _simplified(formula: f.Formula) -> f.Formula:
    match formula:
        case f.Exists(f.Variable(name, category), f.Equals(left, right)) if category is not None:
            other = right if left.name == name else left
            return f.Atom("is_a", (other, f.Constant(category)))
        case f.And(parts) if f.TRUE in parts:
            return _simplified(f.And(tuple([part for part in parts if part != f.TRUE])))
        case f.And(parts) | f.Or(parts):
            return type(formula)(tuple(map(_simplified, parts)))
        case f.Not(f.Not(operand)):
            return _simplified(operand)
        case f.Not(operand):
            return f.Not(_simplified(operand))
        case f.Implies(left_part, right_part):
            return f.Implies(_simplified(left_part), _simplified(right_part))
        case f.Exists(_, body) | f.ForAll(_, body) | f.Exactly(_, _, body) | f.ForPairs(_, _, body):
            return replace(formula, body=_simplified(body))
        case _:
            return formula


class World(Protocol):
    """The effects of actions, as far as they can be shown."""

    def after(self, state: State, action: Action) -> State | None:
        """The state after an action; None where it is impossible."""

    def added(self, before: State, after: State) -> Sequence[Fact]:
        """The facts that hold in one state and not in another."""


@dataclass(frozen=True, slots=True)
class Edge:
    """An action and the state that it leads to, by their numbers."""

    action: int
    target: int


@dataclass(frozen=True)
class Repertoire:
    """Some actions, each of which may be taken as often as one likes, and everything they lead to.

    Attributes:
        actions: the actions.
        states: every state that can be reached, the start first, nearer ones before farther ones.
        edges: of every state what each action that is possible in it leads to.
        depths: of every state how many actions it takes to get there.
        gained: of every state what holds in it and not at the start.
    """

    actions: tuple[Action, ...]
    states: tuple[State, ...]
    edges: tuple[tuple[Edge, ...], ...]
    depths: tuple[int, ...]
    gained: tuple[tuple[Fact, ...], ...]

    @property
    def becoming_true(self) -> frozenset[Fact]:
        """All facts that do not hold at the start and do at some time."""
        return frozenset().union(*self.gained)

    def within(self, actions: Sequence[int]) -> Repertoire:
        """The states that some of the actions, by their numbers, lead to."""
        place = {number: n for n, number in enumerate(actions)}
        numbers, depths, edges = {0: 0}, [0], list[tuple[Edge, ...]]()
        for n, old in enumerate(kept := [0]):  # which grows on the way
            found = []
            for edge in self.edges[old]:
                if edge.action in place:
                    if edge.target not in numbers:
                        numbers[edge.target] = len(kept)
                        kept.append(edge.target)
                        depths.append(depths[n] + 1)
                    found.append(Edge(place[edge.action], numbers[edge.target]))
            edges.append(tuple(found))
        return Repertoire(
            tuple([self.actions[number] for number in actions]),
            tuple([self.states[n] for n in kept]),
            tuple(edges),
            tuple(depths),
            tuple([self.gained[n] for n in kept]),
        )

    def distance(self, is_goal: Callable[[int], bool], *, without: int | None = None) -> int | None:
        """How many actions lead from the start to a goal at least; None if none do.

        Args:
            is_goal: whether a state, by its number, is one.
            without: an action, by its number, that is not taken.
        """
        if without is None:
            return next((depth for n, depth in enumerate(self.depths) if is_goal(n)), None)
        level, seen, depth = [0], {0}, 0
        while level:
            if any(is_goal(n) for n in level):
                return depth
            further = [e.target for n in level for e in self.edges[n] if e.action != without]
            level = [n for n in dict.fromkeys(further) if n not in seen]
            seen.update(level)
            depth += 1
        return None

    def from_here(self, is_goal: Callable[[int], bool]) -> Mapping[int, int]:
        """How many actions lead from each state to a goal at least; of those from which none do, nothing."""
        sources: list[list[int]] = [[] for _ in self.states]
        for n, edges in enumerate(self.edges):
            for edge in edges:
                sources[edge.target].append(n)
        level = [n for n in range(len(self.states)) if is_goal(n)]
        found = dict.fromkeys(level, 0)
        depth = 0
        while level:
            depth += 1
            level = [n for n in dict.fromkeys([s for t in level for s in sources[t]]) if n not in found]
            found.update(dict.fromkeys(level, depth))
        return found


def exhaust(world: World, start: State, actions: Sequence[Action], most: int) -> Repertoire | None:
    """All that some actions lead to from a state; None if that is more states than ``most``."""
    numbers, states, depths = {start: 0}, [start], [0]
    edges: list[tuple[Edge, ...]] = []
    for n, state in enumerate(states):  # which grows on the way
        found = []
        for number, action in enumerate(actions):
            after = world.after(state, action)
            if after is None:
                continue
            target = numbers.setdefault(after, len(states))
            if target == len(states):
                if target == most:
                    return None
                states.append(after)
                depths.append(depths[n] + 1)
            found.append(Edge(number, target))
        edges.append(tuple(found))
    gained = [tuple(world.added(start, state)) for state in states]
    return Repertoire(tuple(actions), tuple(states), tuple(edges), tuple(depths), tuple(gained))
