"""BDDL, the language of BEHAVIOR's activity definitions: conditions and whole problem files.

A name with a ``?`` is a variable if a quantifier around it binds it, otherwise the object of that name.
Everything is lower case, as in bddl's own reader (``bddl/parsing.py``).
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import partial

from lark import Token

from eai.logic.formula import And, Atom, Formula, Occurs, Variable
from eai.logic.grammar import ParseTree, error_at, parse_tree
from eai.logic.reader import FormulaReader, Reading, start, term
from eai.logic.signature import Signature

GRAMMAR = "bddl.lark"

_NAME = re.compile(r"[^\s();]+")

_WORDS = {
    "WORD": "a name",
    "COUNT": "a number",
    "_HYPHEN": "'-'",
    "LPAR": "'('",
    "RPAR": "')'",
    "_AND": "a connective",
    "_DEFINE": "'define'",
    "_PROBLEM": "'problem'",
    "_DOMAIN": "':domain'",
    "_OBJECTS": "':objects'",
    "_INIT": "':init'",
    "_GOAL": "':goal'",
    "$END": "the end",
}


@dataclass(frozen=True, slots=True)
class Declaration:
    """An object of a problem with its category (a synset such as ``candle.n.01``)."""

    name: str
    category: str


@dataclass(frozen=True, slots=True)
class Problem:
    """An activity definition: its objects in the order of the file, initial facts and goal."""

    name: str
    domain: str
    objects: tuple[Declaration, ...]
    init: tuple[Formula, ...]
    goal: Formula

    @property
    def goals(self) -> tuple[Formula, ...]:
        """The goal's top-level conjuncts: what BEHAVIOR calls its goal conditions."""
        return self.goal.operands if isinstance(self.goal, And) else (self.goal,)


def parse_condition(text: str, signature: Signature | None = None) -> Reading:
    """Read one BDDL condition.

    Args:
        text: a condition, such as ``(forall (?tray.n.01 - tray.n.01) (not (stained ?tray.n.01)))``.
        signature: the names to check against; None checks nothing and knows no actions.

    Raises:
        ParseError: the text is no condition, or nested too deep (`traversal.MAX_DEPTH`).
    """
    return _BddlReader(text, signature).reading(parse_tree(GRAMMAR, text, _WORDS, "condition"))


def parse_problem(text: str) -> Problem:
    """Read a whole problem file; line ends and comments do not matter.

    Raises:
        ParseError: the text is no problem file, has not exactly one domain, objects, init and goal section,
            or is nested too deep (`traversal.MAX_DEPTH`).
    """
    tree = parse_tree(GRAMMAR, text, _WORDS, "problem")
    reader = _BddlReader(text)
    name, *sections = _children(tree)
    by_rule = {str(section.data): section.children for section in sections if not isinstance(section, Token)}
    for rule in ("domain", "objects", "init", "goal"):
        if sum(not isinstance(s, Token) and s.data == rule for s in sections) != 1:
            raise error_at(text, len(text), f"exactly one ':{rule}' section")
    return Problem(
        _word(name),
        _word(by_rule["domain"][0]),
        tuple(each for declaration in by_rule["objects"] for each in _declared(declaration)),
        tuple(reader.reading(fact).formula for fact in by_rule["init"]),
        reader.reading(by_rule["goal"][0]).formula,
    )


class _BddlReader(FormulaReader):
    def primitive(self, tree: ParseTree | Token, scope: frozenset[str]) -> Formula:
        name, *arguments = _words(tree)
        terms = tuple([term(argument, scope) for argument in arguments])
        if self._signature is None:
            return Atom(name, terms)
        self._checker.check(name, terms, partial(_place_of_name, tree))
        return Occurs(name, terms) if self._signature.is_action(name) else Atom(name, terms)

    def variable(self, tree: ParseTree) -> Variable:
        name, category = map(_word, tree.children)
        return Variable(name, category)


def _words(tree: ParseTree | Token) -> list[str]:
    """The names of a primitive, which is one token unless there is a comment inside."""
    if isinstance(tree, Token):
        return [_plain(name) for name in _NAME.findall(tree)]
    return [_word(token) for token in tree.children]


def _place_of_name(primitive: ParseTree | Token, index: int) -> int:
    """The offset of the predicate (0) or an argument (from 1 on)."""
    if isinstance(primitive, Token):
        return start(primitive) + list(_NAME.finditer(primitive))[index].start()
    return start(primitive.children[index])


def _declared(tree: ParseTree | Token) -> list[Declaration]:
    """The objects of a declaration, which may be one token: a name, a hyphen and a category."""
    *names, category = _children(tree)
    if not names:
        name, _, category_name = _NAME.findall(str(category))
        return [Declaration(_plain(name), _plain(category_name))]
    return [Declaration(_word(name), _word(category)) for name in names]


def _children(tree: ParseTree | Token) -> list[ParseTree | Token]:
    return [] if isinstance(tree, Token) else tree.children


def _word(token: ParseTree | Token) -> str:
    """A word without what marks variables, in lower case."""
    return _plain(str(token))


def _plain(word: str) -> str:
    return word.lower().strip("?")
