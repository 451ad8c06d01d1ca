"""Find the offset of a mistake: the position of a violation (`PddlFinding`) in a text of PDDL or BDDL."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import islice
from typing import Final

import eai.pddl.model as m
from eai.pddl.check import PddlDeclarations, PddlFinding, PddlViolationKind
from eai.pddl.reader import ExpressionList, SExpr, Symbol, get_first_word

_SECTIONS: Final[Mapping[str, str]] = {
    "objects": ":objects",
    "initial state": ":init",
    "goal": ":goal",
    "predicates": ":predicates",
    "predicate": ":predicates",
    "operators": ":action",
    "parameters": ":action",
    "precondition": ":action",
    "effect": ":action",
    "condition": ":derived",
    "derived predicate": ":derived",
}
"""Mapping from words for the place of a mistake (`PddlFinding.place`) to the keywords of PDDL sections."""

_NAMED_SECTIONS: Final = frozenset({":action", ":derived"})
"""Keywords of sections that begin with a name and can occur several times."""

_QUANTIFIERS: Final = frozenset({"forall", "exists", "forn", "forpairs", "fornpairs"})


def find_offset_of_finding(
    finding: PddlFinding, definition: ExpressionList, vocabulary: PddlDeclarations
) -> int:
    """Return the offset in a text of the mistake that a finding describes.

    A mistake without a position, such as a missing name, has the offset of its section.

    Args:
        finding: the finding: a violation with the wrong name and its location in words.
        definition: the expression ``(define ...)`` of the text.
        vocabulary: the names that the text may use.
    """
    sections = list(_find_expressions_at_location(definition, finding.place))
    offsets = (
        offset for section in sections for offset in _find_mistake_offsets(section, finding, vocabulary)
    )
    allowed = 1 if finding.offence is PddlViolationKind.DUPLICATE else 0
    return next(islice(offsets, allowed, None), sections[0].offset if sections else definition.offset)


def _find_expressions_at_location(definition: ExpressionList, location_in_words: str) -> Iterator[SExpr]:
    """Yield the expressions at a location that is given in words, such as ``effect of move``."""
    kind, _, name = location_in_words.partition(" of ")
    if not name and location_in_words not in _SECTIONS:
        kind, _, name = location_in_words.rpartition(" ")
    wanted = _SECTIONS.get(kind, location_in_words)
    for section in definition.items:
        if not isinstance(section, ExpressionList) or get_first_word(section) != wanted:
            continue
        if wanted not in _NAMED_SECTIONS or not name:
            yield section
        elif _list_names(section.items[1:2]) == [name]:
            parts = zip(section.items, section.items[1:], strict=False)
            values = [value for key, value in parts if _list_names([key]) == [f":{kind}"]]
            yield from values or [section]


def _list_names(items: tuple[SExpr, ...] | list[SExpr]) -> list[str]:
    """Return the words among items of an expression, and the first word of each list among the items."""
    return [item.text if isinstance(item, Symbol) else get_first_word(item) for item in items]


def _find_mistake_offsets(
    section: SExpr, finding: PddlFinding, vocabulary: PddlDeclarations
) -> Iterator[int]:
    """Yield the offsets of the mistakes of one finding in a PDDL section, outer lists first."""
    name = finding.name
    declared = vocabulary.predicates.get(name)
    arity = None if declared is None else len(declared.parameters)
    unknown = {
        symbol for symbol in m.list_alternatives_of_either_type(name) if symbol not in vocabulary.parents
    }
    for group, bound in _walk_lists_with_bound_names(section, frozenset()):
        head, arguments = get_first_word(group), group.items[1:]
        match finding.offence:
            case PddlViolationKind.UNKNOWN_PREDICATE if head == name:
                yield group.items[0].offset
            case PddlViolationKind.WRONG_ARITY if head == name and len(arguments) != arity:
                yield group.items[0].offset
            case PddlViolationKind.UNDECLARED_CONSTANT | PddlViolationKind.UNBOUND_VARIABLE:
                spelt = {name} if finding.offence is PddlViolationKind.UNDECLARED_CONSTANT else set[str]()
                spelt |= {f"?{name}"} - bound
                symbols = (symbol for symbol in arguments if isinstance(symbol, Symbol))
                yield from (symbol.offset for symbol in symbols if symbol.text in spelt)
            case PddlViolationKind.UNKNOWN_TYPE:
                yield from (
                    symbol.offset
                    for symbol in _find_type_names(group)
                    if symbol.text.removeprefix("-") in unknown
                )
            case PddlViolationKind.DUPLICATE | PddlViolationKind.MALFORMED:
                yield from _find_declaration_offsets(group, name)


def _walk_lists_with_bound_names(
    expression: SExpr, bound: frozenset[str]
) -> Iterator[tuple[ExpressionList, frozenset[str]]]:
    """Yield all lists in an expression, each with the variables that quantifiers around it bind."""
    if isinstance(expression, ExpressionList):
        yield expression, bound
        inner = bound
        if get_first_word(expression) in _QUANTIFIERS:
            lists = [item for item in expression.items[:-1] if isinstance(item, ExpressionList)]
            inner = bound.union(*(_list_names(variable_list.items) for variable_list in lists))
        for item in expression.items:
            yield from _walk_lists_with_bound_names(item, inner)


def _find_type_names(group: ExpressionList) -> Iterator[Symbol]:
    """Yield the names of types in a typed list: after a hyphen, or as alternatives."""
    if get_first_word(group) == "either":
        yield from (item for item in group.items[1:] if isinstance(item, Symbol))
    for before, item in zip(group.items, group.items[1:], strict=False):
        if isinstance(item, Symbol) and (_list_names([before]) == ["-"] or item.text.startswith("-")):
            yield item


def _find_declaration_offsets(group: ExpressionList, name: str) -> Iterator[int]:
    """Yield the offsets at which a list declares an operator, a predicate, a parameter or an object."""
    words = (name, f"?{name}")
    match group.items:
        case (Symbol(":action"), Symbol(word) as symbol, *_):
            if word == name:
                yield symbol.offset
        case (Symbol(":predicates"), *predicates):
            yield from (predicate.offset for predicate in predicates if _list_names([predicate]) == [name])
        case _:
            pairs = zip((None, *group.items), group.items, strict=False)
            for before, item in pairs:
                is_type = before is not None and _list_names([before]) == ["-"]
                if isinstance(item, Symbol) and item.text in words and not is_type:
                    yield item.offset
