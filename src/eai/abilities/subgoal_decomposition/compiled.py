"""Answers made ready for the search, or what keeps them from it: the same for every domain."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from eai.abilities.subgoal_decomposition.notation import WrittenSubgoals
from eai.abilities.subgoal_decomposition.program import Program
from eai.abilities.unreadable import Unreadable
from eai.abilities.verdict import ErrorReport, SubgoalCategory
from eai.errors import InputError, ParseError
from eai.logic.formula import Formula
from eai.logic.ltl import parse
from eai.logic.signature import Misuse, MisuseKind, Signature
from eai.world.fault import FaultKind


@dataclass(frozen=True, slots=True)
class Compiled:
    """An answer that can be carried out: its subgoals, also as a program, and the repairs made."""

    subgoals: tuple[Formula, ...]
    program: Program
    repairs: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Rejected:
    """An answer that cannot be carried out: its category, why, and what is wrong with its names."""

    category: SubgoalCategory
    error: ErrorReport
    repairs: tuple[str, ...] = ()
    offences: tuple[Misuse, ...] = ()


def unparseable(reason: str, repairs: tuple[str, ...] = ()) -> Rejected:
    """The rejection of what no plan can be made of."""
    return Rejected(SubgoalCategory.NOT_PARSEABLE, ErrorReport(FaultKind.PARSING, None, reason), repairs)


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
    formulas: list[Formula] = []
    offences: list[Misuse] = []
    for number, subgoal in enumerate(written.subgoals):
        try:
            reading = parse(subgoal, signature)
        except ParseError as error:
            return unparseable(f"subgoal {number + 1}: {error}", written.repairs)
        formulas.append(reading.formula)
        offences += reading.offences
    if offences:
        return offending(offences, written.repairs)
    try:
        return Compiled(tuple(formulas), program(formulas), written.repairs)
    except InputError as error:
        return unparseable(str(error), written.repairs)


_PRECEDENCE = (MisuseKind.UNKNOWN_PREDICATE, MisuseKind.WRONG_ARITY, MisuseKind.UNKNOWN_OBJECT)


def offending(offences: Sequence[Misuse], repairs: tuple[str, ...]) -> Rejected:
    """The rejection for names that are not allowed: unknown predicates first, then numbers of objects."""
    worst = min(offences, key=lambda offence: _PRECEDENCE.index(offence.kind))
    wrong_number = worst.kind is MisuseKind.WRONG_ARITY
    kind = FaultKind.ARGUMENT_NUMBER if wrong_number else FaultKind.HALLUCINATION
    error = ErrorReport(kind, None, worst.detail)
    return Rejected(SubgoalCategory.HALLUCINATION, error, repairs, tuple(offences))
