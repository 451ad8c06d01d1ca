"""Print domains, problems, operators and formulas as PDDL.

`reader` reads the text back as the same value, and equal values give equal bytes.
"""

from __future__ import annotations

from collections.abc import Iterable

import eai.logic.formula as f
import eai.pddl.model as m
from eai.pddl.model import OperatorText


def write_domain(domain: m.PddlDomain) -> str:
    """Return a domain as PDDL text, one declaration a line."""
    sections = [
        f"(:requirements {' '.join(domain.requirements)})" if domain.requirements else "",
        f"(:types {_write_typed_names(domain.types)})" if domain.types else "",
        f"(:constants {_write_typed_names(domain.constants)})" if domain.constants else "",
        _write_block(
            ":predicates", [_write_list([p.name, *_write_variables(p.parameters)]) for p in domain.predicates]
        ),
        *map(write_axiom, domain.axioms),
        *map(write_action, domain.actions),
    ]
    return _write_definition(f"(domain {domain.name})", sections)


def write_problem(problem: m.PddlProblem) -> str:
    """Return a problem as PDDL text, one fact a line."""
    denied = [f"(not {write_atom(atom)})" for atom in problem.denied]
    sections = [
        f"(:domain {problem.domain})",
        f"(:objects {_write_typed_names(problem.objects)})",
        _write_block(":init", [*map(write_atom, problem.initial), *denied]),
        f"(:goal {write_formula(problem.goal)})",
    ]
    return _write_definition(f"(problem {problem.name})", sections)


def write_axiom(axiom: m.PddlAxiom) -> str:
    """Return the definition of a derived predicate as PDDL text."""
    head = _write_list([axiom.name, *_write_variables(axiom.parameters)])
    return f"(:derived {head}\n    {write_formula(axiom.condition)})"


def write_action(action: m.PddlAction) -> str:
    """Return an operator as PDDL text."""
    return "\n  ".join(
        (
            f"(:action {action.name}",
            f":parameters {_write_list(_write_variables(action.parameters))}",
            f":precondition {write_formula(action.precondition)}",
            f":effect {write_effect(action.effect)})",
        )
    )


def unparse_operator(action: m.PddlAction) -> OperatorText:
    """Return an operator as an `OperatorText`: its parameters, precondition and effect as PDDL text."""
    parameters = _write_list(_write_variables(action.parameters))
    return OperatorText(
        action.name, parameters, write_formula(action.precondition), write_effect(action.effect)
    )


def write_effect(effect: m.PddlEffect) -> str:
    """Return an effect as PDDL text on one line."""
    match effect:
        case m.Add(atom):
            return write_atom(atom)
        case m.Delete(atom):
            return f"(not {write_atom(atom)})"
        case m.AndEffect(parts):
            return _write_list(["and", *map(write_effect, parts)])
        case m.ForAllEffect(variable, part):
            return f"(forall {_write_list(_write_variables((variable,)))} {write_effect(part)})"
        case m.WhenEffect(condition, part):
            return f"(when {write_formula(condition)} {write_effect(part)})"


def write_formula(formula: f.Formula) -> str:
    """Return a condition as PDDL text on one line.

    Raises:
        ValueError: the formula has a part without a PDDL form, such as a temporal operator.
    """
    match formula:
        case f.Atom():
            return write_atom(formula)
        case f.Equals(left, right):
            return f"(= {write_term(left)} {write_term(right)})"
        case f.Not(operand):
            return f"(not {write_formula(operand)})"
        case f.And(operands):
            return _write_list(["and", *map(write_formula, operands)])
        case f.Or(operands):
            return _write_list(["or", *map(write_formula, operands)])
        case f.Implies(premise, conclusion):
            return f"(imply {write_formula(premise)} {write_formula(conclusion)})"
        case f.ForAll(variable, body):
            return f"(forall {_write_list(_write_variables((variable,)))} {write_formula(body)})"
        case f.Exists(variable, body):
            return f"(exists {_write_list(_write_variables((variable,)))} {write_formula(body)})"
        case _:
            raise ValueError(
                f"{type(formula).__name__} has no PDDL form: use and, or, not, imply, forall and exists"
            )


def write_atom(atom: f.Atom) -> str:
    """Return an atom as PDDL text."""
    return _write_list([atom.predicate, *map(write_term, atom.arguments)])


def write_term(term: f.Term) -> str:
    """Return a variable or constant as PDDL text."""
    return f"?{term.name}" if isinstance(term, f.Variable) else term.name


def _write_variables(variables: Iterable[f.Variable]) -> list[str]:
    """Return variables with their types as a typed list of PDDL.

    The type of every variable is written, because a type applies to all names before it.
    """
    return [f"?{variable.name} - {m.get_variable_type(variable)}" for variable in variables]


def _write_typed_names(names: Iterable[m.TypedName]) -> str:
    return " ".join(f"{item.name} - {item.type}" for item in names)


def _write_list(words: Iterable[str]) -> str:
    return f"({' '.join(words)})"


def _write_block(head: str, lines: Iterable[str]) -> str:
    return "\n    ".join((f"({head}", *lines)) + ")"


def _write_definition(head: str, sections: Iterable[str]) -> str:
    return "\n  ".join((f"(define {head}", *filter(None, sections))) + ")\n"
