"""Reader of formulas in the syntax of goals and subgoals of the paper "Embodied Agent Interface".

Operators from the loosest to the tightest: then, implies, or, and, until; then the prefixes not, next,
eventually and always. Blanks may stand between any two words, and are never needed: ``p(x)thenq(y)`` is a
formula. No word is reserved: ``not(x)`` and ``forall(x)`` are atoms or actions, because ``x`` alone is not a
formula. ``not(true)`` is a negation, because ``true`` is a formula.
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
    FormulaSignature,
    NameMisuse,
    NameMisuseKind,
    describe_wrong_arity,
    find_line_and_column,
    join_with_or,
    make_parse_error,
    make_term,
)
from eai.logic.traversal import MAX_COUNT_DIGITS, MAX_FORMULA_DEPTH

MAX_CACHED_ATOMS_AND_ACTIONS = 1_000
"""Maximum number of parsed atoms and actions that one `FormulaSignature` (set of allowed names) caches."""


Dialect: TypeAlias = Literal["release", "ltlf"]
"""Name of a dialect, that is, of the set of formulas that the reader accepts.

``release``: the paper's formulas, exactly as the parser of eai-eval 1.0.5 accepts them
(``tl_formula/simple_tl_parser.py``). In this dialect, a name that begins with ``not`` is a negation
(``notopen(x)``).
``ltlf``: the paper's formulas, with or without a period after the number of ``forn``. This dialect adds
all of linear temporal logic on finite traces, implication, equations (``x = y``), ``true``, ``false``,
``forpairs`` and ``fornpairs``. A quantifier may give its variable a category (``exists x: lamp.``).
"""


def parse(text: str, dialect: Dialect = "ltlf") -> f.Formula:
    """Parse a formula without a signature: every name is allowed, and every predicate becomes an atom.

    Raises:
        ParseError: the text is not a formula of the dialect, as in `read_formula`.
    """
    return _LtlReader(text, None, dialect).read()[0]


def read_formula(
    text: str, signature: FormulaSignature, dialect: Dialect = "ltlf"
) -> tuple[f.Formula, tuple[NameMisuse, ...]]:
    """Parse a formula. Return it with the misuses of names (see `NameMisuse`), in the order of the text.

    The whole text is parsed before names are looked up. So a syntax error anywhere is reported before any
    unknown name. An argument is a variable if a quantifier around it binds its name, otherwise an object.
    Names of actions become `Occurs`; all other names, even unknown ones, become `Atom`.

    Args:
        text: one formula.
        signature: the names that the formula may use.
        dialect: the formulas to accept.

    Raises:
        ParseError: the text is not a formula of the dialect, is nested too deep
            (`traversal.MAX_FORMULA_DEPTH`), or has a count with too many digits
            (`traversal.MAX_COUNT_DIGITS`).
    """
    return _LtlReader(text, signature, dialect).read()


_INVALID_CHARACTER = re.compile(r"\W")
_NUMBERED_NAME = re.compile(r"(.+)\.([0-9]+)")


def map_formula_safe_names_to_original_names(original_names: Iterable[str]) -> dict[str, str]:
    """Return a mapping from the spellings of names in formulas to the names, in their given order.

    A character that formulas do not allow in names becomes an underscore. If two spellings become equal, the
    later one gets another underscore.
    """
    words: dict[str, str] = {}
    for name in original_names:
        match = _NUMBERED_NAME.fullmatch(name)
        stem, number = (match[1], f".{match[2]}") if match else (name, "")
        stem = _INVALID_CHARACTER.sub("_", stem)
        stem = stem if stem[:1].isalpha() or stem[:1] == "_" else f"_{stem}"
        while f"{stem}{number}" in words:
            stem += "_"
        words[f"{stem}{number}"] = name
    return words


_BLANK = r"[ \t\f\r\n]*"
_NAME = r"(?:[^\W\d]|-)\w*"
_RELEASE_NAME = r"[a-zA-Z_\-]\w*"
_OBJECT = rf"{_NAME}(?:\.[0-9]+)?"
_CATEGORY = r"(?:[^\W\d]|-)[\w\-]*(?:\.\w+)*"
_PRIMITIVE = rf"{_NAME}{_BLANK}\({_BLANK}(?:{_OBJECT}{_BLANK}(?:,{_BLANK}{_OBJECT}{_BLANK})*)?\)"
_RELEASE_PRIMITIVE = _PRIMITIVE.replace(_NAME, _RELEASE_NAME)

_PREFIXED_CONSTANT = rf"(?:not|next|eventually|always){_BLANK}\({_BLANK}(?:true|false){_BLANK}\)"
"""Pattern of a prefix operator before a constant in brackets. The text looks like an atom: ``not(true)``."""

_OPERANDS: Final[Mapping[Dialect, re.Pattern[str]]] = {
    "release": re.compile(
        rf"{_BLANK}(?:(?P<primitive>(?!not[a-zA-Z_\-]){_RELEASE_PRIMITIVE})|(?P<bracket>\()"
        r"|(?P<word>not|forall|exists|forn))"
    ),
    "ltlf": re.compile(
        rf"{_BLANK}(?:(?P<primitive>(?!{_PREFIXED_CONSTANT}){_PRIMITIVE})|(?P<bracket>\()"
        r"|(?P<word>(?:not|forall|exists|forn|next|eventually|always|true|false|forpairs|fornpairs)\b)"
        rf"|(?P<equation>{_OBJECT}{_BLANK}={_BLANK}{_OBJECT}))"
    ),
}
_OPERATORS: Final[Mapping[Dialect, re.Pattern[str]]] = {
    "release": re.compile(rf"{_BLANK}(and|or|then|\)|\Z)"),
    "ltlf": re.compile(rf"{_BLANK}(and|or|then|until|implies|\)|\Z)"),
}
_OBJECTS: Final = re.compile(_OBJECT)
STRENGTHS: Final = {"": 0, ")": 0, "then": 1, "implies": 2, "or": 3, "and": 4, "until": 5}
"""Binding strength of each infix word: larger numbers bind more tightly. See also `PREFIX`."""
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
class _PartlyParsedSubformula:
    """A construct that is not yet read to its end: an operator, a quantifier or an opening bracket.

    Attributes:
        strength: binding strength, as in `STRENGTHS`; 0 for a bracket.
        make: function that builds the formula from its operands.
        parts: the operands read before the current one.
        levels: maximum nesting depth of the operands in ``parts``.
        scope: names of variables that quantifiers around the construct bind.
    """

    strength: int
    make: _Make
    parts: list[f.Formula]
    levels: int
    scope: frozenset[str]


class _LtlReader:
    """Reads a formula from left to right. Open constructs are on a stack, so that no method recurses."""

    def __init__(self, text: str, signature: FormulaSignature | None, dialect: Dialect) -> None:
        self._text = text
        self._signature = signature
        self._is_release = dialect == "release"
        self._name = _RELEASE_NAME if self._is_release else _NAME
        self._operands, self._joints = _OPERANDS[dialect], _OPERATORS[dialect]
        self._misuses: list[NameMisuse] = []
        self._position = 0
        self._scope: frozenset[str] = frozenset()
        self._stack: list[_PartlyParsedSubformula] = []
        self._brackets = 0

    def read(self) -> tuple[f.Formula, tuple[NameMisuse, ...]]:
        """Return the formula of the whole text, and the misuses of names (unknown, or with a wrong arity)."""
        formula, levels = self._read_operand(), 1
        while True:
            operator = self._read_token_after_operand()
            strength = STRENGTHS[operator]
            while self._stack and self._stack[-1].strength > strength:
                pending = self._stack.pop()
                formula = pending.make(*pending.parts, formula)
                levels = 1 + max(levels, pending.levels)
                if levels > MAX_FORMULA_DEPTH:
                    raise self._make_error(f"at most {MAX_FORMULA_DEPTH} levels of nesting")
            if operator == "":
                return formula, tuple(self._misuses)
            if operator == ")":
                self._scope = self._stack.pop().scope
                self._brackets -= 1
            else:
                self._push_operand(formula, operator, levels)
                formula, levels = self._read_operand(), 1

    def _read_token_after_operand(self) -> str:
        """Read and return the token after an operand: a word, a closing bracket, or "" at the end."""
        match = self._joints.match(self._text, self._position)
        if match is None:
            words = ["'and'", "'or'", "'then'", *([] if self._is_release else ["'until'", "'implies'"])]
            raise self._make_error(*(["')'", *words] if self._brackets else [*words, "the end"]))
        operator = match[1]
        if operator == ("" if self._brackets else ")"):
            raise self._make_error("')'" if self._brackets else "the end")
        self._position = match.end()
        return operator

    def _push_operand(self, operand: f.Formula, next_operator: str, nesting_depth: int) -> None:
        strength = STRENGTHS[next_operator]
        if next_operator in _INFIXES:  # right-associative: the next operand starts a nested formula
            self._stack.append(
                _PartlyParsedSubformula(
                    strength, _INFIXES[next_operator], [operand], nesting_depth, self._scope
                )
            )
        elif self._stack and self._stack[-1].strength == strength:
            self._stack[-1].parts.append(operand)
            self._stack[-1].levels = max(nesting_depth, self._stack[-1].levels)
        else:
            self._stack.append(
                _PartlyParsedSubformula(
                    strength, _SERIES[next_operator], [operand], nesting_depth, self._scope
                )
            )

    def _read_operand(self) -> f.Formula:
        """Read the next atom, action, equation or constant.

        Prefixes, quantifiers and opening brackets before the operand are pushed on the stack.
        """
        while True:
            token = self._operands.match(self._text, self._position)
            if token is None:
                raise self._make_operand_error()
            self._position = token.end()
            match token.lastgroup:
                case "primitive":
                    return self._read_atom_or_action(token["primitive"], token.start("primitive"))
                case "bracket":
                    self._push_open_bracket(self._scope)
                case "equation":
                    return self._read_equation(token["equation"], token.start("equation"))
                case _ if (word := token["word"]) in _CONSTANTS:
                    return _CONSTANTS[word]
                case _ if word in PREFIXES:
                    self._stack.append(_PartlyParsedSubformula(PREFIX, PREFIXES[word], [], 0, self._scope))
                case _:
                    self._parse_and_push_quantifier(word)

    def _read_atom_or_action(self, text: str, position: int) -> f.Formula:
        signature, scope = self._signature, self._scope
        if signature is not None and not scope and text in signature.parsed:
            return signature.parsed[text]
        name, *arguments = _OBJECTS.findall(text)
        terms = tuple([make_term(argument, scope) for argument in arguments])
        if signature is None:
            return f.Atom(name, terms)
        self._record_misused_names(
            name, terms, signature, lambda i: position + [*_OBJECTS.finditer(text)][i].start()
        )
        formula = f.Occurs(name, terms) if signature.is_action(name) else f.Atom(name, terms)
        if not scope and not self._misuses and len(signature.parsed) < MAX_CACHED_ATOMS_AND_ACTIONS:
            signature.parsed[text] = formula
        return formula

    def _read_equation(self, text: str, position: int) -> f.Formula:
        names = [*_OBJECTS.finditer(text)]
        left, right = terms = [make_term(name.group(), self._scope) for name in names]
        if self._signature is not None:
            self._record_unknown_objects(
                "=", terms, self._signature, lambda i: position + names[i - 1].start()
            )
        return f.Equals(left, right)

    def _record_misused_names(
        self,
        name: str,
        terms: Sequence[f.Term],
        signature: FormulaSignature,
        find_offset: Callable[[int], int],
    ) -> None:
        """Record misuses of names in one atom or action: names that the signature does not allow.

        Args:
            name: name of the predicate or action.
            terms: its arguments.
            signature: the names that a formula may use.
            find_offset: function that takes the number of an argument, from 1, and returns its offset in the
                text; for 0 the offset of the name.
        """
        arities = signature.get_arities_of_names_of_same_kind(name)
        if name not in arities:
            detail = f"{name} is no predicate and no action"
            self._add_misuse("unknown_predicate", name, name, find_offset(0), detail)
        elif (arity := arities[name]) is not None and arity != len(terms):
            detail = describe_wrong_arity(name, arity, "argument", len(terms))
            self._add_misuse("wrong_arity", name, name, find_offset(0), detail)
        self._record_unknown_objects(name, terms, signature, find_offset)

    def _record_unknown_objects(
        self,
        name: str,
        terms: Sequence[f.Term],
        signature: FormulaSignature,
        find_offset: Callable[[int], int],
    ) -> None:
        objects = signature.objects
        if objects is None:
            return
        for i, term in enumerate(terms, start=1):
            if isinstance(term, f.Constant) and term.name not in objects:
                detail = f"there is no object {term.name}"
                self._add_misuse("unknown_object", term.name, name, find_offset(i), detail)

    def _add_misuse(
        self, kind: NameMisuseKind, name: str, primitive: str, position: int, detail: str
    ) -> None:
        line, column = find_line_and_column(self._text, position)
        self._misuses.append(NameMisuse(kind, name, primitive, line, column, detail))

    def _push_open_bracket(self, bound_variables: frozenset[str]) -> None:
        self._stack.append(_PartlyParsedSubformula(0, f.And, [], 0, self._scope))
        self._scope = bound_variables
        self._brackets += 1

    def _parse_and_push_quantifier(self, keyword: str) -> None:
        count, expected = None, "a name"
        if keyword.startswith("forn"):
            count = self._parse_quantifier_count()
            if self._read_match(r"\.") is None:
                if self._is_release:
                    raise self._make_error("'.' after the number")
                expected = "a name or '.'"
        make: _Make
        variables: tuple[f.Variable, ...]
        if keyword.endswith("pairs"):
            first, second = variables = (
                self._read_quantified_variable(expected, ","),
                self._read_quantified_variable("a name", "."),
            )
            make = partial(f.ForPairs, first, second, count=count)
        else:
            variables = (self._read_quantified_variable(expected, "."),)
            make = partial(_QUANTIFIERS[keyword], *(() if count is None else (count,)), *variables)
        self._read_required_match(r"\(", "'('")
        self._stack.append(_PartlyParsedSubformula(PREFIX, make, [], 0, self._scope))
        self._push_open_bracket(self._scope | {variable.name for variable in variables})

    def _parse_quantifier_count(self) -> int:
        digits = self._read_required_match(r"\d+", "a number")
        if len(digits) > MAX_COUNT_DIGITS:
            position = self._position - len(digits)
            raise make_parse_error(self._text, position, f"a number of at most {MAX_COUNT_DIGITS} digits")
        return int(digits)

    def _read_quantified_variable(self, expected_in_message: str, end_sign: str) -> f.Variable:
        name, category = self._read_required_match(self._name, expected_in_message), None
        if not self._is_release and self._read_match(":") is not None:
            category = self._read_required_match(_CATEGORY, "a category")
        signs = [f"'{end_sign}'"] if self._is_release or category else [f"'{end_sign}'", "':'"]
        self._read_required_match(re.escape(end_sign), *signs)
        return f.Variable(name, category)

    def _make_operand_error(self) -> ParseError:
        name = self._read_match(self._name if self._is_release else _OBJECT)
        if name is None:
            return self._make_error("a predicate or action", "a name", "'not'", "a quantifier", "'('")
        if not self._is_release and self._read_match("=") is not None:
            return self._make_error("a name")
        if "." in name:
            return self._make_error("'='")
        if self._read_match(r"\(") is None:
            return self._make_error("'('") if self._is_release else self._make_error("'('", "'='")
        object_name = _OBJECT.replace(_NAME, self._name)
        if self._read_match(object_name) is None:
            return self._make_error("a name", "')'")
        while self._read_match(",") is not None:
            if self._read_match(object_name) is None:
                return self._make_error("a name")
        return self._make_error("')'", "','")

    def _read_match(self, pattern: str) -> str | None:
        """Skip blanks, and read text that matches a pattern; None if the next text does not match."""
        match = re.compile(f"{_BLANK}({pattern})").match(self._text, self._position)
        if match is None:
            return None
        self._position = match.end()
        return match[1]

    def _read_required_match(self, pattern: str, *expected: str) -> str:
        text = self._read_match(pattern)
        if text is None:
            raise self._make_error(*expected)
        return text

    def _make_error(self, *expected: str) -> ParseError:
        self._read_match("")
        return make_parse_error(self._text, self._position, join_with_or(expected))
