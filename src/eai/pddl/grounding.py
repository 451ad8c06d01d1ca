"""Grounding: operators with objects put in, conditions and effects as bit masks over numbered atoms.

What no effect can change is decided while grounding: what is true of predicates that are never deleted, and
what is false of those that are never added. A state is an integer whose bit i says whether atom i is true.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import eai.logic.formula as f
import eai.pddl.model as m
from eai.logic.traversal import free_variables, objects
from eai.pddl.evaluation import DerivedPredicates
from eai.pddl.execute import PlanStep
from eai.planning.search import Effort


class GroundCondition(NamedTuple):
    """A ground condition: atoms that must be true, atoms that must be false, and one of each of the choices.

    ``true`` and ``false`` are bit masks.
    """

    true: int
    false: int
    choices: tuple[tuple[GroundCondition, ...], ...]


class GroundChange(NamedTuple):
    """A ground conditional effect; ``add`` and ``delete`` are bit masks."""

    condition: GroundCondition
    add: int
    delete: int


@dataclass(frozen=True, slots=True)
class GroundAction:
    """An operator with its objects."""

    step: PlanStep
    precondition: GroundCondition
    changes: tuple[GroundChange, ...]


ALWAYS = GroundCondition(0, 0, ())

_Key = tuple[str, ...]
_Binding = Mapping[str, str]


class Grounder:
    """Grounds one domain and problem; atoms are numbered in the order in which they are met.

    Args:
        domain: the operators.
        problem: the objects, the initial state and the goal.
        looks: how many objects parameters and quantifiers may be bound to; any number by default. Where
            they are used up, what is ground lacks some parts.
    """

    def __init__(self, domain: m.PddlDomain, problem: m.PddlProblem, looks: Effort | None = None) -> None:
        self._looks = looks or Effort()
        self._domain = domain
        self._problem = problem
        self._objects = m.objects_by_type(domain, problem)
        self._facts = {_key(atom, {}) for atom in problem.initial}
        effects = [part for action in domain.actions for part in m.elementary_effects(action.effect)]
        self._added = {part.atom.predicate for part in effects if isinstance(part, m.AddEffect)}
        self._deleted = {part.atom.predicate for part in effects if isinstance(part, m.DeleteEffect)}
        self._axioms = DerivedPredicates(domain.axioms).axioms
        self._numbers: dict[_Key, int] = {}
        self._ground: dict[tuple[object, ...], GroundAction | None] = {}

    @property
    def initial(self) -> int:
        """The initial state over the atoms met so far: to be asked for when grounding is done."""
        return sum(1 << number for key, number in self._numbers.items() if key in self._facts)

    @property
    def atoms(self) -> int:
        """How many atoms have been met so far."""
        return len(self._numbers)

    @property
    def objects(self) -> frozenset[str]:
        """All objects."""
        return frozenset(self._objects["object"])

    def goal(self) -> GroundCondition | None:
        """The goal, or None if it is false in every state."""
        return self._condition(self._problem.goal, {}, negated=False)

    def actions(self, allowed: frozenset[str] | None = None) -> Iterator[GroundAction]:
        """All ground actions that some state may admit and that change something.

        Args:
            allowed: the objects that parameters may take; None for all. Quantifiers always range over all.
        """
        for number, action in enumerate(self._domain.actions):
            for binding in self._bindings(action, allowed):
                key = (number, *binding.values())
                if key not in self._ground:
                    self._ground[key] = self._action(action, binding)
                ground = self._ground[key]
                if ground is not None:
                    yield ground

    def central_objects(self) -> frozenset[str]:
        """The objects that the goal names, and those of the types that operators ask for by name."""
        named = {*objects(self._problem.goal)}
        asked = {m.type_of(parameter) for action in self._domain.actions for parameter in action.parameters}
        for members in (self._objects.get(name, ()) for name in asked):
            if self.objects != set(members):
                named.update(members)
        return frozenset(named)

    def _bindings(self, action: m.PddlAction, allowed: frozenset[str] | None) -> Iterator[dict[str, str]]:
        """The bindings that satisfy the atoms of the precondition's top level that nothing adds.

        A parameter that nothing is said of takes one object only: any is as good.
        """
        tests = _tests_by_variable(action, self._never_added(action.precondition))
        mentioned = _mentioned(action)
        stack: list[dict[str, str]] = [{}]
        for parameter in action.parameters:
            members = self._objects.get(m.type_of(parameter), ())
            candidates = [name for name in members if allowed is None or name in allowed]
            stack = [
                extended
                for binding in stack
                for name in self._looks.at(candidates if parameter.name in mentioned else candidates[:1])
                if self._passes(tests[parameter.name], extended := {**binding, parameter.name: name})
            ]
        return iter(stack)

    def _never_added(self, precondition: f.Formula) -> list[f.Atom]:
        conjuncts = precondition.operands if isinstance(precondition, f.And) else (precondition,)
        may_become_true = self._added.union(self._axioms)
        return [
            part for part in conjuncts if isinstance(part, f.Atom) and part.predicate not in may_become_true
        ]

    def _passes(self, tests: Sequence[f.Atom], binding: _Binding) -> bool:
        return all(_key(atom, binding) in self._facts for atom in tests)

    def _action(self, action: m.PddlAction, binding: _Binding) -> GroundAction | None:
        precondition = self._condition(action.precondition, binding, negated=False)
        if precondition is None:
            return None
        found: list[GroundChange] = []
        self._add_changes(action.effect, binding, ALWAYS, found)
        add = delete = 0
        conditional = []
        for change in found:
            if change.condition is ALWAYS:
                add |= change.add
                delete |= change.delete
            elif change.add or change.delete:
                conditional.append(change)
        changes = [GroundChange(ALWAYS, add, delete)] if add or delete else []
        changes += conditional
        arguments = tuple(binding[parameter.name] for parameter in action.parameters)
        return (
            GroundAction(PlanStep(action.name, arguments), precondition, tuple(changes)) if changes else None
        )

    def _add_changes(
        self, effect: m.PddlEffect, binding: _Binding, condition: GroundCondition, found: list[GroundChange]
    ) -> None:
        """Add the changes that an effect makes under a condition to those that were found."""
        match effect:
            case m.AddEffect(atom):
                found.append(GroundChange(condition, self._bit(_key(atom, binding)), 0))
            case m.DeleteEffect(atom):
                found.append(GroundChange(condition, 0, self._bit(_key(atom, binding))))
            case m.Both(parts):
                for part in parts:
                    self._add_changes(part, binding, condition, found)
            case m.Each(variable, part):
                for inner in self._extensions(variable, binding):
                    self._add_changes(part, inner, condition, found)
            case m.WhenEffect(premise, part):
                combined = _all_of((condition, self._condition(premise, binding, negated=False)))
                if combined is not None:
                    self._add_changes(part, binding, combined, found)

    def _condition(self, formula: f.Formula, binding: _Binding, *, negated: bool) -> GroundCondition | None:
        """The ground condition, or None if it is false in every state."""
        match formula:
            case f.Atom():
                return self._literal(formula, binding, negated=negated)
            case f.Equals(left, right):
                return ALWAYS if (_name(left, binding) == _name(right, binding)) != negated else None
            case f.Not(operand):
                return self._condition(operand, binding, negated=not negated)
            case f.And(operands) | f.Or(operands):
                parts = (self._condition(operand, binding, negated=negated) for operand in operands)
                return _all_of(parts) if isinstance(formula, f.And) != negated else _one_of(parts)
            case f.Implies(premise, conclusion):
                return self._condition(f.Or((f.Not(premise), conclusion)), binding, negated=negated)
            case f.ForAll(variable, body) | f.Exists(variable, body):
                inners = self._extensions(variable, binding)
                parts = (self._condition(body, inner, negated=negated) for inner in inners)
                return _all_of(parts) if isinstance(formula, f.ForAll) != negated else _one_of(parts)
            case _:
                raise ValueError(f"{type(formula).__name__} has no PDDL form")

    def _literal(self, atom: f.Atom, binding: _Binding, *, negated: bool) -> GroundCondition | None:
        if atom.predicate in self._axioms:
            return self._derived(atom, binding, negated=negated)
        key = _key(atom, binding)
        bit = self._bit(key)
        if not bit:
            return ALWAYS if (key in self._facts) != negated else None
        return GroundCondition(0, bit, ()) if negated else GroundCondition(bit, 0, ())

    def _derived(self, atom: f.Atom, binding: _Binding, *, negated: bool) -> GroundCondition | None:
        """The condition of a derived predicate; one that depends on itself has none."""
        names = [_name(term, binding) for term in atom.arguments]
        parts = (
            self._condition(
                axiom.condition,
                {parameter.name: name for parameter, name in zip(axiom.parameters, names, strict=True)},
                negated=negated,
            )
            for axiom in self._axioms[atom.predicate]
        )
        return _all_of(parts) if negated else _one_of(parts)

    def _bit(self, key: _Key) -> int:
        """The bit of an atom; none if it stays what it is."""
        if key[0] not in (self._deleted if key in self._facts else self._added):
            return 0
        return 1 << self._numbers.setdefault(key, len(self._numbers))

    def _extensions(self, variable: f.Variable, binding: _Binding) -> Iterator[_Binding]:
        """A binding for each object of a variable: the same one, so that each is used before the next."""
        inner, slot = {**binding}, variable.name
        for inner[slot] in self._looks.at(self._objects.get(m.type_of(variable), ())):
            yield inner


def _all_of(parts: Iterable[GroundCondition | None]) -> GroundCondition | None:
    true = false = 0
    choices: list[tuple[GroundCondition, ...]] = []
    for part in parts:
        if part is None:
            return None
        true |= part.true
        false |= part.false
        choices += part.choices
    if true & false:
        return None
    return GroundCondition(true, false, tuple(choices)) if true or false or choices else ALWAYS


def _one_of(parts: Iterable[GroundCondition | None]) -> GroundCondition | None:
    options: list[GroundCondition] = []
    for part in parts:
        if part is ALWAYS:
            return ALWAYS
        if part is not None:
            options.append(part)
    if len(options) < 2:
        return options[0] if options else None
    return GroundCondition(0, 0, (tuple(options),))


def _tests_by_variable(action: m.PddlAction, atoms: Sequence[f.Atom]) -> dict[str, list[f.Atom]]:
    """For each parameter the atoms whose variables are all bound once it is, in order of the parameters."""
    tests: dict[str, list[f.Atom]] = {parameter.name: [] for parameter in action.parameters}
    order = list(tests)
    for atom in atoms:
        places = [order.index(term.name) for term in atom.arguments if isinstance(term, f.Variable)]
        if places:
            tests[order[max(places)]].append(atom)
    return tests


def _mentioned(action: m.PddlAction) -> set[str]:
    """The names of all that an operator's conditions and effects are about."""
    names = {term.name for atom in m.effect_atoms(action.effect) for term in atom.arguments}
    conditions = (action.precondition, *m.effect_conditions(action.effect))
    return names.union(*map(free_variables, conditions))


def _key(atom: f.Atom, binding: _Binding) -> _Key:
    names = [binding[t.name] if isinstance(t, f.Variable) else t.name for t in atom.arguments]
    return (atom.predicate, *names)


def _name(term: f.Term, binding: _Binding) -> str:
    return binding[term.name] if isinstance(term, f.Variable) else term.name
