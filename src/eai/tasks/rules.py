"""The rules of a domain as text for prompts: the exact conditions and effects of its actions."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import groupby

import eai.logic.formula as f
from eai.logic.ltl_printer import format_ltl
from eai.logic.traversal import find_predicates, map_subformulas
from eai.planning.effect_schema import find_predicates_changed_by_effects
from eai.world.condition import FormulaEvaluator
from eai.world.derived import DefinedPredicate, LookupPredicate, find_definition, find_stored_dependencies
from eai.world.domain import Domain
from eai.world.effect import Add, Delete, Effect, ForEach, Let, When
from eai.world.fault import FaultKind
from eai.world.operator import Operator, find_operator_conditions
from eai.world.vocabulary import DerivedPredicate

_INDENT = "  "
_EXPLANATIONS = (
    ("requires:", "An action is possible if all holds that it requires."),
    ("needed only if:", "One that is not needed is passed over."),
    ("becomes", "Its conditions are read before it is taken, its changes are made in the order in which they"
    " stand, and nothing else changes."),
    ("*", "* is any object."),
    ("for the first", "\"The first\" is meant in the order of the objects."),
    ("is_a(", "is_a(x, k) says that x is of kind k."),
    (" or ", "\"And\" binds more tightly than \"or\", and \"or\" than \"implies\"."),
)  # fmt: skip
"""Pairs: a sign that can occur in the text of rules, and a sentence that explains the sign."""
_BECOMES: Mapping[type[Effect], str] = {Add: "becomes true", Delete: "becomes false"}


@dataclass(frozen=True)
class DomainRulesInPrompts:
    """The rules of a domain as prompts state them: without hidden facts, which prompts never show.

    An operator has no rules for prompts if it can act in several ways, or if its conditions depend on a
    changeable hidden predicate. The same holds if its conditions need a derived predicate without a formula
    as definition. No question is about operators without rules.

    Attributes:
        domain: the declaration of the domain.
    """

    domain: Domain

    @cached_property
    def operators(self) -> tuple[Operator, ...]:
        """The operators whose rules prompts may state."""
        return tuple(
            [operator for operator in self.domain.operators if self._can_be_written_as_rule(operator)]
        )

    @cached_property
    def operator_names(self) -> frozenset[str]:
        """The names of the operators whose rules prompts may state."""
        return frozenset([operator.name for operator in self.operators])

    @cached_property
    def evaluator(self) -> FormulaEvaluator:
        """The evaluator of the domain's formulas in states."""
        return FormulaEvaluator(self.domain.vocabulary)

    @cached_property
    def changeable_hidden_predicates(self) -> frozenset[str]:
        """The names of the predicates that operators can change but prompts never show."""
        predicates = self.domain.vocabulary.predicates
        return frozenset([p.name for p in predicates if not p.visible and not p.static])

    @cached_property
    def changeable_visible_predicates(self) -> frozenset[str]:
        """The names of the predicates that operators can change and prompts show."""
        predicates = self.domain.vocabulary.predicates
        return frozenset([p.name for p in predicates if p.visible and not p.static])

    @cached_property
    def changed_predicates_by_operator(self) -> Mapping[str, frozenset[str]]:
        """Mapping from the name of each operator to the visible predicates that it changes."""
        return {
            operator.name: frozenset(find_predicates_changed_by_effects(operator.effects))
            - self.changeable_hidden_predicates
            for operator in self.operators
        }

    def find_used_predicates(
        self, operators: Collection[str], formulas: Iterable[f.Formula] = ()
    ) -> frozenset[str]:
        """Return the predicates that operators read or change, or that formulas need.

        A derived predicate is replaced by the predicates in its definition.
        """
        decisive = find_stored_dependencies(find_predicates(*formulas), self.domain.vocabulary)
        return frozenset(decisive).union(*(self._used_predicates_by_operator[name] for name in operators))

    @cached_property
    def _used_predicates_by_operator(self) -> Mapping[str, frozenset[str]]:
        vocabulary = self.domain.vocabulary
        return {
            name: self.changed_predicates_by_operator[name].union(find_stored_dependencies(read, vocabulary))
            for name, read in self._condition_predicates_by_operator.items()
        }

    def write_rules(self, operators: Collection[str], formulas: Iterable[f.Formula] = ()) -> str:
        """Return the rules of some operators, and the definitions of the derived predicates in these rules.

        Derived predicates in the given formulas are defined, too.
        """
        shown = [operator for operator in self.operators if operator.name in operators]
        named = list(
            dict.fromkeys(
                [
                    *find_predicates(*formulas),
                    *(n for operator in shown for n in self._condition_predicates_by_operator[operator.name]),
                ]
            )
        )
        lines = [
            *(self._rule_text_by_operator[operator.name] for operator in shown),
            *(
                self._definition_text_by_predicate[name]
                for name in self._find_derived_predicates_used_by(named)
            ),
        ]
        return "\n".join(lines)

    def write_operator_rule(self, operator: Operator) -> str | None:
        """Return an operator's conditions and effects as text; None if prompts must not state its rules."""
        if operator.name not in self.operator_names:
            return None
        lines = [write_operator_title(operator)]
        for heading, of_needless in (("requires", False), ("needed only if", True)):
            checks = [c for c in operator.checks if (c.fault is FaultKind.ADDITIONAL_STEP) is of_needless]
            conditions = dict.fromkeys([_write_formula(check.condition) for check in checks])
            lines += [f"{_INDENT}{heading}: {'; '.join(conditions)}"] if conditions else []
        return "\n".join([*lines, *self._write_effect_lines(operator)])

    def write_predicate_definitions(self) -> list[str]:
        """Return the definitions of derived predicates as text.

        A definition is left out if it depends on hidden facts: facts that prompts never show, although
        actions can change them.
        """
        return [
            text
            for name, text in self._definition_text_by_predicate.items()
            if not self._does_any_depend_on_hidden_predicates([name])
        ]

    def write_operator_signatures(self, operators: Collection[str]) -> str:
        """Return the first lines of some operators' rules, which give only the names and parameters."""
        return "\n".join(
            [_write_operator_signature(operator) for operator in self.operators if operator.name in operators]
        )

    @cached_property
    def _rule_text_by_operator(self) -> Mapping[str, str]:
        return {operator.name: self._write_operator(operator) for operator in self.operators}

    @cached_property
    def _condition_predicates_by_operator(self) -> Mapping[str, Sequence[str]]:
        """Mapping from the name of each operator to the predicates in its conditions."""
        return {
            operator.name: find_predicates(*find_operator_conditions(operator)) for operator in self.operators
        }

    def _can_be_written_as_rule(self, operator: Operator) -> bool:
        vocabulary = self.domain.vocabulary
        read = find_predicates(*find_operator_conditions(operator))
        derived = [vocabulary.derived_by_name[name] for name in self._find_derived_predicates_used_by(read)]
        undefined = any(find_definition(predicate) is None for predicate in derived)
        return not (operator.alternatives or undefined or self._does_any_depend_on_hidden_predicates(read))

    def _does_any_depend_on_hidden_predicates(self, names: Iterable[str]) -> bool:
        return not self.changeable_hidden_predicates.isdisjoint(
            find_stored_dependencies(names, self.domain.vocabulary)
        )

    def _find_derived_predicates_used_by(self, names: Iterable[str]) -> list[str]:
        """Return the derived predicates among some names, and those in their definitions, each once."""
        derived_names: dict[str, None] = {}
        pending = list(names)
        while pending:
            name = pending.pop(0)
            derived = self.domain.vocabulary.derived_by_name.get(name)
            if derived is None or name in derived_names:
                continue
            derived_names[name] = None
            defined = find_definition(derived)
            pending += [] if defined is None else find_predicates(defined.definition)
        return list(derived_names)

    def _write_operator(self, operator: Operator) -> str:
        lines = [write_operator_title(operator)]
        names = {parameter.name: parameter.name for parameter in operator.parameters}
        for number, check in enumerate(operator.checks, 1):
            lines.append(
                f"{_INDENT}requirement {number}: {_write_formula(check.condition)}"
                f'   [otherwise "{check.reason.format_map(names)}"]'
            )
        return "\n".join([*lines, *self._write_effect_lines(operator)])

    def _write_effect_lines(self, operator: Operator) -> list[str]:
        return [*self._write_effects(operator.effects, _INDENT)] or [f"{_INDENT}changes nothing"]

    def _write_effects(self, effects: Sequence[Effect], indent: str) -> Iterator[str]:
        """Yield lines of text that describe effects, in order.

        Successive additions of facts share one line, and so do successive deletions of facts.
        """
        for kind, run in groupby(effects, type):
            if kind in (Add, Delete):
                atoms = [atom_effect.atom for atom_effect in run if isinstance(atom_effect, Add | Delete)]
                shown = [
                    _write_formula(atom)
                    for atom in atoms
                    if atom.predicate not in self.changeable_hidden_predicates
                ]
                yield from [f"{indent}{_BECOMES[kind]}: {', '.join(shown)}"] if shown else []
                continue
            for effect in run:
                yield from self._write_compound_effect(effect, indent)

    def _write_compound_effect(self, effect: Effect, indent: str) -> Iterator[str]:
        match effect:
            case When(condition, effects, otherwise):
                yield from self._write_effect_block(f"if {_write_formula(condition)}", effects, indent)
                yield from self._write_effect_block(
                    f"if {_write_formula(f.Not(condition))}", otherwise, indent
                )
            case ForEach(variable, condition, effects):
                yield from self._write_effect_block(
                    f"for each {variable.name} with {_write_formula(condition)}", effects, indent
                )
            case Let(variable, condition, effects):
                first = f"for the first {variable.name} with {_write_formula(condition)}"
                yield from self._write_effect_block(first, effects, indent)

    def _write_effect_block(self, heading: str, effects: Sequence[Effect], indent: str) -> Iterator[str]:
        """Yield a heading and the lines on the visible effects below it; nothing if no effect is visible."""
        lines = list(self._write_effects(effects, indent + _INDENT))
        yield from [f"{indent}{heading}:", *lines] if lines else []

    @cached_property
    def _definition_text_by_predicate(self) -> Mapping[str, str]:
        """Mapping from each derived predicate that a formula defines to the text of its definition."""
        meanings = [(predicate, find_definition(predicate)) for predicate in self.domain.vocabulary.derived]
        return {
            predicate.name: _write_definition_of_derived_predicate(predicate, defined)
            for predicate, defined in meanings
            if defined is not None
        }


def explain_rule_notation(rules: str) -> str:
    """Return explanations of the symbols that occur in the text of some rules."""
    return " ".join([words for sign, words in _EXPLANATIONS if sign in rules])


def _write_operator_signature(operator: Operator) -> str:
    return f"{operator.name}({', '.join([p.name for p in operator.parameters])})"


def write_operator_title(operator: Operator) -> str:
    """Return the first line of an operator's rule: its name, its parameters and a short description."""
    head = _write_operator_signature(operator)
    return f"{head}: {operator.description}" if operator.description else head


def _write_definition_of_derived_predicate(derived: DerivedPredicate, defined: DefinedPredicate) -> str:
    remark = derived.open_in_meaning if isinstance(derived, LookupPredicate) else ""
    head = f"{derived.name}({', '.join([p.name for p in defined.parameters])}) means: "
    return f"{head}{_write_formula(defined.definition)}{f' ({remark})' if remark else ''}"


def _write_formula(formula: f.Formula) -> str:
    """Return a formula as text. Trivial parts are left out, and ``is_a(x, lamp)`` states that x is a lamp."""
    return format_ltl(_simplify_formula(formula))


def _simplify_formula(formula: f.Formula) -> f.Formula:
    match formula:
        case f.Exists(f.Variable(name, category), f.Equals(left, right)) if category is not None:
            other = right if left.name == name else left
            return f.Atom("is_a", (other, f.Constant(category)))
        case f.And(parts) if f.TRUE in parts:
            return _simplify_formula(f.And(tuple([part for part in parts if part != f.TRUE])))
        case f.Not(f.Not(operand)):
            return _simplify_formula(operand)
        case _:
            return map_subformulas(formula, _simplify_formula)
