"""Plain formulas read without a parser's tables: what nearly all goals and answers are.

Plain is a formula of primitives, ``and``, ``or``, ``then``, ``not``, ``exists``, ``forall`` and brackets,
with blanks around its words. Every dialect reads it alike. Any other text is left to the grammar files, which
also say what is wrong with it; on plain ones they take several times as long, and building their parsers
longer still.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import TypeAlias

from eai.logic.formula import And, Exists, ForAll, Formula, Not, Or, Then, Variable

MAX_BRACKETS = 18
"""How deep brackets may be nested: at five levels each, less than `traversal.MAX_DEPTH` levels."""

_BLANK = r"[ \t\f\r\n]"
_NAME = r"[a-zA-Z_\-]\w*"
_ARGUMENT = rf"{_NAME}(?:\.[0-9]+)?{_BLANK}*"
_PRIMITIVE = rf"(?!not){_NAME}{_BLANK}*\({_BLANK}*(?:{_ARGUMENT}(?:,{_BLANK}*{_ARGUMENT})*)?\)"
_BINDER = rf"(?P<quantifier>exists|forall){_BLANK}+(?P<variable>{_NAME}){_BLANK}*\.{_BLANK}*\("
_NEGATION = rf"(?P<negation>not{_BLANK}+)"
_OPERAND = re.compile(rf"{_BLANK}*{_NEGATION}?(?:(?P<primitive>{_PRIMITIVE})|{_BINDER}|\()")
_JOINT = re.compile(rf"{_BLANK}*(and|or|then|\)|\Z)")

_QUANTIFIERS: dict[str, type[Exists] | type[ForAll]] = {"exists": Exists, "forall": ForAll}

Primitive: TypeAlias = Callable[[str, int, frozenset[str]], Formula]
"""Makes a formula of a primitive's text, its place in the whole, and the names that are variables there."""


def read_plain(text: str, primitive: Primitive) -> Formula | None:
    """The formula of a text, or None if the text is not plain."""
    try:
        return _PlainReader(text, primitive).whole()
    except _NotPlainError:
        return None


class _NotPlainError(Exception):
    """The text is to be read by its grammar."""


class _PlainReader:
    """Reads one text from left to right; ``_joint`` is what stands behind the last operand."""

    __slots__ = ("_joint", "_position", "_primitive", "_text")

    def __init__(self, text: str, primitive: Primitive) -> None:
        self._text = text
        self._primitive = primitive
        self._position = 0
        self._joint = ""

    def whole(self) -> Formula:
        formula = self._sequence(frozenset(), MAX_BRACKETS)
        if self._joint:
            raise _NotPlainError
        return formula

    def _sequence(self, scope: frozenset[str], brackets: int) -> Formula:
        sequence: list[Formula] = []
        disjunction: list[Formula] = []
        conjunction: list[Formula] = []
        while True:
            conjunction.append(self._operand(scope, brackets))
            if self._joint == "and":
                continue
            disjunction.append(_joined(And, conjunction))
            conjunction = []
            if self._joint == "or":
                continue
            sequence.append(_joined(Or, disjunction))
            disjunction = []
            if self._joint != "then":
                return _joined(Then, sequence)

    def _operand(self, scope: frozenset[str], brackets: int) -> Formula:
        found = _OPERAND.match(self._text, self._position)
        if found is None:
            raise _NotPlainError
        self._position = found.end()
        formula = self._positive(found, scope, brackets)
        if found["negation"] is not None:
            formula = Not(formula)
        joint = _JOINT.match(self._text, self._position)
        if joint is None:
            raise _NotPlainError
        self._joint = joint[1]
        self._position = joint.end()
        return formula

    def _positive(self, found: re.Match[str], scope: frozenset[str], brackets: int) -> Formula:
        """The formula behind a negation, or without one."""
        if found["primitive"] is not None:
            return self._primitive(found["primitive"], found.start("primitive"), scope)
        name = found["variable"]
        if name is None:
            return self._bracketed(scope, brackets)
        body = self._bracketed(scope | {name}, brackets)
        return _QUANTIFIERS[found["quantifier"]](Variable(name), body)

    def _bracketed(self, scope: frozenset[str], brackets: int) -> Formula:
        if brackets == 0:
            raise _NotPlainError
        formula = self._sequence(scope, brackets - 1)
        if self._joint != ")":
            raise _NotPlainError
        return formula


def _joined(connective: type[And] | type[Or] | type[Then], parts: list[Formula]) -> Formula:
    return connective(tuple(parts)) if len(parts) > 1 else parts[0]
