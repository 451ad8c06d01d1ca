"""Answers made ready for the search, or what keeps them from it: the same for every domain."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from eai.abilities.subgoal_decomposition.declaration import SubgoalCategory
from eai.abilities.subgoal_decomposition.notation import WrittenSubgoals
from eai.abilities.subgoal_decomposition.program import Program
from eai.abilities.verdict import ErrorReport, Unreadable
from eai.errors import InputError, ParseError
from eai.logic.formula import Formula
from eai.logic.ltl import parse
from eai.logic.signature import Misuse, MisuseKind, Signature
from eai.world.fault import FaultKind


@dataclass(frozen=True, slots=True)
class Compiled:
    """An answer that can be carried out: its subgoals, their program, what reading repaired and left out."""

    subgoals: tuple[Formula, ...]
    program: Program
    repairs: tuple[str, ...] = ()
    left_out: tuple[str, ...] = ()


class Offence(NamedTuple):
    """A name that is not allowed, and the number of the subgoal that it stands in, from 0."""

    subgoal: int
    misuse: Misuse

    def __str__(self) -> str:
        return f"subgoal {self.subgoal + 1}, {self.misuse.primitive}: {self.misuse.detail}"


@dataclass(frozen=True, slots=True)
class Rejected:
    """An answer that cannot be carried out: why, what is wrong with its names, what reading left out."""

    category: SubgoalCategory
    error: ErrorReport
    repairs: tuple[str, ...] = ()
    offences: tuple[Offence, ...] = ()
    left_out: tuple[str, ...] = ()


def unparseable(reason: str, repairs: tuple[str, ...] = (), subgoal: int | None = None) -> Rejected:
    """The rejection of what no plan can be made of, for the sake of this subgoal if it is one."""
    error = ErrorReport(FaultKind.PARSING, subgoal, reason)
    return Rejected(SubgoalCategory.NOT_PARSEABLE, error, repairs)


def compile_each(
    written: WrittenSubgoals | Unreadable,
    signature: Signature,
    program: Callable[[Sequence[Formula]], Program],
) -> Compiled | Rejected:
    """An answer whose subgoals are each a text of its own, each read by itself.

    ``program`` makes a program of them, or raises an `InputError` that says why there is none.
    """
    if isinstance(written, Unreadable):
        return unparseable(written.reason)
    compiled = _compile(written, signature, program)
    return replace(compiled, left_out=written.left_out)


def _compile(
    written: WrittenSubgoals, signature: Signature, program: Callable[[Sequence[Formula]], Program]
) -> Compiled | Rejected:
    formulas: list[Formula] = []
    offences: list[Offence] = []
    for number, subgoal in enumerate(written.subgoals):
        try:
            reading = parse(subgoal, signature)
        except ParseError as error:
            return unparseable(str(error), written.repairs, number)
        formulas.append(reading.formula)
        offences += [Offence(number, misuse) for misuse in reading.offences]
    if offences:
        return offending(offences, written.repairs)
    try:
        return Compiled(tuple(formulas), program(formulas), written.repairs)
    except InputError as error:
        return unparseable(str(error), written.repairs)


_PRECEDENCE = (MisuseKind.UNKNOWN_PREDICATE, MisuseKind.WRONG_ARITY, MisuseKind.UNKNOWN_OBJECT)


def offending(offences: Sequence[Offence], repairs: tuple[str, ...]) -> Rejected:
    """The rejection for names that are not allowed: unknown predicates first, then numbers of objects."""
    subgoal, worst = min(offences, key=lambda offence: _PRECEDENCE.index(offence.misuse.kind))
    wrong_number = worst.kind is MisuseKind.WRONG_ARITY
    kind = FaultKind.ARGUMENT_NUMBER if wrong_number else FaultKind.HALLUCINATION
    objects = (worst.name,) if worst.kind is MisuseKind.UNKNOWN_OBJECT else ()
    error = ErrorReport(kind, subgoal, worst.detail, worst.kind.value, objects)
    return Rejected(SubgoalCategory.HALLUCINATION, error, repairs, tuple(offences))
