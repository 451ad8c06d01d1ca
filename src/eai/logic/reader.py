"""From parse trees to formulas, for every grammar whose rules have these names.

Rules named after connectives hold their operands; rules named after quantifiers hold an optional COUNT token,
one or two ``variable`` trees and the body. What a primitive looks like is each syntax's own business.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass

from lark import Token

from eai.logic.formula import (
    FALSE,
    TRUE,
    Always,
    And,
    Constant,
    Eventually,
    Exactly,
    Exists,
    ForAll,
    Formula,
    ForPairs,
    Implies,
    Next,
    Not,
    Or,
    Term,
    Then,
    Until,
    Variable,
)
from eai.logic.grammar import ParseTree, error_at
from eai.logic.signature import NameChecker, Offence, Signature
from eai.logic.traversal import MAX_DEPTH

MAX_COUNT_DIGITS = 9
"""The longest number that a counting quantifier may carry."""


@dataclass(frozen=True, slots=True)
class Reading:
    """A text that parsed: its formula, and in text order the names that the signature does not allow."""

    formula: Formula
    offences: tuple[Offence, ...] = ()


class FormulaReader(ABC):
    """Turns parse trees of one text into formulas, top down: only quantifiers know what is a variable.

    Args:
        text: the text that was parsed.
        signature: the names to check against; None checks nothing and knows no actions.
    """

    def __init__(self, text: str, signature: Signature | None = None) -> None:
        self._text = text
        self._signature = signature
        self._checker = NameChecker(text, signature)

    def reading(self, tree: ParseTree | Token) -> Reading:
        """The formula of a tree without variables from outside, and what is wrong with its names.

        Raises:
            ParseError: it is nested deeper than `MAX_DEPTH`, or counts with a number of more than
                `MAX_COUNT_DIGITS` digits.
        """
        formula = self.read(tree, frozenset(), MAX_DEPTH)
        return Reading(formula, self.offences)

    @property
    def offences(self) -> tuple[Offence, ...]:
        """What is wrong with the names read so far."""
        return tuple(self._checker.offences)

    def read(self, tree: ParseTree | Token, scope: frozenset[str], levels: int) -> Formula:
        """The formula of a tree that may have ``levels`` levels, below quantifiers that bind ``scope``."""
        if levels == 0:
            raise error_at(self._text, start(tree), f"at most {MAX_DEPTH} levels of nesting")
        rule = "primitive" if isinstance(tree, Token) else str(tree.data)
        if isinstance(tree, Token) or rule not in _RULES:
            return self.primitive(tree, scope)
        if rule in _QUANTIFIERS:
            return self._quantified(rule, tree, scope, levels)
        return _CONNECTIVES[rule](tuple([self.read(part, scope, levels - 1) for part in tree.children]))

    @abstractmethod
    def primitive(self, tree: ParseTree | Token, scope: frozenset[str]) -> Formula:
        """The formula of a tree that is no connective and no quantifier."""

    def variable(self, tree: ParseTree) -> Variable:
        """The variable that a quantifier binds."""
        name, *category = map(str, tree.children)
        return Variable(name, category[0] if category else None)

    def _quantified(self, rule: str, tree: ParseTree, scope: frozenset[str], levels: int) -> Formula:
        *head, body_tree = tree.children
        variables = [self.variable(part) for part in head if not isinstance(part, Token)]
        counts = [self._count(part) for part in head if isinstance(part, Token)]
        body = self.read(body_tree, scope | {variable.name for variable in variables}, levels - 1)
        return _QUANTIFIERS[rule](counts, variables, body)

    def _count(self, token: Token) -> int:
        if len(token) > MAX_COUNT_DIGITS:
            raise error_at(self._text, start(token), f"a number of at most {MAX_COUNT_DIGITS} digits")
        return int(token)


def term(name: str, scope: frozenset[str]) -> Term:
    """What a name denotes below quantifiers that bind the names in ``scope``."""
    return Variable(name) if name in scope else Constant(name)


def start(tree: ParseTree | Token) -> int:
    """The offset of the first token of a tree that is not mere syntax; 0 if there is none."""
    while not isinstance(tree, Token):
        if not tree.children:
            return 0
        tree = tree.children[0]
    return tree.start_pos or 0


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
    "true": lambda _: TRUE,
    "false": lambda _: FALSE,
}

_QUANTIFIERS: dict[str, Callable[[list[int], list[Variable], Formula], Formula]] = {
    "for_all": lambda _, variables, body: ForAll(variables[0], body),
    "exists": lambda _, variables, body: Exists(variables[0], body),
    "exactly": lambda counts, variables, body: Exactly(counts[0], variables[0], body),
    "for_pairs": lambda _, variables, body: ForPairs(variables[0], variables[1], body),
    "for_n_pairs": lambda counts, variables, body: ForPairs(variables[0], variables[1], body, counts[0]),
}

_RULES = {*_CONNECTIVES, *_QUANTIFIERS}
