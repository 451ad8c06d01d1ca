"""BDDL, the language of BEHAVIOR's activity definitions: conditions and whole problem files.

A name with a ``?`` is a variable if a quantifier around it binds it, otherwise the object of that name.
Everything is lower case, as in bddl's own reader (``bddl/parsing.py``).
"""

from __future__ import annotations

from dataclasses import dataclass

from lark import Token

from eai.logic.formula import And, Atom, Formula, Occurs, Variable
from eai.logic.grammar import ParseTree, error_at, parse_tree
from eai.logic.reader import FormulaReader, Reading, start, term
from eai.logic.signature import Signature

GRAMMAR = "bddl.lark"

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
        tuple(
            Declaration(_word(thing), _word(_children(declaration)[-1]))
            for declaration in by_rule["objects"]
            for thing in _children(declaration)[:-1]
        ),
        tuple(reader.reading(fact).formula for fact in by_rule["init"]),
        reader.reading(by_rule["goal"][0]).formula,
    )


class _BddlReader(FormulaReader):
    def primitive(self, tree: ParseTree | Token, scope: frozenset[str]) -> Formula:
        tokens = _children(tree)
        name, *arguments = map(_word, tokens)
        terms = tuple([term(argument, scope) for argument in arguments])
        if self._signature is None:
            return Atom(name, terms)
        self._checker.check(name, terms, lambda index: start(tokens[index]))
        return Occurs(name, terms) if self._signature.is_action(name) else Atom(name, terms)

    def variable(self, tree: ParseTree) -> Variable:
        name, category = map(_word, tree.children)
        return Variable(name, category)


def _children(tree: ParseTree | Token) -> list[ParseTree | Token]:
    return [] if isinstance(tree, Token) else tree.children


def _word(token: ParseTree | Token) -> str:
    """A word without what marks variables, in lower case."""
    return str(token).lower().strip("?")
