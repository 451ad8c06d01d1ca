"""Read problem files in BDDL, a language that defines household activities.

Words are separated by spaces and parentheses. A semicolon begins a comment that ends with its line. A name
with a ``?`` is a variable if a quantifier around it binds it, and otherwise the object of that name.
Everything is lower case, as in bddl's own reader (``bddl/parsing.py``).
"""

from __future__ import annotations

import re
from functools import cached_property
from typing import Final

import eai.logic.formula as f
from eai.base.errors import InputError, ParseError, did_you_mean
from eai.logic.ltl_printer import format_ltl
from eai.logic.signature import find_line_and_column, make_parse_error, make_term
from eai.logic.traversal import MAX_COUNT_DIGITS, MAX_FORMULA_DEPTH
from eai.pddl.model import PddlProblem, TypedName

_TOKEN: Final = re.compile(r"[()]|[^\s();]+|;[^\n]*")
_COUNT: Final = re.compile(r"[0-9]+")

_END: Final = ""
"""Token that stands after the last token of the text."""

_ENDS_OF_WORDS: Final = frozenset({"(", ")", _END})

_ENDS_OF_ARGUMENTS: Final = _ENDS_OF_WORDS | {"-"}
"""Tokens that end a list of arguments.

A hyphen belongs before a category, not among arguments. So a list that ends at a hyphen lacks its closing
parenthesis.
"""

_SECTIONS: Final = frozenset({":domain", ":requirements", ":objects", ":init", ":goal"})

_CONNECTIVES: Final = frozenset({"and", "or", "not", "imply"})

_QUANTIFIERS: Final = frozenset({"forall", "exists", "forn", "forpairs", "fornpairs"})


def parse_problem(text: str) -> PddlProblem:
    """Read the text of a problem file; line ends and comments do not matter.

    The type of an object is its category, a synset such as ``candle.n.01``.

    Raises:
        ParseError: the text is not a problem file, has not exactly one domain, objects, init and goal
            section, or is nested too deep (`traversal.MAX_FORMULA_DEPTH`).
        InputError: an initial fact is neither an atom nor a negated atom.
    """
    return _BddlReader(text).read_problem()


class _BddlReader:
    """Reads one BDDL text token by token. A scope is the set of variables that enclosing quantifiers bind."""

    def __init__(self, text: str) -> None:
        self._text = text
        self._tokens: list[str] = [token for token in _TOKEN.findall(text.lower()) if token[0] != ";"]
        self._tokens.append(_END)
        self._next = 0

    def read_problem(self) -> PddlProblem:
        """Return the problem that the whole text defines."""
        domains: list[str] = []
        objects: list[tuple[TypedName, ...]] = []
        facts: list[tuple[tuple[f.Atom, ...], tuple[f.Atom, ...]]] = []
        goals: list[f.Formula] = []
        for token in ("(", "define", "("):
            self._consume_required_token(token)
        self._consume_required_token(
            "problem", "'problem', as this is a domain" if self._is_next_token("domain") else ""
        )
        name = self._read_word()
        self._consume_required_token(")")
        while self._has_next_sublist_else_read_list_end():
            match self._read_section_keyword():
                case ":domain":
                    domains.append(self._read_word())
                    self._consume_required_token(")")
                case ":objects":
                    objects.append(self._read_declarations())
                case ":init":
                    facts.append(self._read_atoms_and_negated_atoms())
                case ":goal":
                    goals.append(self._read_condition())
                    self._consume_required_token(")")
                case _:
                    self._read_arguments()
        self._consume_required_token(_END, "the end")
        for section, sections in (
            ("domain", domains),
            ("objects", objects),
            ("init", facts),
            ("goal", goals),
        ):
            if len(sections) != 1:
                raise make_parse_error(self._text, len(self._text), f"exactly one ':{section}' section")
        initial, denied = facts[0]
        return PddlProblem(name, domains[0], objects[0], initial, denied, goals[0])

    def _read_section_keyword(self) -> str:
        """Read the keyword at the beginning of a section, such as ``:init``."""
        self._consume_required_token("(")
        keyword = self._tokens[self._next]
        if keyword not in _SECTIONS:
            raise self._make_error(
                expected=f"':domain', ':objects', ':init' or ':goal'{did_you_mean(keyword, _SECTIONS)}"
            )
        self._next += 1
        return keyword

    def _read_declarations(self) -> tuple[TypedName, ...]:
        """Read groups of names up to the closing parenthesis.

        Each group is followed by a hyphen and a category.
        """
        declarations: list[TypedName] = []
        while not self._is_next_token(")"):
            names = [self._read_name_in_typed_list("a name or ')'")]
            while not self._tokens[self._next].startswith("-"):
                names.append(self._read_name_in_typed_list("a name or '-'"))
            category = self._read_category()
            declarations += [TypedName(name, category) for name in names]
        self._consume_required_token(")")
        return tuple(declarations)

    def _read_name_in_typed_list(self, expected: str) -> str:
        word = self._read_word(expected)
        if word.endswith("-"):
            self._next -= 1
            raise self._make_error(expected=f"a space before the hyphen, as in {word[:-1]} - CATEGORY")
        return word

    def _read_category(self) -> str:
        """Read the category after a hyphen; a space between them is optional."""
        token = self._tokens[self._next]
        if len(token) > 1 and token.startswith("-"):
            self._next += 1
            return _strip_question_marks(token[1:])
        self._consume_required_token("-")
        return self._read_word()

    def _is_next_token(self, token: str) -> bool:
        return self._tokens[self._next] == token

    def _read_atoms_and_negated_atoms(self) -> tuple[tuple[f.Atom, ...], tuple[f.Atom, ...]]:
        """Read facts and the closing parenthesis; return the atoms and the negated atoms."""
        initial, denied = list[f.Atom](), list[f.Atom]()
        while self._has_next_sublist_else_read_list_end():
            offset = self._token_offsets[self._next]
            match self._read_condition():
                case f.Atom() as atom:
                    initial.append(atom)
                case f.Not(f.Atom() as atom):
                    denied.append(atom)
                case other:
                    line, _ = find_line_and_column(self._text, offset)
                    raise InputError(f"line {line}: expected a fact, not {format_ltl(other)}")
        return tuple(initial), tuple(denied)

    def _read_conditions(
        self, scope: frozenset[str] = frozenset(), levels: int = MAX_FORMULA_DEPTH
    ) -> tuple[f.Formula, ...]:
        """Read conditions and the closing parenthesis."""
        conditions: list[f.Formula] = []
        while self._has_next_sublist_else_read_list_end():
            conditions.append(self._read_condition(scope, levels))
        return tuple(conditions)

    def _read_condition(
        self, scope: frozenset[str] = frozenset(), levels: int = MAX_FORMULA_DEPTH
    ) -> f.Formula:
        """Read a condition that is nested at most `levels` deep."""
        if levels == 0 and self._tokens[self._next] == "(":
            raise self._make_error(expected=f"a condition with at most {MAX_FORMULA_DEPTH} levels of nesting")
        self._consume_required_token("(")
        keyword = self._tokens[self._next]
        if keyword in _CONNECTIVES:
            self._next += 1
            return self._read_connective(keyword, scope, levels - 1)
        if keyword in _QUANTIFIERS:
            self._next += 1
            return self._read_quantifier(keyword, scope, levels - 1)
        return self._read_primitive(scope)

    def _read_connective(self, connective: str, scope: frozenset[str], levels: int) -> f.Formula:
        """Read the parts of a connective and the closing parenthesis."""
        if connective in ("and", "or"):
            return (f.And if connective == "and" else f.Or)(self._read_conditions(scope, levels))
        first = self._read_condition(scope, levels)
        second = self._read_condition(scope, levels) if connective == "imply" else None
        self._consume_required_token(")")
        return f.Not(first) if second is None else f.Implies(first, second)

    def _read_quantifier(self, quantifier: str, scope: frozenset[str], levels: int) -> f.Formula:
        """Read the variables and body of a quantifier and the closing parenthesis."""
        count = self._read_count() if quantifier in ("forn", "fornpairs") else None
        variable = self._read_variable()
        second = self._read_variable() if quantifier.endswith("pairs") else None
        bound = {variable.name} if second is None else {variable.name, second.name}
        body = self._read_condition(scope | bound, levels)
        self._consume_required_token(")")
        if second is not None:
            return f.ForPairs(variable, second, body, count)
        if count is not None:
            return f.Exactly(count, variable, body)
        return f.ForAll(variable, body) if quantifier == "forall" else f.Exists(variable, body)

    def _read_count(self) -> int:
        self._consume_required_token("(")
        digits = self._tokens[self._next]
        if not _COUNT.fullmatch(digits):
            raise self._make_error(expected="the number of objects")
        if len(digits) > MAX_COUNT_DIGITS:
            raise self._make_error(expected=f"a number of at most {MAX_COUNT_DIGITS} digits")
        self._next += 1
        self._consume_required_token(")")
        return int(digits)

    def _read_variable(self) -> f.Variable:
        self._consume_required_token("(")
        name = self._read_word()
        category = self._read_category()
        self._consume_required_token(")")
        return f.Variable(name, category)

    def _read_primitive(self, scope: frozenset[str]) -> f.Formula:
        """Read a predicate with its arguments, and the closing parenthesis."""
        name = self._read_word("a name or a connective")
        return f.Atom(name, tuple([make_term(argument, scope) for argument in self._read_arguments()]))

    def _read_arguments(self) -> list[str]:
        """Read arguments and the closing parenthesis."""
        start = self._next
        while self._tokens[self._next] not in _ENDS_OF_ARGUMENTS:
            self._next += 1
        words = [_strip_question_marks(token) for token in self._tokens[start : self._next]]
        self._consume_required_token(")", "a name or ')'")
        return words

    def _read_word(self, expected: str = "a name") -> str:
        token = self._tokens[self._next]
        if token in _ENDS_OF_WORDS:
            raise self._make_error(expected=expected)
        self._next += 1
        return _strip_question_marks(token)

    def _has_next_sublist_else_read_list_end(self) -> bool:
        """Whether the next token opens a list. A closing parenthesis is consumed, an opening one is not."""
        if self._tokens[self._next] == "(":
            return True
        self._consume_required_token(")", "'(' or ')'")
        return False

    def _consume_required_token(self, token: str, expected: str = "") -> None:
        """Read the expected token, or raise an error if another token stands here."""
        if self._tokens[self._next] != token:
            raise self._make_error(expected=expected or f"'{token}'")
        self._next += 1

    def _make_error(self, *, expected: str) -> ParseError:
        return make_parse_error(self._text, self._token_offsets[self._next], expected)

    @cached_property
    def _token_offsets(self) -> list[int]:
        """The offset of each token in the text, in characters."""
        offsets = [match.start() for match in _TOKEN.finditer(self._text) if match[0][0] != ";"]
        return [*offsets, len(self._text)]


def _strip_question_marks(word: str) -> str:
    """Return the name of a variable without the question marks before it."""
    return word.strip("?")
