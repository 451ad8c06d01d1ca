"""BDDL for tests: read conditions, and print formulas and problems."""

from __future__ import annotations

from collections.abc import Iterator

import eai.logic.formula as f
from eai.base.errors import InputError
from eai.pddl.bddl import parse_problem
from eai.pddl.model import PddlProblem


def read_condition(text: str) -> f.Formula:
    """Parse a condition. In errors, the text begins on line 2.

    Raises:
        ParseError: the text is not a condition.
    """
    return parse_problem(f"(define (problem p) (:domain d) (:objects) (:init) (:goal\n{text}\n))").goal


def print_condition(formula: f.Formula) -> str:
    """Print a formula as one BDDL condition on one line.

    Raises:
        InputError: it has a temporal operator, an action, an equation or a variable without a category.
    """
    match formula:
        case f.Atom(name, arguments):
            return _list(name, *map(_term, arguments))
        case f.Not(operand):
            return _list("not", print_condition(operand))
        case f.And(operands):
            return _list("and", *map(print_condition, operands))
        case f.Or(operands):
            return _list("or", *map(print_condition, operands))
        case f.Implies(premise, conclusion):
            return _list("imply", print_condition(premise), print_condition(conclusion))
        case f.ForAll(variable, body):
            return _list("forall", _binding(variable), print_condition(body))
        case f.Exists(variable, body):
            return _list("exists", _binding(variable), print_condition(body))
        case f.Exactly(count, variable, body):
            return _list("forn", _list(str(count)), _binding(variable), print_condition(body))
        case f.ForPairs(first, second, body, count):
            head = ("forpairs",) if count is None else ("fornpairs", _list(str(count)))
            return _list(*head, _binding(first), _binding(second), print_condition(body))
        case _:
            raise InputError(f"BDDL has no {type(formula).__name__}")


def print_problem(problem: PddlProblem) -> str:
    """Print a problem as a file, with one object, fact or goal on each line.

    Raises:
        InputError: BDDL cannot express one of its formulas.
    """
    return "\n".join(_lines(problem)) + "\n"


def _lines(problem: PddlProblem) -> Iterator[str]:
    yield f"(define (problem {problem.name})"
    yield f"  (:domain {problem.domain})"
    yield "  (:objects"
    yield from (f"    {each.name} - {each.type}" for each in problem.objects)
    yield "  )"
    yield "  (:init"
    facts = (*problem.initial, *map(f.Not, problem.denied))
    yield from (f"    {print_condition(fact)}" for fact in facts)
    yield "  )"
    yield "  (:goal"
    if isinstance(problem.goal, f.And):
        yield "    (and"
        yield from (f"      {print_condition(goal)}" for goal in problem.goal.operands)
        yield "    )"
    else:
        yield f"    {print_condition(problem.goal)}"
    yield "  )"
    yield ")"


def _list(*parts: str) -> str:
    return f"({' '.join(parts)})"


def _term(term: f.Term) -> str:
    return f"?{term.name}" if isinstance(term, f.Variable) else term.name


def _binding(variable: f.Variable) -> str:
    if variable.category is None:
        raise InputError(f"BDDL needs a category for variable {variable.name}")
    return f"(?{variable.name} - {variable.category})"
