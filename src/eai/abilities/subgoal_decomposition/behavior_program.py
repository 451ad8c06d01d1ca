"""Subgoals of BEHAVIOR as programs for the search.

In protocol `strict` every alternative of an ``or`` is tried, an action is carried out as it stands, and what
no action brings about must hold, in a conjunction when the actions for its other parts are done.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from eai.abilities.subgoal_decomposition.behavior_translation import (
    Plan,
    Translation,
    are_placed_together,
    is_brought_about,
)
from eai.abilities.subgoal_decomposition.behavior_vocabulary import UNOBSERVED, object_names
from eai.abilities.subgoal_decomposition.program import Do, End, Instruction, Program, Require, Split
from eai.abilities.subgoal_decomposition.progress import StateTest
from eai.benchmarks.behavior import predicates as p
from eai.errors import InputError
from eai.logic.formula import And, Atom, Constant, Formula, Implies, Not, Occurs, Or, Then
from eai.logic.ltl_printer import print_ltl
from eai.logic.traversal import children
from eai.world.derived import is_a
from eai.world.operator import missing
from eai.world.state import Scene, State

_IN_DOMAIN: Mapping[str, str] = {
    "toggledon": "toggled_on",
    "touching": "nextto",
    "inHandOfRobot": p.held.name,
}
"""What the domain calls the states that it has under another name."""

MAX_INSTRUCTIONS = 20_000
"""The longest program; alternatives multiply where they stand in sequences."""


def reference_program(translation: Translation, literals: Sequence[Formula]) -> Program:
    """The program of protocol `eai-1.0.5`: one literal, or two that are done together, after the other."""
    steps: list[tuple[int, Callable[[State], Sequence[Plan]]]] = []
    number = 0
    while number < len(literals):
        width = 2 if are_placed_together(*literals[number : number + 2]) else 1
        steps.append((number, _plans(translation, literals[number : number + width])))
        number += width
    program: list[Instruction] = [End()]
    for number, plans in reversed(steps):
        program.append(Do(plans, number, len(program) - 1))
    return program


def _plans(translation: Translation, literals: Sequence[Formula]) -> Callable[[State], Sequence[Plan]]:
    def plans(state: State) -> Sequence[Plan]:
        first, *rest = literals
        plan = translation.plan_together(first, rest[0], state) if rest else translation.plan(first, state)
        return () if plan is None else (plan,)

    return plans


def strict_program(scene: Scene, subgoals: Sequence[Formula]) -> Program:
    """The program of protocol `strict`.

    Raises:
        InputError: a subgoal is not a combination of states and actions by ``then``, ``and``, ``or`` and
            ``not``, or there are too many alternatives.
    """
    builder = _Builder(scene)
    start = builder.sequence([(number, subgoal) for number, subgoal in enumerate(subgoals)], 0)
    return builder.program[: start + 1]


class _Builder:
    """Makes instructions from the end of a plan to its beginning."""

    def __init__(self, scene: Scene) -> None:
        self.program: list[Instruction] = [End()]
        self._scene = scene
        self._objects = object_names(scene)
        self._categories = dict.fromkeys(thing.category for thing in scene.objects)
        self._translation = Translation(scene, self._objects, by_substring=False)

    def sequence(self, subgoals: Sequence[tuple[int, Formula]], then: int) -> int:
        """Put subgoals, each with its number, in front of instruction ``then``; returns the first."""
        parts = [(number, part) for number, subgoal in subgoals for part in _parts(subgoal)]
        while parts:
            pair = tuple(part for _, part in parts[-2:])
            if are_placed_together(*pair):
                number, _ = parts[-2]
                then = self._append(Do(_plans(self._translation, pair), number, then))
                del parts[-2:]
            else:
                then = self._part(*parts.pop(), then)
        return then

    def _part(self, number: int, part: Formula, then: int) -> int:
        match part:
            case Or(operands):
                targets = tuple([self.sequence([(number, operand)], then) for operand in operands])
                return self._append(Split(targets))
            case Occurs():
                action = self._translation.action(part)
                return self._append(Do(lambda _: ((action,),), number, then))
            case Atom() | Not(Atom()):
                return self._literal(number, part, then)
            case _:
                raise InputError(f"{print_ltl(part)} cannot be carried out")

    def _literal(self, number: int, literal: Formula, then: int) -> int:
        if is_brought_about(literal):
            return self._append(Do(_plans(self._translation, (literal,)), number, then))
        condition = self._condition(literal)
        if condition is None:
            return then
        check = missing(condition, f"{print_ltl(literal)} does not hold, and no action brings it about")
        return self._append(Require(StateTest(condition, self._scene), check, number, then))

    def _condition(self, literal: Formula) -> Formula | None:
        """A literal as the domain says it; None where the domain knows nothing of it."""
        if isinstance(literal, Not):
            inner = self._condition(literal.operand)
            return None if inner is None else Not(inner)
        if not isinstance(literal, Atom) or literal.predicate in UNOBSERVED:
            return None
        things = tuple(
            Constant(self._scene.objects[self._objects[term.name]].name) for term in literal.arguments
        )
        name = _IN_DOMAIN.get(literal.predicate, literal.predicate)
        if self._scene.vocabulary.arity(name) is not None:
            return Atom(name, things)
        category = next(c for c in self._categories if c.replace(".", "_") == name)
        return is_a(things[0], category)

    def _append(self, instruction: Instruction) -> int:
        if len(self.program) >= MAX_INSTRUCTIONS:
            raise InputError("the subgoals leave too many alternatives")
        self.program.append(instruction)
        return len(self.program) - 1


def _parts(subgoal: Formula) -> list[Formula]:
    """A subgoal as parts to be carried out one after the other, with negations at states."""
    match subgoal:
        case And(operands):
            return [part for operand in sorted(operands, key=_only_holds) for part in _parts(operand)]
        case Then(operands):
            return [part for operand in operands for part in _parts(operand)]
        case Implies(premise, conclusion):
            return [Or((Not(premise), conclusion))]
        case Not(Not(operand)):
            return _parts(operand)
        case Not(And(operands)):
            return [Or(tuple(Not(operand) for operand in operands))]
        case Not(Or(operands)):
            return _parts(And(tuple(Not(operand) for operand in operands)))
        case Not(Implies(premise, conclusion)):
            return _parts(And((premise, Not(conclusion))))
        case _:
            return [subgoal]


def _only_holds(formula: Formula) -> bool:
    """Whether no action brings about any part of a formula."""
    match formula:
        case Occurs():
            return False
        case Atom() | Not(Atom()):
            return not is_brought_about(formula)
        case _:
            return all(_only_holds(part) for part in children(formula))
