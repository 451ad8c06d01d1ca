"""Formulas as text, in the syntax of the paper's goals and subgoals."""

from __future__ import annotations

import re
from enum import Enum
from functools import partial

from lark import Token

from eai.logic.formula import Atom, Equals, Formula, Occurs, Term
from eai.logic.grammar import ParseTree, parse_tree
from eai.logic.plain import read_plain
from eai.logic.reader import FormulaReader, Reading, start, term
from eai.logic.signature import Signature

MAX_KNOWN = 1_000
"""How many primitives are remembered with a signature."""

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
        ParseError: the text is no formula of the dialect, is nested too deep (`traversal.MAX_DEPTH`), or
            counts with too large a number (`reader.MAX_COUNT_DIGITS`).
    """
    reader = _LtlReader(text, signature)
    formula = read_plain(text, reader.named)
    if formula is None:
        return parse_by_grammar(text, signature, dialect)
    return Reading(formula, reader.offences)


def parse_by_grammar(text: str, signature: Signature | None, dialect: Dialect) -> Reading:
    """What `parse` returns and raises, also where a plain formula could be read faster."""
    return _LtlReader(text, signature).reading(parse_tree(dialect.value, text, _WORDS))


class _LtlReader(FormulaReader):
    def primitive(self, tree: ParseTree | Token, scope: frozenset[str]) -> Formula:
        if not isinstance(tree, Token):  # the only other rule is that of an equation
            left, right = (term(str(token), scope) for token in tree.children)
            return Equals(left, right)
        return self.named(tree, start(tree), scope)

    def named(self, text: str, position: int, scope: frozenset[str]) -> Formula:
        """The formula of a primitive's text, which stands at a position of the whole."""
        signature = self._signature
        if signature is None:
            return Atom(*_name_and_terms(text, scope))
        if not scope and text in signature.known:
            return signature.known[text]
        name, terms = _name_and_terms(text, scope)
        self._checker.check(name, terms, partial(_place_of_name, text, position))
        formula = Occurs(name, terms) if signature.is_action(name) else Atom(name, terms)
        if not scope and not self._checker.offences and len(signature.known) < MAX_KNOWN:
            signature.known[text] = formula
        return formula


def _name_and_terms(primitive: str, scope: frozenset[str]) -> tuple[str, tuple[Term, ...]]:
    name, *arguments = _NAME.findall(primitive)
    return name, tuple([term(argument, scope) for argument in arguments])


def _place_of_name(primitive: str, position: int, index: int) -> int:
    """The offset of the predicate (0) or an argument (from 1 on)."""
    return position + list(_NAME.finditer(primitive))[index].start()
