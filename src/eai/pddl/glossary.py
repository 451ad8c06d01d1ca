"""The PDDL names of an export, and which of these names its conditions use.

Formulas of a declared domain become conditions of PDDL. Categories of quantified variables become types. The
condition that an object is of a category becomes a static predicate. PDDL has neither the quantifier
"exactly n" nor pairings of objects: these become quantifiers over n different objects, or n pairs.

PDDL ignores case and allows few special characters. A valid PDDL name in lower case stays as it is. In any
other name each invalid character becomes an underscore, and equal names get numbers
(`PddlNamesByOriginalName`).
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import chain

import eai.logic.formula as f
from eai.base.errors import DomainError
from eai.logic.traversal import find_predicates, map_subformulas, wrap_in_quantifiers
from eai.pddl.reader import CONNECTIVES
from eai.world.derived import DefinedPredicate, find_definition, find_stored_dependencies
from eai.world.relation import iterate_bits
from eai.world.state import Scene
from eai.world.vocabulary import DerivedPredicate, Vocabulary


def conjoin(parts: Iterable[f.Formula]) -> f.Formula:
    """Return the conjunction of formulas, each once; false if two of the formulas are opposites."""
    return _join_formulas(f.And, parts)


def disjoin(parts: Iterable[f.Formula]) -> f.Formula:
    """Return the disjunction of formulas, each once; true if two of the formulas are opposites."""
    return _join_formulas(f.Or, parts)


def negate(formula: f.Formula) -> f.Formula:
    """Return the negation of a formula."""
    if isinstance(formula, f.Not):
        return formula.operand
    if formula in (f.TRUE, f.FALSE):
        return f.FALSE if formula == f.TRUE else f.TRUE
    return f.Not(formula)


def make_equality(left: f.Term, right: f.Term) -> f.Formula:
    """Return the condition that two terms are equal; it is false for constants with different names."""
    if left == right:
        return f.TRUE
    if isinstance(left, f.Constant) and isinstance(right, f.Constant):
        return f.FALSE
    return f.Equals(left, right)


def replace_variables(formula: f.Formula, terms: Mapping[str, f.Term]) -> f.Formula:
    """Return a formula with free variables replaced by terms.

    No quantifier in the formula may bind a variable that is replaced or occurs in the new terms.
    """
    match formula:
        case f.Atom(predicate, arguments):
            return f.Atom(predicate, tuple([replace_variable(term, terms) for term in arguments]))
        case f.Equals(left, right):
            return make_equality(replace_variable(left, terms), replace_variable(right, terms))
        case f.Not(operand):
            return negate(replace_variables(operand, terms))
        case f.And(operands):
            return conjoin([replace_variables(operand, terms) for operand in operands])
        case f.Or(operands):
            return disjoin([replace_variables(operand, terms) for operand in operands])
        case f.Implies() | f.ForAll() | f.Exists():
            return map_subformulas(formula, lambda part: replace_variables(part, terms))
        case _:
            raise ValueError(
                f"{type(formula).__name__} has no PDDL form: use and, or, not, imply, forall and exists"
            )


def replace_variable(term: f.Term, terms: Mapping[str, f.Term]) -> f.Term:
    """Return the term that replaces a variable, or the term itself if nothing replaces it."""
    return terms.get(term.name, term) if isinstance(term, f.Variable) else term


def _join_formulas(connective: type[f.And] | type[f.Or], parts: Iterable[f.Formula]) -> f.Formula:
    """Return a simplified conjunction or disjunction of formulas.

    It is the constant false (or true for a disjunction) if one part is that constant or two parts are
    opposites.
    """
    unique = dict.fromkeys(chain.from_iterable(f.get_operands(part, connective) for part in parts))
    decisive = negate(connective(()))
    if any(part == decisive or negate(part) in unique for part in unique):
        return decisive
    return next(iter(unique)) if len(unique) == 1 else connective(tuple(unique))


_STRANGE = re.compile(r"[^a-z0-9_-]")
_RESERVED = CONNECTIVES | {
    "either",
    "object",
    "define",
    "total-cost",
    "always",
    "sometime",
    "within",
    "at-most-once",
    "sometime-after",
    "sometime-before",
    "always-within",
    "hold-during",
    "hold-after",
    "preference",
}
"""Reserved words of PDDL, including words of PDDL 3, which the plan validator VAL interprets."""


class PddlNamesByOriginalName(dict[str, str]):
    """The PDDL names of one kind of thing (objects, predicates, operators, types), each used once.

    If a name is missing, a lookup of this name adds it with a new PDDL name.

    Args:
        names: the names that are added first, in order.
    """

    def __init__(self, names: Iterable[str] = ()) -> None:
        super().__init__()
        self._meant: dict[str, str] = {}
        for name in names:
            self[name]

    def __missing__(self, name: str) -> str:
        written = self[name] = self._make_unused_name(name)
        self._meant[written] = name
        return written

    def find_original_name(self, pddl_name: str) -> str:
        """Return the name that a PDDL name stands for.

        Raises:
            KeyError: the PDDL name is unknown.
        """
        return self._meant[pddl_name]

    def _make_unused_name(self, name: str) -> str:
        stem = _STRANGE.sub("_", name.strip().lower())
        if not stem[:1].isalpha() or stem in _RESERVED:
            stem = f"x-{stem}"
        number, written = 1, stem
        while written in self._meant:
            number += 1
            written = f"{stem}-{number}"
        return written


ORDER = "precedes"
"""Name of the static predicate ``(precedes x y)``: x has a lower index in the scene than y."""

TermScope = Mapping[str, f.Term]
"""Mapping from each variable of a formula to its PDDL term."""


@dataclass(slots=True)
class PddlExportNames:
    """The PDDL names of one export. A name counts as used once a method has returned it.

    Attributes:
        vocabulary: the predicates of the declared domain.
        predicates: PDDL names of the domain's predicates, and of predicates that the export adds.
        types: PDDL names of the categories of objects and of quantified variables.
        objects: PDDL names of the objects that the domain names, including the agent.
        derived: the used derived predicates that a formula defines.
        without_formula: the used derived predicates that no formula defines; they keep their initial values.
        category_predicates: mapping from each category that a condition tests to its predicate.
        execution_predicates: mapping from each operator whose execution a goal requires to the predicate
            which states that the operator was executed.
        uses_object_order: whether a condition uses the order of the objects.
    """

    vocabulary: Vocabulary
    predicates: PddlNamesByOriginalName = field(init=False)
    types: PddlNamesByOriginalName = field(default_factory=PddlNamesByOriginalName)
    objects: PddlNamesByOriginalName = field(default_factory=PddlNamesByOriginalName)
    derived: dict[str, DefinedPredicate] = field(default_factory=dict)
    without_formula: dict[str, DerivedPredicate] = field(default_factory=dict)
    category_predicates: dict[str, str] = field(default_factory=dict)
    execution_predicates: dict[str, str] = field(default_factory=dict)
    uses_object_order: bool = False

    def __post_init__(self) -> None:
        stored = [predicate.name for predicate in self.vocabulary.predicates]
        self.predicates = PddlNamesByOriginalName([*stored, *self.vocabulary.derived_by_name])

    def register_predicate(self, name: str) -> str:
        """Register a stored or derived predicate for the export, and return its PDDL name.

        Raises:
            DomainError: the predicate is not declared.
        """
        derived = self.vocabulary.derived_by_name.get(name)
        if derived is not None and name not in self.derived:
            said = find_definition(derived)
            if said is None:
                self.without_formula[name] = derived
            else:
                self.derived[name] = said
        elif derived is None and self.vocabulary.find_stored_predicate(name) is None:
            raise DomainError(
                f"predicate {name} is not declared: declare it in the vocabulary, or correct the name"
            )
        return self.predicates[name]

    def add_types_of_objects(self, scene: Scene, objects_mask: int) -> None:
        """Register types for the objects in a bit mask: their categories and all wider categories."""
        for i in iterate_bits(objects_mask):
            for kind in self.vocabulary.list_kind_with_ancestors(scene.objects[i].category):
                self.types[kind]

    def register_category_predicate(self, category: str) -> str:
        """Register the static predicate that holds for the objects of a category; return its PDDL name."""
        return self.category_predicates.setdefault(category, self.predicates[f" is-{category}"])

    def register_execution_predicate(self, operator: str) -> str:
        """Return the predicate without arguments which states that the operator was executed."""
        return self.execution_predicates.setdefault(operator, self.predicates[f" done-{operator}"])

    def make_precedes_atom(self, first: f.Term, second: f.Term) -> f.Atom:
        """Return the atom which states that the first object has the lower index in the scene."""
        self.uses_object_order = True
        return f.Atom(self.predicates[f" {ORDER}"], (first, second))


class ConditionWriter:
    """Writes the conditions of one operator, axiom or goal in PDDL.

    Each bound variable gets a name of its own.

    Args:
        glossary: the PDDL names of the export; the names that conditions use are added to it.
        object_names: PDDL names of the objects that conditions may use; by default the names in ``glossary``.
        scene: the objects, to convert pairings of objects (`ForPairs`); None if no condition has a pairing.
    """

    def __init__(
        self,
        glossary: PddlExportNames,
        object_names: PddlNamesByOriginalName | None = None,
        scene: Scene | None = None,
    ) -> None:
        self.glossary = glossary
        self._object_names = glossary.objects if object_names is None else object_names
        self._variables = PddlNamesByOriginalName()
        self._count = 0
        self._scene = scene

    def map_parameters_to_pddl_variables(self, variables: Sequence[f.Variable]) -> dict[str, f.Variable]:
        """Return a mapping from the names of parameters to their PDDL variables, in order."""
        return {variable.name: f.Variable(self._variables[variable.name]) for variable in variables}

    def make_unused_variable(self, preferred_name: str, category: str | None = None) -> f.Variable:
        """Return a variable with the preferred name, or with this name and a number if the name is used."""
        name = preferred_name
        while name in self._variables:
            self._count += 1
            name = f"{preferred_name}{self._count}"
        return f.Variable(self._variables[name], None if category is None else self.glossary.types[category])

    def convert_term_to_pddl(self, term: f.Term, scope: TermScope) -> f.Term:
        """Return a variable or constant in PDDL.

        Raises:
            DomainError: the variable is not bound.
        """
        if isinstance(term, f.Constant):
            return f.Constant(self._object_names[term.name])
        if term.name not in scope:
            raise DomainError(f"variable {term.name} is not bound: make it a parameter, or quantify over it")
        return scope[term.name]

    def convert_formula_to_pddl(self, formula: f.Formula, scope: TermScope) -> f.Formula:
        """Return a state formula as a condition of PDDL.

        Raises:
            DomainError: the formula is not about one state, or uses an undeclared name.
        """
        match formula:
            case f.Atom(predicate, arguments):
                terms = tuple([self.convert_term_to_pddl(term, scope) for term in arguments])
                return f.Atom(self.glossary.register_predicate(predicate), terms)
            case f.Occurs(action):
                return f.Atom(self.glossary.register_execution_predicate(action), ())
            case f.Equals(left, right):
                return make_equality(
                    self.convert_term_to_pddl(left, scope), self.convert_term_to_pddl(right, scope)
                )
            case f.Not(operand):
                return negate(self.convert_formula_to_pddl(operand, scope))
            case f.And(operands):
                return conjoin([self.convert_formula_to_pddl(operand, scope) for operand in operands])
            case f.Or(operands):
                return disjoin([self.convert_formula_to_pddl(operand, scope) for operand in operands])
            case f.Implies(premise, conclusion):
                return disjoin(
                    [
                        negate(self.convert_formula_to_pddl(premise, scope)),
                        self.convert_formula_to_pddl(conclusion, scope),
                    ]
                )
            case f.Exists(f.Variable(name, str(category)), f.Equals(left, right)) if (
                f.Variable(name) in (left, right) and left != right
            ):
                other = right if left == f.Variable(name) else left
                return f.Atom(
                    self.glossary.register_category_predicate(category),
                    (self.convert_term_to_pddl(other, scope),),
                )
            case f.ForAll(variable, body) | f.Exists(variable, body):
                bound = self.make_unused_variable(variable.name, variable.category)
                inner = self.convert_formula_to_pddl(body, {**scope, variable.name: f.Variable(bound.name)})
                return type(formula)(bound, inner)
            case f.Exactly(count, variable, body):
                return self._convert_exact_count(count, variable, body, scope)
            case f.ForPairs():
                return self._convert_for_pairs_to_ordinary_quantifiers(formula, scope)
            case _:
                raise DomainError(
                    f"{type(formula).__name__} is not a condition on one state: write a formula without"
                    " temporal operators"
                )

    def _convert_exact_count(
        self, count: int, variable: f.Variable, body: f.Formula, scope: TermScope
    ) -> f.Formula:
        """Return the condition that exactly `count` different objects satisfy a body."""
        if self._scene is not None and count > self._scene.get_category_mask(variable.category).bit_count():
            return f.FALSE
        chosen = [self.make_unused_variable(variable.name, variable.category) for _ in range(count)]
        terms: list[f.Term] = [f.Variable(variable_of_term.name) for variable_of_term in chosen]
        met = [self.convert_formula_to_pddl(body, {**scope, variable.name: term}) for term in terms]
        other = self.make_unused_variable(variable.name, variable.category)
        rest = self.convert_formula_to_pddl(body, {**scope, variable.name: f.Variable(other.name)})
        among = [make_equality(f.Variable(other.name), term) for term in terms]
        only = f.ForAll(other, disjoin([negate(rest), *among]))
        return wrap_in_quantifiers(
            f.Exists, chosen, conjoin([*met, *_make_pairwise_difference_conditions(terms), only])
        )

    def _convert_for_pairs_to_ordinary_quantifiers(self, formula: f.ForPairs, scope: TermScope) -> f.Formula:
        """Return a `ForPairs` formula as a condition with ordinary quantifiers.

        The condition states that a number of pairs exist which satisfy the body of the formula. The two
        objects of a pair differ. No two pairs have the same first object, or the same second object. If the
        formula gives no number, each object of the smaller category is in a pair.
        """
        if self._scene is None:
            raise DomainError(
                "only goals can have a pairing of objects (ForPairs): use other quantifiers here"
            )
        first, second, body, count = formula.first, formula.second, formula.body, formula.count
        sizes = [self._scene.get_category_mask(each.category).bit_count() for each in (first, second)]
        if (min(sizes) if count is None else count) > min(sizes):
            return f.FALSE
        smaller, larger = (first, second) if sizes[0] <= sizes[1] else (second, first)
        named = self._scene.names_of_category(smaller.category)
        members: list[f.Term] = [f.Constant(self._object_names[name]) for name in named]
        chosen: list[f.Variable] = []
        if count is not None and count < len(members):
            chosen = [self.make_unused_variable(smaller.name, smaller.category) for _ in range(count)]
            members = [f.Variable(each.name) for each in chosen]
        partners = [self.make_unused_variable(larger.name, larger.category) for _ in members]
        terms: list[f.Term] = [f.Variable(each.name) for each in partners]
        parts: list[f.Formula] = [] if not chosen else list(_make_pairwise_difference_conditions(members))
        for one, other in zip(members, terms, strict=True):
            parts.append(negate(make_equality(one, other)))
            parts.append(self.convert_formula_to_pddl(body, {**scope, smaller.name: one, larger.name: other}))
        return wrap_in_quantifiers(
            f.Exists, [*chosen, *partners], conjoin([*parts, *_make_pairwise_difference_conditions(terms)])
        )


def _make_pairwise_difference_conditions(terms: Sequence[f.Term]) -> Iterator[f.Formula]:
    for index, one in enumerate(terms):
        for other in terms[:index]:
            yield negate(make_equality(one, other))


def find_predicates_forbidden_in_prompts(vocabulary: Vocabulary) -> frozenset[str]:
    """Return the predicates that prompts and answers must not mention.

    These are the invisible predicates (`Predicate.visible`), and the predicates derived from them.
    """
    invisible = {predicate.name for predicate in vocabulary.predicates if not predicate.visible}
    names = [*invisible, *vocabulary.derived_by_name]
    return frozenset(
        [name for name in names if invisible.intersection(find_stored_dependencies([name], vocabulary))]
    )


def remove_hidden_predicates(
    formula: f.Formula, hidden_predicates: frozenset[str], *, weaken: bool = True
) -> f.Formula:
    """Return a formula without the predicates that an export leaves out.

    With ``weaken``, literals with these predicates count as true, even negated literals: the result holds
    whenever the formula holds. Otherwise these literals count as false: the formula holds whenever the result
    holds.
    """
    if hidden_predicates.isdisjoint(find_predicates(formula)):
        return formula
    match formula:
        case f.Atom():
            return f.TRUE if weaken else f.FALSE
        case f.Not(operand):
            return negate(remove_hidden_predicates(operand, hidden_predicates, weaken=not weaken))
        case f.And(operands):
            return conjoin(
                [remove_hidden_predicates(operand, hidden_predicates, weaken=weaken) for operand in operands]
            )
        case f.Or(operands):
            return disjoin(
                [remove_hidden_predicates(operand, hidden_predicates, weaken=weaken) for operand in operands]
            )
        case f.Implies(premise, conclusion):
            return remove_hidden_predicates(
                f.Or((f.Not(premise), conclusion)), hidden_predicates, weaken=weaken
            )
        case f.Exists(variable, body) | f.ForAll(variable, body):
            inner = remove_hidden_predicates(body, hidden_predicates, weaken=weaken)
            return inner if inner == (f.TRUE if weaken else f.FALSE) else type(formula)(variable, inner)
        case _:
            return f.TRUE if weaken else f.FALSE
