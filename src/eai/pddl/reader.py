"""Read PDDL text into values (`model`); the reverse of `writer`.

Reading only checks that connectives have the right number of parts and that lists of variables are lists;
`check` tests the names. The type ``object`` is no restriction and is dropped. A quantifier over several
variables becomes nested quantifiers, and a quantifier without variables becomes its body. Unreadable text
raises a `PddlError` with the violation and its position. The parentheses are read first, as a tree of
S-expressions, each with its offset.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import zip_longest
from typing import TypeAlias

import eai.logic.formula as f
import eai.pddl.model as m
from eai.base.errors import did_you_mean
from eai.logic.signature import find_line_and_column, join_with_or
from eai.logic.traversal import wrap_in_quantifiers
from eai.pddl.check import PddlError, PddlViolationKind

_WORD = re.compile(r"[()]|\??[^\s();?]+|\?|;[^\n]*")

MAX_DEPTH = 100
"""Maximum nesting depth of parentheses. The deepest text in the paper's data set has a depth of 9."""


@dataclass(slots=True, eq=False)
class Symbol:
    """A word in lower case, because PDDL ignores case. ``offset`` is the index of its first character."""

    text: str
    offset: int


@dataclass(slots=True, eq=False)
class ExpressionList:
    """A parenthesised list. It begins at ``offset``, and ``end`` is the offset after its last character."""

    items: tuple[SExpr, ...]
    offset: int
    end: int


SExpr: TypeAlias = Symbol | ExpressionList


def make_pddl_error(text: str, offset: int, offence: PddlViolationKind, expected: str) -> PddlError:
    """Return a `PddlError` that states the position of an offset in a text."""
    return PddlError(offence, *find_line_and_column(text, offset), expected)


def read_group(text: str) -> ExpressionList:
    """Return the first expression of a text, which must be a parenthesised list.

    Raises:
        PddlError: the text has no such list, or the list is unbalanced.
    """
    expression = _read_expression(text)
    if not isinstance(expression, ExpressionList):
        raise make_pddl_error(
            text,
            len(text) if expression is None else expression.offset,
            PddlViolationKind.MALFORMED,
            "a parenthesised list",
        )
    return expression


def _read_expression(text: str) -> SExpr | None:
    """Return the first expression of a text, or None if the text has no expression."""
    pending: list[tuple[int, list[SExpr]]] = []
    for match in _WORD.finditer(text):
        word, place = match.group(), match.start()
        node: SExpr
        if word == "(":
            pending.append((place, []))
            if len(pending) > MAX_DEPTH:
                raise make_pddl_error(
                    text, place, PddlViolationKind.MALFORMED, f"at most {MAX_DEPTH} nested parentheses"
                )
            continue
        if word.startswith(";"):
            continue
        if word != ")":
            node = Symbol(word.lower(), place)
        elif pending:
            start, items = pending.pop()
            node = ExpressionList(tuple(items), start, match.end())
        else:
            raise make_pddl_error(
                text, place, PddlViolationKind.UNBALANCED, "no closing parenthesis without an opening one"
            )
        if not pending:
            return node
        pending[-1][1].append(node)
    if pending:
        raise make_pddl_error(
            text, pending[-1][0], PddlViolationKind.UNBALANCED, "a partner for this opening parenthesis"
        )
    return None


def find_start_of_unclosed_section(text: str) -> int | None:
    """Return the offset of the first section that begins inside another section, or None.

    The text probably lacks the closing parenthesis of the outer section.
    """
    depth, before = 0, ""
    for match in _WORD.finditer(text):
        word = match.group()
        if word.startswith(";"):
            continue
        if before == "(" and word.startswith(":") and depth > _DEPTH_OF_SECTIONS:
            return text.rindex("(", 0, match.start())
        depth += (word == "(") - (word == ")")
        before = word
    return None


_DEPTH_OF_SECTIONS = 2

CONNECTIVES = frozenset({"and", "or", "not", "imply", "forall", "exists", "when", "="})


def read_domain(text: str) -> m.PddlDomain:
    """Return the domain that a text defines."""
    return PddlReader(text).read_domain_definition(read_group(text))


def read_problem(text: str) -> m.PddlProblem:
    """Return the problem that a text defines."""
    return PddlReader(text).read_problem_definition(read_group(text))


def read_action(text: str) -> m.PddlAction:
    """Return the operator ``(:action ...)`` at the beginning of a text."""
    return PddlReader(text).read_action_definition(read_group(text))


class PddlReader:
    """Converts expressions of one text to values.

    Args:
        text: the text, for positions of errors.
        is_file: whether to accept syntax of files: variables with alternative types, and ``-t`` for ``- t``.
    """

    def __init__(self, text: str, *, is_file: bool = False) -> None:
        self._text = text
        self._is_file = is_file

    def _make_error(
        self, node: SExpr, expected: str, offence: PddlViolationKind = PddlViolationKind.MALFORMED
    ) -> PddlError:
        return make_pddl_error(self._text, node.offset, offence, expected)

    def read_domain_definition(self, group: ExpressionList) -> m.PddlDomain:
        """Return the domain of ``(define (domain ...) ...)``."""
        name, sections = self._read_definition(group, "domain")
        actions = [
            self.read_action_definition(section)
            for section in sections
            if get_first_word(section) == ":action"
        ]
        return m.PddlDomain(
            name=name,
            requirements=tuple(
                self._require_word(item).text for item in _find_section_items(sections, ":requirements")
            ),
            types=_add_supertypes(self._read_typed_names(_find_section_items(sections, ":types"))),
            constants=self._read_typed_names(_find_section_items(sections, ":constants")),
            predicates=tuple(
                self._read_predicate(item) for item in _find_section_items(sections, ":predicates")
            ),
            actions=tuple(actions),
            axioms=tuple(
                self._read_axiom(section) for section in sections if get_first_word(section) == ":derived"
            ),
        )

    def read_problem_definition(self, group: ExpressionList) -> m.PddlProblem:
        """Return the problem of ``(define (problem ...) ...)``."""
        name, sections = self._read_definition(group, "problem")
        facts = [self._read_literal(item) for item in _find_section_items(sections, ":init")]
        goals = [self.read_condition_or_empty(item) for item in _find_section_items(sections, ":goal")]
        return m.PddlProblem(
            name=name,
            domain=" ".join(
                self._require_word(item).text for item in _find_section_items(sections, ":domain")
            ),
            objects=self._read_typed_names(_find_section_items(sections, ":objects")),
            initial=tuple(fact for fact in facts if isinstance(fact, f.Atom)),
            denied=tuple(
                fact.operand for fact in facts if isinstance(fact, f.Not) and isinstance(fact.operand, f.Atom)
            ),
            goal=goals[0] if len(goals) == 1 else f.And(tuple(goals)),
        )

    def read_action_definition(self, group: ExpressionList) -> m.PddlAction:
        """Return the operator of ``(:action name :parameters (...) :precondition ... :effect ...)``."""
        if get_first_word(group) != ":action" or len(group.items) < 2:
            raise self._make_error(group, "(:action NAME ...)")
        name = self._require_word(group.items[1])
        if name.text.startswith(":"):
            raise self._make_error(name, f"the name of an action, not {name.text}")
        parts = self._read_action_parts(group.items[2:])
        return m.PddlAction(
            name=name.text,
            parameters=self.read_variables(parts.get(":parameters", _EMPTY)),
            precondition=self.read_condition_or_empty(parts.get(":precondition", _EMPTY)),
            effect=self.read_effect_or_empty(parts.get(":effect", _EMPTY)),
        )

    def _read_action_parts(self, items: Sequence[SExpr]) -> dict[str, SExpr]:
        parts: dict[str, SExpr] = {}
        for key, value in zip_longest(items[::2], items[1::2]):
            word = self._require_word(key).text
            if word not in _PARTS_OF_ACTION:
                expected = (
                    f"{join_with_or(_PARTS_OF_ACTION)}, not {word}{did_you_mean(word, _PARTS_OF_ACTION)}"
                )
                raise self._make_error(key, expected)
            if word in parts:
                raise self._make_error(key, f"{word} once only")
            if value is None or (isinstance(value, Symbol) and value.text in _PARTS_OF_ACTION):
                raise self._make_error(key, f"a list after {word}")
            parts[word] = value
        return parts

    def read_condition_or_empty(self, expression: SExpr) -> f.Formula:
        """Return the formula of a whole condition; like `read_formula`, but ``()`` is read as true."""
        if isinstance(expression, ExpressionList) and not expression.items:
            return f.TRUE
        return self.read_formula(expression)

    def read_effect_or_empty(self, expression: SExpr) -> m.PddlEffect:
        """Return the whole effect of an operator; like `read_effect`, but ``()`` is read as no effect."""
        if isinstance(expression, ExpressionList) and not expression.items:
            return m.NO_EFFECT
        return self.read_effect(expression)

    def read_formula(self, expression: SExpr) -> f.Formula:
        """Read a condition, a goal or a part of either in PDDL, and return it as a formula."""
        group, head = self._require_list_and_first_word(expression)
        match head:
            case "and":
                return f.And(tuple(map(self.read_formula, group.items[1:])))
            case "or":
                return f.Or(tuple(map(self.read_formula, group.items[1:])))
            case "not":
                return f.Not(self.read_formula(self._require_parts(group, 1)[0]))
            case "imply":
                premise, conclusion = self._require_parts(group, 2)
                return f.Implies(self.read_formula(premise), self.read_formula(conclusion))
            case "forall" | "exists":
                names, body = self._require_parts(group, 2)
                quantifier = f.ForAll if head == "forall" else f.Exists
                part = self.read_formula(body)
                return wrap_in_quantifiers(quantifier, self.read_variables(names), part)
            case "=":
                left, right = self._require_parts(group, 2)
                return f.Equals(self._read_term(left), self._read_term(right))
            case "when":
                raise self._make_error(
                    group, "a condition, not (when ...)", PddlViolationKind.EFFECT_IN_CONDITION
                )
            case _:
                return self._read_atom(group)

    def read_effect(self, expression: SExpr) -> m.PddlEffect:
        """Return the effect that an expression describes."""
        group, head = self._require_list_and_first_word(expression)
        match head:
            case "and":
                return m.AndEffect(tuple(map(self.read_effect, group.items[1:])))
            case "when":
                condition, part = self._require_parts(group, 2)
                return m.WhenEffect(self.read_condition_or_empty(condition), self.read_effect(part))
            case "forall":
                names, body = self._require_parts(group, 2)
                result = self.read_effect(body)
                return wrap_in_quantifiers(m.ForAllEffect, self.read_variables(names), result)
            case "not":
                negated, inner = self._require_list_and_first_word(self._require_parts(group, 1)[0])
                if inner not in CONNECTIVES:
                    return m.Delete(self._read_atom(negated))
                raise self._make_error(negated, "an atom in (not ...)", PddlViolationKind.CONDITION_IN_EFFECT)
            case "or" | "exists" | "imply" | "=":
                raise self._make_error(
                    group, f"an effect, not ({head} ...)", PddlViolationKind.CONDITION_IN_EFFECT
                )
            case _:
                return m.Add(self._read_atom(group))

    def read_variables(self, expression: SExpr) -> tuple[f.Variable, ...]:
        """Return the variables of a typed list."""
        if not isinstance(expression, ExpressionList):
            raise self._make_error(expression, "a parenthesised list of variables")
        variables = []
        for symbol, category in self._read_typed_list(expression.items):
            if not _is_variable(symbol.text):
                raise self._make_error(symbol, "a variable, as in ?x")
            variables.append(f.Variable(symbol.text[1:], None if category == m.OBJECT else category))
        return tuple(variables)

    def _read_definition(self, group: ExpressionList, kind: str) -> tuple[str, Sequence[ExpressionList]]:
        match group.items[:2]:
            case (Symbol("define"), ExpressionList((Symbol(word), Symbol(name)))) if word == kind:
                return name, [section for section in group.items[2:] if isinstance(section, ExpressionList)]
            case _:
                raise self._make_error(group, f"(define ({kind} NAME) ...)")

    def _read_predicate(self, expression: SExpr) -> m.PddlPredicate:
        group, head = self._require_list_and_first_word(expression)
        return m.PddlPredicate(
            head, self.read_variables(ExpressionList(group.items[1:], group.offset, group.end))
        )

    def _read_axiom(self, section: ExpressionList) -> m.PddlAxiom:
        if len(section.items) != 3:
            raise self._make_error(section, "(:derived (NAME ...) CONDITION)")
        head = self._read_predicate(section.items[1])
        return m.PddlAxiom(head.name, head.parameters, self.read_condition_or_empty(section.items[2]))

    def _read_literal(self, expression: SExpr) -> f.Formula:
        formula = self.read_formula(expression)
        if isinstance(formula.operand if isinstance(formula, f.Not) else formula, f.Atom):
            return formula
        raise self._make_error(
            expression, "an atom or a negated atom in :init", PddlViolationKind.UNSUPPORTED
        )

    def _read_atom(self, group: ExpressionList) -> f.Atom:
        if self._is_file and any(isinstance(item, ExpressionList) for item in group.items[1:]):
            head = self._require_word(group.items[0])
            expected = f"a connective or a predicate of names, not ({head.text} ...)"
            raise self._make_error(head, expected + did_you_mean(head.text, sorted(CONNECTIVES)))
        return f.Atom(self._require_word(group.items[0]).text, tuple(map(self._read_term, group.items[1:])))

    def _read_term(self, expression: SExpr) -> f.Term:
        name = self._require_word(expression).text
        return f.Variable(name[1:]) if _is_variable(name) else f.Constant(name)

    def _read_typed_names(self, items: Sequence[SExpr]) -> tuple[m.TypedName, ...]:
        return tuple(
            m.TypedName(symbol.text, category or m.OBJECT)
            for symbol, category in self._read_typed_list(items)
        )

    def _read_typed_list(self, items: Sequence[SExpr]) -> list[tuple[Symbol, str | None]]:
        """Read ``a b - t c`` as [(a, t), (b, t), (c, None)]."""
        typed: list[tuple[Symbol, str | None]] = []
        waiting: list[Symbol] = []
        rest = iter(items)
        for item in rest:
            symbol = self._require_word(item)
            is_joined = self._is_file and symbol.text.startswith("-") and symbol.text != "-"
            if symbol.text != "-" and not is_joined:
                if self._is_file and symbol.text.endswith("-"):
                    raise self._make_error(
                        symbol, f"a space before the hyphen, as in {symbol.text[:-1]} - TYPE"
                    )
                waiting.append(symbol)
                continue
            category = Symbol(symbol.text[1:], symbol.offset + 1) if is_joined else next(rest, None)
            if category is None:
                raise self._make_error(symbol, "a type behind the hyphen")
            kind = self._read_type(category, of_variables=any(_is_variable(name.text) for name in waiting))
            typed += [(name, kind) for name in waiting]
            waiting.clear()
        return [*typed, *[(name, None) for name in waiting]]

    def _read_type(self, category: SExpr, *, of_variables: bool) -> str:
        match category:
            case Symbol(name):
                return name
            case ExpressionList((Symbol("either"), *types)) if self._is_file and of_variables and types:
                return m.write_either_type([self._require_word(alternative).text for alternative in types])
            case _:
                raise self._make_error(category, "one type name (no either)", PddlViolationKind.UNSUPPORTED)

    def _require_parts(self, group: ExpressionList, count: int) -> tuple[SExpr, ...]:
        if len(group.items) != count + 1:
            head = self._require_word(group.items[0]).text
            raise self._make_error(group, f"{count} part(s) of ({head} ...)")
        return group.items[1:]

    def _require_list_and_first_word(self, expression: SExpr) -> tuple[ExpressionList, str]:
        """Return an expression, which must be a non-empty list, together with its first word."""
        if isinstance(expression, ExpressionList) and expression.items:
            return expression, self._require_word(expression.items[0]).text
        raise self._make_error(expression, "a non-empty parenthesised list")

    def _require_word(self, expression: SExpr) -> Symbol:
        if isinstance(expression, Symbol):
            return expression
        raise self._make_error(expression, "a word, not a list")


def _add_supertypes(types: tuple[m.TypedName, ...]) -> tuple[m.TypedName, ...]:
    """Return the declared types, followed by types that the text only uses as supertypes."""
    named = dict.fromkeys(declared.name for declared in types)
    above = dict.fromkeys(
        declared.type for declared in types if declared.type not in named and declared.type != m.OBJECT
    )
    return (*types, *map(m.TypedName, above))


_EMPTY = ExpressionList((), 0, 0)
_PARTS_OF_ACTION = (":parameters", ":precondition", ":effect")


def _is_variable(name: str) -> bool:
    return name.startswith("?")


def get_first_word(group: ExpressionList) -> str:
    """Return the first word of a list, or an empty text."""
    return group.items[0].text if group.items and isinstance(group.items[0], Symbol) else ""


def _find_section_items(sections: Sequence[ExpressionList], keyword: str) -> list[SExpr]:
    """Return the items of all sections with a keyword, without the keyword itself."""
    return [item for section in sections if get_first_word(section) == keyword for item in section.items[1:]]
