"""Formulas as text, in the syntax of the paper's goals and subgoals."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum

from lark import Token

from eai.logic.formula import (
    FALSE,
    TRUE,
    Always,
    And,
    Atom,
    Constant,
    Equals,
    Eventually,
    Exactly,
    Exists,
    ForAll,
    Formula,
    ForPairs,
    Implies,
    Next,
    Not,
    Occurs,
    Or,
    Term,
    Then,
    Until,
    Variable,
)
from eai.logic.grammar import ParseTree, error_at, parse_tree, place
from eai.logic.signature import Offence, OffenceKind, Signature
from eai.logic.traversal import MAX_DEPTH

MAX_COUNT_DIGITS = 9
"""The longest number that a counting quantifier may carry."""

_NAME = re.compile(r"[a-zA-Z_\-]\w*(?:\.[0-9]+)?")

_WORDS = {
    "PRIMITIVE": "a predicate or action",
    "NAME": "a name",
    "OBJECT": "a name",
    "CATEGORY": "a category",
    "COUNT": "a number",
    "_NOT": "'not'",
    "_FORALL": "a quantifier",
    "LPAR": "'('",
    "RPAR": "')'",
    "COMMA": "','",
    "DOT": "'.'",
    "COLON": "':'",
    "EQUAL": "'='",
    "_AND": "'and'",
    "_OR": "'or'",
    "_THEN": "'then'",
    "_UNTIL": "'until'",
    "_IMPLIES": "'implies'",
    "$END": "the end",
}


class Dialect(Enum):
    """Which formulas are accepted."""

    RELEASE = "ltl.lark"
    """What the parser of eai-eval 1.0.5 accepts, text for text (``tl_formula/simple_tl_parser.py``)."""
    LTLF = "ltlf.lark"
    """The paper's formulas in both spellings of ``forn``, and all of LTL on finite traces."""


@dataclass(frozen=True, slots=True)
class Reading:
    """A text that parsed: its formula, and in text order the names that the signature does not allow."""

    formula: Formula
    offences: tuple[Offence, ...] = ()


def parse(text: str, signature: Signature | None = None, dialect: Dialect = Dialect.LTLF) -> Reading:
    """Read a formula.

    The whole text is parsed before names are looked up, so a syntax error anywhere comes before an unknown
    name. An argument is a variable where a quantifier around it binds its name, otherwise an object. Names
    of actions become `Occurs`, all others, also unknown ones, `Atom`.

    Args:
        text: one formula.
        signature: the names to check against; None checks nothing and knows no actions.
        dialect: the grammar.

    Raises:
        ParseError: the text is no formula of the dialect, is nested deeper than `MAX_DEPTH`, or counts with
            a number of more than `MAX_COUNT_DIGITS` digits.
    """
    reader = _Reader(text, signature)
    formula = reader.read(parse_tree(dialect.value, text, _WORDS), frozenset(), MAX_DEPTH)
    return Reading(formula, tuple(reader.offences))


class _Reader:
    """Turns one parse tree into a formula, top down, because only quantifiers know what is a variable."""

    def __init__(self, text: str, signature: Signature | None) -> None:
        self._text = text
        self._signature = signature
        self.offences: list[Offence] = []

    def read(self, tree: ParseTree | Token, scope: frozenset[str], levels: int) -> Formula:
        """The formula of a tree that may have ``levels`` levels, below quantifiers that bind ``scope``."""
        if levels == 0:
            raise error_at(self._text, _start(tree), f"at most {MAX_DEPTH} levels of nesting")
        if isinstance(tree, Token):
            return self._primitive(tree, scope)
        rule = str(tree.data)
        if rule in _QUANTIFIERS:
            return self._quantified(rule, tree, scope, levels)
        if rule == "equals":
            left, right = (_term(_token(argument), scope) for argument in tree.children)
            return Equals(left, right)
        parts = tuple(self.read(child, scope, levels - 1) for child in tree.children)
        return _CONNECTIVES[rule](parts)

    def _primitive(self, token: Token, scope: frozenset[str]) -> Formula:
        name, *arguments = _NAME.findall(token)
        terms = tuple(_term(argument, scope) for argument in arguments)
        signature = self._signature
        if signature is None:
            return Atom(name, terms)
        if not signature.knows(name):
            detail = f"{name} is no predicate and no action"
            self._add(OffenceKind.UNKNOWN_PREDICATE, name, name, token.start_pos, detail)
        elif (arity := signature.arity(name)) not in (None, len(terms)):
            detail = f"{name} takes {arity} arguments, not {len(terms)}"
            self._add(OffenceKind.WRONG_ARITY, name, name, token.start_pos, detail)
        for i, term in enumerate(terms):
            if isinstance(term, Constant) and not signature.has_object(term.name):
                self._unknown_object(token, name, i)
        return Occurs(name, terms) if signature.is_action(name) else Atom(name, terms)

    def _quantified(self, rule: str, tree: ParseTree, scope: frozenset[str], levels: int) -> Formula:
        *head, body_tree = tree.children
        variables = [_variable(part) for part in head if not isinstance(part, Token)]
        counts = [self._count(part) for part in head if isinstance(part, Token) and part.type == "COUNT"]
        body = self.read(body_tree, scope | {variable.name for variable in variables}, levels - 1)
        return _QUANTIFIERS[rule](counts, variables, body)

    def _count(self, token: Token) -> int:
        if len(token) > MAX_COUNT_DIGITS:
            limit = f"a number of at most {MAX_COUNT_DIGITS} digits"
            raise error_at(self._text, token.start_pos or 0, limit)
        return int(token)

    def _unknown_object(self, token: Token, primitive: str, index: int) -> None:
        match = list(_NAME.finditer(token))[index + 1]
        name = match.group()
        position = (token.start_pos or 0) + match.start()
        self._add(OffenceKind.UNKNOWN_OBJECT, name, primitive, position, f"there is no object {name}")

    def _add(self, kind: OffenceKind, name: str, primitive: str, position: int | None, detail: str) -> None:
        line, column = place(self._text, position or 0)
        self.offences.append(Offence(kind, name, primitive, line, column, detail))


def _term(name: str, scope: frozenset[str]) -> Term:
    return Variable(name) if name in scope else Constant(str(name))


def _token(tree: ParseTree | Token) -> Token:
    """The first token of a tree."""
    while not isinstance(tree, Token):
        tree = tree.children[0]
    return tree


def _start(tree: ParseTree | Token) -> int:
    return _token(tree).start_pos or 0


def _variable(tree: ParseTree) -> Variable:
    name, *category = map(str, tree.children)
    return Variable(name, category[0] if category else None)


_CONNECTIVES: dict[str, Callable[[tuple[Formula, ...]], Formula]] = {
    "sequence": Then,
    "disjunction": Or,
    "conjunction": And,
    "negation": lambda parts: Not(parts[0]),
    "implication": lambda parts: Implies(parts[0], parts[1]),
    "until": lambda parts: Until(parts[0], parts[1]),
    "next": lambda parts: Next(parts[0]),
    "eventually": lambda parts: Eventually(parts[0]),
    "always": lambda parts: Always(parts[0]),
    "true": lambda parts: TRUE,
    "false": lambda parts: FALSE,
}

_QUANTIFIERS: dict[str, Callable[[list[int], list[Variable], Formula], Formula]] = {
    "for_all": lambda _, variables, body: ForAll(variables[0], body),
    "exists": lambda _, variables, body: Exists(variables[0], body),
    "exactly": lambda counts, variables, body: Exactly(counts[0], variables[0], body),
    "for_pairs": lambda _, variables, body: ForPairs(variables[0], variables[1], body),
    "for_n_pairs": lambda counts, variables, body: ForPairs(variables[0], variables[1], body, counts[0]),
}
