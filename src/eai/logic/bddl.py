"""BDDL, the language of household activity definitions: conditions and whole problem files.

A name with a ``?`` is a variable if a quantifier around it binds it, otherwise the object of that name.
Everything is lower case, as in bddl's own reader (``bddl/parsing.py``).
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from lark import Token

import eai.logic.formula as f
from eai.logic.grammar import ParseTree, error_at, parse_tree
from eai.logic.signature import NameChecker, Reading, Signature, term
from eai.logic.traversal import MAX_COUNT_DIGITS, MAX_DEPTH

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
    init: tuple[f.Formula, ...]
    goal: f.Formula

    @property
    def goals(self) -> tuple[f.Formula, ...]:
        """The goal's top-level conjuncts, which are counted one by one."""
        return self.goal.operands if isinstance(self.goal, f.And) else (self.goal,)


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


class _BddlReader:
    """Turns parse trees of one text into formulas, top down: only quantifiers know what is a variable."""

    def __init__(self, text: str, signature: Signature | None = None) -> None:
        self._text = text
        self._signature = signature
        self._checker = NameChecker(text, signature)

    def reading(self, tree: ParseTree | Token) -> Reading:
        """The formula of a tree without variables from outside, and what is wrong with its names."""
        formula = self._read(tree, frozenset(), MAX_DEPTH)
        return Reading(formula, tuple(self._checker.offences))

    def _read(self, tree: ParseTree | Token, scope: frozenset[str], levels: int) -> f.Formula:
        """The formula of a tree that may have ``levels`` levels, below quantifiers that bind ``scope``."""
        if levels == 0:
            raise error_at(self._text, _start(tree), f"at most {MAX_DEPTH} levels of nesting")
        rule = "primitive" if isinstance(tree, Token) else str(tree.data)
        if isinstance(tree, Token) or rule == "primitive":
            return self._primitive(tree, scope)
        if rule in _QUANTIFIERS:
            return self._quantified(rule, tree, scope, levels)
        return _CONNECTIVES[rule](tuple([self._read(part, scope, levels - 1) for part in tree.children]))

    def _primitive(self, tree: ParseTree | Token, scope: frozenset[str]) -> f.Formula:
        name, *arguments = _words(tree)
        terms = tuple([term(argument, scope) for argument in arguments])
        if self._signature is None:
            return f.Atom(name, terms)
        self._checker.check(name, terms, partial(_place_of_name, tree))
        return f.Occurs(name, terms) if self._signature.is_action(name) else f.Atom(name, terms)

    def _quantified(self, rule: str, tree: ParseTree, scope: frozenset[str], levels: int) -> f.Formula:
        *head, body_tree = tree.children
        variables = [f.Variable(*map(_word, part.children)) for part in head if not isinstance(part, Token)]
        counts = [self._count(part) for part in head if isinstance(part, Token)]
        body = self._read(body_tree, scope | {variable.name for variable in variables}, levels - 1)
        return _QUANTIFIERS[rule](counts, variables, body)

    def _count(self, token: Token) -> int:
        if len(token) > MAX_COUNT_DIGITS:
            raise error_at(self._text, _start(token), f"a number of at most {MAX_COUNT_DIGITS} digits")
        return int(token)


_CONNECTIVES: dict[str, Callable[[tuple[f.Formula, ...]], f.Formula]] = {
    "conjunction": f.And,
    "disjunction": f.Or,
    "negation": lambda parts: f.Not(parts[0]),
    "implication": lambda parts: f.Implies(parts[0], parts[1]),
}

_QUANTIFIERS: dict[str, Callable[[list[int], list[f.Variable], f.Formula], f.Formula]] = {
    "for_all": lambda _, variables, body: f.ForAll(variables[0], body),
    "exists": lambda _, variables, body: f.Exists(variables[0], body),
    "exactly": lambda counts, variables, body: f.Exactly(counts[0], variables[0], body),
    "for_pairs": lambda _, variables, body: f.ForPairs(variables[0], variables[1], body),
    "for_n_pairs": lambda counts, variables, body: f.ForPairs(variables[0], variables[1], body, counts[0]),
}


def _start(tree: ParseTree | Token) -> int:
    """The offset of the first token of a tree that is not mere syntax; 0 if there is none."""
    while not isinstance(tree, Token):
        if not tree.children:
            return 0
        tree = tree.children[0]
    return tree.start_pos or 0


def _words(tree: ParseTree | Token) -> list[str]:
    """The names of a primitive, which is one token unless there is a comment inside."""
    if isinstance(tree, Token):
        return [_plain(name) for name in _NAME.findall(tree)]
    return [_word(token) for token in tree.children]


def _place_of_name(primitive: ParseTree | Token, index: int) -> int:
    """The offset of the predicate (0) or an argument (from 1 on)."""
    if isinstance(primitive, Token):
        return _start(primitive) + list(_NAME.finditer(primitive))[index].start()
    return _start(primitive.children[index])


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
