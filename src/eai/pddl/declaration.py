"""Convert a PDDL domain to a declared domain, and its problems to states and goals; reverses `export`.

Each conjunct of a precondition becomes a check: a condition whose failure makes an action impossible. If no
effect can change the truth of the condition, its failure is an affordance error, and otherwise a missing
step. Effects keep PDDL's meaning: an atom that is both deleted and added is true. The type of an object
becomes its category, and a supertype the parent of a category.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

import eai.logic.formula as f
import eai.pddl.model as m
from eai.logic.traversal import find_predicates, map_subformulas, wrap_in_quantifiers
from eai.pddl.execute import DerivedPredicates
from eai.pddl.writer import write_formula
from eai.world.derived import DefinedPredicate, is_a
from eai.world.domain import Domain
from eai.world.effect import Add, Delete, Effect, ForEach, When
from eai.world.fault import FaultKind
from eai.world.fixpoint import make_recursive_predicates
from eai.world.frame import AGENT
from eai.world.operator import Check, Operator, affordance
from eai.world.state import Fact, Scene, State, WorldObject
from eai.world.vocabulary import DerivedPredicate, Predicate, Vocabulary


class ConvertedPddlDomain:
    """A domain of PDDL that was converted to a declared domain.

    Args:
        source: the domain of PDDL. All its names must be declared.

    Attributes:
        domain: the declared domain.

    Raises:
        DomainError: a derived predicate depends on its own negation.
    """

    def __init__(self, source: m.PddlDomain) -> None:
        self._source = source
        changing = {
            atom.predicate for action in source.actions for atom in m.find_effect_atoms(action.effect)
        }
        derived = DerivedPredicates(source.axioms)
        self._changing = set(changing)
        while new := {
            axiom.name
            for axiom in source.axioms
            if axiom.name not in self._changing
            and not self._changing.isdisjoint(find_predicates(axiom.condition))
        }:
            self._changing |= new
        plain = {name: self._make_derived_predicate(name, axioms) for name, axioms in derived.axioms.items()}
        defined: dict[str, DerivedPredicate] = {**plain}
        for cycle in dict.fromkeys(map(frozenset, derived.cycles.values())):
            members = [each for name, each in plain.items() if name in cycle]
            recursive = make_recursive_predicates(members, lambda: self.domain.vocabulary)
            defined |= {each.name: each for each in recursive}
        stored = [
            Predicate(each.name, len(each.parameters), static=each.name not in changing)
            for each in source.predicates
            if each.name not in derived.axioms
        ]
        parents = {
            name: kind for name, kind in m.map_types_to_parents(source.types).items() if kind != m.OBJECT
        }
        vocabulary = Vocabulary(tuple(stored), tuple(defined.values()), parents)
        self.domain = Domain(source.name, vocabulary, tuple(map(self._convert_operator, source.actions)))

    def convert_problem(self, problem: m.PddlProblem) -> tuple[State, tuple[f.Formula, ...]]:
        """Return the initial state of a problem of the domain, and the conjuncts of its goal."""
        items = (*self._source.constants, *problem.objects)
        things = [WorldObject(item.name, item.type) for item in items]
        index = {thing.name: i for i, thing in enumerate(things)}
        scene = Scene(self.domain.vocabulary, things, agent=index.get(AGENT.name))
        facts = [
            Fact(atom.predicate, tuple([index[term.name] for term in atom.arguments]))
            for atom in problem.initial
        ]
        goals = tuple([_replace_either_types_by_conditions(part) for part in split_conjuncts(problem.goal)])
        return scene.state(facts), goals

    def _make_derived_predicate(self, name: str, axioms: Sequence[m.PddlAxiom]) -> DefinedPredicate:
        """Return the derived predicate that its axioms define, with the parameters of the first axiom."""
        first = axioms[0].parameters
        return DefinedPredicate(
            name, first, f.Or(tuple([self._rename_axiom_parameters(axiom, first) for axiom in axioms]))
        )

    def _rename_axiom_parameters(self, axiom: m.PddlAxiom, new_parameters: Sequence[f.Variable]) -> f.Formula:
        """Return an axiom's condition, with parameters renamed to those of its predicate's first axiom."""
        places = [
            (f.Variable(a.name), f.Variable(b.name))
            for a, b in zip(axiom.parameters, new_parameters, strict=True)
        ]
        renamed = [(mine, other) for mine, other in places if mine != other]
        typed = [_make_type_condition(parameter) for parameter in axiom.parameters]
        same = [f.Equals(mine, other) for mine, other in renamed]
        body: f.Formula = f.And((*typed, *same, _replace_either_types_by_conditions(axiom.condition)))
        return wrap_in_quantifiers(f.Exists, [mine for mine, _ in reversed(renamed)], body)

    def _convert_operator(self, action: m.PddlAction) -> Operator:
        parameters = tuple([f.Variable(parameter.name) for parameter in action.parameters])
        kinds = [
            self._make_type_check(each) for each in action.parameters if m.get_variable_type(each) != m.OBJECT
        ]
        checks = [
            self._make_precondition_check(part, parameters) for part in split_conjuncts(action.precondition)
        ]
        deletions, additions = (tuple(self._convert_effects(action.effect, kind)) for kind in (Delete, Add))
        return Operator(action.name, parameters, (*kinds, *checks), (*deletions, *additions))

    def _make_type_check(self, parameter: f.Variable) -> Check:
        kinds = " or ".join(m.list_alternatives_of_either_type(m.get_variable_type(parameter)))
        return affordance(_make_type_condition(parameter), f"{{{parameter.name}}} is no {kinds}")

    def _make_precondition_check(self, condition: f.Formula, parameters: Sequence[f.Variable]) -> Check:
        can_change = self._changing.intersection(find_predicates(condition))
        fault = FaultKind.MISSING_STEP if can_change else FaultKind.AFFORDANCE
        return Check(
            _replace_either_types_by_conditions(condition),
            fault,
            _write_reason_of_failure(condition, parameters),
        )

    def _convert_effects(self, effect: m.PddlEffect, kind: type[Add] | type[Delete]) -> Iterator[Effect]:
        """Yield either the additions or the deletions of an effect."""
        match effect:
            case Add() | Delete() if isinstance(effect, kind):
                yield effect
            case m.AndEffect(parts):
                for part in parts:
                    yield from self._convert_effects(part, kind)
            case m.ForAllEffect(variable, part):
                inner = tuple(self._convert_effects(part, kind))
                if inner:
                    yield ForEach(f.Variable(variable.name), _make_type_condition(variable), inner)
            case m.WhenEffect(condition, part):
                inner = tuple(self._convert_effects(part, kind))
                if inner:
                    yield When(_replace_either_types_by_conditions(condition), inner)


def _make_type_condition(variable: f.Variable) -> f.Formula:
    """Return the condition that the value of a variable is of the variable's type."""
    names = m.list_alternatives_of_either_type(m.get_variable_type(variable))
    return f.TRUE if m.OBJECT in names else is_a(f.Variable(variable.name), *names)


def _replace_either_types_by_conditions(formula: f.Formula) -> f.Formula:
    """Return a formula whose quantifiers range over one type each; ``either`` types become conditions."""
    match formula:
        case f.ForAll(variable, body) if (
            len(m.list_alternatives_of_either_type(m.get_variable_type(variable))) > 1
        ):
            kind = _make_type_condition(variable)
            return f.ForAll(
                f.Variable(variable.name), f.Implies(kind, _replace_either_types_by_conditions(body))
            )
        case f.Exists(variable, body) if (
            len(m.list_alternatives_of_either_type(m.get_variable_type(variable))) > 1
        ):
            kind = _make_type_condition(variable)
            return f.Exists(
                f.Variable(variable.name), f.And((kind, _replace_either_types_by_conditions(body)))
            )
        case _:
            return map_subformulas(formula, _replace_either_types_by_conditions)


def split_conjuncts(formula: f.Formula) -> Iterator[f.Formula]:
    """Yield the conjuncts of a formula, left to right."""
    if isinstance(formula, f.And):
        for operand in formula.operands:
            yield from split_conjuncts(operand)
    else:
        yield formula


def _write_reason_of_failure(condition: f.Formula, parameters: Sequence[f.Variable]) -> str:
    """Return the reason why a condition fails, with placeholders for the names of the arguments."""
    names = {parameter.name for parameter in parameters}
    match condition:
        case f.Atom():
            return f"{_write_atom(condition, names)} does not hold"
        case f.Not(f.Atom() as atom):
            return f"{_write_atom(atom, names)} holds"
        case f.Not(f.Equals(left, right)):
            terms = [_write_term_in_failure_reason(term, names) for term in (left, right)]
            return f"{terms[0]} and {terms[1]} are the same"
        case f.Equals(left, right):
            terms = [_write_term_in_failure_reason(term, names) for term in (left, right)]
            return f"{terms[0]} and {terms[1]} are not the same"
        case _:
            text = write_formula(condition).replace("{", "{{").replace("}", "}}")
            words = re.split(r"([\s()])", text)
            filled = [f"{{{w[1:]}}}" if w[:1] == "?" and w[1:] in names else w for w in words]
            return f"{''.join(filled)} does not hold"


def _write_atom(atom: f.Atom, parameter_names: set[str]) -> str:
    terms = [_write_term_in_failure_reason(term, parameter_names) for term in atom.arguments]
    return f"{atom.predicate}({', '.join(terms)})"


def _write_term_in_failure_reason(term: f.Term, parameter_names: set[str]) -> str:
    return f"{{{term.name}}}" if isinstance(term, f.Variable) and term.name in parameter_names else term.name
