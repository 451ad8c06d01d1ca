"""Compare operators with gold operators (the data set's), as the paper "Embodied Agent Interface" does.

Clauses are compared. If a condition or effect is a list with a connective, each of its parts is a clause;
otherwise all of it is one clause. A clause matches an identical clause, including everything nested in it;
the order of parts does not matter. Names of variables do not matter either: parameters are matched by the
best pairing that agrees with their types, bound variables by their quantifiers.

In addition, literals are counted with partial credit, each occurrence once. Parts of lists are paired so that
as many literals as possible match (an assignment problem, level by level). So one wrong literal inside a
nested list costs one literal, not the list.

Conditions and effects are normalized before the comparison: connectives are flattened and lists with a single
part are replaced by it. ``(and (p) (and (q)))`` equals ``(and (p) (q))``, and ``(and (p))`` equals ``(p)``.
Double negations vanish, and an implication becomes a disjunction. A deletion is a negated atom. A conditional
effect is an implication; conditions no longer contain implications.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import permutations
from typing import NamedTuple, TypeAlias, TypeVar

from typing_extensions import assert_never

import eai.logic.formula as f
import eai.pddl.model as m
from eai.logic.matching import find_heaviest_matching_of_any_size
from eai.logic.traversal import map_subformulas, walk_subformulas
from eai.pddl.writer import write_formula

_T = TypeVar("_T")

_MAX_CACHED_OPERATORS = 1000
"""Maximum number of cached gold operators (the data set's) in normal form."""

MAX_PERMUTED_PARAMETERS = 5
"""Maximum number of parameters of two operators for which all pairings are tried.

Longer lists of parameters are paired by position.
"""

Clause: TypeAlias = f.Formula
"""A condition or an effect in normal form: flat ``and`` and ``or``, and no double negation."""

_LISTS = (f.And, f.Or)

Renaming = Mapping[str, str]
"""Mapping from variables of the answer to gold names; a variable without a gold name matches nothing."""


@dataclass(frozen=True, slots=True)
class ClauseComparison:
    """The comparison of one side of an operator (its precondition or its effect) with the gold side.

    Each tuple holds clauses as PDDL text, which `find_predicates_in_text` reads, in their original order.

    Attributes:
        matched: the gold clauses that the answer has.
        additional: the clauses of the answer that match no gold clause.
        missing: the gold clauses that the answer lacks.
    """

    matched: tuple[str, ...] = ()
    additional: tuple[str, ...] = ()
    missing: tuple[str, ...] = ()


NO_MATCH = ClauseComparison()
"""Comparison of two empty preconditions or effects: no clause is matched, additional or missing."""


_LiteralMatch: TypeAlias = tuple[int, int, int]
"""Numbers of matched, additional and missing literals of one side (precondition or effect)."""


@dataclass(frozen=True, slots=True)
class ComparisonWithGoldOperator:
    """The comparison of an answer's operator with the data set's (gold) operator, by clauses and by literals.

    Attributes:
        renamed: pairs of an answer's parameter and the matching gold parameter, if their names differ.
        missing_any: whether the missing clauses of the precondition are alternatives (a disjunction in the
            gold operator). Then one would suffice. If not, the gold operator requires all of them.
        additional_any: whether the additional clauses of the precondition are alternatives (a disjunction in
            the answer). If not, the answer requires all of them.
    """

    precondition: ClauseComparison
    effect: ClauseComparison
    precondition_literals: _LiteralMatch
    effect_literals: _LiteralMatch
    renamed: tuple[tuple[str, str], ...] = ()
    missing_any: bool = False
    additional_any: bool = False


class _GoldClauseWithCanonicalTexts(NamedTuple):
    """The precondition or the effect of a gold operator, with the canonical texts of its parts."""

    clause: Clause
    texts_of_parts: tuple[str, ...]
    literal_count: int


class _AnswerAndGoldClauses(NamedTuple):
    """The preconditions, or the effects, of an answer's operator and of the gold operator.

    Attributes:
        gold_texts: the canonical clauses of the gold side.
        gold_literals: number of literals of the gold side.
    """

    answer: Clause
    gold: Clause
    gold_texts: tuple[str, ...]
    gold_literals: int


def normalize_condition(formula: f.Formula) -> Clause:
    """Return a condition as a clause, that is, in the normal form in which conditions are compared.

    Raises:
        ValueError: the formula has a part without a PDDL form.
    """
    match formula:
        case f.Not(operand):
            return _negate_clause(normalize_condition(operand))
        case f.And(operands) | f.Or(operands):
            return _join_clauses(type(formula), map(normalize_condition, operands))
        case f.Implies(premise, conclusion):
            return normalize_condition(f.Or((f.Not(premise), conclusion)))
        case f.Atom() | f.Equals() | f.ForAll() | f.Exists():
            return map_subformulas(formula, normalize_condition)
        case _:
            raise ValueError(
                f"{type(formula).__name__} has no PDDL form: use and, or, not, imply, forall and exists"
            )


def normalize_effect(effect: m.PddlEffect) -> Clause:
    """Return an effect in normal form."""
    match effect:
        case m.Add(atom):
            return atom
        case m.Delete(atom):
            return f.Not(atom)
        case m.AndEffect(parts):
            return _join_clauses(f.And, map(normalize_effect, parts))
        case m.ForAllEffect(variable, part):
            return f.ForAll(variable, normalize_effect(part))
        case m.WhenEffect(condition, part):
            return f.Implies(normalize_condition(condition), normalize_effect(part))
        case _:
            assert_never(effect)


def _negate_clause(clause: Clause) -> Clause:
    return clause.operand if isinstance(clause, f.Not) else f.Not(clause)


def _join_clauses(connective: type[f.And] | type[f.Or], parts: Iterable[Clause]) -> Clause:
    flat: list[Clause] = []
    for part in parts:
        flat.extend(f.get_operands(part, connective))
    return flat[0] if len(flat) == 1 else connective(tuple(flat))


def _get_clause_parts(clause: Clause) -> tuple[Clause, ...]:
    """Return the parts of a clause that is a list; any other clause has itself as only part."""
    return clause.operands if isinstance(clause, _LISTS) else (clause,)


def write_clause(clause: Clause) -> str:
    """Return a clause as PDDL on one line."""
    return write_formula(clause).replace("(imply ", "(when ")


_HEAD = re.compile(r"\(([^\s()?]+)")
_CONNECTIVES = frozenset({"and", "or", "forall", "exists", "not", "when"})


def find_predicates_in_text(text: str) -> frozenset[str]:
    """Return the predicates in a text of `write_clause`. A text without brackets is a predicate."""
    return frozenset(_HEAD.findall(text)) - _CONNECTIVES if text.startswith("(") else frozenset({text})


def _write_canonical(clause: Clause, names: Renaming, depth: int = 0) -> str:
    """Return a text that is equal for clauses which differ only in order of parts and names of variables.

    Args:
        clause: the clause.
        names: mapping from the free variables to their names in the text; a variable that is not in it equals
            no variable of another clause.
        depth: number of enclosing quantifiers.
    """
    match clause:
        case f.Not(part):
            return f"(not {_write_canonical(part, names, depth)})"
        case f.And(parts) | f.Or(parts):
            word = "and" if isinstance(clause, f.And) else "or"
            return f"({' '.join([word, *sorted([_write_canonical(part, names, depth) for part in parts])])})"
        case f.ForAll(variable, part) | f.Exists(variable, part):
            word, bound = "forall" if isinstance(clause, f.ForAll) else "exists", f"#{depth}"
            body = _write_canonical(part, {**names, variable.name: bound}, depth + 1)
            return f"({word} (?{bound} - {m.get_variable_type(variable)}) {body})"
        case f.Implies(guard, part):
            return f"(when {_write_canonical(guard, names, depth)} {_write_canonical(part, names, depth)})"
        case f.Atom(predicate, terms):
            return f"({' '.join([predicate, *[_write_term(term, names) for term in terms]])})"
        case f.Equals(left, right):
            return f"(= {_write_term(left, names)} {_write_term(right, names)})"
        case _:
            raise ValueError(
                f"{type(clause).__name__} has no PDDL form: use and, or, not, imply, forall and exists"
            )


def _write_term(term: f.Term, names: Renaming) -> str:
    return f"?{names.get(term.name, f'?{term.name}')}" if isinstance(term, f.Variable) else term.name


@lru_cache(_MAX_CACHED_OPERATORS)
def _prepare_gold_clauses(
    gold: m.PddlAction,
) -> tuple[_GoldClauseWithCanonicalTexts, ...]:
    """Return the precondition and the effect of a gold operator, prepared for comparison with answers.

    The result is cached, because many answers are compared with the same gold operator.
    """
    names = {parameter.name: parameter.name for parameter in gold.parameters}
    return tuple(
        [
            _GoldClauseWithCanonicalTexts(
                clause,
                tuple([_write_canonical(part, names) for part in _get_clause_parts(clause)]),
                _count_literals(clause),
            )
            for clause in (normalize_condition(gold.precondition), normalize_effect(gold.effect))
        ]
    )


def match_operators(predicted: m.PddlAction, gold: m.PddlAction) -> ComparisonWithGoldOperator:
    """Compare an operator of an answer with the data set's (gold) operator of the same name."""
    own = normalize_condition(predicted.precondition), normalize_effect(predicted.effect)
    sides = [
        _AnswerAndGoldClauses(ours, *theirs)
        for ours, theirs in zip(own, _prepare_gold_clauses(gold), strict=True)
    ]
    renamings = _list_parameter_renamings(predicted, gold)
    wanted = sum(len(side.gold_texts) for side in sides)
    renaming, matches = _find_best_renaming(
        sides,
        renamings,
        _split_into_matched_additional_missing_clauses,
        lambda clauses: len(clauses[0]),
        wanted,
    )
    precondition, effect = [
        ClauseComparison(*[tuple(map(write_clause, part)) for part in side]) for side in matches
    ]
    wanted = sum(side.gold_literals for side in sides)
    _, matched = _find_best_renaming(
        sides,
        renamings,
        lambda side, renaming: _count_matched_literals(side.answer, side.gold, renaming),
        int,
        wanted,
    )
    of_precondition, of_effect = [
        (number, _count_literals(side.answer) - number, side.gold_literals - number)
        for number, side in zip(matched, sides, strict=True)
    ]
    renamed = tuple([(ours, theirs) for ours, theirs in renaming.items() if ours != theirs])
    ours, theirs = sides[0].answer, sides[0].gold
    alternatives = (
        isinstance(theirs, f.Or),
        isinstance(ours, f.Or) and len(_split_answer_unless_connectives_differ(ours, theirs)) > 1,
    )
    return ComparisonWithGoldOperator(
        precondition, effect, of_precondition, of_effect, renamed, *alternatives
    )


def mark_all_clauses_missing(gold: m.PddlAction) -> ComparisonWithGoldOperator:
    """Return the comparison for a gold operator that the answer lacks or whose text is unreadable."""
    return match_operators(m.PddlAction(gold.name, (), f.TRUE, m.NO_EFFECT), gold)


def _find_best_renaming(
    pairs: Sequence[_AnswerAndGoldClauses],
    renamings: Iterable[Renaming],
    match: Callable[[_AnswerAndGoldClauses, Renaming], _T],
    count_matches: Callable[[_T], int],
    max_matches: int,
) -> tuple[Renaming, list[_T]]:
    """Return the first renaming of parameters with most matches, and the matches with this renaming."""
    best: tuple[Renaming, list[_T]] = ({}, [])
    most = -1
    for renaming in renamings:
        matches = [match(side, renaming) for side in pairs]
        total = sum(map(count_matches, matches))
        if total > most:
            best, most = (renaming, matches), total
        if most == max_matches:
            break
    return best


def _split_into_matched_additional_missing_clauses(
    pair: _AnswerAndGoldClauses, renaming: Renaming
) -> tuple[list[Clause], list[Clause], list[Clause]]:
    """Return the matched, additional and missing clauses of a precondition or of an effect.

    Matched clauses are identical after parameters are renamed.
    """
    left = [
        (_write_canonical(part, renaming), part)
        for part in _split_answer_unless_connectives_differ(pair.answer, pair.gold)
    ]
    matched, missing = list[Clause](), list[Clause]()
    for part, same in zip(_get_clause_parts(pair.gold), pair.gold_texts, strict=True):
        partner = next(filter(lambda own: own[0] == same, left), None)
        if partner is None:
            missing.append(part)
        else:
            matched.append(part)
            left.remove(partner)
    return matched, [part for _, part in left], missing


def _split_answer_unless_connectives_differ(answer: Clause, gold: Clause) -> tuple[Clause, ...]:
    """Return the clauses of one side (precondition or effect) of an answer's operator.

    If the connective of this side differs from the connective of the gold side, the whole side is one clause.
    """
    lists = isinstance(answer, _LISTS) and isinstance(gold, _LISTS)
    unlike = (
        lists and type(answer) is not type(gold) and _get_clause_parts(answer) and _get_clause_parts(gold)
    )
    return (answer,) if unlike else _get_clause_parts(answer)


def _list_parameter_renamings(predicted: m.PddlAction, gold: m.PddlAction) -> list[Renaming]:
    """Return the pairings of two operators' parameters in which the most pairs have equal types.

    If the pairing by position is among them, it comes first.
    """
    ours, theirs = predicted.parameters, gold.parameters
    size = max(len(ours), len(theirs))
    orders = permutations(range(size)) if size <= MAX_PERMUTED_PARAMETERS else iter([tuple(range(size))])
    candidates = []
    for order in orders:
        pairs = [(ours[i], theirs[j]) for i, j in enumerate(order) if i < len(ours) and j < len(theirs)]
        agreeing = sum(m.get_variable_type(a) == m.get_variable_type(b) for a, b in pairs)
        candidates.append((agreeing, {a.name: b.name for a, b in pairs}))
    most = max(agreeing for agreeing, _ in candidates)
    return [renaming for agreeing, renaming in candidates if agreeing == most]


def _count_matched_literals(answer: Clause, gold: Clause, renaming: Renaming) -> int:
    """Return the maximum number of literals that match between an answer's clause and a gold clause.

    Clauses are conditions or effects: trees of connectives, quantifiers and literals. Literals match only if
    the nodes above them match.
    """
    if isinstance(answer, _LISTS) or isinstance(gold, _LISTS):
        return _count_matched_literals_of_and_or_clauses(answer, gold, renaming)
    match answer, gold:
        case f.Atom(name, terms), f.Atom(gold_name, gold_terms):
            return int(name == gold_name and _are_terms_equal(terms, gold_terms, renaming))
        case f.Equals(left, right), f.Equals(gold_left, gold_right):
            return int(_are_terms_equal((left, right), (gold_left, gold_right), renaming))
        case f.Not(a), f.Not(b) if _is_atom_or_equation(a) == _is_atom_or_equation(b):
            return _count_matched_literals(a, b, renaming)
        case (f.ForAll(own, a), f.ForAll(other, b)) | (f.Exists(own, a), f.Exists(other, b)) if (
            m.get_variable_type(own) == m.get_variable_type(other)
        ):
            return _count_matched_literals(a, b, {**renaming, own.name: other.name})
        case f.Implies(guard, a), f.Implies(gold_guard, b):
            return _count_matched_literals(guard, gold_guard, renaming) + _count_matched_literals(
                a, b, renaming
            )
        case _:
            return 0


def _count_matched_literals_of_and_or_clauses(answer: Clause, gold: Clause, renaming: Renaming) -> int:
    """Return the maximum number of matched literals of two clauses.

    At least one of the clauses is a conjunction or a disjunction. A conjunction does not match a disjunction,
    but may match a part of the disjunction, or the reverse.
    """
    if isinstance(answer, _LISTS) and isinstance(gold, _LISTS) and type(answer) is not type(gold):
        inside = [
            _count_matched_literals(part, gold, renaming)
            for part in _find_conjunctions_and_disjunctions(answer)
        ]
        around = [
            _count_matched_literals(answer, part, renaming)
            for part in _find_conjunctions_and_disjunctions(gold)
        ]
        return max([*inside, *around], default=0)
    grid = [
        [_count_matched_literals(a, b, renaming) for b in _get_clause_parts(gold)]
        for a in _get_clause_parts(answer)
    ]
    return sum(grid[row][column] for row, column in find_heaviest_matching_of_any_size(grid))


def _find_conjunctions_and_disjunctions(clause: Clause) -> list[Clause]:
    return [part for part in _get_clause_parts(clause) if isinstance(part, _LISTS)]


def _is_atom_or_equation(clause: Clause) -> bool:
    return isinstance(clause, (f.Atom, f.Equals))


def _count_literals(clause: Clause) -> int:
    return sum(map(_is_atom_or_equation, walk_subformulas(clause)))


def _are_terms_equal(
    answer_terms: Sequence[f.Term], gold_terms: Sequence[f.Term], renaming: Renaming
) -> bool:
    """Whether terms of an answer are the gold terms, after ``renaming`` its variables to gold variables."""
    return len(answer_terms) == len(gold_terms) and all(
        renaming.get(term.name) == gold_term.name
        if isinstance(term, f.Variable) and isinstance(gold_term, f.Variable)
        else term == gold_term
        for term, gold_term in zip(answer_terms, gold_terms, strict=True)
    )
