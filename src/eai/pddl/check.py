"""Kinds of violations in PDDL text, and checks that all names are declared and rightly used.

`reader` checks the form of a text. `check_action` and `check_problem` find all further violations.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from enum import Enum

import eai.logic.formula as f
import eai.pddl.model as m
from eai.base.errors import ParseError
from eai.logic.traversal import get_bound_variables, get_subformulas


class PddlViolationKind(str, Enum):
    """A kind of violation of the rules of PDDL. Stored verdicts (records) contain its value."""

    UNBALANCED = "unbalanced_parenthesis"
    """A parenthesis that is not closed, or that closes nothing."""
    MALFORMED = "malformed"
    """Balanced parentheses, but not PDDL, such as a connective with a wrong number of parts."""
    UNSUPPORTED = "unsupported"
    """Valid PDDL that this package does not read: ``either``, numbers, preferences."""
    CONDITION_IN_EFFECT = "condition_in_effect"
    """A condition in place of an effect: ``or``, ``exists``, ``imply``, ``=``, or ``not`` of a non-atom."""
    EFFECT_IN_CONDITION = "effect_in_condition"
    """A conditional effect (``when``) in place of a condition."""
    UNKNOWN_PREDICATE = "unknown_predicate"
    WRONG_ARITY = "wrong_arity"
    WRONG_ARGUMENT_TYPE = "wrong_argument_type"
    """An argument whose type does not fit the predicate's declaration. Planners do not check this."""
    UNKNOWN_TYPE = "unknown_type"
    UNBOUND_VARIABLE = "unbound_variable"
    UNDECLARED_CONSTANT = "undeclared_constant"
    DUPLICATE = "duplicate"
    """A name declared twice in one list of parameters, predicates, operators or objects."""

    @property
    def makes_planners_refuse_domain(self) -> bool:
        """Whether a planner that follows the standard refuses a domain with a violation of this kind."""
        return self is not PddlViolationKind.WRONG_ARGUMENT_TYPE

    @property
    def makes_text_unreadable(self) -> bool:
        """Whether a text with a violation of this kind cannot be read.

        Violations of other kinds are wrong names in a readable text.
        """
        return self in _UNREADABLE


_UNREADABLE = frozenset(
    {
        PddlViolationKind.UNBALANCED,
        PddlViolationKind.MALFORMED,
        PddlViolationKind.UNSUPPORTED,
        PddlViolationKind.CONDITION_IN_EFFECT,
        PddlViolationKind.EFFECT_IN_CONDITION,
    }
)


@dataclass(frozen=True, slots=True)
class PddlFinding:
    """One violation of PDDL in a text.

    Attributes:
        offence: the kind of the violation.
        name: the wrong name (predicate, type, variable, constant). For a kind of violation that makes the
            text unreadable, the text that was expected there.
        place: the location of the violation in words: the operator and its part.
    """

    offence: PddlViolationKind
    name: str
    place: str

    @property
    def description(self) -> str:
        """The finding in words: the wrong name, or for an unreadable text, what was expected."""
        return f"expected {self.name}" if self.offence.makes_text_unreadable else self.name


class PddlError(ParseError):
    """A PDDL text that cannot be read, with the kind of violation.

    Args:
        offence: the kind of the violation.
        line: the line of the violation, counted from 1.
        column: the column of the violation, counted from 1.
        expected: the expected text, in words.
    """

    def __init__(self, offence: PddlViolationKind, line: int, column: int, expected: str) -> None:
        super().__init__(line, column, expected)
        self.offence = offence


TypeScope = Mapping[str, str]
"""Mapping from the variables that are bound at some point of the text to their types."""


@dataclass(frozen=True, slots=True)
class PddlDeclarations:
    """The declared names that a text may use.

    Attributes:
        parents: the direct supertype of each declared type.
        predicates: mapping from the name of each predicate to its declaration.
        constants: mapping from the name of each constant to its type.
    """

    parents: Mapping[str, str]
    predicates: Mapping[str, m.PddlPredicate]
    constants: Mapping[str, str]

    @classmethod
    def from_domain(cls, domain: m.PddlDomain, objects: Iterable[m.TypedName] = ()) -> PddlDeclarations:
        """Return the declared names of a domain and, if given, of the objects of a problem."""
        return cls(
            parents=m.map_types_to_parents(domain.types),
            predicates={predicate.name: predicate for predicate in domain.predicates},
            constants={item.name: item.type for item in (*domain.constants, *objects)},
        )

    def has_type(self, name: str) -> bool:
        """Whether a type, or each type of an ``either``, is declared. The root type counts as declared."""
        return all(
            alternative == m.OBJECT or alternative in self.parents
            for alternative in m.list_alternatives_of_either_type(name)
        )

    def is_subtype(self, name: str, required: str) -> bool:
        """Whether a type equals a required type, or is below the required type.

        One matching alternative of an ``either`` is enough.
        """
        kinds = {
            kind
            for alternative in m.list_alternatives_of_either_type(name)
            for kind in m.list_supertypes(self.parents, alternative)
        }
        return not kinds.isdisjoint(m.list_alternatives_of_either_type(required))


def check_domain(domain: m.PddlDomain) -> tuple[PddlFinding, ...]:
    """Return all violations of a domain: in its declarations, then operator by operator."""
    vocabulary = PddlDeclarations.from_domain(domain)
    findings = [
        *_find_duplicate_names([item.name for item in domain.constants], ":constants"),
        *_find_duplicate_names([predicate.name for predicate in domain.predicates], "predicates"),
        *_find_duplicate_names([action.name for action in domain.actions], "operators"),
    ]
    above = vocabulary.parents
    findings += [
        PddlFinding(PddlViolationKind.MALFORMED, name, ":types")
        for name in above
        if above[name] != m.OBJECT and name in m.list_supertypes(above, above[name])
    ]
    for predicate in domain.predicates:
        findings += _find_unknown_types(predicate.parameters, vocabulary, f"predicate {predicate.name}")
    for axiom in domain.axioms:
        scope = {parameter.name: m.get_variable_type(parameter) for parameter in axiom.parameters}
        place, condition = f"derived predicate {axiom.name}", f"condition of {axiom.name}"
        findings += _find_unknown_types(axiom.parameters, vocabulary, place)
        findings += _find_duplicate_names([parameter.name for parameter in axiom.parameters], place)
        head = f.Atom(axiom.name, tuple([f.Variable(parameter.name) for parameter in axiom.parameters]))
        findings += _FormulaChecker(vocabulary, place).check_atom(head, scope)
        findings += _FormulaChecker(vocabulary, condition).check_formula(axiom.condition, scope)
    for action in domain.actions:
        findings += check_action(action, vocabulary)
    return tuple(findings)


def check_action(action: m.PddlAction, vocabulary: PddlDeclarations) -> tuple[PddlFinding, ...]:
    """Return all violations of PDDL in an operator, such as undeclared names, in the order of the text.

    Each violation is listed once.
    """
    place = f"parameters of {action.name}"
    scope = {parameter.name: m.get_variable_type(parameter) for parameter in action.parameters}
    findings = [
        *_find_duplicate_names([parameter.name for parameter in action.parameters], place),
        *_find_unknown_types(action.parameters, vocabulary, place),
        *_FormulaChecker(vocabulary, f"precondition of {action.name}").check_formula(
            action.precondition, scope
        ),
        *_FormulaChecker(vocabulary, f"effect of {action.name}").check_effect(action.effect, scope),
    ]
    return tuple(dict.fromkeys(findings))


def check_problem(problem: m.PddlProblem, domain: m.PddlDomain) -> tuple[PddlFinding, ...]:
    """Return each violation of PDDL in a problem once, such as a name that its domain does not declare."""
    vocabulary = PddlDeclarations.from_domain(domain, problem.objects)
    objects = [f.Variable(item.name, item.type) for item in problem.objects]
    findings = [
        *_find_duplicate_names([item.name for item in objects], "objects"),
        *_find_unknown_types(objects, vocabulary, "objects"),
    ]
    for atom in (*problem.initial, *problem.denied):
        findings += _FormulaChecker(vocabulary, "initial state").check_formula(atom, {})
    findings += _FormulaChecker(vocabulary, "goal").check_formula(problem.goal, {})
    for action in domain.actions:
        findings += [
            finding
            for finding in check_action(action, vocabulary)
            if finding.offence is VIOLATION_FIXABLE_BY_PROBLEM
        ]
    return tuple(dict.fromkeys(findings))


VIOLATION_FIXABLE_BY_PROBLEM = PddlViolationKind.UNDECLARED_CONSTANT
"""Kind of violation: an operator names an undeclared object. A problem fixes it by declaring the object."""


@dataclass(frozen=True, slots=True)
class _FormulaChecker:
    """Checks one formula or effect. `place` states in words where the formula or effect stands."""

    vocabulary: PddlDeclarations
    place: str

    def check_formula(self, formula: f.Formula, scope: TypeScope) -> Iterator[PddlFinding]:
        match formula:
            case f.Atom():
                yield from self.check_atom(formula, scope)
            case f.Equals(left, right):
                for term in (left, right):
                    yield from self.check_term(term, scope)
            case f.Occurs() | f.Then() | f.Next() | f.Eventually() | f.Always() | f.Until():
                yield PddlFinding(
                    PddlViolationKind.UNSUPPORTED, f"PDDL, not {type(formula).__name__}", self.place
                )
            case _:
                bound = get_bound_variables(formula)
                yield from _find_unknown_types(bound, self.vocabulary, self.place)
                inner = (
                    {**scope, **{variable.name: m.get_variable_type(variable) for variable in bound}}
                    if bound
                    else scope
                )
                for part in get_subformulas(formula):
                    yield from self.check_formula(part, inner)

    def check_effect(self, effect: m.PddlEffect, scope: TypeScope) -> Iterator[PddlFinding]:
        match effect:
            case m.Add(atom) | m.Delete(atom):
                yield from self.check_atom(atom, scope)
            case m.AndEffect(parts):
                for part in parts:
                    yield from self.check_effect(part, scope)
            case m.ForAllEffect(variable, part):
                yield from _find_unknown_types((variable,), self.vocabulary, self.place)
                yield from self.check_effect(part, {**scope, variable.name: m.get_variable_type(variable)})
            case m.WhenEffect(condition, part):
                yield from self.check_formula(condition, scope)
                yield from self.check_effect(part, scope)

    def check_atom(self, atom: f.Atom, scope: TypeScope) -> Iterator[PddlFinding]:
        declared = self.vocabulary.predicates.get(atom.predicate)
        if declared is None:
            yield PddlFinding(PddlViolationKind.UNKNOWN_PREDICATE, atom.predicate, self.place)
        elif len(declared.parameters) != len(atom.arguments):
            yield PddlFinding(PddlViolationKind.WRONG_ARITY, atom.predicate, self.place)
        else:
            for parameter, argument in zip(declared.parameters, atom.arguments, strict=True):
                yield from self._check_argument_type(parameter, argument, scope)
        for argument in atom.arguments:
            yield from self.check_term(argument, scope)

    def check_term(self, term: f.Term, scope: TypeScope) -> Iterator[PddlFinding]:
        match term:
            case f.Variable(name) if name not in scope:
                yield PddlFinding(PddlViolationKind.UNBOUND_VARIABLE, name, self.place)
            case f.Constant(name) if name not in self.vocabulary.constants:
                yield PddlFinding(PddlViolationKind.UNDECLARED_CONSTANT, name, self.place)

    def _check_argument_type(
        self, parameter: f.Variable, argument: f.Term, scope: TypeScope
    ) -> Iterator[PddlFinding]:
        types = scope if isinstance(argument, f.Variable) else self.vocabulary.constants
        actual = types.get(argument.name)
        if actual is None or not self.vocabulary.has_type(actual):
            return
        if not self.vocabulary.is_subtype(actual, m.get_variable_type(parameter)):
            yield PddlFinding(PddlViolationKind.WRONG_ARGUMENT_TYPE, argument.name, self.place)


def _find_unknown_types(
    variables: Iterable[f.Variable], vocabulary: PddlDeclarations, place: str
) -> Iterator[PddlFinding]:
    for variable in variables:
        if not vocabulary.has_type(m.get_variable_type(variable)):
            yield PddlFinding(PddlViolationKind.UNKNOWN_TYPE, m.get_variable_type(variable), place)


def _find_duplicate_names(names: Iterable[str], place: str) -> Iterator[PddlFinding]:
    for name, count in Counter(names).items():
        if count > 1:
            yield PddlFinding(PddlViolationKind.DUPLICATE, name, place)
