"""Comparing a condition or effect with the gold one as eai-eval 1.0.5 does (protocol ``eai-1.0.5``).

Reproduced is ``virtualhome_eval/simulation/evolving_graph/logic_score.py``. What differs from the paper's
"maximum bipartite matching over clauses" is listed in `_CountingQuirk`, each with the place in that file;
`matching` is what the paper says. The input is text, since two of the quirks are about text.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from enum import Enum
from typing import TypeAlias

from eai.logic.matching import maximum_matching


class _CountingQuirk(str, Enum):
    """Where the reference's counting departs from the paper. Values are names for reports."""

    TEXT_LITERALS = "text_literals"
    """``tokenize``: an atom is the text between parentheses, so variables must carry the gold names."""
    JOINED_LISTS = "joined_lists"
    """``parse_pddl_expr``: an unknown head with literals inside becomes one literal, named by its first
    word."""
    UNREADABLE_IS_FREE = "unreadable_is_free"
    """``calculate_logic_score``: a side that does not parse removes the pair: no false negatives either."""
    PADDING = "padding"
    """``align_expressions``: the shorter of two and/or lists is padded with the literal ``()``."""
    POSITIONAL_RENAMING = "positional_renaming"
    """``replace_in_tuple``: bound variables are renamed only at equal positions, as plain substrings."""
    SHORTER_LIST = "shorter_list"
    """``match_expressions``: a nested and/or matches in full when the shorter list is covered."""
    FRACTIONS_ARE_ZERO = "fractions_are_zero"
    """``match_expressions``: scores enter an integer matrix, so partial credit inside a list is lost."""
    ROW_AS_COLUMN = "row_as_column"
    """``match_expressions``: a predicted child is additional also if its index is no matched column."""
    SETS = "sets"
    """``identify_predicates``: a predicate counts once per list, and may be in all three lists."""


@dataclass(frozen=True, slots=True)
class _PredicateSets:
    """Names of the predicates that are matched, additional in the answer, and missing from it.

    A name can be in all three (`_CountingQuirk.SETS`).
    """

    matched: frozenset[str] = frozenset()
    additional: frozenset[str] = frozenset()
    missing: frozenset[str] = frozenset()


NOTHING = _PredicateSets()

_PADDING = "()"
_QUANTIFIERS = frozenset({"exists", "forall"})
_LISTS = frozenset({"and", "or"})
_ARITY = {"not": 1, "exists": 2, "forall": 2, "when": 2}
_TOKEN = re.compile(r"[()]|[^()\s][^()]*")


@dataclass(frozen=True, slots=True)
class _Node:
    """A connective (a literal is a plain string); a quantifier's first argument is its variable text."""

    head: str
    arguments: tuple[_Tree, ...]


_Tree: TypeAlias = "str | _Node"


class _UnreadableError(Exception):
    """The reference's parser gives up on a text."""


@dataclass(frozen=True, slots=True)
class _Comparison:
    """How well two trees agree, and which parts of them do and do not."""

    score: float
    matched: tuple[_Tree, ...] = ()
    additional: tuple[_Tree, ...] = ()
    missing: tuple[_Tree, ...] = ()


def compare_as_reference(predicted: str, gold: str) -> _PredicateSets:
    """The predicates of one condition or effect that match, are additional, or are missing.

    Args:
        predicted: the answer's block, one parenthesised text.
        gold: the gold block.
    """
    try:
        ours, theirs = _align(_parse(predicted), _parse(gold))
    except _UnreadableError:
        return NOTHING
    result = _compare(ours, theirs)
    return _PredicateSets(_names(result.matched), _names(result.additional), _names(result.missing))


def _parse(text: str) -> _Tree:
    stack: list[_Tree] = []
    openings: list[int] = []
    for match in _TOKEN.finditer(text):
        word = match.group().strip()
        if word == "(":
            openings.append(len(stack))
        elif word != ")":
            stack.append(word)
        elif openings:
            start = openings.pop()
            stack[start:] = [_combine(stack[start:])]
        else:
            raise _UnreadableError
    if openings or len(stack) != 1:
        raise _UnreadableError
    return stack[0]


def _combine(parts: list[_Tree]) -> _Tree:
    """One finished list as a node or, with any other head, as a joined literal."""
    if not parts:
        return _PADDING
    head, *arguments = parts
    if isinstance(head, str) and (head in _LISTS or head in _ARITY):
        if head in _ARITY and len(arguments) != _ARITY[head]:
            raise _UnreadableError
        return _Node(head, tuple(arguments))
    words = [part for part in parts if isinstance(part, str)]
    if len(words) != len(parts):
        raise _UnreadableError
    return " ".join(words)


def _align(predicted: _Tree, gold: _Tree) -> tuple[_Tree, _Tree]:
    """Pad lists and rename the gold's bound variables, from the top down to the first other connective."""
    if isinstance(predicted, str) or isinstance(gold, str):
        return predicted, gold
    if predicted.head == gold.head and predicted.head in _QUANTIFIERS:
        return predicted, _rename(gold, _bound_name(gold), _bound_name(predicted))
    if predicted.head not in _LISTS or gold.head not in _LISTS:
        return predicted, gold
    size = max(len(predicted.arguments), len(gold.arguments))
    pairs = [_align(*pair) for pair in zip(_padded(predicted, size), _padded(gold, size), strict=True)]
    ours, theirs = tuple(pair[0] for pair in pairs), tuple(pair[1] for pair in pairs)
    return _Node(predicted.head, ours), _Node(gold.head, theirs)


def _padded(node: _Node, size: int) -> tuple[_Tree, ...]:
    return node.arguments + (_PADDING,) * (size - len(node.arguments))


def _bound_name(quantifier: _Node) -> str:
    variable = quantifier.arguments[0]
    if not isinstance(variable, str):
        raise _UnreadableError
    return variable.split("-")[0].strip()


def _rename(tree: _Tree, old: str, new: str) -> _Tree:
    if isinstance(tree, str):
        return tree.replace(old, new)
    return _Node(tree.head, tuple(_rename(argument, old, new) for argument in tree.arguments))


def _compare(predicted: _Tree, gold: _Tree) -> _Comparison:
    if isinstance(predicted, str) or isinstance(gold, str):
        score = float(predicted == gold)
    elif predicted.head != gold.head:
        score = 0.0
    elif predicted.head in _LISTS:
        return _compare_lists(predicted, gold)
    else:
        score = _unit_score(predicted, gold)
    if score > 0:
        return _Comparison(score, matched=(predicted,))
    return _Comparison(score, additional=(predicted,), missing=(gold,))


def _unit_score(predicted: _Node, gold: _Node) -> float:
    """The score of two nodes with the same head that is not and/or; they match or fail as a whole."""
    match predicted.head:
        case "not":
            return _compare(predicted.arguments[0], gold.arguments[0]).score
        case "when":
            parts = zip(predicted.arguments, gold.arguments, strict=True)
            return float(all(_compare(*pair).score == 1 for pair in parts))
        case _:
            same_variable = predicted.arguments[0] == gold.arguments[0]
            return _compare(predicted.arguments[1], gold.arguments[1]).score if same_variable else 0.0


def _compare_lists(predicted: _Node, gold: _Node) -> _Comparison:
    grid = [[_compare(ours, theirs) for theirs in gold.arguments] for ours in predicted.arguments]
    edges = [[column for column, cell in enumerate(row) if int(cell.score) == 1] for row in grid]
    partner = maximum_matching(edges)
    columns = {column for column in partner if column is not None}
    shorter = min(len(predicted.arguments), len(gold.arguments))
    additional = (
        child
        for row, child in enumerate(predicted.arguments)
        if partner[row] is None or row not in columns  # CountingQuirk.ROW_AS_COLUMN
    )
    return _Comparison(
        score=len(columns) / shorter if shorter else 0.0,
        matched=tuple(
            part for row, cells in enumerate(grid) for column in edges[row] for part in cells[column].matched
        ),
        additional=tuple(additional),
        missing=tuple(child for column, child in enumerate(gold.arguments) if column not in columns),
    )


def _names(trees: Iterable[_Tree]) -> frozenset[str]:
    return frozenset(name for tree in trees for name in _predicates(tree) if name != _PADDING)


def _predicates(tree: _Tree) -> Iterator[str]:
    if isinstance(tree, str):
        yield tree.split(" ")[0]
        return
    for argument in tree.arguments[1:] if tree.head in _QUANTIFIERS else tree.arguments:
        yield from _predicates(argument)
