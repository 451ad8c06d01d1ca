"""Subgoals of VirtualHome as programs for the search.

In protocol `strict` each subgoal is a formula with all that the language has: every alternative of an ``or``
is tried; an ``exists`` ranges over the task's objects; a class name without an id stands for any of the
task's objects of that class; what no action brings about must hold, in a conjunction when the actions for its
other parts are done.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import partial
from itertools import product

from typing_extensions import assert_never

from eai.abilities.subgoal_decomposition.program import (
    Do,
    End,
    Halt,
    Instruction,
    Plan,
    Program,
    Require,
    Split,
)
from eai.abilities.subgoal_decomposition.progress import StateTest
from eai.abilities.subgoal_decomposition.rewriting import substitute
from eai.abilities.subgoal_decomposition.virtualhome_translation import Translation
from eai.abilities.task import Task
from eai.errors import InputError
from eai.logic.formula import (
    FALSE,
    And,
    Atom,
    Constant,
    Exists,
    Formula,
    Implies,
    Not,
    Occurs,
    Or,
    Then,
    Variable,
)
from eai.logic.ltl_printer import print_ltl
from eai.logic.traversal import children, is_state_formula, walk
from eai.world.operator import missing
from eai.world.state import State

MAX_INSTRUCTIONS = 20_000
"""The longest program; alternatives multiply where names or variables stand for several objects."""

OPPOSITES = {
    "OPEN": "CLOSED",
    "CLOSED": "OPEN",
    "ON": "OFF",
    "OFF": "ON",
    "PLUGGED_IN": "PLUGGED_OUT",
    "PLUGGED_OUT": "PLUGGED_IN",
    "DIRTY": "CLEAN",
}
"""What an object is if it is not in a state: a negated subgoal asks for that."""


def reference_program(task: Task, literals: Sequence[Formula]) -> Program:
    """The program of protocol `eai-1.0.5`: one literal after the other, nothing verified."""
    translation = Translation(task.scene, either_way=False)
    program: list[Instruction] = [End()]
    for number in reversed(range(len(literals))):
        program.append(_literal(task, translation, literals[number], number, len(program) - 1))
    return program


def _literal(task: Task, translation: Translation, literal: Formula, number: int, then: int) -> Instruction:
    if not isinstance(literal, (Atom, Occurs)):
        return Halt("a negation cannot be translated")
    arguments = _indices(task, literal)
    if arguments is None:
        return Halt(f"{print_ltl(literal)}: an object without an id cannot be translated")
    return Do(_plans(translation, literal, arguments), number, then)


def _indices(task: Task, literal: Atom | Occurs) -> tuple[int, ...] | None:
    """The objects of a ground literal, or None if a name is not that of one object."""
    index = task.scene.index
    try:
        return tuple([index[term.name] for term in literal.arguments])
    except KeyError:
        return None


def _plans(
    translation: Translation, literal: Atom | Occurs, arguments: tuple[int, ...]
) -> Callable[[State], Sequence[Plan]]:
    if isinstance(literal, Atom):
        return partial(translation.of_state, literal.predicate, arguments)
    return partial(translation.of_action, literal.action, arguments)


def strict_program(task: Task, subgoals: Sequence[Formula]) -> Program:
    """The program of protocol `strict`.

    Raises:
        InputError: a subgoal is not a combination of states and actions that can be carried out one after
            the other, or there are too many alternatives.
    """
    builder = _Builder(task)
    then = 0
    for number in reversed(range(len(subgoals))):
        then = builder.subgoal(subgoals[number], number, then)
    return builder.program[: then + 1]


class _Builder:
    """Makes instructions from the end of a plan to its beginning."""

    def __init__(self, task: Task) -> None:
        self.program: list[Instruction] = [End()]
        self._task = task
        self._translation = Translation(task.scene)

    def subgoal(self, formula: Formula, number: int, then: int) -> int:
        """Put a subgoal in front of instruction ``then``; returns its first instruction."""
        names = dict.fromkeys(
            term
            for part in walk(formula)
            if isinstance(part, (Atom, Occurs))
            for term in part.arguments
            if isinstance(term, Constant) and term.name not in self._task.scene.index
        )
        choices = product(*(self._objects(name.name) for name in names))
        variants = (substitute(formula, dict(zip(names, choice, strict=True))) for choice in choices)
        return self._any(variants, number, then)

    def _objects(self, category: str | None) -> list[Constant]:
        """The task's objects of a class, or, if there are none, all in the scene."""
        scene = self._task.scene
        relevant = [i for i in self._task.relevant if scene.category(category) >> i & 1]
        names = [scene.objects[i].name for i in relevant] or scene.names(scene.category(category))
        return [Constant(name) for name in names]

    def _any(self, alternatives: Iterable[Formula], number: int, then: int) -> int:
        entries = tuple([self._formula(alternative, number, then) for alternative in alternatives])
        if len(entries) == 1:
            return entries[0]
        return self._add(Split(entries) if entries else self._require(FALSE, number, then))

    def _formula(self, formula: Formula, number: int, then: int) -> int:
        match formula:
            case Then(parts):
                return self._all(parts, number, then)
            case And(parts):
                return self._all(sorted(parts, key=self._only_holds), number, then)
            case Or(parts):
                return self._any(parts, number, then)
            case Implies(premise, conclusion):
                return self._any((Not(premise), conclusion), number, then)
            case Exists(variable, body):
                values = self._objects(variable.category)
                instances = (substitute(body, {Variable(variable.name): value}) for value in values)
                return self._any(instances, number, then)
            case Not(Not() | And() | Or() | Implies() as operand):
                return self._formula(_negated(operand), number, then)
            case Not(Atom() as atom) if not self._only_holds(formula):
                return self._add(Do(self._plans_against(atom), number, then))
            case Atom() | Occurs() if not self._only_holds(formula):
                return self._add(Do(self._plans_for(formula), number, then))
            case _:
                return self._add(self._require(formula, number, then))

    def _all(self, parts: Sequence[Formula], number: int, then: int) -> int:
        for part in reversed(parts):
            then = self._formula(part, number, then)
        return then

    def _only_holds(self, formula: Formula) -> bool:
        """Whether no action brings about any part of a formula."""
        match formula:
            case Occurs():
                return False
            case Not(Atom(predicate)):
                return predicate not in OPPOSITES
            case Atom(predicate):
                indices = _indices(self._task, formula)
                if indices is None:
                    return False
                return not self._translation.of_state(predicate, indices, self._task.initial)
            case And() | Or() | Then() | Implies() | Exists():
                return all(self._only_holds(part) for part in children(formula))
            case _:
                return True

    def _plans_for(self, literal: Atom | Occurs) -> Callable[[State], Sequence[Plan]]:
        return _plans(self._translation, literal, _indices(self._task, literal) or ())

    def _plans_against(self, atom: Atom) -> Callable[[State], Sequence[Plan]]:
        """The plans that make an atom false; none where it is false already."""
        plans = self._plans_for(Atom(OPPOSITES[atom.predicate], atom.arguments))
        holds = StateTest(atom, self._task.scene)
        return lambda state: plans(state) if holds(state) else ()

    def _require(self, formula: Formula, number: int, then: int) -> Require:
        text = print_ltl(formula)
        if not is_state_formula(formula) or any(isinstance(part, Occurs) for part in walk(formula)):
            raise InputError(f"{text}: there is no way to carry this out")
        check = missing(formula, f"{text} does not hold, and no action brings it about")
        return Require(StateTest(formula, self._task.scene), check, number, then)

    def _add(self, instruction: Instruction) -> int:
        if len(self.program) >= MAX_INSTRUCTIONS:
            raise InputError(f"more than {MAX_INSTRUCTIONS} alternatives and steps to carry out")
        self.program.append(instruction)
        return len(self.program) - 1


def _negated(formula: Not | And | Or | Implies) -> Formula:
    """The negation of a connective, as a formula with negations further in."""
    match formula:
        case Not(operand):
            return operand
        case And(parts):
            return Or(tuple(Not(part) for part in parts))
        case Or(parts):
            return And(tuple(Not(part) for part in parts))
        case Implies(premise, conclusion):
            return And((premise, Not(conclusion)))
        case _:
            assert_never(formula)
