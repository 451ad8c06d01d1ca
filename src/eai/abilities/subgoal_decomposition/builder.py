"""Subgoals made into programs for the search: the same for every domain.

Each subgoal is a formula with all that the language has. Every alternative of an ``or`` is tried; an
``exists`` ranges over the task's objects; the name of a class stands for any of the task's objects of that
class; a negation is pushed inwards; an action is carried out. What no action brings about must hold, in a
conjunction when the actions for its other parts are done.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

from typing_extensions import assert_never

import eai.logic.formula as f
from eai.abilities.subgoal_decomposition.lexicon import SubgoalLexicon
from eai.abilities.subgoal_decomposition.program import Do, End, Instruction, Program, Require, Split
from eai.abilities.subgoal_decomposition.progress import StateTest
from eai.abilities.subgoal_decomposition.rewriting import substitute
from eai.abilities.subgoal_decomposition.translation import Translation
from eai.abilities.task import Task
from eai.errors import InputError
from eai.logic.ltl_printer import print_ltl
from eai.logic.traversal import children, is_state_formula, walk
from eai.planning.subgoal import GroundAtom
from eai.world.fault import FaultKind
from eai.world.operator import Check
from eai.world.relation import bits

MAX_INSTRUCTIONS = 20_000
"""The longest program; alternatives multiply where names or variables stand for several objects."""

_BY_NOTHING = "no action brings it about"
_NOT_DONE = "a few actions do not bring it about"


def program_of(
    task: Task, lexicon: SubgoalLexicon, translation: Translation, subgoals: Sequence[f.Formula]
) -> Program:
    """The program that carries out subgoals one after the other.

    Raises:
        InputError: a subgoal is not a combination of states and actions that can be carried out one after
            the other, or there are too many alternatives.
    """
    builder = _Builder(task, lexicon, translation)
    parts = [_Part(number, builder.with_classes(subgoal)) for number, subgoal in enumerate(subgoals)]
    start = builder.sequence(parts, 0)
    return builder.program[: start + 1]


class _Part(NamedTuple):
    """A part of the subgoal of this number."""

    subgoal: int
    formula: f.Formula


class _Builder:
    """Makes instructions from the end of a plan to its beginning."""

    def __init__(self, task: Task, lexicon: SubgoalLexicon, translation: Translation) -> None:
        self.program: list[Instruction] = [End()]
        self._task = task
        self._lexicon = lexicon
        self._translation = translation

    def with_classes(self, subgoal: f.Formula) -> f.Formula:
        """A subgoal where the name of a class has become a variable for an object of it."""
        names = dict.fromkeys(
            term
            for part in walk(subgoal)
            if isinstance(part, (f.Atom, f.Occurs))
            for term in part.arguments
            if isinstance(term, f.Constant) and term.name not in self._lexicon.objects
        )
        if not names:
            return subgoal
        subgoal = substitute(subgoal, {name: f.Variable(name.name) for name in names})
        for name in reversed(names):
            subgoal = f.Exists(f.Variable(name.name, name.name), subgoal)
        return subgoal

    def sequence(self, subgoals: Sequence[_Part], then: int) -> int:
        """Put subgoals in front of instruction ``then``; returns the first instruction."""
        parts = [_Part(each.subgoal, part) for each in subgoals for part in self._parts(each.formula)]
        while parts:
            part = parts.pop()
            pair = self._done_together(parts[-1].formula, part.formula) if parts else None
            if pair is not None:
                part = parts.pop()
                then = self._do(pair, part.subgoal, then)
            else:
                then = self._part(part, then)
        return then

    def _parts(self, formula: f.Formula) -> list[f.Formula]:
        """A subgoal as parts to be carried out one after the other, with negations pushed inwards."""
        match formula:
            case f.Not(f.Not() | f.And() | f.Or() | f.Implies() as operand):
                return self._parts(_negated(operand))
            case f.Then(operands):
                return [part for operand in operands for part in self._parts(operand)]
            case f.And(operands):
                ordered = sorted(operands, key=self._only_holds)
                parts = [part for operand in ordered for part in self._parts(operand)]
                return self._joined(parts) if self._translation.whole and is_state_formula(formula) else parts
            case _:
                return [formula]

    def _joined(self, parts: Sequence[f.Formula]) -> list[f.Formula]:
        """The parts of a conjunction, all literals that are brought about as one of them."""
        together = [part for part in parts if isinstance(part, f.And) or self._is_brought_about(part)]
        literals = [
            each for part in together for each in (part.operands if isinstance(part, f.And) else (part,))
        ]
        others = [part for part in parts if part not in together]
        return [f.And(tuple(literals)), *others] if len(literals) > 1 else list(parts)

    def _part(self, part: _Part, then: int) -> int:
        match part.formula:
            case f.Or(operands):
                return self._any(operands, part.subgoal, then)
            case f.Implies(premise, conclusion):
                return self._any((f.Not(premise), conclusion), part.subgoal, then)
            case f.Exists(variable, body):
                return self._any(self._instances(variable, body), part.subgoal, then)
            case f.Occurs() as occurrence:
                plans = self._translation.plans_to_take(self._lexicon.action(occurrence), self._task)
                return self._add(Do(plans, part.subgoal, then))
            case f.And(operands):
                return self._do(self._literals(operands), part.subgoal, self._tested(part, then))
            case formula if self._is_brought_about(formula):
                return self._do(self._literals((formula,)), part.subgoal, self._tested(part, then))
            case _:
                return self._require(part, then)

    def _any(self, alternatives: Iterable[f.Formula], subgoal: int, then: int) -> int:
        entries = tuple([self.sequence([_Part(subgoal, each)], then) for each in alternatives])
        if len(entries) == 1:
            return entries[0]
        return self._add(Split(entries)) if entries else self._require(_Part(subgoal, f.FALSE), then)

    def _instances(self, variable: f.Variable, body: f.Formula) -> Iterable[f.Formula]:
        """The body for each of the task's objects of a class, or, if there are none, for all in the scene."""
        scene = self._task.scene
        mask = scene.category(variable.category)
        indices = [i for i in self._task.relevant if mask >> i & 1] or bits(mask)
        for index in indices:
            yield substitute(body, {f.Variable(variable.name): f.Constant(self._lexicon.name(index))})

    def _done_together(self, first: f.Formula, second: f.Formula) -> tuple[GroundAtom, GroundAtom] | None:
        """The literals of two parts, if they are brought about together."""
        one, other = self._lexicon.literal(first), self._lexicon.literal(second)
        if one is None or other is None or not self._translation.are_done_together(one, other):
            return None
        return one, other

    def _literals(self, formulas: Iterable[f.Formula]) -> list[GroundAtom]:
        return [literal for literal in map(self._lexicon.literal, formulas) if literal is not None]

    def _is_brought_about(self, formula: f.Formula) -> bool:
        """Whether a formula is a literal for which something is done."""
        literal = self._lexicon.literal(formula)
        return literal is not None and self._translation.brings_about(literal, self._task.scene)

    def _only_holds(self, formula: f.Formula) -> bool:
        """Whether no action brings about any part of a formula; of what is about variables, one may."""
        match formula:
            case f.Occurs():
                return False
            case f.Atom(_, arguments) | f.Not(f.Atom(_, arguments)):
                if any(isinstance(term, f.Variable) for term in arguments):
                    return False
                return not self._is_brought_about(formula)
            case (
                f.Not(f.And() | f.Or() | f.Implies() | f.Not())
                | f.And()
                | f.Or()
                | f.Then()
                | f.Implies()
                | f.Exists()
            ):
                return all(self._only_holds(part) for part in children(formula))
            case _:
                return True

    def _do(self, literals: Sequence[GroundAtom], subgoal: int, then: int) -> int:
        return self._add(Do(self._translation.plans(literals, self._task), subgoal, then))

    def _tested(self, part: _Part, then: int) -> int:
        """A test of what has been brought about, where that is asked for."""
        return self._require(part, then, _NOT_DONE) if self._translation.whole else then

    def _require(self, part: _Part, then: int, why: str = _BY_NOTHING) -> int:
        """A test, or nothing for a literal of which the domain knows nothing."""
        formula, lexicon = part.formula, self._lexicon
        is_literal = isinstance(formula.operand if isinstance(formula, f.Not) else formula, f.Atom)
        if is_literal and lexicon.is_unobserved(formula):
            return then
        text = print_ltl(formula)
        if (
            not is_state_formula(formula)
            or any(isinstance(each, f.Occurs) for each in walk(formula))
            or lexicon.is_unobserved(formula)
        ):
            raise InputError(f"{text}: there is no way to carry this out")
        meaning = lexicon.meaning(formula)
        reason, name = f"{text} does not hold, and {why}", why.replace(" ", "_")
        check = Check(meaning, FaultKind.MISSING_STEP, reason, id=name)
        return self._add(Require(StateTest(meaning, self._task.scene), check, part.subgoal, then))

    def _add(self, instruction: Instruction) -> int:
        if len(self.program) >= MAX_INSTRUCTIONS:
            raise InputError(f"more than {MAX_INSTRUCTIONS} alternatives and steps to carry out")
        self.program.append(instruction)
        return len(self.program) - 1


def _negated(formula: f.Not | f.And | f.Or | f.Implies) -> f.Formula:
    """The negation of a connective, as a formula with negations further in."""
    match formula:
        case f.Not(operand):
            return operand
        case f.And(parts):
            return f.Or(tuple(f.Not(part) for part in parts))
        case f.Or(parts):
            return f.And(tuple(f.Not(part) for part in parts))
        case f.Implies(premise, conclusion):
            return f.And((premise, f.Not(conclusion)))
        case _:
            assert_never(formula)
