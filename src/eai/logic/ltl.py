"""Formulas as text, in the syntax of the paper's goals and subgoals.

Precedence, loosest first: then, implies, or, and, until, and the prefixes not, next, eventually, always.
Blanks may stand between any two words and are needed nowhere: ``p(x)thenq(y)`` is a formula. No word is
reserved: ``not(x)`` and ``forall(x)`` are primitives, because ``x`` alone is no formula. ``not(true)`` is a
negation, because ``true`` is one.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Final, Literal, TypeAlias

import eai.logic.formula as f
from eai.base.errors import ParseError
from eai.logic.signature import (
    Misuse,
    MisuseKind,
    Signature,
    describe_arity,
    error_at,
    join_with_or,
    line_and_column,
    to_term,
)
from eai.logic.traversal import MAX_COUNT_DIGITS, MAX_DEPTH

MAX_PARSED_PRIMITIVES = 1_000
"""How many primitives are remembered with a signature."""


Dialect: TypeAlias = Literal["release", "ltlf"]
"""Which formulas are accepted.

``release``: the paper's formulas, all that the parser of eai-eval 1.0.5 accepts, text for text
(``tl_formula/simple_tl_parser.py``); a name that begins with ``not`` is a negation there (``notopen(x)``).
``ltlf``: the paper's formulas in both spellings of ``forn``, and beyond them all of linear temporal logic on
finite traces, categories of variables, equations, implication, pairings and the constants.
"""


def parse(text: str, dialect: Dialect = "ltlf") -> f.Formula:
    """The formula in a text, of whatever names; no name is an action. Raises as `read_formula`."""
    return _LtlReader(text, None, dialect).reading()[0]


def read_formula(
    text: str, signature: Signature, dialect: Dialect = "ltlf"
) -> tuple[f.Formula, tuple[Misuse, ...]]:
    """The formula in a text, and in text order the uses of names that a signature does not allow.

    The whole text is parsed before names are looked up, so a syntax error anywhere comes before an unknown
    name. An argument is a variable where a quantifier around it binds its name, otherwise an object. Names
    of actions become `Occurs`, all others, also unknown ones, `Atom`.

    Args:
        text: one formula.
        signature: the names to check against.
        dialect: the formulas to accept.

    Raises:
        ParseError: the text is no formula of the dialect, is nested too deep (`traversal.MAX_DEPTH`), or
            counts with too large a number (`traversal.MAX_COUNT_DIGITS`).
    """
    return _LtlReader(text, signature, dialect).reading()


_UNSPEAKABLE = re.compile(r"\W")
_NUMBERED = re.compile(r"(.+)\.([0-9]+)")


def spell_names(names: Iterable[str]) -> dict[str, str]:
    """Names as formulas can have them -> the names themselves, in order.

    What cannot stand in a formula's names becomes an underscore; where that makes two names one, the later
    gets one more.
    """
    words: dict[str, str] = {}
    for name in names:
        match = _NUMBERED.fullmatch(name)
        stem, number = (match[1], f".{match[2]}") if match else (name, "")
        stem = _UNSPEAKABLE.sub("_", stem)
        stem = stem if stem[:1].isalpha() or stem[:1] == "_" else f"_{stem}"
        while f"{stem}{number}" in words:
            stem += "_"
        words[f"{stem}{number}"] = name
    return words


_BLANK = r"[ \t\f\r\n]*"
_NAME = r"[a-zA-Z_\-]\w*"
_OBJECT = rf"{_NAME}(?:\.[0-9]+)?"
_CATEGORY = r"[a-zA-Z_\-][\w\-]*(?:\.\w+)*"
_PRIMITIVE = rf"{_NAME}{_BLANK}\({_BLANK}(?:{_OBJECT}{_BLANK}(?:,{_BLANK}{_OBJECT}{_BLANK})*)?\)"

_CONSTANT_PART = rf"(?:not|next|eventually|always){_BLANK}\({_BLANK}(?:true|false){_BLANK}\)"
"""A prefix before a constant in brackets, which looks like a primitive."""

_OPERANDS: Final[Mapping[Dialect, re.Pattern[str]]] = {
    "release": re.compile(
        rf"{_BLANK}(?:(?P<primitive>(?!not[a-zA-Z_\-]){_PRIMITIVE})|(?P<bracket>\()"
        r"|(?P<word>not|forall|exists|forn))"
    ),
    "ltlf": re.compile(
        rf"{_BLANK}(?:(?P<primitive>(?!{_CONSTANT_PART}){_PRIMITIVE})|(?P<bracket>\()"
        r"|(?P<word>(?:not|forall|exists|forn|next|eventually|always|true|false|forpairs|fornpairs)\b)"
        rf"|(?P<equation>{_OBJECT}{_BLANK}={_BLANK}{_OBJECT}))"
    ),
}
_JOINTS: Final[Mapping[Dialect, re.Pattern[str]]] = {
    "release": re.compile(rf"{_BLANK}(and|or|then|\)|\Z)"),
    "ltlf": re.compile(rf"{_BLANK}(and|or|then|until|implies|\)|\Z)"),
}
_OBJECTS: Final = re.compile(_OBJECT)
STRENGTHS: Final = {"": 0, ")": 0, "then": 1, "implies": 2, "or": 3, "and": 4, "until": 5}
"""How tightly what stands behind an operand binds; what stands in front of one binds with `PREFIX`."""
PREFIX: Final = 6

_Make: TypeAlias = Callable[..., f.Formula]
_SERIES: Final[Mapping[str, _Make]] = {
    "and": lambda *parts: f.And(parts),
    "or": lambda *parts: f.Or(parts),
    "then": lambda *parts: f.Then(parts),
}
_INFIXES: Final[Mapping[str, _Make]] = {"implies": f.Implies, "until": f.Until}
PREFIXES: Final[Mapping[str, _Make]] = {
    "not": f.Not,
    "next": f.Next,
    "eventually": f.Eventually,
    "always": f.Always,
}
_QUANTIFIERS: Final[Mapping[str, _Make]] = {"forall": f.ForAll, "exists": f.Exists, "forn": f.Exactly}
_CONSTANTS: Final[Mapping[str, f.Formula]] = {"true": f.TRUE, "false": f.FALSE}


@dataclass(slots=True)
class _Pending:
    """A construct that waits for its last part: a series, an infix, a prefix, a quantifier; or a bracket.

    A bracket has the strength 0. ``levels`` is the depth of its parts so far, ``scope`` has the names bound
    where it begins.
    """

    strength: int
    make: _Make
    parts: list[f.Formula]
    levels: int
    scope: frozenset[str]


class _LtlReader:
    """Reads one text from left to right; what is still open is on a stack, so that nothing recurses."""

    def __init__(self, text: str, signature: Signature | None, dialect: Dialect) -> None:
        self._text = text
        self._signature = signature
        self._is_release = dialect == "release"
        self._operands, self._joints = _OPERANDS[dialect], _JOINTS[dialect]
        self._offences: list[Misuse] = []
        self._position = 0
        self._scope: frozenset[str] = frozenset()
        self._stack: list[_Pending] = []
        self._brackets = 0

    def reading(self) -> tuple[f.Formula, tuple[Misuse, ...]]:
        """The formula of the whole text, and what is wrong with its names."""
        formula, levels = self._operand(), 1
        while True:
            joint = self._joint()
            strength = STRENGTHS[joint]
            while self._stack and self._stack[-1].strength > strength:
                pending = self._stack.pop()
                formula = pending.make(*pending.parts, formula)
                levels = 1 + max(levels, pending.levels)
                if levels > MAX_DEPTH:
                    raise self._expected(f"at most {MAX_DEPTH} levels of nesting")
            if joint == "":
                return formula, tuple(self._offences)
            if joint == ")":
                self._scope = self._stack.pop().scope
                self._brackets -= 1
            else:
                self._extend(joint, formula, levels)
                formula, levels = self._operand(), 1

    def _joint(self) -> str:
        """The token behind an operand: a word, a closing bracket, or nothing at the end of the text."""
        found = self._joints.match(self._text, self._position)
        if found is None:
            words = ["'and'", "'or'", "'then'", *([] if self._is_release else ["'until'", "'implies'"])]
            raise self._expected(*(["')'", *words] if self._brackets else [*words, "the end"]))
        joint = found[1]
        if joint == ("" if self._brackets else ")"):
            raise self._expected("')'" if self._brackets else "the end")
        self._position = found.end()
        return joint

    def _extend(self, joint: str, formula: f.Formula, levels: int) -> None:
        """Put an operand on the stack, with the word behind it."""
        strength = STRENGTHS[joint]
        if joint in _INFIXES:  # groups to the right: one on top of the other
            self._stack.append(_Pending(strength, _INFIXES[joint], [formula], levels, self._scope))
        elif self._stack and self._stack[-1].strength == strength:
            self._stack[-1].parts.append(formula)
            self._stack[-1].levels = max(levels, self._stack[-1].levels)
        else:
            self._stack.append(_Pending(strength, _SERIES[joint], [formula], levels, self._scope))

    def _operand(self) -> f.Formula:
        """The next formula without parts; prefixes, quantifiers and brackets before it go on the stack."""
        while True:
            found = self._operands.match(self._text, self._position)
            if found is None:
                raise self._malformed_operand()
            self._position = found.end()
            match found.lastgroup:
                case "primitive":
                    return self._primitive(found["primitive"], found.start("primitive"))
                case "bracket":
                    self._open_bracket(self._scope)
                case "equation":
                    left, right = _OBJECTS.findall(found["equation"])
                    return f.Equals(to_term(left, self._scope), to_term(right, self._scope))
                case _ if (word := found["word"]) in _CONSTANTS:
                    return _CONSTANTS[word]
                case _ if word in PREFIXES:
                    self._stack.append(_Pending(PREFIX, PREFIXES[word], [], 0, self._scope))
                case _:
                    self._quantifier(word)

    def _primitive(self, text: str, position: int) -> f.Formula:
        """The formula of a primitive's text, which stands at a position of the whole."""
        signature, scope = self._signature, self._scope
        if signature is not None and not scope and text in signature.parsed:
            return signature.parsed[text]
        name, *arguments = _OBJECTS.findall(text)
        terms = tuple([to_term(argument, scope) for argument in arguments])
        if signature is None:
            return f.Atom(name, terms)
        self._check(name, terms, signature, lambda i: position + [*_OBJECTS.finditer(text)][i].start())
        formula = f.Occurs(name, terms) if signature.is_action(name) else f.Atom(name, terms)
        if not scope and not self._offences and len(signature.parsed) < MAX_PARSED_PRIMITIVES:
            signature.parsed[text] = formula
        return formula

    def _check(
        self, name: str, terms: Sequence[f.Term], signature: Signature, position: Callable[[int], int]
    ) -> None:
        """Collect the offences of one predicate or action.

        Args:
            name: its name.
            terms: its arguments.
            signature: the names that it may use.
            position: gives the offset of the name (for 0) and of the arguments (from 1 on) in the text.
        """
        arities, objects = signature.arity_table(name), signature.objects
        if name not in arities:
            detail = f"{name} is no predicate and no action"
            self._offend("unknown_predicate", name, name, position(0), detail)
        elif (wanted := arities[name]) is not None and wanted != len(terms):
            detail = f"{describe_arity(name, wanted, 'argument')}, not {len(terms)}"
            self._offend("wrong_arity", name, name, position(0), detail)
        if objects is None:
            return
        for i, each in enumerate(terms, start=1):
            if isinstance(each, f.Constant) and each.name not in objects:
                detail = f"there is no object {each.name}"
                self._offend("unknown_object", each.name, name, position(i), detail)

    def _offend(self, kind: MisuseKind, name: str, primitive: str, position: int, detail: str) -> None:
        line, column = line_and_column(self._text, position)
        self._offences.append(Misuse(kind, name, primitive, line, column, detail))

    def _open_bracket(self, scope: frozenset[str]) -> None:
        """Open a bracket in which the names of a scope are bound."""
        self._stack.append(_Pending(0, f.And, [], 0, self._scope))
        self._scope = scope
        self._brackets += 1

    def _quantifier(self, word: str) -> None:
        """The variables between the word of a quantifier and its body."""
        count, expected = None, "a name"
        if word.startswith("forn"):
            count = self._count()
            if self._take(r"\.") is None:
                if self._is_release:
                    raise self._expected("'.'")
                expected = "a name or '.'"
        make: _Make
        variables: tuple[f.Variable, ...]
        if word.endswith("pairs"):
            first, second = variables = self._variable(expected, ","), self._variable("a name", ".")
            make = partial(f.ForPairs, first, second, count=count)
        else:
            variables = (self._variable(expected, "."),)
            make = partial(_QUANTIFIERS[word], *(() if count is None else (count,)), *variables)
        self._need(r"\(", "'('")
        self._stack.append(_Pending(PREFIX, make, [], 0, self._scope))
        self._open_bracket(self._scope | {variable.name for variable in variables})

    def _count(self) -> int:
        digits = self._need(r"\d+", "a number")
        if len(digits) > MAX_COUNT_DIGITS:
            place = self._position - len(digits)
            raise error_at(self._text, place, f"a number of at most {MAX_COUNT_DIGITS} digits")
        return int(digits)

    def _variable(self, expected: str, end: str) -> f.Variable:
        """A variable, and the sign that ends its declaration."""
        name, category = self._need(_NAME, expected), None
        if not self._is_release and self._take(":") is not None:
            category = self._need(_CATEGORY, "a category")
        signs = [f"'{end}'"] if self._is_release or category else [f"'{end}'", "':'"]
        self._need(re.escape(end), *signs)
        return f.Variable(name, category)

    def _malformed_operand(self) -> ParseError:
        """Where a text stops to be an operand, and what could have stood there."""
        name = self._take(_NAME if self._is_release else _OBJECT)
        if name is None:
            return self._expected("a predicate or action", "a name", "'not'", "a quantifier", "'('")
        if not self._is_release and self._take("=") is not None:
            return self._expected("a name")
        if "." in name:
            return self._expected("'='")
        if self._take(r"\(") is None:
            return self._expected("'('") if self._is_release else self._expected("'('", "'='")
        if self._take(_OBJECT) is None:
            return self._expected("a name", "')'")
        while self._take(",") is not None:
            if self._take(_OBJECT) is None:
                return self._expected("a name")
        return self._expected("')'", "','")

    def _take(self, pattern: str) -> str | None:
        """The text of a pattern if it stands here, past blanks."""
        found = re.compile(f"{_BLANK}({pattern})").match(self._text, self._position)
        if found is None:
            return None
        self._position = found.end()
        return found[1]

    def _need(self, pattern: str, *expected: str) -> str:
        found = self._take(pattern)
        if found is None:
            raise self._expected(*expected)
        return found

    def _expected(self, *words: str) -> ParseError:
        """The error that none of these stands here, past blanks."""
        self._take("")
        return error_at(self._text, self._position, join_with_or(words))
